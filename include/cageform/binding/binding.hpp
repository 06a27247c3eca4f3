// The artefact between bind time and run time: a figure's points, expressed by the handles of a cage.
#pragma once

#include <cageform/core/blocks.hpp>

#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// What `clone` reads; owns nothing, so it may point into a `Binding` or into memory of the caller.
template <Scalar T, std::size_t D>
struct BindingView {
    using scalar = T;
    static constexpr std::size_t dimension = D;

    BlockView<const T> weights;              ///< rows are handles
    BlockView<const T> rest;                 ///< rows are axes: where the points were bound
    const Vec<T, D>* rest_handles = nullptr; ///< #handles: where the handles were then

    std::size_t handle_count() const noexcept { return weights.rows; }
    std::size_t point_count() const noexcept { return weights.points; }
};

/// A bound figure: for every point its place at rest and a weight per handle. Made by `bind`.
///
/// A pose moves a point by the weighted sum of its handles' displacements, so the unmoved pose returns the
/// bound points bit for bit, and what the weights lack of reproducing the point at rest is kept:
///
///     p' = p + Σ w_i (C'_i − C_i) = Σ w_i C'_i + (p − Σ w_i C_i)
///
/// Memory: (#handles + D) scalars a point, in blocks of one cache line (core/blocks.hpp).
template <Scalar T, std::size_t D>
class Binding {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    Binding() = default;
    Binding(const Binding&) = default;
    Binding& operator=(const Binding&) = default;
    /// What is moved from is empty.
    Binding(Binding&& other) noexcept { *this = std::move(other); }
    Binding& operator=(Binding&& other) noexcept {
        weights_ = std::exchange(other.weights_, {});
        rest_ = std::exchange(other.rest_, {});
        rest_handles_ = std::exchange(other.rest_handles_, {});
        point_count_ = std::exchange(other.point_count_, 0);
        return *this;
    }
    ~Binding() = default;
    Binding(std::vector<Lanes<T>> weights, std::vector<Lanes<T>> rest, std::vector<Vec<T, D>> rest_handles,
            std::size_t point_count) noexcept
        : weights_(std::move(weights))
        , rest_(std::move(rest))
        , rest_handles_(std::move(rest_handles))
        , point_count_(point_count) {
        CAGEFORM_ASSERT(weights_.size() == block_count<T>(point_count_) * rest_handles_.size(),
                        "one row per handle");
        CAGEFORM_ASSERT(rest_.size() == block_count<T>(point_count_) * D, "one row per axis");
    }

    /// Gives the memory of weights and rest points away, to be filled anew; the binding is then empty.
    struct Memory {
        std::vector<Lanes<T>> weights, rest;
    };
    Memory release() && noexcept {
        Binding emptied = std::move(*this);
        return {std::move(emptied.weights_), std::move(emptied.rest_)};
    }

    std::size_t handle_count() const noexcept { return rest_handles_.size(); }
    std::size_t point_count() const noexcept { return point_count_; }
    const Vec<T, D>& rest_handle(std::size_t handle) const noexcept { return rest_handles_[handle]; }

    T weight(std::size_t point, std::size_t handle) const noexcept { return view().weights(point, handle); }
    Vec<T, D> rest_point(std::size_t point) const noexcept { return block_point<D>(view().rest, point); }

    BindingView<T, D> view() const noexcept {
        return {{weights_.data(), handle_count(), point_count_},
                {rest_.data(), D, point_count_},
                rest_handles_.data()};
    }

private:
    std::vector<Lanes<T>> weights_;
    std::vector<Lanes<T>> rest_;
    std::vector<Vec<T, D>> rest_handles_;
    std::size_t point_count_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI

// A binding: the weights of a figure's points for the handles of a cage. Made at bind time, used at run time.
#pragma once

#include <cageform/core/types/blocks.hpp>
#include <cageform/core/types/handles.hpp>

#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// The input of `clone`: a non-owning view of a Binding or of the caller's memory.
template <Scalar T, std::size_t D>
struct BindingView {
    using scalar = T;
    static constexpr std::size_t dimension = D;

    BlockView<const T> weights;               ///< rows are handles
    BlockView<const T> rest;                  ///< rows are axes: the points at rest
    const Vec<T, D>* rest_handles = nullptr;  ///< #handles: the handles at rest
    const HandleKind* handle_kinds = nullptr; ///< #handles; null if all are points
    /// #vectors: the faces of the vectors, in order; null if the vectors have no faces.
    const HandleFace<D>* handle_faces = nullptr;
    const std::uint32_t* handle_loops = nullptr; ///< HandleView::loops; null if there are none

    std::size_t handle_count() const noexcept { return weights.rows; }
    std::size_t point_count() const noexcept { return weights.points; }
    HandleView<T, D> handle_view() const noexcept {
        return {rest_handles, weights.rows, handle_kinds, handle_faces, handle_loops};
    }
};

/// A bound figure: for every point its position at rest and a weight per handle. Made by `bind`.
///
/// A pose moves a point by the weighted sum of its handles' displacements. The pose at rest therefore
/// returns the bound points bit for bit, and the residual of the weights at rest is preserved:
///
///     p' = p + Σ w_i (C'_i − C_i) = Σ w_i C'_i + (p − Σ w_i C_i)
///
/// Memory: (#handles + D) scalars per point, in blocks of one cache line (core/types/blocks.hpp).
template <Scalar T, std::size_t D>
class Binding {
public:
    using scalar = T;
    static constexpr std::size_t dimension = D;

    Binding() = default;
    Binding(const Binding&) = default;
    Binding& operator=(const Binding&) = default;
    /// A moved-from binding is empty.
    Binding(Binding&& other) noexcept { *this = std::move(other); }
    Binding& operator=(Binding&& other) noexcept {
        weights_ = std::exchange(other.weights_, {});
        rest_ = std::exchange(other.rest_, {});
        rest_handles_ = std::exchange(other.rest_handles_, {});
        handle_kinds_ = std::exchange(other.handle_kinds_, {});
        handle_faces_ = std::exchange(other.handle_faces_, {});
        handle_loops_ = std::exchange(other.handle_loops_, {});
        point_count_ = std::exchange(other.point_count_, 0);
        return *this;
    }
    ~Binding() = default;
    /// Copies the handles; may throw std::bad_alloc.
    Binding(std::vector<Lanes<T>> weights, std::vector<Lanes<T>> rest, const HandleView<T, D>& handles,
            std::size_t point_count)
        : weights_(std::move(weights))
        , rest_(std::move(rest))
        , rest_handles_(handles.rest, handles.rest + handles.count)
        , point_count_(point_count) {
        if (handles.kinds != nullptr) handle_kinds_.assign(handles.kinds, handles.kinds + handles.count);
        if (handles.faces != nullptr)
            handle_faces_.assign(handles.faces, handles.faces + handles.vector_count());
        handle_loops_.assign(handles.loops, handles.loops + handles.loop_numbers());
        CAGEFORM_ASSERT(weights_.size() == block_count<T>(point_count_) * rest_handles_.size(),
                        "one row per handle");
        CAGEFORM_ASSERT(rest_.size() == block_count<T>(point_count_) * D, "one row per axis");
    }

    /// Moves out the memory of weights and rest points for reuse; the binding is then empty.
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
                rest_handles_.data(),
                handle_kinds_.empty() ? nullptr : handle_kinds_.data(),
                handle_faces_.empty() ? nullptr : handle_faces_.data(),
                handle_loops_.empty() ? nullptr : handle_loops_.data()};
    }
    HandleView<T, D> handle_view() const noexcept { return view().handle_view(); }

private:
    std::vector<Lanes<T>> weights_;
    std::vector<Lanes<T>> rest_;
    std::vector<Vec<T, D>> rest_handles_;
    std::vector<HandleKind> handle_kinds_;    // empty: all are points
    std::vector<HandleFace<D>> handle_faces_; // empty: the vectors belong to no faces
    std::vector<std::uint32_t> handle_loops_; // empty: no corner of a face is a mean of a loop
    std::size_t point_count_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI

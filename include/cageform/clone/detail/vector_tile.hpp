// Moves bound vectors with a pose, a few blocks at a time.
#pragma once

#include <cageform/clone/detail/block_cloner.hpp>

#include <array>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A block of bound vectors, one row per axis, moved and at rest.
template <Scalar T, std::size_t D>
struct VectorBlock {
    std::array<const Lanes<T>*, D> moved;
    std::array<const Lanes<T>*, D> rest;

    /// Returns the vector of one lane.
    static Vec<T, D> at(const std::array<const Lanes<T>*, D>& rows, std::size_t lane) noexcept {
        Vec<T, D> v{};
        for (std::size_t k = 0; k < D; ++k) v[k] = (*rows[k])[lane];
        return v;
    }
};

/// The moved vectors of a few blocks, in the order of the binding.
template <Scalar T, std::size_t D, std::size_t Blocks = 32>
class VectorTile {
public:
    static constexpr std::size_t blocks = Blocks;

    template <class View, class Pose>
    void load(View view, const Pose& pose, std::size_t begin, std::size_t end) noexcept {
        if constexpr (requires { view.order; }) view.order = nullptr;
        // The view starts where point 0 would be stored if it were in the tile.
        StridedPoints<T, D> tile(moved_[0][0].v - begin * lane_count<T>, view.point_count(), sizeof(T),
                                 sizeof(moved_[0]));
        auto&& source = as_strided<const T, D>(pose);
        BlockCloner(view, source, tile, {}).run(begin, end);
        rest_ = PackedBindingView<T, D>(view).rest;
        first_ = begin;
    }

    VectorBlock<T, D> block(std::size_t b) const noexcept {
        VectorBlock<T, D> rows;
        for (std::size_t k = 0; k < D; ++k) {
            rows.moved[k] = moved_[k] + (b - first_);
            rows.rest[k] = rest_ + b * D + k;
        }
        return rows;
    }
    /// Returns an axis of a block's moved vectors, for writing.
    Lanes<T>& moved(std::size_t b, std::size_t axis) noexcept { return moved_[axis][b - first_]; }

private:
    const Lanes<T>* rest_ = nullptr;
    std::size_t first_ = 0; ///< block
    Lanes<T> moved_[D][blocks];
};

template <class B, std::size_t K>
auto views_of(const std::array<B, K>& bindings) noexcept {
    std::array<decltype(view_of(bindings[0])), K> views;
    for (std::size_t k = 0; k < K; ++k) views[k] = view_of(bindings[k]);
    return views;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

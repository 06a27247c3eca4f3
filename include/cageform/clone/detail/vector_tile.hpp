// Bound vectors as a pose moves them, a few blocks at a time.
#pragma once

#include <cageform/clone/detail/block_cloner.hpp>

#include <array>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A block of bound vectors, a row an axis: as a pose moves them, and as they are at rest.
template <Scalar T, std::size_t D>
struct VectorBlock {
    std::array<const Lanes<T>*, D> moved;
    std::array<const Lanes<T>*, D> rest;

    /// The vectors of one lane.
    static Vec<T, D> at(const std::array<const Lanes<T>*, D>& rows, std::size_t lane) noexcept {
        Vec<T, D> v{};
        for (std::size_t k = 0; k < D; ++k) v[k] = (*rows[k])[lane];
        return v;
    }
};

/// The vectors of a few blocks, cloned into memory of its own, in the order of their places.
template <Scalar T, std::size_t D>
class VectorTile {
public:
    static constexpr std::size_t blocks = 32;

    template <class View, class Pose>
    void load(View view, const Pose& pose, std::size_t begin, std::size_t end) noexcept {
        if constexpr (requires { view.order; }) view.order = nullptr;
        // An axis after the other, from where point 0 would be, were it in the tile.
        StridedPoints<T, D> tile(moved_[0][0].v - begin * lane_count<T>, view.point_count(), sizeof(T),
                                 sizeof(moved_[0]));
        BlockCloner(view, pose, tile, {}).run(begin, end);
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

private:
    const Lanes<T>* rest_ = nullptr;
    std::size_t first_ = 0; ///< block
    Lanes<T> moved_[D][blocks];
};

/// The views of bindings of the same points to the same handles.
template <class B, std::size_t K>
auto views_of(const std::array<B, K>& bindings) noexcept {
    std::array<decltype(view_of(bindings[0])), K> views;
    for (std::size_t k = 0; k < K; ++k) {
        views[k] = view_of(bindings[k]);
        CAGEFORM_ASSERT(views[k].point_count() == views[0].point_count() &&
                            views[k].handle_count() == views[0].handle_count(),
                        "bindings of the same points");
    }
    return views;
}

/// Whether the points of two views lie at the same places.
template <class View>
bool same_order(const View& a, const View& b) noexcept {
    const PackedBindingView<typename View::scalar, View::dimension> of_a(a), of_b(b);
    if (of_a.order == of_b.order) return true;
    if (of_a.order == nullptr || of_b.order == nullptr) return false;
    for (std::size_t i = 0; i < of_a.points; ++i) {
        if (of_a.order[i] != of_b.order[i]) return false;
    }
    return true;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

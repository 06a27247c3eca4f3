// Sorts points spatially, so that the points of a block are near each other.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/core/types/blocks.hpp>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the index of the point at each position of an order in which nearby points share a block.
/// Recursively halves the points along the longest side of their bounds, at a multiple of the block
/// size. O(n log n).
template <Scalar T, std::size_t D>
std::vector<std::uint32_t> spatial_order(const BlockView<const T>& points) {
    auto order = first_indices<std::uint32_t>(points.points);
    const auto coordinate = [&points](std::uint32_t i, std::size_t axis) {
        const T x = points(i, axis);
        return is_finite(x) ? x : T(0); // the position of such a point is arbitrary
    };
    std::vector<std::array<std::size_t, 2>> ranges{{0, order.size()}};
    while (!ranges.empty()) {
        const auto [begin, end] = ranges.back();
        ranges.pop_back();
        const std::size_t blocks = block_count<T>(end - begin);
        if (blocks <= 1) continue;
        Vec<T, D> low{}, high{};
        for (std::size_t n = begin; n < end; ++n) {
            for (std::size_t k = 0; k < D; ++k) {
                const T x = coordinate(order[n], k);
                low[k] = n == begin ? x : (std::min)(low[k], x);
                high[k] = n == begin ? x : (std::max)(high[k], x);
            }
        }
        std::size_t axis = 0;
        for (std::size_t k = 1; k < D; ++k) {
            if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
        }
        const std::size_t middle = begin + blocks / 2 * lane_count<T>;
        const auto at = [&order](std::size_t n) { return order.begin() + std::ptrdiff_t(n); };
        std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
            const T x = coordinate(a, axis), y = coordinate(b, axis);
            return x != y ? x < y : a < b;
        });
        ranges.push_back({begin, middle});
        ranges.push_back({middle, end});
    }
    return order;
}

/// Compares points by position: negative, zero or positive. Points that are not finite come last.
///
///   at  at(point, axis)
template <std::size_t D, class At>
int compare_positions(const At& at, std::size_t a, std::size_t b) {
    for (std::size_t k = 0; k < D; ++k) {
        const auto x = at(a, k), y = at(b, k);
        if (is_finite(x) != is_finite(y)) return is_finite(x) ? -1 : 1;
        if (is_finite(x) && x != y) return x < y ? -1 : 1;
    }
    return 0;
}

/// Returns which points lie on a seam: they have the position of a point of another block. Their
/// weights must not depend on the rest of the block. O(n log n).
///
///   less  less(a, b): a strict weak order, in which points with equal positions are equivalent
template <Scalar T, class Less>
std::vector<char> seam_points(std::span<const std::uint32_t> order, const Less& less) {
    const auto lanes = std::uint32_t(lane_count<T>);
    std::vector<std::uint32_t> position(order.size()), sorted(order.begin(), order.end());
    for (std::uint32_t n = 0; n < order.size(); ++n) position[order[n]] = n;
    std::sort(sorted.begin(), sorted.end(), less);
    std::vector<char> on_seam(order.size(), 0);
    for (std::size_t begin = 0, end = 0; begin < sorted.size(); begin = end) {
        bool one_block = true;
        for (end = begin + 1; end < sorted.size() && !less(sorted[begin], sorted[end]); ++end)
            one_block = one_block && position[sorted[end]] / lanes == position[sorted[begin]] / lanes;
        for (std::size_t n = begin; n < end && !one_block; ++n) on_seam[sorted[n]] = 1;
    }
    return on_seam;
}

/// Returns whether an order contains each of `count` points once.
inline bool is_permutation(const std::vector<std::uint32_t>& order, std::size_t count) {
    std::vector<char> there(count, 0);
    for (const std::uint32_t i : order) {
        if (i >= count || there[i] != 0) return false;
        there[i] = 1;
    }
    return order.size() == count;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

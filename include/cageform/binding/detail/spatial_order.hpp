// Sorts points spatially, so that the points of a block are close to each other.
#pragma once

#include <cageform/core/detail/blocks.hpp>

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns an order in which points that are close to each other share a block: the index of the
/// point at each position. The points are halved along the longest side of their bounds, at a
/// multiple of a block, recursively. O(n log n).
template <Scalar T, std::size_t D>
std::vector<std::uint32_t> spatial_order(const BlockView<const T>& points) {
    std::vector<std::uint32_t> order(points.points);
    std::iota(order.begin(), order.end(), 0u);
    const auto coordinate = [&points](std::uint32_t i, std::size_t axis) {
        const T x = points(i, axis);
        return is_finite(x) ? x : T(0); // such a point is kept, its position does not matter
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

/// Returns whether an order names each of `count` points once.
inline bool is_permutation(const std::vector<std::uint32_t>& order, std::size_t count) {
    std::vector<char> there(count, 0);
    for (const std::uint32_t i : order) {
        if (i >= count || there[i] != 0) return false;
        there[i] = 1;
    }
    return order.size() == count;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

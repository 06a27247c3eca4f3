// The side of a polygon's loop on which the inside lies.
#pragma once

#include <cageform/cage/detail/primitives.hpp>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T>
class Polygon; // in cage/polygon.hpp

namespace detail {

/// Counts the other loops that enclose loop `k`. The number is even for an outer loop and odd for a hole.
/// Loops must not touch.
template <Scalar T>
std::size_t loop_depth(const Polygon<T>& polygon, std::size_t k) noexcept {
    const auto q = vec_cast<double>(polygon[polygon.loops()[k].begin]);
    std::size_t depth = 0;
    for (std::size_t other = 0; other < polygon.loops().size(); ++other) {
        if (other == k) continue;
        bool inside = false;
        polygon.loops()[other].for_each_edge([&](std::size_t i, std::size_t j) {
            const auto a = vec_cast<double>(polygon[i]), b = vec_cast<double>(polygon[j]);
            if (crosses_ray(q, a, b)) inside = !inside;
        });
        depth += inside;
    }
    return depth;
}

/// Whether the inside of the polygon is to the left of the edges of loop `k`. This holds for a
/// counter-clockwise outer loop and for a clockwise hole. Loops must not touch. O(#V).
template <Scalar T>
bool inside_is_left(const Polygon<T>& polygon, std::size_t k) noexcept {
    return (signed_area(polygon, polygon.loops()[k]) > 0) == (loop_depth(polygon, k) % 2 == 0);
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI

// Segments and triangles, the facets of all cages, and the rules that decide what is inside.
#pragma once

#include <cageform/cage/detail/indices.hpp>
#include <cageform/cage/detail/orientation.hpp>
#include <cageform/cage/types/facet.hpp>
#include <cageform/core/types/buffer.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// For each axis of 3D space, the other two in order.
inline constexpr std::array<std::array<std::size_t, 2>, 3> other_axes{{{1, 2}, {0, 2}, {0, 1}}};

template <std::size_t D>
double length(const Vec<double, D>& v) noexcept {
    return std::sqrt(dot(v, v));
}

// ---- which side is inside -----------------------------------------------------------------------

/// The even-odd rule in 2D: a point is inside if the ray from it to the right crosses an odd number of
/// edges. An edge includes its lower end but not its upper one, so a ray through a vertex counts correctly.
inline bool crosses_ray(const Vec<double, 2>& q, const Vec<double, 2>& a, const Vec<double, 2>& b) noexcept {
    return (a[1] > q[1]) != (b[1] > q[1]) && (cross(b - a, q - a) > 0) == (b[1] > a[1]);
}

/// The even-odd rule in 3D: a point is inside if the winding number rounds to an odd integer.
inline bool is_enclosed(double winding_number) noexcept {
    return std::fmod(std::fabs(std::round(winding_number)), 2.0) == 1;
}

// ---- facets: edges in 2D, triangles in 3D -------------------------------------------------------

/// Returns the point of segment ab nearest to `p`.
template <std::size_t D>
Vec<double, D> nearest_on_segment(const Vec<double, D>& p, const Vec<double, D>& a,
                                  const Vec<double, D>& b) noexcept {
    return a + segment_parameter(p, a, b) * (b - a);
}
template <std::size_t D>
double distance_to_segment(const Vec<double, D>& p, const Vec<double, D>& a,
                           const Vec<double, D>& b) noexcept {
    return length(nearest_on_segment(p, a, b) - p);
}

/// Returns the distance between two segments; in 2D it is exactly 0 if they meet.
template <std::size_t D>
double segment_distance(const Vec<double, D>& a, const Vec<double, D>& b, const Vec<double, D>& c,
                        const Vec<double, D>& d) noexcept {
    const double least = (std::min)({distance_to_segment(c, a, b), distance_to_segment(d, a, b),
                                     distance_to_segment(a, c, d), distance_to_segment(b, c, d)});
    if constexpr (D == 2) {
        return segments_touch(a, b, c, d) ? 0.0 : least;
    } else {
        // Interior points can be closer than the ends only if the common perpendicular meets both segments.
        const auto e = b - a, f = d - c, g = a - c;
        const double ee = dot(e, e), ff = dot(f, f), ef = dot(e, f), determinant = ee * ff - ef * ef;
        if (!(determinant > 0)) return least;
        const double s = (ef * dot(f, g) - ff * dot(e, g)) / determinant;
        const double t = (ee * dot(f, g) - ef * dot(e, g)) / determinant;
        if (s < 0 || s > 1 || t < 0 || t > 1) return least;
        return (std::min)(least, length(a + s * e - (c + t * f)));
    }
}

template <std::size_t D>
Vec<double, D> point_on_facet(const std::array<double, D>& weights, const Corners<D>& corner) noexcept {
    Vec<double, D> x{};
    for (std::size_t k = 0; k < D; ++k) x = x + weights[k] * corner[k];
    return x;
}
template <std::size_t D>
double distance_to_facet(const Vec<double, D>& p, const Corners<D>& corner) noexcept {
    return length(point_on_facet(nearest_on_facet(p, corner), corner) - p);
}

/// Returns the normal of a triangle with twice its area as length.
inline Vec<double, 3> area_normal(const Corners<3>& corner) noexcept {
    return cross(corner[1] - corner[0], corner[2] - corner[0]);
}

/// Whether the corners of a triangle are collinear within `tolerance`.
inline bool is_flat(const Corners<3>& corner, double tolerance) noexcept {
    const auto& [a, b, c] = corner;
    const double longest = (std::max)({length(b - a), length(c - b), length(a - c)});
    return !(length(area_normal(corner)) > tolerance * longest);
}

/// Returns the offset from the first point to the point farthest from it.
template <Scalar T>
Vec<double, 2> farthest_offset(std::span<const Vec<T, 2>> points) noexcept {
    Vec<double, 2> farthest{};
    for (const auto& p : points) {
        const auto d = vec_cast<double>(p) - vec_cast<double>(points[0]);
        if (dot(d, d) > dot(farthest, farthest)) farthest = d;
    }
    return farthest;
}
/// Whether all points lie within `tolerance` of the line through the first point and the one farthest from
/// it.
template <Scalar T>
bool are_collinear(std::span<const Vec<T, 2>> points, double tolerance) noexcept {
    const auto axis = farthest_offset(points);
    return std::all_of(points.begin(), points.end(), [&](const auto& p) {
        return std::fabs(cross(axis, vec_cast<double>(p) - vec_cast<double>(points[0]))) <=
               tolerance * length(axis);
    });
}

/// Returns half the solid angle of a triangle seen from `q`, positive if it is clockwise seen from `q` (van
/// Oosterom & Strackee 1983).
inline double half_solid_angle(const Vec<double, 3>& q, const Corners<3>& corner) noexcept {
    const auto a = corner[0] - q, b = corner[1] - q, c = corner[2] - q;
    const double x = length(a), y = length(b), z = length(c);
    return std::atan2(dot(a, cross(b, c)), x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y);
}

/// Whether a line through `s` and `t`, not in the triangle's plane, meets the triangle or its boundary.
/// Exact: a line cannot pass between triangles that share an edge.
inline bool line_meets(const Vec<double, 3>& s, const Vec<double, 3>& t, const Corners<3>& corner) noexcept {
    const auto& [a, b, c] = corner;
    const int first = orientation(s, t, a, b), second = orientation(s, t, b, c);
    if (first * second < 0) return false;
    const int third = orientation(s, t, c, a);
    return first * third >= 0 && second * third >= 0;
}
/// Whether the segment from `s` to `t`, ends included, meets a triangle. The segment must not lie in the
/// triangle's plane. Exact.
inline bool pierces(const Vec<double, 3>& s, const Vec<double, 3>& t, const Corners<3>& corner) noexcept {
    const auto& [a, b, c] = corner;
    const int from = orientation(a, b, c, s), to = orientation(a, b, c, t);
    return from * to <= 0 && from != to && line_meets(s, t, corner);
}

/// Returns the distance between the segment from `a` to `b` and a facet.
template <std::size_t D>
double segment_to_facet(const Vec<double, D>& a, const Vec<double, D>& b, const Corners<D>& corner) noexcept {
    if constexpr (D == 2) {
        return segment_distance(a, b, corner[0], corner[1]);
    } else {
        if (pierces(a, b, corner)) return 0;
        double least = (std::min)(distance_to_facet(a, corner), distance_to_facet(b, corner));
        for (std::size_t k = 0; k < 3; ++k)
            least = (std::min)(least, segment_distance(a, b, corner[k], corner[(k + 1) % 3]));
        return least;
    }
}

/// Whether two edges come within `tolerance` of each other, except at a common vertex.
inline bool facets_touch(const Facet<2>& a, const Facet<2>& b, double tolerance) noexcept {
    for (std::size_t k = 0; k < 2; ++k) {
        for (std::size_t l = 0; l < 2; ++l) {
            if (a.vertex[k] != b.vertex[l]) continue;
            if (a.vertex[1 - k] == b.vertex[1 - l]) return true; // the same edge twice
            // Neighbours must not fold back onto each other.
            const auto u = a.corner[1 - k] - a.corner[k], v = b.corner[1 - l] - b.corner[l];
            return dot(u, v) > 0 &&
                   std::fabs(cross(u, v)) <= tolerance * std::sqrt((std::max)(dot(u, u), dot(v, v)));
        }
    }
    return segment_distance(a.corner[0], a.corner[1], b.corner[0], b.corner[1]) <= tolerance;
}
/// Whether two triangles meet anywhere except in their common vertices.
inline bool facets_touch(const Facet<3>& a, const Facet<3>& b, double tolerance) noexcept {
    const auto shared =
        std::count_if(a.vertex.begin(), a.vertex.end(), [&](std::uint32_t i) { return b.has(i); });
    if (shared == 3) return true;
    // An edge without a shared end may intersect or come near the other triangle. An edge with a shared end
    // cannot, unless it lies in the plane of the other triangle.
    const auto comes_near = [&](const Facet<3>& f, const Facet<3>& g) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t l = (k + 1) % 3;
            if (g.has(f.vertex[k])) continue;
            if (!g.has(f.vertex[l]) && segment_to_facet(f.corner[k], f.corner[l], g.corner) <= tolerance)
                return true;
            // Triangles that share an edge must not fold flat onto each other.
            if (shared == 2 && distance_to_facet(f.corner[k], g.corner) <= tolerance) return true;
        }
        return false;
    };
    return comes_near(a, b) || comes_near(b, a);
}

/// Returns the axis along which boxes are shortest on average, relative to the standard deviation of their
/// centres. A few outliers change this deviation little, unlike the range of the centres.
template <std::size_t D>
std::size_t sweep_axis(const Buffer<Bounds<double, D>>& boxes) noexcept {
    std::size_t axis = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < D; ++k) {
        double lengths = 0, mean = 0, variance = 0; // Welford 1962
        double count = 0;
        for (const auto& box : boxes) {
            lengths += box.upper[k] - box.lower[k];
            const double middle = 0.5 * box.lower[k] + 0.5 * box.upper[k], off = middle - mean;
            mean += off / ++count;
            variance += off * (middle - mean);
        }
        const double ratio = lengths / std::sqrt(variance);
        if (!(ratio < least)) continue;
        least = ratio;
        axis = k;
    }
    return axis;
}

/// Calls f(m, n), m < n, for all pairs of overlapping boxes, by a sweep along one axis. Usually O(n log n),
/// O(n²) at worst.
template <std::size_t D, class F>
void for_each_overlap(const Buffer<Bounds<double, D>>& boxes, F&& f) {
    const std::size_t axis = sweep_axis(boxes);
    auto order = first_indices<std::size_t>(boxes.size());
    std::sort(order.begin(), order.end(),
              [&](std::size_t m, std::size_t n) { return boxes[m].lower[axis] < boxes[n].lower[axis]; });
    Buffer<Bounds<double, D>> sorted; // contiguous for the sweep
    sorted.reserve(boxes.size());
    for (const std::size_t m : order) sorted.push_back(boxes[m]);
    for (std::size_t m = 0; m < sorted.size(); ++m) {
        const double end = sorted[m].upper[axis];
        for (std::size_t n = m + 1; n < sorted.size() && sorted[n].lower[axis] <= end; ++n) {
            if (sorted[m].overlaps(sorted[n]))
                f((std::min)(order[m], order[n]), (std::max)(order[m], order[n]));
        }
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail

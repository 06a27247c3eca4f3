// Facets of cages: edges in 2D, triangles in 3D.
#pragma once

#include <cageform/core/types/bounds.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

template <std::size_t D>
using Corners = std::array<Vec<double, D>, D>;

/// Returns the parameter of the point of segment ab nearest to `p`: 0 at a, 1 at b; 0 if a equals b.
template <std::size_t D>
double segment_parameter(const Vec<double, D>& p, const Vec<double, D>& a, const Vec<double, D>& b) noexcept {
    const auto e = b - a;
    const double length2 = dot(e, e);
    return length2 > 0 ? std::fmin(std::fmax(dot(p - a, e) / length2, 0.0), 1.0) : 0.0;
}

} // namespace detail

/// A facet of a cage: an edge in 2D, a triangle in 3D.
template <std::size_t D>
struct Facet {
    std::array<std::uint32_t, D> vertex; ///< indices
    detail::Corners<D> corner;

    template <Scalar T>
    Facet(const std::array<std::uint32_t, D>& of, std::span<const Vec<T, D>> vertices) noexcept
        : vertex(of) {
        for (std::size_t k = 0; k < D; ++k) corner[k] = vec_cast<double>(vertices[of[k]]);
    }
    bool has(std::uint32_t i) const noexcept {
        bool found = false; // branch-free, because it is called for all pairs of a fan
        for (const std::uint32_t v : vertex) found |= v == i;
        return found;
    }
    Bounds<double, D> bounds() const noexcept { return bounds_of(std::span<const Vec<double, D>>(corner)); }
};

/// Returns the point of an edge nearest to `p`, as barycentric weights.
inline std::array<double, 2> nearest_on_facet(const Vec<double, 2>& p,
                                              const detail::Corners<2>& edge) noexcept {
    const double s = detail::segment_parameter(p, edge[0], edge[1]);
    return {1 - s, s};
}
/// Returns the point of a triangle nearest to `p`, as barycentric weights (Ericson, Real-Time Collision
/// Detection (2005), sec. 5.1.5: the regions of vertices, edges and the face).
inline std::array<double, 3> nearest_on_facet(const Vec<double, 3>& p,
                                              const detail::Corners<3>& triangle) noexcept {
    const auto& [a, b, c] = triangle;
    const auto n = cross(b - a, c - a);
    const double area2 = dot(n, n);
    if (area2 > 0) {
        const double u = dot(cross(c - b, p - b), n) / area2, v = dot(cross(a - c, p - c), n) / area2;
        if (u >= 0 && v >= 0 && u + v <= 1) return {u, v, 1 - (u + v)};
    }
    std::array<double, 3> best{1, 0, 0};
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t l = (k + 1) % 3;
        const double s = detail::segment_parameter(p, triangle[k], triangle[l]);
        const auto d = triangle[k] + s * (triangle[l] - triangle[k]) - p;
        if (dot(d, d) >= least) continue;
        least = dot(d, d);
        best = {0, 0, 0};
        best[k] = 1 - s;
        best[l] = s;
    }
    return best;
}

} // namespace cageform::inline CAGEFORM_ABI

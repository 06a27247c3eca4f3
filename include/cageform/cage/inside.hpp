// Where a point lies with respect to a polygon, and the boundary point nearest to it.
#pragma once

#include <cageform/cage/boundary_value.hpp>
#include <cageform/cage/polygon.hpp>
#include <cageform/core/status.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A place on the boundary of a polygon: (1 − s) vertex[i] + s vertex[j].
template <Scalar T>
struct BoundaryPoint {
    std::size_t i = 0;
    std::size_t j = 0;
    T s = 0;            ///< in [0, 1]
    T distance = 0;     ///< from the point asked for
    Vec<T, 2> position; ///< of the place itself
};

/// The place of edge (i, j) nearest to `p`; interpolated from the nearer end, so that both ends are met
/// exactly. `p` must be finite.
template <Scalar T>
BoundaryPoint<T> nearest_on_edge(const Polygon<T>& polygon, std::size_t i, std::size_t j,
                                 const Vec<T, 2>& p) noexcept {
    const auto a = vec_cast<double>(polygon[i]);
    const auto b = vec_cast<double>(polygon[j]);
    const auto q = vec_cast<double>(p);
    const auto e = b - a;
    const double length2 = dot(e, e);
    const double from_a = length2 > 0 ? dot(q - a, e) / length2 : 0;
    const double from_b = length2 > 0 ? dot(b - q, e) / length2 : 1;
    const double s = from_a <= 0.5 ? std::fmax(from_a, 0.0) : std::fmin(1 - from_b, 1.0);
    const auto x = s <= 0.5 ? a + s * e : b - std::fmax(from_b, 0.0) * e;
    return {i, j, static_cast<T>(s), static_cast<T>(std::hypot(x[0] - q[0], x[1] - q[1])), vec_cast<T>(x)};
}

/// The nearest place on the whole boundary. `p` must be finite and the polygon not empty. O(#V).
template <Scalar T>
BoundaryPoint<T> nearest_on_boundary(const Polygon<T>& polygon, const Vec<T, 2>& p) noexcept {
    BoundaryPoint<T> best;
    polygon.for_each_edge([&](std::size_t i, std::size_t j) {
        const auto candidate = nearest_on_edge(polygon, i, j, p);
        const bool first = best.i == best.j; // taken as it is: so far out all distances may be infinite
        if (first || candidate.distance < best.distance) best = candidate;
    });
    return best;
}

/// The boundary data at the boundary place nearest to a finite point, and that place: linear along the edges.
template <Scalar T>
BoundaryValue<2> nearest_boundary_value(const Polygon<T>& polygon, const Vec<T, 2>& p,
                                        Vec<T, 2>& place) noexcept {
    const auto q = nearest_on_boundary(polygon, p);
    place = q.position;
    return {{std::uint32_t(q.i), std::uint32_t(q.j)}, {1 - double(q.s), double(q.s)}};
}

/// Inside by the even-odd rule; on the boundary when within `tolerance` of it (the cage's
/// coincidence_tolerance); not_finite for a NaN or infinite point. O(#V).
///
/// Crossings of the ray to the right are decided by the side of each edge the point is on. That side can
/// only be wrong nearer to the edge than the tolerance, where the answer is on_boundary in any case.
template <Scalar T>
PointState locate(const Polygon<T>& polygon, const Vec<T, 2>& p, T tolerance) noexcept {
    if (!is_finite(p)) return PointState::not_finite;
    bool inside = false;
    bool touches = false;
    const auto q = vec_cast<double>(p);
    polygon.for_each_edge([&](std::size_t i, std::size_t j) {
        const auto a = vec_cast<double>(polygon[i]);
        const auto b = vec_cast<double>(polygon[j]);
        const auto e = b - a;
        const double side = cross(e, q - a);
        const double reach = tolerance * (std::fabs(e[0]) + std::fabs(e[1]));
        if (std::fabs(side) <= reach && nearest_on_edge(polygon, i, j, p).distance <= tolerance)
            touches = true;
        if ((a[1] > q[1]) != (b[1] > q[1]) && (side > 0) == (b[1] > a[1])) inside = !inside;
    });
    if (touches) return PointState::on_boundary;
    return inside ? PointState::inside : PointState::outside;
}

} // namespace cageform::inline CAGEFORM_ABI

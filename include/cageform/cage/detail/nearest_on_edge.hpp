// The point of a polygon's edge nearest to a point.
#pragma once

#include <cageform/core/vec.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T>
class Polygon; // in cage/polygon.hpp
template <Scalar T>
struct BoundaryPoint; // in cage/polygon.hpp

namespace detail {

/// Returns the point of edge (i, j) nearest to `p`. Interpolates from the nearer end, so both ends are
/// exact. `p` must be finite.
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

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI

// The vectors that faces of a cage are handles by: normals, of the length of the edge
// in the plane and the root of the area in space.
#pragma once

#include <cageform/core/vec.hpp>

#include <array>
#include <cmath>

namespace cageform::inline CAGEFORM_ABI {

/// The edge from `a` to `b` turned by −90°: the outward normal where the inside is on the left.
/// Linear in the pose.
template <Scalar T>
Vec<T, 2> edge_handle(const Vec<T, 2>& a, const Vec<T, 2>& b) noexcept {
    return {b[1] - a[1], a[0] - b[0]};
}

namespace detail {

/// Two edges of a triangle, divided by their largest component `size`, so that no square overflows.
template <Scalar T>
struct TriangleEdges {
    Vec<T, 3> u, v;
    T size = 0;

    explicit TriangleEdges(const std::array<Vec<T, 3>, 3>& corners) noexcept
        : u(corners[1] - corners[0])
        , v(corners[2] - corners[0]) {
        for (std::size_t k = 0; k < 3; ++k)
            size = std::fmax(size, std::fmax(std::fabs(u[k]), std::fabs(v[k])));
        if (!(size > 0)) return;
        for (std::size_t k = 0; k < 3; ++k) {
            u[k] /= size;
            v[k] /= size;
        }
    }
    /// Whether `normal`, cross(u, v), is more than rounding.
    bool has_area(const Vec<T, 3>& normal) const noexcept {
        constexpr T rounding = 4 * epsilon<T>; // of the sine of the angle between u and v
        return dot(normal, normal) > rounding * rounding * dot(u, u) * dot(v, v);
    }
};

} // namespace detail

/// √area · s · n' of a triangle: the unit normal n' of its posed corners, and how much the pose
/// lengthens it,
///
///     s = √(|U|²|v|² − 2 (U·V)(u·v) + |V|²|u|²) / (√8 area),   u, v two edges at rest, U, V the
///     same edges posed
///
/// so that a similarity takes the handle along. With `posed` = `rest` the handle at rest. Zero
/// where a triangle has no area. Finite where coordinates are below epsilon times the largest
/// number. Lipman, Levin, Cohen-Or: Green Coordinates (ACM Trans. Graph. 27, 2008), sec. 3.2.
template <Scalar T>
Vec<T, 3> face_handle(const std::array<Vec<T, 3>, 3>& rest, const std::array<Vec<T, 3>, 3>& posed) noexcept {
    const detail::TriangleEdges<T> before(rest), now(posed);
    const auto normal_before = cross(before.u, before.v), normal = cross(now.u, now.v);
    if (!before.has_area(normal_before) || !now.has_area(normal)) return {};
    const T squares = dot(now.u, now.u) * dot(before.v, before.v) -
                      2 * dot(now.u, now.v) * dot(before.u, before.v) +
                      dot(now.v, now.v) * dot(before.u, before.u);
    const T twice_area = std::sqrt(dot(normal_before, normal_before));
    return (now.size / 2 * std::sqrt(squares / (twice_area * dot(normal, normal)))) * normal;
}

} // namespace cageform::inline CAGEFORM_ABI

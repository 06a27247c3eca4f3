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

/// Two edges of a triangle, each divided by its largest component, so that no square overflows or
/// vanishes.
template <Scalar T>
struct TriangleEdges {
    std::array<Vec<T, 3>, 2> edge;
    std::array<T, 2> size{}; ///< what they were divided by
    Vec<T, 3> normal;        ///< of the divided edges

    explicit TriangleEdges(const std::array<Vec<T, 3>, 3>& corners) noexcept
        : edge{corners[1] - corners[0], corners[2] - corners[0]} {
        for (std::size_t n = 0; n < 2; ++n) {
            for (std::size_t k = 0; k < 3; ++k) size[n] = std::fmax(size[n], std::fabs(edge[n][k]));
            for (std::size_t k = 0; k < 3 && size[n] > 0; ++k) edge[n][k] /= size[n];
        }
        normal = cross(edge[0], edge[1]);
    }
    /// Whether `normal` is more than rounding.
    bool has_area() const noexcept {
        constexpr T rounding = 4 * epsilon<T>; // of the sine of the angle between them
        return dot(normal, normal) > rounding * rounding * dot(edge[0], edge[0]) * dot(edge[1], edge[1]);
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
/// number and the sides at rest differ by less than 1/epsilon. Lipman, Levin, Cohen-Or: Green
/// Coordinates (ACM Trans. Graph. 27, 2008), sec. 3.2.
template <Scalar T>
Vec<T, 3> face_handle(const std::array<Vec<T, 3>, 3>& rest, const std::array<Vec<T, 3>, 3>& posed) noexcept {
    const detail::TriangleEdges<T> before(rest), now(posed);
    if (!before.has_area() || !now.has_area()) return {};
    // s as a sum of squares, which is positive for thin triangles too: with u the longer edge,
    // v = c u + a part of length q |u| across it, s² area = (q |U|² + |V − c U|² / q) / 4.
    const std::size_t a = before.size[0] < before.size[1] ? 1 : 0, b = 1 - a;
    const Vec<T, 3>&u = before.edge[a], &v = before.edge[b];
    const T share = before.size[b] / before.size[a] / dot(u, u);
    const T q = share * std::sqrt(dot(before.normal, before.normal)), c = share * dot(u, v);
    if (!(q > 0)) return {};
    const T size = std::fmax(now.size[0], now.size[1]);
    const Vec<T, 3> along = (now.size[a] / size) * now.edge[a];
    const Vec<T, 3> across = (now.size[b] / size) * now.edge[b] - c * along;
    const T squares = q * dot(along, along) + dot(across, across) / q;
    return (size / 2 * std::sqrt(squares / dot(now.normal, now.normal))) * now.normal;
}

} // namespace cageform::inline CAGEFORM_ABI

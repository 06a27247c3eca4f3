// The vector handle of a face: its normal, scaled to the edge's length in 2D and to the square root of
// the area in 3D.
#pragma once

#include <cageform/core/types/handles.hpp>
#include <cageform/core/vec.hpp>
#include <cageform/core/view.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the edge from `a` to `b` rotated by −90°: the outward normal if the inside is on the left.
/// Linear in the pose.
template <Scalar T>
Vec<T, 2> edge_handle(const Vec<T, 2>& a, const Vec<T, 2>& b) noexcept {
    return {b[1] - a[1], a[0] - b[0]};
}

/// Two edges of a triangle, each divided by its largest component, so that squares neither overflow
/// nor underflow.
template <Scalar T>
struct TriangleEdges {
    std::array<Vec<T, 3>, 2> edge;
    std::array<T, 2> size{}; ///< the divisors
    Vec<T, 3> normal;        ///< of the divided edges

    explicit TriangleEdges(const std::array<Vec<T, 3>, 3>& corners) noexcept
        : edge{corners[1] - corners[0], corners[2] - corners[0]} {
        for (std::size_t n = 0; n < 2; ++n) {
            for (std::size_t k = 0; k < 3; ++k) size[n] = std::fmax(size[n], std::fabs(edge[n][k]));
            for (std::size_t k = 0; k < 3 && size[n] > 0; ++k) edge[n][k] /= size[n];
        }
        normal = cross(edge[0], edge[1]);
    }
    /// Whether `normal` exceeds rounding errors.
    bool has_area() const noexcept {
        constexpr T rounding = 4 * epsilon<T>; // relative to the sine of the edges' angle
        return dot(normal, normal) > rounding * rounding * dot(edge[0], edge[0]) * dot(edge[1], edge[1]);
    }
};

/// Returns √area · s · n' for a triangle: the unit normal n' of its posed corners, scaled by how
/// much the pose stretches the triangle,
///
///     s = √(|U|²|v|² − 2 (U·V)(u·v) + |V|²|u|²) / (√8 area),   u, v two edges at rest, U, V the
///     same edges posed
///
/// A similarity therefore transforms the handle in the same way as the triangle. With `posed` = `rest`
/// this is the handle at rest. The result is zero if a triangle has no area. It is finite if coordinates are
/// below epsilon times the largest number and the ratio of two sides at rest is below 1/epsilon.
/// Lipman, Levin, Cohen-Or: Green Coordinates (ACM Trans. Graph. 27, 2008), sec. 3.2.
template <Scalar T>
Vec<T, 3> face_handle(const std::array<Vec<T, 3>, 3>& rest, const std::array<Vec<T, 3>, 3>& posed) noexcept {
    const TriangleEdges<T> before(rest), now(posed);
    if (!before.has_area() || !now.has_area()) return {};
    // Writes s as a sum of squares, which is accurate for thin triangles. With u the longer edge and v
    // = c u + a component of length q |u| orthogonal to u, s² area = (q |U|² + |V − c U|² / q) / 4.
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

/// Returns the mean of a loop of `count` points, where at(i) is vertex i. Faces at rest and posed faces
/// both use this function, so equal points give means that are equal bit for bit.
template <class At>
auto mean_of_loop(const std::uint32_t* loop, std::size_t count, const At& at) noexcept {
    auto sum = at(loop[0]);
    using T = std::remove_cvref_t<decltype(sum[0])>;
    for (std::size_t k = 1; k < count; ++k) sum = sum + at(loop[k]);
    return (T(1) / T(count)) * sum;
}

/// Returns whether a point is finite and small enough for finite posed vectors. The limit is that of the
/// narrower of two scalars: the binding's and the output's.
template <Scalar T, class Out, std::size_t D>
bool can_be_posed(const Vec<T, D>& p) noexcept {
    using Narrow = std::conditional_t<std::is_same_v<T, float> || std::is_same_v<range_scalar_t<Out>, float>,
                                      float, double>;
    constexpr T limit = T((std::numeric_limits<Narrow>::max)() * epsilon<Narrow>);
    if (!is_finite(p)) return false;
    for (std::size_t k = 0; k < D; ++k) {
        if (p[k] > limit || p[k] < -limit) return false;
    }
    return true;
}

/// Returns a corner of a face: at(i) for handle i, or the mean of a loop of handles.
template <Scalar T, std::size_t D, class At>
Vec<T, D> corner_of_face(const HandleView<T, D>& handles, std::uint32_t corner, const At& at) noexcept {
    if (corner < handles.count) return at(corner);
    const std::uint32_t* const begin = handles.loops + (corner - handles.count);
    return mean_of_loop(handles.loops + begin[0], begin[1] - begin[0], at);
}

/// Returns the vector of a face whose posed corners are in `out`. If no corner has moved, it is the
/// vector at rest, bit for bit.
template <Scalar T, std::size_t D, class Out>
Vec<T, D> posed_vector(const HandleView<T, D>& handles, std::size_t handle, const HandleFace<D>& face,
                       const Out& out) noexcept {
    std::array<Vec<T, D>, D> rest, posed;
    for (std::size_t k = 0; k < D; ++k) {
        rest[k] = corner_of_face(handles, face[k], [&](std::uint32_t i) { return handles.rest[i]; });
        posed[k] = corner_of_face(handles, face[k], [&](std::uint32_t i) { return to_vec<T>(out[i]); });
    }
    if (posed == rest) return handles.rest[handle];
    if constexpr (D == 2) {
        return edge_handle(posed[0], posed[1]);
    } else {
        return face_handle(rest, posed);
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail

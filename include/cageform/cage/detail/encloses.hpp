// Whether a closed triangle mesh encloses a point.
#pragma once

#include <cageform/cage/detail/box_tree.hpp>
#include <cageform/cage/detail/mesh_face.hpp>
#include <cageform/cage/detail/primitives.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Projects a, b and p along the third axis, and returns the side of the line ab on which p lies: 1 left, −1
/// right. A point on the line counts as shifted infinitesimally along the first axis, and far less along the
/// second. Returns 0 if a and b coincide in the projection.
inline int side_seen_from_above(const Vec<double, 3>& a, const Vec<double, 3>& b,
                                const Vec<double, 3>& p) noexcept {
    const int side = orientation({a[0], a[1]}, {b[0], b[1]}, {p[0], p[1]});
    if (side != 0) return side;
    if (a[1] != b[1]) return a[1] > b[1] ? 1 : -1;
    return b[0] > a[0] ? 1 : b[0] < a[0] ? -1 : 0;
}

/// Whether a closed mesh encloses a point, by the even-odd rule for a ray along the third axis. The point
/// must not be on a face. Degenerate intersections are resolved by an infinitesimal shift of the ray. Exact.
/// Usually O(log #F).
///   boxes  the hierarchy of the faces
template <Scalar T>
bool encloses(const BoxTree<3>& boxes, std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces,
              const Vec<double, 3>& p) {
    if (boxes.is_empty()) return false;
    bool inside = false;
    const Vec<double, 3> end{p[0], p[1], (std::max)(p[2], boxes.bounds().upper[2])};
    (void)boxes.any_on_segment(p, end, [&](std::uint32_t f) {
        const auto [a, b, c] = Facet<3>(faces[f], vertices).corner;
        const int side = side_seen_from_above(a, b, p);
        if (side == 0 || side_seen_from_above(b, c, p) != side || side_seen_from_above(c, a, p) != side)
            return false;
        if (side * orientation(a, b, c, p) < 0) inside = !inside;
        return false;
    });
    return inside;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

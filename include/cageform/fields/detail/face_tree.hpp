// Tests whether a segment meets a triangle mesh.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The faces of a mesh in a bounding volume hierarchy. Built in O(n log n); a query usually takes O(log n).
class FaceTree {
public:
    /// All coordinates must be finite; vertices and faces must outlive the tree.
    FaceTree(std::span<const Vec<double, 3>> vertices, std::span<const MeshFace> faces)
        : vertices_(vertices)
        , faces_(faces)
        , boxes_(faces.size(), [&](std::uint32_t f) { return Facet<3>(faces[f], vertices).bounds(); }) {}

    /// Whether the segment from a vertex to another point meets the mesh only at its ends. Exact.
    bool is_free(std::uint32_t vertex, const Vec<double, 3>& q) const {
        const auto& p = vertices_[vertex];
        return !boxes_.any_on_segment(p, q, [&](std::uint32_t f) {
            const Facet<3> facet(faces_[f], vertices_);
            return facet.has(vertex) ? runs_along(facet, vertex, q) : blocks(facet.corner, p, q);
        });
    }

    /// Whether a closed mesh encloses a point that is not on a face. Exact.
    bool encloses(const Vec<double, 3>& p) const { return detail::encloses(boxes_, vertices_, faces_, p); }

private:
    /// Whether a face meets the open segment from p to q.
    static bool blocks(const Corners<3>& corner, const Vec<double, 3>& p, const Vec<double, 3>& q) noexcept {
        const auto& [a, b, c] = corner;
        const int from = orientation(a, b, c, p), to = orientation(a, b, c, q);
        if (from != 0 || to != 0) return from * to < 0 && line_meets(p, q, corner);
        const auto [d, e, f] = flattened(corner, corner);
        const auto [s, t, unused] = flattened(corner, {p, q, q});
        const int side = orientation(d, e, f);
        return segments_touch(s, t, d, e) || segments_touch(s, t, e, f) || segments_touch(s, t, f, d) ||
               (orientation(d, e, s) == side && orientation(e, f, s) == side && orientation(f, d, s) == side);
    }
    /// Whether the segment from a vertex of a face to q begins along the face.
    static bool runs_along(const Facet<3>& facet, std::uint32_t vertex, const Vec<double, 3>& q) noexcept {
        const auto& [a, b, c] = facet.corner;
        if (orientation(a, b, c, q) != 0) return false;
        const std::size_t k = facet.vertex[0] == vertex ? 0 : facet.vertex[1] == vertex ? 1 : 2;
        const auto corner = flattened(facet.corner, facet.corner);
        const auto &p = corner[k], &d = corner[(k + 1) % 3], &e = corner[(k + 2) % 3];
        const auto to = flattened(facet.corner, {q, q, q})[0];
        const int side = orientation(p, d, e);
        return side * orientation(p, d, to) >= 0 && side * orientation(p, to, e) >= 0;
    }
    /// Projects points of a face's plane to 2D, along an axis that is not parallel to the plane.
    static std::array<Vec<double, 2>, 3> flattened(const Corners<3>& face,
                                                   const Corners<3>& positions) noexcept {
        const auto along = [](std::size_t axis, const Vec<double, 3>& p) {
            return Vec<double, 2>{p[(axis + 1) % 3], p[(axis + 2) % 3]};
        };
        std::size_t axis = 0;
        while (axis < 2 && orientation(along(axis, face[0]), along(axis, face[1]), along(axis, face[2])) == 0)
            ++axis;
        return {along(axis, positions[0]), along(axis, positions[1]), along(axis, positions[2])};
    }

    std::span<const Vec<double, 3>> vertices_;
    std::span<const MeshFace> faces_;
    BoxTree<3> boxes_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

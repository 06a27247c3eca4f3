// A tree of the triangles of a mesh, for tests whether a segment meets one and whether the mesh
// encloses a point.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>

#include <numeric>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A bounding volume hierarchy: boxes are halved along their longest side at the median of the
/// faces' centres. Built in O(n log n); a query usually takes O(log n).
class FaceTree {
public:
    /// Builds the tree. All coordinates must be finite; vertices and faces must outlive the tree.
    FaceTree(std::span<const Vec<double, 3>> vertices, std::span<const MeshFace> faces)
        : vertices_(vertices)
        , faces_(faces)
        , order_(faces.size()) {
        std::iota(order_.begin(), order_.end(), std::uint32_t{0});
        boxes_.reserve(faces.size());
        for (const auto& face : faces) boxes_.push_back(Facet<3>(face, vertices).bounds());
        if (!faces.empty()) build(0, std::uint32_t(faces.size()));
    }

    /// Whether the segment from a vertex to another point meets the mesh at most at its ends.
    /// Exact.
    bool is_free(std::uint32_t vertex, const Vec<double, 3>& q) const {
        const auto& p = vertices_[vertex];
        return !any_near(p, q, [&](std::uint32_t f) {
            const Facet<3> facet(faces_[f], vertices_);
            return facet.has(vertex) ? runs_along(facet, vertex, q) : blocks(facet.corner, p, q);
        });
    }

    /// Whether a closed mesh encloses a point that lies on no face, by the even-odd rule: a ray
    /// along the third axis crosses an odd number of faces. Degenerate contacts are resolved by
    /// moving the ray infinitesimally. Exact.
    bool encloses(const Vec<double, 3>& p) const {
        if (nodes_.empty()) return false;
        bool inside = false;
        const Vec<double, 3> end{p[0], p[1], (std::max)(p[2], nodes_[0].box.upper[2])};
        any_near(p, end, [&](std::uint32_t f) {
            const auto [a, b, c] = Facet<3>(faces_[f], vertices_).corner;
            const int side = side_of(a, b, p);
            if (side == 0 || side_of(b, c, p) != side || side_of(c, a, p) != side) return false;
            if (side * orientation(a, b, c, p) < 0) inside = !inside;
            return false;
        });
        return inside;
    }

private:
    static constexpr std::uint32_t leaf = 4; ///< most faces of a leaf

    struct Node {
        Bounds<double, 3> box;
        std::uint32_t begin, end; ///< of faces in `order_`
        std::uint32_t second;     ///< the second child; the first is the next node. 0 for a leaf
    };

    std::uint32_t build(std::uint32_t begin, std::uint32_t end) {
        Bounds<double, 3> box = boxes_[order_[begin]];
        for (std::uint32_t n = begin + 1; n < end; ++n) {
            const auto& more = boxes_[order_[n]];
            for (std::size_t k = 0; k < 3; ++k) {
                box.lower[k] = (std::min)(box.lower[k], more.lower[k]);
                box.upper[k] = (std::max)(box.upper[k], more.upper[k]);
            }
        }
        const auto number = std::uint32_t(nodes_.size());
        nodes_.push_back({box, begin, end, 0});
        if (end - begin <= leaf) return number;
        const auto extent = box.upper - box.lower;
        const std::size_t axis = extent[0] >= extent[1] && extent[0] >= extent[2] ? 0
                                 : extent[1] >= extent[2]                         ? 1
                                                                                  : 2;
        const std::uint32_t middle = begin + (end - begin) / 2;
        const auto twice = [&](std::uint32_t f) { return boxes_[f].lower[axis] + boxes_[f].upper[axis]; };
        std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                         [&](std::uint32_t f, std::uint32_t g) {
                             return twice(f) != twice(g) ? twice(f) < twice(g) : f < g;
                         });
        build(begin, middle);
        const std::uint32_t second = build(middle, end);
        nodes_[number].second = second;
        return number;
    }

    /// Returns the side of the line from a to b, seen along the third axis, on which p lies after
    /// an infinitesimal shift along the first axis and a far smaller one along the second; 0 if a
    /// and b coincide.
    static int side_of(const Vec<double, 3>& a, const Vec<double, 3>& b, const Vec<double, 3>& p) noexcept {
        const int side = orientation({a[0], a[1]}, {b[0], b[1]}, {p[0], p[1]});
        if (side != 0) return side;
        if (a[1] != b[1]) return a[1] > b[1] ? 1 : -1;
        return b[0] > a[0] ? 1 : b[0] < a[0] ? -1 : 0;
    }

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
    /// Whether the segment from a vertex of a face to q starts out along the face.
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
    /// Projects points of a face's plane to 2D, along an axis not parallel to the plane.
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

    /// A segment, prepared for tests against many boxes.
    struct Sight {
        Vec<double, 3> from, lower, upper, inverse; ///< inverse: 0 along axes that the segment hardly
                                                    ///< moves along

        Sight(const Vec<double, 3>& p, const Vec<double, 3>& q) noexcept
            : from(p) {
            constexpr double least = 1e-290; // keeps the inverse finite
            for (std::size_t k = 0; k < 3; ++k) {
                lower[k] = (std::min)(p[k], q[k]);
                upper[k] = (std::max)(p[k], q[k]);
                inverse[k] = upper[k] - lower[k] > least ? 1 / (q[k] - p[k]) : 0;
            }
        }
        /// Whether the segment may meet a box. Never false if it does.
        bool may_meet(const Bounds<double, 3>& box) const noexcept {
            constexpr double slack = 1e-9; // in segment lengths, far above rounding
            double first = -slack, last = 1 + slack;
            for (std::size_t k = 0; k < 3; ++k) {
                if (box.upper[k] < lower[k] || box.lower[k] > upper[k]) return false;
                if (inverse[k] == 0) continue;
                const double s = (box.lower[k] - from[k]) * inverse[k],
                             t = (box.upper[k] - from[k]) * inverse[k];
                first = (std::max)(first, (std::min)(s, t) - slack);
                last = (std::min)(last, (std::max)(s, t) + slack);
            }
            return first <= last;
        }
    };

    /// Whether f(face) holds for one of the faces whose boxes the segment may meet.
    template <class F>
    bool any_near(const Vec<double, 3>& p, const Vec<double, 3>& q, const F& f) const {
        const Sight sight(p, q);
        std::array<std::uint32_t, 64> waiting{}; // pending subtrees; the tree has at most 32 levels
        std::size_t count = nodes_.empty() ? 0 : 1;
        while (count > 0) {
            const std::uint32_t number = waiting[--count];
            const Node& node = nodes_[number];
            if (!sight.may_meet(node.box)) continue;
            if (node.second != 0) {
                waiting[count++] = node.second;
                waiting[count++] = number + 1;
                continue;
            }
            for (std::uint32_t n = node.begin; n < node.end; ++n) {
                if (f(order_[n])) return true;
            }
        }
        return false;
    }

    std::span<const Vec<double, 3>> vertices_;
    std::span<const MeshFace> faces_;
    std::vector<std::uint32_t> order_;
    std::vector<Bounds<double, 3>> boxes_; // of every face
    std::vector<Node> nodes_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

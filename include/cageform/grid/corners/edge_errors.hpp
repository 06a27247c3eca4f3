// Estimates the error near the edges of a mesh and of its interior faces. In a plane perpendicular to an
// edge the solution behaves as near a 2D corner (grid/corners/corner.hpp).
#pragma once

#include <cageform/cage/cell_complex.hpp>
#include <cageform/cage/detail/gaps.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/corners/corner_errors.hpp>
#include <cageform/grid/lattice/embed.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// Two neighbouring faces at an edge and the wedge between them. Lengths are in cells.
struct EdgeSector {
    using Point = Vec<double, 3>;

    struct AdjacentFace {
        Point across;    ///< unit vector in the face, perpendicular to the edge
        double distance; ///< from the edge's line to the face's third vertex
        double along;    ///< from the edge's first vertex to the foot of the perpendicular from the third

        AdjacentFace(const Point& origin, const Point& direction, const Point& third) noexcept
            : along(dot(third - origin, direction)) {
            const auto d = third - origin - along * direction;
            distance = std::sqrt(dot(d, d));
            across = (1 / distance) * d;
        }
    };

    std::array<std::size_t, 4> handles; ///< the ends of the edge, then the third vertices of the faces
    Point origin, direction;            ///< the line of the edge
    double length;
    AdjacentFace first, second;
    grid::Corner corner; ///< the corner in a perpendicular plane, from the first face to the second

    /// Returns the components of a vector in the frame of `corner`.
    Vec<double, 2> across(const Point& d) const noexcept {
        return {dot(d, first.across), dot(d, cross(direction, first.across))};
    }
    /// Returns the derivative of the data of each handle across the edge, in a face.
    std::array<double, 4> slopes(const AdjacentFace& face, std::size_t third) const noexcept {
        std::array<double, 4> slope{};
        slope[third] = 1 / face.distance;
        slope[1] = -face.along / (length * face.distance);
        slope[0] = -slope[third] - slope[1];
        return slope;
    }
    /// Returns the coefficient of w in the data of each handle, per cell.
    std::array<double, 4> coefficients_of_w() const noexcept {
        const auto here = slopes(first, 2);
        auto coefficient = slopes(second, 3);
        for (std::size_t k = 0; k < 4; ++k) coefficient[k] -= here[k] * corner.cosine();
        return coefficient;
    }
    double slope_of_w() const noexcept {
        double largest = 0;
        for (const double coefficient : coefficients_of_w())
            largest = (std::max)(largest, std::fabs(coefficient));
        return largest;
    }
    /// Returns the weight of each handle in the extended data at a point.
    std::array<double, 4> shares(const Point& p) const noexcept {
        const auto d = p - origin;
        const auto xy = across(d);
        const double z = dot(d, direction) / length, x = corner.along(xy), w = corner.functions(xy)[0];
        const auto slope = slopes(first, 2), of_w = coefficients_of_w();
        std::array<double, 4> share{1 - z, z, 0, 0};
        for (std::size_t k = 0; k < 4; ++k) share[k] += slope[k] * x + of_w[k] * w;
        return share;
    }

    /// Calls f(point) for at most 16 points along the edge, at least three cells apart.
    template <class F>
    void for_each_position_along(F&& f) const {
        const double step = (std::max)(3.0, length / 16);
        for (double z = 0.5 * (std::min)(step, length); z < length; z += step) f(origin + z * direction);
    }
    /// Whether a point lies between the faces, at most 1.5 cells from the edge, and next to
    /// `position_along` on the edge.
    bool holds(const Point& p, const Point& position_along) const noexcept {
        const auto d = p - origin;
        const double z = dot(d, direction);
        if (z < 0 || z > length || std::fabs(z - dot(position_along - origin, direction)) > 0.5) return false;
        const auto xy = across(d);
        return corner.distance(xy) <= 1.5 && corner.contains(xy);
    }
};

/// Calls f(sector) for all pairs of neighbouring faces at the edges of triangles.
template <class F>
void for_each_edge_sector(std::span<const Vec<double, 3>> vertices,
                          std::span<const std::array<std::uint32_t, 3>> faces, F&& f) {
    struct Face {
        std::size_t third;
        EdgeSector::AdjacentFace face;
        double angle; // around the edge, from the first face
    };
    const auto half_edges = detail::half_edges_of(faces);
    detail::for_each_edge(half_edges, [&](std::span<const detail::HalfEdge> about) {
        const auto [i, j] = about[0].edge();
        const auto d = vertices[j] - vertices[i];
        const double length = std::sqrt(dot(d, d));
        const auto direction = (1 / length) * d;
        std::vector<Face> fan;
        for (const detail::HalfEdge& half : about) {
            const auto& [a, b, c] = faces[half.face];
            const std::size_t third = std::size_t(a) + b + c - i - j;
            const EdgeSector::AdjacentFace face(vertices[i], direction, vertices[third]);
            const auto& x = fan.empty() ? face.across : fan[0].face.across;
            const double angle = std::atan2(dot(face.across, cross(direction, x)), dot(face.across, x));
            fan.push_back({third, face, angle < 0 ? angle + 2 * std::numbers::pi : angle});
        }
        std::sort(fan.begin(), fan.end(), [](const Face& a, const Face& b) { return a.angle < b.angle; });
        for (std::size_t n = 0; n < fan.size(); ++n) {
            const Face &a = fan[n], &b = fan[(n + 1) % fan.size()];
            const Vec<double, 2> after{1, 0};
            const Vec<double, 2> before{dot(b.face.across, a.face.across),
                                        dot(b.face.across, cross(direction, a.face.across))};
            f(EdgeSector{{i, j, a.third, b.third},
                         vertices[i],
                         direction,
                         length,
                         a.face,
                         b.face,
                         grid::Corner({0, 0}, fan.size() == 1 ? after : before, after, 1)});
        }
    });
}

} // namespace detail
namespace grid {

/// Returns the estimates of all edges of a TriangleMesh or a CellComplex that have nodes between their faces.
/// Handles are those of the cage. At most O(#edges · 16 points · 64 nodes).
template <class Cage>
CornerErrors<3> edge_errors(const Cage& cage, const Lattice<double, 3>& lattice,
                            const EmbeddedProblem<3>& problem) {
    using Index = NodeRuns<3>::Index;
    const auto vertices = lattice.in_cells(cage.vertices());
    const auto outer = boundary_of(cage).faces();
    const auto& inner = interior_cells(cage).facets;
    std::vector<std::array<std::uint32_t, 3>> faces(outer.begin(), outer.end());
    faces.insert(faces.end(), inner.begin(), inner.end());

    CornerErrors<3> errors;
    Buffer<CornerErrors<3>::Node> nodes;
    detail::for_each_edge_sector(vertices, faces, [&](const detail::EdgeSector& sector) {
        nodes.clear();
        sector.for_each_position_along([&](const Vec<double, 3>& position) {
            Index low;
            for (std::size_t k = 0; k < 3; ++k) low[k] = std::int32_t(std::floor(position[k])) - 1;
            for (std::int32_t n = 0; n < 64; ++n) {
                const Index index{low[0] + n % 4, low[1] + n / 4 % 4, low[2] + n / 16};
                const auto p = node_position<3>(index);
                if (!sector.holds(p, position)) continue;
                const auto node = problem.nodes.find(index);
                if (node != NodeRuns<3>::none) nodes.push_back({node, sector.shares(p)});
            }
        });
        if (nodes.empty()) return; // no node between these faces
        errors.add(CornerErrors<3>::untreated(sector.handles, sector.corner, sector.slope_of_w()), nodes);
    });
    return errors;
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI

// Checks a mesh, and computes the cotangent weights of its edges.
#pragma once

#include <cageform/core/result.hpp>
#include <cageform/core/types/bounds.hpp>
#include <cageform/fields/detail/intrinsic_mesh.hpp>
#include <cageform/fields/types/cotangent_weights.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the positions of vertices in 3D; a 2D mesh is in the plane of the first two axes.
template <class R>
std::vector<Vec<double, 3>> positions_in_space(const R& vertices) {
    std::vector<Vec<double, 3>> positions(std::size(vertices));
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const auto p = to_vec<double>(vertices[i]);
        for (std::size_t k = 0; k < range_dimension<R>; ++k) positions[i][k] = p[k];
    }
    return positions;
}

/// Returns a power of two. Division by it makes the longest side of the bounding box at most 2.
template <Scalar T>
double surface_unit(std::span<const Vec<T, 3>> vertices) noexcept {
    const auto bounds = bounds_of(vertices);
    double longest = 0;
    for (std::size_t k = 0; k < 3 && !vertices.empty(); ++k)
        longest = std::fmax(longest, 0.5 * double(bounds.upper[k]) - 0.5 * double(bounds.lower[k]));
    int exponent = 0;
    std::frexp(longest, &exponent);
    return std::ldexp(1.0, (std::min)(exponent, 1023));
}

/// Whether the corners of a face are collinear, so that its cotangents are infinite.
inline bool has_no_area(const Corners<3>& corner) noexcept {
    constexpr double relative = 1e-12; // relative to the longest side
    const auto& [a, b, c] = corner;
    return is_flat(corner, relative * (std::max)({length(b - a), length(c - b), length(a - c)}));
}

/// Reports the faults of faces and edges, and unused vertices. All vertices must be finite.
inline void check_surface(std::span<const Vec<double, 3>> vertices, std::span<const MeshFace> faces,
                          std::span<const HalfEdge> half_edges,
                          Result<CotangentWeights, SurfaceReport>& result) {
    CageReport& report = result.report.mesh;
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if (has_no_area(Facet<3>(faces[f], vertices).corner)) report.add(CageFaultKind::face_without_area, f);
    }
    for_each_edge(half_edges, [&](std::span<const HalfEdge> edge) {
        const auto [low, high] = edge[0].edge();
        if (edge.size() > 2) report.add(CageFaultKind::edge_not_manifold, low, high);
        if (edge.size() == 1) ++result.report.rim_edges;
    });
    for (std::size_t i = 0; i < result.value.unused.size(); ++i) {
        if (result.value.unused[i] != 0) report.add(CageFaultKind::vertex_unused, i);
    }
}

inline void add_links(const IntrinsicMesh& mesh, Result<CotangentWeights, SurfaceReport>& result) {
    result.value.links.reserve(mesh.sides() / 2 + 1);
    for (std::uint32_t side = 0; side < mesh.sides(); ++side) {
        if (mesh.twin(side) != IntrinsicMesh::rim && mesh.twin(side) < side) continue;
        const auto [value, rounding] = mesh.cotangents(side);
        const auto [a, b] = mesh.ends(side);
        // Flips may create an edge from a vertex to itself, which has no effect.
        if (a == b || std::fabs(value) <= rounding) continue;
        result.value.links.push_back({a, b, 0.5 * value});
        if (value < 0) ++result.report.negative_weights;
    }
}

inline Status make_weights(std::span<const Vec<double, 3>> vertices, std::span<const MeshFace> faces,
                           MeshWeights weights, Result<CotangentWeights, SurfaceReport>& result) {
    CageReport& report = result.report.mesh;
    result.value.unused.assign(vertices.size(), 1);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        if (has_missing_vertex(faces[f])) {
            report.add(CageFaultKind::face_without_vertex, f);
            continue;
        }
        for (const std::uint32_t i : faces[f]) result.value.unused[i] = 0;
    }
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        if (!is_finite(vertices[i])) report.add(CageFaultKind::vertex_not_finite, i);
    }
    if (report.status != Status::ok) return report.status;
    const auto half_edges = half_edges_of(faces);
    check_surface(vertices, faces, half_edges, result);
    if (report.status != Status::ok) return report.status;
    result.value.areas.assign(vertices.size(), 0.0);
    for (const auto& face : faces) {
        const double third = TriangleShape::of(Facet<3>(face, vertices).corner).area2 / 6;
        for (const std::uint32_t i : face) result.value.areas[i] += third;
    }
    IntrinsicMesh mesh(vertices, faces, half_edges);
    if (weights == MeshWeights::intrinsic_delaunay) result.report.flips = mesh.make_delaunay();
    add_links(mesh, result);
    result.value.has_negative = result.report.negative_weights > 0;
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

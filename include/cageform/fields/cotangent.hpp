// Cotangent weights of triangle meshes: the links for fields/graph.hpp that make functions on the
// vertices harmonic. Not included by cageform.hpp.
#pragma once

#include <cageform/core/result.hpp>
#include <cageform/fields/detail/intrinsic_mesh.hpp>
#include <cageform/fields/graph.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The triangles that the angles are measured in.
enum class MeshWeights : std::uint8_t {
    /// The triangles after intrinsic edge flips (by lengths alone) have made the mesh Delaunay. The
    /// surface and the vertices do not change. No weight of an edge with two faces is negative.
    intrinsic_delaunay,
    own, ///< the mesh's own triangles; an edge whose two opposite angles exceed π in sum has a negative
         ///< weight
};

/// A report on the weights of a mesh and on faults of the mesh.
struct SurfaceReport {
    Status status = Status::ok;
    /// The faults with indices, and warnings for unused vertices. Possible kinds are
    /// vertex_not_finite, face_without_vertex, face_without_area, edge_not_manifold and
    /// vertex_unused.
    CageReport mesh;
    std::size_t rim_edges = 0; ///< edges with only one face
    std::size_t flips = 0;
    /// The number of negative weights. If positive, values may leave the range of those given. They
    /// occur on rim edges opposite to an obtuse angle, and with MeshWeights::own on other edges
    /// too.
    std::size_t negative_weights = 0;
    double seconds = 0; ///< wall-clock time
};

/// The links of a mesh that make a function on its vertices harmonic, made by `cotangent_weights`.
struct CotangentWeights {
    std::size_t vertices = 0;
    std::vector<GraphLink> links;     ///< w_ij; those that are zero within rounding are left out
    std::vector<double> areas;        ///< of every vertex, a third of the given faces around it
    std::vector<std::uint8_t> unused; ///< of every vertex, 1 where no face has it
    double unit = 1;                  ///< the areas are in its square: a power of two
    bool has_negative = false;        ///< whether SurfaceReport::negative_weights is positive

    Graph graph() const noexcept { return {vertices, links}; }
};

namespace detail {

/// Returns the positions of vertices in space; a plane mesh lies in the plane of the first two
/// axes.
template <class R>
std::vector<Vec<double, 3>> places_in_space(const R& vertices) {
    std::vector<Vec<double, 3>> places(std::size(vertices));
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto p = to_vec<double>(vertices[i]);
        for (std::size_t k = 0; k < range_dimension<R>; ++k) places[i][k] = p[k];
    }
    return places;
}

/// Returns a power of two; dividing by it makes the largest coordinate at most 1.
template <Scalar T>
double surface_unit(std::span<const Vec<T, 3>> vertices) noexcept {
    double largest = 0;
    for (const auto& v : vertices) {
        for (std::size_t k = 0; k < 3; ++k) largest = std::fmax(largest, std::fabs(double(v[k])));
    }
    int exponent = 0;
    std::frexp(largest, &exponent);
    return std::ldexp(1.0, (std::min)(exponent, 1023));
}

/// Whether the corners of a face lie on one line, so that their cotangents would be infinite.
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

/// Adds the links of a mesh, one for each edge.
inline void add_links(const IntrinsicMesh& mesh, Result<CotangentWeights, SurfaceReport>& result) {
    result.value.links.reserve(mesh.sides() / 2 + 1);
    for (std::uint32_t side = 0; side < mesh.sides(); ++side) {
        if (mesh.twin(side) != IntrinsicMesh::rim && mesh.twin(side) < side) continue;
        const auto [value, rounding] = mesh.cotangents(side);
        const auto [a, b] = mesh.ends(side);
        // Flips may create an edge from a vertex to itself; it has no effect.
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
        if (lacks_vertex(faces[f])) {
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

} // namespace detail

/// Returns the weights w_ij = ½ (cot α_ij + cot β_ij) over the one or two angles opposite to edge
/// ij. Then Σ ½ w_ij (u_i − u_j)² is the Dirichlet energy of the function that is u at the vertices
/// and linear on the faces (Pinkall, Polthier, Computing discrete minimal surfaces and their
/// conjugates, Exper. Math. 2 (1993), sec. 2). A rim is free: nothing flows across it.
///
///   vertices  of a surface in space, or of a mesh in the plane
///   faces     each in either orientation; the mesh may be open or closed, of several components, of
///             any genus, orientable or not. Each edge has one face or two
///   cost      O(#F log #F) plus the flips, usually O(#F)
///   fails     as SurfaceReport::mesh says: vertex_not_finite, face_without_vertex,
///             face_without_area (twice the area at most 1e-12 of the longest side's square),
///             cage_not_manifold (an edge of three faces); out_of_memory
template <PointRange R, FaceRange F>
    requires(range_dimension<R> == 2 || range_dimension<R> == 3)
Result<CotangentWeights, SurfaceReport>
cotangent_weights(const R& vertices, const F& faces, MeshWeights weights = MeshWeights::intrinsic_delaunay) {
    Result<CotangentWeights, SurfaceReport> result;
    detail::run_into(result.report, [&] {
        const std::size_t count = std::size(vertices);
        auto places = detail::places_in_space(vertices);
        result.value.unit = detail::surface_unit(std::span<const Vec<double, 3>>(places));
        for (auto& place : places) {
            for (std::size_t k = 0; k < 3; ++k) place[k] /= result.value.unit;
        }
        std::vector<detail::MeshFace> checked;
        checked.reserve(std::size(faces));
        for (std::size_t f = 0; f < std::size(faces); ++f)
            checked.push_back(detail::checked_face(faces[f], count));
        result.value.vertices = count;
        return detail::make_weights(places, checked, weights, result);
    });
    if (!result) result.value = {};
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI

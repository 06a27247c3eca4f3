// The cotangent weights of a mesh, and the report of their making.
#pragma once

#include <cageform/cage/types/report.hpp>
#include <cageform/fields/types/graph.hpp>

#include <cstdint>
#include <vector>

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

} // namespace cageform::inline CAGEFORM_ABI

// The cotangent weights of a mesh, and the report of their computation.
#pragma once

#include <cageform/cage/types/report.hpp>
#include <cageform/fields/types/graph.hpp>

#include <cstdint>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// The triangles in which the angles are measured.
enum class MeshWeights : std::uint8_t {
    /// The triangles after intrinsic edge flips (by lengths only), which make the mesh Delaunay. The
    /// surface and the vertices do not change. Edges with two faces have no negative weights.
    intrinsic_delaunay,
    own, ///< the given triangles; the weight is negative if its two angles exceed π in sum
};

/// The report on the weights of a mesh and its faults.
struct SurfaceReport {
    Status status = Status::ok;
    /// The faults, of the kinds vertex_not_finite, face_without_vertex, face_without_area,
    /// edge_not_manifold and the warning vertex_unused.
    CageReport mesh;
    std::size_t rim_edges = 0; ///< edges with only one face
    std::size_t flips = 0;     ///< edge flips of MeshWeights::intrinsic_delaunay
    /// Number of negative weights. If positive, values may leave the range of the given values. Negative
    /// weights occur on boundary edges opposite to an obtuse angle, and with MeshWeights::own on other
    /// edges too.
    std::size_t negative_weights = 0;
    double seconds = 0; ///< wall-clock time
};

/// The edge weights of a mesh that make functions on its vertices harmonic (`cotangent_weights`).
struct CotangentWeights {
    std::size_t vertices = 0;
    std::vector<GraphLink> links;     ///< w_ij; weights that are zero up to rounding are left out
    std::vector<double> areas;        ///< per vertex: a third of the area of the given faces around it
    std::vector<std::uint8_t> unused; ///< per vertex: 1 if it has no face
    double unit = 1;                  ///< unit of length, a power of two; `areas` has its square as unit
    bool has_negative = false;        ///< whether SurfaceReport::negative_weights is positive

    Graph graph() const noexcept { return {vertices, links}; }
};

} // namespace cageform::inline CAGEFORM_ABI

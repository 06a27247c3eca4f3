// Cotangent weights of triangle meshes, as links for fields/graph.hpp. Not included by cageform.hpp.
#pragma once

#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/core/result.hpp>
#include <cageform/fields/detail/edge_weights.hpp>
#include <cageform/fields/graph.hpp>
#include <cageform/fields/types/cotangent_weights.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Returns the weights w_ij = ½ (cot α_ij + cot β_ij) over the one or two angles opposite to edge ij. Let a
/// function be u at the vertices and linear on the faces. Then Σ ½ w_ij (u_i − u_j)² is the Dirichlet energy
/// of this function (Pinkall, Polthier, Computing discrete minimal surfaces and their conjugates, Exper.
/// Math. 2 (1993), sec. 2). There is no flux across boundary edges.
///
///   vertices  of a surface in 3D, or of a mesh in 2D
///   faces     in any orientation; the mesh may be open or closed, orientable or not, with several
///             components and of any genus. Each edge has one face or two
///   cost      O(#F log #F) plus the flips, usually O(#F)
///   fails     with the faults in SurfaceReport::mesh: vertex_not_finite, face_without_vertex,
///             face_without_area (twice the area at most 1e-12 of the longest side's square),
///             cage_not_manifold (an edge of three faces); out_of_memory
template <PointRange R, FaceRange F>
    requires(range_dimension<R> == 2 || range_dimension<R> == 3)
Result<CotangentWeights, SurfaceReport>
cotangent_weights(const R& vertices, const F& faces, MeshWeights weights = MeshWeights::intrinsic_delaunay) {
    Result<CotangentWeights, SurfaceReport> result;
    detail::run_into(result.report, [&] {
        const std::size_t count = std::size(vertices);
        auto positions = detail::positions_in_space(vertices);
        result.value.unit = detail::surface_unit(std::span<const Vec<double, 3>>(positions));
        for (auto& position : positions) {
            for (std::size_t k = 0; k < 3; ++k) position[k] /= result.value.unit;
        }
        std::vector<detail::MeshFace> checked;
        checked.reserve(std::size(faces));
        for (std::size_t f = 0; f < std::size(faces); ++f)
            checked.push_back(detail::checked_face(faces[f], count));
        result.value.vertices = count;
        return detail::make_weights(positions, checked, weights, result);
    });
    if (!result) result.value = {};
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI

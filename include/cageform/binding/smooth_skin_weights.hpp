// Skin weights that are computed for all points of a mesh at once, so that the posed surface is smooth.
#pragma once

#include <cageform/binding/detail/smooth_skin.hpp>
#include <cageform/cage/triangle_mesh.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Returns a skin as `skin_weights` does, for points that are the vertices of a mesh. The weights of
/// all points are chosen together, so that the loss changes little along edges. Weights chosen point by
/// point would crease the surface where neighbours drop different handles.
///
///   triangles  #triangles · 3 indices of points. Points at the same position with the same weights get
///              the same skin
///   objective  Σ_edges e |r_i − r_j|² + 0.02 Σ_points |r|² + 100 Σ_points |Σwc − p|² / L². r is the loss of
///              a point in poses that move close handles similarly: the covariance of the handles'
///              displacements is a Gaussian with σ = L/5. L is the cage's diagonal; e is (mean edge
///              length / edge length)², at most 25. Handles with the smallest weights, smoothed over the
///              mesh, are dropped in ten rounds
///   weights    non-negative, Σw = 1 and, with K > D, Σwc = p as in skin_weights(), restored by the least
///              relative change. If the kept handles do not surround the point, other handles replace
///              them, and the surface may crease: in 3D everywhere for K = 4, rarely for K = 8
///   returns    the skin and its report, as skin_weights()
///   cost       480 passes over the kept weights, about thirty numbers per weight: 0.7 ms per point for
///              60 handles and K = 8. Memory: #points · (2 #handles floats and 120 doubles)
///   fails      as skin_weights(); index_out_of_range
template <Scalar T, std::size_t D, FaceRange F>
Result<SkinWeights, SkinWeightsReport>
smooth_skin_weights(const BindingView<T, D>& binding, const F& triangles,
                    const SkinWeightsOptions& options = {}, const Running& running = {}) {
    return detail::make_skin(binding, options, [&](Result<SkinWeights, SkinWeightsReport>& result) {
        std::vector<detail::MeshFace> faces;
        for (std::size_t f = 0; f < std::size(triangles); ++f)
            faces.push_back(detail::checked_face(triangles[f], binding.point_count()));
        return detail::make_smooth_skin<T, D>(binding, faces, options, running, result);
    });
}
template <Scalar T, std::size_t D, FaceRange F>
Result<SkinWeights, SkinWeightsReport> smooth_skin_weights(const Binding<T, D>& binding, const F& triangles,
                                                           const SkinWeightsOptions& options = {},
                                                           const Running& running = {}) {
    return smooth_skin_weights(binding.view(), triangles, options, running);
}

} // namespace cageform::inline CAGEFORM_ABI

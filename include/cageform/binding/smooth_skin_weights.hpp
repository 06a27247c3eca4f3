// Chooses the weights of a skin for all points of a mesh together, so that its surface stays smooth
// where neighbours drop different handles.
#pragma once

#include <cageform/binding/detail/smooth_skin.hpp>
#include <cageform/cage/triangle_mesh.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Returns a skin as `skin_weights` does, for points that are the vertices of a mesh. The handles
/// and weights of all points are chosen together, so that the loss changes little along edges. If
/// they are chosen point by point, neighbours drop different handles and the surface creases.
///
///   triangles  #triangles · 3 indices of points. Points at the same position with the same weights get
///              the same skin
///   objective  the loss in poses that move close handles alike: the sum over edges of the squared
///              difference of the loss, with smaller weights for longer edges, plus a small share of the
///              loss itself and of the error of the reproduced point. The covariance of the handles'
///              displacements is a Gaussian of a fifth of the cage's diagonal. Handles are dropped in ten
///              rounds: those of the smallest weights, smoothed over the mesh
///   weights    non-negative, Σw = 1 and, with K > D, Σwc = p as with skin_weights(). This is restored by
///              the least relative change, so weights that fade out still do. If the kept handles do not
///              surround the point, others replace them and the surface may crease there: with 4 handles
///              in 3D everywhere, with 8 hardly
///   returns    the skin and its report, as skin_weights()
///   cost       480 passes over the kept weights, each of some thirty numbers a weight: 0.7 ms a point for
///              60 handles and K of 8. Memory: #points · (#handles floats twice, and 120 doubles)
///   fails      as skin_weights(); index_out_of_range
template <Scalar T, std::size_t D, FaceRange F>
Result<SkinWeights, SkinWeightsReport>
smooth_skin_weights(const BindingView<T, D>& binding, const F& triangles,
                    const SkinWeightsOptions& options = {}, const Running& running = {}) {
    return detail::make_skin(binding, options, [&](SkinWeights& skin, SkinWeightsReport& report) {
        std::vector<detail::MeshFace> faces;
        for (std::size_t f = 0; f < std::size(triangles); ++f)
            faces.push_back(detail::checked_face(triangles[f], binding.point_count()));
        return detail::make_smooth_skin<T, D>(binding, faces, options, running, skin, report);
    });
}
template <Scalar T, std::size_t D, FaceRange F>
Result<SkinWeights, SkinWeightsReport> smooth_skin_weights(const Binding<T, D>& binding, const F& triangles,
                                                           const SkinWeightsOptions& options = {},
                                                           const Running& running = {}) {
    return smooth_skin_weights(binding.view(), triangles, options, running);
}

} // namespace cageform::inline CAGEFORM_ABI

// Declares the implementation of `smooth_skin_weights`.
#pragma once

#include <cageform/binding/skin_weights.hpp>
#include <cageform/cage/detail/mesh_face.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Fills a skin and its report. Vertices out of range must be `no_vertex`.
template <class T, std::size_t D>
Status make_smooth_skin(const BindingView<T, D>& binding, std::span<const MeshFace> triangles,
                        const SkinWeightsOptions& options, const Running& running,
                        Result<SkinWeights, SkinWeightsReport>& result);

} // namespace cageform::inline CAGEFORM_ABI::detail

#if !defined(CAGEFORM_COMPILED)
#include <cageform/binding/detail/smooth_skinner.hpp>
#endif

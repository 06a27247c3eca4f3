// Compiles `skin_weights` and `smooth_skin_weights`.
#include "../instantiate.hpp"

#include <cageform/binding/detail/smooth_skinner.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

CAGEFORM_COMPILE Status Skinner<CAGEFORM_T, CAGEFORM_D>::run(SkinWeights&, SkinWeightsReport&);
CAGEFORM_COMPILE Status make_smooth_skin(const BindingView<CAGEFORM_T, CAGEFORM_D>&,
                                         std::span<const MeshFace>, const SkinWeightsOptions&, const Running&,
                                         SkinWeights&, SkinWeightsReport&);

} // namespace cageform::inline CAGEFORM_ABI::detail

// Compiles `skin_weights` and `smooth_skin_weights`.
#include "../instantiate.hpp"

#include <cageform/binding/detail/smooth_skinner.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#define CAGEFORM_SKIN(T, D)                                                                                  \
    CAGEFORM_COMPILE Status Skinner<T, D>::run(SkinWeights&, SkinWeightsReport&);                            \
    CAGEFORM_COMPILE Status make_smooth_skin(const BindingView<T, D>&, std::span<const MeshFace>,            \
                                             const SkinWeightsOptions&, const Running&,                      \
                                             Result<SkinWeights, SkinWeightsReport>&);
CAGEFORM_FOR_SCALARS(CAGEFORM_SKIN, 2)
CAGEFORM_FOR_SCALARS(CAGEFORM_SKIN, 3)

} // namespace cageform::inline CAGEFORM_ABI::detail

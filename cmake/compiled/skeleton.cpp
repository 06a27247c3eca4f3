// Compiles `fit_skeleton`.
#include "instantiate.hpp"

#include <cageform/skeleton/detail/fit_motion.hpp>
#include <cageform/skeleton/detail/fit_motion.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#define CAGEFORM_SKELETON(T)                                                                                 \
    CAGEFORM_COMPILE Status fit_motion(Motion&, const SkeletonOptions&, const Running&,                      \
                                       Result<FittedSkeleton<T>, SkeletonReport>&);
CAGEFORM_FOR_SCALARS(CAGEFORM_SKELETON)

} // namespace cageform::inline CAGEFORM_ABI::detail

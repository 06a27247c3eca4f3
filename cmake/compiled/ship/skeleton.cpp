// Compiles `fit_skeleton` and `fit_skeleton_keys`.
#include "../instantiate.hpp"

#include <cageform/skeleton/detail/fit_motion.hpp>
#include <cageform/skeleton/detail/fit_motion.impl.hpp>
#include <cageform/skeleton/detail/make_keys.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#define CAGEFORM_SKELETON(T, D)                                                                              \
    CAGEFORM_COMPILE Status fit_motion(Motion&, const SkeletonOptions&, const Running&,                      \
                                       Result<FittedSkeleton<T>, SkeletonReport>&);                          \
    CAGEFORM_COMPILE Status make_keys(const SkeletonFrames<T>&, const SkeletonKeyOptions&, const Running&,   \
                                      Result<SkeletonKeys<T>, SkeletonKeysReport>&);
CAGEFORM_FOR_SCALARS(CAGEFORM_SKELETON, 3)

} // namespace cageform::inline CAGEFORM_ABI::detail

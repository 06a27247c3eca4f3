// Compiles `fit_skeleton` and `fit_skeleton_keys`, in space.
#include "../instantiate.hpp"

#if CAGEFORM_D == 3
#include <cageform/skeleton/detail/fit_motion.hpp>
#include <cageform/skeleton/detail/fit_motion.impl.hpp>
#include <cageform/skeleton/detail/make_keys.hpp>
#include <cageform/skeleton/detail/make_keys.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

using T = CAGEFORM_T;
CAGEFORM_COMPILE Status fit_motion(Motion&, const SkeletonOptions&, const Running&,
                                   Result<FittedSkeleton<T>, SkeletonReport>&);
CAGEFORM_COMPILE Status make_keys(const FittedSkeleton<T>&, const std::vector<Vec<double, 3>>&,
                                  std::span<const T>, const SkeletonKeyOptions&, const Running&,
                                  Result<SkeletonKeys<T>, SkeletonKeysReport>&);

} // namespace cageform::inline CAGEFORM_ABI::detail
#endif

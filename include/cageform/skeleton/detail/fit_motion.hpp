// Declares the function behind `fit_skeleton`, which knows the frames only as a Motion.
#pragma once

#include <cageform/core/result.hpp>
#include <cageform/parallel/running.hpp>
#include <cageform/skeleton/detail/motion.hpp>
#include <cageform/skeleton/types/fitted_skeleton.hpp>
#include <cageform/skeleton/types/skeleton_options.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Fits a skeleton; `motion` has the figure as it is given.
template <class T>
Status fit_motion(Motion& motion, const SkeletonOptions& options, const Running& running,
                  Result<FittedSkeleton<T>, SkeletonReport>& result);

} // namespace cageform::inline CAGEFORM_ABI::detail

#if !defined(CAGEFORM_COMPILED)
#include <cageform/skeleton/detail/fit_motion.impl.hpp>
#endif

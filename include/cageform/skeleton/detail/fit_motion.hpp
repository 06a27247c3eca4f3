// Declares the implementations of `fit_skeleton`, which reads frames only as a Motion, and of
// `fit_skeleton_keys`.
#pragma once

#include <cageform/core/result.hpp>
#include <cageform/parallel/running.hpp>
#include <cageform/skeleton/detail/motion.hpp>
#include <cageform/skeleton/types/skeleton_keys.hpp>
#include <cageform/skeleton/types/skeleton_options.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Fits a skeleton; `motion` has the input vertices and faces.
template <class T>
Status fit_motion(Motion& motion, const SkeletonOptions& options, const Running& running,
                  Result<FittedSkeleton<T>, SkeletonReport>& result);

/// Arguments of `fit_skeleton_keys`.
template <class T>
struct SkeletonFrames {
    const FittedSkeleton<T>& skeleton;
    const std::vector<Vec<double, 3>>& rest; ///< #vertices
    std::span<const T> times;                ///< #frames, in seconds
};
template <class T>
Status make_keys(const SkeletonFrames<T>& given, const SkeletonKeyOptions& options, const Running& running,
                 Result<SkeletonKeys<T>, SkeletonKeysReport>& result);

} // namespace cageform::inline CAGEFORM_ABI::detail

#if !defined(CAGEFORM_COMPILED)
#include <cageform/skeleton/detail/fit_motion.impl.hpp>
#include <cageform/skeleton/detail/make_keys.impl.hpp>
#endif

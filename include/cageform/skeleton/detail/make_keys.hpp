// Declares the function behind `fit_skeleton_keys`.
#pragma once

#include <cageform/core/result.hpp>
#include <cageform/parallel/running.hpp>
#include <cageform/skeleton/types/skeleton_keys.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Checks a skeleton, makes its keys and measures them.
template <class T>
Status make_keys(const FittedSkeleton<T>& skeleton, const std::vector<Vec<double, 3>>& rest,
                 std::span<const T> times, const SkeletonKeyOptions& options, const Running& running,
                 Result<SkeletonKeys<T>, SkeletonKeysReport>& result);

} // namespace cageform::inline CAGEFORM_ABI::detail

#if !defined(CAGEFORM_COMPILED)
#include <cageform/skeleton/detail/make_keys.impl.hpp>
#endif

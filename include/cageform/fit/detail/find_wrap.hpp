// Declares the implementation of `wrap`, in double.
#pragma once

#include <cageform/core/result.hpp>
#include <cageform/fit/detail/dense_rows.hpp>
#include <cageform/fit/types/wrap.hpp>
#include <cageform/parallel/running.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The cage of a wrap, in the space of the source.
struct WrapCageInput {
    std::vector<Vec<double, 3>> rest;
    std::vector<char> is_point; ///< #handles
    EvaluateCage evaluate;      ///< weights, or derivatives along the axes of the source
};

/// What `wrap` is given.
struct WrapInput {
    const SurfaceMesh &source, &target;
    const WrapOptions& options;
    const WrapCageInput* cage = nullptr; ///< null for a lattice alone
};

/// Finds a wrap.
template <class T>
Status find_wrap(const WrapInput& input, const Running& running, Result<Wrap<T>, WrapReport>& result);

} // namespace cageform::inline CAGEFORM_ABI::detail

#if !defined(CAGEFORM_COMPILED)
#include <cageform/fit/detail/find_wrap.impl.hpp>
#endif

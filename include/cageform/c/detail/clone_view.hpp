// Declares the clone functions of the C interface, per scalar and dimension.
#pragma once

#include <cageform/c/detail/running.hpp>

namespace cageform::inline CAGEFORM_ABI::detail::c {

/// Clones the points of a figure, and normals and tangents unless they are null.
template <class T, std::size_t D>
cageform_status clone_view(const PackedFigureView<T, D>& figure, const cageform_points& pose,
                           const cageform_output& points, const cageform_output* normals,
                           const cageform_output* tangents, const cageform_running* running);

template <class T, std::size_t D>
cageform_status clone_view_transposed(const PackedBindingView<T, D>& binding,
                                      const cageform_points& gradients, const cageform_output& handles,
                                      const cageform_running* running);

} // namespace cageform::inline CAGEFORM_ABI::detail::c

#if !defined(CAGEFORM_COMPILED)
#include <cageform/c/detail/clone_view.impl.hpp>
#endif

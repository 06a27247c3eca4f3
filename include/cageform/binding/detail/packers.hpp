// Declares the implementation of `pack`.
#pragma once

#include <cageform/binding/types/figure_binding.hpp>
#include <cageform/binding/types/pack_options.hpp>
#include <cageform/core/result.hpp>
#include <cageform/parallel/running.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Packs a binding. `on_seam` is the result of seam_points; if it is empty, it is computed.
template <class T, std::size_t D>
Result<PackedBinding<T, D>, PackReport> pack_binding(const BindingView<T, D>& binding,
                                                     const PackOptions& options, const Running& running,
                                                     std::span<const char> on_seam);

template <class T, std::size_t D>
Status pack_parts(const FigureBinding<T, D>& figure, const FigurePackOptions& options, const Running& running,
                  Result<PackedFigure<T, D>, FigurePackReport>& result);

} // namespace cageform::inline CAGEFORM_ABI::detail

#if !defined(CAGEFORM_COMPILED)
#include <cageform/binding/detail/figure_packer.hpp>
#endif

// Declares the implementation of `bind`, which uses the coordinates only through a BindInput.
#pragma once

#include <cageform/binding/detail/bind_input.hpp>
#include <cageform/binding/types/bind_options.hpp>
#include <cageform/binding/types/figure_binding.hpp>
#include <cageform/core/result.hpp>
#include <cageform/figure/binding.hpp>

#include <array>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Binds points; reuses the memory of `recycled`.
template <class T, std::size_t D>
Result<Binding<T, D>, BindReport> bind_points(const BindInput<T, D>& input, const BindOptions& options,
                                              Binding<T, D>&& recycled, const Running& running);

/// Binds families of vectors, one binding per family. The input must have gradients.
template <class T, std::size_t D>
BindReport bind_vectors_into(std::span<Binding<T, D>> bindings, const BindInput<T, D>& input,
                             std::span<const PointReader<T>> vectors, const BindOptions& options,
                             const Running& running);

template <class T, std::size_t D, std::size_t K>
Result<std::array<Binding<T, D>, K>, BindReport>
bind_each_vector(const BindInput<T, D>& input, const std::array<PointReader<T>, K>& vectors,
                 const BindOptions& options, const Running& running) {
    Result<std::array<Binding<T, D>, K>, BindReport> result;
    result.report = bind_vectors_into<T, D>(result.value, input, vectors, options, running);
    return result;
}

/// Binds the D axes at every point.
template <class T, std::size_t D>
Result<std::array<Binding<T, D>, D>, BindReport>
bind_axes(const BindInput<T, D>& input, const BindOptions& options, const Running& running);

/// The figure to bind, read from the caller's memory.
template <Scalar T, std::size_t D>
struct FigureInput {
    PointReader<T> points;
    std::array<PointReader<T>, D - 1> tangents; ///< empty without normals
    std::vector<std::int8_t> handedness;        ///< of the given tangents

    bool has_normals() const noexcept { return bool(tangents[0].read); }
};

/// Binds a figure. A solver solves once for weights and gradients.
template <class T, std::size_t D>
Status bind_read_figure(const BindInput<T, D>& coordinates, FigureInput<T, D>& figure,
                        const BindOptions& options, const Running& running,
                        Result<FigureBinding<T, D>, FigureBindReport>& result);

} // namespace cageform::inline CAGEFORM_ABI::detail

#if !defined(CAGEFORM_COMPILED)
#include <cageform/binding/detail/binders.impl.hpp>
#endif

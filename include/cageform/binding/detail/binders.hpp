// Declares the functions behind `bind`, which know the coordinates only as a BindInput.
#pragma once

#include <cageform/binding/binding.hpp>
#include <cageform/binding/detail/bind_input.hpp>
#include <cageform/binding/types/bind_options.hpp>
#include <cageform/core/result.hpp>

#include <array>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Binds points, into the memory of a binding that is no longer needed.
template <class T, std::size_t D>
Result<Binding<T, D>, BindReport> bind_points(const BindInput<T, D>& input, const BindOptions& options,
                                              Binding<T, D>&& recycled, const Running& running);

/// Binds families of vectors, one binding for each; the input evaluates gradients.
template <class T, std::size_t D>
BindReport bind_vectors_into(std::span<Binding<T, D>> bindings, const BindInput<T, D>& input,
                             std::span<const PointReader<T>> vectors, const BindOptions& options,
                             const Running& running);

template <class C, std::size_t K>
Result<std::array<Binding<typename C::scalar, C::dimension>, K>, BindReport>
bind_each_vector(const C& coordinates, const PointReader<typename C::scalar>& points,
                 const std::array<PointReader<typename C::scalar>, K>& vectors, const BindOptions& options,
                 const Running& running) {
    using T = typename C::scalar;
    auto input = bind_input(coordinates, points);
    input.evaluate = [&coordinates](const Batch<T>& batch, const Running& how) {
        return coordinates.evaluate_gradients(batch.points, batch.rows, batch.states, how);
    };
    Result<std::array<Binding<T, C::dimension>, K>, BindReport> result;
    result.report = bind_vectors_into<T, C::dimension>(result.value, input, vectors, options, running);
    return result;
}

/// Binds the D axes at every point.
template <class C>
auto bind_axes(const C& coordinates, const PointReader<typename C::scalar>& points,
               const BindOptions& options, const Running& running) {
    using T = typename C::scalar;
    std::array<Vec<T, C::dimension>, C::dimension> axes{};
    std::array<PointReader<T>, C::dimension> readers;
    for (std::size_t n = 0; n < C::dimension; ++n) {
        axes[n][n] = 1;
        readers[n] = repeat_vector(points.size, axes[n]);
    }
    return bind_each_vector(coordinates, points, readers, options, running);
}

} // namespace cageform::inline CAGEFORM_ABI::detail

#if !defined(CAGEFORM_COMPILED)
#include <cageform/binding/detail/binders.impl.hpp>
#endif

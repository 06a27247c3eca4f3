// Definitions of MeanValueCoordinates. Not included if the program links cageform::compiled.
#pragma once

#include <cageform/coordinates/mean_value/polygons.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template <class Cage>
Evaluation MeanValueEvaluation<Cage>::evaluate(BlockView<const scalar> points, BlockView<scalar> weights,
                                               std::span<PointState> states, const Running& running) const {
    return evaluate_numbers<Simd<T>>({points, weights, states}, running);
}

template <class Cage>
Evaluation
MeanValueEvaluation<Cage>::evaluate_gradients(BlockView<const scalar> points, BlockView<scalar> gradients,
                                              std::span<PointState> states, const Running& running) const {
    return evaluate_numbers<Dual<Simd<double>, D>>({points, gradients, states}, running);
}

template <class Cage>
Status MeanValueEvaluation<Cage>::prepare() {
    if (report_.status == Status::ok) report_.status = guard_memory([&] { fill_tables(); });
    return report_.status;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

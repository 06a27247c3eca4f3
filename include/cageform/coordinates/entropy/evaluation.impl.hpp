// Definitions of MaximumEntropyCoordinates. Not included if the program links cageform::compiled.
#pragma once

#include <cageform/coordinates/entropy/evaluation.hpp>
#include <cageform/coordinates/mean_value/evaluation.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template <class Cage>
Evaluation EntropyEvaluation<Cage>::evaluate(BlockView<const scalar> points, BlockView<scalar> weights,
                                             std::span<PointState> states, const Running& running) const {
    return evaluate_numbers<Simd<T>>({points, weights, states}, running);
}

template <class Cage>
Evaluation
EntropyEvaluation<Cage>::evaluate_gradients(BlockView<const scalar> points, BlockView<scalar> gradients,
                                            std::span<PointState> states, const Running& running) const {
    return evaluate_numbers<Dual<Simd<double>, D>>({points, gradients, states}, running);
}

} // namespace cageform::inline CAGEFORM_ABI::detail

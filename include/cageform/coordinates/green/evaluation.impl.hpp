// Definitions of GreenCoordinates. Not included if the program links cageform::compiled.
#pragma once

#include <cageform/coordinates/green/evaluation.hpp>
#include <cageform/coordinates/green/plane.hpp>
#include <cageform/coordinates/green/space.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template <class Cage>
Evaluation GreenEvaluation<Cage>::evaluate(BlockView<const scalar> points, BlockView<scalar> weights,
                                           std::span<PointState> states, const Running& running) const {
    return evaluate_rows<false>({points, weights, states}, running);
}

template <class Cage>
Evaluation
GreenEvaluation<Cage>::evaluate_gradients(BlockView<const scalar> points, BlockView<scalar> gradients,
                                          std::span<PointState> states, const Running& running) const {
    return evaluate_rows<true>({points, gradients, states}, running);
}

template <class Cage>
auto GreenEvaluation<Cage>::nearest_boundary(const Vec<scalar, dimension>& p, std::span<scalar> row) const
    -> Vec<scalar, dimension> {
    Vec<T, D> nearest = p;
    (void)nearest_boundary_value(cage_, p, nearest);
    std::vector<Lanes<T>> position(D), rows(handles_.size());
    for (std::size_t k = 0; k < D; ++k) std::fill_n(position[k].v, lane_count<T>, nearest[k]);
    PointState state = PointState::unreached;
    GreenRows<T, D> memory(frame_);
    std::vector<Lanes<T>> of_points(folds() ? row_count() : 0);
    // The tolerance allows for the rounding of the nearest point.
    evaluate_block<false>({{position.data(), D, 1}, {rows.data(), rows.size(), 1}, {&state, 1}}, 0,
                          4 * tolerance_, of_points, memory);
    for (std::size_t h = 0; h < row.size(); ++h) row[h] = rows[h][0];
    return nearest;
}

template <class Cage>
Status GreenEvaluation<Cage>::prepare() {
    if constexpr (requires { cage_.options().divisions; }) {
        if (report_.status == Status::ok && cage_.options().divisions > 1)
            report_.add(CageFaultKind::face_divisions, cage_.options().divisions);
    }
    if (report_.status != Status::ok) return report_.status;
    report_.status = guard_memory([&] {
        fill_tables();
        refuse_overflow();
        return report_.status;
    });
    return report_.status;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

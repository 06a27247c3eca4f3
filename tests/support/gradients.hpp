// Gradients of a batch of points.
#pragma once

#include "weights.hpp"

namespace cageform_tests {

template <class T, std::size_t D>
struct Gradients {
    cageform::Evaluation evaluation;
    std::vector<PointState> states;
    std::vector<std::vector<Vec<T, D>>> rows; ///< [point][handle]
};

/// Evaluates a whole batch at once, in buffers exactly as long as promised.
template <class T, std::size_t D, class Coordinates>
Gradients<T, D> gradients_of(const Coordinates& coordinates, const std::vector<Vec<T, D>>& points,
                             const cageform::Running& options = {}) {
    const std::size_t handles = coordinates.handles().size(),
                      blocks = cageform::block_count<T>(points.size());
    std::vector<cageform::Lanes<T>> position(blocks * D), rows(blocks * D * handles);
    const cageform::BlockView<T> places{position.data(), D, points.size()};
    const cageform::BlockView<T> gradients{rows.data(), D * handles, points.size()};
    Gradients<T, D> result;
    for (const auto& p : points)
        result.states.push_back(is_finite(p) ? PointState::inside : PointState::not_finite);
    for (std::size_t i = 0; i < blocks * cageform::lane_count<T>; ++i) {
        for (std::size_t k = 0; k < D; ++k) places(i, k) = points[std::min(i, points.size() - 1)][k];
    }
    result.evaluation = coordinates.evaluate_gradients(places, gradients, result.states, options);
    if (result.evaluation.status != Status::ok) return result;
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::vector<Vec<T, D>> row(handles);
        for (std::size_t h = 0; h < handles; ++h) {
            for (std::size_t k = 0; k < D; ++k) row[h][k] = gradients(i, k * handles + h);
        }
        result.rows.push_back(std::move(row));
    }
    return result;
}

} // namespace cageform_tests

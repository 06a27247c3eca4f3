// Gradients of a batch of points.
#pragma once

#include "larger.hpp"
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

/// The largest difference to expected gradients (times the diagonal), relative to the largest or one.
template <class T, std::size_t D>
double error_of(const std::vector<Vec<T, D>>& row, const std::vector<Vec<double, D>>& expected, double size) {
    double largest = 1, worst = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        for (std::size_t k = 0; k < D; ++k) {
            largest = larger(largest, std::fabs(expected[i][k]));
            const double d = std::fabs(double(row[i][k]) * size - expected[i][k]);
            worst = larger(worst, d); // keeps a NaN
        }
    }
    return worst / largest;
}

/// How far Σ ∇w = 0 and Σ C ∇w = identity are missed, relative to the largest gradient and to the cage's
/// diagonal.
template <class T, std::size_t D>
double law_error(std::span<const Vec<T, D>> handles, const Vec<T, D>& p, const std::vector<Vec<T, D>>& row) {
    const double size = double(bounds_of(handles).diagonal());
    double largest = 1, worst = 0;
    Vec<double, D> sum{};
    std::array<Vec<double, D>, D> jacobian{};
    for (std::size_t i = 0; i < handles.size(); ++i) {
        const auto c = vec_cast<double>(handles[i]) - vec_cast<double>(p);
        const auto g = vec_cast<double>(row[i]);
        for (std::size_t k = 0; k < D; ++k) {
            largest = larger(largest, std::fabs(g[k]) * std::max(size, std::sqrt(dot(c, c))));
            jacobian[k] = jacobian[k] + c[k] * g;
        }
        sum = sum + g;
    }
    for (std::size_t k = 0; k < D; ++k) {
        worst = larger(worst, std::fabs(sum[k]) * size);
        for (std::size_t l = 0; l < D; ++l)
            worst = larger(worst, std::fabs(jacobian[k][l] - (k == l ? 1 : 0)));
    }
    return worst / largest;
}

} // namespace cageform_tests

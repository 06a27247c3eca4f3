// Cages that are nearly flat, and the law that restoring linear precision keeps in them.
#pragma once

#include "../catch.hpp"
#include "larger.hpp"
#include "weights.hpp"

namespace cageform_tests {

/// How far weights are from Σw = 1 and Σwc = p, lengths about the middle of the handles and in their
/// diagonal.
template <class Row, std::size_t D, class T>
double affine_residual(const Row& row, std::span<const Vec<T, D>> handles, const Vec<T, D>& p) {
    const auto bounds = cageform::bounds_of(handles);
    const auto half = cageform::vec_cast<long double>(T(0.5) * (bounds.lower + bounds.upper));
    const auto in_frame = [&](const Vec<T, D>& x) {
        return 1 / static_cast<long double>(bounds.diagonal()) * (cageform::vec_cast<long double>(x) - half);
    };
    const auto missing = in_frame(p);
    long double worst = std::fabs(sum_of(row) - 1);
    for (std::size_t k = 0; k < D; ++k) {
        long double sum = -missing[k];
        for (std::size_t i = 0; i < handles.size(); ++i)
            sum += static_cast<long double>(row[i]) * in_frame(handles[i])[k];
        worst = larger(worst, std::fabs(sum));
    }
    return double(worst);
}

/// A thin triangle or tetrahedron: a segment of length 1 somewhere, and corners within `width` of it.
template <class T, std::size_t D>
std::vector<Vec<T, D>> thin_simplex(Random& random, double width) {
    Vec<double, D> from{}, along{};
    double square = 0;
    for (std::size_t k = 0; k < D; ++k) {
        from[k] = random.uniform(-1, 1);
        along[k] = random.uniform(-1, 1);
        square += along[k] * along[k];
    }
    along = (1 / std::sqrt(square)) * along;
    std::vector<Vec<T, D>> corners{cageform::vec_cast<T>(from), cageform::vec_cast<T>(from + along)};
    for (std::size_t i = 2; i <= D; ++i) {
        auto corner = from + (double(i) - 1 + random.uniform(-0.2, 0.2)) / double(D) * along;
        for (std::size_t k = 0; k < D; ++k)
            corner[k] += width * (random.below(2) == 0 ? 1 : -1) * random.uniform(0.5, 1);
        corners.push_back(cageform::vec_cast<T>(corner));
    }
    return corners;
}

/// A point in a random direction, 0.1 to 1000 diagonals from the middle of the handles and outside their
/// bounds.
template <class T, std::size_t D>
Vec<T, D> random_outside(std::span<const Vec<T, D>> handles, Random& random) {
    const auto bounds = cageform::bounds_of(handles);
    const double size = double(bounds.diagonal());
    for (;;) {
        Vec<double, D> direction{};
        double square = 0;
        for (std::size_t k = 0; k < D; ++k) {
            direction[k] = random.uniform(-1, 1);
            square += direction[k] * direction[k];
        }
        const double far = size * std::pow(10.0, random.uniform(-1, 3)) / std::sqrt(square);
        const auto p = cageform::vec_cast<T>(
            cageform::vec_cast<double>(T(0.5) * (bounds.lower + bounds.upper)) + far * direction);
        for (std::size_t k = 0; k < D; ++k) {
            if (double(p[k]) < double(bounds.lower[k]) - 0.01 * size ||
                double(p[k]) > double(bounds.upper[k]) + 0.01 * size)
                return p;
        }
    }
}

/// Points outside a thin cage are known to be: outside, or unreached where the widest scalar does not tell
/// their weights. Nothing where the cage is too thin to be one.
template <class Coordinates>
void check_thin_states(const Coordinates& coordinates, Random& random) {
    using T = typename Coordinates::scalar;
    constexpr std::size_t D = Coordinates::dimension;
    if (coordinates.cage_report().status != Status::ok) return;
    const auto handles = coordinates.handles();
    std::vector<Vec<T, D>> points;
    for (int i = 0; i < 200; ++i) points.push_back(random_outside(handles, random));
    const auto states = evaluate_all(coordinates, points).states;
    std::size_t outside = 0;
    for (std::size_t i = 0; i < states.size(); ++i) {
        CAPTURE(i, double(points[i][0]), double(points[i][1]), int(states[i]));
        CHECK((states[i] == PointState::outside || states[i] == PointState::unreached));
        outside += states[i] == PointState::outside;
    }
    CHECK(outside >= states.size() / 2);
}

/// Restored weights have linear precision no worse than those left alone, and where more than rounding is
/// missed, the report says so.
template <class T, std::size_t D, class Result>
void check_restored(const Result& left, const Result& restored, std::span<const Vec<T, D>> handles) {
    const auto row_of = [](const auto& binding, std::size_t i) {
        std::vector<T> row;
        for (std::size_t h = 0; h < binding.handle_count(); ++h) row.push_back(binding.weight(i, h));
        return row;
    };
    const double eps = double(cageform::epsilon<T>);
    const auto& listed = restored.report.not_restored;
    CHECK(left.report.not_restored.empty());
    CHECK(std::is_sorted(listed.begin(), listed.end()));
    for (std::size_t i = 0; i < left.value.point_count(); ++i) {
        const auto before = row_of(left.value, i), after = row_of(restored.value, i);
        const auto p = left.value.rest_point(i);
        // The library measures in the scalar itself.
        const double rounding = 2 * double(handles.size()) * eps * (absolute_sum(before) + 1);
        const double missed = affine_residual(after, handles, p);
        CAPTURE(i, text(before), text(after), affine_residual(before, handles, p), rounding);
        CHECK(missed <= affine_residual(before, handles, p) + rounding);
        const double far =
            std::max(1.0, distance(p, handles[0]) / double(cageform::bounds_of(handles).diagonal()));
        if (missed > 128 * eps * far + rounding) CHECK(std::binary_search(listed.begin(), listed.end(), i));
    }
}

} // namespace cageform_tests

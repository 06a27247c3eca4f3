// Batches of weights as plain rows, sums over them in long double, and the random figures they are
// tested on.
#pragma once

#include "cages.hpp"
#include "larger.hpp"

#include <cageform/coordinates/coordinate.hpp>

#include <algorithm>
#include <string>

namespace cageform_tests {

using cageform::PointState;
using cageform::Status;

/// The result of `evaluate` for a batch of points.
template <class T>
struct Weights {
    cageform::Evaluation evaluation;
    std::vector<PointState> states;
    std::vector<std::vector<T>> rows; ///< [point][handle]

    Status status() const { return evaluation.status; }
};

/// Evaluates a whole batch at once, in buffers exactly as long as the concept promises.
template <cageform::CageCoordinates C, cageform::PointRange R>
Weights<typename C::scalar> evaluate_all(const C& coordinates, const R& points,
                                         const cageform::Running& options = {}) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    const std::size_t count = std::size(points);
    const std::size_t handles = coordinates.handles().size();
    const std::size_t blocks = cageform::block_count<T>(count);
    std::vector<cageform::Lanes<T>> position(blocks * D), weights(blocks * handles);
    const cageform::BlockView<T> places{position.data(), D, count};
    const cageform::BlockView<T> table{weights.data(), handles, count};
    Weights<T> result;
    result.states.assign(count, PointState::unreached);
    for (std::size_t i = 0; i < blocks * cageform::lane_count<T>; ++i) {
        const auto p = cageform::to_vec<T>(points[std::min(i, count - 1)]);
        if (i < count && !cageform::is_finite(p)) result.states[i] = PointState::not_finite;
        for (std::size_t k = 0; k < D; ++k) places(i, k) = p[k];
    }
    result.evaluation = coordinates.evaluate(places, table, result.states, options);
    if (result.status() != Status::ok) return result;
    for (std::size_t i = 0; i < count; ++i) {
        std::vector<T> row;
        for (std::size_t h = 0; h < handles; ++h) row.push_back(table(i, h));
        result.rows.push_back(std::move(row));
    }
    return result;
}

/// Returns the rest positions of the handles that are points.
template <class C>
auto corners_of(const C& coordinates) {
    const auto handles = cageform::handle_view(coordinates);
    std::vector<Vec<typename C::scalar, C::dimension>> corners;
    for (std::size_t i = 0; i < handles.count; ++i) {
        if (handles.is_point(i)) corners.push_back(handles.rest[i]);
    }
    return corners;
}

template <class Row>
long double sum_of(const Row& row) {
    long double sum = 0;
    for (const auto w : row) sum += static_cast<long double>(w);
    return sum;
}

/// Σ w_i c_i.
template <class Row, cageform::PointRange R>
auto combine(const Row& row, const R& handles) {
    Vec<long double, cageform::range_dimension<R>> sum{};
    for (std::size_t i = 0; i < std::size(handles); ++i) {
        sum = sum + static_cast<long double>(row[i]) * cageform::to_vec<long double>(handles[i]);
    }
    return sum;
}

/// The distance of two points of whatever types.
template <cageform::Point P, cageform::Point Q>
double distance(const P& p, const Q& q) {
    const auto d = cageform::to_vec<long double>(p) - cageform::to_vec<long double>(q);
    return double(std::sqrt(cageform::dot(d, d)));
}

/// The largest difference of two rows.
template <class A, class B>
double difference(const A& a, const B& b) {
    long double worst = a.size() == b.size() ? 0 : 1e9L;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        const auto d = std::fabs(static_cast<long double>(a[i]) - static_cast<long double>(b[i]));
        worst = larger(worst, d); // keeps a NaN
    }
    return double(worst);
}

/// Σ |w_i|: 1 for non-negative weights; what their rounding is relative to.
template <class Row>
double absolute_sum(const Row& row) {
    double sum = 0;
    for (const auto w : row) sum += std::fabs(double(w));
    return sum;
}

/// The size that rounding is relative to: diagonal plus largest coordinate.
template <cageform::PointRange R>
double size_of(const R& points) {
    constexpr std::size_t D = cageform::range_dimension<R>;
    std::vector<Vec<double, D>> copy;
    for (std::size_t i = 0; i < std::size(points); ++i) copy.push_back(cageform::to_vec<double>(points[i]));
    const auto bounds = cageform::bounds_of(std::span<const Vec<double, D>>(copy));
    return bounds.diagonal() + bounds.magnitude();
}

/// A row as text, for CAPTURE.
template <class Row>
std::string text(const Row& row) {
    std::string s;
    for (const auto w : row) s += std::to_string(double(w)) + " ";
    return s;
}

/// x ↦ A x + b, applied in long double.
template <std::size_t D>
struct AffineMap {
    Vec<Vec<double, D>, D> rows{};
    Vec<double, D> shift{};

    template <class T>
    Vec<T, D> operator()(const Vec<T, D>& p) const {
        Vec<T, D> r{};
        for (std::size_t k = 0; k < D; ++k) {
            long double x = static_cast<long double>(shift[k]);
            for (std::size_t c = 0; c < D; ++c)
                x += static_cast<long double>(rows[k][c]) * static_cast<long double>(p[c]);
            r[k] = static_cast<T>(x);
        }
        return r;
    }
    template <class T>
    std::vector<Vec<T, D>> operator()(std::span<const Vec<T, D>> points) const {
        std::vector<Vec<T, D>> result;
        for (const auto& p : points) result.push_back((*this)(p));
        return result;
    }
};

/// Entries in [-2, 2], mirrored as often as not; `shift` is the largest move.
template <std::size_t D>
AffineMap<D> random_affine(Random& random, double shift) {
    AffineMap<D> map;
    for (std::size_t k = 0; k < D; ++k) {
        for (std::size_t c = 0; c < D; ++c) map.rows[k][c] = random.uniform(-2, 2);
        map.shift[k] = random.uniform(-shift, shift);
    }
    return map;
}

/// A simplex with sides of 10^-3 … 10^3, far from degenerate, of either orientation.
template <class T, std::size_t D>
std::vector<Vec<T, D>> random_simplex(std::uint64_t seed) {
    Random random(seed);
    const double scale = std::pow(10.0, random.uniform(-3, 3));
    Vec<double, D> centre{};
    for (std::size_t k = 0; k < D; ++k) centre[k] = scale * random.uniform(-2, 2);
    std::vector<Vec<T, D>> corners;
    for (std::size_t i = 0; i <= D; ++i) {
        // The standard simplex, its corners shaken by less than its inner radius, and sheared.
        Vec<double, D> c{};
        for (std::size_t k = 0; k < D; ++k) c[k] = (i == k + 1 ? 1.0 : 0.0) + random.uniform(-0.05, 0.05);
        for (std::size_t k = 1; k < D; ++k) c[k] += 0.5 * c[k - 1];
        corners.push_back(cageform::vec_cast<T>(centre + scale * c));
    }
    if (seed % 2 == 1) std::swap(corners[0], corners[D]);
    return corners;
}

/// Positive weights that sum to 1, for points inside a simplex.
inline std::vector<double> random_shares(std::size_t count, Random& random) {
    std::vector<double> shares(count);
    double sum = 0;
    for (double& s : shares) sum += s = -std::log(1 - random.uniform(0, 1) * (1 - 1e-9)) + 1e-3;
    for (double& s : shares) s /= sum;
    return shares;
}

/// One to four loops within each other, outline, hole, island, hole, each turning either way.
template <class T>
cageform::Polygon<T> random_rings(std::uint64_t seed) {
    Random random(seed);
    const std::size_t count = 3 + random.below(12), rings = 1 + random.below(4);
    const double scale = std::pow(10.0, random.uniform(-3, 3));
    const Vec<double, 2> centre{random.uniform(-2, 2) * scale, random.uniform(-2, 2) * scale};
    std::vector<Vec<double, 2>> outline;
    for (std::size_t i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * (double(i) + random.uniform(-0.3, 0.3)) / double(count);
        const double radius = scale * random.uniform(0.3, 1.0);
        outline.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    Points2<T> vertices;
    double factor = 1;
    for (std::size_t ring = 0; ring < rings; ++ring) {
        const bool back = random.below(2) == 1;
        for (std::size_t i = 0; i < count; ++i) {
            vertices.push_back(cageform::vec_cast<T>(centre + factor * outline[back ? count - 1 - i : i]));
        }
        factor *= random.uniform(0.4, 0.8);
    }
    return {vertices, std::vector<std::size_t>(rings, count)};
}

/// A place on edge `edge` (numbered in the order of the vertices), `s` of the way along.
template <class T>
struct OnEdge {
    std::size_t i, j;
    Vec<T, 2> position;
};
template <class T>
OnEdge<T> on_edge(const cageform::Polygon<T>& cage, std::size_t edge, double s) {
    OnEdge<T> result{};
    cage.for_each_edge([&](std::size_t i, std::size_t j) {
        if (i != edge) return;
        const auto a = cageform::vec_cast<long double>(cage[i]), b = cageform::vec_cast<long double>(cage[j]);
        const auto t = static_cast<long double>(s);
        result = {i, j, cageform::vec_cast<T>((1 - t) * a + t * b)};
    });
    return result;
}

} // namespace cageform_tests

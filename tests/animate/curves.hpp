// Bézier curves for tests: the source's ten and random ones; references for fits.
#pragma once

#include "support/cages.hpp"
#include "support/larger.hpp"

#include <cageform/animate/fit.hpp>

#include <Eigen/Dense>

#include <string>

namespace cageform_tests {

using cageform::BezierCurve;
using cageform::BezierFit;
using cageform::FitCondition;
using cageform::FitOptions;
using cageform::SobolevFitter;
using cageform::Status;

inline BezierCurve bezier(double u1, double y1, double u2, double y2) {
    return {{{{0, 0}, {u1, y1}, {u2, y2}, {1, 1}}}};
}

/// The ten test curves of the source, as recovered (specification, 8.1).
inline const std::array<BezierCurve, 10> test_curves{
    bezier(0.65, 1, 0.80, 1),     bezier(0.20, 1, 0.25, 1),     bezier(0.80, 1, 0.20, 1),
    bezier(0.40, 0, 0.60, 1),     bezier(0.85, 0, 0.15, 1),     bezier(0.20, 1, 0.80, 0),
    bezier(0.80, 1, 0.20, 0),     bezier(0.20, 1.3, 0.80, 1.3), bezier(0.80, 1.3, 0.20, 1.3),
    bezier(0.80, -0.3, 0.20, 1.3)};

/// The 27 configurations of the source's Table 6.1, I first.
inline const std::array<FitCondition, 27> configurations = [] {
    using enum FitCondition;
    const auto c0 = end_value | knot_c0, value = end_value | knot_value;
    return std::array{none,
                      c0,
                      value,
                      c0 | knot_c1,
                      value | knot_c1,
                      c0 | knot_d1,
                      value | knot_d1,
                      c0 | knot_c1 | knot_c2,
                      value | knot_c1 | knot_c2,
                      c0 | knot_c1 | knot_d2,
                      c0 | knot_d1 | knot_c2,
                      c0 | end_d1,
                      value | end_d1,
                      c0 | end_d1 | end_d2,
                      value | end_d1 | end_d2,
                      c0 | end_d1 | knot_c1,
                      value | end_d1 | knot_c1,
                      c0 | end_d1 | knot_d1,
                      value | end_d1 | knot_d1,
                      c0 | end_d1 | knot_c1 | end_d2,
                      value | end_d1 | knot_c1 | end_d2,
                      c0 | end_d1 | knot_d1 | end_d2,
                      c0 | end_d1 | knot_c1 | knot_c2,
                      value | end_d1 | knot_c1 | knot_c2,
                      c0 | end_d1 | knot_c1 | knot_d2,
                      c0 | end_d1 | knot_d1 | knot_c2,
                      c0 | end_d1 | knot_c1 | end_d2 | knot_c2};
}();
/// By their Roman number.
inline FitCondition configuration(std::size_t number) {
    return configurations[number - 1];
}

/// Whether time is monotone for handles at these fractions, by the specification's closed condition.
inline bool admissible(double u1, double u2) {
    return u1 >= 0 && u2 <= 1 && (u2 >= u1 || (u1 - u2) * (u1 - u2) <= u1 * (1 - u2));
}

/// A curve between (0, 0) and (1, 1), handles `margin` within the admissible region.
inline BezierCurve random_normal_curve(Random& random, double margin = 0.02) {
    for (;;) {
        const double u1 = random.uniform(-0.4, 1.4), u2 = random.uniform(-0.4, 1.4);
        if (!admissible(u1 - margin, u2 + margin) || !admissible(u1 + margin, u2 - margin) ||
            !admissible(u1, u2) || u1 < margin || u2 > 1 - margin)
            continue;
        return bezier(u1, random.uniform(-1, 2), u2, random.uniform(-1, 2));
    }
}

/// The image of a curve: x ↦ begin + length x, y ↦ value + height y.
inline BezierCurve moved(BezierCurve curve, double begin, double length, double value, double height) {
    for (auto& p : curve.points) p = {begin + length * p[0], value + height * p[1]};
    return curve;
}
/// A random curve of random position and size (10^-2 … 10^2).
inline BezierCurve random_curve(Random& random, double margin = 0.02) {
    const double length = std::pow(10.0, random.uniform(-2, 2)),
                 height = std::pow(10.0, random.uniform(-2, 2));
    return moved(random_normal_curve(random, margin), length * random.uniform(-3, 3), length,
                 height * random.uniform(-3, 3), random.below(2) == 0 ? height : -height);
}

/// The axis-wise map of a curve to keys at (0, 0) and (1, 1), and back. Where both keys have the same
/// value, time is added to the value instead, which changes no error of a fit.
struct NormalForm {
    BezierCurve curve;
    double begin = 0, length = 1; ///< of time
    double value = 0, height = 1; ///< of the first key, and from it to the second; 1 where they are equal
    bool sheared = false;

    /// A value of the original from a time (in [0, 1]) and value of the normal form.
    double value_of(double part, double y) const noexcept {
        return value + height * (sheared ? y - part : y);
    }
};

inline NormalForm normal_form(const BezierCurve& curve) noexcept {
    NormalForm form;
    form.begin = curve.begin();
    form.length = curve.end() - curve.begin();
    form.value = curve.points[0][1];
    form.sheared = curve.points[3][1] == curve.points[0][1];
    form.height = form.sheared ? 1 : curve.points[3][1] - curve.points[0][1];
    for (std::size_t i = 0; i < 4; ++i) {
        const double part = (curve.points[i][0] - form.begin) / form.length;
        const double y = (curve.points[i][1] - form.value) / form.height;
        form.curve.points[i] = {part, form.sheared ? y + part : y};
    }
    return form;
}

/// Ascending parameters from 0 to 1, neighbours at least half a uniform step apart.
inline std::vector<double> random_parameters(Random& random, std::size_t pieces) {
    std::vector<double> t(pieces + 1);
    for (std::size_t i = 0; i <= pieces; ++i)
        t[i] = (double(i) + (i == 0 || i == pieces ? 0 : random.uniform(-0.25, 0.25))) / double(pieces);
    return t;
}

/// The largest |y|; tolerances of coefficients are relative to it.
inline double height_of(const BezierCurve& curve) {
    double most = 0;
    for (const auto& p : curve.points) most = cageform_tests::larger(most, std::fabs(p[1]));
    return most;
}

/// Coordinates at a parameter by de Casteljau's steps in long double.
inline std::array<long double, 2> point_at(const BezierCurve& curve, long double t) {
    std::array<std::array<long double, 2>, 4> p{};
    for (std::size_t k = 0; k < 4; ++k) p[k] = {curve.points[k][0], curve.points[k][1]};
    for (std::size_t n = 3; n > 0; --n) {
        for (std::size_t k = 0; k < n; ++k) {
            for (std::size_t axis = 0; axis < 2; ++axis)
                p[k][axis] = (1 - t) * p[k][axis] + t * p[k + 1][axis];
        }
    }
    return p[0];
}

/// Derivatives of the coordinates by the parameter.
inline std::array<long double, 2> velocity_at(const BezierCurve& curve, long double t) {
    std::array<long double, 2> velocity{};
    for (std::size_t axis = 0; axis < 2; ++axis) {
        std::array<long double, 4> c{};
        for (std::size_t k = 0; k < 4; ++k) c[k] = curve.points[k][axis];
        velocity[axis] =
            3 * ((1 - t) * (1 - t) * (c[1] - c[0]) + 2 * t * (1 - t) * (c[2] - c[1]) + t * t * (c[3] - c[2]));
    }
    return velocity;
}

/// C, C' and C'' by time at a parameter, from the definitions, in long double.
inline std::array<long double, 3> derivatives_at(const BezierCurve& curve, long double t) {
    const auto p = point_at(curve, t);
    std::array<std::array<long double, 2>, 2> d{}; // first and second derivatives of x and y by t
    for (std::size_t axis = 0; axis < 2; ++axis) {
        std::array<long double, 4> c{};
        for (std::size_t k = 0; k < 4; ++k) c[k] = curve.points[k][axis];
        d[0][axis] =
            3 * ((1 - t) * (1 - t) * (c[1] - c[0]) + 2 * t * (1 - t) * (c[2] - c[1]) + t * t * (c[3] - c[2]));
        d[1][axis] = 6 * ((1 - t) * (c[2] - 2 * c[1] + c[0]) + t * (c[3] - 2 * c[2] + c[1]));
    }
    const auto [gx, gy] = d[0];
    return {p[1], gy / gx, (d[1][1] * gx - gy * d[1][0]) / (gx * gx * gx)};
}

/// A piece's polynomial and its slope at u in [0, 1], by de Casteljau's steps.
struct ValueAndSlope {
    long double value, slope;
};
inline ValueAndSlope piece_at(std::span<const double> coefficients, long double h, long double u) {
    std::vector<long double> b(coefficients.begin(), coefficients.end());
    const std::size_t d = b.size() - 1;
    for (std::size_t n = d; n > 1; --n) {
        for (std::size_t i = 0; i < n; ++i) b[i] = (1 - u) * b[i] + u * b[i + 1];
    }
    return {(1 - u) * b[0] + u * b[1], static_cast<long double>(d) * (b[1] - b[0]) / h};
}

/// Visits (t, weight of dx, piece, u) of a composite rule of the parameter: 48 panels of 16 nodes a piece.
template <class Visit>
void for_each_node(const BezierFit& fit, const BezierCurve& curve, const Visit& visit) {
    constexpr std::size_t panels = 48;
    const auto& rule = cageform::detail::Gauss<16>::rule();
    for (std::size_t i = 0; i < fit.pieces(); ++i) {
        const long double begin = fit.parameters[i], width = fit.parameters[i + 1] - fit.parameters[i];
        const long double x_begin = point_at(curve, begin)[0];
        const long double h = point_at(curve, begin + width)[0] - x_begin;
        for (std::size_t k = 0; k < panels; ++k) {
            for (std::size_t n = 0; n < 16; ++n) {
                const long double node = (static_cast<long double>(k) + rule.node[n]) / panels;
                const long double t = begin + width * node, gx = velocity_at(curve, t)[0];
                const long double u = (point_at(curve, t)[0] - x_begin) / h;
                visit(t, gx * width / panels * rule.weight[n], i, h, u);
            }
        }
    }
}

/// Errors of a fit by brute quadrature.
struct SlowErrors {
    double l2, slope;
};
inline SlowErrors slow_errors(const BezierFit& fit, const BezierCurve& curve) {
    long double l2 = 0, slope = 0;
    for_each_node(fit, curve,
                  [&](long double t, long double dx, std::size_t i, long double h, long double u) {
                      const auto c = derivatives_at(curve, t);
                      const auto f = piece_at(fit.coefficients(i), h, u);
                      l2 += dx * (c[0] - f.value) * (c[0] - f.value);
                      slope += dx * (c[1] - f.slope) * (c[1] - f.slope);
                  });
    return {double(std::sqrt(l2)), double(std::sqrt(slope))};
}

/// Rows A and right sides D of the conditions in the pieces' Bernstein coefficients, each row of length 1.
struct Conditions {
    Eigen::MatrixXd a;
    Eigen::VectorXd d;
};
inline Conditions conditions_of(const BezierFit& fit, const BezierCurve& curve, FitCondition conditions) {
    const std::size_t degree = fit.degree, count = fit.pieces(), size = (degree + 1) * count;
    std::vector<Eigen::RowVectorXd> rows;
    std::vector<double> right;
    // The derivative of one order of piece i at its left or right end, as a row.
    const auto derivative = [&](std::size_t order, std::size_t i, bool at_right) {
        Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(long(size));
        const double h = fit.knots[i + 1] - fit.knots[i], d = double(degree);
        const double scale = order == 0 ? 1 : order == 1 ? d / h : d * (d - 1) / (h * h);
        for (std::size_t k = 0; k <= order;
             ++k) { // forward differences from the left, backward from the right
            const double binomial = order == 2 && k == 1 ? 2 : 1;
            const double sign = (at_right ? k : order - k) % 2 == 0 ? 1 : -1;
            row(long(i * (degree + 1) + (at_right ? degree - k : k))) = sign * binomial * scale;
        }
        return row;
    };
    const auto add = [&](const Eigen::RowVectorXd& row, double value) {
        rows.push_back(row / row.norm());
        right.push_back(value / row.norm());
    };
    constexpr std::array orders{
        std::array{FitCondition::end_value, FitCondition::knot_c0, FitCondition::knot_value},
        std::array{FitCondition::end_d1, FitCondition::knot_c1, FitCondition::knot_d1},
        std::array{FitCondition::end_d2, FitCondition::knot_c2, FitCondition::knot_d2}};
    for (std::size_t order = 0; order < 3; ++order) {
        const auto of_curve = [&](double t) { return double(derivatives_at(curve, t)[order]); };
        if (contains(conditions, orders[order][0])) {
            add(derivative(order, 0, false), of_curve(0));
            add(derivative(order, count - 1, true), of_curve(1));
        }
        for (std::size_t i = 0; i + 1 < count; ++i) {
            const double c = of_curve(fit.parameters[i + 1]);
            if (contains(conditions, orders[order][1]))
                add(derivative(order, i, true) - derivative(order, i + 1, false), 0);
            if (contains(conditions, orders[order][2])) {
                add(derivative(order, i, true), c);
                add(derivative(order, i + 1, false), c);
            }
        }
    }
    Conditions result{Eigen::MatrixXd::Zero(long(rows.size()), long(size)),
                      Eigen::VectorXd::Zero(long(rows.size()))};
    for (std::size_t r = 0; r < rows.size(); ++r) {
        result.a.row(long(r)) = rows[r];
        result.d(long(r)) = right[r];
    }
    return result;
}

/// The largest |C − f| among samples of the parameter, and polished between the neighbours of the largest.
struct SampledError {
    double sampled = 0, polished = 0;
};
inline SampledError sampled_error(const BezierFit& fit, const BezierCurve& curve, std::size_t samples) {
    const cageform::BezierFunction function(curve);
    const std::size_t d = fit.degree;
    SampledError result;
    for (std::size_t i = 0; i < fit.pieces(); ++i) {
        const double h = (fit.knots[i + 1] - fit.knots[i]) / function.length();
        const double begin = fit.parameters[i], width = fit.parameters[i + 1] - begin;
        const double x_begin = begin == 0 ? 0 : function.time()(begin);
        const auto b = fit.coefficients(i);
        const auto error = [&](double v) {
            const double t = begin + width * v, u = (function.time()(t) - x_begin) / h;
            std::array<double, 6> c{};
            for (std::size_t k = 0; k <= d; ++k) c[k] = b[k] - curve.points[0][1];
            for (std::size_t n = d; n > 0; --n) {
                for (std::size_t k = 0; k < n; ++k) c[k] += u * (c[k + 1] - c[k]);
            }
            return std::fabs(function.value()(t) - c[0]);
        };
        const std::size_t count = samples / fit.pieces();
        std::size_t at = 0;
        double most = -1;
        for (std::size_t n = 0; n <= count; ++n) {
            const double e = error(double(n) / double(count));
            if (e <= most) continue;
            most = e;
            at = n;
        }
        double low = (double(at) - 1) / double(count), high = (double(at) + 1) / double(count);
        low = cageform_tests::larger(low, 0.0);
        high = std::min(high, 1.0);
        result.sampled = cageform_tests::larger(result.sampled, most);
        for (int step = 0; step < 60; ++step) { // golden sections
            const double a = high - 0.6180339887498949 * (high - low),
                         c = low + 0.6180339887498949 * (high - low);
            const double ea = error(a), ec = error(c);
            most = std::max({most, ea, ec});
            (ea < ec ? low : high) = ea < ec ? a : c;
        }
        result.polished = cageform_tests::larger(result.polished, most);
    }
    return result;
}

} // namespace cageform_tests

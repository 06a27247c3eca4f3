// A fit in normalised units: time runs from 0 to 1; values are relative to the first key and at most 1.
#pragma once

#include <cageform/animate/curves/bezier.hpp>
#include <cageform/animate/fit/fit_options.hpp>
#include <cageform/core/detail/bernstein.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// One polynomial on its own interval.
struct FitPiece {
    double begin = 0, end = 1;     ///< parameters of the curve
    double x_begin = 0, x_end = 1; ///< the same interval in normalised time
    Bernstein polynomial;
    bool solved = false;

    double length() const noexcept { return x_end - x_begin; }
};

/// The maximum number of coefficients of a piece, for degree 5.
inline constexpr std::size_t most_coefficients = 6;
using Coefficients = std::array<double, most_coefficients>;

/// Returns the power of two above the largest difference of the curve's values from the first key's. In
/// this unit squares neither overflow nor underflow, and the division is exact.
inline double value_unit(const BezierCurve& curve) noexcept {
    double largest = 0;
    for (const auto& p : curve.points) largest = std::fmax(largest, std::fabs(p[1] - curve.points[0][1]));
    if (largest == 0 || !is_finite(largest)) return 1;
    int exponent = 0;
    (void)std::frexp(largest, &exponent);
    return std::ldexp(1.0, exponent < -1000 ? -1000 : exponent);
}
inline BezierCurve in_value_unit(BezierCurve curve) noexcept {
    const double unit = value_unit(curve);
    for (auto& p : curve.points) p[1] /= unit;
    return curve;
}

/// The curve, which must pass `check`, and the options of its fit, in normalised units.
struct FitProblem {
    double unit; ///< the unit of the values
    BezierFunction function;
    FitOptions options; ///< with the weights in normalised units
    bool vertical;      ///< the curve has a vertical tangent somewhere

    FitProblem(const BezierCurve& curve, const FitOptions& given) noexcept
        : unit(value_unit(curve))
        , function(in_value_unit(curve))
        , options(given)
        , vertical(check(curve).vertical_tangent) {
        if (given.scale_free) return;
        options.value_weight *= function.length();
        options.slope_weight /= function.length();
    }

    bool has(FitCondition one) const noexcept { return contains(options.conditions, one); }

    FitPiece interval(double begin, double end) const noexcept {
        const auto& time = function.time();
        return {begin, end, begin == 0 ? 0 : time(begin), end == 1 ? 1 : time(end), {}, false};
    }

    /// Returns how many derivatives of a piece (0: value) equal the curve's at a key or an inner knot.
    std::size_t prescribed(bool at_key) const noexcept {
        const auto& conditions = at_key ? at_keys : at_knots;
        return 1 + std::size_t(has(conditions[1])) + std::size_t(has(conditions[2]));
    }

    /// The first `count` of C, C' and C'' by time at a parameter; returns false if one is unbounded.
    bool derivatives(double t, std::size_t count, std::array<double, 3>& c) const noexcept {
        const double length = function.length();
        c = {t == 1 ? function.curve().points[3][1] - function.curve().points[0][1] : function.value()(t), 0,
             0};
        // At an inner vertical tangent the derivative of time is 0 only up to thousands of rounding errors.
        constexpr double none = 1e-12;
        const double rise = std::fabs(function.value().slope(t));
        if (vertical && count > 1 && function.time().slope(t) <= none && rise > none * largest_value())
            return false;
        if (count > 1) c[1] = function.slope_at(t) * length;
        if (count > 2) c[2] = function.curvature_at(t) * length * length;
        return is_finite(c[1]) && is_finite(c[2]);
    }

    /// The largest absolute value of the control points, relative to the first key.
    double largest_value() const noexcept {
        double largest = 0;
        for (const auto& p : function.curve().points)
            largest = std::fmax(largest, std::fabs(p[1] - function.curve().points[0][1]));
        return largest;
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail

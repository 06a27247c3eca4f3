// A cubic Bézier curve as a function of time: the interval between two keys.
#pragma once

#include <cageform/core/status.hpp>
#include <cageform/core/vec.hpp>

#include <array>
#include <cmath>
#include <limits>

namespace cageform::inline CAGEFORM_ABI {

/// Keys `points[0]` and `points[3]`, with their handles between them; axis 0 is time, axis 1 the
/// value. The curve is a function of time if time never decreases along it; see `check`.
struct BezierCurve {
    std::array<Vec<double, 2>, 4> points;

    double begin() const noexcept { return points[0][0]; }
    double end() const noexcept { return points[3][0]; }

    friend bool operator==(const BezierCurve&, const BezierCurve&) = default;
};

/// The result of `check`. `status` is ok or
///   value_not_finite     a coordinate is NaN or infinite
///   interval_empty       the second key is not at least 1e-308 later than the first
///   time_not_monotone    time decreases somewhere between the keys
struct BezierCheck {
    Status status = Status::ok;
    /// The slope is unbounded somewhere, except at a key whose handle coincides with it.
    bool vertical_tangent = false;
};

namespace detail {

/// The coefficients of t, t², t³ for a coordinate of a curve, relative to the first key.
struct PowerForm {
    double c1 = 0, c2 = 0, c3 = 0;
    double last = 0; ///< the last key minus the last handle: exactly a third of the slope there

    double operator()(double t) const noexcept { return ((c3 * t + c2) * t + c1) * t; }
    double slope(double t) const noexcept {
        return (1 - t) * ((1 - t) * c1 + 2 * t * (c1 + c2)) + 3 * last * t * t;
    }
    double curvature(double t) const noexcept { return 6 * c3 * t + 2 * c2; }
};

/// The power form of a coordinate times `scale`.
inline PowerForm power_form(const BezierCurve& curve, std::size_t axis, double scale) noexcept {
    // Uses differences of neighbours, which keeps precision far from the origin.
    std::array<double, 3> step{};
    for (std::size_t k = 0; k < 3; ++k) step[k] = scale * (curve.points[k + 1][axis] - curve.points[k][axis]);
    return {3 * step[0], 3 * (step[1] - step[0]), step[0] - 2 * step[1] + step[2], step[2]};
}

} // namespace detail

/// Checks that time never decreases. u1 and u2 are the handles' times as fractions of the interval.
/// Time is monotone if u1 ≥ 0, u2 ≤ 1, and u1 ≤ u2 or (u1 − u2)² ≤ u1 (1 − u2): the derivative of time,
/// a quadratic, then has no sign change in (0, 1).
inline BezierCheck check(const BezierCurve& curve) noexcept {
    BezierCheck result;
    for (const auto& p : curve.points) {
        if (!is_finite(p)) result.status = Status::value_not_finite;
    }
    if (result.status != Status::ok) return result;
    const double length = curve.end() - curve.begin();
    if (!(length > 0) || !is_finite(length) || !is_finite(1 / length)) {
        result.status = Status::interval_empty;
        return result;
    }
    constexpr double rounding = 4 * epsilon<double>; // relative to the terms compared, about 1
    const double u1 = (curve.points[1][0] - curve.begin()) / length;
    const double rest = (curve.end() - curve.points[2][0]) / length; // 1 - u2
    const double between = 1 - u1 - rest;                            // u2 - u1
    const double outside_ellipse = between * between - u1 * rest;
    const bool decreases = u1 < 0 || rest < 0 || (between < 0 && !(outside_ellipse <= rounding));
    if (decreases) result.status = Status::time_not_monotone;
    result.vertical_tangent = u1 == 0 || rest == 0 || (between < 0 && outside_ellipse >= -rounding);
    return result;
}

/// A checked curve as a function of time: Newton's method safeguarded by bisection, which also handles
/// vertical tangents. The reference for all other evaluations.
///
///   accuracy  time: a rounding error of the interval's length; value: the error that this causes
///   cost      tens of nanoseconds
class BezierFunction {
public:
    explicit BezierFunction(const BezierCurve& curve) noexcept
        : curve_(curve)
        , length_(curve.end() - curve.begin())
        , time_(detail::power_form(curve, 0, 1 / length_))
        , value_(detail::power_form(curve, 1, 1)) {}

    /// Returns the curve's parameter, in [0, 1], at a time; the time is clamped to the interval.
    double parameter(double x) const noexcept {
        const double fraction = std::fmin(std::fmax((x - curve_.begin()) / length_, 0.0), 1.0);
        return parameter_at_fraction(fraction);
    }
    double operator()(double x) const noexcept {
        // Relative to the nearer end, so that both keys are exact.
        const double t = parameter(x);
        return t < 1 ? curve_.points[0][1] + value_(t) : curve_.points[3][1];
    }
    /// Returns the derivative by time: infinite at a vertical tangent; the limit at a key that
    /// coincides with its handle.
    double derivative(double x) const noexcept { return slope_at(parameter(x)); }

    /// The first and second derivatives by time, at a parameter.
    double slope_at(double t) const noexcept {
        const double g = time_.slope(t), f = value_.slope(t);
        if (g == 0 && f == 0) {
            const double g2 = time_.curvature(t), f2 = value_.curvature(t);
            // Both handles lie on this key: the curve is a straight line.
            if (g2 == 0 && f2 == 0) return value_.c3 / time_.c3 / length_;
            // Vertical: near an end t0, the derivative of time is of order (t - t0)², and of the
            // value f2 (t - t0).
            if (g2 == 0) return std::copysign(std::numeric_limits<double>::infinity(), t < 0.5 ? f2 : -f2);
            return f2 / g2 / length_;
        }
        return f / g / length_;
    }
    double curvature_at(double t) const noexcept {
        const double g = time_.slope(t), f = value_.slope(t);
        return (value_.curvature(t) * g - f * time_.curvature(t)) / (g * g * g) / (length_ * length_);
    }

    const BezierCurve& curve() const noexcept { return curve_; }
    double length() const noexcept { return length_; }               ///< of the interval
    const detail::PowerForm& time() const noexcept { return time_; } ///< scaled to run from 0 to 1
    const detail::PowerForm& value() const noexcept { return value_; }

    /// Returns the parameter at a fraction of the interval's time, in [0, 1].
    double parameter_at_fraction(double fraction) const noexcept {
        if (fraction <= 0) return 0;
        if (fraction >= 1) return 1;
        double low = 0, high = 1, t = fraction;
        for (int step = 0; step < 100; ++step) {
            const double miss = time_(t) - fraction;
            if (miss == 0) return t;
            (miss < 0 ? low : high) = t;
            const double slope = time_.slope(t);
            double next = t - miss / slope;
            if (!(next > low && next < high)) next = 0.5 * (low + high);
            if (std::fabs(next - t) <= 0.5 * epsilon<double> * t || next == low || next == high) return next;
            t = next;
        }
        return t;
    }

private:
    BezierCurve curve_;
    double length_;
    detail::PowerForm time_, value_;
};

} // namespace cageform::inline CAGEFORM_ABI

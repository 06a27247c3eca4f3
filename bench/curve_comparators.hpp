// Peers of the library's curves: other evaluators of Bézier curves, and the paper's search for a knot.
#pragma once

#include <cageform/animate/fit/knots.hpp>

namespace cageform_bench {

using namespace cageform;

/// Newton's method as in OpenGEX (starts from linear interpolation, without bounds), to a tolerance of the
/// curve parameter. Fast on tame curves, wrong next to vertical tangents.
class NewtonFunction {
public:
    explicit NewtonFunction(const BezierCurve& curve, double tolerance = 1e-6) noexcept
        : function_(curve)
        , tolerance_(tolerance) {}

    double operator()(double x) const noexcept {
        const auto& time = function_.time();
        const double part = (x - function_.curve().begin()) / function_.length();
        double t = part;
        for (int step = 0; step < 32; ++step) {
            const double change = (time(t) - part) / time.slope(t);
            t -= change;
            if (std::fabs(change) <= tolerance_) break;
        }
        return function_.curve().points[0][1] + function_.value()(t);
    }

private:
    BezierFunction function_;
    double tolerance_;
};

/// Closed-form inverse of time by one of six families: linear, square root, cube root, sinh, cosh and cos.
/// The last two may alternate along a curve. Inaccurate for small cubic coefficients of time (1e-4 occurs),
/// so not a reference.
class ClosedFormFunction {
public:
    explicit ClosedFormFunction(const BezierCurve& curve) noexcept
        : function_(curve) {
        const double a = function_.time().c3, b = function_.time().c2, c = function_.time().c1;
        constexpr double none = 1e-14; // rounding of coefficients of time in [0, 1]
        if (std::fabs(a) <= none) {
            family_ = std::fabs(b) <= none ? Family::linear : Family::square_root;
            return;
        }
        centre_ = -b / (3 * a);
        const double p = (3 * a * c - b * b) / (3 * a * a);
        q_ = (2 * b * b * b - 9 * a * b * c) / (27 * a * a * a);
        if (p == 0) {
            family_ = Family::cube_root;
            return;
        }
        family_ = p > 0 ? Family::sinh : Family::cosh_or_cos;
        amplitude_ = p > 0 ? -2 * std::sqrt(p / 3) : 2 * std::sqrt(-p / 3);
        scale_ = p > 0 ? -3 / (amplitude_ * p) : 3 / (amplitude_ * p);
        if (a < 0) {
            turns_ = 1;
        } else {
            turns_ = centre_ <= 0.5 ? 0 : 2;
        }
    }

    double parameter(double x) const noexcept {
        const double a = function_.time().c3, b = function_.time().c2, c = function_.time().c1;
        const double part = (x - function_.curve().begin()) / function_.length();
        switch (family_) {
        case Family::linear: return part / c;
        case Family::square_root:
            return -c / (2 * b) + std::copysign(std::sqrt(std::fmax(part / b + c * c / (4 * b * b), 0.0)), b);
        case Family::cube_root: return centre_ + std::cbrt(part / a - q_);
        case Family::sinh: return centre_ + amplitude_ * std::sinh(std::asinh(scale_ * (q_ - part / a)) / 3);
        case Family::cosh_or_cos: break;
        }
        const double z = scale_ * (q_ - part / a);
        if (std::fabs(z) > 1)
            return centre_ + std::copysign(amplitude_ * std::cosh(std::acosh(std::fabs(z)) / 3), z);
        constexpr double turn = 6.283185307179586;
        return centre_ + amplitude_ * std::cos((std::acos(z) - turn * turns_) / 3);
    }
    double operator()(double x) const noexcept {
        return function_.curve().points[0][1] + function_.value()(parameter(x));
    }

private:
    enum class Family : std::uint8_t { linear, square_root, cube_root, sinh, cosh_or_cos };

    BezierFunction function_;
    Family family_ = Family::linear;
    double centre_ = 0, q_ = 0, amplitude_ = 0, scale_ = 0, turns_ = 0;
};

/// The paper's heuristic for two pieces (Algorithm 4). Takes the best of `steps` equal time steps, then of as
/// many between its neighbours. Stops when the weighted error is accepted, or after `rounds` rounds.
inline Result<BestKnots, KnotReport> refine_knot(const BezierCurve& curve, std::size_t steps,
                                                 const FitOptions& options = {}, double accepted_error = 0,
                                                 std::size_t rounds = 8) {
    const SobolevFitter fitter(curve, options);
    Result<BestKnots, KnotReport> search;
    search.report.status = fitter.status();
    if (!search) return search;
    double low = 0, high = 1;
    for (std::size_t round = 0;
         round < rounds && std::sqrt(std::fmax(search.report.objective, 0.0)) > accepted_error; ++round) {
        double best = 0.5 * (low + high), least = std::numeric_limits<double>::infinity();
        for (std::size_t i = 1; i < steps; ++i) {
            const double part = low + (high - low) * double(i) / double(steps);
            const std::array<double, 3> parameters{0, BezierFunction(curve).parameter_at_fraction(part), 1};
            const double objective = fitter.objective(parameters);
            ++search.report.trials;
            if (objective >= least) continue;
            least = objective;
            best = part;
            search.value.parameters.assign(parameters.begin(), parameters.end());
        }
        search.report.objective = least;
        const double step = (high - low) / double(steps);
        low = best - step;
        high = best + step;
    }
    if (search.value.parameters.empty()) search.report.status = Status::too_many_conditions;
    return search;
}

} // namespace cageform_bench

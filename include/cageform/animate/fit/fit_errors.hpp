// The errors of a fitted piece: L² error, slope error and maximum error.
#pragma once

#include <cageform/animate/fit/fit_problem.hpp>
#include <cageform/core/detail/gauss.hpp>

#include <algorithm>
#include <limits>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns a coordinate of the curve between two parameters, by its polar form (blossom).
inline Bernstein restricted(const PowerForm& p, double a, double b) noexcept {
    const auto polar = [&](double x, double y, double z) {
        return p.c1 * (x + y + z) / 3 + p.c2 * (x * y + y * z + z * x) / 3 + p.c3 * x * y * z;
    };
    return {3, {polar(a, a, a), polar(a, a, b), polar(a, b, b), polar(b, b, b)}};
}

/// Returns C − f on a piece, a polynomial in the curve's parameter scaled to [0, 1] on the piece.
inline Bernstein residual(const FitProblem& problem, const FitPiece& piece) noexcept {
    Bernstein u = restricted(problem.function.time(), piece.begin, piece.end), rest{3, {}};
    for (std::size_t k = 1; k < 3; ++k) u.c[k] = (u.c[k] - piece.x_begin) / piece.length();
    u.c[0] = 0;
    u.c[3] = 1;
    for (std::size_t k = 0; k < 4; ++k) rest.c[k] = 1 - u.c[k];
    // Composes the piece's polynomial with u, by de Casteljau's algorithm on polynomials.
    const std::size_t d = problem.options.degree;
    std::array<Bernstein, most_coefficients> b;
    for (std::size_t i = 0; i <= d; ++i) b[i].c[0] = -piece.polynomial.c[i];
    for (std::size_t n = d; n > 0; --n) {
        for (std::size_t i = 0; i < n; ++i) b[i] = rest * b[i] + u * b[i + 1];
    }
    return b[0] + elevated(restricted(problem.function.value(), piece.begin, piece.end), 3 * d);
}

/// The largest |C − f| on a piece, exact up to rounding.
inline double largest_error(const FitProblem& problem, const FitPiece& piece) noexcept {
    return largest_absolute(residual(problem, piece)).value;
}

/// The largest |C − f| at ten parameters of a piece: a lower bound of largest_error, rarely by more
/// than 5 %, and much faster.
inline double sampled_error(const FitProblem& problem, const FitPiece& piece) noexcept {
    const double h = piece.length();
    double largest = 0;
    for (const double v : {0.04, 0.12, 0.22, 0.34, 0.45, 0.55, 0.66, 0.78, 0.88, 0.96}) {
        const double t = piece.begin + v * (piece.end - piece.begin);
        const double u = (problem.function.time()(t) - piece.x_begin) / h;
        largest = std::fmax(largest, std::fabs(problem.function.value()(t) - piece.polynomial(u)));
    }
    return largest;
}

/// ∫ E² dx for the residual E. In the parameter, the integrand is a polynomial of degree 6 d + 2.
inline double l2_square(const FitProblem& problem, const FitPiece& piece, const Bernstein& error) {
    const double width = piece.end - piece.begin;
    const auto square = [&](double v) {
        const double e = error(v);
        return e * e * problem.function.time().slope(piece.begin + v * width) * width;
    };
    return problem.options.degree == 3 ? Gauss<11>::rule()(0, 1, square) : Gauss<17>::rule()(0, 1, square);
}

/// The two roots of the derivative of time; 1e300 if there are none.
struct TimeRoots {
    double re[2] = {1e300, 1e300}, im = 0;

    explicit TimeRoots(const PowerForm& time) noexcept {
        if (time.c3 != 0) {
            const double root = time.c2 * time.c2 - 3 * time.c1 * time.c3, middle = -time.c2 / (3 * time.c3);
            const double away = std::sqrt(std::fabs(root)) / (3 * std::fabs(time.c3));
            re[0] = root >= 0 ? middle - away : middle;
            re[1] = root >= 0 ? middle + away : middle;
            im = root >= 0 ? 0 : away;
        } else if (time.c2 != 0) {
            re[0] = re[1] = -time.c1 / (2 * time.c2);
        }
    }
    double distance(double t) const noexcept {
        return (std::min)(std::hypot(re[0] - t, im), std::hypot(re[1] - t, im));
    }
};

/// Whether the slope of the residual is unbounded: slope_at(t), its derivative by the parameter, is not
/// 0 at a root of the derivative of time.
template <class Slope>
bool slope_is_unbounded(const FitProblem& problem, const FitPiece& piece, const TimeRoots& roots,
                        const Slope& slope_at) {
    if (!problem.vertical) return false;
    const double middle = std::fabs(problem.function.value().slope(0.5)), scale = middle == 0 ? 1 : middle;
    for (const double t : roots.re) { // rounding may split a double root
        if (t < piece.begin - 1e-12 || t > piece.end + 1e-12 || roots.im > 1e-7) continue;
        if (std::fabs(slope_at(std::clamp(t, piece.begin, piece.end))) > 1e-9 * scale) return true;
    }
    return false;
}

/// ∫ (E'/x')² dx = ∫ E'²/x' dt for the residual E. The integrand is singular at the roots of x'. Panels
/// are halved until they are small relative to their distance from the roots.
inline double slope_square(const FitProblem& problem, const FitPiece& piece, const Bernstein& error) {
    const auto& time = problem.function.time();
    const auto slope = error.derivative();
    const double width = piece.end - piece.begin;
    const auto slope_at = [&](double t) { return slope((t - piece.begin) / width) / width; };
    const TimeRoots roots(time);
    if (slope_is_unbounded(problem, piece, roots, slope_at)) return std::numeric_limits<double>::infinity();
    const auto square = [&](double t) {
        const double e = slope_at(t), g = time.slope(t);
        return g > 0 ? e * e / g : 0.0;
    };
    struct Panel {
        double begin, end;
    };
    double sum = 0;
    std::vector<Panel> panels{{piece.begin, piece.end}};
    while (!panels.empty()) {
        const auto [begin, end] = panels.back();
        panels.pop_back();
        const double middle = 0.5 * (begin + end), radius = 0.5 * (end - begin);
        if (roots.distance(middle) >= 2 * radius || radius < 1e-14) {
            sum += Gauss<16>::rule()(begin, end, square);
        } else {
            panels.push_back({begin, middle});
            panels.push_back({middle, end});
        }
    }
    return sum;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// Minimises functions of one variable.
#pragma once

#include <cageform/config.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Minimises f on (low, high), starting at `at`, by parabolic interpolation if it converges,
/// otherwise by golden sections (Brent 1973, ch. 5).
template <class F>
double line_minimum(double low, double at, double high, double tolerance, const F& f) {
    constexpr double golden = 0.3819660112501051; // (3 − √5) / 2
    double best = at, second = at, third = at, f_best = f(at), f_second = f_best, f_third = f_best;
    double step = 0, before = 0;
    for (int round = 0; round < 60; ++round) {
        const double middle = 0.5 * (low + high);
        if (std::fabs(best - middle) <= 2 * tolerance - 0.5 * (high - low)) break;
        bool parabola = false;
        if (std::fabs(before) > tolerance) {
            const double r = (best - second) * (f_best - f_third), q0 = (best - third) * (f_best - f_second);
            double p = (best - third) * q0 - (best - second) * r, q = 2 * (q0 - r);
            if (q > 0) p = -p;
            q = std::fabs(q);
            if (std::fabs(p) < std::fabs(0.5 * q * before) && p > q * (low - best) && p < q * (high - best)) {
                before = step;
                step = p / q;
                parabola = true;
            }
        }
        if (!parabola) {
            before = best < middle ? high - best : low - best;
            step = golden * before;
        }
        const double next = best + (std::fabs(step) >= tolerance ? step : std::copysign(tolerance, step));
        const double f_next = f(next);
        if (f_next <= f_best) {
            (next < best ? high : low) = best;
            third = second;
            f_third = f_second;
            second = best;
            f_second = f_best;
            best = next;
            f_best = f_next;
        } else {
            (next < best ? low : high) = next;
            if (f_next <= f_second || second == best) {
                third = second;
                f_third = f_second;
                second = next;
                f_second = f_next;
            } else if (f_next <= f_third || third == best || third == second) {
                third = next;
                f_third = f_next;
            }
        }
    }
    return best;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

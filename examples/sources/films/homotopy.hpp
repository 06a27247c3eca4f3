#pragma once

// Regular homotopies of closed curves in the plane. Two closed regular curves are regularly homotopic if and
// only if their turning numbers are equal: H. Whitney, "On regular closed curves in the plane", Compositio
// Mathematica 4 (1937), 276–284, who attributes it to W. C. Graustein.

#include "svg/path.hpp"

#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <random>
#include <vector>

namespace cageform_sources {

using namespace cageform_support;

/// A curve of unit speed, given by the angle of its tangent at τ from 0 to 2π:
/// `turns` τ + Σ sines[j] sin (j + 1) τ + Σ cosines[j] cos (j + 1) τ. Homotopy subtracts the mean velocity,
/// which closes the curve.
struct TurningCurve {
    int turns = 1;
    std::vector<double> sines{}, cosines{};

    double angle(double tau) const {
        double sum = turns * tau;
        for (std::size_t j = 0; j < sines.size(); ++j) sum += sines[j] * std::sin(double(j + 1) * tau);
        for (std::size_t j = 0; j < cosines.size(); ++j) sum += cosines[j] * std::cos(double(j + 1) * tau);
        return sum;
    }
};

/// A curve with three random sines and three cosines. The j-th coefficients (j = 1, 2, 3) are uniform in
/// [−2/j, 2/j).
inline TurningCurve random_curve(int turns, unsigned seed) {
    std::mt19937 generator(seed);
    TurningCurve curve{turns};
    for (int j = 1; j <= 3; ++j) {
        for (auto* waves : {&curve.sines, &curve.cosines}) // no std distribution: equal on all platforms
            waves->push_back((double(generator()) / 2147483648.0 - 1) * 2 / j);
    }
    return curve;
}

/// A family of closed curves from one curve at s = 0 to another at s = 1.
///
/// If the turning numbers are equal, the angles are interpolated: θ_s = (1 − s) θ_0 + s θ_1. The curve is the
/// integral of e^{iθ_s} − m_s, where m_s is the mean of e^{iθ_s}. It is closed, and regular because
/// |m_s| < 1, unless θ_s is constant. Otherwise the velocities are interpolated, and the speed is 0 for some
/// s and τ.
class Homotopy {
public:
    using Complex = std::complex<double>;
    static constexpr std::size_t samples = 1024; // of τ: means are then exact up to rounding

    Homotopy(const TurningCurve& from, const TurningCurve& to)
        : curves_{from, to} {
        for (std::size_t k = 0; k <= samples; ++k) {
            from_.push_back(from.angle(tau(k)));
            to_.push_back(to.angle(tau(k)));
        }
        // Two curves of turning number 0 can cancel each other. The second one then starts at another τ.
        constexpr double enough = 0.05;
        if (!is_regular() || from.turns != 0 || least_speed().least >= enough) return;
        const std::vector<double> unmoved = to_;
        std::size_t best = 0;
        double most = 0;
        for (std::size_t places = 0; places < samples; places += samples / 16) {
            for (std::size_t k = 0; k <= samples; ++k) to_[k] = unmoved[(k + places) % samples];
            if (const double least = least_speed().least; least > most) {
                most = least;
                best = places;
            }
        }
        for (std::size_t k = 0; k <= samples; ++k) to_[k] = unmoved[(k + best) % samples];
        start_ = tau(best);
    }

    bool is_regular() const { return curves_[0].turns == curves_[1].turns; }
    double start() const { return start_; } // the τ at which the second curve starts

    static double tau(std::size_t k) { return 2 * std::numbers::pi * double(k) / samples; }

    /// The velocities at all samples; the last equals the first.
    std::vector<Complex> velocities(double s) const {
        std::vector<Complex> all(samples + 1);
        if (is_regular()) {
            for (std::size_t k = 0; k <= samples; ++k) all[k] = std::polar(1.0, angle(s, k));
            const Complex mean = mean_of(all);
            for (Complex& v : all) v -= mean;
        } else {
            const Complex from = mean_of_angles(from_), to = mean_of_angles(to_);
            for (std::size_t k = 0; k <= samples; ++k)
                all[k] = (1 - s) * (std::polar(1.0, from_[k]) - from) + s * (std::polar(1.0, to_[k]) - to);
        }
        return all;
    }

    /// The points of the curve, with mean 0; the last equals the first up to rounding.
    std::vector<Complex> points(double s) const {
        const auto v = velocities(s);
        std::vector<Complex> all{0};
        const double half = tau(1) / 2;
        for (std::size_t k = 1; k <= samples; ++k) all.push_back(all.back() + half * (v[k - 1] + v[k]));
        const Complex middle = mean_of(all);
        for (Complex& p : all) p -= middle;
        return all;
    }

    /// The angle of the velocity at all samples, in radians, without jumps of 2π.
    std::vector<double> angles(double s) const {
        const auto v = velocities(s);
        std::vector<double> all{std::arg(v[0])};
        for (std::size_t k = 1; k <= samples; ++k) all.push_back(all.back() + std::arg(v[k] / v[k - 1]));
        return all;
    }

    /// The turning number; meaningless if the speed is 0 somewhere.
    double turns(double s) const {
        const auto all = angles(s);
        return (all.back() - all.front()) / (2 * std::numbers::pi);
    }

    struct SpeedBound {
        double least = 0;          ///< lower bound of the speed for all s and τ; 0: not proved
        double reached = 1;        ///< minimum of 1 − |m_s| over the tested s
        std::size_t intervals = 0; ///< number of tested intervals of s
    };

    /// Bounds the speed of a regular homotopy from below by halving intervals of s. The speed is at least
    /// 1 − |m_s|, and |m_s| changes by at most the mean of |θ_1 − θ_0| times the change of s. An interval is
    /// final if its bound is at least 0.98 `reached`. If `reached` falls below 1e-6, the bound is 0.
    SpeedBound least_speed() const {
        double slope = 0;
        for (std::size_t k = 0; k < samples; ++k) slope += std::fabs(to_[k] - from_[k]) / samples;
        SpeedBound bound{1, 1, 0};
        struct Interval {
            double middle, half;
        };
        std::vector<Interval> open{{0.5, 0.5}};
        while (!open.empty()) {
            const auto [middle, half] = open.back();
            open.pop_back();
            ++bound.intervals;
            std::vector<Complex> all(samples);
            for (std::size_t k = 0; k < samples; ++k) all[k] = std::polar(1.0, angle(middle, k));
            Complex sum = 0;
            for (const Complex& v : all) sum += v;
            const double here = 1 - std::abs(sum) / samples;
            bound.reached = std::fmin(bound.reached, here);
            if (bound.reached < 1e-6) return {0, bound.reached, bound.intervals};
            const double least = here - slope * half;
            if (least >= 0.98 * bound.reached) {
                bound.least = std::fmin(bound.least, least);
                continue;
            }
            open.push_back({middle - half / 2, half / 2});
            open.push_back({middle + half / 2, half / 2});
        }
        return bound;
    }

    struct Stop {
        double s, tau, speed;
    };

    /// The points with speed 0 if the turning numbers differ. The angle between the velocities u_0 and u_1
    /// changes by 2π times the difference of the turning numbers. So the velocities are opposite at some τ,
    /// and interpolate to 0 at s = |u_0| / (|u_0| + |u_1|). Halves intervals of τ.
    std::vector<Stop> stops() const {
        const TurningCurve &from = curves_[0], &to = curves_[1];
        const Complex mean_from = mean_of_angles(from_), mean_to = mean_of_angles(to_);
        const auto pair = [&](double t) {
            return std::pair{std::polar(1.0, from.angle(t)) - mean_from,
                             std::polar(1.0, to.angle(t)) - mean_to};
        };
        const auto against = [&](double t) { // 0 if the velocities are parallel
            const auto [u, v] = pair(t);
            return std::imag(v * std::conj(u));
        };
        std::vector<Stop> all;
        for (std::size_t k = 0; k < samples; ++k) {
            const double shift = 0.3183; // a zero must not be an end of an interval
            double low = tau(k) + shift, high = tau(k + 1) + shift;
            const bool rises = against(low) < 0;
            if (rises == (against(high) < 0)) continue;
            for (int n = 0; n < 60; ++n) {
                const double middle = (low + high) / 2;
                ((against(middle) < 0) == rises ? low : high) = middle;
            }
            const auto [u, v] = pair(low);
            if (std::real(v * std::conj(u)) > 0) continue; // equal directions
            const double s = std::abs(u) / (std::abs(u) + std::abs(v));
            all.push_back({s, std::fmod(low, 2 * std::numbers::pi), std::abs((1 - s) * u + s * v)});
        }
        return all;
    }

private:
    double angle(double s, std::size_t k) const { return (1 - s) * from_[k] + s * to_[k]; }

    static Complex mean_of(const std::vector<Complex>& all) { // without the last, which equals the first
        Complex sum = 0;
        for (std::size_t k = 0; k < samples; ++k) sum += all[k];
        return sum / double(samples);
    }
    static Complex mean_of_angles(const std::vector<double>& angles) {
        std::vector<Complex> all;
        for (const double angle : angles) all.push_back(std::polar(1.0, angle));
        return mean_of(all);
    }

    std::array<TurningCurve, 2> curves_;
    std::vector<double> from_, to_;
    double start_ = 0;
};

} // namespace cageform_sources

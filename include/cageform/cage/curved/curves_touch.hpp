// Whether Bézier curves touch each other or themselves.
#pragma once

#include <cageform/cage/curved/plane_curve.hpp>
#include <cageform/cage/detail/primitives.hpp>
#include <cageform/core/detail/complex_roots.hpp>

#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Tests whether two curves come within a tolerance of each other. Halves both until boxes around their
/// pieces are apart or as small as the tolerance. The boxes are aligned with the chords of the pieces,
/// which separates nearly parallel curves in few steps.
class CurvesTouch {
public:
    explicit CurvesTouch(double tolerance)
        : tolerance_(tolerance) {}

    /// Ignores pairs of pieces that both lie within `radius` of one of the `exempt` points.
    bool operator()(const PlaneCurve& a, const PlaneCurve& b, std::span<const Vec<double, 2>> exempt,
                    double radius) {
        pairs_.clear();
        pairs_.push_back({a, b});
        std::size_t tested = 0;
        while (!pairs_.empty()) {
            const Pair pair = pairs_.back();
            pairs_.pop_back();
            if (are_apart(pair) || are_exempt(pair, exempt, radius)) continue;
            const double a_size = pair.a.bounds().diagonal(), b_size = pair.b.bounds().diagonal();
            if ((a_size <= tolerance_ && b_size <= tolerance_) || ++tested > most_pairs) return true;
            const bool splits_a = a_size > b_size;
            const auto [low, high] = (splits_a ? pair.a : pair.b).halves();
            for (const auto& half : {low, high})
                pairs_.push_back(splits_a ? Pair{half, pair.b} : Pair{pair.a, half});
        }
        return false;
    }

private:
    static constexpr std::size_t most_pairs = std::size_t{1} << 17;
    struct Pair {
        PlaneCurve a, b;
    };

    struct Range {
        double lower = (std::numeric_limits<double>::max)(), upper = std::numeric_limits<double>::lowest();
    };
    static Range along(const PlaneCurve& curve, const Vec<double, 2>& from,
                       const Vec<double, 2>& axis) noexcept {
        Range range;
        for (const auto& c : curve.points()) {
            const double x = dot(axis, c - from);
            range = {(std::min)(range.lower, x), (std::max)(range.upper, x)};
        }
        return range;
    }
    bool are_apart(const Pair& pair) const noexcept {
        std::array<Vec<double, 2>, 6> axes{Vec<double, 2>{1, 0}, Vec<double, 2>{0, 1}};
        std::size_t count = 2;
        for (const PlaneCurve* curve : {&pair.a, &pair.b}) {
            const auto chord = curve->end() - curve->begin();
            const double size = std::hypot(chord[0], chord[1]);
            if (!(size > 0)) continue;
            axes[count++] = (1 / size) * chord;
            axes[count++] = (1 / size) * Vec<double, 2>{-chord[1], chord[0]};
        }
        for (std::size_t n = 0; n < count; ++n) {
            const Range a = along(pair.a, pair.a.begin(), axes[n]),
                        b = along(pair.b, pair.a.begin(), axes[n]);
            if (a.lower > b.upper + tolerance_ || b.lower > a.upper + tolerance_) return true;
        }
        return false;
    }
    static bool are_exempt(const Pair& pair, std::span<const Vec<double, 2>> exempt, double radius) noexcept {
        return std::any_of(exempt.begin(), exempt.end(), [&](const Vec<double, 2>& place) {
            for (const PlaneCurve* curve : {&pair.a, &pair.b}) {
                for (const auto& c : curve->points()) {
                    if (std::hypot(c[0] - place[0], c[1] - place[1]) > radius) return false;
                }
            }
            return true;
        });
    }

    double tolerance_;
    std::vector<Pair> pairs_;
};

/// Returns the complex roots of e', from the power coefficients of e. A curve reverses direction near a
/// root that is nearly real.
inline PolynomialRoots turning_points(const std::array<Vec<double, 2>, 4>& c) noexcept {
    PolynomialRoots roots;
    const ComplexNumber constant = to_number(c[1]), first = 2.0 * to_number(c[2]),
                        second = 3.0 * to_number(c[3]);
    if (norm(second) > 0)
        add_quadratic_roots(second, first, constant, roots);
    else if (norm(first) > 0)
        roots.add(-(constant / first));
    return roots;
}

/// Whether a curve comes within a tolerance of itself: a loop, or a straight curve that reverses. A cubic
/// meets itself at s and t where (e(s) − e(t))/(s − t) = c_1 + c_2 (s + t) + c_3 (s² + s t + t²) = 0.
///
///   joined  whether the ends of the curve may meet
inline bool touches_itself(const PlaneCurve& curve, bool joined, double tolerance) noexcept {
    const auto c = curve.powers();
    const auto apart = [&](double s, double t) { return length(curve.at(s) - curve.at(t)); };
    const auto meet = [&](double s, double t) {
        s = std::clamp(s, 0.0, 1.0);
        t = std::clamp(t, 0.0, 1.0);
        if (joined && (std::min)(s, t) < 0x1p-10 && (std::max)(s, t) > 1 - 0x1p-10) return false;
        return apart(s, t) <= tolerance && apart(s, 0.5 * (s + t)) > 8 * tolerance;
    };
    if (curve.degree == 1) return false;
    if (!joined && meet(0, 1)) return true;
    if (curve.degree == 3) {
        const double sum = -cross(c[3], c[1]) / cross(c[3], c[2]);
        const double product = sum * sum + dot(c[3], sum * c[2] + c[1]) / dot(c[3], c[3]);
        const double under_root = sum * sum - 4 * product;
        if (under_root >= 0 && is_finite(under_root)) {
            const double root = std::sqrt(under_root);
            if (meet(0.5 * (sum - root), 0.5 * (sum + root))) return true;
        }
    }
    // A straight curve must not reverse along its line.
    const auto axis = farthest_offset<double>(curve.points());
    const double size = length(axis);
    if (!(size > 0) || !are_collinear<double>(curve.points(), tolerance)) return false;
    const PolynomialRoots turning = turning_points(c);
    double highest = dot(curve.begin() - c[0], axis);
    std::array<double, 4> parameters{0, 1, 1, 1};
    for (std::size_t n = 0; n < turning.count; ++n) parameters[n] = std::clamp(turning.s[n].re, 0.0, 1.0);
    parameters[turning.count] = 0;
    std::sort(parameters.begin(), parameters.end());
    const double direction = dot(curve.end() - curve.begin(), axis) < 0 ? -1 : 1;
    highest *= direction;
    return std::any_of(parameters.begin(), parameters.end(), [&](double t) {
        const double along = direction * dot(curve.at(t) - c[0], axis);
        const bool turns_back = along < highest - tolerance * size;
        highest = (std::max)(highest, along);
        return turns_back;
    });
}

/// Returns the parameter of a cusp strictly inside a curve, or NaN. A cusp is a root of e'. The point of the
/// curve at this root must be within the tolerance of the point at the root's real part.
inline double cusp_inside(const PlaneCurve& curve, double tolerance) noexcept {
    const double none = std::numeric_limits<double>::quiet_NaN();
    if (curve.degree < 3) return none;
    const auto c = curve.powers();
    const PolynomialRoots turning = turning_points(c);
    for (std::size_t n = 0; n < turning.count; ++n) {
        const auto [t, off] = turning.s[n];
        if (!(t > 0 && t < 1)) continue;
        const auto at = curve.at(t);
        if (length(at - curve.begin()) <= tolerance || length(at - curve.end()) <= tolerance) continue;
        // e' ≈ e'' (t − τ) near the root τ, so the points differ by about |e''| off².
        const auto bend = 2.0 * (c[2] + 3 * t * c[3]);
        if (length(bend) * off * off <= tolerance) return t;
    }
    return none;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

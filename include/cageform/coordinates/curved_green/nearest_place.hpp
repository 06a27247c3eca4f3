// The point of a curve nearest to a given point, and the continuation of weights across it.
#pragma once

#include <cageform/coordinates/curved_green/curved_edge.hpp>

#include <algorithm>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The nearest point of a curve.
struct NearestPlace {
    double t = 0, distance = (std::numeric_limits<double>::max)();
};

/// Finds the nearest point of a curve within the distance `most` of p. |e(t) − p|² is bisected in Bernstein
/// form. Pieces whose coefficients are not below the best value are pruned. Newton's method finishes convex
/// pieces.
class NearestOnCurve {
public:
    NearestOnCurve(const PlaneCurve& curve, const Vec<double, 2>& p) noexcept
        : curve_(curve)
        , reversed_(curve.reversed())
        , slope_(curve.slope())
        , bend_(curve.degree > 1 ? slope_.slope() : PlaneCurve{0, {}})
        , p_(p) {}

    NearestPlace search(double most) noexcept {
        std::array<Bernstein, 2> axis{Bernstein{curve_.degree, {}}, Bernstein{curve_.degree, {}}};
        for (std::size_t k = 0; k < 2; ++k) {
            for (std::size_t i = 0; i <= curve_.degree; ++i) axis[k].c[i] = curve_.control[i][k] - p_[k];
        }
        std::array<Piece, 64> stack;
        std::size_t count = 0;
        stack[count++] = {axis[0] * axis[0] + axis[1] * axis[1], 0, 1};
        try_at(0);
        try_at(1);
        while (count > 0) {
            const Piece piece = stack[--count];
            const double limit = (std::min)(best_.distance, most);
            const double rounding = 64 * epsilon<double> * piece.square.largest_coefficient();
            if (!(least_of(piece.square) < limit * limit - rounding)) continue;
            const Bernstein derivative = piece.square.derivative();
            const double first = derivative.c[0], last = derivative.c[derivative.degree];
            const double end = piece.begin + piece.length;
            const bool is_convex = least_of(derivative.derivative()) >= 0;
            if (is_convex && (first >= 0 || last <= 0)) {
                try_at(first >= 0 ? piece.begin : end);
            } else if (is_convex || piece.length < 0x1p-40 || count + 2 > stack.size()) {
                try_at(newton(piece.begin, end, piece.begin + 0.5 * piece.length));
            } else {
                const double half = 0.5 * piece.length;
                const auto [lower, upper] = piece.square.split(0.5);
                try_at(piece.begin + half);
                stack[count++] = {lower, piece.begin, half};
                stack[count++] = {upper, piece.begin + half, half};
            }
        }
        // Refines a minimum that bisection only came close to.
        if (best_.t > 0 && best_.t < 1) {
            const double t = newton(0, 1, best_.t), distance = distance_at(t);
            if (distance <= best_.distance * (1 + 4 * epsilon<double>)) best_ = {t, distance};
        }
        return best_;
    }

private:
    struct Piece {
        Bernstein square;
        double begin, length;
    };

    static double least_of(const Bernstein& f) noexcept {
        return *std::min_element(f.c.data(), f.c.data() + f.degree + 1);
    }
    double distance_at(double t) const noexcept {
        const auto off = t <= 0.5 ? curve_.at(t) - p_ : reversed_.at(1 - t) - p_;
        return std::hypot(off[0], off[1]);
    }
    void try_at(double t) noexcept {
        const double distance = distance_at(t);
        if (distance < best_.distance) best_ = {t, distance};
    }
    /// Returns a root of (e − p)·e' in [low, high], by Newton's method from t, safeguarded by bisection.
    double newton(double low, double high, double t) const noexcept {
        for (int step = 0; step < 60; ++step) {
            const auto off = curve_.at(t) - p_, along = slope_.at(t);
            const double f = dot(off, along), rate = dot(along, along) + dot(off, bend_.at(t));
            (f > 0 ? high : low) = t;
            double next = t - f / rate;
            if (!(next >= low && next <= high)) next = 0.5 * (low + high);
            const bool is_done = std::fabs(next - t) <= epsilon<double> * t;
            t = next;
            if (is_done) break;
        }
        return t;
    }

    const PlaneCurve& curve_;
    PlaneCurve reversed_, slope_, bend_;
    Vec<double, 2> p_;
    NearestPlace best_;
};
inline NearestPlace nearest_place(const PlaneCurve& curve, const Vec<double, 2>& p, double most) noexcept {
    return NearestOnCurve(curve, p).search(most);
}

/// The continuation of first order across the point e(t) of an edge:
///
///     c_k = b_k(t) + b_k'(t) w,   w = (z − e(t))/e'(t)
///
/// with Σ c = 1 and Σ c C = z. At an end C with e' = 0, b' w is replaced by ±(z − C)/(C_k − C), where C_k is
/// the nearest control point that differs from C.
struct CurveContinuation {
    EdgeMoments<double> value{};   ///< c_k
    EdgeMoments<double> along_x{}; ///< ∂c_k/∂x
    EdgeMoments<double> along_y{}; ///< ∂c_k/∂y

    CurveContinuation(const CurvedEdge& edge, double t, const ComplexNumber& z) noexcept {
        const std::size_t m = edge.posed_degree, n = edge.curve.degree;
        const bool at_end = t == 0 || t == 1;
        const auto& end = edge.end[t == 1 ? 1 : 0];
        if (at_end && end.vanishing > 1) {
            continue_from_end(edge, t == 1, z);
            return;
        }
        // The values b_k, and their first and second derivatives.
        Values b{}, first{}, second{};
        const auto raise = [t](Values& v, std::size_t d) {
            for (std::size_t k = d + 1; k-- > 0;)
                v[k] = (k < d ? (1 - t) * v[k] : 0) + (k > 0 ? t * v[k - 1] : 0);
        };
        b[0] = 1;
        for (std::size_t d = 1; d <= m; ++d) {
            if (d + 1 == m) differentiate(b, m - 2, double(m) * double(m - 1), second);
            if (d == m) differentiate(b, m - 1, double(m), first);
            raise(b, d);
        }
        if (m >= 2) differentiate(Values(second), m - 1, 1, second);
        const PlaneCurve slope_curve = edge.curve.slope();
        const ComplexNumber slope = to_number(slope_curve.at(t));
        const ComplexNumber bend = n > 1 ? to_number(slope_curve.slope().at(t)) : ComplexNumber{0, 0};
        const ComplexNumber off =
            z - (t <= 0.5 ? to_number(edge.curve.at(t)) : to_number(edge.curve.reversed().at(1 - t)));
        const ComplexNumber w = off / slope;
        // dt = Re(dz conj e')/(|e'|² − Re((z − e) conj e'')); zero at ends.
        const double fall = norm(slope) - (off * conjugate(bend)).re;
        const double rate = at_end || !(fall > 0) ? 0 : 1 / fall;
        for (std::size_t k = 0; k <= m; ++k) {
            value[k] = ComplexNumber{b[k], 0} + first[k] * w;
            const ComplexNumber through = w * (ComplexNumber{second[k], 0} - first[k] * (bend / slope));
            const ComplexNumber direct = first[k] * inverse(slope);
            along_x[k] = direct + (rate * slope.re) * through;
            along_y[k] = ComplexNumber{0, 1} * direct + (rate * slope.im) * through;
        }
    }

private:
    using Values = std::array<double, most_posed_degree + 1>;

    /// Sets the derivatives of polynomials of degree d + 1 from values of degree d: size (f_{k−1} − f_k).
    static void differentiate(const Values& f, std::size_t d, double size, Values& slope) noexcept {
        for (std::size_t k = 0; k <= d + 1; ++k)
            slope[k] = size * ((k > 0 ? f[k - 1] : 0) - (k <= d ? f[k] : 0));
    }
    void continue_from_end(const CurvedEdge& edge, bool is_last, const ComplexNumber& z) noexcept {
        const std::size_t m = edge.posed_degree, end = is_last ? m : 0;
        const auto from = is_last ? edge.curve.reversed() : edge.curve;
        // Of the elevated control points, the first r − 1 after the end coincide with the end.
        const std::size_t r = edge.end[is_last ? 1 : 0].vanishing, other = is_last ? m - r : r;
        double rise = 1; // from powers to control points: 1/(m over r)
        for (std::size_t k = 0; k < r; ++k) rise *= double(k + 1) / double(m - k);
        const ComplexNumber leg = rise * edge.end[is_last ? 1 : 0].away.c[r];
        const ComplexNumber w = (z - to_number(from.begin())) / leg, rate = inverse(leg);
        value[end] = ComplexNumber{1, 0} - w;
        value[other] = w;
        along_x[end] = -rate;
        along_x[other] = rate;
        along_y[end] = ComplexNumber{0, -1} * rate;
        along_y[other] = ComplexNumber{0, 1} * rate;
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail

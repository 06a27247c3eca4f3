// Polynomials on [0, 1] in Bernstein form: products, subdivision and maxima, all numerically stable.
#pragma once

#include <cageform/core/vec.hpp>

#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// binomials[n][k] = n over k.
inline constexpr auto binomials = [] {
    std::array<std::array<double, 16>, 16> table{};
    for (std::size_t n = 0; n < table.size(); ++n) {
        table[n][0] = 1;
        for (std::size_t k = 1; k <= n; ++k)
            table[n][k] = table[n - 1][k - 1] + (k < n ? table[n - 1][k] : 0);
    }
    return table;
}();

/// The polynomial Σ c_i B_i, of degree 15 at most: that of a polynomial of degree 5 composed with a cubic.
struct Bernstein {
    static constexpr std::size_t most = 15;
    std::size_t degree = 0;
    std::array<double, most + 1> c{};

    double operator()(double u) const noexcept {
        auto b = c;
        for (std::size_t n = degree; n > 0; --n) {
            for (std::size_t i = 0; i < n; ++i) b[i] += u * (b[i + 1] - b[i]);
        }
        return b[0];
    }
    double slope(double u) const noexcept { return derivative()(u); }
    Bernstein derivative() const noexcept {
        if (degree == 0) return {};
        Bernstein d{degree - 1, {}};
        for (std::size_t i = 0; i < degree; ++i) d.c[i] = double(degree) * (c[i + 1] - c[i]);
        return d;
    }
    /// The parts on [0, u] and on [u, 1], each as a polynomial on [0, 1] (de Casteljau).
    std::pair<Bernstein, Bernstein> split(double u) const noexcept {
        Bernstein low{degree, {}}, high{degree, c};
        for (std::size_t n = 0; n <= degree; ++n) {
            low.c[n] = high.c[0];
            for (std::size_t i = 0; i < degree - n; ++i) high.c[i] += u * (high.c[i + 1] - high.c[i]);
        }
        return {low, high};
    }
    double largest_coefficient() const noexcept {
        double largest = 0;
        for (std::size_t i = 0; i <= degree; ++i) largest = std::fmax(largest, std::fabs(c[i]));
        return largest;
    }

    friend Bernstein operator*(const Bernstein& a, const Bernstein& b) noexcept {
        Bernstein p{a.degree + b.degree, {}};
        for (std::size_t i = 0; i <= a.degree; ++i) {
            for (std::size_t j = 0; j <= b.degree; ++j)
                p.c[i + j] += binomials[a.degree][i] * a.c[i] * binomials[b.degree][j] * b.c[j];
        }
        for (std::size_t k = 0; k <= p.degree; ++k) p.c[k] /= binomials[p.degree][k];
        return p;
    }
    friend Bernstein operator+(Bernstein a, const Bernstein& b) noexcept { // equal degrees only
        for (std::size_t i = 0; i <= a.degree; ++i) a.c[i] += b.c[i];
        return a;
    }
};

/// Raises the degree of a polynomial without changing it.
inline Bernstein elevated(Bernstein p, std::size_t degree) noexcept {
    while (p.degree < degree) {
        const std::size_t n = p.degree + 1;
        Bernstein q{n, {}};
        q.c[0] = p.c[0];
        q.c[n] = p.c[n - 1];
        for (std::size_t i = 1; i < n; ++i)
            q.c[i] = (double(i) * p.c[i - 1] + double(n - i) * p.c[i]) / double(n);
        p = q;
    }
    return p;
}

/// Returns the root in (0, 1) of a polynomial with one sign change: Newton's method safeguarded by
/// bisection.
///
///   falls  whether the sign changes from positive to negative
inline double simple_root(const Bernstein& p, bool falls) noexcept {
    double low = 0, high = 1, u = 0.5;
    const Bernstein derivative = p.derivative();
    for (int step = 0; step < 60 && high - low > 1e-12; ++step) {
        const double value = p(u);
        ((value > 0) == falls ? low : high) = u;
        double next = u - value / derivative(u);
        if (!(next > low && next < high)) next = 0.5 * (low + high);
        const bool converged = std::fabs(next - u) < 1e-10;
        u = next;
        if (converged) break;
    }
    return u;
}

/// The maximum of |p| on [0, 1] and its position, exact up to rounding. Subdivides until the
/// coefficients of the derivative change sign at most once; there is then at most one extremum.
/// Infinite if a coefficient is not finite.
struct LargestValue {
    double value = 0, at = 0;
};
inline LargestValue largest_absolute(const Bernstein& p) {
    for (std::size_t i = 0; i <= p.degree; ++i) {
        if (!is_finite(p.c[i])) return {std::numeric_limits<double>::infinity(), 0};
    }
    LargestValue best{std::fabs(p.c[0]), 0};
    const auto consider = [&](double value, double at) {
        if (std::fabs(value) > best.value) best = {std::fabs(value), at};
    };
    consider(p.c[p.degree], 1);
    struct Piece {
        Bernstein p;
        double begin, length;
    };
    std::array<Piece, 64> stack; // a piece is replaced by its two halves
    std::size_t count = 0;
    stack[count++] = {p, 0, 1};
    // Bounds the rounding errors of repeated subdivision. With a smaller bound, a rounded constant
    // would be subdivided endlessly.
    const double rounding = 64 * epsilon<double> * p.largest_coefficient();
    while (count > 0) {
        const Piece piece = stack[--count];
        if (piece.p.largest_coefficient() <= best.value + rounding) continue;
        const Bernstein slope = piece.p.derivative();
        std::size_t changes = 0;
        double before = 0;
        for (std::size_t i = 0; i <= slope.degree; ++i) {
            if (slope.c[i] == 0) continue;
            if (before != 0 && (slope.c[i] > 0) != (before > 0)) ++changes;
            before = slope.c[i];
        }
        if (changes == 0) continue; // monotone: the maximum is at an end, already visited
        if (changes == 1) {
            const double u = simple_root(slope, before < 0);
            consider(piece.p(u), piece.begin + u * piece.length);
            continue;
        }
        if (piece.length < 1e-12 || count + 2 > stack.size()) { // a multiple extremum: nearly constant
            consider(piece.p(0.5), piece.begin + 0.5 * piece.length);
            continue;
        }
        const auto [low, high] = piece.p.split(0.5);
        consider(high.c[0], piece.begin + 0.5 * piece.length);
        stack[count++] = {low, piece.begin, 0.5 * piece.length};
        stack[count++] = {high, piece.begin + 0.5 * piece.length, 0.5 * piece.length};
    }
    return best;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

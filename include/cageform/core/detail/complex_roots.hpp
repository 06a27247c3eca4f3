// The complex roots of polynomials of degree 1 to 3.
#pragma once

#include <cageform/core/detail/complex.hpp>

#include <array>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A polynomial c_0 + c_1 s + …
struct Polynomial {
    std::size_t degree = 0;
    std::array<ComplexNumber, 4> c{};

    ComplexNumber at(const ComplexNumber& s) const noexcept {
        ComplexNumber sum = c[degree];
        for (std::size_t k = degree; k-- > 0;) sum = s * sum + c[k];
        return sum;
    }
    ComplexNumber slope(const ComplexNumber& s) const noexcept {
        ComplexNumber sum = double(degree) * c[degree];
        for (std::size_t k = degree; k-- > 1;) sum = s * sum + double(k) * c[k];
        return degree == 0 ? ComplexNumber{0, 0} : sum;
    }
    /// Returns the polynomial whose roots are 1/s.
    Polynomial reversed() const noexcept {
        Polynomial r{degree, {}};
        for (std::size_t k = 0; k <= degree; ++k) r.c[k] = c[degree - k];
        return r;
    }
    /// Divides by s; the constant coefficient must be 0.
    Polynomial divided_by_s() const noexcept {
        Polynomial q{degree - 1, {}};
        for (std::size_t k = 0; k < degree; ++k) q.c[k] = c[k + 1];
        return q;
    }
    /// Divides by s − 1; 1 must be a root.
    Polynomial divided_by_s_minus_one() const noexcept {
        Polynomial q{degree - 1, {}};
        ComplexNumber sum{0, 0};
        for (std::size_t k = degree; k-- > 0;) q.c[k] = sum = sum + c[k + 1];
        return q;
    }
};

struct PolynomialRoots {
    std::size_t count = 0;
    std::array<ComplexNumber, 3> s{};

    void add(const ComplexNumber& root) noexcept { s[count++] = root; }
};

/// Adds the two roots of a s² + b s + c, without cancellation.
inline void add_quadratic_roots(const ComplexNumber& a, const ComplexNumber& b, const ComplexNumber& c,
                                PolynomialRoots& roots) noexcept {
    ComplexNumber w = root(b * b - 4.0 * (a * c));
    if (w.re * b.re + w.im * b.im < 0) w = -w;
    const ComplexNumber h = -0.5 * (b + w);
    if (!(norm(h) > 0)) { // a double root at 0
        roots.add({0, 0});
        roots.add({0, 0});
        return;
    }
    roots.add(c / h);
    roots.add(h / a);
}

/// Returns the most isolated root of x³ + a x² + b x + c: the root with the largest distance to its nearest
/// other root. Uses Cardano's formula.
inline ComplexNumber most_isolated_root(const ComplexNumber& a, const ComplexNumber& b,
                                        const ComplexNumber& c) noexcept {
    const ComplexNumber third = (1 / 3.0) * a, p = b - a * third, q = third * (2.0 * (third * third) - b) + c;
    const ComplexNumber half = 0.5 * q, cube = (1 / 3.0) * p;
    ComplexNumber w = root(half * half + cube * cube * cube);
    if (w.re * half.re + w.im * half.im < 0) w = -w;
    const ComplexNumber u = cube_root(-(half + w)); // w has the sign that avoids cancellation
    const ComplexNumber v = norm(u) > 0 ? -(cube / u) : ComplexNumber{0, 0};
    constexpr ComplexNumber turn{-0.5, 0.86602540378443865};
    const std::array<ComplexNumber, 3> x{u + v, u * turn + v * conjugate(turn),
                                         u * conjugate(turn) + v * turn};
    std::size_t isolated = 0;
    double most = -1;
    for (std::size_t k = 0; k < 3; ++k) {
        const double nearest = std::fmin(norm(x[k] - x[(k + 1) % 3]), norm(x[k] - x[(k + 2) % 3]));
        if (!(nearest > most)) continue;
        most = nearest;
        isolated = k;
    }
    return x[isolated] - third;
}

/// Returns the roots of a polynomial; neither the leading nor the constant coefficient may be 0. For a
/// cubic, only the most isolated root is refined and divided out. Two nearly equal roots are each
/// ill-conditioned, but the remaining quadratic determines their sum and product well.
inline PolynomialRoots roots_of(const Polynomial& of) noexcept {
    PolynomialRoots roots;
    const auto& c = of.c;
    if (of.degree == 1) roots.add(-(c[0] / c[1]));
    if (of.degree == 2) add_quadratic_roots(c[2], c[1], c[0], roots);
    if (of.degree < 3) return roots;
    // Solves for 1/s if the constant coefficient is larger than the leading one.
    const bool inverted = norm(c[0]) > norm(c[3]);
    const Polynomial p = inverted ? of.reversed() : of;
    const ComplexNumber share = inverse(p.c[3]);
    ComplexNumber x = most_isolated_root(share * p.c[2], share * p.c[1], share * p.c[0]);
    for (int step = 0; step < 2; ++step) {
        const ComplexNumber slope = p.slope(x);
        if (norm(slope) > 0) x = x - p.at(x) / slope;
    }
    const ComplexNumber s = inverted ? inverse(x) : x;
    roots.add(s);
    const ComplexNumber last = -(c[0] / s);
    const double r = size(s);
    const bool from_above = (size(c[2]) + size(c[3]) * r) * r <= size(last) + size(c[1]);
    const ComplexNumber middle = from_above ? c[2] + c[3] * s : (last - c[1]) / s;
    add_quadratic_roots(c[3], middle, last, roots);
    return roots;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

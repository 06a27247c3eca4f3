// Complex numbers, or registers of them.
#pragma once

#include <cageform/core/vec.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A complex number; R is double or a register. Unlike std::complex, products do not check for NaN.
template <class R>
struct Complex {
    R re, im;

    friend Complex operator+(const Complex& a, const Complex& b) noexcept {
        return {a.re + b.re, a.im + b.im};
    }
    friend Complex operator-(const Complex& a, const Complex& b) noexcept {
        return {a.re - b.re, a.im - b.im};
    }
    friend Complex operator-(const Complex& a) noexcept { return {R(0.0) - a.re, R(0.0) - a.im}; }
    friend Complex operator*(const Complex& a, const Complex& b) noexcept {
        return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
    }
    friend Complex operator*(const R& a, const Complex& b) noexcept { return {a * b.re, a * b.im}; }
    friend Complex operator/(const Complex& a, const Complex& b) noexcept { return a * inverse(b); }
    Complex& operator+=(const Complex& b) noexcept { return *this = *this + b; }

    friend R norm(const Complex& a) noexcept { return a.re * a.re + a.im * a.im; } ///< |a|²
    friend Complex inverse(const Complex& a) noexcept {
        const R share = R(1.0) / norm(a);
        return {share * a.re, R(0.0) - share * a.im};
    }
};

using ComplexNumber = Complex<double>;

inline ComplexNumber to_number(const Vec<double, 2>& v) noexcept {
    return {v[0], v[1]};
}
inline double size(const ComplexNumber& a) noexcept {
    return std::sqrt(norm(a));
}
inline ComplexNumber conjugate(const ComplexNumber& a) noexcept {
    return {a.re, -a.im};
}
/// Returns the square root with a real part of at least 0.
inline ComplexNumber root(const ComplexNumber& a) noexcept {
    const double length = size(a);
    if (!(length > 0)) return {0, 0};
    // The larger part is a square root, the smaller one a quotient, to avoid cancellation.
    const double larger = std::sqrt((length + std::fabs(a.re)) / 2), smaller = a.im / (2 * larger);
    return a.re >= 0 ? ComplexNumber{larger, smaller}
                     : ComplexNumber{std::fabs(smaller), std::copysign(larger, a.im)};
}
/// Returns one of the three cube roots.
inline ComplexNumber cube_root(const ComplexNumber& a) noexcept {
    const double length = std::cbrt(size(a)), angle = std::atan2(a.im, a.re) / 3;
    return {length * std::cos(angle), length * std::sin(angle)};
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// Forward differentiation: a number together with its gradient, through any formula.
#pragma once

#include <cageform/core/vec.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The value of an expression in `D` variables, and its derivatives with respect to them. Formulas that are templates of
/// their scalar are differentiated by calling them with it; they have to find `sqrt` and the like by their arguments.
template <class U, std::size_t D>
struct Dual {
    U value{};
    Vec<U, D> gradient{};

    constexpr Dual() noexcept = default;
    constexpr Dual(U x) noexcept // NOLINT(google-explicit-constructor): constants in formulas
        : value(x) {}
    constexpr Dual(U x, const Vec<U, D>& slope) noexcept
        : value(x)
        , gradient(slope) {}

    friend constexpr Dual operator+(const Dual& a, const Dual& b) noexcept {
        return {a.value + b.value, a.gradient + b.gradient};
    }
    friend constexpr Dual operator-(const Dual& a, const Dual& b) noexcept {
        return {a.value - b.value, a.gradient - b.gradient};
    }
    friend constexpr Dual operator-(const Dual& a) noexcept { return {-a.value, U(-1) * a.gradient}; }
    friend constexpr Dual operator*(const Dual& a, const Dual& b) noexcept {
        return {a.value * b.value, a.value * b.gradient + b.value * a.gradient};
    }
    friend constexpr Dual operator*(U a, const Dual& b) noexcept { return {a * b.value, a * b.gradient}; }
    friend constexpr Dual operator/(const Dual& a, const Dual& b) noexcept {
        const U inverse = 1 / b.value, quotient = a.value * inverse;
        return {quotient, inverse * (a.gradient - quotient * b.gradient)};
    }
    friend constexpr Dual operator/(const Dual& a, U b) noexcept { return (1 / b) * a; }
    Dual& operator+=(const Dual& b) noexcept { return *this = *this + b; }

    friend constexpr bool operator<(const Dual& a, const Dual& b) noexcept { return a.value < b.value; }
    friend constexpr bool operator>(const Dual& a, const Dual& b) noexcept { return a.value > b.value; }
    friend constexpr bool operator==(const Dual& a, const Dual& b) noexcept { return a.value == b.value; }

    /// Not at zero.
    friend Dual sqrt(const Dual& a) noexcept {
        const U root = std::sqrt(a.value);
        return {root, (U(0.5) / root) * a.gradient};
    }
    friend Dual fabs(const Dual& a) noexcept { return a.value < 0 ? -a : a; }
    friend Dual atan(const Dual& a) noexcept {
        return {std::atan(a.value), (1 / (1 + a.value * a.value)) * a.gradient};
    }
    /// Not at (0, 0).
    friend Dual atan2(const Dual& y, const Dual& x) noexcept {
        const U inverse = 1 / (x.value * x.value + y.value * y.value);
        return {std::atan2(y.value, x.value), inverse * (x.value * y.gradient - y.value * x.gradient)};
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail

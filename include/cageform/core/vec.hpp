// The vector type of all computations. User point types are converted at the interface (core/point.hpp).
#pragma once

#include <cageform/config.hpp>

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

namespace cageform::inline CAGEFORM_ABI {

/// The scalars that the library supports.
template <class T>
concept Scalar = std::same_as<T, float> || std::same_as<T, double>;

/// A point or vector of `D` components; an aggregate, so `Vec<double, 2>{1, 2}`.
template <class T, std::size_t D>
struct Vec {
    T v[D];

    constexpr T& operator[](std::size_t axis) noexcept { return v[axis]; }
    constexpr const T& operator[](std::size_t axis) const noexcept { return v[axis]; }

    friend constexpr Vec operator+(Vec a, const Vec& b) noexcept {
        for (std::size_t k = 0; k < D; ++k) a.v[k] += b.v[k];
        return a;
    }
    friend constexpr Vec operator-(Vec a, const Vec& b) noexcept {
        for (std::size_t k = 0; k < D; ++k) a.v[k] -= b.v[k];
        return a;
    }
    friend constexpr Vec operator*(T s, Vec a) noexcept {
        for (std::size_t k = 0; k < D; ++k) a.v[k] *= s;
        return a;
    }
    friend constexpr bool operator==(const Vec&, const Vec&) = default;
};

template <class T, std::size_t D>
constexpr T dot(const Vec<T, D>& a, const Vec<T, D>& b) noexcept {
    T sum = 0;
    for (std::size_t k = 0; k < D; ++k) sum += a.v[k] * b.v[k];
    return sum;
}

/// Returns the signed area of the parallelogram (a, b): positive if b is counter-clockwise from a.
template <class T>
constexpr T cross(const Vec<T, 2>& a, const Vec<T, 2>& b) noexcept {
    return a.v[0] * b.v[1] - a.v[1] * b.v[0];
}
template <class T>
constexpr Vec<T, 3> cross(const Vec<T, 3>& a, const Vec<T, 3>& b) noexcept {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Converts each component, for instance from float to double.
template <class To, class T, std::size_t D>
constexpr Vec<To, D> vec_cast(const Vec<T, D>& a) noexcept {
    Vec<To, D> r{};
    for (std::size_t k = 0; k < D; ++k) r.v[k] = static_cast<To>(a.v[k]);
    return r;
}

/// Whether `x` is neither NaN nor infinite. Tests the exponent bits, so it also works under -ffast-math.
template <Scalar T>
constexpr bool is_finite(T x) noexcept {
    using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
    constexpr Bits exponent = sizeof(T) == 4 ? Bits(0x7f800000) : Bits(0x7ff0000000000000);
    auto bits = std::bit_cast<Bits>(x);
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
    // Hides the bits from clang 19, which would otherwise assume that their source is finite.
    if (!std::is_constant_evaluated()) __asm__("" : "+r"(bits));
#endif
    return (bits & exponent) != exponent;
}

template <Scalar T, std::size_t D>
constexpr bool is_finite(const Vec<T, D>& a) noexcept {
    for (std::size_t k = 0; k < D; ++k) {
        if (!is_finite(a.v[k])) return false;
    }
    return true;
}

/// The distance from 1 to the next larger number, 2.2e-16 for double. Tolerances are multiples of it.
template <Scalar T>
inline constexpr T epsilon = std::numeric_limits<T>::epsilon();

} // namespace cageform::inline CAGEFORM_ABI

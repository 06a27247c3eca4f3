// Logarithms of registers, by arithmetic alone.
#pragma once

#include <cageform/core/detail/simd.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The bits of a number as an integer, or of a register as integers.
template <class Register>
struct BitsOf {
    using type = decltype(Register{} < Register{});
};
template <>
struct BitsOf<float> {
    using type = std::int32_t;
};
template <>
struct BitsOf<double> {
    using type = std::int64_t;
};

/// Natural logarithms of finite numbers that are positive and normal: to four roundings.
template <Scalar T>
Simd<T> log(const Simd<T>& a) noexcept {
    using Int = std::conditional_t<sizeof(T) == 8, std::int64_t, std::int32_t>;
    using Register = typename Simd<T>::Register;
    using Bits = typename BitsOf<Register>::type;
    constexpr int digits = sizeof(T) == 8 ? 52 : 23;
    constexpr Int bias = sizeof(T) == 8 ? 1023 : 127, mantissa = (Int(1) << digits) - 1;
    // 2^digits + n has the bits of n where its mantissa is.
    constexpr Int integer = Int(bias + digits) << digits;
    constexpr T large = T(Int(1) << digits);

    Simd<T> exponent, m; // a = m 2^exponent, 1 ≤ m < 2
    for (std::size_t k = 0; k < Simd<T>::count; ++k) {
        const Bits bits = __builtin_bit_cast(Bits, a.r[k]);
        exponent.r[k] = __builtin_bit_cast(Register, (bits >> digits) | integer) - (large + T(bias));
        m.r[k] = __builtin_bit_cast(Register, (bits & mantissa) | (bias << digits));
    }
    const Simd<T> one(T(1));
    const auto above = Simd<T>(T(1.4142135623730951)) < m;
    m = select<T>(above, Simd<T>(T(0.5)) * m, m);
    exponent = select<T>(above, exponent + one, exponent);
    // The series of 2 artanh(z): at |z| ≤ 3 − √8 each term is a thirtieth of the one before.
    const Simd<T> z = (m - one) / (m + one), zz = z * z;
    constexpr int terms = sizeof(T) == 8 ? 12 : 6;
    // ln 2 in two parts, of which the first times the exponent is exact.
    constexpr T high = T(sizeof(T) == 8 ? 0x1.62e42fefa38p-1 : 0x1.62ep-1);
    constexpr T low = T(sizeof(T) == 8 ? 0x1.ef35793c7673p-45 : 0x1.0bfbe8p-15);
    return exponent * Simd<T>(high) + (exponent * Simd<T>(low) + Simd<T>(T(2)) * (z * odd_series<terms>(zz)));
}

} // namespace cageform::inline CAGEFORM_ABI::detail

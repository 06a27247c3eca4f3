// The exponential function for registers, without table or library calls.
#pragma once

#include <cageform/core/detail/simd.hpp>

#include <cmath>
#include <concepts>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns e^r for |r| ≤ ln(2)/2, by a Chebyshev fit. The error is 4e-18 (float: 2e-9) before coefficients
/// are rounded.
template <Scalar T>
CAGEFORM_DETAIL_INLINE inline Simd<T> exp_reduced(const Simd<T>& r) noexcept {
    if constexpr (sizeof(T) == 8) {
        static constexpr std::array<T, 12> c{1,
                                             1,
                                             0.5000000000000018386,
                                             0.1666666666666668081,
                                             0.0416666666664880955,
                                             0.008333333333319600611,
                                             0.001388888895231477465,
                                             0.0001984126989004711371,
                                             0.00002480148548232849242,
                                             2.755724091857896982e-6,
                                             2.763263963904102975e-7,
                                             2.511003760596377771e-8};
        return polynomial(c, r);
    } else {
        static constexpr std::array<T, 7> c{
            1, 1.000000038F, 0.5000000047F, 0.1666641551F, 0.0416663529F, 0.008375126398F, 0.001394110843F};
        return polynomial(c, r);
    }
}

/// Returns e^a for a ≤ 700 (float: 85), to 2 ulp; zero where e^a would be below the normal numbers.
template <Scalar T>
Simd<T> exp(const Simd<T>& a) noexcept {
    using Int = std::conditional_t<sizeof(T) == 8, std::int64_t, std::int32_t>;
    using Register = typename Simd<T>::Register;
    using Bits = typename BitsOf<Register>::type;
    constexpr int digits = sizeof(T) == 8 ? 52 : 23;
    constexpr Int bias = sizeof(T) == 8 ? 1023 : 127;
    constexpr T least = sizeof(T) == 8 ? T(-708) : T(-87);
    // The sum of this number and n, |n| small, has n in its lowest bits.
    constexpr T integer = T(Int(3) << (digits - 1));
    constexpr T high = T(sizeof(T) == 8 ? 0x1.62e42fefa38p-1 : 0x1.62ep-1); // ln 2 = high + low, as in log
    constexpr T low = T(sizeof(T) == 8 ? 0x1.ef35793c7673p-45 : 0x1.0bfbe8p-15);
    const Simd<T> x = max<T>(a, Simd<T>(least));
    const Simd<T> sum = x * Simd<T>(T(1.4426950408889634)) + Simd<T>(integer), n = sum - Simd<T>(integer);
    const Simd<T> r = (x - n * Simd<T>(high)) - n * Simd<T>(low);
    Simd<T> power;
    for (std::size_t k = 0; k < Simd<T>::count; ++k) {
        const Bits bits = __builtin_bit_cast(Bits, sum.r[k]);
        power.r[k] = __builtin_bit_cast(Register, (bits + bias) << digits);
    }
    return select<T>(a < Simd<T>(least), Simd<T>(T(0)), exp_reduced(r) * power);
}

template <std::floating_point X>
X exp(X a) noexcept {
    return std::exp(a);
}
template <std::floating_point X>
X log(X a) noexcept {
    return std::log(a);
}

} // namespace cageform::inline CAGEFORM_ABI::detail

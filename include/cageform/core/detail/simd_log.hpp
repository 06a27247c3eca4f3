// The natural logarithm for registers, without table or library calls.
#pragma once

#include <cageform/core/detail/simd.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns artanh(√u)/√u for 0 ≤ u ≤ (3 − √8)², by the minimax polynomial of the relative error. The error
/// is 2e-18 (float: 7e-10) before coefficients are rounded.
template <Scalar T>
CAGEFORM_DETAIL_INLINE inline Simd<T> artanh_over(const Simd<T>& u) noexcept {
    if constexpr (sizeof(T) == 8) {
        static constexpr std::array<T, 8> c{1,
                                            0.33333333333333826,
                                            0.19999999999649443,
                                            0.14285714380673098,
                                            0.11111098494138967,
                                            0.09091817546676477,
                                            0.076562218832389728,
                                            0.074052649176298446};
        return polynomial(c, u);
    } else {
        static constexpr std::array<T, 4> c{1, 0.333334088F, 0.199873969F, 0.149628252F};
        return polynomial(c, u);
    }
}

/// Returns natural logarithms of positive, normal, finite numbers; the error is at most 4 ulp.
template <Scalar T>
Simd<T> log(const Simd<T>& a) noexcept {
    using Int = std::conditional_t<sizeof(T) == 8, std::int64_t, std::int32_t>;
    using Register = typename Simd<T>::Register;
    using Bits = typename BitsOf<Register>::type;
    constexpr int digits = sizeof(T) == 8 ? 52 : 23;
    constexpr Int bias = sizeof(T) == 8 ? 1023 : 127, mantissa = (Int(1) << digits) - 1;
    // The bits of 2^digits + n hold n in the mantissa.
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
    const Simd<T> z = (m - one) / (m + one); // ln m = 2 artanh(z), |z| ≤ 3 − √8
    // ln 2 as a sum of two numbers; the first times the exponent is exact.
    constexpr T high = T(sizeof(T) == 8 ? 0x1.62e42fefa38p-1 : 0x1.62ep-1);
    constexpr T low = T(sizeof(T) == 8 ? 0x1.ef35793c7673p-45 : 0x1.0bfbe8p-15);
    return exponent * Simd<T>(high) + (exponent * Simd<T>(low) + Simd<T>(T(2)) * (z * artanh_over(z * z)));
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// atan2 for registers, without table or library calls.
#pragma once

#include <cageform/core/detail/simd.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns atan(√u)/√u for 0 ≤ u ≤ tan²(π/8), by the minimax polynomial of the relative error. The error is
/// 4e-17 (float: 7e-10) before coefficients are rounded. The Taylor series would need 20 terms (float: 10).
template <Scalar T>
CAGEFORM_DETAIL_INLINE inline Simd<T> atan_over(const Simd<T>& u) noexcept {
    if constexpr (sizeof(T) == 8) {
        static constexpr std::array<T, 11> c{1,
                                             -0.33333333333328619,
                                             0.19999999998889212,
                                             -0.1428571418350976,
                                             0.11111106276082101,
                                             -0.090907751491587765,
                                             0.076899809007724071,
                                             -0.066404580758439233,
                                             0.056894574061706185,
                                             -0.043510861983284556,
                                             0.021170682492677943};
        return polynomial(c, u);
    } else {
        static constexpr std::array<T, 6> c{
            1, -0.333333075F, 0.199982166F, -0.142400831F, 0.105734795F, -0.0603479035F};
        return polynomial(c, u);
    }
}

/// Writes atan2(y, x), for y ≥ 0 and not both zero, as offset + atan(numerator/denominator) with a
/// quotient of absolute value at most tan(π/8).
template <Scalar T>
struct AngleTerms {
    Simd<T> numerator, denominator, offset;

    CAGEFORM_DETAIL_INLINE AngleTerms(const Simd<T>& y, const Simd<T>& x) noexcept {
        constexpr T pi = T(3.14159265358979323846), tangent_of_eighth = T(0.41421356237309505);
        const Simd<T> zero(T(0)), size = abs<T>(x), less = min<T>(y, size), more = max<T>(y, size);
        // Beyond tan(π/8) the angle is measured from the diagonal, beyond π/4 from the y axis.
        const auto steep = Simd<T>(tangent_of_eighth) * more < less, above = size < y, is_left = x < zero;
        numerator = select<T>(steep, less - more, less);
        denominator = select<T>(steep, less + more, more);
        offset = select<T>(steep, Simd<T>(pi / 4), zero);
        offset = select<T>(above, Simd<T>(pi / 2) - offset, offset);
        offset = select<T>(is_left, Simd<T>(pi) - offset, offset);
        numerator = select<T>(above ^ is_left, zero - numerator, numerator);
    }
};

/// Returns atan2(y, x) in [0, π] for y ≥ 0, not both zero; the error is at most three roundings.
template <Scalar T>
CAGEFORM_DETAIL_INLINE inline Simd<T> angle(const Simd<T>& y, const Simd<T>& x) noexcept {
    const AngleTerms<T> terms(y, x);
    const Simd<T> z = terms.numerator / terms.denominator;
    return z * atan_over(z * z) + terms.offset;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

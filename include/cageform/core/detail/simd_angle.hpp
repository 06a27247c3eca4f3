// Angles of registers, by arithmetic alone.
#pragma once

#include <cageform/core/detail/simd.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// atan2(y, x) for y ≥ 0, not both zero: in [0, π], to three roundings.
template <Scalar T>
Simd<T> angle(const Simd<T>& y, const Simd<T>& x) noexcept {
    constexpr T pi = T(3.14159265358979323846), tangent_of_eighth = T(0.41421356237309505);
    // The smaller over the larger is in [0, 1]; beyond tan(π/8) the angle from the diagonal is
    // taken.
    const Simd<T> zero(T(0)), size = abs<T>(x);
    const Simd<T> small = min<T>(y, size), large = max<T>(y, size);
    const auto steep = Simd<T>(tangent_of_eighth) * large < small;
    const Simd<T> z = select<T>(steep, small - large, small) / select<T>(steep, small + large, large);
    // The series of atan: at |z| ≤ tan(π/8) each term is a sixth of the one before.
    constexpr int terms = sizeof(T) == 8 ? 20 : 10;
    const Simd<T> zz = zero - z * z;
    Simd<T> a = z * odd_series<terms>(zz);
    a = select<T>(steep, a + Simd<T>(pi / 4), a);
    a = select<T>(size < y, Simd<T>(pi / 2) - a, a);
    return select<T>(x < zero, Simd<T>(pi) - a, a);
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// Register operations that need intrinsics. A separate header, because the headers of intrinsics are large.
#pragma once

#include <cageform/core/detail/simd.hpp>

#if CAGEFORM_REGISTER_BYTES == 16 && defined(__SSE2__)
#include <emmintrin.h>
#elif CAGEFORM_REGISTER_BYTES > 16 && defined(__SSE2__)
#include <immintrin.h> // 40,000 lines
#else
#include <cmath>
#endif

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns square roots. A loop over std::sqrt would stay scalar unless the user compiles with
/// -fno-math-errno.
template <Scalar T>
CAGEFORM_DETAIL_INLINE inline Simd<T> sqrt(Simd<T> a) noexcept {
    for (std::size_t k = 0; k < Simd<T>::count; ++k) {
        auto& x = a.r[k];
#if CAGEFORM_REGISTER_BYTES == 64
        if constexpr (sizeof(T) == 8)
            x = __builtin_bit_cast(typename Simd<T>::Register,
                                   _mm512_maskz_sqrt_pd(0xff, __builtin_bit_cast(__m512d, x)));
        else
            x = __builtin_bit_cast(typename Simd<T>::Register,
                                   _mm512_maskz_sqrt_ps(0xffff, __builtin_bit_cast(__m512, x)));
#elif CAGEFORM_REGISTER_BYTES == 32
        if constexpr (sizeof(T) == 8)
            x = _mm256_sqrt_pd(x);
        else
            x = _mm256_sqrt_ps(x);
#elif CAGEFORM_REGISTER_BYTES == 16 && defined(__SSE2__)
        if constexpr (sizeof(T) == 8)
            x = _mm_sqrt_pd(x);
        else
            x = _mm_sqrt_ps(x);
#elif CAGEFORM_REGISTER_BYTES != 0
        for (std::size_t lane = 0; lane < register_bytes / sizeof(T); ++lane) x[lane] = std::sqrt(x[lane]);
#else
        x = std::sqrt(x);
#endif
    }
    return a;
}

/// Whether square roots and their inverses start from hardware estimates: the case for 64-byte registers.
/// Such processors have one slow unit for roots and quotients, so estimates are several times as fast;
/// narrower registers gain nothing. Estimates may differ in the last bits between manufacturers.
template <class N>
inline constexpr bool estimates_roots = false;

#if CAGEFORM_REGISTER_BYTES == 64
template <Scalar T>
inline constexpr bool estimates_roots<Simd<T>> = true;

template <Scalar T>
struct RootAndInverse {
    Simd<T> root, inverse;
};

/// Returns √x and 1/√x, to one rounding each, for positive, normal, finite numbers; NaN for others.
template <Scalar T>
CAGEFORM_DETAIL_INLINE inline RootAndInverse<T> root_and_inverse(const Simd<T>& x) noexcept {
    using X = Simd<T>;
    using Register = typename X::Register;
    X y; // 1/√x to 14 bits; masked with all lanes: GNU 12 warns of unset values in the plain functions
    if constexpr (sizeof(T) == 8)
        y.r[0] =
            __builtin_bit_cast(Register, _mm512_maskz_rsqrt14_pd(0xff, __builtin_bit_cast(__m512d, x.r[0])));
    else
        y.r[0] =
            __builtin_bit_cast(Register, _mm512_maskz_rsqrt14_ps(0xffff, __builtin_bit_cast(__m512, x.r[0])));
    // With e = 1 − x y², 1/√x = y/√(1 − e) = y (1 + e/2 + 3/8 e² + 5/16 e³ + …).
    const X h = x * y, e = X(T(1)) - h * y;
    const X more = sizeof(T) == 8 ? X(T(0.375)) + e * X(T(0.3125)) : X(T(0.375));
    const X p = e * (X(T(0.5)) + e * more);
    return {h + h * p, y + y * p};
}
#endif

/// Whether a comparison holds in any lane.
template <class Mask>
CAGEFORM_DETAIL_INLINE inline bool any(const Mask& mask) noexcept {
    auto all = mask.m[0];
    for (std::size_t k = 1; k < sizeof(mask.m) / sizeof(all); ++k) all = all | mask.m[k];
#if CAGEFORM_REGISTER_BYTES == 64
    return _mm512_test_epi64_mask(__builtin_bit_cast(__m512i, all), __builtin_bit_cast(__m512i, all)) != 0;
#elif CAGEFORM_REGISTER_BYTES == 32
    return _mm256_movemask_epi8(__builtin_bit_cast(__m256i, all)) != 0;
#elif CAGEFORM_REGISTER_BYTES == 16 && defined(__SSE2__)
    return _mm_movemask_epi8(__builtin_bit_cast(__m128i, all)) != 0;
#elif CAGEFORM_REGISTER_BYTES != 0
    std::uint64_t words[sizeof(all) / 8], found = 0;
    std::memcpy(words, &all, sizeof(all));
    for (const std::uint64_t word : words) found |= word;
    return found != 0;
#else
    return all;
#endif
}

} // namespace cageform::inline CAGEFORM_ABI::detail

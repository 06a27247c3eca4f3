// Square roots of registers: the only place that knows instructions by name, apart since their
// header is large.
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

/// Square roots. A loop over std::sqrt would stay scalar unless the user compiles with
/// -fno-math-errno.
template <Scalar T>
Simd<T> sqrt(Simd<T> a) noexcept {
    for (std::size_t k = 0; k < Simd<T>::count; ++k) {
        auto& x = a.r[k];
#if CAGEFORM_REGISTER_BYTES == 64
        if constexpr (sizeof(T) == 8)
            x = __builtin_bit_cast(typename Simd<T>::Register,
                                   _mm512_sqrt_pd(__builtin_bit_cast(__m512d, x)));
        else
            x = __builtin_bit_cast(typename Simd<T>::Register, _mm512_sqrt_ps(__builtin_bit_cast(__m512, x)));
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

} // namespace cageform::inline CAGEFORM_ABI::detail

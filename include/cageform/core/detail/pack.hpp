// One row of a block as registers: the only place that knows about vector instructions.
#pragma once

#include <cageform/core/blocks.hpp>

#include <cstring>

#if CAGEFORM_REGISTER_BYTES != 0 && (defined(__x86_64__) || defined(__i386__))
#include <immintrin.h>
#else
#include <cmath>
#endif

namespace cageform::inline CAGEFORM_ABI::detail {

#if CAGEFORM_REGISTER_BYTES != 0
inline constexpr std::size_t register_bytes = CAGEFORM_REGISTER_BYTES;
template <class T>
struct RegisterOf {
    typedef T type __attribute__((vector_size(register_bytes)));
};
#else
template <class T>
struct RegisterOf {
    using type = T;
};
#endif

/// `lane_count<T>` numbers held in registers, with elementwise arithmetic. The loops below run over
/// registers (one to four), never over lanes, and disappear.
template <Scalar T>
struct Pack {
    using Register = typename RegisterOf<T>::type;
    static constexpr std::size_t count = 64 / sizeof(Register);

    struct Mask {
        using Part = decltype(Register{} < Register{});
        Part m[count];

        friend Mask operator&(Mask a, const Mask& b) noexcept {
            for (std::size_t k = 0; k < count; ++k) a.m[k] = a.m[k] & b.m[k];
            return a;
        }
        friend Mask operator|(Mask a, const Mask& b) noexcept {
            for (std::size_t k = 0; k < count; ++k) a.m[k] = a.m[k] | b.m[k];
            return a;
        }
    };

    Register r[count];

    Pack() noexcept = default;
    Pack(T x) noexcept { // NOLINT(google-explicit-constructor): constants in formulas
        for (std::size_t k = 0; k < count; ++k) r[k] = x - Register{};
    }
    static Pack load(const Lanes<T>& lanes) noexcept {
        Pack p;
        std::memcpy(&p.r, &lanes.v, sizeof(p.r));
        return p;
    }
    void store(Lanes<T>& lanes) const noexcept { std::memcpy(&lanes.v, &r, sizeof(r)); }

    friend Pack operator+(Pack a, const Pack& b) noexcept {
        for (std::size_t k = 0; k < count; ++k) a.r[k] = a.r[k] + b.r[k];
        return a;
    }
    friend Pack operator-(Pack a, const Pack& b) noexcept {
        for (std::size_t k = 0; k < count; ++k) a.r[k] = a.r[k] - b.r[k];
        return a;
    }
    friend Pack operator*(Pack a, const Pack& b) noexcept {
        for (std::size_t k = 0; k < count; ++k) a.r[k] = a.r[k] * b.r[k];
        return a;
    }
    friend Pack operator/(Pack a, const Pack& b) noexcept {
        for (std::size_t k = 0; k < count; ++k) a.r[k] = a.r[k] / b.r[k];
        return a;
    }
    friend Mask operator<(const Pack& a, const Pack& b) noexcept {
        Mask m;
        for (std::size_t k = 0; k < count; ++k) m.m[k] = a.r[k] < b.r[k];
        return m;
    }
    friend Mask operator<=(const Pack& a, const Pack& b) noexcept {
        Mask m;
        for (std::size_t k = 0; k < count; ++k) m.m[k] = a.r[k] <= b.r[k];
        return m;
    }
};

template <Scalar T>
Pack<T> select(const typename Pack<T>::Mask& m, Pack<T> a, const Pack<T>& b) noexcept {
    for (std::size_t k = 0; k < Pack<T>::count; ++k) a.r[k] = m.m[k] ? a.r[k] : b.r[k];
    return a;
}

template <Scalar T>
Pack<T> abs(const Pack<T>& a) noexcept {
    return select<T>(a < Pack<T>(T(0)), Pack<T>(T(0)) - a, a);
}

template <Scalar T>
Pack<T> max(const Pack<T>& a, const Pack<T>& b) noexcept {
    return select<T>(a < b, b, a);
}

template <Scalar T>
Pack<T> min(const Pack<T>& a, const Pack<T>& b) noexcept {
    return select<T>(a < b, a, b);
}

/// Square roots. Written with intrinsics because a loop over std::sqrt stays scalar unless the user
/// compiles with -fno-math-errno: 3 times slower binding (bench/mean_value.cpp).
template <Scalar T>
Pack<T> sqrt(Pack<T> a) noexcept {
    for (std::size_t k = 0; k < Pack<T>::count; ++k) {
        auto& x = a.r[k];
#if CAGEFORM_REGISTER_BYTES == 64
        if constexpr (sizeof(T) == 8)
            x = __builtin_bit_cast(typename Pack<T>::Register,
                                   _mm512_sqrt_pd(__builtin_bit_cast(__m512d, x)));
        else
            x = __builtin_bit_cast(typename Pack<T>::Register, _mm512_sqrt_ps(__builtin_bit_cast(__m512, x)));
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

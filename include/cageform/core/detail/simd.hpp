// One row of a block in vector registers, with elementwise arithmetic.
#pragma once

#include <cageform/core/types/blocks.hpp>

#include <array>
#include <cstring>
#include <utility>

// Builds without registers (scalars only) are for checking, not for speed.
#if defined(__GNUC__) && CAGEFORM_REGISTER_BYTES != 0
#define CAGEFORM_DETAIL_INLINE __attribute__((always_inline))
#define CAGEFORM_DETAIL_FLATTEN __attribute__((flatten))
#define CAGEFORM_DETAIL_NO_INLINE __attribute__((noinline))
// Unrolls a short loop whose length is a compile-time constant. At -O2, GCC would otherwise keep the
// loop and the arrays it indexes in memory.
#define CAGEFORM_DETAIL_UNROLL _Pragma("GCC unroll 16")
#else
#define CAGEFORM_DETAIL_INLINE
#define CAGEFORM_DETAIL_FLATTEN
#define CAGEFORM_DETAIL_NO_INLINE
#define CAGEFORM_DETAIL_UNROLL
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

/// Loads a number or register from unaligned bytes. Without optimisation, a memcpy would become two
/// moves of half the size, and the read that follows would stall.
template <class R>
CAGEFORM_DETAIL_INLINE inline R load_bytes(const void* bytes) noexcept {
#if CAGEFORM_REGISTER_BYTES != 0
    typedef R Anywhere __attribute__((aligned(1), may_alias));
    return *static_cast<const Anywhere*>(bytes);
#else
    R r;
    std::memcpy(&r, bytes, sizeof(r));
    return r;
#endif
}
template <class R>
CAGEFORM_DETAIL_INLINE inline void store_bytes(void* bytes, const R& r) noexcept {
#if CAGEFORM_REGISTER_BYTES != 0
    typedef R Anywhere __attribute__((aligned(1), may_alias));
    *static_cast<Anywhere*>(bytes) = r;
#else
    std::memcpy(bytes, &r, sizeof(r));
#endif
}

/// Prefetches the cache line `ahead` bytes further on into the second-level cache. The address may
/// lie past the end of the memory.
CAGEFORM_DETAIL_INLINE inline void prefetch([[maybe_unused]] const void* bytes,
                                            [[maybe_unused]] std::size_t ahead) noexcept {
#if defined(__GNUC__)
    // NOLINTNEXTLINE(performance-no-int-to-ptr): avoids pointer arithmetic past the end
    __builtin_prefetch(reinterpret_cast<const void*>(reinterpret_cast<std::uintptr_t>(bytes) + ahead), 0, 2);
#endif
}

/// Hides a number or register from the optimiser, at no cost in instructions. Prevents compilers from
/// merging operations before and after this call.
template <class R>
CAGEFORM_DETAIL_INLINE inline void optimizer_barrier([[maybe_unused]] R& r) noexcept {
#if defined(__GNUC__) && defined(__SSE2__)
    __asm__("" : "+v"(r));
#elif defined(__GNUC__) && defined(__aarch64__)
    __asm__("" : "+w"(r));
#elif defined(__GNUC__) && defined(__arm__) && defined(CAGEFORM_DETAIL_FUSED)
    if constexpr (!std::is_arithmetic_v<R>) { // a register emulated with scalars
        for (std::size_t lane = 0; lane < sizeof(r) / sizeof(r[0]); ++lane) {
            auto x = r[lane];
            optimizer_barrier(x);
            r[lane] = x;
        }
    } else if constexpr (sizeof(r) == 4) {
        __asm__("" : "+t"(r));
    } else {
        __asm__("" : "+w"(r));
    }
#elif defined(CAGEFORM_DETERMINISTIC) && !(defined(__GNUC__) && (defined(__arm__) || defined(__wasm__)))
#error "CAGEFORM_DETERMINISTIC supports GNU and clang on x86 with SSE2, on ARM and on WebAssembly"
#endif // the other targets have no fused instruction
}

/// Returns a · b for numbers or registers. Under CAGEFORM_DETERMINISTIC, the product is rounded separately.
template <class R>
CAGEFORM_DETAIL_INLINE inline R product(const R& a, const R& b) noexcept {
#if defined(CAGEFORM_DETERMINISTIC)
    R ab = a * b;
    optimizer_barrier(ab); // or compilers would fuse it with an addition, each by its own rules
    return ab;
#else
    return a * b;
#endif
}

/// Returns a · b + c for numbers or registers, with the rounding described at `multiply_add` below.
template <class R>
CAGEFORM_DETAIL_INLINE inline R multiply_add(R a, R b, R c) noexcept {
#if defined(CAGEFORM_DETERMINISTIC)
    return product(a, b) + c;
#elif defined(__clang__) && defined(CAGEFORM_DETAIL_FUSED)
#if __has_builtin(__builtin_elementwise_fma)
    return __builtin_elementwise_fma(a, b, c); // clang does not fuse across functions by itself
#else
    return a * b + c; // clang before 16 lacks the builtin, and fuses within one expression
#endif
#else
    return a * b + c;
#endif
}

/// `lane_count<T>` numbers held in registers, with elementwise arithmetic. The loops below run over
/// registers (one to four), never over lanes, and are fully unrolled.
template <Scalar T>
struct Simd {
    using Register = typename RegisterOf<T>::type;
    static constexpr std::size_t count = 64 / sizeof(Register);

    struct Mask {
        using RegisterMask = decltype(Register{} < Register{});
        RegisterMask m[count];

        friend Mask operator&(Mask a, const Mask& b) noexcept {
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < count; ++k) a.m[k] = a.m[k] & b.m[k];
            return a;
        }
        friend Mask operator|(Mask a, const Mask& b) noexcept {
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < count; ++k) a.m[k] = a.m[k] | b.m[k];
            return a;
        }
        friend Mask operator^(Mask a, const Mask& b) noexcept {
            CAGEFORM_DETAIL_UNROLL
            for (std::size_t k = 0; k < count; ++k) a.m[k] = a.m[k] ^ b.m[k];
            return a;
        }
    };

    Register r[count];

    Simd() noexcept = default;
    Simd(T x) noexcept { // NOLINT(google-explicit-constructor): constants in formulas
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t k = 0; k < count; ++k) r[k] = x - Register{};
    }
    static Simd load(const Lanes<T>& lanes) noexcept {
        Simd p; // one register at a time: GCC would copy the array in pieces of another width
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t k = 0; k < count; ++k)
            p.r[k] = load_bytes<Register>(lanes.v + k * (64 / sizeof(T) / count));
        return p;
    }
    void store(Lanes<T>& lanes) const noexcept {
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t k = 0; k < count; ++k) store_bytes(lanes.v + k * (64 / sizeof(T) / count), r[k]);
    }

    friend Simd operator+(Simd a, const Simd& b) noexcept {
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t k = 0; k < count; ++k) a.r[k] = a.r[k] + b.r[k];
        return a;
    }
    friend Simd operator-(Simd a, const Simd& b) noexcept {
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t k = 0; k < count; ++k) a.r[k] = a.r[k] - b.r[k];
        return a;
    }
    friend Simd operator*(Simd a, const Simd& b) noexcept {
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t k = 0; k < count; ++k) a.r[k] = product(a.r[k], b.r[k]);
        return a;
    }
    friend Simd operator/(Simd a, const Simd& b) noexcept {
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t k = 0; k < count; ++k) a.r[k] = a.r[k] / b.r[k];
        return a;
    }
    friend Simd operator-(const Simd& a) noexcept { return Simd(T(0)) - a; }
    Simd& operator+=(const Simd& b) noexcept { return *this = *this + b; }
    Simd& operator-=(const Simd& b) noexcept { return *this = *this - b; }
    Simd& operator*=(const Simd& b) noexcept { return *this = *this * b; }
    friend Mask operator<(const Simd& a, const Simd& b) noexcept {
        Mask m;
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t k = 0; k < count; ++k) m.m[k] = a.r[k] < b.r[k];
        return m;
    }
    friend Mask operator<=(const Simd& a, const Simd& b) noexcept {
        Mask m;
        CAGEFORM_DETAIL_UNROLL
        for (std::size_t k = 0; k < count; ++k) m.m[k] = a.r[k] <= b.r[k];
        return m;
    }
};

template <Scalar T>
CAGEFORM_DETAIL_INLINE inline Simd<T> select(const typename Simd<T>::Mask& m, Simd<T> a,
                                             const Simd<T>& b) noexcept {
    CAGEFORM_DETAIL_UNROLL
    for (std::size_t k = 0; k < Simd<T>::count; ++k) a.r[k] = m.m[k] ? a.r[k] : b.r[k];
    return a;
}

/// Returns a · b + c with one rounding or two, depending on compiler and target; under
/// CAGEFORM_DETERMINISTIC always with two.
template <Scalar T>
Simd<T> multiply_add(const Simd<T>& a, const Simd<T>& b, Simd<T> c) noexcept {
    CAGEFORM_DETAIL_UNROLL
    for (std::size_t k = 0; k < Simd<T>::count; ++k) c.r[k] = multiply_add(a.r[k], b.r[k], c.r[k]);
    return c;
}

/// The integer type with the bits of a number, or of a register's lanes.
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

template <Scalar T>
CAGEFORM_DETAIL_INLINE inline Simd<T> abs(Simd<T> a) noexcept {
    using Register = typename Simd<T>::Register;
    using Bits = typename BitsOf<Register>::type;
    using Int = typename BitsOf<T>::type;
    CAGEFORM_DETAIL_UNROLL
    for (std::size_t k = 0; k < Simd<T>::count; ++k)
        a.r[k] = __builtin_bit_cast(Register,
                                    __builtin_bit_cast(Bits, a.r[k]) & (std::numeric_limits<Int>::max)());
    return a;
}

// The names are parenthesised because windows.h defines macros of these names.
template <Scalar T>
CAGEFORM_DETAIL_INLINE inline Simd<T>(max)(const Simd<T>& a, const Simd<T>& b) noexcept {
    return select<T>(a < b, b, a);
}

template <Scalar T>
CAGEFORM_DETAIL_INLINE inline Simd<T>(min)(const Simd<T>& a, const Simd<T>& b) noexcept {
    return select<T>(a < b, a, b);
}

/// Loads lanes [first, first + lane_count<S>) of a row, converted to another scalar.
template <Scalar S, Scalar T>
Simd<S> load_lanes(const Lanes<T>& row, [[maybe_unused]] std::size_t first) noexcept {
    if constexpr (std::is_same_v<S, T>) {
        return Simd<S>::load(row);
    } else {
        Lanes<S> chunk;
        for (std::size_t lane = 0; lane < lane_count<S>; ++lane) chunk[lane] = S(row[first + lane]);
        return Simd<S>::load(chunk);
    }
}
template <Scalar S, Scalar T>
void store_lanes(const Simd<S>& x, Lanes<T>& row, [[maybe_unused]] std::size_t first) noexcept {
    if constexpr (std::is_same_v<S, T>) {
        x.store(row);
    } else {
        Lanes<S> chunk;
        x.store(chunk);
        for (std::size_t lane = 0; lane < lane_count<S>; ++lane) row[first + lane] = T(chunk[lane]);
    }
}

/// Returns the sum of the lanes, added in order.
template <Scalar T>
T ordered_sum(const Simd<T>& x) noexcept {
    Lanes<T> lanes;
    x.store(lanes);
    T sum = 0;
    for (const T lane : lanes.v) sum += lane;
    return sum;
}

/// Evaluates a polynomial in x by Horner's rule. Its coefficients are c[last], c[last − 2], …, from the
/// highest power down. Its degree is the length of the index sequence.
template <Scalar T, std::size_t n, std::size_t... k>
CAGEFORM_DETAIL_INLINE inline Simd<T> every_second(const std::array<T, n>& c, std::size_t last,
                                                   const Simd<T>& x, std::index_sequence<k...>) noexcept {
    Simd<T> sum(c[last]);
    ((sum = sum * x + Simd<T>(c[last - 2 * k - 2])), ...);
    return sum;
}

/// Evaluates c[0] + c[1] x + c[2] x² + … as independent even and odd halves, which halves the latency.
/// Uses a fold expression, because GCC would keep a loop and reload its constants.
template <Scalar T, std::size_t n>
CAGEFORM_DETAIL_INLINE inline Simd<T> polynomial(const std::array<T, n>& c, const Simd<T>& x) noexcept {
    static_assert(n >= 3);
    constexpr std::size_t even = (n - 1) / 2, odd = n / 2 - 1; // terms of each half after the first
    const Simd<T> xx = x * x;
    return every_second(c, 2 * odd + 1, xx, std::make_index_sequence<odd>()) * x +
           every_second(c, 2 * even, xx, std::make_index_sequence<even>());
}

} // namespace cageform::inline CAGEFORM_ABI::detail

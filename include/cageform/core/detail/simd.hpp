// One row of a block as registers, with elementwise arithmetic. Light enough for run time.
#pragma once

#include <cageform/core/blocks.hpp>

#include <cstring>

// Plain scalars are for checking, not for speed.
#if defined(__GNUC__) && CAGEFORM_REGISTER_BYTES != 0
#define CAGEFORM_DETAIL_INLINE __attribute__((always_inline))
#define CAGEFORM_DETAIL_FLATTEN __attribute__((flatten))
#define CAGEFORM_DETAIL_NO_INLINE __attribute__((noinline))
#else
#define CAGEFORM_DETAIL_INLINE
#define CAGEFORM_DETAIL_FLATTEN
#define CAGEFORM_DETAIL_NO_INLINE
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

/// A number or register from bytes that lie anywhere. Without optimisation a memcpy is two moves of
/// half the size, and what reads the whole waits for both.
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

/// Leaves a number or register as it is, in a way that compilers cannot look through; takes no
/// instruction. Where they must not merge what comes before with what comes after.
template <class R>
CAGEFORM_DETAIL_INLINE inline void conceal([[maybe_unused]] R& r) noexcept {
#if defined(__GNUC__) && defined(__SSE2__)
    __asm__("" : "+v"(r));
#elif defined(__GNUC__) && defined(__aarch64__)
    __asm__("" : "+w"(r));
#elif defined(CAGEFORM_DETERMINISTIC)
#error "CAGEFORM_DETERMINISTIC knows GNU and clang on x86 and 64-bit ARM"
#endif
}

/// a · b of numbers or registers; under CAGEFORM_DETERMINISTIC rounded before it meets a sum.
template <class R>
CAGEFORM_DETAIL_INLINE inline R product(const R& a, const R& b) noexcept {
#if defined(CAGEFORM_DETERMINISTIC)
    R ab = a * b;
    conceal(ab); // or it would become one instruction with the sum, by each compiler's own rules
    return ab;
#else
    return a * b;
#endif
}

/// a · b + c of numbers or registers, rounded as `multiply_add` of registers says.
template <class R>
CAGEFORM_DETAIL_INLINE inline R multiply_add(R a, R b, R c) noexcept {
#if defined(CAGEFORM_DETERMINISTIC)
    return product(a, b) + c;
#elif defined(__clang__) && (defined(__FMA__) || defined(__aarch64__))
    return __builtin_elementwise_fma(a, b, c); // clang does not merge across functions by itself
#else
    return a * b + c;
#endif
}

/// `lane_count<T>` numbers held in registers, with elementwise arithmetic. The loops below run over
/// registers (one to four), never over lanes, and disappear.
template <Scalar T>
struct Simd {
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

    Simd() noexcept = default;
    Simd(T x) noexcept { // NOLINT(google-explicit-constructor): constants in formulas
        for (std::size_t k = 0; k < count; ++k) r[k] = x - Register{};
    }
    static Simd load(const Lanes<T>& lanes) noexcept {
        Simd p; // register by register: as a whole GNU would copy in pieces of another width
        for (std::size_t k = 0; k < count; ++k)
            p.r[k] = load_bytes<Register>(lanes.v + k * (64 / sizeof(T) / count));
        return p;
    }
    void store(Lanes<T>& lanes) const noexcept {
        for (std::size_t k = 0; k < count; ++k) store_bytes(lanes.v + k * (64 / sizeof(T) / count), r[k]);
    }

    friend Simd operator+(Simd a, const Simd& b) noexcept {
        for (std::size_t k = 0; k < count; ++k) a.r[k] = a.r[k] + b.r[k];
        return a;
    }
    friend Simd operator-(Simd a, const Simd& b) noexcept {
        for (std::size_t k = 0; k < count; ++k) a.r[k] = a.r[k] - b.r[k];
        return a;
    }
    friend Simd operator*(Simd a, const Simd& b) noexcept {
        for (std::size_t k = 0; k < count; ++k) a.r[k] = product(a.r[k], b.r[k]);
        return a;
    }
    friend Simd operator/(Simd a, const Simd& b) noexcept {
        for (std::size_t k = 0; k < count; ++k) a.r[k] = a.r[k] / b.r[k];
        return a;
    }
    friend Simd operator-(const Simd& a) noexcept { return Simd(T(0)) - a; }
    Simd& operator+=(const Simd& b) noexcept { return *this = *this + b; }
    Simd& operator-=(const Simd& b) noexcept { return *this = *this - b; }
    Simd& operator*=(const Simd& b) noexcept { return *this = *this * b; }
    friend Mask operator<(const Simd& a, const Simd& b) noexcept {
        Mask m;
        for (std::size_t k = 0; k < count; ++k) m.m[k] = a.r[k] < b.r[k];
        return m;
    }
    friend Mask operator<=(const Simd& a, const Simd& b) noexcept {
        Mask m;
        for (std::size_t k = 0; k < count; ++k) m.m[k] = a.r[k] <= b.r[k];
        return m;
    }
};

/// Whether a comparison holds in any lane.
template <class M>
bool any(const M& mask) noexcept {
    std::uint64_t words[sizeof(M) / 8], all = 0;
    std::memcpy(words, &mask, sizeof(words));
    for (const std::uint64_t word : words) all |= word;
    return all != 0;
}

template <Scalar T>
Simd<T> select(const typename Simd<T>::Mask& m, Simd<T> a, const Simd<T>& b) noexcept {
    for (std::size_t k = 0; k < Simd<T>::count; ++k) a.r[k] = m.m[k] ? a.r[k] : b.r[k];
    return a;
}

/// a · b + c. One rounding or two, as the compiler and its target have it; under
/// CAGEFORM_DETERMINISTIC always two.
template <Scalar T>
Simd<T> multiply_add(const Simd<T>& a, const Simd<T>& b, Simd<T> c) noexcept {
    for (std::size_t k = 0; k < Simd<T>::count; ++k) c.r[k] = multiply_add(a.r[k], b.r[k], c.r[k]);
    return c;
}

template <Scalar T>
Simd<T> abs(const Simd<T>& a) noexcept {
    return select<T>(a < Simd<T>(T(0)), Simd<T>(T(0)) - a, a);
}

// Named in parentheses, for windows.h defines macros of these names.
template <Scalar T>
Simd<T>(max)(const Simd<T>& a, const Simd<T>& b) noexcept {
    return select<T>(a < b, b, a);
}

template <Scalar T>
Simd<T>(min)(const Simd<T>& a, const Simd<T>& b) noexcept {
    return select<T>(a < b, a, b);
}

/// Lanes [first, first + lane_count<S>) of a row, in another scalar.
template <Scalar S, Scalar T>
Simd<S> load_lanes(const Lanes<T>& row, [[maybe_unused]] std::size_t first) noexcept {
    if constexpr (std::is_same_v<S, T>) {
        return Simd<S>::load(row);
    } else {
        Lanes<S> part;
        for (std::size_t lane = 0; lane < lane_count<S>; ++lane) part[lane] = S(row[first + lane]);
        return Simd<S>::load(part);
    }
}
template <Scalar S, Scalar T>
void store_lanes(const Simd<S>& x, Lanes<T>& row, [[maybe_unused]] std::size_t first) noexcept {
    if constexpr (std::is_same_v<S, T>) {
        x.store(row);
    } else {
        Lanes<S> part;
        x.store(part);
        for (std::size_t lane = 0; lane < lane_count<S>; ++lane) row[first + lane] = T(part[lane]);
    }
}

/// Σ x^k/(2k + 1) over `terms` of them, an even number: the series of atan and artanh. In two halves
/// side by side, which take half as long one after the other.
template <int terms, Scalar T>
Simd<T> odd_series(const Simd<T>& x) noexcept {
    static_assert(terms % 2 == 0);
    const Simd<T> xx = x * x;
    Simd<T> even(T(1) / T(2 * terms - 3)), odd(T(1) / T(2 * terms - 1));
    for (int k = terms - 4; k >= 0; k -= 2) {
        even = even * xx + Simd<T>(T(1) / T(2 * k + 1));
        odd = odd * xx + Simd<T>(T(1) / T(2 * k + 3));
    }
    return odd * x + even;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

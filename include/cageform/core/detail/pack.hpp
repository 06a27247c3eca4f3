// One row of a block as registers, with elementwise arithmetic. Light enough for run time.
#pragma once

#include <cageform/core/blocks.hpp>

#include <cstring>

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

} // namespace cageform::inline CAGEFORM_ABI::detail

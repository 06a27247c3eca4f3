// Loads rows of weights from storage formats into registers.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/figure/packed_binding.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#if CAGEFORM_REGISTER_BYTES != 0
/// Integer vectors with as many lanes as a register of T.
template <class Whole, class T>
struct WholeOf {
    typedef Whole type __attribute__((vector_size(register_bytes / sizeof(T) * sizeof(Whole))));
};
template <class To, class From>
CAGEFORM_DETAIL_INLINE inline To convert_lanes(From from) noexcept {
    return __builtin_convertvector(from, To);
}
#else
template <class Whole, class T>
struct WholeOf {
    using type = Whole;
};
template <class To, class From>
CAGEFORM_DETAIL_INLINE inline To convert_lanes(From from) noexcept {
    return static_cast<To>(from);
}
#endif
template <class Whole, class T>
using Wholes = typename WholeOf<Whole, T>::type;

/// Calls use.operator()<Format>() with a constant format, and returns its result.
template <class Use>
auto with_format(WeightFormat format, const Use& use) noexcept {
    switch (format) {
#define CAGEFORM_DETAIL_FORMAT(name, ...)                                                                    \
    case WeightFormat::name: return use.template operator()<WeightFormat::name>();
        CAGEFORM_WEIGHT_FORMATS(CAGEFORM_DETAIL_FORMAT)
#undef CAGEFORM_DETAIL_FORMAT
    }
    return decltype(use.template operator()<WeightFormat::scalar>())();
}

/// Loads one register of weights in a format.
template <WeightFormat Format, Scalar T>
CAGEFORM_DETAIL_INLINE inline typename Simd<T>::Register load_weights(const std::byte* bytes) noexcept {
    using Register = typename Simd<T>::Register;
    if constexpr (Format == WeightFormat::scalar) {
        return load_bytes<Register>(bytes);
    } else if constexpr (Format == WeightFormat::int16) {
        const auto q = load_bytes<Wholes<std::int16_t, T>>(bytes);
        return convert_lanes<Register>(convert_lanes<Wholes<std::int32_t, T>>(q));
    } else if constexpr (Format == WeightFormat::int8) {
        const auto q = load_bytes<Wholes<std::int8_t, T>>(bytes);
        // Converts in two steps, because GCC has instructions for both.
        const auto wider = convert_lanes<Wholes<std::int16_t, T>>(q);
        return convert_lanes<Register>(convert_lanes<Wholes<std::int32_t, T>>(wider));
    } else {
        // Shifts the exponent to its position in a float. The factor corrects the different bias.
        const auto h = load_bytes<Wholes<std::uint16_t, T>>(bytes);
        const auto wide = convert_lanes<Wholes<std::uint32_t, T>>(h);
        const Wholes<std::uint32_t, T> bits = ((wide & 0x7FFFu) << 13) | ((wide & 0x8000u) << 16);
        Wholes<float, T> f;
        std::memcpy(&f, &bits, sizeof(f));
        return convert_lanes<Register>(f) * T(0x1p112f);
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// Converts weights to the formats of a packed binding.
#pragma once

#include <cageform/figure/packed_binding.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the nearest binary16 number (ties to even, subnormals flushed to zero); |x| must be below 65504.
inline std::uint16_t to_half(double x) noexcept {
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(x));
    const std::uint32_t sign = (bits >> 16) & 0x8000u, magnitude = bits & 0x7FFFFFFFu;
    if (magnitude < 0x38800000u) return static_cast<std::uint16_t>(sign);
    const std::uint32_t rounded = magnitude + 0x0FFFu + ((magnitude >> 13) & 1u);
    return static_cast<std::uint16_t>(sign | ((rounded - 0x38000000u) >> 13));
}
inline double from_half(std::uint16_t half) noexcept {
    const std::uint32_t bits = ((half & 0x7FFFu) << 13) | (std::uint32_t(half & 0x8000u) << 16);
    return double(std::bit_cast<float>(bits)) * 0x1p112;
}

/// Writes the weights of a block to `to` and replaces `weights` by the stored values. Returns the scale.
template <Scalar T>
T store_weights(WeightFormat format, std::span<double> weights, std::byte* to) {
    const auto write = [&to](auto x) {
        std::memcpy(to, &x, sizeof(x));
        to += sizeof(x);
        return double(x);
    };
    if (format == WeightFormat::scalar) {
        for (double& w : weights) w = write(static_cast<T>(w));
        return T(1);
    }
    double largest = 0;
    for (const double w : weights) largest = (std::max)(largest, std::fabs(w));
    // Keeps halves above the subnormal range, which some processors flush to zero.
    const double reach = format == WeightFormat::int16  ? 32767.0
                         : format == WeightFormat::int8 ? 127.0
                                                        : 32768.0;
    const T scale = largest > 0 ? static_cast<T>(largest / reach) : T(1);
    for (double& w : weights) {
        const double q = std::clamp(w / double(scale), -reach, reach);
        if (format == WeightFormat::half) {
            const auto half = to_half(q);
            write(half);
            w = double(scale) * from_half(half);
        } else if (format == WeightFormat::int16) {
            w = double(scale) * write(static_cast<std::int16_t>(std::nearbyint(q)));
        } else {
            w = double(scale) * write(static_cast<std::int8_t>(std::nearbyint(q)));
        }
    }
    return scale;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// Extrapolates curves to times outside their range. For run time.
#pragma once

#include <cageform/core/detail/simd.hpp>

#include <cmath>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

/// The values of a curve before its first key and after its last.
enum class Extrapolation : std::uint8_t {
    constant,          ///< the nearest value
    linear,            ///< a straight line with the slope at the nearest key
    cycle,             ///< repeats from the beginning
    cycle_with_offset, ///< repeats; each cycle starts at the last value of the one before
    ping_pong,         ///< repeats, alternately backwards and forwards
};

/// A time mapped into the range of a curve by its extrapolation.
template <Scalar T>
struct FoldedTime {
    T time = 0;   ///< in the range
    T cycles = 0; ///< for cycle_with_offset: the number of complete repetitions
    T beyond = 0; ///< for linear: the distance beyond the range, negative before it

    /// Returns the extrapolated value.
    ///
    ///  value  the curve's value at `time`
    ///  slope  the slope at the end of the range that is nearer to the original time
    ///  rise   the curve's last value minus its first
    T extend(T value, T slope, T rise) const noexcept {
        return detail::multiply_add(beyond, slope, detail::multiply_add(cycles, rise, value));
    }
};

/// Maps a time into the range begin … end; times in the range are unchanged. O(1).
template <Scalar T>
FoldedTime<T> fold_time(T x, T begin, T end, Extrapolation before, Extrapolation after) noexcept {
    if (x >= begin && x <= end) return {x, 0, 0};
    const bool early = x < begin;
    const auto mode = early ? before : after;
    const T edge = early ? begin : end, length = end - begin;
    if (mode == Extrapolation::constant || !(length > 0) || !is_finite(x)) return {edge, 0, 0};
    if (mode == Extrapolation::linear) return {edge, 0, x - edge};
    const double cycles = std::floor((double(x) - double(begin)) / double(length));
    double offset = detail::multiply_add(-cycles, double(length), double(x) - double(begin));
    offset = offset < 0 ? 0 : offset > double(length) ? double(length) : offset;
    if (mode == Extrapolation::ping_pong && cycles - 2 * std::floor(cycles / 2) == 1)
        offset = double(length) - offset;
    return {static_cast<T>(double(begin) + offset),
            mode == Extrapolation::cycle_with_offset ? static_cast<T>(cycles) : T(0), 0};
}

} // namespace cageform::inline CAGEFORM_ABI

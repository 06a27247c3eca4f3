// Checks shared by the importers and exporters of keyframes.
#pragma once

#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/result.hpp>
#include <cageform/exchange/types/key_interval.hpp>

#include <bit>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns the status of `check`, or time_not_monotone if a handle is longer than two intervals. Such
/// handles never give monotone time, and they may overflow in `check`.
inline Status check_curve(const BezierCurve& curve) noexcept {
    const Status status = check(curve).status;
    if (status != Status::ok) return status;
    const auto& p = curve.points;
    const double length = p[3][0] - p[0][0];
    const bool fits = (p[1][0] - p[0][0]) / length <= 2 && (p[3][0] - p[2][0]) / length <= 2;
    return fits ? status : Status::time_not_monotone;
}

inline Result<KeyInterval> refused(Status status) noexcept {
    return {{}, status};
}

inline Result<KeyInterval> imported(KeyKind kind, const BezierCurve& curve) noexcept {
    const Status status = check_curve(curve);
    if (status != Status::ok) return refused(status);
    return {{kind, curve}, status};
}

/// Checks a number that must be a fraction of an interval.
inline Status check_fraction(double fraction) noexcept {
    if (!is_finite(fraction)) return Status::value_not_finite;
    return fraction >= 0 && fraction <= 1 ? Status::ok : Status::handle_not_allowed;
}

/// Returns the straight line between two keys. Its handles lie at thirds, so time is linear in the parameter.
inline BezierCurve straight_line(const Vec<double, 2>& first, const Vec<double, 2>& second) noexcept {
    const Vec<double, 2> third{(second[0] - first[0]) / 3, (second[1] - first[1]) / 3};
    return {{first, first + third, second - third, second}};
}

inline Result<KeyInterval> constant_interval(const Vec<double, 2>& first, double second_time) noexcept {
    return imported(KeyKind::hold, straight_line(first, {second_time, first[1]}));
}

inline bool has(WeightedHandles set, WeightedHandles one) noexcept {
    return (unsigned(set) & unsigned(one)) != 0;
}

inline WeightedHandles with(WeightedHandles set, WeightedHandles one, bool on) noexcept {
    return WeightedHandles((unsigned(set) & ~unsigned(one)) | (on ? unsigned(one) : 0));
}

/// Returns infinity, also if compiled with -ffast-math.
inline double infinite() noexcept {
    return std::bit_cast<double>(std::uint64_t{0x7ff0000000000000});
}

/// Whether `x` is infinite and not NaN. Tests the bits, like is_finite, so that the result is right with
/// -ffast-math too.
inline bool is_infinite(double x) noexcept {
    return !is_finite(x) && (std::bit_cast<std::uint64_t>(x) << 12) == 0;
}

/// Whether a number is finite in single precision, which engines and glTF store.
inline bool fits_float(double x) noexcept {
    return is_finite(x) && std::fabs(x) <= double((std::numeric_limits<float>::max)());
}

inline bool is_third(double fraction) noexcept {
    return std::fabs(fraction) < 1 && static_cast<float>(fraction) == 1.0f / 3;
}

/// Computes the slope of a handle; 0 if the handle lies on its key. Returns slope_unbounded if the handle is
/// vertical or too steep for single precision, because an infinite slope would mean a hold.
inline Status slope_of(const Vec<double, 2>& handle, double& slope) noexcept {
    slope = 0;
    if (handle[0] == 0 && handle[1] == 0) return Status::ok;
    if (handle[0] == 0) return Status::slope_unbounded;
    const double quotient = handle[1] / handle[0];
    if (!fits_float(quotient)) return Status::slope_unbounded;
    slope = quotient;
    return Status::ok;
}

/// Handles as fractions of the interval and of the difference between the keys' values, as in CSS and Lottie.
struct UnitHandles {
    Vec<double, 2> first{0, 0}, second{1, 1};
};

/// Converts a curve's handles to fractions.
///
///   fails  as `check`; handle_not_allowed if a handle's time leaves the interval, or if the keys have equal
///          values and a handle has a different value; value_not_finite if a fraction overflows
inline Result<UnitHandles> unit_handles(const BezierCurve& curve) noexcept {
    if (const Status status = check_curve(curve); status != Status::ok) return {{}, status};
    UnitHandles unit;
    Status status = Status::ok;
    const auto& p = curve.points;
    const double length = curve.end() - curve.begin(), rise = p[3][1] - p[0][1];
    unit.first = {(p[1][0] - p[0][0]) / length, 0};
    unit.second = {(p[2][0] - p[0][0]) / length, 1};
    for (const double fraction : {unit.first[0], unit.second[0]}) {
        if (!(fraction >= 0 && fraction <= 1)) status = Status::handle_not_allowed;
    }
    if (rise != 0) {
        unit.first[1] = (p[1][1] - p[0][1]) / rise;
        unit.second[1] = (p[2][1] - p[0][1]) / rise;
    } else if (p[1][1] != p[0][1] || p[2][1] != p[0][1]) {
        status = Status::handle_not_allowed;
    }
    for (auto* handle : {&unit.first, &unit.second}) {
        // Adding 0.0 turns −0, which a falling curve can give, into 0.
        for (std::size_t k = 0; k < 2; ++k) (*handle)[k] += 0.0;
    }
    if (!is_finite(unit.first[1]) || !is_finite(unit.second[1])) status = Status::value_not_finite;
    return {unit, status};
}

template <class K>
Vec<double, 2> position_of(const K& key) noexcept {
    if constexpr (requires { key.co; })
        return key.co;
    else
        return {key.time, key.value};
}

/// Imports keys interval by interval: interval(first, second) converts one interval. The keys reproduce the
/// intervals bit by bit.
template <class K, class Interval>
Result<std::vector<Key>, ExchangeReport> import_keys(std::span<const K> keyframes,
                                                     const Interval& interval) noexcept {
    Result<std::vector<Key>, ExchangeReport> result;
    result.report.status = guard_memory([&] {
        const std::size_t count = keyframes.size();
        if (count == 0) return Status::keys_missing;
        std::vector<Key> keys(count);
        for (std::size_t n = 0; n < count; ++n) {
            const Vec<double, 2> at = position_of(keyframes[n]);
            keys[n].time = at[0];
            keys[n].value = at[1];
            keys[n].kind = KeyKind::bezier;
            if (n == 0) keys[n].in_handle = at;
            keys[n].out_handle = at;
            if (n + 1 == count) continue;
            result.report.culprit = n;
            const Result<KeyInterval> imported = interval(keyframes[n], keyframes[n + 1]);
            if (!imported) return imported.status();
            const auto& [kind, curve] = imported.value;
            keys[n].kind = kind;
            if (kind == KeyKind::bezier) keys[n].out_handle = curve.points[1];
            keys[n + 1].in_handle = kind == KeyKind::bezier ? curve.points[2] : position_of(keyframes[n + 1]);
            keys[n + 1].arrives_by_handle = kind == KeyKind::bezier;
        }
        result.report.culprit = count - 1;
        if (!is_finite(position_of(keyframes.back()))) return Status::value_not_finite;
        result.report.culprit = 0;
        result.value = std::move(keys);
        return Status::ok;
    });
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

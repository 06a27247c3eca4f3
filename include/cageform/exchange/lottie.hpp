// Imports and exports the easing of Lottie keyframes.
#pragma once

#include <cageform/core/result.hpp>
#include <cageform/exchange/detail/easing.hpp>

#include <initializer_list>
#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// A handle as fractions: x of the interval's duration, y of the difference between the keys' values. In the
/// file both are numbers, or arrays with one number per component; an array of one number applies to all
/// components.
struct LottieHandle {
    double x = 0, y = 0;

    friend bool operator==(const LottieHandle&, const LottieHandle&) = default;
};

/// The members `o`, `i` and `h` of a keyframe. They define the easing to the next keyframe; `i` too is stored
/// in the first of the two keyframes. Linear by default.
struct LottieEasing {
    LottieHandle out{0, 0}, in{1, 1};
    bool hold = false;

    friend bool operator==(const LottieEasing&, const LottieEasing&) = default;
};

/// Imports the curve between two keyframes.
///
///   first, second  times (in frames) and values (of one component) of both keyframes
///   fails          value_not_finite; interval_empty; handle_not_allowed if an x is outside [0, 1]. A y
///                  outside [0, 1] is accepted: the specification's prose forbids it, but its schema and
///                  the players allow overshoot
/// Lottie specification 1.0, Properties, "Keyframes" and "Keyframe Easing".
inline Result<KeyInterval> from_lottie(const LottieEasing& easing, const Vec<double, 2>& first,
                                       const Vec<double, 2>& second) noexcept {
    if (easing.hold) return detail::constant_interval(first, second[0]);
    for (const LottieHandle& handle : {easing.out, easing.in}) {
        if (!is_finite(handle.y)) return detail::refused(Status::value_not_finite);
        if (const Status status = detail::check_fraction(handle.x); status != Status::ok)
            return detail::refused(status);
    }
    const auto position = [&](const LottieHandle& handle) {
        return Vec<double, 2>{std::lerp(first[0], second[0], handle.x),
                              std::lerp(first[1], second[1], handle.y)};
    };
    return detail::imported(KeyKind::bezier, {{first, position(easing.out), position(easing.in), second}});
}

/// Exports a curve as the easing of its first keyframe. Handles are written only for KeyKind::bezier.
///
///   level  a constant curve gets 0 and 1 as its y values, because any easing between equal values is
///          constant
///   fails  as `check`; handle_not_allowed if a handle's time leaves the interval, or if the keys have equal
///          values and a handle has a different value, which Lottie cannot express; value_not_finite
inline Result<LottieEasing> to_lottie(const BezierCurve& curve, KeyKind kind = KeyKind::bezier) noexcept {
    Result<LottieEasing> result;
    result.value.hold = kind == KeyKind::hold;
    if (kind != KeyKind::bezier) {
        result.report = detail::check_curve(curve);
        return result;
    }
    const auto [unit, status] = detail::unit_handles(curve);
    result.report = status;
    if (status == Status::ok)
        result.value = {{unit.first[0], unit.first[1]}, {unit.second[0], unit.second[1]}, false};
    return result;
}

/// A keyframe of one component, with the easing to the next keyframe.
struct LottieKey {
    double time = 0, value = 0; ///< the time in frames
    LottieEasing easing;
};

/// Imports all keyframes of one component, in frames, by `from_lottie`. Fails as `from_lottie`, at the
/// first interval that fails.
inline Result<std::vector<Key>, ExchangeReport>
keys_from_lottie(std::span<const LottieKey> keyframes) noexcept {
    return detail::import_keys(keyframes, [](const LottieKey& first, const LottieKey& second) {
        return from_lottie(first.easing, detail::position_of(first), detail::position_of(second));
    });
}

} // namespace cageform::inline CAGEFORM_ABI

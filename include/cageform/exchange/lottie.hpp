// Imports and exports the easing of Lottie keyframes.
#pragma once

#include <cageform/core/result.hpp>
#include <cageform/exchange/detail/easing.hpp>

#include <initializer_list>
#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// A handle as fractions: x of the interval's time, y of the rise from the first key's value to the
/// second's. In the file both are numbers, or arrays with one number per component of the value; an
/// array of one serves all components.
struct LottieHandle {
    double x = 0, y = 0;

    friend bool operator==(const LottieHandle&, const LottieHandle&) = default;
};

/// The members `o`, `i` and `h` of a keyframe, which define the easing to the next keyframe; `i`
/// too is stored in the first of the two. Linear by default.
struct LottieEasing {
    LottieHandle out{0, 0}, in{1, 1};
    bool hold = false;

    friend bool operator==(const LottieEasing&, const LottieEasing&) = default;
};

/// Imports the curve from a keyframe to the next.
///
///   first, second  times (in frames) and values (of one component) of both keyframes
///   fails          value_not_finite; interval_empty; handle_not_allowed if an x leaves [0, 1]. A y
///                  may leave it: the specification's prose forbids that, but its schema and the
///                  players allow overshooting handles.
/// Lottie specification 1.0, Properties, "Keyframes" and "Keyframe Easing".
inline Result<KeyInterval> from_lottie(const LottieEasing& easing, const Vec<double, 2>& first,
                                       const Vec<double, 2>& second) noexcept {
    if (easing.hold) return detail::held(first, second[0]);
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

/// Exports a curve as the easing of the first of the two keyframes at its ends. Kinds other than
/// bezier have no handles.
///
///   level  a constant curve equals any easing between equal values; its y are 0 and 1
///   fails  as `check`; handle_not_allowed if a handle's time leaves the interval, or if the keys
///          have one value and a handle another: Lottie has no easing for an overshoot between
///          equal values; value_not_finite
inline Result<LottieEasing> to_lottie(const BezierCurve& curve, KeyKind kind = KeyKind::bezier) noexcept {
    Result<LottieEasing> result;
    result.value.hold = kind == KeyKind::hold;
    if (kind != KeyKind::bezier) {
        result.report = detail::sound(curve);
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

/// Imports all keyframes of one component as keys to be compiled, in frames; `from_lottie` makes
/// the curves between them. Fails as it does, for the first interval that is refused.
inline Result<std::vector<Key>, ExchangeReport>
keys_from_lottie(std::span<const LottieKey> keyframes) noexcept {
    const auto position = [&](std::size_t n) {
        return Vec<double, 2>{keyframes[n].time, keyframes[n].value};
    };
    return detail::import_keys(
        keyframes.size(),
        [&](std::size_t n) { return from_lottie(keyframes[n].easing, position(n), position(n + 1)); },
        position);
}

} // namespace cageform::inline CAGEFORM_ABI

// Imports and exports keyframes of Unity's AnimationCurve.
#pragma once

#include <cageform/exchange/detail/easing.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// A UnityEngine.Keyframe. Tangents are slopes (value per time). Weights are fractions of the interval on
/// their side, in [0, 1]. Unity stores single precision. An import followed by an export returns the same
/// single-precision numbers, unless a handle is shorter than 1e-7 of its key's coordinates.
struct UnityKey {
    double time = 0, value = 0;
    double in_tangent = 0, out_tangent = 0;
    double in_weight = 1.0 / 3, out_weight = 1.0 / 3;
    WeightedHandles weighted = WeightedHandles::none; ///< weightedMode
};

/// Imports the curve between two keyframes. A handle lies on its tangent, at its weight's fraction of the
/// interval, or at a third if it is unweighted. An infinite tangent at either end holds the first value.
///
///   reads  the out tangent and weight of `first`, the in tangent and weight of `second`; weights only if
///          `weighted` includes their side
///   fails  value_not_finite; interval_empty; handle_not_allowed if a weight is outside [0, 1]
/// Unity Scripting API, Keyframe ("Hermite Segment", "Bezier Segment") and WeightedMode.
inline Result<KeyInterval> from_unity(const UnityKey& first, const UnityKey& second) noexcept {
    if (detail::is_infinite(first.out_tangent) || detail::is_infinite(second.in_tangent))
        return detail::constant_interval({first.time, first.value}, second.time);
    constexpr double third = 1.0 / 3;
    const double out = detail::has(first.weighted, WeightedHandles::out) ? first.out_weight : third;
    const double in = detail::has(second.weighted, WeightedHandles::in) ? second.in_weight : third;
    for (const double weight : {out, in}) {
        if (const Status status = detail::check_fraction(weight); status != Status::ok)
            return detail::refused(status);
    }
    const double length = second.time - first.time;
    return detail::imported(
        KeyKind::bezier,
        {{{{first.time, first.value},
           {std::lerp(first.time, second.time, out), first.value + out * length * first.out_tangent},
           {std::lerp(second.time, first.time, in), second.value - in * length * second.in_tangent},
           {second.time, second.value}}}});
}

/// Exports a curve to two keyframes: times, values, and the tangents, weights and weighted sides between
/// them. A handle at a third is written unweighted. The outer tangents belong to the neighbouring curves.
///
///   hold    gives an infinite tangent; the second key's value does not change
///   linear  gives the straight line between the keys; the handles are ignored
///   fails   as `check`; handle_not_allowed if a handle's time leaves the interval; slope_unbounded if a
///           handle is vertical or too steep for single precision; nothing is written then
inline Status to_unity(const BezierCurve& curve, UnityKey& first, UnityKey& second,
                       KeyKind kind = KeyKind::bezier) noexcept {
    Status status = detail::check_curve(curve);
    if (status != Status::ok) return status;
    const auto p = kind == KeyKind::linear ? detail::straight_line(curve.points[0], curve.points[3]).points
                                           : curve.points;
    constexpr double third = 1.0 / 3;
    double out_tangent = detail::infinite(), in_tangent = out_tangent;
    double out = third, in = third;
    if (kind != KeyKind::hold) {
        if (status = detail::slope_of(p[1] - p[0], out_tangent); status != Status::ok) return status;
        if (status = detail::slope_of(p[3] - p[2], in_tangent); status != Status::ok) return status;
    }
    if (kind == KeyKind::bezier) {
        out = (p[1][0] - p[0][0]) / (p[3][0] - p[0][0]);
        in = (p[3][0] - p[2][0]) / (p[3][0] - p[0][0]);
        if (!(out <= 1 && in <= 1)) return Status::handle_not_allowed;
    }
    first.time = p[0][0];
    first.value = p[0][1];
    first.out_tangent = out_tangent;
    first.out_weight = out;
    first.weighted = detail::with(first.weighted, WeightedHandles::out, !detail::is_third(out));
    second.time = p[3][0];
    if (kind != KeyKind::hold) second.value = p[3][1];
    second.in_tangent = in_tangent;
    second.in_weight = in;
    second.weighted = detail::with(second.weighted, WeightedHandles::in, !detail::is_third(in));
    return Status::ok;
}

/// Imports all keyframes of an AnimationCurve, in seconds, by `from_unity`. Fails as `from_unity`, at the
/// first interval that fails.
inline Result<std::vector<Key>, ExchangeReport>
keys_from_unity(std::span<const UnityKey> keyframes) noexcept {
    return detail::import_keys(keyframes, from_unity);
}

} // namespace cageform::inline CAGEFORM_ABI

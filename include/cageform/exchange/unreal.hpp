// Imports and exports keys of Unreal's rich curves.
#pragma once

#include <cageform/exchange/detail/easing.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// An FRichCurveKey. Tangents are slopes (value per second). Weights are the lengths of the handles in the
/// time–value plane, with seconds and units of the value on equal scales. Unreal stores single precision.
/// An import followed by an export returns the same single-precision numbers, unless a handle is shorter
/// than 1e-7 of its key's coordinates. `interpolation` applies between this key and the next: RCIM_Constant
/// is hold, RCIM_Cubic bezier.
struct UnrealKey {
    double time = 0, value = 0;
    double arrive_tangent = 0, leave_tangent = 0;
    double arrive_weight = 0, leave_weight = 0;
    WeightedHandles weighted = WeightedHandles::none; ///< TangentWeightMode
    KeyKind interpolation = KeyKind::bezier;
};

/// Imports the curve between two keys.
///
///   reads  the leave tangent and weight of `first`, the arrive tangent and weight of `second`; weights
///          only if `weighted` includes their side
///   fails  value_not_finite; interval_empty; time_not_monotone if weights are negative or too long
/// Unreal Engine C++ API, FRichCurveKey, ERichCurveInterpMode and ERichCurveTangentWeightMode.
inline Result<KeyInterval> from_unreal(const UnrealKey& first, const UnrealKey& second) noexcept {
    const Vec<double, 2> begin{first.time, first.value}, end{second.time, second.value};
    if (first.interpolation == KeyKind::hold) return detail::constant_interval(begin, second.time);
    if (first.interpolation == KeyKind::linear)
        return detail::imported(KeyKind::linear, detail::straight_line(begin, end));
    const double length = second.time - first.time;
    // The vector from a key to the end of its handle, directed into the interval. A weighted handle has
    // length `weight`; an unweighted one spans a third of the interval.
    const auto handle = [length](double slope, double weight, bool weighted) {
        const double time = weighted ? weight / std::hypot(1.0, slope) : length / 3;
        return Vec<double, 2>{time, time * slope};
    };
    const auto leave =
        handle(first.leave_tangent, first.leave_weight, detail::has(first.weighted, WeightedHandles::out));
    const auto arrive = handle(second.arrive_tangent, second.arrive_weight,
                               detail::has(second.weighted, WeightedHandles::in));
    return detail::imported(KeyKind::bezier, {{begin, begin + leave, end - arrive, end}});
}

/// Exports a curve to two keys: times, values, the tangents, weights and weighted sides between them, and the
/// interpolation. A handle at a third is written unweighted. The outer tangents belong to the neighbouring
/// curves. The tangent mode must be RCTM_User or RCTM_Break; otherwise Unreal recomputes the tangents.
///
///   hold   the second key's value does not change
///   fails  as `check`; slope_unbounded if a handle is vertical or too steep for single precision; nothing
///          is written then
inline Status to_unreal(const BezierCurve& curve, UnrealKey& first, UnrealKey& second,
                        KeyKind kind = KeyKind::bezier) noexcept {
    Status status = detail::check_curve(curve);
    if (status != Status::ok) return status;
    const auto& p = curve.points;
    if (kind == KeyKind::bezier) {
        const Vec<double, 2> leave = p[1] - p[0], arrive = p[3] - p[2];
        double leave_tangent = 0, arrive_tangent = 0;
        if (status = detail::slope_of(leave, leave_tangent); status != Status::ok) return status;
        if (status = detail::slope_of(arrive, arrive_tangent); status != Status::ok) return status;
        const double length = p[3][0] - p[0][0];
        first.leave_tangent = leave_tangent;
        first.leave_weight = std::hypot(leave[0], leave[1]);
        first.weighted =
            detail::with(first.weighted, WeightedHandles::out, !detail::is_third(leave[0] / length));
        second.arrive_tangent = arrive_tangent;
        second.arrive_weight = std::hypot(arrive[0], arrive[1]);
        second.weighted =
            detail::with(second.weighted, WeightedHandles::in, !detail::is_third(arrive[0] / length));
    }
    first.time = p[0][0];
    first.value = p[0][1];
    first.interpolation = kind;
    second.time = p[3][0];
    if (kind != KeyKind::hold) second.value = p[3][1];
    return Status::ok;
}

/// Imports all keys of a rich curve, in seconds, by `from_unreal`. Fails as `from_unreal`, at the first
/// interval that fails.
inline Result<std::vector<Key>, ExchangeReport>
keys_from_unreal(std::span<const UnrealKey> rich_curve) noexcept {
    return detail::import_keys(rich_curve, from_unreal);
}

} // namespace cageform::inline CAGEFORM_ABI

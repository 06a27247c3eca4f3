// Imports and exports keys of Unreal's rich curves.
#pragma once

#include <cageform/exchange/detail/easing.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// An FRichCurveKey. Tangents are slopes (value per second). Weights are the lengths of the handles
/// in the time–value plane, with seconds and units of the value on equal scales. Unreal stores all
/// in single precision. A round trip gives the same rounded numbers, unless a handle is shorter
/// than 1e-7 of its key's coordinates. `interpolation` applies between this key and the next:
/// RCIM_Constant is hold, RCIM_Cubic bezier.
struct UnrealKey {
    double time = 0, value = 0;
    double arrive_tangent = 0, leave_tangent = 0;
    double arrive_weight = 0, leave_weight = 0;
    WeightedHandles weighted = WeightedHandles::none; ///< TangentWeightMode
    KeyKind interpolation = KeyKind::bezier;
};

/// Imports the curve from a key to the next.
///
///   reads  the leave tangent and weight of `first`, the arrive tangent and weight of `second`; a
///          weight only if `weighted` says so
///   fails  value_not_finite; interval_empty; time_not_monotone if weights are negative or too long
/// Unreal Engine C++ API, FRichCurveKey, ERichCurveInterpMode and ERichCurveTangentWeightMode.
inline Result<KeyInterval> from_unreal(const UnrealKey& first, const UnrealKey& second) noexcept {
    const Vec<double, 2> begin{first.time, first.value}, end{second.time, second.value};
    if (first.interpolation == KeyKind::hold) return detail::held(begin, second.time);
    if (first.interpolation == KeyKind::linear)
        return detail::imported(KeyKind::linear, detail::straight(begin, end));
    const double length = second.time - first.time;
    // Returns the vector from a key to the end of its handle, towards the interval. A weighted handle
    // has the given length along the slope; any other spans a third of the interval.
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

/// Exports a curve to two keys: writes times, values, the tangents, weights and weighted sides
/// between the keys, and the interpolation. A handle at a third is written unweighted. The outer
/// tangents belong to the neighbouring curves. The tangent mode must be RCTM_User or RCTM_Break, or
/// Unreal recomputes the tangents.
///
///   hold   the second key's value is left alone
///   fails  as `check`; slope_unbounded if a handle is vertical or too steep for single precision;
///          nothing is written then
inline Status to_unreal(const BezierCurve& curve, UnrealKey& first, UnrealKey& second,
                        KeyKind kind = KeyKind::bezier) noexcept {
    Status status = detail::sound(curve);
    if (status != Status::ok) return status;
    const auto& p = curve.points;
    if (kind == KeyKind::bezier) {
        const Vec<double, 2> leave = p[1] - p[0], arrive = p[3] - p[2];
        double leave_tangent = 0, arrive_tangent = 0;
        status = detail::slope_of(leave, leave_tangent);
        if (status != Status::ok) return status;
        status = detail::slope_of(arrive, arrive_tangent);
        if (status != Status::ok) return status;
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

/// Imports all keys of a rich curve as keys to be compiled, in seconds; `from_unreal` makes the
/// curves between them. Fails as it does, for the first interval that is refused.
inline Result<std::vector<Key>, ExchangeReport>
keys_from_unreal(std::span<const UnrealKey> rich_curve) noexcept {
    return detail::import_keys(
        rich_curve.size(), [&](std::size_t n) { return from_unreal(rich_curve[n], rich_curve[n + 1]); },
        [&](std::size_t n) {
            return Vec<double, 2>{rich_curve[n].time, rich_curve[n].value};
        });
}

} // namespace cageform::inline CAGEFORM_ABI

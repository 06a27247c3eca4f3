// Keys of Unreal's rich curves.
#pragma once

#include <cageform/exchange/detail/easing.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// An FRichCurveKey: tangents are slopes (value by second), weights the lengths of the handles in
/// the plane of time and value, seconds and units of the value taken alike. Unreal stores all in
/// single precision. Numbers read and written again round to the same ones, unless a handle is
/// shorter than 1e-7 of its key's coordinates. `interpolation` says how the next key is reached:
/// RCIM_Constant is hold, RCIM_Cubic bezier.
struct UnrealKey {
    double time = 0, value = 0;
    double arrive_tangent = 0, leave_tangent = 0;
    double arrive_weight = 0, leave_weight = 0;
    WeightedHandles weighted = WeightedHandles::none; ///< TangentWeightMode
    KeyKind interpolation = KeyKind::bezier;
};

namespace detail {

/// From the key to the end of its handle, towards the interval: of the given length along the slope
/// where weighted, else as far as a third of the interval.
inline Vec<double, 2> unreal_handle(double slope, double weight, bool weighted, double length) noexcept {
    const double time = weighted ? weight / std::hypot(1.0, slope) : length / 3;
    return {time, time * slope};
}

} // namespace detail

/// The curve from a key to the next.
///
///   reads  of `first` the leave, of `second` the arrive tangent and weight; a weight only where
///          `weighted` says so
///   fails  value_not_finite; interval_empty; curve_turns_back where weights are negative or too
///          long
/// Unreal Engine C++ API, FRichCurveKey, ERichCurveInterpMode and ERichCurveTangentWeightMode.
inline Result<KeyInterval> from_unreal(const UnrealKey& first, const UnrealKey& second) noexcept {
    const Vec<double, 2> begin{first.time, first.value}, end{second.time, second.value};
    if (first.interpolation == KeyKind::hold) return detail::held(begin, second.time);
    if (first.interpolation == KeyKind::linear)
        return detail::imported(KeyKind::linear, detail::straight(begin, end));
    const double length = second.time - first.time;
    const auto leave = detail::unreal_handle(first.leave_tangent, first.leave_weight,
                                             detail::has(first.weighted, WeightedHandles::out), length);
    const auto arrive = detail::unreal_handle(second.arrive_tangent, second.arrive_weight,
                                              detail::has(second.weighted, WeightedHandles::in), length);
    return detail::imported(KeyKind::bezier, {{begin, begin + leave, end - arrive, end}});
}

/// Writes what a curve says of two keys: times, values, tangents, weights and weighted sides
/// between them, how the second is reached. A handle at a third goes unweighted. The outer tangents
/// are the neighbours'. The tangent mode must be RCTM_User or RCTM_Break, or Unreal computes the
/// tangents anew.
///
///   hold   the second key's value is left alone
///   fails  as `check`; slope_unbounded where a handle is vertical or too steep for single
///          precision; nothing is written then
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

/// All keys of a rich curve as keys to be compiled, in seconds: the curves between are those of
/// `from_unreal`. Fails as it does, for the first interval that is refused.
inline Result<std::vector<Key>, ExchangeReport>
keys_from_unreal(std::span<const UnrealKey> rich_curve) noexcept {
    return detail::import_keys(
        rich_curve.size(), [&](std::size_t n) { return from_unreal(rich_curve[n], rich_curve[n + 1]); },
        [&](std::size_t n) {
            return Vec<double, 2>{rich_curve[n].time, rich_curve[n].value};
        });
}

} // namespace cageform::inline CAGEFORM_ABI

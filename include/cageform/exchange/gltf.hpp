// Imports glTF 2.0 animation samplers of any interpolation, and exports curves as CUBICSPLINE.
#pragma once

#include <cageform/exchange/detail/easing.hpp>
#include <cageform/exchange/detail/gltf_sampler.hpp>

#include <span>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

struct GltfTrack {
    std::vector<float> times;  ///< the sampler's input, in seconds
    std::vector<float> values; ///< the sampler's output: in-tangent, value and out-tangent of each key
};

enum class GltfInterpolation : std::uint8_t { linear, step, cubicspline };

/// Imports the arrays of a sampler as keys, one curve per component. CUBICSPLINE gives handles at thirds of
/// the interval, on the tangents; LINEAR gives straight lines, and STEP gives held values.
///
///   times       #K, in seconds, ascending; a single key is allowed
///   values      #K · components; for CUBICSPLINE 3 · #K · components: in-tangent, value and out-tangent of
///               each key, with tangents per second. Normalise a rotation after evaluation. For LINEAR
///               rotations the result is not the slerp of the glTF standard
///   components  3 for translation and scale, 4 for rotation; for weights, the number of morph targets
///   fails       input_malformed if the sizes do not match, or for no keys or components; value_not_finite,
///               also for the unused first in- and last out-tangent; keys_not_ascending; out_of_memory
/// glTF 2.0, sec. 3.11 and appendix C, "Cubic Spline Interpolation".
inline Result<std::vector<std::vector<Key>>, ExchangeReport>
keys_from_gltf(std::span<const float> times, std::span<const float> values, std::size_t components,
               GltfInterpolation interpolation) noexcept {
    const bool cubic = interpolation == GltfInterpolation::cubicspline;
    const std::size_t keys = times.size(), rows = cubic ? 3 : 1;
    if (const auto sound = detail::check_gltf(times, values, components, rows); sound.status != Status::ok)
        return {{}, sound};
    Result<std::vector<std::vector<Key>>, ExchangeReport> result;
    result.report.status =
        detail::guard_memory([&] { result.value.assign(components, std::vector<Key>(keys)); });
    for (std::size_t index = 0; index < result.value.size() * keys; ++index) {
        const std::size_t k = index / components, c = index % components;
        const auto of_key = [&](std::size_t row) {
            return double(values[(rows * k + row) * components + c]);
        };
        Key& key = result.value[c][k];
        key.time = times[k];
        key.value = of_key(cubic ? 1 : 0);
        key.kind = cubic                                      ? KeyKind::hermite
                   : interpolation == GltfInterpolation::step ? KeyKind::hold
                                                              : KeyKind::linear;
        if (!cubic) continue;
        key.in_slope = of_key(0);
        key.out_slope = of_key(2);
    }
    return result;
}

/// Imports a CUBICSPLINE sampler as Bézier curves, without loss: curves[interval · components + component].
/// Fails as `keys_from_gltf`; input_malformed also for a single key.
inline Result<std::vector<BezierCurve>, ExchangeReport>
from_gltf_cubicspline(std::span<const float> times, std::span<const float> values,
                      std::size_t components) noexcept {
    if (times.size() < 2) return {{}, {Status::input_malformed, 0}};
    const auto keys = keys_from_gltf(times, values, components, GltfInterpolation::cubicspline);
    Result<std::vector<BezierCurve>, ExchangeReport> result{{}, keys.report};
    if (!keys) return result;
    result.report.status = detail::guard_memory([&] {
        for (std::size_t k = 0; k + 1 < times.size(); ++k) {
            for (const auto& curve : keys.value) result.value.push_back(key_interval(curve, k));
        }
    });
    return result;
}

/// Exports curves as one sampler. Time must be linear in the parameter, as in curves fitted by this library
/// and those of `from_gltf_cubicspline`; fit other curves first.
///
///   curves      #I · components, #I ≥ 1: curves[interval · components + component]. All components have
///               the same consecutive intervals, and each curve begins at the value where the curve before
///               it ends
///   components  at least 1
///   tangents    scaled by the single-precision length of the interval, so that handles keep their values;
///               the first in- and the last out-tangent are 0
///   fails       as `check`; input_malformed if the sizes do not match, if neighbouring intervals or values
///               do not meet, or if time begins before 0; interval_empty if times coincide in single
///               precision; handle_not_allowed if a handle is off its third by more than 1e-7 of the
///               interval; value_not_finite and slope_unbounded if a value or tangent is too large for
///               single precision; out_of_memory
/// glTF 2.0, sec. 3.11 and appendix C, "Cubic Spline Interpolation".
inline Result<GltfTrack, ExchangeReport> to_gltf_cubicspline(std::span<const BezierCurve> curves,
                                                             std::size_t components) noexcept {
    const auto refused = [](Status status, std::size_t index) {
        return Result<GltfTrack, ExchangeReport>{{}, {status, index}};
    };
    if (components == 0 || curves.empty() || curves.size() % components != 0)
        return refused(Status::input_malformed, 0);
    const std::size_t intervals = curves.size() / components;
    GltfTrack track;
    const Status status = detail::guard_memory([&] {
        track.times.resize(intervals + 1);
        track.values.resize(3 * (intervals + 1) * components);
    });
    if (status != Status::ok) return refused(status, 0);
    for (std::size_t index = 0; index < curves.size(); ++index) {
        const std::size_t k = index / components, c = index % components;
        const auto interval = detail::gltf_interval(curves[index]);
        if (interval.status != Status::ok) return refused(interval.status, index);
        if (index == 0) track.times[0] = interval.begin;
        if (c == 0) track.times[k + 1] = interval.end;
        const bool same_time = interval.begin == track.times[k] && interval.end == track.times[k + 1];
        if (!same_time || (k > 0 && !detail::values_meet(curves[index - components], curves[index])))
            return refused(Status::input_malformed, index);
        const auto& p = curves[index].points;
        const double third = (double(interval.end) - double(interval.begin)) / 3;
        const double out = (p[1][1] - p[0][1]) / third, in = (p[3][1] - p[2][1]) / third;
        if (!detail::fits_float(out) || !detail::fits_float(in))
            return refused(Status::slope_unbounded, index);
        float* const values = track.values.data() + 3 * k * components + c;
        values[components] = static_cast<float>(p[0][1]);
        values[2 * components] = static_cast<float>(out);
        values[3 * components] = static_cast<float>(in);
        values[4 * components] = static_cast<float>(p[3][1]);
    }
    return {std::move(track), {}};
}

} // namespace cageform::inline CAGEFORM_ABI

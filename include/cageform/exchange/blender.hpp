// Imports and exports keyframes of Blender's F-curves.
#pragma once

#include <cageform/exchange/detail/blender_handles.hpp>
#include <cageform/exchange/detail/easing.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// A bpy.types.Keyframe. Points are (frame, value); Blender stores them in single precision.
/// `interpolation` applies between this keyframe and the next; CONSTANT is hold.
struct BlenderKey {
    Vec<double, 2> co{}, handle_left{}, handle_right{};
    KeyKind interpolation = KeyKind::bezier;
};

/// How Blender shortens long handles when it evaluates a curve. The stored handles do not change.
enum class BlenderLimit : std::uint8_t {
    /// A handle longer in time than the interval is scaled to the interval's length. Blender 3.4.1.
    each_handle,
    /// If the lengths in time of both handles add up to more than the interval, both are scaled to fit.
    /// Earlier versions of Blender.
    both_together,
};

/// Imports the curve between two keyframes as Blender evaluates it, with long handles shortened.
///
///   fails  value_not_finite; interval_empty; time_not_monotone if a handle points away from the interval
/// The easing interpolations (SINE, BOUNCE, …) are not Bézier curves; they are not supported. Blender manual,
/// Graph Editor, F-Curves, "Handles" and "Interpolation"; the limits were measured with fcurve.evaluate().
inline Result<KeyInterval> from_blender(const BlenderKey& first, const BlenderKey& second,
                                        BlenderLimit limit = BlenderLimit::each_handle) noexcept {
    if (first.interpolation == KeyKind::hold) return detail::constant_interval(first.co, second.co[0]);
    if (first.interpolation == KeyKind::linear)
        return detail::imported(KeyKind::linear, detail::straight_line(first.co, second.co));
    const BezierCurve stored{{first.co, first.handle_right, second.handle_left, second.co}};
    for (const auto& p : stored.points) {
        if (!is_finite(p)) return detail::refused(Status::value_not_finite);
    }
    if (!(second.co[0] > first.co[0])) return detail::refused(Status::interval_empty);
    return detail::imported(KeyKind::bezier,
                            detail::with_blender_limit(stored, limit == BlenderLimit::each_handle));
}

/// Exports a curve to two keyframes: their points, the handles between them and the interpolation. The outer
/// handles belong to the neighbouring curves. Both handle types must be FREE (or ALIGNED); otherwise Blender
/// recomputes the handles.
///
///   hold   the second key's value does not change
///   fails  as `check`; handle_not_allowed if Blender would shorten a handle; nothing is written then
inline Status to_blender(const BezierCurve& curve, BlenderKey& first, BlenderKey& second,
                         KeyKind kind = KeyKind::bezier,
                         BlenderLimit limit = BlenderLimit::each_handle) noexcept {
    if (const Status status = detail::check_curve(curve); status != Status::ok) return status;
    const auto& p = curve.points;
    if (kind == KeyKind::bezier) {
        const auto kept = detail::with_blender_limit(curve, limit == BlenderLimit::each_handle).points;
        const double off = std::fabs(kept[1][0] - p[1][0]) + std::fabs(kept[2][0] - p[2][0]);
        const double rounding = 4 * epsilon<double> * (std::fabs(p[0][0]) + std::fabs(p[3][0]));
        if (off > rounding) return Status::handle_not_allowed;
    }
    first.co = p[0];
    first.handle_right = p[1];
    first.interpolation = kind;
    second.co = {p[3][0], kind == KeyKind::hold ? second.co[1] : p[3][1]};
    second.handle_left = kind == KeyKind::hold ? second.co : p[2];
    return Status::ok;
}

/// Imports all keyframes of an F-curve, in frames, by `from_blender`. Fails as `from_blender`, at the first
/// interval that fails.
inline Result<std::vector<Key>, ExchangeReport>
keys_from_blender(std::span<const BlenderKey> keyframes,
                  BlenderLimit limit = BlenderLimit::each_handle) noexcept {
    return detail::import_keys(keyframes, [&](const BlenderKey& first, const BlenderKey& second) {
        return from_blender(first, second, limit);
    });
}

} // namespace cageform::inline CAGEFORM_ABI

// Types and checks shared by the importers and exporters of keyframe curves.
#pragma once

#include <cageform/animate/key.hpp>
#include <cageform/core/detail/guard_memory.hpp>

#include <bit>
#include <limits>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Which handles of a key have an explicit length. The numbers match Unity's WeightedMode and
/// Unreal's ERichCurveTangentWeightMode, which call `in` arrive and `out` leave.
enum class WeightedHandles : std::uint8_t { none = 0, in = 1, out = 2, both = 3 };

/// An interval between two keys of another program. If `status` is ok, `curve` passes `check`;
/// otherwise it is all zeros. For a held key the curve is constant at the first key's value; the
/// second key's value starts the next interval.
struct ImportedCurve {
    Status status = Status::ok;
    KeyKind kind = KeyKind::bezier;
    BezierCurve curve{};
};

/// The keys of a curve, in the form that `compile_track` and `compile_clip` take.
struct ImportedKeys {
    /// keys_missing, out_of_memory, or the status of the first interval that is refused.
    Status status = Status::ok;
    std::size_t culprit = 0; ///< the key that this interval begins with
    std::vector<Key> keys;   ///< empty unless the status is ok
};

namespace detail {

/// Checks as `check` does, and that no handle is farther from its key than two intervals. Beyond
/// that, time turns back in any case, and the numbers that `check` compares may overflow.
inline Status sound(const BezierCurve& curve) noexcept {
    const Status status = check(curve).status;
    if (status != Status::ok) return status;
    const auto& p = curve.points;
    const double length = p[3][0] - p[0][0];
    const bool fits = (p[1][0] - p[0][0]) / length <= 2 && (p[3][0] - p[2][0]) / length <= 2;
    return fits ? status : Status::curve_turns_back;
}

inline ImportedCurve refused(Status status, KeyKind kind = KeyKind::bezier) noexcept {
    return {status, kind, {}};
}

inline ImportedCurve imported(KeyKind kind, const BezierCurve& curve) noexcept {
    const Status status = sound(curve);
    return status == Status::ok ? ImportedCurve{status, kind, curve} : refused(status, kind);
}

/// Checks a number that must be a fraction of an interval.
inline Status check_part(double part) noexcept {
    if (!is_finite(part)) return Status::value_not_finite;
    return part >= 0 && part <= 1 ? Status::ok : Status::handle_not_allowed;
}

/// Returns the straight line between two keys with its handles at thirds, so that time is linear in
/// the curve's parameter.
inline BezierCurve straight(const Vec<double, 2>& first, const Vec<double, 2>& second) noexcept {
    const Vec<double, 2> third{(second[0] - first[0]) / 3, (second[1] - first[1]) / 3};
    return {{first, first + third, second - third, second}};
}

inline ImportedCurve held(const Vec<double, 2>& first, double second_time) noexcept {
    return imported(KeyKind::hold, straight(first, {second_time, first[1]}));
}

inline bool has(WeightedHandles set, WeightedHandles one) noexcept {
    return (unsigned(set) & unsigned(one)) != 0;
}

inline WeightedHandles with(WeightedHandles set, WeightedHandles one, bool on) noexcept {
    return WeightedHandles((unsigned(set) & ~unsigned(one)) | (on ? unsigned(one) : 0));
}

/// Returns infinity, under -ffast-math too.
inline double infinite() noexcept {
    return std::bit_cast<double>(std::uint64_t{0x7ff0000000000000});
}

/// Whether `x` is infinite and not NaN. Tests the bits, as is_finite does.
inline bool is_infinite(double x) noexcept {
    return !is_finite(x) && (std::bit_cast<std::uint64_t>(x) << 12) == 0;
}

/// Whether a number is finite in single precision, which engines and glTF store; larger ones would
/// become infinite.
inline bool fits_float(double x) noexcept {
    return is_finite(x) && std::fabs(x) <= double((std::numeric_limits<float>::max)());
}

/// Whether a fraction of an interval is a third in single precision.
inline bool is_third(double part) noexcept {
    return std::fabs(part) < 1 && static_cast<float>(part) == 1.0f / 3;
}

/// Finds the slope of a handle; 0 if it lies on its key. Returns slope_unbounded if it is vertical
/// or too steep for single precision: an infinite slope would mean a held key.
inline Status slope_of(const Vec<double, 2>& handle, double& slope) noexcept {
    slope = 0;
    if (handle[0] == 0 && handle[1] == 0) return Status::ok;
    if (handle[0] == 0) return Status::slope_unbounded;
    const double quotient = handle[1] / handle[0];
    if (!fits_float(quotient)) return Status::slope_unbounded;
    slope = quotient;
    return Status::ok;
}

/// The handles as fractions of the interval and of the rise between the keys, as CSS and Lottie
/// store them.
struct UnitHandles {
    Status status = Status::ok;
    Vec<double, 2> first{0, 0}, second{1, 1};
};

/// Converts a curve's handles. Fails as `check`; with handle_not_allowed if a handle's time leaves
/// the interval, or if the keys have the same value and a handle another; with value_not_finite if
/// a fraction overflows.
inline UnitHandles unit_handles(const BezierCurve& curve) noexcept {
    UnitHandles result;
    result.status = sound(curve);
    if (result.status != Status::ok) return result;
    const auto& p = curve.points;
    const double length = curve.end() - curve.begin(), rise = p[3][1] - p[0][1];
    result.first = {(p[1][0] - p[0][0]) / length, 0};
    result.second = {(p[2][0] - p[0][0]) / length, 1};
    for (const double part : {result.first[0], result.second[0]}) {
        if (!(part >= 0 && part <= 1)) result.status = Status::handle_not_allowed;
    }
    if (rise != 0) {
        result.first[1] = (p[1][1] - p[0][1]) / rise;
        result.second[1] = (p[2][1] - p[0][1]) / rise;
    } else if (p[1][1] != p[0][1] || p[2][1] != p[0][1]) {
        result.status = Status::handle_not_allowed;
    }
    for (auto* handle : {&result.first, &result.second}) {
        // In a falling curve a fraction may be −0; adding 0 keeps it out of texts.
        for (std::size_t k = 0; k < 2; ++k) (*handle)[k] += 0.0;
    }
    if (!is_finite(result.first[1]) || !is_finite(result.second[1])) result.status = Status::value_not_finite;
    return result;
}

/// Builds the keys of a curve by importing its intervals: interval(n) is the curve from key n to
/// the next, place(n) the time and value of key n. The keys reproduce the imported intervals of
/// their kinds bit by bit.
template <class Interval, class Place>
ImportedKeys import_keys(std::size_t count, const Interval& interval, const Place& place) noexcept {
    ImportedKeys result;
    result.status = guard_memory([&] {
        if (count == 0) return Status::keys_missing;
        std::vector<Key> keys(count);
        for (std::size_t n = 0; n < count; ++n) {
            const Vec<double, 2> at = place(n);
            keys[n].time = at[0];
            keys[n].value = at[1];
            keys[n].kind = KeyKind::bezier;
            if (n == 0) keys[n].in_handle = at;
            keys[n].out_handle = at;
            if (n + 1 == count) continue;
            result.culprit = n;
            const ImportedCurve curve = interval(n);
            if (curve.status != Status::ok) return curve.status;
            keys[n].kind = curve.kind;
            if (curve.kind == KeyKind::bezier) keys[n].out_handle = curve.curve.points[1];
            keys[n + 1].in_handle = curve.kind == KeyKind::bezier ? curve.curve.points[2] : place(n + 1);
            keys[n + 1].arrives_by_handle = curve.kind == KeyKind::bezier;
        }
        const Vec<double, 2> last = place(count - 1);
        result.culprit = count - 1;
        if (!is_finite(last)) return Status::value_not_finite;
        result.culprit = 0;
        result.keys = std::move(keys);
        return Status::ok;
    });
    return result;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI

// What the importers and exporters of keyframe curves have in common.
#pragma once

#include <cageform/animate/key.hpp>
#include <cageform/core/detail/guard_memory.hpp>

#include <bit>
#include <limits>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Which handles of a key have a length of their own. The numbers are those of Unity's WeightedMode
/// and of Unreal's ERichCurveTangentWeightMode, where `in` is called arrive and `out` leave.
enum class WeightedHandles : std::uint8_t { none = 0, in = 1, out = 2, both = 3 };

/// The interval between two keys of another program. `curve` is a sound one (`check` says ok) where
/// `status` is ok, else all zeros. Of a held key it is level, at the first key's value; the second
/// key's value begins the next interval.
struct ImportedCurve {
    Status status = Status::ok;
    KeyKind kind = KeyKind::bezier;
    BezierCurve curve{};
};

/// The keys of a curve, as `compile_track` and `compile_clip` take them.
struct ImportedKeys {
    /// keys_missing; out_of_memory; that of the first interval that is refused.
    Status status = Status::ok;
    std::size_t culprit = 0; ///< the key that this interval begins with
    std::vector<Key> keys;   ///< none where the status is not ok
};

namespace detail {

/// As `check`, and no handle farther from its key than two intervals. Time turns back there in any
/// case, and what `check` compares may be too large to tell.
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

/// Of a number that is to be a part of an interval.
inline Status check_part(double part) noexcept {
    if (!is_finite(part)) return Status::value_not_finite;
    return part >= 0 && part <= 1 ? Status::ok : Status::handle_not_allowed;
}

/// The straight line between two keys, its handles at thirds, so that time is linear in the curve's
/// parameter.
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

/// Infinity under -ffast-math too.
inline double infinite() noexcept {
    return std::bit_cast<double>(std::uint64_t{0x7ff0000000000000});
}

/// Infinite and not NaN, by the bits as is_finite.
inline bool is_infinite(double x) noexcept {
    return !is_finite(x) && (std::bit_cast<std::uint64_t>(x) << 12) == 0;
}

/// Whether a number has a place in single precision, which is what engines and glTF store: larger
/// ones become infinite.
inline bool fits_float(double x) noexcept {
    return is_finite(x) && std::fabs(x) <= double((std::numeric_limits<float>::max)());
}

/// Whether a part of an interval is a third as single precision has it.
inline bool is_third(double part) noexcept {
    return std::fabs(part) < 1 && static_cast<float>(part) == 1.0f / 3;
}

/// The slope of a handle; 0 where it lies on its key. slope_unbounded where it is vertical, or too
/// steep for single precision: an infinite slope would be taken for a held key.
inline Status slope_of(const Vec<double, 2>& handle, double& slope) noexcept {
    slope = 0;
    if (handle[0] == 0 && handle[1] == 0) return Status::ok;
    if (handle[0] == 0) return Status::slope_unbounded;
    const double quotient = handle[1] / handle[0];
    if (!fits_float(quotient)) return Status::slope_unbounded;
    slope = quotient;
    return Status::ok;
}

/// The handles in parts of the interval and of the rise between the keys, as CSS and Lottie have
/// them.
struct UnitHandles {
    Status status = Status::ok;
    Vec<double, 2> first{0, 0}, second{1, 1};
};

/// Fails as `check`; with handle_not_allowed where a handle's time leaves the interval, or where
/// the keys have one value and a handle another; with value_not_finite where a part is too large
/// for a number.
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
        // Of a falling curve a part may be −0, which a text is not to show.
        for (std::size_t k = 0; k < 2; ++k) (*handle)[k] += 0.0;
    }
    if (!is_finite(result.first[1]) || !is_finite(result.second[1])) result.status = Status::value_not_finite;
    return result;
}

/// The keys of a curve whose intervals are imported one by one: interval(n) is the curve from key n
/// to the next, place(n) the time and the value of key n. Of their kinds the intervals are as they
/// were, to the bit.
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

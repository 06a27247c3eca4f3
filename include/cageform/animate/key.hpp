// Key frames: what animators set, and the Bézier curves between.
#pragma once

#include <cageform/animate/bezier.hpp>

#include <cstdint>
#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// What the curve is from a key to the next. Where it arrives there, the next key's own handle or
/// slope counts.
enum class KeyKind : std::uint8_t {
    hold,      ///< the value stays until the next key
    linear,    ///< a straight line
    hermite,   ///< slopes `in_slope` and `out_slope`, per unit of time
    tcb,       ///< slopes by tension, continuity and bias (Kochanek & Bartels 1984)
    bezier,    ///< handles `in_handle` and `out_handle`
    automatic, ///< smooth, and never beyond the keys' values (Fritsch & Butland 1984)
};

struct Key {
    double time = 0, value = 0;
    KeyKind kind = KeyKind::automatic;
    Vec<double, 2> in_handle{}, out_handle{};     ///< of bezier: time and value of the handle itself
    double in_slope = 0, out_slope = 0;           ///< of hermite
    double tension = 0, continuity = 0, bias = 0; ///< of tcb, in [-1, 1]; 0 is Catmull & Rom's
    /// The curve arrives by `in_handle` whatever the kind, as where a hold follows a Bézier curve.
    bool arrives_by_handle = false;
};

namespace detail {

/// The slope at a key that has no handles, per unit of time: where the curve leaves it (`out`), or
/// arrives. Of two keys at least.
inline double key_slope(std::span<const Key> keys, std::size_t i, bool out) noexcept {
    const Key& key = keys[i];
    const auto length = [&](std::size_t k) { return keys[k + 1].time - keys[k].time; };
    const auto chord = [&](std::size_t k) { return (keys[k + 1].value - keys[k].value) / length(k); };
    const bool first = i == 0, last = i + 1 == keys.size();
    const double before = chord(first ? 0 : i - 1), after = chord(last ? i - 1 : i);
    switch (key.kind) {
    case KeyKind::hermite: return out ? key.out_slope : key.in_slope;
    case KeyKind::hold:
    case KeyKind::linear: return out ? after : before;
    case KeyKind::tcb: {
        // Slopes in place of differences, which is the same where keys are equally far apart.
        const double c = out ? key.continuity : -key.continuity;
        return 0.5 * (1 - key.tension) *
               ((1 + key.bias) * (1 + c) * before + (1 - key.bias) * (1 - c) * after);
    }
    case KeyKind::bezier:
    case KeyKind::automatic: break;
    }
    if (first || last) return before;
    if (!(before * after > 0)) return 0;
    const double h = length(i - 1), k = length(i);
    const double part = (h + 2 * k) / (3 * (h + k));
    return before * after / (part * after + (1 - part) * before);
}

/// A key's own handle where it has such, otherwise that on its slope at `third` of an interval from
/// the key.
inline Vec<double, 2> key_handle(std::span<const Key> keys, std::size_t i, double third) noexcept {
    const Key& key = keys[i];
    const bool out = third > 0;
    if (!out && key.arrives_by_handle) return key.in_handle;
    if (key.kind == KeyKind::bezier) return out ? key.out_handle : key.in_handle;
    return {key.time + third, key.value + third * key_slope(keys, i, out)};
}

} // namespace detail

/// The Bézier curve from key `i` to the next, of kinds other than hold. A handle that a key does
/// not have itself lies at a third of the interval; where both do, the curve is a cubic of time.
inline BezierCurve key_interval(std::span<const Key> keys, std::size_t i) noexcept {
    const Key &a = keys[i], &b = keys[i + 1];
    const Vec<double, 2> begin{a.time, a.value}, end{b.time, b.value};
    const double third = (b.time - a.time) / 3, rise = (b.value - a.value) / 3;
    if (a.kind == KeyKind::linear)
        return {{begin, {a.time + third, a.value + rise}, {b.time - third, b.value - rise}, end}};
    return {{begin, detail::key_handle(keys, i, third), detail::key_handle(keys, i + 1, -third), end}};
}

} // namespace cageform::inline CAGEFORM_ABI

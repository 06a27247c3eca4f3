// Key frames, and the Bézier curves between them.
#pragma once

#include <cageform/animate/curves/bezier.hpp>

#include <cstdint>
#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// The shape of the curve from a key to the next. The kind of the next key determines the handle or
/// slope at its end.
enum class KeyKind : std::uint8_t {
    hold,      ///< the value stays until the next key
    linear,    ///< a straight line
    hermite,   ///< slopes `in_slope` and `out_slope`, per unit of time
    tcb,       ///< slopes by tension, continuity and bias (Kochanek & Bartels 1984)
    bezier,    ///< handles `in_handle` and `out_handle`
    automatic, ///< monotone between keys (Fritsch & Butland 1984)
};

/// A key of one value. Times and values have any units, such as seconds and metres.
struct Key {
    double time = 0, value = 0;
    KeyKind kind = KeyKind::automatic;
    Vec<double, 2> in_handle{}, out_handle{};     ///< for bezier: absolute time and value
    double in_slope = 0, out_slope = 0;           ///< for hermite
    double tension = 0, continuity = 0, bias = 0; ///< for tcb, in [-1, 1]; 0 gives Catmull-Rom slopes
    /// Whether `in_handle` applies for any kind; needed if a hold follows a Bézier curve.
    bool arrives_by_handle = false;
};

namespace detail {

/// Returns the slope, per unit of time, at a key without handles: of the curve that leaves it (`out`)
/// or that arrives at it. Requires at least two keys.
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
        // Uses slopes where the paper uses differences; for equally spaced keys both are equal.
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
    const double weight = (h + 2 * k) / (3 * (h + k));
    return before * after / (weight * after + (1 - weight) * before);
}

/// Returns the key's handle; without one, the point on the tangent at the time `third` from the key.
inline Vec<double, 2> key_handle(std::span<const Key> keys, std::size_t i, double third) noexcept {
    const Key& key = keys[i];
    const bool out = third > 0;
    if (!out && key.arrives_by_handle) return key.in_handle;
    if (key.kind == KeyKind::bezier) return out ? key.out_handle : key.in_handle;
    return {key.time + third, key.value + third * key_slope(keys, i, out)};
}

} // namespace detail

/// Returns the Bézier curve from key `i`, which is not a hold, to the next key. Missing handles are
/// placed at a third of the interval; if both are missing, the curve is a cubic polynomial in time.
inline BezierCurve key_interval(std::span<const Key> keys, std::size_t i) noexcept {
    const Key &a = keys[i], &b = keys[i + 1];
    const Vec<double, 2> begin{a.time, a.value}, end{b.time, b.value};
    const double third = (b.time - a.time) / 3, rise = (b.value - a.value) / 3;
    if (a.kind == KeyKind::linear)
        return {{begin, {a.time + third, a.value + rise}, {b.time - third, b.value - rise}, end}};
    return {{begin, detail::key_handle(keys, i, third), detail::key_handle(keys, i + 1, -third), end}};
}

} // namespace cageform::inline CAGEFORM_ABI

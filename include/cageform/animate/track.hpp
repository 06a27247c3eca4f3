// Key frames to tracks: every kind of key compiled to the one format of pieces. Bind time.
#pragma once

#include <cageform/animate/fit.hpp>
#include <cageform/animate/piecewise_cubic.hpp>

#include <functional>

namespace cageform::inline CAGEFORM_ABI {

struct Key {
    double time = 0, value = 0;
    KeyKind kind = KeyKind::automatic;
    Vec<double, 2> in_handle{},
        out_handle{}; ///< of bezier: time and value, of the handle itself, not relative to the key
    double in_slope = 0, out_slope = 0;           ///< of hermite
    double tension = 0, continuity = 0, bias = 0; ///< of tcb, in [-1, 1]; all zero is Catmull & Rom's
};

namespace detail {

/// The slope at key `i`, on its way in or out, per unit of time.
inline double key_slope(std::span<const Key> keys, std::size_t i, bool out) noexcept {
    const Key& key = keys[i];
    const auto chord = [&](std::size_t k) { // from key k to the next
        return (keys[k + 1].value - keys[k].value) / (keys[k + 1].time - keys[k].time);
    };
    const bool first = i == 0, last = i + 1 == keys.size();
    if (first && last) return 0;
    switch (key.kind) {
    case KeyKind::hermite: return out ? key.out_slope : key.in_slope;
    case KeyKind::bezier: {
        const auto& handle = out ? key.out_handle : key.in_handle;
        const double away = handle[0] - key.time;
        return away != 0 ? (handle[1] - key.value) / away : 0;
    }
    case KeyKind::hold: return out ? 0 : first ? 0 : chord(i - 1);
    case KeyKind::linear: return out ? (last ? 0 : chord(i)) : (first ? 0 : chord(i - 1));
    case KeyKind::tcb: {
        // Slopes in the stead of differences, which is the same where keys are equally far apart.
        const double before = first ? chord(i) : chord(i - 1), after = last ? chord(i - 1) : chord(i);
        const double c = out ? key.continuity : -key.continuity;
        return 0.5 * (1 - key.tension) *
               ((1 + key.bias) * (1 + c) * before + (1 - key.bias) * (1 - c) * after);
    }
    case KeyKind::automatic: break;
    }
    if (first) return chord(0);
    if (last) return chord(i - 1);
    const double before = chord(i - 1), after = chord(i);
    if (!(before * after > 0)) return 0;
    const double h = keys[i].time - keys[i - 1].time, k = keys[i + 1].time - keys[i].time;
    const double part = (h + 2 * k) / (3 * (h + k));
    return before * after / (part * after + (1 - part) * before);
}

} // namespace detail

/// The Bézier curve from key `i` to the next, of kinds other than hold. A key's own handles where both ends have such,
/// otherwise at thirds of the interval, where the curve is a cubic of time.
inline BezierCurve key_interval(std::span<const Key> keys, std::size_t i) noexcept {
    const Key &a = keys[i], &b = keys[i + 1];
    const double third = (b.time - a.time) / 3;
    BezierCurve curve;
    curve.points[0] = {a.time, a.value};
    curve.points[3] = {b.time, b.value};
    if (a.kind == KeyKind::linear) {
        curve.points[1] = {a.time + third, a.value + (b.value - a.value) / 3};
        curve.points[2] = {b.time - third, b.value - (b.value - a.value) / 3};
        return curve;
    }
    curve.points[1] =
        a.kind == KeyKind::bezier
            ? a.out_handle
            : Vec<double, 2>{a.time + third, a.value + third * detail::key_slope(keys, i, true)};
    curve.points[2] =
        b.kind == KeyKind::bezier
            ? b.in_handle
            : Vec<double, 2>{b.time - third, b.value - third * detail::key_slope(keys, i + 1, false)};
    return curve;
}

/// A piece of degree 3 of a fit as it is at run time; from times as T rounds them, so that it still meets the next. Not finite
/// where T does not tell its ends apart.
template <Scalar T>
CubicPiece<T> cubic_piece(const BezierFit& fitted, std::size_t piece) noexcept {
    const auto b = fitted.coefficients(piece);
    const T begin = static_cast<T>(fitted.knots[piece]);
    const double h = double(static_cast<T>(fitted.knots[piece + 1])) - double(begin);
    const double c1 = 3 * (b[1] - b[0]), c2 = 3 * (b[2] - 2 * b[1] + b[0]),
                 c3 = b[3] - 3 * b[2] + 3 * b[1] - b[0];
    if (!(h > 0)) return {begin, static_cast<T>(b[0]), T(0), T(0), std::numeric_limits<T>::infinity()};
    return {begin, static_cast<T>(b[0]), static_cast<T>(c1 / h), static_cast<T>(c2 / (h * h)),
            static_cast<T>(c3 / (h * h * h))};
}

struct TrackOptions {
    double tolerance = screen_tolerance; ///< of a value, in its units
    FitOptions fit{};
    Extrapolation before = Extrapolation::constant, after = Extrapolation::constant;
    /// Told the part done, every thousand keys; false cancels.
    std::function<bool(double)> progress{};
};

template <Scalar T>
struct CompiledTrack {
    /// ok; keys_missing; value_not_finite; keys_not_ascending; cancelled; and as `fit`. `culprit` is then the key, or the first of its
    /// interval.
    Status status = Status::ok;
    std::size_t culprit = 0;
    Track<T> track;
    double sup_error = 0; ///< the largest of all intervals, but for the rounding of T
};

/// Compiles keys, which ascend by time, to a track. A single key is a constant.
///
///   cost   a piece for every interval that is a cubic of time (all kinds but bezier with handles elsewhere than at thirds);
///          of others as `fit`
template <Scalar T>
CompiledTrack<T> compile_track(std::span<const Key> keys, const TrackOptions& options = {}) {
    CompiledTrack<T> result;
    result.track.before = options.before;
    result.track.after = options.after;
    const auto refuse = [&](Status status, std::size_t key) {
        result.status = status;
        result.culprit = key;
        result.track.curve = {};
        return result;
    };
    if (keys.empty()) return refuse(Status::keys_missing, 0);
    for (std::size_t i = 0; i < keys.size(); ++i) {
        const Key& key = keys[i];
        for (const double x :
             {key.time, key.value, key.in_slope, key.out_slope, key.tension, key.continuity, key.bias,
              key.in_handle[0], key.in_handle[1], key.out_handle[0], key.out_handle[1]}) {
            if (!is_finite(x)) return refuse(Status::value_not_finite, i);
        }
        if (i > 0 && !(static_cast<T>(key.time) > static_cast<T>(keys[i - 1].time)))
            return refuse(Status::keys_not_ascending, i);
    }
    std::vector<CubicPiece<T>> pieces;
    const auto constant = [&](double time, double value) {
        pieces.push_back({static_cast<T>(time), static_cast<T>(value), T(0), T(0), T(0)});
    };
    FitOptions fit_options = options.fit;
    fit_options.degree = 3;
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
        if (options.progress && i % 1000 == 0 && !options.progress(double(i) / double(keys.size() - 1)))
            return refuse(Status::cancelled, i);
        if (keys[i].kind == KeyKind::hold) {
            constant(keys[i].time, keys[i].value);
            continue;
        }
        const BezierFit fitted = fit(key_interval(keys, i), options.tolerance, fit_options);
        if (fitted.status != Status::ok) return refuse(fitted.status, i);
        result.sup_error = std::max(result.sup_error, fitted.sup_error);
        for (std::size_t k = 0; k < fitted.pieces(); ++k) {
            const auto piece = cubic_piece<T>(fitted, k);
            if (!pieces.empty() && !(piece.begin > pieces.back().begin))
                pieces.pop_back(); // shorter than T resolves
            if (is_finite(piece.c3)) pieces.push_back(piece);
        }
    }
    if (keys.size() == 1) constant(keys[0].time, keys[0].value);
    const T end = static_cast<T>(keys.back().time), end_value = static_cast<T>(keys.back().value);
    if (options.progress && !options.progress(1.0)) return refuse(Status::cancelled, 0);
    // After a hold the value jumps to that of the last key; otherwise it is there already.
    result.track.curve = PiecewiseCubic<T>(std::move(pieces), end, end_value);
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI

// Compiles the key frames of one value to a track: every kind of key becomes cubic pieces. Bind time.
#pragma once

#include <cageform/animate/fit.hpp>
#include <cageform/animate/key.hpp>
#include <cageform/animate/track.hpp>
#include <cageform/core/running.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI {

/// Converts a piece of degree 3 of a fit to its run-time form. It uses times rounded to T, so that
/// it still meets the next piece. T must resolve its length; its coefficients may overflow T.
template <Scalar T>
CubicPiece<T> cubic_piece(const BezierFit& fitted, std::size_t piece) noexcept {
    const auto b = fitted.coefficients(piece);
    const T begin = static_cast<T>(fitted.knots[piece]);
    const double h = double(static_cast<T>(fitted.knots[piece + 1])) - double(begin);
    const double c1 = 3 * (b[1] - b[0]), c2 = 3 * (b[2] - 2 * b[1] + b[0]),
                 c3 = b[3] - 3 * b[2] + 3 * b[1] - b[0];
    return {begin, static_cast<T>(b[0]), static_cast<T>(c1 / h), static_cast<T>(c2 / (h * h)),
            static_cast<T>(c3 / (h * h * h))};
}

struct TrackOptions {
    /// The largest error of a value, in its units. By default screen_tolerance for a track; for a
    /// clip (`compile_clip`), this share of the diagonal of the bounding box of all keys' values.
    std::optional<double> tolerance{};
    FitOptions fit{}; ///< the degree is always 3
    Extrapolation before = Extrapolation::constant, after = Extrapolation::constant;
};

template <Scalar T>
struct CompiledTrack {
    /// keys_missing; value_not_finite, also if a value is too large for T; keys_not_ascending;
    /// cancelled; out_of_memory; as `fit`.
    Status status = Status::ok;
    std::size_t culprit = 0; ///< the refused key, or the first key of the interval
    Track<T> track;          ///< without pieces unless the status is ok
    double sup_error = 0;    ///< the largest of all intervals, without the rounding of T
    double seconds = 0;
};

namespace detail {

template <Scalar T>
class TrackCompiler {
public:
    TrackCompiler(std::span<const Key> keys, const TrackOptions& options, CompiledTrack<T>& result)
        : keys_(keys)
        , tolerance_(options.tolerance.value_or(screen_tolerance))
        , fit_(options.fit)
        , result_(result) {
        fit_.degree = 3;
    }

    Status run(const Running& running) {
        if (keys_.empty()) return Status::keys_missing;
        for (std::size_t i = 0; i < keys_.size(); ++i) {
            if (const Status status = check_key(i); status != Status::ok) return refuse(status, i);
        }
        for (std::size_t i = 0; i + 1 < keys_.size(); ++i) {
            if (i % 1000 == 0 && !running.keep_going(double(i) / double(keys_.size() - 1)))
                return refuse(Status::cancelled, i);
            const Status status = keys_[i].kind == KeyKind::hold ? add_constant(i) : add_interval(i, running);
            if (status != Status::ok) return refuse(status, i);
        }
        if (!running.keep_going(1)) return Status::cancelled;
        const Key& last = keys_.back();
        if (keys_.size() == 1) (void)add_constant(0);
        // After a hold the value jumps to the last key's; otherwise it has already arrived there.
        result_.track.curve =
            PiecewiseCubic<T>(std::move(pieces_), static_cast<T>(last.time), static_cast<T>(last.value));
        return Status::ok;
    }

private:
    Status refuse(Status status, std::size_t key) {
        result_.culprit = key;
        return status;
    }
    Status check_key(std::size_t i) const {
        const Key& key = keys_[i];
        for (const double x :
             {key.time, key.value, key.in_slope, key.out_slope, key.tension, key.continuity, key.bias,
              key.in_handle[0], key.in_handle[1], key.out_handle[0], key.out_handle[1]}) {
            if (!is_finite(x)) return Status::value_not_finite;
        }
        // Values, times and the track's length must also be finite in T.
        if (!is_finite(static_cast<T>(key.value)) || !is_finite(static_cast<T>(key.time - keys_[0].time)) ||
            !is_finite(static_cast<T>(key.time)))
            return Status::value_not_finite;
        const bool later = i == 0 || static_cast<T>(key.time) > static_cast<T>(keys_[i - 1].time);
        return later ? Status::ok : Status::keys_not_ascending;
    }
    Status add_constant(std::size_t i) {
        pieces_.push_back({static_cast<T>(keys_[i].time), static_cast<T>(keys_[i].value), T(0), T(0), T(0)});
        return Status::ok;
    }
    Status add_interval(std::size_t i, const Running& running) {
        const FewestPieces search(key_interval(keys_, i), tolerance_, fit_, default_max_pieces);
        const double intervals = double(keys_.size() - 1);
        const BezierFit fitted = search.find(
            search.tied() ? running.part(double(i) / intervals, double(i + 1) / intervals) : Running{});
        if (fitted.status != Status::ok) return fitted.status;
        result_.sup_error = (std::max)(result_.sup_error, fitted.sup_error);
        for (std::size_t k = 0; k < fitted.pieces(); ++k) {
            const T begin = static_cast<T>(fitted.knots[k]), end = static_cast<T>(fitted.knots[k + 1]);
            if (!(begin < end)) continue; // T does not resolve its length
            const auto piece = cubic_piece<T>(fitted, k);
            if (!stays_finite(piece, end - begin)) return Status::value_not_finite;
            pieces_.push_back(piece);
        }
        return Status::ok;
    }

    /// Whether the evaluation of a piece up to `length` never overflows. The piece with absolute
    /// coefficients bounds every intermediate result.
    static bool stays_finite(const CubicPiece<T>& piece, T length) noexcept {
        const CubicPiece<T> bound{T(0), std::fabs(piece.c0), std::fabs(piece.c1), std::fabs(piece.c2),
                                  std::fabs(piece.c3)};
        return is_finite(bound(length)) && is_finite(bound.derivative(length));
    }

    std::span<const Key> keys_;
    double tolerance_;
    FitOptions fit_;
    CompiledTrack<T>& result_;
    std::vector<CubicPiece<T>> pieces_;
};

} // namespace detail

/// Compiles keys, ascending by time, to a track. A single key is a constant. Reports progress every
/// thousand keys; if pieces are tied, for every fit.
///
///   cost   one piece for each interval that is a cubic of time (all kinds except bezier with
///          handles not at thirds); for others as `fit`
template <Scalar T>
CompiledTrack<T> compile_track(std::span<const Key> keys, const TrackOptions& options = {},
                               const Running& running = {}) {
    CompiledTrack<T> result;
    result.track.before = options.before;
    result.track.after = options.after;
    detail::run_into(result, [&] { return detail::TrackCompiler<T>(keys, options, result).run(running); });
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI

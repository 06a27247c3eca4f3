// Key frames to tracks: every kind of key compiled to the one format of pieces. Bind time.
#pragma once

#include <cageform/animate/fit.hpp>
#include <cageform/animate/key.hpp>
#include <cageform/animate/track.hpp>
#include <cageform/core/result.hpp>
#include <cageform/core/running.hpp>

#include <concepts>
#include <optional>
#include <span>

namespace cageform::inline CAGEFORM_ABI {

/// A piece of degree 3 of a fit as it is at run time; from times as T rounds them, so that it still
/// meets the next. Of times that T tells apart; its coefficients may be too large for T.
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
    /// The largest error of a value, in its units. Where it is not given, it is screen_tolerance for a track; for a
    /// clip it is that share of the diagonal of the box that holds the values of all its keys.
    std::optional<double> tolerance{};
    FitOptions fit{}; ///< the degree is 3 whatever it says
    Extrapolation before = Extrapolation::constant, after = Extrapolation::constant;
};

/// How the compilation of a track or of a clip went.
struct CompileReport {
    Status status = Status::ok;
    std::size_t curve = 0;   ///< of a clip: the curve that is refused
    std::size_t culprit = 0; ///< the key that is refused, or the first one of the refused interval
    double sup_error = 0;    ///< largest error of all intervals and curves, apart from the rounding of T
    double seconds = 0;      ///< wall-clock time
};

namespace detail {

/// Keys of one curve: a vector, an array or a span of Key.
template <class R>
concept Keys = std::convertible_to<const R&, std::span<const Key>>;

template <Scalar T>
class TrackCompiler {
public:
    TrackCompiler(std::span<const Key> keys, const TrackOptions& options,
                  Result<Track<T>, CompileReport>& result)
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
        // After a hold the value jumps to that of the last key; otherwise it is there already.
        result_.value.curve =
            PiecewiseCubic<T>(std::move(pieces_), static_cast<T>(last.time), static_cast<T>(last.value));
        return Status::ok;
    }

private:
    Status refuse(Status status, std::size_t key) {
        result_.report.culprit = key;
        return status;
    }
    Status check_key(std::size_t i) const {
        const Key& key = keys_[i];
        for (const double x :
             {key.time, key.value, key.in_slope, key.out_slope, key.tension, key.continuity, key.bias,
              key.in_handle[0], key.in_handle[1], key.out_handle[0], key.out_handle[1]}) {
            if (!is_finite(x)) return Status::value_not_finite;
        }
        // In T too, and so that the track's length is.
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
        const FewestPieces search(key_interval(keys_, i), tolerance_, fit_);
        const double intervals = double(keys_.size() - 1);
        const auto [fitted, report] = search.find(
            search.tied() ? running.part(double(i) / intervals, double(i + 1) / intervals) : Running{});
        if (report.status != Status::ok) return report.status;
        result_.report.sup_error = (std::max)(result_.report.sup_error, report.sup_error);
        for (std::size_t k = 0; k < fitted.pieces(); ++k) {
            const T begin = static_cast<T>(fitted.knots[k]), end = static_cast<T>(fitted.knots[k + 1]);
            if (!(begin < end)) continue; // shorter than T resolves
            const auto piece = cubic_piece<T>(fitted, k);
            if (!stays_finite(piece, end - begin)) return Status::value_not_finite;
            pieces_.push_back(piece);
        }
        return Status::ok;
    }

    /// Whether no step of a piece's evaluation overflows up to `length`: those of the absolute
    /// coefficients are the largest there.
    static bool stays_finite(const CubicPiece<T>& piece, T length) noexcept {
        const CubicPiece<T> bound{T(0), std::fabs(piece.c0), std::fabs(piece.c1), std::fabs(piece.c2),
                                  std::fabs(piece.c3)};
        return is_finite(bound(length)) && is_finite(bound.derivative(length));
    }

    std::span<const Key> keys_;
    double tolerance_;
    FitOptions fit_;
    Result<Track<T>, CompileReport>& result_;
    std::vector<CubicPiece<T>> pieces_;
};

} // namespace detail

/// Compiles keys, which ascend by time, to a track. A single key is a constant. The progress is
/// told every thousand keys, and for every piece tried where pieces are tied.
///
///   cost   a piece for every interval that is a cubic of time (all kinds but bezier with handles
///          elsewhere than at thirds); of others as `fit`
///   fails  keys_missing; value_not_finite, also where a key is too large for T; keys_not_ascending;
///          cancelled; out_of_memory; as `fit`
template <Scalar T, detail::Keys R>
Result<Track<T>, CompileReport> compile(const R& keys, const TrackOptions& options = {},
                                        const Running& running = {}) {
    Result<Track<T>, CompileReport> result;
    result.value.before = options.before;
    result.value.after = options.after;
    detail::run_into(result.report, [&] {
        return detail::TrackCompiler<T>(std::span<const Key>(keys), options, result).run(running);
    });
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI

// Compiles the keys of one curve to cubic pieces.
#pragma once

#include <cageform/animate/curves/key.hpp>
#include <cageform/animate/fit/fewest_pieces.hpp>
#include <cageform/animate/types/track_options.hpp>
#include <cageform/clip/curves/track.hpp>
#include <cageform/core/result.hpp>
#include <cageform/core/types/scalar_range.hpp>
#include <cageform/parallel/running.hpp>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

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
        // After a hold the value jumps to that of the last key; otherwise it is already equal.
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
        // Values, times and the track's duration must be finite in T.
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
            search.coupled() ? running.subtask(double(i) / intervals, double(i + 1) / intervals) : Running{});
        if (report.status != Status::ok) return report.status;
        result_.report.sup_error = (std::max)(result_.report.sup_error, report.sup_error);
        for (std::size_t k = 0; k < fitted.pieces(); ++k) {
            const T begin = static_cast<T>(fitted.knots[k]), end = static_cast<T>(fitted.knots[k + 1]);
            if (!(begin < end)) continue; // the piece is shorter than T resolves
            const auto piece = cubic_piece<T>(fitted, k);
            if (!stays_finite(piece, end - begin)) return Status::value_not_finite;
            pieces_.push_back(piece);
        }
        return Status::ok;
    }

    /// Whether the evaluation of a piece up to `length` never overflows: the piece with absolute
    /// coefficients bounds every intermediate result.
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

/// The keys of several curves: a vector, an array or a span of `Keys`.
template <class R>
concept KeysOfCurves = Keys<std::remove_cv_t<element_t<const R>>>;

/// Returns the size of a pixel if the keys of all coordinates fill a screen. Without motion any
/// tolerance is valid.
template <std::size_t D>
double pixel_of_clip(std::span<const std::span<const Key>> keys) noexcept {
    double diagonal = 0;
    for (std::size_t axis = 0; axis < D; ++axis) {
        double lower = std::numeric_limits<double>::infinity(), upper = -lower;
        for (std::size_t curve = axis; curve < keys.size(); curve += D) {
            for (const Key& key : keys[curve]) {
                lower = (std::min)(lower, key.value);
                upper = (std::max)(upper, key.value);
            }
        }
        if (lower < upper) diagonal = std::hypot(diagonal, upper - lower);
    }
    return screen_tolerance * (diagonal > 0 ? diagonal : 1);
}

} // namespace cageform::inline CAGEFORM_ABI::detail

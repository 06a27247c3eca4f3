// Compiles key frames to the motion of a cage. Bind time.
//
// The way of an animation: key.hpp (keys) → fit.hpp (few cubics for each Bézier curve) →
// detail/compile_track.hpp (a coordinate) → here (all coordinates) → clip.hpp (played) →
// pack_clip.hpp (shipped), clip_blob.hpp (its format).
#pragma once

#include <cageform/animate/clip.hpp>
#include <cageform/animate/detail/compile_track.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T, std::size_t D>
struct CompiledClip {
    Status status = Status::ok;                 ///< as `compile_track`; input_malformed
    std::size_t culprit_curve = 0, culprit = 0; ///< the refused curve, and its key
    CageClip<T, D> clip;                        ///< without curves unless the status is ok
    double sup_error = 0;                       ///< the largest of all curves
    double seconds = 0;
};

namespace detail {

/// The size of a pixel if the keys of all coordinates just fill a screen. Without motion any tolerance does.
template <std::size_t D>
double pixel_of_clip(std::span<const std::vector<Key>> keys) noexcept {
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

} // namespace detail

/// Compiles key frames to a clip, curve by curve, in parallel if `running` says so.
///
///   keys     #vertices · D lists of keys; the coordinates of a vertex are adjacent
///   options  the extrapolation applies to the clip as a whole. Without a tolerance, the result
///            does not depend on the unit of length; set one for a figure that moves far
///   fails    input_malformed if the number of curves is no multiple of D; as `compile_track`, for
///            the first refused curve
template <Scalar T, std::size_t D>
CompiledClip<T, D> compile_clip(std::span<const std::vector<Key>> keys, const TrackOptions& options = {},
                                const Running& running = {}) {
    CompiledClip<T, D> result;
    detail::run_into(result, [&] {
        if (keys.size() % D != 0) return Status::input_malformed;
        std::vector<CompiledTrack<T>> tracks(keys.size());
        TrackOptions of_tracks = options;
        of_tracks.tolerance = options.tolerance.value_or(detail::pixel_of_clip<D>(keys));
        // A track may take seconds if its pieces are tied.
        const std::size_t step = std::max<std::size_t>(keys.size() / 50, 16);
        for (std::size_t begin = 0; begin < keys.size(); begin += step) {
            const std::size_t count = (std::min)(step, keys.size() - begin);
            detail::in_parallel(running, count, 1, [&](std::size_t b, std::size_t e) {
                for (std::size_t k = begin + b; k < begin + e; ++k)
                    tracks[k] = compile_track<T>(keys[k], of_tracks);
            });
            if (!running.keep_going(double(begin + count) / double(keys.size()))) return Status::cancelled;
        }
        if (keys.empty() && !running.keep_going(1)) return Status::cancelled;
        std::vector<PiecewiseCubic<T>> curves;
        for (std::size_t k = 0; k < keys.size(); ++k) {
            if (tracks[k].status != Status::ok) {
                result.culprit_curve = k;
                result.culprit = tracks[k].culprit;
                return tracks[k].status;
            }
            result.sup_error = (std::max)(result.sup_error, tracks[k].sup_error);
            curves.push_back(std::move(tracks[k].track.curve));
        }
        result.clip = CageClip<T, D>(curves, options.before, options.after);
        return Status::ok;
    });
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI

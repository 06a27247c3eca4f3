// Compiles key frames at bind time: the keys of one value to a track, those of all coordinates of a
// cage to a clip.
//
// Order of reading: curves/key.hpp (keys) → fit.hpp (few cubics for each Bézier curve) →
// detail/track_compiler.hpp (all intervals of a curve) → this header → clip.hpp (playback) →
// pack_clip.hpp and clip_blob.hpp (packed clips).
#pragma once

#include <cageform/animate/curves/key.hpp>
#include <cageform/animate/detail/track_compiler.hpp>
#include <cageform/animate/fit.hpp>
#include <cageform/animate/types/track_options.hpp>
#include <cageform/clip/clip.hpp>
#include <cageform/clip/curves/track.hpp>
#include <cageform/core/detail/stopwatch.hpp>
#include <cageform/core/result.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>
#include <cageform/parallel/running.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Compiles keys, ascending by time, to a track. A single key gives a constant. Reports progress every
/// thousand keys; if pieces are coupled, for every fit.
///
///  cost   one piece for each interval that is a cubic of time: all kinds except bezier with
///         handles not at thirds; other intervals as `fit`
///  fails  keys_missing; value_not_finite, also if a key is too large for T; keys_not_ascending;
///         cancelled; out_of_memory; as `fit`
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

/// Compiles key frames to a clip, curve by curve, in parallel with `running.parallel`.
///
///   curves   #vertices · D ranges of keys; the coordinates of a vertex are adjacent. If the first
///            time is farther from 0 than the clip is long, times are stored relative to it
///   options  the extrapolation applies to the clip as a whole. The default tolerance is relative to
///            the extent of the motion; set a tolerance for a figure that moves far
///   fails    input_malformed if the number of curves is no multiple of D; as `compile`
///            of a track, for the first refused curve
template <Scalar T, std::size_t D, detail::KeysOfCurves R>
Result<CageClip<T, D>, CompileReport> compile(const R& curves, const TrackOptions& options = {},
                                              const Running& running = {}) {
    Result<CageClip<T, D>, CompileReport> result;
    detail::run_into(result.report, [&] {
        const std::vector<std::span<const Key>> keys(std::begin(curves), std::end(curves));
        if (keys.size() % D != 0) return Status::input_malformed;
        std::vector<Result<Track<T>, CompileReport>> tracks(keys.size());
        TrackOptions of_tracks = options;
        of_tracks.tolerance = options.tolerance.value_or(detail::pixel_of_clip<D>(keys));
        double first = std::numeric_limits<double>::infinity(), last = -first;
        for (const auto& of_curve : keys) {
            if (of_curve.empty()) continue;
            first = (std::min)(first, of_curve.front().time);
            last = (std::max)(last, of_curve.back().time);
        }
        const double origin = std::fabs(first) > last - first ? first : 0; // 0 if a time is not finite
        // A track may take seconds if its pieces are coupled.
        const std::size_t step = std::max<std::size_t>(keys.size() / 50, 16);
        for (std::size_t begin = 0; begin < keys.size(); begin += step) {
            const std::size_t count = (std::min)(step, keys.size() - begin);
            detail::in_parallel(running, count, 1, [&](std::size_t b, std::size_t e) {
                for (std::size_t k = begin + b; k < begin + e; ++k) {
                    std::vector<Key> shifted(keys[k].begin(), keys[k].end());
                    for (Key& key : shifted) {
                        for (double* time : {&key.time, &key.in_handle[0], &key.out_handle[0]})
                            *time -= origin;
                    }
                    tracks[k] = compile<T>(shifted, of_tracks);
                }
            });
            if (!running.keep_going(double(begin + count) / double(keys.size()))) return Status::cancelled;
        }
        if (keys.empty() && !running.keep_going(1)) return Status::cancelled;
        std::vector<PiecewiseCubic<T>> compiled;
        for (std::size_t k = 0; k < keys.size(); ++k) {
            auto& [track, report] = tracks[k];
            if (report.status != Status::ok) {
                result.report.curve = k;
                result.report.culprit = report.culprit;
                return report.status;
            }
            result.report.sup_error = (std::max)(result.report.sup_error, report.sup_error);
            compiled.push_back(std::move(track.curve));
        }
        result.value = CageClip<T, D>(compiled, options.before, options.after, origin);
        return Status::ok;
    });
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI

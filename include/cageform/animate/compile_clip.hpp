// Key frames to the motion of a cage. Bind time.
#pragma once

#include <cageform/animate/clip.hpp>
#include <cageform/animate/detail/compile_track.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The keys of many curves: a vector, an array or a span of any of the `Keys`.
template <class R>
concept KeysOfCurves = std::ranges::random_access_range<const R> && Keys<std::ranges::range_value_t<const R>>;

/// A pixel of a screen that shows all that the keys reach; of keys that do not move, any tolerance is met.
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

} // namespace detail

/// Compiles key frames to a clip, one curve after the other, in parallel where asked.
///
///   curves   keys of each coordinate, #vertices · D ranges; the coordinates of a vertex side by side
///   options  the extrapolation is that of the clip as a whole. Without a tolerance, what the clip
///            looks like does not depend on the unit; of a figure that goes far, give one
///   fails    input_malformed where the number of curves is no multiple of D; as `compile` of
///            a track, for the first curve that is refused
template <Scalar T, std::size_t D, detail::KeysOfCurves R>
Result<CageClip<T, D>, CompileReport> compile(const R& curves, const TrackOptions& options = {},
                                              const Running& running = {}) {
    Result<CageClip<T, D>, CompileReport> result;
    detail::run_into(result.report, [&] {
        const std::vector<std::span<const Key>> keys(std::ranges::begin(curves), std::ranges::end(curves));
        if (keys.size() % D != 0) return Status::input_malformed;
        std::vector<Result<Track<T>, CompileReport>> tracks(keys.size());
        TrackOptions of_tracks = options;
        of_tracks.tolerance = options.tolerance.value_or(detail::pixel_of_clip<D>(keys));
        // A track may take seconds, where its pieces are tied.
        const std::size_t step = std::max<std::size_t>(keys.size() / 50, 16);
        for (std::size_t begin = 0; begin < keys.size(); begin += step) {
            const std::size_t count = (std::min)(step, keys.size() - begin);
            detail::in_parallel(running, count, 1, [&](std::size_t b, std::size_t e) {
                for (std::size_t k = begin + b; k < begin + e; ++k)
                    tracks[k] = compile<T>(keys[k], of_tracks);
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
        result.value = CageClip<T, D>(compiled, options.before, options.after);
        return Status::ok;
    });
    return result;
}

} // namespace cageform::inline CAGEFORM_ABI

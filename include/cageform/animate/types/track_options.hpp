// The options and the report of compiling key frames.
#pragma once

#include <cageform/animate/fit/fit_options.hpp>
#include <cageform/clip/curves/track.hpp>
#include <cageform/core/status.hpp>

#include <cstddef>
#include <optional>

namespace cageform::inline CAGEFORM_ABI {

struct TrackOptions {
    /// The maximum error of a value, in its units. Default: screen_tolerance for a track; for a clip,
    /// screen_tolerance times the diagonal of the bounding box of all keys.
    std::optional<double> tolerance{};
    FitOptions fit{}; ///< the degree is always 3
    Extrapolation before = Extrapolation::constant, after = Extrapolation::constant;
};

/// The result of compiling a track or a clip.
struct CompileReport {
    Status status = Status::ok;
    std::size_t curve = 0;   ///< of a clip: the refused curve
    std::size_t culprit = 0; ///< the refused key, or the first key of the refused interval
    double sup_error = 0;    ///< the largest error of all curves, excluding rounding to T
    double seconds = 0;      ///< wall-clock time
};

} // namespace cageform::inline CAGEFORM_ABI

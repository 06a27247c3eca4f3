// The options and the report of packing a clip.
#pragma once

#include <cageform/core/status.hpp>

#include <cstddef>

namespace cageform::inline CAGEFORM_ABI {

/// The distance of a vertex is that between its positions in the packed and in the original clip, the
/// maximum over all times.
struct ClipPackOptions {
    /// The maximum distance of a vertex, in the units of the cage, that quantisation may cause. 0: no
    /// limit in these units.
    double tolerance = 0;
    /// The maximum distance relative to the cage's size (ClipPackReport::size). The smaller limit applies. If
    /// both are 0, nothing is quantised, and the packed clip gives the same bits as the original.
    double share = 0;
};

struct ClipPackReport {
    Status status = Status::ok; ///< value_not_finite: a tolerance that is NaN, infinite or negative
    std::size_t vertices = 0;
    std::size_t curves = 0, quantised = 0; ///< `quantised`: with 16-bit coefficients
    /// The diagonal of the bounding box of all vertices at the knots of their curves, without the
    /// rigid motion.
    double size = 0;
    /// The largest distance of a vertex, excluding rounding to T during playback and independent of the
    /// rigid motion.
    double distance = 0;
    std::size_t distance_vertex = 0;
    std::size_t bytes = 0;             ///< of the packed clip
    std::size_t unquantised_bytes = 0; ///< without any quantised curve
    double seconds = 0;
};

} // namespace cageform::inline CAGEFORM_ABI

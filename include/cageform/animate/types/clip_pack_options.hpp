// The options and the report of packing a clip.
#pragma once

#include <cageform/core/status.hpp>

#include <cstddef>

namespace cageform::inline CAGEFORM_ABI {

/// The distance of a vertex is the largest distance, over all times, between its positions in the
/// packed clip and in the clip.
struct ClipPackOptions {
    /// The largest distance allowed for a vertex, in the units of the cage. Curves are quantised to
    /// 16-bit coefficients as long as it is kept. 0: no limit in these units.
    double tolerance = 0;
    /// The largest distance as a share of the cage's size (ClipPackReport::size). The smaller limit
    /// counts. Without either, nothing is quantised, and the packed clip gives the same bits as the clip.
    double share = 0;
};

struct ClipPackReport {
    Status status = Status::ok; ///< value_not_finite: a tolerance that is NaN, infinite or negative
    std::size_t vertices = 0;
    std::size_t curves = 0, quantised = 0; ///< `quantised`: with 16-bit coefficients
    /// The diagonal of the bounding box of all vertices at the knots of their curves, without the
    /// rigid motion.
    double size = 0;
    /// The largest distance of a vertex, apart from rounding to T during play; a rigid motion does
    /// not change it.
    double distance = 0;
    std::size_t distance_vertex = 0;
    std::size_t bytes = 0;             ///< of the packed clip
    std::size_t unquantised_bytes = 0; ///< without any quantised curve
    double seconds = 0;
};

} // namespace cageform::inline CAGEFORM_ABI

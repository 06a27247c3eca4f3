// The options and the report of a rebind.
#pragma once

#include <cageform/binding/types/bind_options.hpp>
#include <cageform/core/status.hpp>

#include <vector>

namespace cageform::inline CAGEFORM_ABI {

struct RebindOptions {
    std::size_t neighbours = 0;  ///< how many old points to interpolate from, at least D + 1; 0: 4 D
    double largest_distance = 2; ///< from the old figure, in its spacings; farther points are listed
};

/// How a rebind went. Lists hold indices of new points in ascending order. The spacing of the old
/// figure near a point is the distance from the nearest old point to its D-th nearest neighbour;
/// old points at the same position count once.
struct RebindReport {
    Status status = Status::ok;
    std::size_t culprit = Extreme::none; ///< weight_not_finite: the old point
    std::size_t points = 0;              ///< given
    std::size_t matched = 0;             ///< at the position of an old point
    std::size_t interpolated = 0;        ///< with weights interpolated from old points
    /// The interpolated points farther away than `largest_distance`: their weights are guesses.
    std::vector<std::size_t> distant;
    /// No pose moves them, because no pose moved the old point there or the nearest one.
    std::vector<std::size_t> kept_in_place;
    std::vector<std::size_t> not_finite; ///< kept as they are in every pose
    std::vector<std::size_t> unreached;  ///< weights overflow; kept in place
    // For interpolated points:
    Extreme distance;        ///< the largest from the old figure, in its spacings
    Extreme partition_error; ///< largest |Σw − 1| of the final weights
    /// Largest |Σwc − p| of the final weights; p is the point to be reproduced.
    Extreme reproduction_error;
    Extreme weight_change;     ///< largest change of a weight by which both are restored
    Extreme residual_restored; ///< largest |Σwc − p| before it
    Extreme least_weight;      ///< may become negative though no old weight is
    double seconds = 0;        ///< wall-clock time
};

} // namespace cageform::inline CAGEFORM_ABI

// Options and report of fit_lattice.
#pragma once

#include <cageform/core/status.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

struct LatticeFitOptions {
    /// The weight λ of smoothness relative to the mean square of the residuals, without a unit. With 0,
    /// the points must determine each free handle.
    double smoothness = 1e-6;
    /// One weight per point, not negative; empty: all are 1.
    std::span<const double> point_weights{};
    /// Handles fixed at rest, as returned by `LatticeCoordinates::frozen_handles`.
    std::span<const std::uint32_t> frozen{};
};

/// The residuals of a fit, which are distances in the units of the figure. Points with weight 0, points
/// that are not finite and points without weights have no residual.
struct LatticeFitReport {
    Status status = Status::ok;
    double rms = 0;     ///< the root of the weighted mean square of the residuals
    double largest = 0; ///< the largest residual
    std::size_t farthest = 0;
    std::size_t unreached = 0;       ///< number of finite points without weights
    std::vector<std::uint32_t> idle; ///< free handles without points, determined only by smoothness
    /// The smallest pivot of the scaled matrix divided by the largest. If it is near rounding errors,
    /// the pose is poorly determined.
    double pivot_ratio = 0;
};

} // namespace cageform::inline CAGEFORM_ABI

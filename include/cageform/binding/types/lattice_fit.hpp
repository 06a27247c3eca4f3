// Options and report of fit_lattice.
#pragma once

#include <cageform/core/status.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

struct LatticeFitOptions {
    /// The weight λ of the smoothness against the mean square of the residuals. It has no unit. With 0, each
    /// free handle needs points that determine it.
    double smoothness = 1e-6;
    /// A weight for each point, none negative; empty: all are 1.
    std::span<const double> point_weights{};
    /// Handles that stay at rest, as `LatticeCoordinates::frozen_handles` lists them.
    std::span<const std::uint32_t> frozen{};
};

/// How well a pose follows. Residuals are distances, in the units of the figure. Points with weight 0, points
/// that are not finite and points that no handle moves have none.
struct LatticeFitReport {
    Status status = Status::ok;
    double rms = 0;     ///< the root of the weighted mean square of the residuals
    double largest = 0; ///< the largest residual
    std::size_t farthest = 0;
    std::size_t unreached = 0;       ///< finite points that no handle moves: the binding keeps them in place
    std::vector<std::uint32_t> idle; ///< free handles that move no point: smoothness alone places them
    /// The least over the largest pivot of the scaled matrix. Near rounding the pose is poorly determined.
    double pivot_ratio = 0;
};

} // namespace cageform::inline CAGEFORM_ABI

// The options and the report of `pose_samples`.
#pragma once

#include <cageform/binding/types/bind_options.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Zero, or for spokes a negative number, stands for a value that the numbers of handles and samples give.
struct PoseSampleOptions {
    std::size_t samples = 0;   ///< about how many, on a lattice; by default 16 a handle, at least 4,000
    std::size_t rotations = 0; ///< clusters; by default 2 a handle, from 200 to 400, never more than samples
    /// ρ: ties each handle to the cluster next to it, so that every handle is felt. By default 1e-3, and
    /// 1e-2 if some handles are vectors.
    double spokes = -1;
    /// ℓ, a share of the cage's size: bends spread over this length; soft drawings take 0.02. It makes more
    /// of the figure follow a pin. Given samples have no neighbours, so it does nothing there.
    double smoothing = 0;
};

struct PoseSamplesReport {
    Status status = Status::ok;
    BindReport bind;          ///< of the gradients: its lists and points are those of the last batch
    std::size_t samples = 0;  ///< used
    std::size_t left_out = 0; ///< samples where the coordinates have no gradients
    std::size_t rotations = 0;
    double spokes = 0; ///< ρ
    double seconds = 0;
};

} // namespace cageform::inline CAGEFORM_ABI

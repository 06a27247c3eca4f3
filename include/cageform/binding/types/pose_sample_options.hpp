// The options and the report of `pose_samples`.
#pragma once

#include <cageform/binding/types/bind_options.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// 0, or a negative number for `spokes`, selects a default that depends on the number of handles and samples.
struct PoseSampleOptions {
    std::size_t samples = 0;   ///< approximate number on a lattice; default: 16 per handle, at least 4,000
    std::size_t rotations = 0; ///< clusters; default: 2 per handle, 200 to 400, at most one per sample
    /// ρ: the weight that ties each handle to its nearest cluster, so that every handle has stiffness.
    /// Default: 1e-3, or 1e-2 if some handles are vectors.
    double spokes = -1;
    /// ℓ, relative to the cage's size: the length over which bends are spread. 0.02 suits soft
    /// drawings. Larger values move more of the figure with a pin. No effect on given samples, which
    /// have no neighbours.
    double smoothing = 0;
};

struct PoseSamplesReport {
    Status status = Status::ok;
    BindReport bind;          ///< of the gradients; lists and points are those of the last batch
    std::size_t samples = 0;  ///< the number of samples used
    std::size_t left_out = 0; ///< the number of samples without gradients
    std::size_t rotations = 0;
    double spokes = 0; ///< ρ
    double seconds = 0;
};

} // namespace cageform::inline CAGEFORM_ABI

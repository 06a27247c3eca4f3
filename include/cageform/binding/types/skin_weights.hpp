// A skin, and the options and the report of its making.
#pragma once

#include <cageform/binding/types/bind_options.hpp>
#include <cageform/core/status.hpp>

#include <cstdint>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

struct SkinWeightsOptions {
    std::size_t influences = 4; ///< K, the most handles a point may have; glTF has sets of 4
    double threshold = 0;       ///< smaller weights are dropped too, if the others can do without them
};

/// A skin. Every handle is a joint that only translates: p' = p + Σ w_k (C'_joint − C_joint). The
/// entries of a point lie side by side, in the order of falling weights; unused ones have weight 0
/// and joint 0.
struct SkinWeights {
    std::size_t influences = 0;        ///< K
    std::vector<std::uint16_t> joints; ///< #points · K: handles
    /// #points · K, non-negative; the sum of a point's weights is 1 to half a rounding of 1
    std::vector<float> weights;

    std::size_t point_count() const noexcept { return influences == 0 ? 0 : joints.size() / influences; }
};

/// How a skin differs from its binding. Lists hold indices of points in ascending order.
struct SkinWeightsReport {
    Status status = Status::ok;
    std::size_t points = 0;
    /// Outside the hull of the handles, or of any K of them: Σwc is not p.
    std::vector<std::size_t> not_reproduced;
    /// Kept in place by the binding, or not finite: all weights are 0.
    std::vector<std::size_t> without_weights;
    /// The binding's weights sum to less than 1 (BindOptions::falloff), the skin's to 1: multiply these by
    /// the binding's sum, and give the rest to a joint that stands still.
    std::vector<std::size_t> faded;
    /// #points: Σ|w − w0| over all handles, where w0 are the binding's weights; of points that fade, over
    /// their sum
    std::vector<float> weight_errors;
    Extreme weight_error;         ///< the largest of them
    double mean_weight_error = 0; ///< of the points that have weights
    Extreme partition_error;      ///< largest |Σw − 1| of the final weights
    /// Largest |Σwc − p| of the final weights, in the units of the cage.
    Extreme reproduction_error;
    /// Largest w − w0: the increase that makes up for negative and dropped weights.
    Extreme weight_added;
    double mean_influences = 0; ///< weights other than 0, of the points that have any
    double seconds = 0;         ///< wall-clock time
};

} // namespace cageform::inline CAGEFORM_ABI

// A skin, and the options and the report of making it.
#pragma once

#include <cageform/binding/types/bind_options.hpp>
#include <cageform/core/status.hpp>

#include <cstdint>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

struct SkinWeightsOptions {
    std::size_t influences = 4; ///< K, the maximum number of handles per point; glTF has sets of 4
    double threshold = 0;       ///< smaller weights are dropped if the others can reproduce the point
};

/// A skin. Every handle is a joint that only translates: p' = p + Σ w_k (C'_joint − C_joint). The
/// entries of a point are consecutive, by descending weight; unused entries have weight 0 and joint 0.
struct SkinWeights {
    std::size_t influences = 0;        ///< K
    std::vector<std::uint16_t> joints; ///< #points · K: handles
    /// #points · K, non-negative; the sum of a point's weights is 1 within half an epsilon of float.
    std::vector<float> weights;

    std::size_t point_count() const noexcept { return influences == 0 ? 0 : joints.size() / influences; }
};

/// The differences of a skin from its binding. Lists contain point indices in ascending order.
struct SkinWeightsReport {
    Status status = Status::ok;
    std::size_t points = 0;
    /// Points outside the hull of the handles, or of any K of them: Σwc is not p.
    std::vector<std::size_t> not_reproduced;
    /// Points that the binding keeps in place, or that are not finite: all weights are 0.
    std::vector<std::size_t> without_weights;
    /// Points whose binding weights have a sum below 1 (BindOptions::falloff), while the skin's have
    /// the sum 1. To reproduce the falloff, multiply the skin's weights by the binding's sum and give
    /// the rest to a joint at rest.
    std::vector<std::size_t> faded;
    /// #points: Σ|w − w0| over all handles, where w0 are the binding's weights, divided by their sum
    /// for points with falloff.
    std::vector<float> weight_errors;
    Extreme weight_error;         ///< the largest of `weight_errors`
    double mean_weight_error = 0; ///< of the points with weights
    Extreme partition_error;      ///< largest |Σw − 1| of the final weights
    /// Largest |Σwc − p| of the final weights, in the units of the cage.
    Extreme reproduction_error;
    /// Largest w − w0: the compensation for negative and dropped weights.
    Extreme weight_added;
    double mean_influences = 0; ///< non-zero weights per point with weights
    double seconds = 0;         ///< wall-clock time
};

} // namespace cageform::inline CAGEFORM_ABI

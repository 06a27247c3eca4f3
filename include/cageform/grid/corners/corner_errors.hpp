// Estimates the error of a solution near corners and edges that the grid does not resolve.
//
// Near a corner a solution is the linear extension of the boundary data plus singular functions
// (grid/corners/corner.hpp). Within one or two cells, finite differences and interpolation miss a fraction of
// these functions. The size of these functions is measured as the deviation of the solution from the extended
// data at the nodes around the corner. The constants are fitted to true errors, computed on finer grids, of
// about 340 binds of random cages. The largest estimate was 1.2 to 65 times the largest error, in 19 of 20
// binds at most 18 times. Bones have no estimate.
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/corners/corner.hpp>
#include <cageform/grid/types/solver_report.hpp>

#include <cstdint>
#include <span>

namespace cageform::inline CAGEFORM_ABI::grid {

/// Estimates the error near corners in 2D or edges in 3D. Corners are added one by one before the solve,
/// each with nodes to measure the solution at; after the solve `measure` makes the report. Takes about 40
/// bytes per node; lengths are in cells.
template <std::size_t D>
class CornerErrors {
public:
    /// Number of handles that determine the boundary data near a corner or edge.
    static constexpr std::size_t data_handles = D + 1;

    struct Node {
        std::uint32_t node;
        /// The weight of each handle in the extended data at the node.
        std::array<double, data_handles> share;
    };
    /// The error at one corner: constant + factor · largest |solution − extended data| at the nodes, in
    /// units of a weight.
    struct Estimate {
        /// In 2D the corner and the vertices before and after it; in 3D the ends of the edge and the third
        /// vertices of its faces.
        std::array<std::size_t, data_handles> handles;
        double constant;
        double factor;
        double order;    ///< the error decreases like the spacing to this power
        double room = 1; ///< distance to the rest of the boundary; `order` holds if it is one cell or more
    };

    /// Returns the factor of an untreated corner or edge: the fraction of its first singular function, r^λ
    /// sin λθ with λ = π/ω = `exponent`, that finite differences miss. The estimate 6 (1 − λ) is 0 for
    /// λ = 1, where the function is linear; it is clamped to 0.06 … 0.6. The missed fraction of w, whose
    /// slope is 1 per cell, is added separately.
    static double missed_share(double exponent) noexcept { return std::clamp(6 * (1 - exponent), 0.06, 0.6); }
    static constexpr double missed_of_w = 0.2, treated_order = 2.25;

    /// Returns the estimate of a corner or edge that is not treated.
    ///
    ///   slope_of_w  the largest coefficient of w (grid/corners/corner.hpp) over the handles, per cell
    static Estimate untreated(const std::array<std::size_t, data_handles>& handles, const Corner& corner,
                              double slope_of_w) noexcept {
        const bool smooth = corner.is_smooth();
        return {handles, smooth ? 0 : missed_of_w * slope_of_w, missed_share(corner.exponent()),
                (std::min)(corner.exponent(), 1.0)};
    }

    /// Returns the estimate of a 2D corner with a small free radius that is treated, or needs no treatment.
    static Estimate treated(const std::array<std::size_t, data_handles>& handles, double room) noexcept {
        return {handles, 0, 0.5 * (std::min)(1.0, std::pow(room, -treated_order)), treated_order};
    }

    /// Adds a corner or edge with the nodes around it. May throw std::bad_alloc.
    void add(const Estimate& estimate, std::span<const Node> nodes) {
        nodes_.append(nodes.data(), nodes.data() + nodes.size());
        estimates_.push_back(estimate);
        ends_.push_back(nodes_.size());
    }

    /// Appends an entry for every corner and edge to `report`: the estimated error of `count` functions
    /// from `first` on. O(#nodes · count).
    ///
    ///   block       value(node) returns the values of sixteen functions from `first` on
    ///   count       number of functions, at most 16
    ///   resolution  the resolution of the grid, and the largest possible one
    template <class Block>
    void measure(std::size_t first, std::size_t count, const Block& block,
                 const std::array<std::size_t, 2>& resolution, std::vector<CornerError>& report) const {
        report.reserve(report.size() + estimates_.size());
        for (std::size_t n = 0; n < estimates_.size(); ++n) {
            const Estimate& estimate = estimates_[n];
            double deviation = 0;
            for (std::size_t i = n == 0 ? 0 : ends_[n - 1]; i < ends_[n]; ++i) {
                auto value = block.value(nodes_[i].node);
                for (std::size_t k = 0; k < data_handles; ++k) {
                    if (estimate.handles[k] - first < count)
                        value[estimate.handles[k] - first] -= nodes_[i].share[k];
                }
                for (std::size_t lane = 0; lane < count; ++lane)
                    deviation = (std::max)(deviation, std::fabs(value[lane]));
            }
            const double error = (std::min)(1.0, estimate.constant + estimate.factor * deviation);
            report.push_back({{estimate.handles[0], estimate.handles[D - 2]},
                              error,
                              sufficient(estimate, error, resolution)});
        }
    }

private:
    /// Returns a resolution at which the error is below CornerError::notable; 0 if it is already below, or if
    /// no grid is fine enough.
    static std::size_t sufficient(const Estimate& estimate, double error,
                                  const std::array<std::size_t, 2>& resolution) noexcept {
        if (error <= CornerError::notable) return 0;
        const double finer =
            std::pow(error / CornerError::notable, 1 / estimate.order) / (std::min)(1.0, estimate.room);
        const double enough = std::ceil(finer * double(resolution[0]));
        return enough <= double(resolution[1]) ? std::size_t(enough) : 0;
    }

    Buffer<Estimate> estimates_;
    std::vector<std::size_t> ends_; ///< end of each estimate's nodes in `nodes_`
    Buffer<Node> nodes_;
};

} // namespace cageform::inline CAGEFORM_ABI::grid

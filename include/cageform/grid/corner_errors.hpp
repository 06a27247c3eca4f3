// How wrong a solution may be beside corners and edges that the grid is too coarse for, told from
// the solution itself.
//
// Beside a corner a solution is the boundary data, continued linearly, and the singular functions
// (grid/corner.hpp). Those are what differences and interpolation get wrong, by a share of their
// size within a cell or two. So their size is measured, as the deviation of the solution from the
// continued data at the nodes around. The constants are fitted to the true errors, by finer grids,
// of some 340 binds of random cages: the largest estimate was 1.2 to 18 times the largest error in
// nineteen of twenty, never less, 65 times at most. Bones have no estimate.
#pragma once

#include <cageform/grid/corner.hpp>
#include <cageform/grid/evaluation.hpp>

#include <cstdint>
#include <span>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// Corners in the plane or edges in space, and the nodes about each.
template <std::size_t D>
class CornerErrors {
public:
    static constexpr std::size_t data_handles = D + 1; ///< that the data beside a corner or edge is of

    struct Node {
        std::uint32_t node;
        std::array<double, data_handles> share; ///< of each handle in the continued data
    };
    struct Site {
        /// In the plane the corner, the vertices before and after it; in space the edge, the third
        /// vertices of its faces.
        std::array<std::size_t, data_handles> handles;
        double known;         ///< error that does not depend on the solution
        double per_deviation; ///< the rest of it, per deviation
        double order;         ///< of the error, in the spacing
        double room = 1;      ///< in cells; where below 1 a finer grid gives it one cell first
    };

    /// Of untreated corners and edges: the share of the singular function that is missed. It is the
    /// function (r^λ sin λθ, λ = π/ω) that is none where λ = 1; w, of slope 1 a cell, comes on top.
    static double missed_share(double exponent) noexcept { return std::clamp(6 * (1 - exponent), 0.06, 0.6); }
    static constexpr double missed_of_w = 0.2, treated_order = 2.25;

    /// A corner or edge that is not treated; `slope_of_w` is the largest coefficient of w.
    static Site untreated(const std::array<std::size_t, data_handles>& handles, const Corner& corner,
                          double slope_of_w) noexcept {
        const bool smooth = corner.is_smooth();
        return {handles, smooth ? 0 : missed_of_w * slope_of_w, missed_share(corner.exponent()),
                std::min(corner.exponent(), 1.0)};
    }

    /// A corner in the plane that is treated, or needs not be, with little room (in cells).
    static Site treated(const std::array<std::size_t, data_handles>& handles, double room) noexcept {
        return {handles, 0, 0.5 * std::min(1.0, std::pow(room, -treated_order)), treated_order};
    }

    void add(const Site& site, std::span<const Node> nodes) {
        nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
        sites_.push_back(site);
        ends_.push_back(nodes_.size());
    }

    /// Adds to `report` what `count` functions from `first` on, solved in `block`, may be off at
    /// each site; `resolution` is the grid's, and that of the finest one.
    template <class Block>
    void measure(std::size_t first, std::size_t count, const Block& block,
                 const std::array<std::size_t, 2>& resolution, std::vector<CornerError>& report) const {
        report.reserve(report.size() + sites_.size());
        for (std::size_t n = 0; n < sites_.size(); ++n) {
            const Site& site = sites_[n];
            double deviation = 0;
            for (std::size_t i = n == 0 ? 0 : ends_[n - 1]; i < ends_[n]; ++i) {
                auto value = block.value(nodes_[i].node);
                for (std::size_t k = 0; k < data_handles; ++k) {
                    if (site.handles[k] - first < count) value[site.handles[k] - first] -= nodes_[i].share[k];
                }
                for (std::size_t lane = 0; lane < count; ++lane)
                    deviation = std::max(deviation, std::fabs(value[lane]));
            }
            const double error = std::min(1.0, site.known + site.per_deviation * deviation);
            report.push_back(
                {{site.handles[0], site.handles[D - 2]}, error, sufficient(site, error, resolution)});
        }
    }

private:
    /// A resolution at which the error is notable no more; 0 where it is not, or no grid is so fine.
    static std::size_t sufficient(const Site& site, double error,
                                  const std::array<std::size_t, 2>& resolution) noexcept {
        if (error <= CornerError::notable) return 0;
        const double finer =
            std::pow(error / CornerError::notable, 1 / site.order) / std::min(1.0, site.room);
        const double enough = std::ceil(finer * double(resolution[0]));
        return enough <= double(resolution[1]) ? std::size_t(enough) : 0;
    }

    std::vector<Site> sites_;
    std::vector<std::size_t> ends_; ///< of each site in `nodes_`
    std::vector<Node> nodes_;
};

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI

// How fine a tree of cells has to be about bones.
#pragma once

#include <cageform/grid/tree/cut_tree.hpp>

namespace cageform::inline CAGEFORM_ABI::grid {

/// The sizes of cells about the bones of a boundary: as many along a bone's radius as told, so many too
/// where other parts are nearer to it than that, up to four times as many along the radius. Farther off
/// they grow with the distance from its axis, as functions fall with it.
template <std::size_t D>
class BoneSizes {
public:
    /// O(bones · facets).
    BoneSizes(const TreeBoundary<D>& boundary, double per_radius)
        : bones_(boundary.bones())
        , per_radius_(per_radius) {
        std::vector<std::uint32_t> facets(boundary.size());
        for (std::uint32_t n = 0; n < facets.size(); ++n) facets[n] = n;
        for (std::size_t bone = 0; bone < bones_.size(); ++bone) {
            const auto& placed = bones_[bone];
            double least = placed.radius;
            for (int n = 0; n <= places; ++n) {
                const auto p = placed.a + (double(n) / places) * (placed.b - placed.a);
                least = std::fmin(least, boundary.nearest(facets, p).distance - placed.radius);
            }
            at_surface_.push_back(std::fmax(least, 0.25 * placed.radius) / per_radius);
        }
    }

    /// The largest that a cell may be, in units; infinite where no bone asks. O(bones).
    double size_of(const typename CellTree<D>::Cell& cell) const noexcept {
        const double half = 0.5 * cell.size;
        auto middle = node_position<D>(cell.low);
        for (std::size_t k = 0; k < D; ++k) middle[k] += half;
        double size = std::numeric_limits<double>::infinity();
        for (std::size_t bone = 0; bone < bones_.size(); ++bone) {
            const double from_axis = bones_[bone].distance(middle) + bones_[bone].radius;
            const double nearest = from_axis - half * std::sqrt(double(D));
            size = std::fmin(size, std::fmax(at_surface_[bone], nearest / per_radius_));
        }
        return size;
    }

private:
    static constexpr int places = 8; ///< along a bone, where the distance to other parts is measured

    const GridBones<D>& bones_;
    double per_radius_;
    std::vector<double> at_surface_;
};

} // namespace cageform::inline CAGEFORM_ABI::grid

// The largest allowed cell size near bones.
#pragma once

#include <cageform/grid/tree/cut_tree.hpp>

namespace cageform::inline CAGEFORM_ABI::grid {

/// The allowed cell size near bones. At the surface of a bone `per_radius` cells fit along its radius. If a
/// facet is nearer than the radius, the distance of this facet replaces the radius. The smallest value used
/// is a quarter of the radius. Farther away the size grows with the distance from the bone's axis, because
/// functions vary less there.
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
            for (int n = 0; n <= samples; ++n) {
                const auto p = placed.a + (double(n) / samples) * (placed.b - placed.a);
                least = std::fmin(least, boundary.nearest(facets, p).distance - placed.radius);
            }
            at_surface_.push_back(std::fmax(least, 0.25 * placed.radius) / per_radius);
        }
    }

    /// Returns the largest size that bones allow for a cell, in units; infinity without bones. O(bones).
    double size_of(const typename CellTree<D>::Cell& cell) const noexcept {
        const double half = 0.5 * cell.size;
        const auto middle = cell.middle();
        double size = std::numeric_limits<double>::infinity();
        for (std::size_t bone = 0; bone < bones_.size(); ++bone) {
            const double from_axis = bones_[bone].distance(middle) + bones_[bone].radius;
            const double nearest = from_axis - half * std::sqrt(double(D));
            size = std::fmin(size, std::fmax(at_surface_[bone], nearest / per_radius_));
        }
        return size;
    }

private:
    /// Number of intervals along a bone for the distance to facets.
    static constexpr int samples = 8;

    const GridBones<D>& bones_;
    double per_radius_;
    std::vector<double> at_surface_;
};

} // namespace cageform::inline CAGEFORM_ABI::grid

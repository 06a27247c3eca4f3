// Refines a tree in space until every cell is small enough.
//
// The Refiner visits cells from the root down and splits those larger than allowed. How large a
// cell may be depends on the facets that pass it, on bones, and on the features near it (reflex
// edges and vertices, see CellSizes). RefinementPlanner estimates the number of leaves beforehand.
#pragma once

#include <cageform/grid/tree/cell_sizes.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// Forecasts a tree before it is made.
struct RefinementPlan {
    /// The scale of the cube, for TreeBoundary. Cell sizes are powers of two times the scale, and
    /// this scale wastes the fewest cells on sizes smaller than needed.
    double scale = 1;
    double leaves = 0; ///< an estimate, within a factor of two on the cages measured
};

/// Describes the finest cells of a tree.
template <std::size_t D>
struct FinestCells {
    double size = std::numeric_limits<double>::infinity(); ///< in units
    Vec<double, D> position{};                             ///< a point in one of them
    SizeReason reason = SizeReason::largest;
};

} // namespace grid

namespace detail {

/// Refines a tree that consists of one cell.
class Refiner {
public:
    using Cell = grid::CellTree<3>::Cell;

    Refiner(grid::CutTree<3>& tree, const grid::RefinementOptions& options, std::size_t most_leaves,
            const Running& running)
        : tree_(tree)
        , running_(running)
        , sizes_(tree.boundary(), options)
        , bones_(tree.boundary(), options.per_radius)
        , features_(sizes_.features())
        , most_leaves_(most_leaves) {}

    bool make() {
        tree_.find_states(); // only the root exists; splits keep the states up to date
        for (std::uint32_t n = 0; n < features_.size(); ++n) near_.push_back(n);
        ranges_.push_back({0, std::uint32_t(near_.size())});
        const auto& cells = tree_.cells();
        // Every round splits the cells that the round before has added.
        for (std::uint32_t first = 0, last = 0; first < cells.cells(); first = last) {
            last = std::uint32_t(cells.cells());
            std::uint32_t number = first;
            for (const Demands& part : demands_of(first, last)) {
                thin_.insert(thin_.end(), part.thin.begin(), part.thin.end());
                for (const auto& demand : part.list) {
                    split_if_too_large(cells.cell(number++), demand);
                    if (cells.leaves() > most_leaves_) return false;
                }
            }
        }
        // Makes cells in the middle of a thin domain as small as at its surface.
        for (const auto& thin : thin_) {
            for (double d = thin.size; d < 0.55 * thin.thickness; d += thin.size)
                split_at(thin.position + d * thin.inwards, thin.size);
            if (cells.leaves() > most_leaves_) return false;
        }
        grid::balance(tree_);
        return cells.leaves() <= most_leaves_;
    }
    const grid::FinestCells<3>& finest() const noexcept { return finest_; }

private:
    struct Range {
        std::uint32_t begin, end; ///< in near_
    };

    /// The sizes that cells may have, and where the domain is thin.
    struct Demands {
        std::vector<CellSizes::Demand> list;
        std::vector<CellSizes::ThinPoint> thin;
    };
    /// Returns what facets, bones and features allow for cells first … last − 1, in order.
    std::vector<Demands> demands_of(std::uint32_t first, std::uint32_t last) const {
        return in_runs<Demands>(running_, last - first, 256, [&] {
            return [this, first, sizes = sizes_](std::size_t begin, std::size_t end, Demands& out) mutable {
                for (std::size_t n = begin; n < end; ++n)
                    out.list.push_back(demand_of(std::uint32_t(first + n), sizes, out.thin));
            };
        });
    }
    CellSizes::Demand demand_of(std::uint32_t number, CellSizes& sizes,
                                std::vector<CellSizes::ThinPoint>& thin) const {
        const Cell cell = tree_.cells().cell(number);
        if (tree_.state(cell.number) == grid::CellState::out)
            return {std::numeric_limits<double>::infinity(), SizeReason::largest};
        const auto middle = cell.middle();
        auto least = sizes.of_facets(tree_.facets(cell.number), cell, middle, thin);
        if (const double size = bones_.size_of(cell); size < least.size) least = {size, SizeReason::bone};
        const Range features = ranges_[cell.number];
        for (std::uint32_t n = features.begin; n < features.end; ++n) {
            const auto& feature = features_[near_[n]];
            const double size = CellSizes::size_at(feature, middle);
            if (size < least.size) least = {size, feature.reason};
        }
        return least;
    }
    /// Splits a cell if it is larger than is allowed.
    void split_if_too_large(const Cell& cell, const CellSizes::Demand& allowed) {
        if (cell.size == 1 || cell.size <= allowed.size) return;
        const Range features = ranges_[cell.number];
        tree_.split(cell);
        if (0.5 * cell.size < finest_.size) finest_ = {0.5 * cell.size, cell.middle(), allowed.reason};
        for (std::size_t n = 0; n < grid::CellTree<3>::children; ++n)
            hand_down(features, tree_.cells().child(cell, n));
    }
    /// Passes a feature on to a child if it limits the size of the child or of cells in it.
    void hand_down(const Range& features, const Cell& child) {
        const auto middle = child.middle();
        const auto begin = std::uint32_t(near_.size());
        const bool counts = tree_.state(child.number) != grid::CellState::out;
        for (std::uint32_t n = features.begin; counts && n < features.end; ++n) {
            if (CellSizes::size_at(features_[near_[n]], middle) < child.size) near_.push_back(near_[n]);
        }
        ranges_.push_back({begin, std::uint32_t(near_.size())});
    }
    /// Splits the leaf at a point until it is no larger than `size`.
    void split_at(const Vec<double, 3>& position, double size) {
        grid::CellTree<3>::Index doubled{};
        for (std::size_t k = 0; k < 3; ++k) doubled[k] = std::int32_t(std::floor(2 * position[k]));
        auto leaf = tree_.cells().leaf_at(doubled);
        while (leaf.size > 1 && leaf.size > size && tree_.state(leaf.number) != grid::CellState::out) {
            tree_.split(leaf);
            leaf = tree_.cells().leaf_at(doubled);
        }
    }

    grid::CutTree<3>& tree_;
    const Running& running_;
    CellSizes sizes_;
    grid::BoneSizes<3> bones_;
    std::vector<CellSizes::Feature> features_;
    std::size_t most_leaves_;
    Buffer<std::uint32_t> near_; ///< indices of features
    Buffer<Range> ranges_;       ///< ranges of near_, by cell
    std::vector<CellSizes::ThinPoint> thin_;
    grid::FinestCells<3> finest_;
};

} // namespace detail
namespace grid {

/// Estimates the number of leaves of trees about a boundary.
class RefinementPlanner {
public:
    /// The boundary must have the scale 1.
    explicit RefinementPlanner(const TreeBoundary<3>& boundary, const Running& running = {})
        : cage_size_(detail::CellSizes::size_of_cage(boundary))
        , patches_(detail::CellSizes(boundary, {}).patches(running)) {
        for (std::size_t n = 0; n < boundary.size(); ++n) { // the volume by the divergence theorem
            const auto& facet = boundary[n];
            if (facet.separates)
                volume_ += dot(boundary.normal(n), facet.corner[0]) * detail::length(normal_of(facet)) / 6;
        }
    }

    RefinementPlan plan(const RefinementOptions& options) const noexcept {
        // Measured: leaves made for each one that the area of a face needs.
        constexpr double of_surface = 6.5;
        constexpr int steps = 16;
        RefinementPlan best{1, std::numeric_limits<double>::infinity()};
        for (int step = 0; step < steps; ++step) {
            const double scale = std::exp2(double(step) / steps), unit = (std::max)(scale, 1.0);
            const auto rounded = [&](double size) {
                return unit * std::exp2((std::max)(std::floor(std::log2(size / unit)), 0.0));
            };
            const double largest = options.largest * cage_size_;
            double leaves = volume_ / std::pow(rounded(largest), 3);
            for (const auto& patch : patches_) {
                const double size = rounded(
                    (std::min)({largest, patch.altitude / options.per_facet,
                                options.of_root_area * patch.root_area, patch.thickness / options.across}));
                // Cells reach beyond narrow facets.
                leaves +=
                    of_surface * patch.area / (size * size) * (1 + size / (std::max)(patch.altitude, 1e-3));
            }
            if (leaves < best.leaves) best = {scale, leaves};
        }
        return best;
    }

private:
    double cage_size_;
    std::vector<detail::CellSizes::Patch> patches_;
    double volume_ = 0;
};

/// Refines a tree that consists of one cell, down to cells of one unit, and then balances it.
///
///   most_leaves  returns false if more would be needed; the tree is then incomplete
///   finest       out
///   cost         a ray across the domain for each facet in each cell
inline bool refine(CutTree<3>& tree, const RefinementOptions& options, std::size_t most_leaves,
                   FinestCells<3>& finest, const Running& running = {}) {
    detail::Refiner refiner(tree, options, most_leaves, running);
    const bool whole = refiner.make();
    finest = refiner.finest();
    return whole;
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI

// A tree of cells in space made as fine as it has to be: cells are asked from the root down; what a cell
// is asked for depends on what passes it and what is near.
#pragma once

#include <cageform/grid/tree/cell_sizes.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// What a tree will be like, before it is made.
struct RefinementPlan {
    /// Of the cube, for TreeBoundary: sizes are powers of two, and so the fewest cells are smaller
    /// than they are asked to be.
    double scale = 1;
    double leaves = 0; ///< by an estimate: within a factor of two on the cages measured
};

/// The finest cells of a tree.
template <std::size_t D>
struct FinestCells {
    double size = std::numeric_limits<double>::infinity(); ///< in units
    Vec<double, D> place{};                                ///< in one of them
    SizeReason reason = SizeReason::largest;
};

} // namespace grid

namespace detail {

/// Splits the leaves of a tree that is one cell.
class Refiner {
public:
    using Cell = grid::CellTree<3>::Cell;

    Refiner(grid::CutTree<3>& tree, const grid::RefinementOptions& options, std::size_t most_leaves)
        : tree_(tree)
        , sizes_(tree.boundary(), options)
        , bones_(tree.boundary(), options.per_radius)
        , features_(sizes_.features())
        , most_leaves_(most_leaves) {}

    bool make() {
        tree_.find_states(); // of none yet; splits keep it up
        for (std::uint32_t n = 0; n < features_.size(); ++n) near_.push_back(n);
        ranges_.push_back({0, std::uint32_t(near_.size())});
        const auto& cells = tree_.cells();
        for (std::uint32_t number = 0; number < cells.cells(); ++number) { // cells are added meanwhile
            ask(cells.cell(number));
            if (cells.leaves() > most_leaves_) return false;
        }
        // The middle of the domain is as fine as its skin.
        for (const auto& thin : thin_) {
            for (double d = thin.size; d < 0.55 * thin.thickness; d += thin.size)
                split_at(thin.place + d * thin.inwards, thin.size);
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

    static Vec<double, 3> middle_of(const Cell& cell) noexcept {
        auto middle = node_position<3>(cell.low);
        for (std::size_t k = 0; k < 3; ++k) middle[k] += 0.5 * cell.size;
        return middle;
    }
    void ask(const Cell& cell) {
        if (tree_.state(cell.number) == grid::CellState::out) return;
        const auto middle = middle_of(cell);
        auto least = sizes_.of_facets(tree_.facets(cell.number), cell, middle, thin_);
        if (const double size = bones_.size_of(cell); size < least.size) least = {size, SizeReason::bone};
        const Range features = ranges_[cell.number];
        for (std::uint32_t n = features.begin; n < features.end; ++n) {
            const auto& feature = features_[near_[n]];
            const double size = CellSizes::size_at(feature, middle);
            if (size < least.size) least = {size, feature.reason};
        }
        if (cell.size == 1 || cell.size <= least.size) return;
        tree_.split(cell);
        if (0.5 * cell.size < finest_.size) finest_ = {0.5 * cell.size, middle, least.reason};
        for (std::size_t n = 0; n < grid::CellTree<3>::children; ++n)
            hand_down(features, tree_.cells().child(cell, n));
    }
    /// The features that may ask something of a cell, or of one in it.
    void hand_down(const Range& features, const Cell& child) {
        const auto middle = middle_of(child);
        const auto begin = std::uint32_t(near_.size());
        const bool counts = tree_.state(child.number) != grid::CellState::out;
        for (std::uint32_t n = features.begin; counts && n < features.end; ++n) {
            if (CellSizes::size_at(features_[near_[n]], middle) < child.size) near_.push_back(near_[n]);
        }
        ranges_.push_back({begin, std::uint32_t(near_.size())});
    }
    void split_at(const Vec<double, 3>& place, double size) {
        grid::CellTree<3>::Index doubled{};
        for (std::size_t k = 0; k < 3; ++k) doubled[k] = std::int32_t(std::floor(2 * place[k]));
        auto leaf = tree_.cells().leaf_at(doubled);
        while (leaf.size > 1 && leaf.size > size && tree_.state(leaf.number) != grid::CellState::out) {
            tree_.split(leaf);
            leaf = tree_.cells().leaf_at(doubled);
        }
    }

    grid::CutTree<3>& tree_;
    CellSizes sizes_;
    grid::BoneSizes<3> bones_;
    std::vector<CellSizes::Feature> features_;
    std::size_t most_leaves_;
    Buffer<std::uint32_t> near_; ///< features
    Buffer<Range> ranges_;       ///< of them, by cell
    std::vector<CellSizes::ThinPlace> thin_;
    grid::FinestCells<3> finest_;
};

} // namespace detail
namespace grid {

/// Tells what trees about a boundary will be like.
class RefinementPlanner {
public:
    /// Of a boundary with the scale 1.
    explicit RefinementPlanner(const TreeBoundary<3>& boundary)
        : cage_size_(detail::CellSizes::size_of_cage(boundary))
        , patches_(detail::CellSizes(boundary, {}).patches()) {
        for (std::size_t n = 0; n < boundary.size(); ++n) { // the divergence theorem
            const auto& facet = boundary[n];
            if (facet.turns)
                volume_ += dot(boundary.normal(n), facet.corner[0]) * detail::length(normal_of(facet)) / 6;
        }
    }

    RefinementPlan plan(const RefinementOptions& options) const noexcept {
        constexpr double of_surface = 6.5; // leaves, as measured, for one that a face needs
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
                const double size = rounded((std::min)(
                    {largest, patch.altitude / options.per_facet, patch.thickness / options.across}));
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

/// Splits the leaves of a tree that is one cell, down to cells of one unit, then those that
/// neighbours of less than half their size ask.
///
///   most_leaves  false when more would be needed; the tree is then not whole
///   finest       out
///   cost         a ray across the domain for each facet in each cell
inline bool refine(CutTree<3>& tree, const RefinementOptions& options, std::size_t most_leaves,
                   FinestCells<3>& finest) {
    detail::Refiner refiner(tree, options, most_leaves);
    const bool whole = refiner.make();
    finest = refiner.finest();
    return whole;
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI

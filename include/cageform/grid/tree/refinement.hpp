// Refines a tree until every cell has the allowed size.
//
// The Refiner visits cells from the root down and splits those larger than allowed. The allowed size depends
// on the facets that intersect the cell, on bones, and on the features near the cell (see Features: reflex
// edges and vertices). RefinementPlanner predicts the number of leaves.
#pragma once

#include <cageform/grid/tree/features.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// A prediction of a tree.
struct RefinementPlan {
    /// The scale of the cube for TreeBoundary. Cell sizes are powers of two times the scale; this scale
    /// gives the fewest cells.
    double scale = 1;
    double leaves = 0; ///< estimate, within a factor of two on the measured cages
};

template <std::size_t D>
struct FinestCells {
    double size = std::numeric_limits<double>::infinity(); ///< in units
    Vec<double, D> position{};                             ///< a point in one of the finest cells
    SizeReason reason = SizeReason::largest;
};

} // namespace grid

namespace detail {

template <std::size_t D>
class Refiner {
public:
    using Cell = typename grid::CellTree<D>::Cell;
    using SizeLimit = typename CellSizes<D>::SizeLimit;
    using ThinPoint = typename CellSizes<D>::ThinPoint;

    Refiner(grid::CutTree<D>& tree, const grid::RefinementOptions& options, std::size_t most_leaves,
            const Running& running)
        : tree_(tree)
        , running_(running)
        , sizes_(tree.boundary(), options)
        , bones_(tree.boundary(), options.per_radius)
        , features_(Features<D>(sizes_).find())
        , most_leaves_(most_leaves) {}

    bool make() {
        tree_.find_states(); // only the root exists; splits update the states
        for (std::uint32_t n = 0; n < features_.size(); ++n) near_.push_back(n);
        ranges_.push_back({0, std::uint32_t(near_.size())});
        const auto& cells = tree_.cells();
        constexpr double of_rounds = 0.7, of_thin = 0.85; // of the progress
        const double most_rounds = (1 + std::log2(double(cells.size()))) / of_rounds;
        double round = 0;
        // Every round splits the cells added by the round before.
        for (std::uint32_t first = 0, last = 0; first < cells.cells(); first = last) {
            last = std::uint32_t(cells.cells());
            std::uint32_t number = first;
            const Running of_round = running_.subtask(round / most_rounds, (round + 1) / most_rounds);
            ++round;
            for (const SizeLimits& part : size_limits(first, last, of_round.subtask(0, 0.5))) {
                report_progress(of_round, 0.5 + 0.5 * double(number - first) / double(last - first));
                thin_.insert(thin_.end(), part.thin.begin(), part.thin.end());
                for (const auto& limit : part.list) {
                    split_if_too_large(cells.cell(number++), limit);
                    if (cells.leaves() > most_leaves_) return false;
                }
            }
        }
        // Splits cells in the middle of a thin domain to the size at its surface.
        for (std::size_t n = 0; n < thin_.size(); ++n) {
            const auto& thin = thin_[n];
            if (n % 1024 == 0)
                report_progress(running_, std::lerp(of_rounds, of_thin, double(n) / double(thin_.size())));
            for (double d = thin.size; d < 0.55 * thin.thickness; d += thin.size)
                split_at(thin.position + d * thin.inwards, thin.size);
            if (cells.leaves() > most_leaves_) return false;
        }
        grid::balance(tree_, running_.subtask(of_thin, 1));
        return cells.leaves() <= most_leaves_;
    }
    const grid::FinestCells<D>& finest() const noexcept { return finest_; }

private:
    struct Range {
        std::uint32_t begin, end; ///< in near_
    };

    /// The allowed cell sizes, and the points where the domain is thin.
    struct SizeLimits {
        std::vector<SizeLimit> list;
        std::vector<ThinPoint> thin;
    };
    /// Returns the sizes that facets, bones and features allow for cells first … last − 1, in order.
    std::vector<SizeLimits> size_limits(std::uint32_t first, std::uint32_t last,
                                        const Running& running) const {
        return in_runs<SizeLimits>(running, last - first, 256, [&] {
            return
                [this, first, sizes = sizes_](std::size_t begin, std::size_t end, SizeLimits& out) mutable {
                    for (std::size_t n = begin; n < end; ++n)
                        out.list.push_back(size_limit(std::uint32_t(first + n), sizes, out.thin));
                };
        });
    }
    SizeLimit size_limit(std::uint32_t number, CellSizes<D>& sizes, std::vector<ThinPoint>& thin) const {
        const Cell cell = tree_.cells().cell(number);
        if (tree_.state(cell.number) == grid::CellState::out)
            return {std::numeric_limits<double>::infinity(), SizeReason::largest};
        const auto middle = cell.middle();
        auto least = sizes.of_facets(tree_.facets(cell.number), cell, middle, thin);
        if (const double size = bones_.size_of(cell); size < least.size) least = {size, SizeReason::bone};
        const Range features = ranges_[cell.number];
        for (std::uint32_t n = features.begin; n < features.end; ++n) {
            const auto& feature = features_[near_[n]];
            const double size = feature.size_at(middle);
            if (size < least.size) least = {size, feature.reason};
        }
        return least;
    }
    void split_if_too_large(const Cell& cell, const SizeLimit& allowed) {
        if (cell.size == 1 || cell.size <= allowed.size) return;
        const Range features = ranges_[cell.number];
        tree_.split(cell);
        if (0.5 * cell.size < finest_.size) finest_ = {0.5 * cell.size, cell.middle(), allowed.reason};
        for (std::size_t n = 0; n < grid::CellTree<D>::children; ++n)
            add_features(features, tree_.cells().child(cell, n));
    }
    /// Lists the features of a child: those of its parent that limit the size of the child or of cells in it.
    void add_features(const Range& features, const Cell& child) {
        const auto middle = child.middle();
        const auto begin = std::uint32_t(near_.size());
        const bool counts = tree_.state(child.number) != grid::CellState::out;
        for (std::uint32_t n = features.begin; counts && n < features.end; ++n) {
            if (features_[near_[n]].size_at(middle) < child.size) near_.push_back(near_[n]);
        }
        ranges_.push_back({begin, std::uint32_t(near_.size())});
    }
    /// Splits the leaf at a point until its size is at most `size`.
    void split_at(const Vec<double, D>& position, double size) {
        typename grid::CellTree<D>::Index doubled{};
        for (std::size_t k = 0; k < D; ++k) doubled[k] = std::int32_t(std::floor(2 * position[k]));
        auto leaf = tree_.cells().leaf_at(doubled);
        while (leaf.size > 1 && leaf.size > size && tree_.state(leaf.number) != grid::CellState::out) {
            tree_.split(leaf);
            leaf = tree_.cells().leaf_at(doubled);
        }
    }

    grid::CutTree<D>& tree_;
    const Running& running_;
    CellSizes<D> sizes_;
    grid::BoneSizes<D> bones_;
    std::vector<Feature<D>> features_;
    std::size_t most_leaves_;
    Buffer<std::uint32_t> near_; ///< indices of features
    Buffer<Range> ranges_;       ///< per cell, ranges of near_
    std::vector<ThinPoint> thin_;
    grid::FinestCells<D> finest_;
};

} // namespace detail
namespace grid {

/// Predicts the number of leaves of trees over a boundary.
template <std::size_t D>
class RefinementPlanner {
public:
    /// The boundary must have the scale 1.
    explicit RefinementPlanner(const TreeBoundary<D>& boundary, const Running& running = {})
        : cage_size_(detail::CellSizes<D>::size_of_cage(boundary))
        , patches_(detail::CellSizes<D>(boundary, {}).patches(running)) {
        if constexpr (D == 2) {
            detail::CellSizes<2> sizes(boundary, {});
            inverse_exponents_ = detail::Features<2>(sizes).inverse_exponents();
        }
        for (std::size_t n = 0; n < boundary.size(); ++n) { // the volume by the divergence theorem
            const auto& facet = boundary[n];
            if (facet.separates)
                volume_ += dot(boundary.normal(n), facet.corner[0]) * detail::measure(facet.corner) / D;
        }
    }

    RefinementPlan plan(const RefinementOptions& options) const noexcept {
        // A measured ratio: all leaves / leaves required by the area of a face (in 2D by the length of an
        // edge).
        constexpr double of_surface = D == 2 ? 2.5 : 6.5;
        // In 2D only scale 1 is tried; the default of RefinementOptions::largest is then a cell size.
        constexpr int steps = D == 2 ? 1 : 16;
        RefinementPlan best{1, std::numeric_limits<double>::infinity()};
        for (int step = 0; step < steps; ++step) {
            const double scale = std::exp2(double(step) / steps), unit = (std::max)(scale, 1.0);
            const auto rounded = [&](double size) {
                return unit * std::exp2((std::max)(std::floor(std::log2(size / unit)), 0.0));
            };
            const double largest = options.largest * cage_size_;
            double leaves = volume_ / std::pow(rounded(largest), double(D));
            for (const auto& patch : patches_) {
                const double most = (std::min)(
                    {largest, patch.altitude / options.per_facet, options.of_root_area * patch.root_area});
                patch.for_each_part(options, most, [&](double size, double area) {
                    size = rounded(size);
                    // Cells extend beyond narrow facets.
                    const double beyond = 1 + size / (std::max)(patch.altitude, 1e-3);
                    leaves += of_surface * area / std::pow(size, double(D - 1)) * beyond;
                });
            }
            const double g = options.corner_gradation; // measured: leaves per halving
            leaves += options.corner_levels * inverse_exponents_ * (12 + 5.5 * g * g);
            if (leaves < best.leaves) best = {scale, leaves};
        }
        return best;
    }

private:
    double cage_size_;
    std::vector<typename detail::CellSizes<D>::Patch> patches_;
    double volume_ = 0;
    double inverse_exponents_ = 0; ///< in 2D
};

/// Refines a tree of one cell, down to cells of one unit, and then balances it.
///
///   most_leaves  limit; if it is exceeded, the tree is incomplete and the result false
///   finest       out: the smallest cells, and why they are small
///   cost         one ray across the domain per facet in each cell
template <std::size_t D>
bool refine(CutTree<D>& tree, const RefinementOptions& options, std::size_t most_leaves,
            FinestCells<D>& finest, const Running& running = {}) {
    detail::Refiner<D> refiner(tree, options, most_leaves, running);
    const bool whole = refiner.make();
    finest = refiner.finest();
    return whole;
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI

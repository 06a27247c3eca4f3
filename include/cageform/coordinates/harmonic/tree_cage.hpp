// A cage laid into a tree of cells: how fine for which accuracy, where points lie, what they are a mean
// of.
#pragma once

#include <cageform/coordinates/cage_solver.hpp>
#include <cageform/grid/tree/leaf_gather.hpp>
#include <cageform/grid/tree/refinement.hpp>
#include <cageform/grid/tree/sizing.hpp>
#include <cageform/grid/tree/star.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A cage laid into a tree. The cage outlives it; it is not moved, as its parts point to each other.
template <class C>
class TreeCage {
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;

public:
    /// Cells of a side of the smallest cube about the cage, at most, as a power of two.
    static constexpr unsigned most_depth = D == 2 ? 20 : 16, least_depth = 8;
    /// The same of a cage that has thin bones.
    static constexpr unsigned most_depth_at_bones = grid::CellTree<D>::most_depth;
    /// The same, so that no cell is much smaller than the tolerance: so near to the cage no function is
    /// asked for, and cells would be lost in the rounding of coordinates.
    static unsigned depth_of(const C& cage, T tolerance) noexcept {
        const auto bounds = bounds_of(cage.vertices());
        double longest = 0;
        for (std::size_t k = 0; k < D; ++k)
            longest = std::fmax(longest, double(bounds.upper[k]) - double(bounds.lower[k]));
        unsigned depth = most_depth;
        for (const auto& bone : interior_cells(cage).bones) {
            while (depth < most_depth_at_bones && std::ldexp(longest, -int(depth)) > 0.25 * bone.radius)
                ++depth;
        }
        while (depth > 0 && std::ldexp(longest, -int(depth)) < 0.25 * double(tolerance)) --depth;
        return depth;
    }

    /// What a tree will be like.
    class Plan {
    public:
        Plan(const C& cage, T tolerance) {
            if constexpr (D == 3) planner_.emplace(boundary_of_tree(cage, tolerance, 1));
        }
        double scale(double accuracy) const noexcept { return plan(accuracy).scale; }
        double leaves(double accuracy) const noexcept { return plan(accuracy).leaves; }
        /// A coarser accuracy for which no more are needed; 0: none.
        double sufficient_accuracy(double accuracy, double most) const noexcept {
            do {
                accuracy *= 1.25;
            } while (accuracy < most_accuracy && leaves(accuracy) > most);
            return accuracy < most_accuracy && D == 3 ? accuracy : 0;
        }

    private:
        grid::RefinementPlan plan(double accuracy) const noexcept {
            if constexpr (D == 3) return planner_->plan(sizing(accuracy)); // NOLINT: made in space
            return {};
        }
        std::optional<grid::RefinementPlanner> planner_;
    };
    static constexpr double least_accuracy = 1e-5, most_accuracy = 0.1;

    TreeCage(const C& cage, T tolerance, double scale = 1)
        : cage_(cage)
        , tolerance_(tolerance)
        , boundary_(boundary_of_tree(cage, tolerance, scale))
        , tree_(boundary_) {}
    TreeCage(const TreeCage&) = delete;
    TreeCage& operator=(const TreeCage&) = delete;
    ~TreeCage() = default;

    /// Errors fall with the square of the cells' sizes, in the plane with their fourth power. The factors
    /// are measured: so that in the plane on the oracles and on random cages all, and in space on the
    /// reference points of tests/data/fingers and the oracles most are what is asked for.
    static auto sizing(double accuracy) noexcept {
        if constexpr (D == 2) {
            const double finer = std::sqrt(std::sqrt(1e-2 / accuracy));
            return grid::SizingOptions{.across = (std::max)(3.0, 1.5 * finer),
                                       .per_facet = (std::max)(1.0, 0.75 * finer),
                                       .singular_levels = 0.8 * std::log2(1 / accuracy) - 1.4,
                                       .layers = unsigned(std::lround(0.5 + 1.3 * finer)),
                                       // Half as large for a tenth, as sizes are powers of two.
                                       .largest = 0.0626 * std::pow(100 * accuracy, 0.301)};
        } else {
            const double finer = std::sqrt(2e-3 / accuracy), levels = (std::max)(0.0, 1 + std::log2(finer));
            return grid::RefinementOptions{.across = 4.8 * finer,
                                           .per_facet = 0.89 * finer,
                                           .edge_levels = levels,
                                           .reflex_levels = levels,
                                           .at_vertex = 7 * accuracy, // errors there are of first order
                                           .per_radius = 10 * finer,
                                           .largest = (std::min)(0.08, 0.0253 / finer)};
        }
    }

    /// False where more leaves than the most allowed are needed; `leaves` then says how many, by an
    /// estimate.
    bool refine(double accuracy, double most, double& leaves) {
        const auto options = sizing(accuracy);
        bool whole = true;
        if constexpr (D == 2) {
            constexpr double samples_of_leaf = 5; // as measured
            const auto samples =
                grid::size_samples(boundary_, options, std::size_t(4 * samples_of_leaf * most));
            leaves = samples.count / samples_of_leaf;
            if (double(samples.list.size()) < samples.count) return false;
            const std::span<const grid::SizeSample<D>> list(samples.list.data(), samples.list.size());
            whole = grid::refine(tree_, list, options, std::size_t(most));
            for (const auto& [place, size, reason] : list) {
                if (size < finest_.size) finest_ = {size, place, reason};
            }
        } else {
            whole = grid::refine(tree_, options, std::size_t(most), finest_);
        }
        leaves = whole ? double(tree_.cells().leaves()) : (std::max)(leaves, most + 1);
        if (whole) nodes_ = grid::nodes_of(tree_);
        return whole;
    }

    /// Puts its finest cells into the report.
    void report_finest(SolverReport& report) const noexcept {
        std::int32_t smallest = tree_.cells().size();
        tree_.cells().for_each_leaf([&](const Cell& leaf) {
            if (tree_.state(leaf.number) != grid::CellState::out) smallest = (std::min)(smallest, leaf.size);
        });
        const auto place = boundary_.in_cage(finest_.place);
        report.finest_size = boundary_.unit() * smallest;
        for (std::size_t k = 0; k < D; ++k) report.finest_place[k] = place[k];
        report.finest_reason = finest_.reason;
    }

    const C& cage() const noexcept { return cage_; }
    /// A handle of a bone thinner than the smallest cells that there are.
    std::optional<std::uint32_t> too_thin() const noexcept { return boundary_.bones().too_thin(); }
    const grid::CutTree<D>& tree() const noexcept { return tree_; }
    const grid::TreeNodes<D>& nodes() const noexcept { return nodes_; }
    std::size_t bytes() const noexcept { return tree_.bytes() + nodes_.bytes(); }
    template <class F>
    void for_each_cell(F&& f) const {
        tree_.cells().for_each_leaf([&](const Cell& leaf) {
            const auto state = tree_.state(leaf.number);
            if (state == grid::CellState::out) return;
            const auto low = vec_cast<T>(boundary_.in_cage(node_position<D>(leaf.low)));
            f(GridCell<T, D>{low, T(boundary_.unit() * leaf.size), state == grid::CellState::cut});
        });
    }

    /// The size of the leaf at a place, in units of the cage.
    double spacing(const Vec<T, D>& p) const noexcept {
        return boundary_.unit() * tree_.leaf_at(placed(p)).size;
    }
    PointState state_of(const Vec<T, D>& p) const noexcept {
        const auto at = placed(p);
        return located(p, at, tree_.leaf_at(at)).state;
    }
    /// From a place inside along an axis, up or down, to the boundary, in sizes of the leaf there; at
    /// most `limit`.
    double free_distance(const Vec<T, D>& p, std::size_t axis, bool up, double limit) const noexcept {
        const auto at = placed(p);
        const double size = tree_.leaf_at(at).size;
        return std::fmin(limit, boundary_.free_distance({at, axis, up, limit * size}) / size);
    }

    /// What the value at point `i` of a batch is a mean of, and where it lies; nothing for points
    /// outside and beyond the batch.
    grid::CutStencil<D> stencil(const Batch<T>& batch, std::size_t i) const {
        grid::CutStencil<D> stencil;
        if (i >= batch.points.points || batch.states[i] == PointState::not_finite) return stencil;
        const auto p = block_point<D>(batch.points, i);
        const auto at = placed(p);
        const auto leaf = tree_.leaf_at(at);
        const auto [state, value] = located(p, at, leaf);
        batch.states[i] = state;
        if (state == PointState::on_boundary) {
            stencil.add(value, 1.0);
        } else if (state == PointState::inside) {
            set_stencil(at, leaf, stencil);
        }
        return stencil;
    }

private:
    using Cell = typename grid::CellTree<D>::Cell;

    static grid::TreeBoundary<D> boundary_of_tree(const C& cage, T tolerance, double scale) {
        return {cage, depth_of(cage, tolerance), 2 * double(tolerance), scale};
    }
    Vec<double, D> placed(const Vec<T, D>& p) const noexcept {
        return boundary_.in_units(vec_cast<double>(p));
    }
    /// Next to the boundary the facets of the tree are rounded, and a leaf does not see all that shapes the
    /// function. There a value is linear between the nearest place of the boundary, as it is, and a place
    /// farther inside: with the distance it tends to the data.
    void set_stencil(const Vec<double, D>& p, const Cell& leaf, grid::CutStencil<D>& stencil) const {
        double layer = layer_share * leaf.size;
        const auto nearest = boundary_.nearest(tree_.facets(leaf.number), p, false);
        if (nearest.distance < layer) { // the place farther inside stays out of bones
            if (const auto bone = boundary_.bones().nearest(p, layer)) layer = bone->distance;
        }
        if (!(nearest.distance < layer)) return set_stencil_inside(p, leaf, stencil);
        if (nearest.distance > grid::on_facet_distance) {
            const auto along = (layer / nearest.distance - 1) * (p - nearest.place);
            const auto met = boundary_.first_met(p, along);
            const double share =
                nearest.distance / (nearest.distance + (met ? met->part : 1) * length(along));
            if (met) {
                stencil.add(met->value, share);
            } else {
                set_stencil_inside(p + along, tree_.leaf_at(p + along), stencil);
                stencil.scale(share);
            }
            stencil.add(nearest.value, 1 - share);
        } else {
            stencil.add(nearest.value, 1.0);
        }
    }
    void set_stencil_inside(const Vec<double, D>& p, const Cell& leaf, grid::CutStencil<D>& stencil) const {
        if constexpr (D == 2) {
            if (const auto mean = harmonic_mean_of(tree_, nodes_, p, leaf, HarmonicMean::most_degree)) {
                stencil = *mean;
                return;
            }
        }
        grid::StencilSink<D> sink{nodes_, stencil};
        LeafGather<D, grid::StencilSink<D>>(boundary_, nodes_, sink)
            .gather(leaf, tree_.facets(leaf.number), p);
    }
    grid::Located<D> located(const Vec<T, D>& p, const Vec<double, D>& at, const Cell& leaf) const noexcept {
        const double size = tree_.cells().size();
        bool in_cube = true;
        for (std::size_t k = 0; k < D; ++k) in_cube = in_cube && at[k] > 0 && at[k] < size;
        const auto state = tree_.state(leaf.number);
        if (in_cube && state != grid::CellState::cut)
            return {state == grid::CellState::in ? PointState::inside : PointState::outside, {}};
        // Where the tolerance or what the tree has rounded might decide.
        const double undecided =
            1e-4 + std::ldexp(2.0, -boundary_.fraction()) + 2 * double(tolerance_) / boundary_.unit();
        if (in_cube && boundary_.nearest(tree_.facets(leaf.number), at).distance > undecided) {
            std::array<std::int64_t, D> line{};
            for (std::size_t k = 0; k < D; ++k)
                line[k] = std::llround(std::ldexp(at[k], boundary_.fraction()));
            return {tree_.is_inside(line) ? PointState::inside : PointState::outside, {}};
        }
        grid::Located<D> found{locate(cage_, p, tolerance_), {}};
        Vec<T, D> place;
        if (found.state == PointState::on_boundary) found.value = nearest_boundary_value(cage_, p, place);
        return found;
    }

    /// How far from the boundary values are linear, as a share of the leaf. In the plane, where they are of
    /// order four beyond it, so near that what is not linear is below every accuracy; in space where that is
    /// the better of the two.
    static constexpr double layer_share = D == 2 ? 0.01 : 0.3;

    const C& cage_;
    T tolerance_;
    grid::TreeBoundary<D> boundary_;
    grid::CutTree<D> tree_;
    grid::TreeNodes<D> nodes_;
    grid::FinestCells<D> finest_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

// Embeds a cage in an adaptive grid: cell sizes for an accuracy, location of points, interpolation stencils.
#pragma once

#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/harmonic/cage_solver.hpp>
#include <cageform/grid/tree/leaf_gather.hpp>
#include <cageform/grid/tree/refinement.hpp>
#include <cageform/grid/tree/star.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A cage embedded in a tree of cells. Refers to the cage. Not movable, because members refer to each other.
template <std::size_t D>
class TreeCage {
    using C = CellComplex<double, D>;

public:
    /// The largest depth of the tree. Cells of depth d have the size 2^-d of the cube around the cage.
    static constexpr unsigned most_depth = D == 2 ? 20 : 16, least_depth = 8;
    /// The largest depth for a cage with thin bones.
    static constexpr unsigned most_depth_at_bones = grid::CellTree<D>::most_depth;
    /// Returns the largest depth for this cage, so that cells are not much smaller than the tolerance:
    /// smaller cells hold only boundary points and are lost in the rounding of coordinates.
    static unsigned depth_of(const C& cage, double tolerance) noexcept {
        const auto bounds = bounds_of(cage.vertices());
        double longest = 0;
        for (std::size_t k = 0; k < D; ++k)
            longest = std::fmax(longest, double(bounds.upper[k]) - double(bounds.lower[k]));
        unsigned depth = most_depth;
        for (const auto& bone : interior_cells(cage).bones) {
            while (depth < most_depth_at_bones && std::ldexp(longest, -int(depth)) > 0.25 * bone.radius)
                ++depth;
        }
        while (depth > 0 && std::ldexp(longest, -int(depth)) < 0.25 * tolerance) --depth;
        return depth;
    }

    /// Predicts the size of a tree before it is made.
    class Plan {
    public:
        ///   subtracts_kinks  whether a near field is subtracted (near_rows.hpp)
        Plan(const SolverInput<D>& input, bool subtracts_kinks, const Running& running)
            : planner_(boundary_of_tree(input.cage, input.tolerance, 1), running)
            , locality_(input.options.locality)
            , subtracts_kinks_(subtracts_kinks) {}
        double scale(double accuracy) const noexcept { return plan(accuracy).scale; }
        double leaves(double accuracy) const noexcept { return plan(accuracy).leaves; }
        /// Returns a coarser accuracy that needs at most `most` leaves, or 0 if there is none.
        double sufficient_accuracy(double accuracy, double most) const noexcept {
            do {
                accuracy *= 1.25;
            } while (accuracy < most_accuracy && leaves(accuracy) > most);
            return accuracy < most_accuracy ? accuracy : 0;
        }

    private:
        grid::RefinementPlan plan(double accuracy) const noexcept {
            return planner_.plan(sizing(accuracy, locality_, subtracts_kinks_));
        }
        grid::RefinementPlanner<D> planner_;
        double locality_;
        bool subtracts_kinks_;
    };
    static constexpr double least_accuracy = 1e-5, most_accuracy = 0.1;

    ///   subtracts_kinks  whether a near field is subtracted (near_rows.hpp)
    TreeCage(const SolverInput<D>& input, bool subtracts_kinks, double scale = 1)
        : cage_(input.cage)
        , tolerance_(input.tolerance)
        , locality_(input.options.locality)
        , subtracts_kinks_(subtracts_kinks)
        , boundary_(boundary_of_tree(cage_, tolerance_, scale))
        , tree_(boundary_, input.screening * boundary_.unit() * boundary_.unit()) {}
    TreeCage(const TreeCage&) = delete;
    TreeCage& operator=(const TreeCage&) = delete;
    ~TreeCage() = default;

    /// Returns the cell sizes for an accuracy. The factors are empirical. 2D errors are of order four in the
    /// cell size, and within the accuracy on all cages with known solutions and on random cages. With a 3D
    /// near field, cells need not resolve the kinks of the data. They may be far larger than small facets and
    /// than the thickness of the domain (HarmonicOptions::accuracy). Without a near field, 3D errors are of
    /// order two. With a locality, cells are at most `most_decay`/κ large.
    static grid::RefinementOptions sizing(double accuracy, double locality, bool subtracts_kinks) noexcept {
        constexpr double most_decay = 0.7;
        auto options = sizing(accuracy, subtracts_kinks);
        options.largest = (std::min)(options.largest, most_decay / (std::max)(locality, 1.0));
        return options;
    }
    static grid::RefinementOptions sizing(double accuracy, [[maybe_unused]] bool subtracts_kinks) noexcept {
        if constexpr (D == 2) {
            const double finer = std::sqrt(std::sqrt(1e-2 / accuracy));
            return {.across = (std::max)(3.0, 1.5 * finer),
                    .per_facet = (std::max)(1.0, 0.75 * finer),
                    .corner_levels = 0.8 * std::log2(1 / accuracy) - 1.4,
                    .corner_gradation = 0.7 + 0.6 * finer,
                    // Sizes are powers of two, so a tenth of the accuracy halves the cells.
                    .largest = 0.0626 * std::pow(100 * accuracy, 0.301)};
        } else {
            const double finer = std::sqrt(2e-3 / accuracy);
            if (!subtracts_kinks) {
                const double levels = (std::max)(0.0, 1 + std::log2(finer));
                return {.across = 4.8 * finer,
                        .per_facet = 0.89 * finer,
                        .edge_levels = levels,
                        .reflex_levels = levels,
                        .at_vertex = 7 * accuracy, // errors there are of first order
                        .per_radius = 10 * finer,
                        .largest = (std::min)(0.08, 0.0253 / finer)};
            }
            // Without kinks, reflex edges have the largest errors.
            const double levels = (std::max)(2.0, 2 + std::log2(finer));
            return {.across = 2.4 * finer,
                    .small_error = accuracy,
                    .per_facet = 0.25 * finer,
                    // Bounds the number of faces in a near field.
                    .of_root_area = 1.7,
                    .edge_levels = levels,
                    .reflex_levels = levels,
                    .at_vertex = 5 * accuracy,
                    // Errors far from the boundary are of order four in the cell size.
                    .largest = (std::min)(0.056, 0.3 * std::sqrt(std::sqrt(accuracy)))};
        }
    }

    /// Refines the tree. Returns false if it needs more than `most` leaves; `leaves` is then an estimate.
    bool refine(double accuracy, double most, double& leaves, const Running& running) {
        const bool whole = grid::refine(tree_, sizing(accuracy, locality_, subtracts_kinks_),
                                        std::size_t(most), finest_, running.subtask(0, 0.8));
        leaves = whole ? double(tree_.cells().leaves()) : (std::max)(leaves, most + 1);
        if (whole) nodes_ = grid::nodes_of(tree_, running.subtask(0.8, 1));
        return whole;
    }

    /// Reports the smallest cells.
    void report_finest(SolverReport& report) const noexcept {
        std::int32_t smallest = tree_.cells().size();
        tree_.cells().for_each_leaf([&](const Cell& leaf) {
            if (tree_.state(leaf.number) != grid::CellState::out) smallest = (std::min)(smallest, leaf.size);
        });
        const auto position = boundary_.in_cage(finest_.position);
        report.tree.finest_size = boundary_.unit() * smallest;
        for (std::size_t k = 0; k < D; ++k) report.tree.finest_position[k] = position[k];
        report.tree.finest_reason = finest_.reason;
    }

    const C& cage() const noexcept { return cage_; }
    /// Returns a handle of a bone that is thinner than the smallest cells, if there is one.
    std::optional<std::uint32_t> too_thin() const noexcept { return boundary_.bones().too_thin(); }
    const grid::CutTree<D>& tree() const noexcept { return tree_; }
    const grid::TreeNodes<D>& nodes() const noexcept { return nodes_; }
    std::size_t bytes() const noexcept { return tree_.bytes() + nodes_.bytes(); }
    template <class F>
    void for_each_cell(F&& f) const {
        tree_.cells().for_each_leaf([&](const Cell& leaf) {
            const auto state = tree_.state(leaf.number);
            if (state == grid::CellState::out) return;
            const auto low = boundary_.in_cage(node_position<D>(leaf.low));
            f(GridCell<double, D>{low, boundary_.unit() * leaf.size, state == grid::CellState::cut});
        });
    }

    /// Returns the size of the leaf at a point, in units of the cage.
    double spacing(const Vec<double, D>& p) const noexcept {
        return boundary_.unit() * tree_.leaf_at(placed(p)).size;
    }
    PointState state_of(const Vec<double, D>& p) const noexcept {
        const auto at = placed(p);
        return located(p, at, tree_.leaf_at(at)).state;
    }
    /// Returns the distance from an inside point to the boundary along an axis, up or down, in sizes of the
    /// point's leaf; at most `limit`.
    double free_distance(const Vec<double, D>& p, std::size_t axis, bool up, double limit) const noexcept {
        const auto at = placed(p);
        const double size = tree_.leaf_at(at).size;
        return std::fmin(limit, boundary_.free_distance({at, axis, up, limit * size}) / size);
    }

    /// Returns the interpolation stencil of point `i` of a batch and sets its state. The stencil of outside
    /// points, and of indices beyond the batch, is empty.
    template <Scalar T>
    grid::CutStencil<D> stencil(const Batch<T>& batch, std::size_t i) const {
        auto stencil = stencil_outside(batch, i);
        if (i < batch.points.points && batch.states[i] == PointState::inside) {
            const auto at = placed(vec_cast<double>(block_point<D>(batch.points, i)));
            set_stencil(at, tree_.leaf_at(at), stencil);
        }
        return stencil;
    }
    /// As `stencil`, but without stencils of inside points.
    template <Scalar T>
    grid::CutStencil<D> stencil_outside(const Batch<T>& batch, std::size_t i) const {
        grid::CutStencil<D> stencil;
        if (i >= batch.points.points || batch.states[i] == PointState::not_finite) return stencil;
        const auto p = vec_cast<double>(block_point<D>(batch.points, i));
        const auto at = placed(p);
        const auto [state, value] = located(p, at, tree_.leaf_at(at));
        batch.states[i] = state;
        if (state == PointState::on_boundary) stencil.add(value, 1.0);
        return stencil;
    }

private:
    using Cell = typename grid::CellTree<D>::Cell;

    static grid::TreeBoundary<D> boundary_of_tree(const C& cage, double tolerance, double scale) {
        return {cage, depth_of(cage, tolerance), 2 * tolerance, scale};
    }
    Vec<double, D> placed(const Vec<double, D>& p) const noexcept { return boundary_.in_units(p); }
    /// Sets the stencil of an inside point. Close to the boundary, facets of the tree are rounded and a leaf
    /// lacks some facets that affect the function. There the value is interpolated linearly between the
    /// nearest point of the unrounded boundary and a point farther inside, so it tends to the boundary
    /// values.
    void set_stencil(const Vec<double, D>& p, const Cell& leaf, grid::CutStencil<D>& stencil) const {
        double layer = layer_share * leaf.size;
        const auto nearest = boundary_.nearest(tree_.facets(leaf.number), p, false);
        if (nearest.distance < layer) { // the point farther inside must not lie in a bone
            if (const auto bone = boundary_.bones().nearest(p, layer)) layer = bone->distance;
        }
        if (!(nearest.distance < layer)) return set_stencil_inside(p, leaf, stencil);
        if (nearest.distance > grid::on_facet_distance) {
            const auto along = (layer / nearest.distance - 1) * (p - nearest.position);
            const auto met = boundary_.first_met(p, along);
            const double share =
                nearest.distance / (nearest.distance + (met ? met->fraction : 1) * length(along));
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
    grid::Located<D> located(const Vec<double, D>& p, const Vec<double, D>& at,
                             const Cell& leaf) const noexcept {
        const double size = tree_.cells().size();
        bool in_cube = true;
        for (std::size_t k = 0; k < D; ++k) in_cube = in_cube && at[k] > 0 && at[k] < size;
        const auto state = tree_.state(leaf.number);
        if (in_cube && state != grid::CellState::cut)
            return {state == grid::CellState::in ? PointState::inside : PointState::outside, {}};
        // Beyond this distance neither the tolerance nor the rounding of the tree changes the result.
        const double undecided =
            1e-4 + std::ldexp(2.0, -boundary_.fraction()) + 2 * tolerance_ / boundary_.unit();
        if (in_cube && boundary_.nearest(tree_.facets(leaf.number), at).distance > undecided) {
            return {tree_.is_inside(at) ? PointState::inside : PointState::outside, {}};
        }
        grid::Located<D> found{locate(cage_, p, tolerance_), {}};
        Vec<double, D> position;
        if (found.state == PointState::on_boundary) found.value = nearest_boundary_value(cage_, p, position);
        return found;
    }

    /// Width of the linear layer at the boundary, relative to the leaf. In 2D, where interpolation beyond the
    /// layer is of fourth order, the layer's error is below every accuracy. In 3D, linear interpolation is
    /// more accurate within the layer.
    static constexpr double layer_share = D == 2 ? 0.01 : 0.3;

    const C& cage_;
    double tolerance_, locality_;
    bool subtracts_kinks_;
    grid::TreeBoundary<D> boundary_;
    grid::CutTree<D> tree_;
    grid::TreeNodes<D> nodes_;
    grid::FinestCells<D> finest_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

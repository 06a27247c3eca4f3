// Harmonic functions of a cage on an adaptive grid: bound by accuracy, not by resolution. Cells are
// as fine as the cage is thin, its facets small and its edges sharp (grid/tree/).
#pragma once

#include <cageform/coordinates/cage_solver.hpp>
#include <cageform/coordinates/detail/cut_samples.hpp>
#include <cageform/coordinates/detail/grid_errors.hpp>
#include <cageform/coordinates/harmonic_options.hpp>
#include <cageform/grid/tree/refinement.hpp>
#include <cageform/grid/tree/sizing.hpp>
#include <cageform/grid/tree/tree_multigrid.hpp>

#include <bit>
#include <memory>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

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
            return grid::SizingOptions{.across = std::max(3.0, 1.5 * finer),
                                       .per_facet = std::max(1.0, 0.75 * finer),
                                       .singular_levels = 0.8 * std::log2(1 / accuracy) - 1.4,
                                       .layers = unsigned(std::lround(0.5 + 1.3 * finer)),
                                       // Half as large for a tenth, as sizes are powers of two.
                                       .largest = 0.0626 * std::pow(100 * accuracy, 0.301)};
        } else {
            const double finer = std::sqrt(2e-3 / accuracy), levels = std::max(0.0, 1 + std::log2(finer));
            return grid::RefinementOptions{.across = 4.8 * finer,
                                           .per_facet = 0.89 * finer,
                                           .edge_levels = levels,
                                           .reflex_levels = levels,
                                           .at_vertex = 7 * accuracy, // errors there are of first order
                                           .per_radius = 10 * finer,
                                           .largest = std::min(0.08, 0.0253 / finer)};
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
        leaves = whole ? double(tree_.cells().leaves()) : std::max(leaves, most + 1);
        if (whole) nodes_ = grid::nodes_of(tree_);
        return whole;
    }

    /// Puts its finest cells into the report.
    void report_finest(SolverReport& report) const noexcept {
        std::int32_t smallest = tree_.cells().size();
        tree_.cells().for_each_leaf([&](const Cell& leaf) {
            if (tree_.state(leaf.number) != grid::CellState::out) smallest = std::min(smallest, leaf.size);
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
    double spacing(const Vec<T, D>& p) const noexcept { return boundary_.unit() * leaf_at(placed(p)).size; }
    PointState state_of(const Vec<T, D>& p) const noexcept {
        const auto at = placed(p);
        return located(p, at, leaf_at(at)).state;
    }
    /// From a place inside along an axis, up or down, to the boundary, in sizes of the leaf there; at
    /// most `limit`.
    double free_distance(const Vec<T, D>& p, std::size_t axis, bool up, double limit) const noexcept {
        const auto at = placed(p);
        const double size = leaf_at(at).size;
        return std::fmin(limit, boundary_.free_distance({at, axis, up, limit * size}) / size);
    }

    /// What the value at point `i` of a batch is a mean of, and where it lies; nothing for points
    /// outside and beyond the batch.
    grid::CutStencil<D> stencil(const Batch<T>& batch, std::size_t i) const {
        grid::CutStencil<D> stencil;
        if (i >= batch.points.points || batch.states[i] == PointState::not_finite) return stencil;
        const auto p = block_point<D>(batch.points, i);
        const auto at = placed(p);
        const auto leaf = leaf_at(at);
        const auto facets = tree_.facets(leaf.number);
        const auto [state, value] = located(p, at, leaf);
        batch.states[i] = state;
        if (state == PointState::on_boundary) {
            stencil.add(value, 1.0);
        } else if (state == PointState::inside) {
            const auto nearest = boundary_.nearest(facets, at);
            if (nearest.distance <= grid::on_facet_distance) {
                stencil.add(nearest.value, 1.0);
                return stencil;
            }
            if constexpr (D == 2) {
                if (add_harmonic_mean(tree_, nodes_, at, leaf, HarmonicMean::most_degree, stencil))
                    return stencil;
            }
            grid::StencilSink<D> sink{nodes_, stencil};
            LeafGather<D, grid::StencilSink<D>>(boundary_, nodes_, sink).gather(leaf, facets, at);
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
    Cell leaf_at(const Vec<double, D>& p) const noexcept {
        typename grid::CellTree<D>::Index doubled{};
        const double end = 2.0 * tree_.cells().size();
        for (std::size_t k = 0; k < D; ++k)
            doubled[k] = std::int32_t(std::floor(std::clamp(2 * p[k], 0.0, end)));
        return tree_.cells().leaf_at(doubled);
    }
    grid::Located<D> located(const Vec<T, D>& p, const Vec<double, D>& at, const Cell& leaf) const noexcept {
        const double size = tree_.cells().size();
        bool in_cube = true;
        for (std::size_t k = 0; k < D; ++k) in_cube = in_cube && at[k] > 0 && at[k] < size;
        const auto state = tree_.state(leaf.number);
        if (in_cube && state != grid::CellState::cut)
            return {state == grid::CellState::in ? PointState::inside : PointState::outside, {}};
        // Where the tolerance or what the tree has rounded might decide.
        const double near =
            1e-4 + std::ldexp(2.0, -boundary_.fraction()) + 2 * double(tolerance_) / boundary_.unit();
        if (in_cube && boundary_.nearest(tree_.facets(leaf.number), at).distance > near) {
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

    const C& cage_;
    T tolerance_;
    grid::TreeBoundary<D> boundary_;
    grid::CutTree<D> tree_;
    grid::TreeNodes<D> nodes_;
    grid::FinestCells<D> finest_;
};

/// Handles in an order in which neighbours come together: functions of a group are then large in the
/// same places.
class HandleOrder {
public:
    HandleOrder() = default;
    /// Halved across the longest side of their bounds, down to groups of `width`.
    template <Scalar T, std::size_t D>
    HandleOrder(std::span<const Vec<T, D>> places, std::size_t width)
        : handle_(places.size())
        , rank_(places.size()) {
        for (std::uint32_t n = 0; n < handle_.size(); ++n) handle_[n] = n;
        divide(places, width, 0, handle_.size());
        for (std::uint32_t n = 0; n < handle_.size(); ++n) rank_[handle_[n]] = n;
    }
    std::uint32_t handle(std::size_t rank) const noexcept { return handle_[rank]; }
    std::uint32_t rank(std::size_t handle) const noexcept { return rank_[handle]; }

private:
    template <Scalar T, std::size_t D>
    void divide(std::span<const Vec<T, D>> places, std::size_t width, std::size_t begin, std::size_t end) {
        if (end - begin <= width) return;
        std::size_t axis = 0;
        double longest = -1;
        for (std::size_t k = 0; k < D; ++k) {
            T low = places[handle_[begin]][k], high = low;
            for (std::size_t n = begin; n < end; ++n) {
                low = std::min(low, places[handle_[n]][k]);
                high = std::max(high, places[handle_[n]][k]);
            }
            if (double(high) - double(low) <= longest) continue;
            longest = double(high) - double(low);
            axis = k;
        }
        const std::size_t groups = (end - begin + width - 1) / width, middle = begin + groups / 2 * width;
        std::nth_element(handle_.begin() + begin, handle_.begin() + middle, handle_.begin() + end,
                         [&](std::uint32_t a, std::uint32_t b) {
                             return std::pair(places[a][axis], a) < std::pair(places[b][axis], b);
                         });
        divide(places, width, begin, middle);
        divide(places, width, middle, end);
    }

    Buffer<std::uint32_t> handle_, rank_;
};

/// The boundary data of a tree's facets, triangles whatever the cage's faces are, by the ranks of the
/// handles.
template <class C>
class RankedData {
public:
    using Value = BoundaryValue<C::dimension>;

    RankedData(const C& cage, const BoundaryData<C>& data, const HandleOrder& order)
        : cage_(cage)
        , data_(data)
        , order_(order) {}

    template <class F>
    void for_each_weight(const Value& value, F&& f) const {
        const auto ranked = [&](std::uint32_t handle, double weight) { f(order_.rank(handle), weight); };
        if constexpr (requires { cage_.divisions(); }) { // a box: bilinear on its rectangles
            Vec<double, 3> place{};
            HatData<3>::for_each_weight(value, [&](std::uint32_t handle, double weight) {
                place = place + weight * vec_cast<double>(cage_.vertices()[handle]);
            });
            Vec<typename C::scalar, 3> on_box;
            HatData<3>::for_each_weight(
                nearest_boundary_value(cage_, vec_cast<typename C::scalar>(place), on_box), ranked);
        } else {
            data_.for_each_weight(value, ranked);
        }
    }

private:
    const C& cage_;
    const BoundaryData<C>& data_;
    const HandleOrder& order_;
};

} // namespace detail

/// A CageSolver for every kind of cage; groups are of sixteen functions.
/// HarmonicOptions::accuracy says how fine the grid is, and how far it is solved. Bones thinner than half
/// the finest cell, some millionths of the cage, are refused (grid_too_coarse).
template <class C>
class TreeSolver {
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;
    using Cage = detail::TreeCage<C>;
    using Multigrid = grid::TreeMultigrid<D>;
    static constexpr std::size_t width = Multigrid::width;
    /// How far functions are solved. In the plane farther: it takes little, and about corners, where
    /// cells are tiny, gradients are differences of values near each other.
    static constexpr double of_accuracy = D == 2 ? 0.01 : 0.1;

public:
    using Problem = CageProblem<C, HarmonicOptions>;
    using Block = typename Multigrid::Block;

    static Status make(const Problem& problem, SolverReport& report, std::optional<TreeSolver>& made) {
        constexpr double bytes_of_leaf = 340; // tree, hierarchy and a block, as measured
        const double accuracy = problem.options.accuracy;
        if (!(accuracy >= Cage::least_accuracy && accuracy <= Cage::most_accuracy))
            return Status::accuracy_not_supported;
        if (problem.data.status() != Status::ok) return problem.data.status();
        if (Cage::depth_of(problem.cage, problem.tolerance) < Cage::least_depth)
            return Status::resolution_not_supported;
        const typename Cage::Plan plan(problem.cage, problem.tolerance);
        double leaves = plan.leaves(accuracy);
        const double most =
            std::min(double(problem.options.memory_limit) / bytes_of_leaf, double(std::uint32_t(-1) / 8));
        std::unique_ptr<Cage> cage;
        constexpr double few = 2e5; // soon made, and fewer than the plan says
        if (leaves < std::max(1.5 * most, few))
            cage = std::make_unique<Cage>(problem.cage, problem.tolerance, plan.scale(accuracy));
        if (const auto handle = cage ? cage->too_thin() : std::nullopt) {
            report.unseen_handle = *handle;
            return Status::grid_too_coarse;
        }
        if (!cage || !cage->refine(accuracy, most, leaves)) {
            report.bytes = std::size_t(std::min(bytes_of_leaf * leaves, 9e18));
            const double more = std::max(1.0, leaves / plan.leaves(accuracy)); // than planned
            report.sufficient_accuracy = plan.sufficient_accuracy(accuracy, 0.5 * most / more);
            return Status::out_of_memory;
        }
        made.emplace(std::move(cage), problem);
        const auto [hierarchy, block] = made->memory();
        if (hierarchy + block > problem.options.memory_limit) {
            report.bytes = hierarchy + block;
            report.sufficient_accuracy = plan.sufficient_accuracy(accuracy, 0.5 * most);
            return Status::out_of_memory;
        }
        report.cells = made->multigrid_.unknowns();
        made->cage_->report_finest(report);
        return Status::ok;
    }
    TreeSolver(std::unique_ptr<Cage> cage, const Problem& problem)
        : cage_(std::move(cage))
        , data_(&problem.data)
        , tolerance_(of_accuracy * problem.options.accuracy)
        , max_cycles_(problem.options.multigrid.max_cycles)
        , order_(cage_->cage().vertices(), width)
        , multigrid_(cage_->tree(), cage_->nodes(),
                     grid::links_of(cage_->tree(), cage_->nodes(), data_by_rank()))
        , errors_(cage_->tree(), cage_->nodes(), data_by_rank()) {}

    SolverMemory memory() const noexcept {
        return {cage_->bytes() + multigrid_.bytes(), multigrid_.block_bytes(is_refined())};
    }
    template <class F>
    void for_each_cell(F&& f) const {
        cage_->for_each_cell(f);
    }

    // ---- groups
    // ------------------------------------------------------------------------------------

    std::size_t groups() const noexcept { return (cage_->cage().size() + width - 1) / width; }
    Block make_block() const { return multigrid_.make_block(); }

    Status solve(std::size_t group, Block& block, grid::GroupWork& work) const {
        SolverReport& report = work.report;
        const std::size_t count = handles_of(group).second;
        report.solves = count;
        multigrid_.start(block, group * width, cutoff());
        double before = 0;
        for (bool refined = !is_refined();;) { // changes in float can be small before errors are
            if (!work.keep_going(double(report.cycles) / double(report.cycles + 4))) return Status::cancelled;
            const double change = multigrid_.cycle(block, count);
            ++report.cycles;
            // A cycle's change is the error before it, but for what is left. The first ones gain more
            // than those that follow.
            const double gained = before > 0 ? change / before : 0.5;
            if (before > tolerance_) report.convergence_factor = std::max(report.convergence_factor, gained);
            report.error_estimate = change * std::clamp(gained, 0.2, 0.9);
            before = change;
            if (refined && report.error_estimate <= tolerance_) break;
            if (report.cycles == max_cycles_) {
                report.unconverged = count;
                return Status::not_converged;
            }
            if (is_refined() && report.cycles > 1) {
                multigrid_.refine(block);
                refined = true;
            }
        }
        report.error_estimate += 0.25 * cutoff();
        report.grid_errors = errors_.of(block, group * width, count);
        return Status::ok;
    }

    /// Of the nodes where any is larger than a hundredth of the accuracy. In float, as the cycles leave
    /// them: what is rounded off is far below any accuracy asked for.
    class Functions {
    public:
        Functions() = default;
        Functions(const Block& block, std::uint32_t nodes, double least)
            : words_((nodes + 63) / 64, Word{}) {
            const auto is_kept = [&](std::uint32_t node) {
                bool any = false;
                for (const double x : block.value(node)) any = any || std::fabs(x) > least;
                return any;
            };
            for (const std::uint32_t node : block.valued()) {
                if (is_kept(node)) words_[node / 64].nodes |= std::uint64_t{1} << (node % 64);
            }
            std::uint32_t count = 0;
            for (auto& word : words_) {
                word.before = count;
                count += std::uint32_t(std::popcount(word.nodes));
            }
            rows_.resize(count);
            for (const std::uint32_t node : block.valued()) {
                if (!has(node)) continue;
                const auto values = block.value(node);
                for (std::size_t k = 0; k < width; ++k) rows_[row(node)][k] = float(values[k]);
            }
        }

        /// Elsewhere they are zero.
        bool has(std::uint32_t node) const noexcept {
            return ((words_[node / 64].nodes >> (node % 64)) & 1u) != 0;
        }
        typename Multigrid::Values value(std::uint32_t node) const noexcept {
            typename Multigrid::Values values{};
            if (!has(node)) return values;
            for (std::size_t k = 0; k < width; ++k) values[k] = double(rows_[row(node)][k]);
            return values;
        }

    private:
        struct Word { ///< of 64 nodes
            std::uint64_t nodes = 0;
            std::uint32_t before = 0; ///< rows
        };
        std::size_t row(std::uint32_t node) const noexcept {
            const Word& word = words_[node / 64];
            return word.before +
                   std::size_t(std::popcount(word.nodes & ((std::uint64_t{1} << (node % 64)) - 1)));
        }

        Buffer<Word> words_;
        Buffer<typename Multigrid::Row> rows_;
    };
    Functions keep(const Block& block) const {
        return Functions(block, multigrid_.unknowns(), 0.01 * tolerance_ / of_accuracy);
    }

    // ---- samples
    // -----------------------------------------------------------------------------------

    using Samples = detail::CutSamples<D>;

    Samples samples(const detail::Batch<T>& batch, std::size_t first, std::size_t last) const {
        Samples samples(first);
        const auto data = data_by_rank();
        for (std::size_t i = first; i < last; ++i) samples.add(cage_->stencil(batch, i), data);
        return samples;
    }
    template <class Solved> // a block or what is kept
    void sample(Samples& samples, std::size_t group, const Solved& solved, BlockView<T> rows) const noexcept {
        const auto [first, count] = handles_of(group);
        samples.sample(solved, first, count, rows, [this](std::size_t rank) { return order_.handle(rank); });
    }
    void finish(const Samples& /*samples*/, BlockView<T> /*rows*/) const noexcept {}

    double spacing(const Vec<T, D>& p) const noexcept { return cage_->spacing(p); }
    PointState state_of(const Vec<T, D>& p) const noexcept { return cage_->state_of(p); }
    double free_distance(const Vec<T, D>& p, std::size_t axis, bool up, double limit) const noexcept {
        return cage_->free_distance(p, axis, up, limit);
    }

private:
    detail::RankedData<C> data_by_rank() const noexcept { return {cage_->cage(), *data_, order_}; }
    /// Where functions are below it the next coarser level is exact enough.
    double cutoff() const noexcept { return is_refined() ? 0 : 2.5 * tolerance_; }
    /// Float alone stalls at some 3e-7.
    bool is_refined() const noexcept { return tolerance_ < 2e-6; }
    /// The rank of a group's first handle, and how many it has.
    std::pair<std::size_t, std::size_t> handles_of(std::size_t group) const noexcept {
        return {group * width, std::min(width, cage_->cage().size() - group * width)};
    }

    std::unique_ptr<Cage> cage_;
    const detail::BoundaryData<C>* data_;
    double tolerance_;
    std::size_t max_cycles_;
    detail::HandleOrder order_;
    Multigrid multigrid_;
    detail::GridErrors<D> errors_;
};

} // namespace cageform::inline CAGEFORM_ABI

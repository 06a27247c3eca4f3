// Solves the harmonic functions of a cage by multigrid on an adaptive grid, to a given accuracy. Cells are
// small where the cage is thin, its facets are small or its edges are sharp (grid/tree/).
#pragma once

#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/harmonic/cage_solver.hpp>
#include <cageform/coordinates/harmonic/cut_samples.hpp>
#include <cageform/coordinates/harmonic/gradient_samples.hpp>
#include <cageform/coordinates/harmonic/grid_errors.hpp>
#include <cageform/coordinates/harmonic/leaf_samples.hpp>
#include <cageform/coordinates/harmonic/near_rows.hpp>
#include <cageform/coordinates/harmonic/options.hpp>
#include <cageform/coordinates/harmonic/solution_blob.hpp>
#include <cageform/coordinates/harmonic/tree_cage.hpp>
#include <cageform/grid/tree/multigrid.hpp>

#include <memory>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// An order of the handles with neighbours close together. The functions of a group of sixteen are then large
/// in the same region, and the solver skips the rest.
class HandleOrder {
public:
    HandleOrder() = default;
    /// Bisects the handles across the longest side of their bounds, down to groups of `width`.
    template <std::size_t D>
    HandleOrder(std::span<const Vec<double, D>> points, std::size_t width)
        : handle_(points.size())
        , position_(points.size()) {
        for (std::uint32_t n = 0; n < handle_.size(); ++n) handle_[n] = n;
        divide(points, width, 0, handle_.size());
        for (std::uint32_t n = 0; n < handle_.size(); ++n) position_[handle_[n]] = n;
    }
    std::uint32_t handle(std::size_t position) const noexcept { return handle_[position]; }
    std::uint32_t position(std::size_t handle) const noexcept { return position_[handle]; }
    std::size_t size() const noexcept { return handle_.size(); }

private:
    template <std::size_t D>
    void divide(std::span<const Vec<double, D>> points, std::size_t width, std::size_t begin,
                std::size_t end) {
        if (end - begin <= width) return;
        std::size_t axis = 0;
        double longest = -1;
        for (std::size_t k = 0; k < D; ++k) {
            double low = points[handle_[begin]][k], high = low;
            for (std::size_t n = begin; n < end; ++n) {
                low = (std::min)(low, points[handle_[n]][k]);
                high = (std::max)(high, points[handle_[n]][k]);
            }
            if (high - low <= longest) continue;
            longest = high - low;
            axis = k;
        }
        const std::size_t groups = (end - begin + width - 1) / width, middle = begin + groups / 2 * width;
        std::nth_element(handle_.begin() + begin, handle_.begin() + middle, handle_.begin() + end,
                         [&](std::uint32_t a, std::uint32_t b) {
                             return std::pair(points[a][axis], a) < std::pair(points[b][axis], b);
                         });
        divide(points, width, begin, middle);
        divide(points, width, middle, end);
    }

    Buffer<std::uint32_t> handle_, position_;
};

/// The boundary values, with handles numbered by HandleOrder::position.
template <std::size_t D>
class OrderedData {
public:
    using Value = BoundaryValue<D>;

    OrderedData(const BoundaryData<D>& data, const HandleOrder& order)
        : data_(data)
        , order_(order) {}

    template <class F>
    void for_each_weight(const Value& value, F&& f) const {
        data_.for_each_weight(
            value, [&](std::uint32_t handle, double weight) { f(order_.position(handle), weight); });
    }

private:
    const BoundaryData<D>& data_;
    const HandleOrder& order_;
};

} // namespace detail

/// A CageSolver for all cages, with sixteen functions per group. HarmonicOptions::accuracy determines the
/// grid and when cycles stop. Bones thinner than half the finest cell, some millionths of the cage, are
/// refused (grid_too_coarse).
template <std::size_t D>
class TreeSolver {
    using Cage = detail::TreeCage<D>;
    using Multigrid = grid::TreeMultigrid<D>;
    static constexpr std::size_t width = Multigrid::width;
    /// Cycles stop at this fraction of the accuracy. The fraction is smaller in 2D, because cycles are cheap
    /// there. Also, 2D gradients in tiny cells around corners are differences of nearly equal values.
    static constexpr double of_accuracy = D == 2 ? 0.01 : 0.1;

public:
    static constexpr std::size_t dimension = D;
    using Block = typename Multigrid::Block;

    static Status make(const SolverInput<D>& input, SolverReport& report, std::optional<TreeSolver>& made,
                       const Running& running) {
        const double accuracy = input.options.accuracy;
        if (!(accuracy >= Cage::least_accuracy && accuracy <= Cage::most_accuracy))
            return Status::accuracy_not_supported;
        if (Cage::depth_of(input.cage, input.tolerance) < Cage::least_depth)
            return Status::resolution_not_supported;
        const bool subtracts_kinks = D == 3 && is_blended(input);
        const double bytes_of_leaf = subtracts_kinks ? 500 : 340; // tree, hierarchy and a block, measured
        const typename Cage::Plan plan(input, subtracts_kinks, running.subtask(0, 0.05));
        double leaves = plan.leaves(accuracy);
        const double most =
            (std::min)(double(input.options.memory_limit) / bytes_of_leaf, 0.125 * double(std::uint32_t(-1)));
        std::unique_ptr<Cage> cage;
        constexpr double few = 2e5; // quick to make; the plan overestimates such small trees
        if (leaves < (std::max)(1.5 * most, few))
            cage = std::make_unique<Cage>(input, subtracts_kinks, plan.scale(accuracy));
        if (const auto handle = cage ? cage->too_thin() : std::nullopt) {
            report.unseen_handle = *handle;
            return Status::grid_too_coarse;
        }
        if (!cage || !cage->refine(accuracy, most, leaves, running.subtask(0.05, 0.3))) {
            report.cells = std::size_t((std::min)(leaves, 9e18));
            report.bytes = std::size_t((std::min)(bytes_of_leaf * leaves, 9e18));
            const double more = (std::max)(1.0, leaves / plan.leaves(accuracy)); // than planned
            report.sufficient_accuracy = plan.sufficient_accuracy(accuracy, 0.5 * most / more);
            return Status::out_of_memory;
        }
        made.emplace(std::move(cage), input, running.subtask(0.3, 1));
        const auto [hierarchy, block] = made->memory();
        if (hierarchy + block > input.options.memory_limit) {
            report.bytes = hierarchy + block;
            report.sufficient_accuracy = plan.sufficient_accuracy(accuracy, 0.5 * most);
            return Status::out_of_memory;
        }
        report.cells = made->multigrid_.unknowns();
        made->cage_->report_finest(report);
        return Status::ok;
    }
    TreeSolver(std::unique_ptr<Cage> cage, const SolverInput<D>& input, const Running& running)
        : cage_(std::move(cage))
        , data_(&input.data)
        , cage_hash_(detail::hash_of_cage(input))
        , tolerance_(of_accuracy * input.options.accuracy)
        , max_cycles_(input.options.multigrid.max_cycles)
        , order_(cage_->cage().vertices().first(input.handles), width)
        , field_(field_of(*cage_, input))
        , multigrid_(cage_->tree(), cage_->nodes(), links(running.subtask(0, 0.7)), running.subtask(0.7, 0.9))
        , errors_(grid_errors(running.subtask(0.9, 1))) {
        errors_.scale_nodes(multigrid_.decay());
    }

    SolverMemory memory() const noexcept {
        const std::size_t bytes =
            cage_->bytes() + multigrid_.bytes() + errors_.bytes() + (field_ ? field_->bytes() : 0);
        return {bytes, multigrid_.block_bytes(is_refined())};
    }
    template <class F>
    void for_each_cell(F&& f) const {
        cage_->for_each_cell(f);
    }

    // ---- groups ------------------------------------------------------------------------------------

    std::size_t groups() const noexcept { return (order_.size() + width - 1) / width; }
    Block make_block() const { return multigrid_.make_block(); }

    Status solve(std::size_t group, Block& block, grid::GroupWork& work) const {
        SolverReport& report = work.report;
        const std::size_t count = handles_of(group).second;
        report.solves = count;
        const typename Multigrid::KeepGoing keep_going = [&work, &report] {
            return work.keep_going(double(report.multigrid.cycles) / double(report.multigrid.cycles + 4));
        };
        multigrid_.start(block, group * width, cutoff(), keep_going);
        if (!keep_going()) return Status::cancelled;
        double before = 0;
        for (bool refined = !is_refined();;) { // float changes can be small while errors are not
            const double change = multigrid_.cycle(block, count, keep_going);
            ++report.multigrid.cycles;
            if (!keep_going()) return Status::cancelled;
            // The change of a cycle is the difference of the errors before and after it. The first cycles
            // gain more than later ones.
            const double gained = before > 0 ? change / before : 0.5;
            if (before > tolerance_)
                report.multigrid.convergence_factor = (std::max)(report.multigrid.convergence_factor, gained);
            report.multigrid.error_estimate = change * std::clamp(gained, 0.2, 0.9);
            before = change;
            if (refined && report.multigrid.error_estimate <= tolerance_) break;
            if (report.multigrid.cycles == max_cycles_) {
                report.unconverged = count;
                return Status::not_converged;
            }
            if (is_refined() && report.multigrid.cycles > 1) {
                multigrid_.refine(block, keep_going);
                refined = true;
            }
        }
        report.multigrid.error_estimate += 0.25 * cutoff();
        report.tree.grid_errors = errors_.of(block, group * width, count);
        return Status::ok;
    }

    /// The values of a group at nodes where a function exceeds accuracy / 500. The rounding to float is far
    /// below the least accuracy.
    using Functions = detail::KeptFunctions;
    Functions keep(const Block& block) const {
        return Functions(block, multigrid_.unknowns(), 0.002 * tolerance_ / of_accuracy);
    }

    /// Returns the header that packed functions for this cage, grid and accuracy have.
    detail::SolutionHeader solution_header() const {
        detail::SolutionHeader header;
        header.dimension = D;
        header.cage_hash = cage_hash_;
        header.accuracy = tolerance_ / of_accuracy;
        header.group_count = groups();
        header.nodes = multigrid_.unknowns();
        header.grid_hash = hash_memory(multigrid_.data());
        const double screening = cage_->tree().screening(); // files of harmonic functions have no such number
        if (screening > 0) header.grid_hash = hash_memory(std::span(&screening, 1), header.grid_hash);
        cage_->for_each_cell([&](const auto& cell) {
            const std::array<double, D + 2> numbers = [&] {
                std::array<double, D + 2> all{};
                for (std::size_t k = 0; k < D; ++k) all[k] = cell.low[k];
                all[D] = double(cell.size);
                all[D + 1] = cell.is_cut ? 1 : 0;
                return all;
            }();
            header.grid_hash = hash_memory(std::span<const double>(numbers), header.grid_hash);
        });
        return header;
    }

    // ---- samples -----------------------------------------------------------------------------------

    using Samples = detail::CutSamples<D>;
    using GradientSamples = detail::GradientSamples<D>;

    /// Returns the indices of the points along the Morton curve.
    template <Scalar T>
    std::vector<std::size_t> order(const Batch<T>& batch) const {
        using Nodes = grid::TreeNodes<D>;
        const std::size_t count = batch.points.blocks() * lane_count<T>;
        std::vector<std::pair<typename Nodes::Key, std::size_t>> keys(count);
        const double most = cage_->tree().cells().size();
        for (std::size_t i = 0; i < count; ++i) {
            const auto p = in_units(batch, i);
            typename Nodes::Index index{};
            for (std::size_t k = 0; k < D; ++k) index[k] = p[k] > 0 ? std::int32_t(std::fmin(p[k], most)) : 0;
            keys[i] = {Nodes::key(index), i};
        }
        std::sort(keys.begin(), keys.end());
        std::vector<std::size_t> order;
        order.reserve(count);
        for (const auto& [key, i] : keys) order.push_back(i);
        return order;
    }
    template <Scalar T>
    Samples samples(const Batch<T>& batch, std::span<const std::size_t> points) const {
        Samples samples;
        if (!field_) {
            for (const std::size_t i : points) samples.add(i, cage_->stencil(batch, i), ordered_data());
            samples.scale_nodes(multigrid_.decay());
            return samples;
        }
        std::vector<Vec<double, D>> places;
        std::vector<std::size_t> numbers;
        for (const std::size_t i : points) {
            const auto stencil = cage_->stencil_outside(batch, i);
            if (i < batch.points.points && batch.states[i] == PointState::inside) {
                places.push_back(in_units(batch, i));
                numbers.push_back(i);
            } else {
                samples.add(i, stencil, ordered_data());
            }
        }
        auto next = numbers.begin();
        blends().stencils(places, [&](const auto& nodes, const auto& vertices) {
            samples.add(*next, nodes, vertices, position_of());
            if (nodes.empty() && vertices.empty()) batch.states[*next] = PointState::unreached;
            ++next;
        });
        samples.scale_nodes(multigrid_.decay());
        return samples;
    }
    /// Whether the solver makes stencils of derivatives: if samples are C².
    bool has_gradient_samples() const noexcept { return field_.has_value(); }
    /// Makes the stencils of derivatives of inside and boundary points. Other points get none.
    template <Scalar T>
    GradientSamples gradient_samples(const Batch<T>& batch, std::span<const std::size_t> points) const {
        GradientSamples samples(order_.size());
        auto blends = this->blends();
        std::vector<Vec<double, D>> places;
        std::vector<std::size_t> numbers;
        for (const std::size_t i : points) {
            if (i >= batch.points.points) continue;
            (void)cage_->stencil_outside(batch, i);
            PointState& state = batch.states[i];
            if (state != PointState::inside && state != PointState::on_boundary) continue;
            const auto place = blends.differentiable_place(in_units(batch, i));
            if (place) {
                places.push_back(*place);
                numbers.push_back(i);
            } else {
                state = PointState::unreached;
            }
        }
        std::size_t n = 0;
        blends.slopes(places, [&](const auto& nodes, const auto& vertices) {
            const std::size_t i = numbers[n++ / (D + 1)];
            if (nodes.empty() && vertices.empty()) batch.states[i] = PointState::unreached;
            samples.add(i, nodes, vertices, position_of());
        });
        samples.scale_nodes(multigrid_.decay());
        for (Vec<double, D>& place : places) place = cage_->tree().boundary().in_cage(place);
        samples.reserve(std::move(places), batch.states);
        return samples;
    }
    template <class AnySamples, class Solved, Scalar T> // Solved: a Block or kept Functions
    void sample(AnySamples& samples, std::size_t group, const Solved& solved,
                BlockView<T> rows) const noexcept {
        const auto [first, count] = handles_of(group);
        samples.sample(solved, first, count, rows,
                       [this](std::size_t position) { return order_.handle(position); });
    }
    template <Scalar T>
    void finish(const Samples& samples, BlockView<T> rows) const noexcept {
        if (field_) samples.normalise(rows, is_local() ? 0 : 0.5);
    }
    template <Scalar T>
    void finish(const GradientSamples& samples, BlockView<T> rows) const {
        if (is_local()) {
            samples.project(rows, handles());
        } else {
            samples.finish(rows);
        }
    }

    double spacing(const Vec<double, D>& p) const noexcept { return cage_->spacing(p); }
    PointState state_of(const Vec<double, D>& p) const noexcept { return cage_->state_of(p); }
    double free_distance(const Vec<double, D>& p, std::size_t axis, bool up, double limit) const noexcept {
        return cage_->free_distance(p, axis, up, limit);
    }

private:
    using Field = std::conditional_t<D == 3, detail::NearField, detail::PlaneField>;
    using Blends =
        std::conditional_t<D == 3, detail::LeafSamples<detail::LeafModel, detail::LeafFit>,
                           detail::LeafSamples<detail::PlaneModel, detail::ModelFit<detail::PlaneModel>>>;

    /// Whether samples blend models of leaves: in 2D if the cage has no bones, in 3D if the boundary values
    /// are linear on faces and the cage has no interior cells.
    static bool is_blended(const SolverInput<D>& input) noexcept {
        if (D == 2) return input.cage.cells().bones.empty();
        return input.data.is_linear() &&
               input.cage.vertices().size() == input.cage.boundary().vertices().size() &&
               input.cage.cells().empty();
    }
    static std::optional<Field> field_of(const Cage& cage, const SolverInput<D>& input) {
        std::optional<Field> made;
        if (!is_blended(input)) return made;
        if constexpr (D == 3) {
            made.emplace(cage.tree().boundary(), input.cage.boundary());
        } else {
            made.emplace(cage.tree().boundary());
        }
        return made;
    }
    grid::TreeLinks links(const Running& running) const {
        if constexpr (D == 3) {
            if (field_)
                return grid::links_of(
                    cage_->tree(), cage_->nodes(), ordered_data(),
                    detail::NearCorrections(cage_->nodes(), ordered_data(), {*field_, least_layer()}),
                    running);
        }
        return grid::links_of(cage_->tree(), cage_->nodes(), ordered_data(), detail::NoCorrections(),
                              running);
    }
    /// Returns the share of a row below which double layers are dropped: a hundredth of the accuracy.
    double least_layer() const noexcept { return 0.01 * tolerance_ / of_accuracy; }
    detail::GridErrors<D> grid_errors(const Running& running) const {
        if constexpr (D == 3) {
            if (field_) {
                using Table = detail::StencilTable<D>;
                return {cage_->tree(), running,
                        [this](std::span<const Vec<double, D>> places, Table& fine, Table& coarse) {
                            for (const unsigned degree : {3u, 1u}) {
                                Blends(cage_->tree(), cage_->nodes(), *field_, degree)
                                    .stencils(places, [&](const auto& nodes, const auto& vertices) {
                                        (degree == 3 ? fine : coarse).add(nodes, vertices, position_of());
                                    });
                            }
                        }};
            }
        }
        return {cage_->tree(), cage_->nodes(), ordered_data(), running};
    }
    Blends blends() const {
        // NOLINTNEXTLINE(bugprone-unchecked-optional-access): called only if samples are blended
        return {cage_->tree(), cage_->nodes(), *field_};
    }
    template <Scalar T>
    Vec<double, D> in_units(const Batch<T>& batch, std::size_t i) const noexcept {
        return cage_->tree().boundary().in_units(vec_cast<double>(block_point<D>(batch.points, i)));
    }

    /// Returns a function that maps a handle to its position in the order.
    auto position_of() const noexcept {
        return [this](std::uint32_t handle) { return order_.position(handle); };
    }
    detail::OrderedData<D> ordered_data() const noexcept { return {*data_, order_}; }
    /// Whether the functions are those of local harmonic coordinates, which are projected.
    bool is_local() const noexcept { return !multigrid_.decay().empty(); }
    std::span<const Vec<double, D>> handles() const noexcept {
        return cage_->cage().vertices().first(order_.size());
    }
    /// Returns the value below which the next coarser level represents a function well enough.
    double cutoff() const noexcept { return is_refined() ? 0 : 2.5 * tolerance_; }
    /// Returns whether values need iterative refinement in double. In float, convergence stalls at about
    /// 3e-7.
    bool is_refined() const noexcept { return tolerance_ < 2e-6; }
    /// Returns the position of a group's first handle, and the number of its handles.
    std::pair<std::size_t, std::size_t> handles_of(std::size_t group) const noexcept {
        return {group * width, (std::min)(width, order_.size() - group * width)};
    }

    std::unique_ptr<Cage> cage_;
    const detail::BoundaryData<D>* data_;
    std::uint64_t cage_hash_;
    double tolerance_;
    std::size_t max_cycles_;
    detail::HandleOrder order_;
    std::optional<Field> field_;
    Multigrid multigrid_;
    detail::GridErrors<D> errors_;
};

} // namespace cageform::inline CAGEFORM_ABI

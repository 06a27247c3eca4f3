// Computes harmonic coordinates by the averaging sweeps of the original papers, on grid cells. This
// is the baseline for measuring other solvers.
#pragma once

#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/harmonic/solution.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>
#include <cageform/papers/averaging_pyramid.hpp>
#include <cageform/papers/detail/rasterise.hpp>
#include <cageform/papers/detail/sample.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A CageSolver for a Polygon or a TriangleMesh. A group is HarmonicOptions::handles_at_once
/// functions, solved one after another.
///
///   range     [0, 1] to rounding (a mean of values in [0, 1]), before `bind` restores linear
///             precision; sum to 1 as far as the solver converged: its tolerance is on the change
///             per sweep, not on the error
///   accuracy  boundary cells form a staircase, which leaves a residual Σwc − p of about half a
///             cell; `bind` restores linear precision, the report says by how much. The papers
///             sweep to AveragingOptions::tolerance 1e-5 and look up Interpolation::nearest_cell,
///             which is off by at most a cell's diagonal
///   cost      per thread handles_at_once scalars a cell, and another scalar and a tag for each
///             cell of the pyramid; after `solve` #V scalars a cell. With one handle at once in
///             float that is 12 bytes a cell in 3D, as published
///   fails     as HarmonicCoordinates, except for grid_too_coarse. A point with no valued cell
///             around it is unreached; there are no gradients (solver_not_supported)
template <class C>
class PyramidSolver {
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;

public:
    using Problem = CageProblem<C>;

    static Status make(const Problem& problem, SolverReport& report, std::optional<PyramidSolver>& made,
                       const Running& /*running*/) {
        const std::size_t resolution = problem.options.resolution;
        if (resolution < least_resolution || resolution > most_resolution<D>)
            return Status::resolution_not_supported;
        if (!(problem.options.averaging.tolerance > 0)) return Status::tolerance_not_positive;
        const auto lattice = grid::lattice_about(bounds_of(problem.cage.vertices()), resolution);
        const double bytes = double(lattice.size()) * (bytes_of_cell(width(problem)) + sizeof(grid::CellTag));
        if (bytes > double(problem.options.memory_limit)) {
            report.bytes =
                std::size_t((std::min)(bytes, double((std::numeric_limits<std::ptrdiff_t>::max)())));
            return Status::out_of_memory;
        }
        made.emplace(problem);
        const grid::GridDomain<T, D>& domain = made->domain_;
        report.pyramid.crowded_cells = domain.crowded_cells;
        report.cells =
            std::size_t(std::count(domain.tags.begin(), domain.tags.end(), grid::CellTag::interior));
        return Status::ok;
    }

    explicit PyramidSolver(const Problem& problem)
        : problem_(problem)
        , domain_(grid::rasterise(problem.cage, grid::lattice_about(bounds_of(problem.cage.vertices()),
                                                                    problem.options.resolution))) {}

    /// Excludes the pyramid's runs of cells, which take some bytes per row.
    SolverMemory memory() const noexcept {
        const std::size_t cells = domain_.tags.size();
        return {cells + domain_.data.size() * sizeof(grid::CellData<T>),
                std::size_t(double(cells) * bytes_of_cell(width()))};
    }

    // ---- groups
    // ------------------------------------------------------------------------------------

    using Functions = std::vector<std::vector<T>>; ///< one vector of cell values per function
    struct Block {
        grid::AveragingPyramid<T, D> pyramid;
        Functions functions;

        operator const Functions&() const noexcept { return functions; }
    };
    std::size_t groups() const noexcept { return (problem_.cage.size() + width() - 1) / width(); }
    Block make_block() const {
        return {grid::AveragingPyramid<T, D>(domain_.lattice, domain_.tags, problem_.options.averaging), {}};
    }

    Status solve(std::size_t group, Block& block, grid::GroupWork& work) const {
        const std::size_t first = group * width(), count = (std::min)(width(), problem_.cage.size() - first);
        block.functions.assign(count, std::vector<T>(domain_.tags.size(), T(0)));
        for (std::size_t n = 0; n < count; ++n) {
            std::vector<T>& field = block.functions[n];
            for (const auto& given : domain_.data_of(first + n)) field[given.cell] = given.value;
            const auto keep_going = [&] { return work.keep_going(double(n) / double(count)); };
            if (!keep_going()) return Status::cancelled;
            const auto outcome = block.pyramid.solve(std::span<T>(field), keep_going);
            if (outcome.cancelled) return Status::cancelled;
            ++work.report.solves;
            work.report.pyramid.sweeps += outcome.sweeps;
            work.report.pyramid.largest_mean_change =
                (std::max)(work.report.pyramid.largest_mean_change, outcome.mean_change);
            if (outcome.converged) continue;
            work.report.unconverged = 1;
            return Status::not_converged;
        }
        return Status::ok;
    }
    Functions keep(const Block& block) const { return block.functions; }

    // ---- samples
    // -----------------------------------------------------------------------------------

    struct Sample {
        std::size_t point;
        grid::SampleStencil<T, D> stencil;  ///< for a point inside
        std::optional<BoundaryValue<D>> on; ///< for a point on the boundary
    };
    using Samples = std::vector<Sample>;
    Samples samples(const detail::Batch<T>& batch, std::span<const std::size_t> points) const {
        Samples samples;
        samples.reserve(points.size());
        for (const std::size_t i : points) {
            Sample& sample = samples.emplace_back(Sample{i, {}, {}});
            if (i >= batch.points.points) continue;
            PointState& state = batch.states[i];
            if (state == PointState::not_finite) continue;
            const auto p = block_point<D>(batch.points, i);
            state = locate(problem_.cage, p, problem_.tolerance);
            Vec<T, D> position;
            if (state == PointState::on_boundary)
                sample.on = nearest_boundary_value(problem_.cage, p, position);
            if (state != PointState::inside) continue;
            sample.stencil =
                grid::sample_stencil(domain_.lattice, std::span<const grid::CellTag>(domain_.tags), p,
                                     problem_.options.interpolation);
            if (sample.stencil.count == 0) state = PointState::unreached;
        }
        return samples;
    }
    void sample(const Samples& samples, std::size_t group, const Functions& functions,
                BlockView<T> rows) const noexcept {
        const std::size_t first = group * width();
        for (const auto& [i, stencil, on] : samples) {
            const std::size_t lane = i % lane_count<T>;
            auto* const row = rows.block(i / lane_count<T>) + first;
            for (std::size_t k = 0; k < functions.size(); ++k)
                row[k][lane] = stencil.sample(std::span<const T>(functions[k]));
            for (std::size_t k = 0; on && k < on->most; ++k) {
                const std::size_t function = on->handle[k] - first;
                if (function < functions.size()) row[function][lane] += T(on->weight[k]);
            }
        }
    }
    void finish(const Samples& /*samples*/, BlockView<T> /*rows*/) const noexcept {}

private:
    static std::size_t width(const Problem& problem) noexcept {
        return std::clamp<std::size_t>(problem.options.handles_at_once, 1, problem.cage.size());
    }
    std::size_t width() const noexcept { return width(problem_); }
    /// Returns the bytes per cell of a block. Each level of the pyramid has a quarter of the cells
    /// of the level below (in 3D, an eighth).
    static double bytes_of_cell(std::size_t functions) noexcept {
        constexpr double levels = D == 2 ? 4.0 / 3 : 8.0 / 7;
        return double(functions * sizeof(T)) + levels * double(sizeof(T) + sizeof(grid::CellTag));
    }

    const Problem& problem_;
    grid::GridDomain<T, D> domain_;
};

/// The choice among all solvers by HarmonicOptions: the pyramid if `solver` names it, else the uniform
/// grid if there is a `resolution`, else the adaptive grid.
///     HarmonicCoordinates<T, 2, Polygon<T>, WithAveragingPyramid>
///     HarmonicCoordinates<T, 3, TriangleMesh<T>, WithAveragingPyramid>
/// Kinds of cages without a PyramidSolver have the other two solvers (solver_not_supported).
struct WithAveragingPyramid {
    template <class C>
    static Status make(const std::shared_ptr<const CageProblem<C>>& problem, SolverReport& report,
                       std::shared_ptr<FunctionsOf<C>>& made, const Running& running) {
        using T = typename C::scalar;
        if (problem->options.solver == HarmonicSolver::averaging_pyramid) {
            if constexpr (std::is_same_v<C, Polygon<T>> || std::is_same_v<C, TriangleMesh<T>>)
                return OnlySolver<PyramidSolver<C>>::make(problem, report, made, running);
            else
                return Status::solver_not_supported;
        }
        if (problem->options.resolution != 0) return UniformGrid::make(problem, report, made, running);
        return AdaptiveGrid::make(problem, report, made, running);
    }
};

} // namespace cageform::inline CAGEFORM_ABI

// Harmonic coordinates by the averaging sweeps of the original papers, on grid cells. They are a baseline for
// other solvers, and an example of a solver of your own.
#pragma once

#include "averaging/averaging_pyramid.hpp"
#include "averaging/rasterise.hpp"
#include "averaging/sample.hpp"

#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/harmonic/solution.hpp>

namespace cageform_sources::averaging {

using cageform::BlockView, cageform::Running, cageform::SolverInput, cageform::SolverReport;
using cageform::Status;

/// The solver of the papers for harmonic coordinates:
/// `HarmonicCoordinates coordinates(cage, {.resolution = 128}, AveragingSolver{})`. The resolution includes
/// a margin of four cells. The cage is a Polygon or a TriangleMesh (else solver_not_supported).
struct AveragingSolver {
    AveragingOptions sweeps{.tolerance = 1e-6};
    Interpolation interpolation = Interpolation::multilinear;
    std::size_t handles_at_once = 16; ///< functions solved and sampled together

    template <class T, std::size_t D>
    Status operator()(std::shared_ptr<const SolverInput<D>> input, SolverReport& report,
                      std::shared_ptr<cageform::CageFunctions<T, D>>& made, const Running& running) const;
};

/// A CageSolver. A group is `handles_at_once` functions, solved one after another.
///
///   range     [0, 1] to rounding (a mean of values in [0, 1]), before `bind` restores linear
///             precision; sum to 1 as far as the solver converged: its tolerance is on the change
///             per sweep, not on the error
///   accuracy  boundary cells form a staircase, which leaves a residual Σwc − p of about half a
///             cell; `bind` restores linear precision, and the report states the correction. The
///             papers sweep to AveragingOptions::tolerance 1e-5. They use
///             Interpolation::nearest_cell, whose error is at most a cell's diagonal
///   cost      per thread handles_at_once scalars a cell, and another scalar and a tag for each
///             cell of the pyramid; after `solve` #V scalars a cell. With one handle at once in
///             float that is 12 bytes a cell in 3D, as published
///   fails     as HarmonicCoordinates, except for grid_too_coarse. A point with no valued cell
///             around it is unreached; there are no gradients (solver_not_supported)
template <class T, std::size_t D>
class PyramidSolver {
    using Cage = std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>;

public:
    static constexpr std::size_t dimension = D;

    static Status make(const SolverInput<D>& input, SolverReport& report, std::optional<PyramidSolver>& made,
                       const Running& /*running*/, const AveragingSolver& options = {}) {
        const std::size_t resolution = input.options.resolution;
        if (!input.data.is_linear() || !input.cage.cells().empty() ||
            input.handles != input.cage.boundary().size())
            return Status::solver_not_supported;
        if (resolution < cageform::least_resolution || resolution > cageform::most_resolution<D>)
            return Status::resolution_not_supported;
        if (!(options.sweeps.tolerance > 0)) return Status::tolerance_not_positive;
        auto cage = cage_of(input);
        const auto lattice = lattice_about(bounds_of(cage.vertices()), resolution);
        const std::size_t width = std::clamp<std::size_t>(options.handles_at_once, 1, cage.size());
        const double bytes = double(lattice.size()) * (bytes_of_cell(width) + sizeof(CellTag));
        if (bytes > double(input.options.memory_limit)) {
            report.bytes = std::size_t(std::min(bytes, double(std::numeric_limits<std::ptrdiff_t>::max())));
            return Status::out_of_memory;
        }
        made.emplace(std::move(cage), T(input.tolerance), lattice, options);
        const auto& domain = made->domain_;
        report.unresolved_cells = domain.unresolved_cells;
        report.cells = std::size_t(std::count(domain.tags.begin(), domain.tags.end(), CellTag::interior));
        return Status::ok;
    }

    PyramidSolver(Cage cage, T tolerance, const Lattice<T, D>& lattice, const AveragingSolver& options)
        : cage_(std::move(cage))
        , tolerance_(tolerance)
        , options_(options)
        , domain_(rasterise(cage_, lattice)) {}

    /// Excludes the pyramid's runs of cells, which take some bytes per row.
    cageform::SolverMemory memory() const noexcept {
        const std::size_t cells = domain_.tags.size();
        return {cells + domain_.data.size() * sizeof(CellData<T>),
                std::size_t(double(cells) * bytes_of_cell(width()))};
    }

    // ---- groups

    using Functions = std::vector<std::vector<T>>; ///< one vector of cell values per function
    struct Block {
        AveragingPyramid<T, D> pyramid;
        Functions functions;

        operator const Functions&() const noexcept { return functions; }
    };
    std::size_t groups() const noexcept { return (cage_.size() + width() - 1) / width(); }
    Block make_block() const {
        return {AveragingPyramid<T, D>(domain_.lattice, domain_.tags, options_.sweeps), {}};
    }

    Status solve(std::size_t group, Block& block, cageform::grid::GroupWork& work) const {
        const std::size_t first = group * width(), count = std::min(width(), cage_.size() - first);
        block.functions.assign(count, std::vector<T>(domain_.tags.size(), T(0)));
        for (std::size_t n = 0; n < count; ++n) {
            std::vector<T>& field = block.functions[n];
            for (const auto& given : domain_.data_of(first + n)) field[given.cell] = given.value;
            const auto keep_going = [&] { return work.keep_going(double(n) / double(count)); };
            if (!keep_going()) return Status::cancelled;
            const auto outcome = block.pyramid.solve(std::span<T>(field), keep_going);
            if (outcome.cancelled) return Status::cancelled;
            ++work.report.solves;
            work.report.relaxation.sweeps += outcome.sweeps;
            work.report.relaxation.largest_mean_change =
                std::max(work.report.relaxation.largest_mean_change, outcome.mean_change);
            if (outcome.converged) continue;
            work.report.unconverged = 1;
            return Status::not_converged;
        }
        return Status::ok;
    }
    Functions keep(const Block& block) const { return block.functions; }

    // ---- samples

    struct Sample {
        std::size_t point;
        SampleStencil<T, D> stencil;        ///< for a point inside
        std::optional<BoundaryValue<D>> on; ///< for a point on the boundary
    };
    using Samples = std::vector<Sample>;
    Samples samples(const cageform::Batch<T>& batch, std::span<const std::size_t> points) const {
        Samples samples;
        samples.reserve(points.size());
        for (const std::size_t i : points) {
            Sample& sample = samples.emplace_back(Sample{i, {}, {}});
            if (i >= batch.points.points) continue;
            PointState& state = batch.states[i];
            if (state == PointState::not_finite) continue;
            const auto p = cageform::block_point<D>(batch.points, i);
            state = locate(cage_, p, tolerance_);
            Vec<T, D> position;
            if (state == PointState::on_boundary) sample.on = nearest_boundary_value(cage_, p, position);
            if (state != PointState::inside) continue;
            sample.stencil = sample_stencil(domain_.lattice, std::span<const CellTag>(domain_.tags), p,
                                            options_.interpolation);
            if (sample.stencil.count == 0) state = PointState::unreached;
        }
        return samples;
    }
    void sample(const Samples& samples, std::size_t group, const Functions& functions,
                BlockView<T> rows) const noexcept {
        const std::size_t first = group * width();
        for (const auto& [i, stencil, on] : samples) {
            const std::size_t lane = i % cageform::lane_count<T>;
            auto* const row = rows.block(i / cageform::lane_count<T>) + first;
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
    /// Returns the cage in its own scalar, from which the input was converted exactly.
    static Cage cage_of(const SolverInput<D>& input) {
        const auto& boundary = input.cage.boundary();
        if constexpr (D == 2) {
            std::vector<std::size_t> sizes;
            for (const auto& loop : boundary.loops()) sizes.push_back(loop.size());
            return Cage(boundary.vertices(), sizes);
        } else {
            return Cage(boundary.vertices(), boundary.faces());
        }
    }
    std::size_t width() const noexcept {
        return std::clamp<std::size_t>(options_.handles_at_once, 1, cage_.size());
    }
    /// Returns the bytes per cell of a block. Each level of the pyramid has a quarter of the cells
    /// of the level below (in 3D, an eighth).
    static double bytes_of_cell(std::size_t functions) noexcept {
        constexpr double levels = D == 2 ? 4.0 / 3 : 8.0 / 7;
        return double(functions * sizeof(T)) + levels * double(sizeof(T) + sizeof(CellTag));
    }

    Cage cage_;
    T tolerance_;
    AveragingSolver options_;
    GridDomain<T, D> domain_;
};

template <class T, std::size_t D>
Status AveragingSolver::operator()(std::shared_ptr<const SolverInput<D>> input, SolverReport& report,
                                   std::shared_ptr<cageform::CageFunctions<T, D>>& made,
                                   const Running& running) const {
    return cageform::make_functions<PyramidSolver<T, D>, T>(std::move(input), report, made, running, *this);
}

} // namespace cageform_sources::averaging

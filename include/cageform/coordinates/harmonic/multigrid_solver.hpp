// Solves the harmonic functions of a cage by multigrid on a uniform lattice. The equations use the exact
// distances from nodes to the boundary.
#pragma once

#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/harmonic/corner_samples.hpp>
#include <cageform/coordinates/harmonic/cut_samples.hpp>
#include <cageform/coordinates/harmonic/embedded_cage.hpp>
#include <cageform/coordinates/harmonic/options.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/corners/edge_errors.hpp>
#include <cageform/grid/multigrid/groups.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A CageSolver with sixteen functions per group. Singularities at a polygon's corners are treated separately
/// (grid/corners/corner_functions.hpp).
template <std::size_t D>
class MultigridSolver {
    static constexpr std::size_t width = grid::Multigrid<D>::width;

public:
    static constexpr std::size_t dimension = D;

    static Status make(const SolverInput<D>& input, SolverReport& report,
                       std::optional<MultigridSolver>& made, const Running& /*running*/) {
        if (!(input.options.multigrid.tolerance > 0)) return Status::tolerance_not_positive;
        std::optional<detail::EmbeddedCage<D>> grid;
        const Status status = detail::EmbeddedCage<D>::make(input, report, grid);
        if (status != Status::ok) return status;
        // NOLINTNEXTLINE(bugprone-unchecked-optional-access): made where the status is ok
        detail::EmbeddedCage<D>& embedded = *grid;
        // Cells must resolve the decay of screened functions over 1/κ.
        constexpr double most_decay = 0.5; // of a cell
        const double rate = std::sqrt(input.screening), of_cell = rate * embedded.lattice().spacing;
        if (of_cell > most_decay) {
            report.sufficient_resolution =
                std::size_t(double(embedded.resolution()) * of_cell / most_decay) + 1;
            return Status::grid_too_coarse;
        }
        // Far inside, all functions are small: at the centre of a ball of radius r, about e^(−κr).
        const auto bounds = bounds_of(input.cage.vertices());
        const auto extent = bounds.upper - bounds.lower;
        const double radius = 0.5 * *std::min_element(std::begin(extent.v), std::end(extent.v));
        MultigridOptions options = input.options.multigrid;
        options.tolerance = (std::max)(options.tolerance * std::exp(-rate * radius),
                                       (std::min)(options.tolerance, least_tolerance));
        made.emplace(std::move(embedded), options, input.screening);
        report.cells = made->multigrid_.unknowns();
        return Status::ok;
    }

    MultigridSolver(detail::EmbeddedCage<D> grid, const MultigridOptions& options, double screening)
        : grid_(std::move(grid))
        , options_(options)
        , corners_(corners_of(grid_, options))
        , errors_(errors_of(grid_, corners_))
        , multigrid_(grid_.problem().nodes, grid_.problem().cuts, corners_.sources(), {},
                     screening * grid_.lattice().spacing * grid_.lattice().spacing)
        , slots_(multigrid_.source_slots()) {
        corners_.set_slots(slots_);
    }

    SolverMemory memory() const noexcept { return {multigrid_.bytes(), multigrid_.block_bytes()}; }

    // ---- groups ------------------------------------------------------------------------------------

    struct Block {
        typename grid::Multigrid<D>::Block cycled;
        grid::CornerFunctions::Coefficients at_corners;

        typename grid::Multigrid<D>::Values value(std::uint32_t node) const noexcept {
            return cycled.value(node);
        }
    };
    std::size_t groups() const noexcept { return (grid_.handles() + width - 1) / width; }
    Block make_block() const { return {multigrid_.make_block(), {}}; }
    std::size_t helpers() const noexcept { return multigrid_.helpers(); }

    Status solve(std::size_t group, Block& block, grid::GroupWork& work) const {
        const std::size_t first = handles_of(group).first, count = handles_of(group).second;
        auto& source = block.cycled.source;
        for (auto& values : source) values.fill(0.0);
        grid_.add_data(first, count, slots_, std::span(source));
        block.at_corners = corners_.start(first, source);
        const grid::CycleGoal goal{count, options_.tolerance, options_.max_cycles};
        const Status status = grid::run_cycles(multigrid_, block.cycled, goal, work, [&] {
            // Alternates with the solution, because corner coefficients and solution depend on each other.
            const auto fitted = corners_.fit(first, block, block.at_corners);
            const double change = corners_.difference(fitted, block.at_corners);
            grid::Multigrid<D>::disturb(block.cycled, corners_.replace(block.at_corners, fitted, source));
            return change;
        });
        if (status == Status::ok) {
            const std::array<std::size_t, 2> resolutions{grid_.resolution(), most_resolution<D>};
            errors_.measure(first, count, block, resolutions, work.report.multigrid.corners);
        }
        return status;
    }

    struct Functions {
        Buffer<typename grid::Multigrid<D>::Values> values; ///< by node
        grid::CornerFunctions::Coefficients at_corners;

        const typename grid::Multigrid<D>::Values& value(std::uint32_t node) const noexcept {
            return values[node];
        }
    };
    Functions keep(const Block& block) const {
        Functions functions{{}, block.at_corners};
        functions.values.reserve(multigrid_.unknowns());
        for (std::uint32_t node = 0; node < multigrid_.unknowns(); ++node)
            functions.values.push_back(block.value(node));
        return functions;
    }

    // ---- samples -----------------------------------------------------------------------------------

    struct Samples {
        detail::CutSamples<D> cut;
        detail::CornerSamples at_corners;
    };
    template <Scalar T>
    Samples samples(const Batch<T>& batch, std::span<const std::size_t> points) const {
        Samples samples;
        for (const std::size_t i : points) {
            const auto stencil = grid_.stencil(batch, i);
            samples.cut.add(i, stencil, grid_.data());
            if constexpr (D == 2) {
                if (i < batch.points.points && batch.states[i] == PointState::inside)
                    samples.at_corners.add(corners_, i,
                                           grid_.in_cells(vec_cast<double>(block_point<D>(batch.points, i))),
                                           stencil);
            }
        }
        samples.at_corners.reserve(grid_.handles());
        return samples;
    }
    template <class Solved, Scalar T> // Solved: a Block or kept Functions
    void sample(Samples& samples, std::size_t group, const Solved& solved, BlockView<T> rows) const noexcept {
        const auto [first, count] = handles_of(group);
        samples.cut.sample(solved, first, count, rows);
        samples.at_corners.sample(solved.at_corners, first, count);
    }
    template <Scalar T>
    void finish(const Samples& samples, BlockView<T> rows) const noexcept {
        samples.at_corners.finish(options_.tolerance, rows);
    }

    double spacing(const Vec<double, D>& /*p*/) const noexcept { return grid_.lattice().spacing; }
    PointState state_of(const Vec<double, D>& p) const noexcept { return grid_.state_of(p); }
    double free_distance(const Vec<double, D>& p, std::size_t axis, bool up, double limit) const noexcept {
        return grid_.free_distance(p, axis, up, limit);
    }

private:
    static constexpr double least_tolerance = 1e-12; ///< that rounding allows

    /// Makes the corner functions of a polygon. There are none in 3D.
    static grid::CornerFunctions corners_of([[maybe_unused]] const detail::EmbeddedCage<D>& grid,
                                            [[maybe_unused]] const MultigridOptions& options) {
        if constexpr (D == 2) {
            return {grid.cage(), grid.lattice(), grid.problem(), options.corner_functions};
        } else {
            return {};
        }
    }
    static grid::CornerErrors<D> errors_of(const detail::EmbeddedCage<D>& grid,
                                           [[maybe_unused]] const grid::CornerFunctions& corners) {
        if constexpr (D == 2) {
            return corners.errors();
        } else {
            if (!grid.data().is_linear()) return {};
            return cageform::grid::edge_errors(grid.cage(), grid.lattice(), grid.problem());
        }
    }
    /// Returns the first handle of a group and the number of its handles.
    std::pair<std::size_t, std::size_t> handles_of(std::size_t group) const noexcept {
        return {group * width, (std::min)(width, grid_.handles() - group * width)};
    }

    detail::EmbeddedCage<D> grid_;
    MultigridOptions options_;
    grid::CornerFunctions corners_;
    grid::CornerErrors<D> errors_;
    grid::Multigrid<D> multigrid_;
    std::vector<std::uint32_t> slots_; ///< per node: its index in Block::source
};

} // namespace cageform::inline CAGEFORM_ABI

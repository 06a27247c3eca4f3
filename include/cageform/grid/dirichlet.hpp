// The discrete Dirichlet problem on the cells of a grid, in one, two or three dimensions: some
// values are given, each of the others is the mean of its neighbours. What harmonic coordinates are
// made with, for any use: images filled in from a few known pixels, heat that has come to rest,
// crosswords of numbers.
#pragma once

#include <cageform/core/buffer.hpp>
#include <cageform/grid/lattice.hpp>
#include <cageform/grid/multigrid_groups.hpp>

namespace cageform::inline CAGEFORM_ABI {

struct DirichletOptions {
    double tolerance =
        1e-6; ///< of the error, by its estimate, relative to the range of a field's given values
    std::size_t max_cycles = 60; ///< not_converged when they do not suffice
};

namespace detail {

/// The unknown cells of a grid as nodes, and their links to given cells.
template <std::size_t D>
struct UnknownCells {
    std::size_t grid_size;
    grid::NodeRuns<D> nodes;
    std::vector<std::size_t> cells; ///< of the nodes
    Buffer<grid::CutLink> cuts;
    std::vector<std::size_t> given;               ///< the cell at the end of each cut link
    std::size_t without_rim = SolverReport::none; ///< the first unknown cell at the end of the grid

    UnknownCells(const CellBox<D>& grid, std::span<const std::uint8_t> is_given)
        : grid_size(grid.size()) {
        typename grid::NodeRuns<D>::Index counts;
        for (std::size_t k = 0; k < D; ++k) counts[k] = std::int32_t(grid.cells[k]);
        nodes = grid::NodeRuns<D>(counts);
        for (std::size_t row = 0; row < grid_size; row += grid.cells[0]) {
            for (std::size_t x = 0; x < grid.cells[0];) {
                std::size_t end = x;
                for (; end < grid.cells[0] && is_given[row + end] == 0; ++end) cells.push_back(row + end);
                nodes.add_run(std::int32_t(x), std::int32_t(end));
                x = end + 1;
            }
            nodes.end_row();
        }
        nodes.for_each_end([&](const auto& index, std::uint32_t node, std::size_t direction) {
            const std::size_t axis = direction / 2, cell = cells[node];
            const bool up = (direction & 1) != 0;
            if (up ? index[axis] + 1 == counts[axis] : index[axis] == 0) {
                without_rim = std::min(without_rim, cell);
                return;
            }
            cuts.push_back({node, std::uint8_t(direction), 1.0});
            given.push_back(up ? cell + grid.stride(axis) : cell - grid.stride(axis));
        });
    }
};

/// The range of the values of a field that unknown cells are linked to, which is solved for as [−1,
/// 1].
struct FieldRange {
    double middle, half;

    template <Scalar T>
    FieldRange(std::span<const T> field, std::span<const std::size_t> cells) {
        double low = double(field[cells[0]]), high = low;
        for (const std::size_t cell : cells) {
            low = std::fmin(low, double(field[cell]));
            high = std::fmax(high, double(field[cell]));
        }
        middle = 0.5 * low + 0.5 * high;
        half = 0.5 * high - 0.5 * low;
    }
};

/// Solves for the unknown cells of all fields; `values` is written when all is solved.
template <std::size_t D, Scalar T>
Status solve_fields(const UnknownCells<D>& unknown, std::span<T> values, const DirichletOptions& options,
                    SolverReport& report, const Running& running) {
    const grid::Multigrid<D> multigrid(unknown.nodes, unknown.cuts, {});
    report.bytes = multigrid.bytes() + multigrid.block_bytes();
    const auto slots = multigrid.source_slots();
    const std::size_t size = unknown.grid_size, fields = values.size() / size, count = unknown.cells.size();
    std::vector<FieldRange> ranges;
    for (std::size_t f = 0; f < fields; ++f)
        ranges.emplace_back(std::span<const T>(values.subspan(f * size, size)), std::span(unknown.given));

    const auto fill = [&](std::size_t first, std::size_t together, auto& source) {
        for (std::size_t k = 0; k < together; ++k) {
            const T* const field = values.data() + (first + k) * size;
            const auto [middle, half] = ranges[first + k];
            for (std::size_t c = 0; c < unknown.cuts.size() && half > 0; ++c)
                source[slots[unknown.cuts[c].node]][k] += (double(field[unknown.given[c]]) - middle) / half;
        }
    };
    std::vector<T> solved(fields * count);
    const auto take = [&](std::size_t group, const auto& block) {
        const std::size_t first = group * multigrid.width;
        for (std::uint32_t node = 0; node < count; ++node) {
            const auto value = block.value(node);
            for (std::size_t k = 0; k < std::min(multigrid.width, fields - first); ++k)
                solved[(first + k) * count + node] =
                    static_cast<T>(ranges[first + k].middle + ranges[first + k].half * value[k]);
        }
    };
    // Errors are of values in [−1, 1], whose range is 2.
    const grid::CycleGoal goal{fields, 2 * options.tolerance, options.max_cycles};
    const Status status =
        grid::solve_groups(grid::MultigridGroups{multigrid, goal, fill}, report, take, running);
    report.error_estimate *= 0.5;
    report.error_bound *= 0.5;
    if (status != Status::ok) return status;
    for (std::size_t f = 0; f < fields; ++f) {
        for (std::size_t node = 0; node < count; ++node)
            values[f * size + unknown.cells[node]] = solved[f * count + node];
    }
    return Status::ok;
}

} // namespace detail

/// Fills in the unknown cells of any number of fields.
///
///   cells    of the grid, numbered along the first axis first
///   given    #cells; 0 where the value is unknown. Every unknown cell must have all its 2·D
///            neighbours in the grid
///   values   fields of #cells each, one after the other; values given are read, unknown ones are
///            written when the status is ok, and not before
///   cost     O(#unknown cells) a field, sixteen together; memory: Multigrid::bytes() once,
///            block_bytes() a thread, the unknown values once more, and 8 bytes an unknown cell.
///            The progress is asked before every cycle
///   fails    rim_not_given and value_not_finite (SolverReport::culprit is the cell, or the place
///            in `values`); tolerance_not_positive; not_converged; cancelled; out_of_memory (also
///            for 2³¹ cells and more)
template <std::size_t D, Scalar T>
Evaluation solve_dirichlet(const CellBox<D>& cells, std::span<const std::uint8_t> given, std::span<T> values,
                           const DirichletOptions& options = {}, const Running& running = {}) {
    const std::size_t size = cells.size();
    CAGEFORM_ASSERT(given.size() == size && (size == 0 ? values.empty() : values.size() % size == 0),
                    "a mark for each cell, and whole fields");
    return detail::guarded_evaluation([&](SolverReport& report) {
        const auto fail = [&](Status status, std::size_t culprit) {
            report.culprit = culprit;
            return status;
        };
        if (!(options.tolerance > 0)) return Status::tolerance_not_positive;
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (given[i % size] != 0 && !std::isfinite(values[i])) return fail(Status::value_not_finite, i);
        }
        constexpr auto most = std::size_t(std::numeric_limits<std::int32_t>::max());
        if (size > most || cells.cells[0] > most) return Status::out_of_memory;
        const detail::UnknownCells<D> unknown(cells, given);
        report.cells = unknown.cells.size();
        if (unknown.without_rim != SolverReport::none)
            return fail(Status::rim_not_given, unknown.without_rim);
        if (unknown.cells.empty()) return Status::ok;
        return detail::solve_fields(unknown, values, options, report, running);
    });
}

} // namespace cageform::inline CAGEFORM_ABI

// The unknown cells of a grid, and the solution of their equations.
#pragma once

#include <cageform/core/detail/disjoint_sets.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/core/view.hpp>
#include <cageform/fields/detail/field_solver.hpp>
#include <cageform/fields/types/dirichlet_options.hpp>
#include <cageform/grid/lattice/lattice.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The connected components of nodes, as sets of runs.
template <std::size_t D>
class NodeComponents {
public:
    explicit NodeComponents(const grid::NodeRuns<D>& nodes)
        : runs_(nodes.runs())
        , components_(runs_.size()) {
        std::size_t step = 1; // number of rows to the neighbour along the axis
        for (std::size_t axis = 1; axis < D; ++axis) {
            for (std::size_t row = 0; row + step < nodes.rows(); ++row) {
                if (nodes.row_index(row)[axis] + 1 < nodes.size()[axis]) join(nodes, row, row + step);
            }
            step *= std::size_t(nodes.size()[axis]);
        }
    }

    std::size_t runs() const noexcept { return runs_.size(); }
    /// Returns the first run of a run's component.
    std::size_t component(std::size_t run) noexcept { return components_.find(std::uint32_t(run)); }
    const typename grid::NodeRuns<D>::Run& operator[](std::size_t run) const noexcept { return runs_[run]; }

private:
    using Run = typename grid::NodeRuns<D>::Run;

    void join(const grid::NodeRuns<D>& nodes, std::size_t row, std::size_t other_row) noexcept {
        const Run *a = nodes.row_runs(row), *b = nodes.row_runs(other_row);
        while (a != nodes.row_runs_end(row) && b != nodes.row_runs_end(other_row)) {
            if ((std::max)(a->begin, b->begin) < (std::min)(a->end, b->end))
                components_.join(std::uint32_t(a - runs_.data()), std::uint32_t(b - runs_.data()));
            ++(a->end < b->end ? a : b);
        }
    }

    std::span<const Run> runs_;
    DisjointSets components_;
};

/// The unknown cells of a grid as nodes, with their links to given cells and out of the domain.
template <std::size_t D>
struct UnknownCells {
    std::size_t grid_size;
    grid::NodeRuns<D> nodes;
    std::vector<std::size_t> cells; ///< per node
    Buffer<grid::CutLink> cuts;     ///< weight 0 for a link out of the domain
    std::vector<std::size_t> given; ///< per cut: the cell at its end; for weight 0 the node's own cell
    std::size_t without_rim = SolverReport::none; ///< the first unknown cell at the boundary of the grid

    UnknownCells(const CellBox<D>& grid, std::span<const Cell> kinds, Rim rim)
        : grid_size(grid.size()) {
        typename grid::NodeRuns<D>::Index counts;
        for (std::size_t k = 0; k < D; ++k) counts[k] = std::int32_t(grid.cells[k]);
        nodes = grid::NodeRuns<D>(counts);
        for (std::size_t row = 0; row < grid_size; row += grid.cells[0]) {
            for (std::size_t x = 0; x < grid.cells[0];) {
                std::size_t end = x;
                for (; end < grid.cells[0] && kinds[row + end] == Cell::unknown; ++end)
                    cells.push_back(row + end);
                nodes.add_run(std::int32_t(x), std::int32_t(end));
                x = end + 1;
            }
            nodes.end_row();
        }
        nodes.for_each_end([&](const auto& index, std::uint32_t node, std::size_t direction) {
            const std::size_t axis = direction / 2, cell = cells[node];
            const bool up = (direction & 1) != 0;
            const bool at_rim = up ? index[axis] + 1 == counts[axis] : index[axis] == 0;
            if (at_rim && rim == Rim::given) {
                without_rim = (std::min)(without_rim, cell);
                return;
            }
            const std::size_t step = grid.stride(axis), there = at_rim ? cell
                                                                : up   ? cell + step
                                                                       : cell - step;
            const bool leaves = at_rim || kinds[there] == Cell::outside;
            cuts.push_back({node, std::uint8_t(direction), leaves ? 0.0 : 1.0});
            given.push_back(leaves ? cell : there);
        });
    }

    /// Finds components without a given cell. Reports the first cell of these components, and the number of
    /// their cells.
    void find_unreached(SolverReport& report) const {
        NodeComponents<D> components(nodes);
        std::vector<bool> reached(components.runs(), false);
        for (const auto& cut : cuts) {
            if (cut.weight > 0) reached[components.component(run_of(components, cut.node))] = true;
        }
        for (std::size_t run = 0; run < components.runs(); ++run) {
            if (reached[components.component(run)]) continue;
            report.culprit = (std::min)(report.culprit, cells[components[run].first]);
            report.unreached_cells += std::size_t(components[run].end - components[run].begin);
        }
    }

private:
    /// Returns the last run that begins at or before the node.
    static std::size_t run_of(const NodeComponents<D>& components, std::uint32_t node) noexcept {
        std::size_t low = 0, high = components.runs();
        while (high - low > 1) {
            const std::size_t middle = (low + high) / 2;
            (components[middle].first <= node ? low : high) = middle;
        }
        return low;
    }
};

/// Solves for the unknown cells of all fields; writes to `values` only on success.
template <std::size_t D, Scalar T>
Status solve_cells(const UnknownCells<D>& unknown, std::span<T> values, const DirichletOptions& options,
                   SolverReport& report, const Running& running) {
    const std::size_t size = unknown.grid_size, fields = values.size() / size, count = unknown.cells.size();
    const auto given = [&](std::size_t cut, std::size_t field) {
        return double(values[field * size + unknown.given[cut]]);
    };
    std::vector<FieldRange> ranges(fields);
    for (std::size_t f = 0; f < fields; ++f) {
        for (std::size_t c = 0; c < unknown.cuts.size(); ++c) {
            if (unknown.cuts[c].weight > 0) ranges[f].add(given(c, f));
        }
    }
    std::vector<T> solved(fields * count);
    const Status status = solve_fields<D, T>(FieldProblem{unknown.nodes, unknown.cuts, ranges, given},
                                             options, solved, report, running);
    if (status != Status::ok) return status;
    for (std::size_t f = 0; f < fields; ++f) {
        for (std::size_t node = 0; node < count; ++node)
            values[f * size + unknown.cells[node]] = solved[f * count + node];
    }
    return Status::ok;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// The unknown cells of a grid, and the solution for them by multigrid.
#pragma once

#include <cageform/core/detail/disjoint_sets.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/core/view.hpp>
#include <cageform/fields/types/dirichlet_options.hpp>
#include <cageform/grid/lattice/lattice.hpp>
#include <cageform/grid/multigrid/groups.hpp>

namespace cageform::inline CAGEFORM_ABI {

namespace detail {

/// The connected components of nodes, as sets of their runs.
template <std::size_t D>
class NodeComponents {
public:
    explicit NodeComponents(const grid::NodeRuns<D>& nodes)
        : runs_(nodes.runs())
        , components_(runs_.size()) {
        std::size_t step = 1; // in rows, to the neighbour along the axis
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

/// The unknown cells of a grid as nodes, with their links to given cells or to nothing.
template <std::size_t D>
struct UnknownCells {
    std::size_t grid_size;
    grid::NodeRuns<D> nodes;
    std::vector<std::size_t> cells; ///< of the nodes
    Buffer<grid::CutLink> cuts;     ///< weight 0 if the link leads nowhere
    std::vector<std::size_t> given; ///< the cell at the end of each cut link; the node's own cell if it
                                    ///< leads nowhere
    std::size_t without_rim = SolverReport::none; ///< the first unknown cell at the end of the grid

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
            const bool nowhere = at_rim || kinds[there] == Cell::outside;
            cuts.push_back({node, std::uint8_t(direction), nowhere ? 0.0 : 1.0});
            given.push_back(nowhere ? cell : there);
        });
    }

    /// Finds components without a given cell: counts their cells and reports the first of these.
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
    static std::size_t run_of(const NodeComponents<D>& components, std::uint32_t node) noexcept {
        std::size_t low = 0, high = components.runs(); // binary search for the last run that begins at or
                                                       // before the node
        while (high - low > 1) {
            const std::size_t middle = (low + high) / 2;
            (components[middle].first <= node ? low : high) = middle;
        }
        return low;
    }
};

/// The range of a field's given values next to unknown cells. It is mapped to [−1, 1] for solving.
struct FieldRange {
    double middle, half;

    template <Scalar T, std::size_t D>
    FieldRange(std::span<const T> field, const UnknownCells<D>& unknown) {
        double low = (std::numeric_limits<double>::max)(), high = -low;
        for (std::size_t c = 0; c < unknown.cuts.size(); ++c) {
            if (unknown.cuts[c].weight == 0) continue;
            low = std::fmin(low, double(field[unknown.given[c]]));
            high = std::fmax(high, double(field[unknown.given[c]]));
        }
        middle = 0.5 * low + 0.5 * high;
        half = 0.5 * high - 0.5 * low;
    }
};

/// Solves for the unknown cells of all fields; writes to `values` only after all are solved.
template <std::size_t D, Scalar T>
Status solve_fields(const UnknownCells<D>& unknown, std::span<T> values, const DirichletOptions& options,
                    SolverReport& report, const Running& running) {
    const grid::Multigrid<D> multigrid(unknown.nodes, unknown.cuts, {}, running);
    report.bytes = multigrid.bytes() + multigrid.block_bytes();
    const auto slots = multigrid.source_slots();
    const std::size_t size = unknown.grid_size, fields = values.size() / size, count = unknown.cells.size();
    std::vector<FieldRange> ranges;
    for (std::size_t f = 0; f < fields; ++f)
        ranges.emplace_back(std::span<const T>(values.subspan(f * size, size)), unknown);

    const auto fill = [&](std::size_t first, std::size_t together, auto& source) {
        for (std::size_t k = 0; k < together; ++k) {
            const T* const field = values.data() + (first + k) * size;
            const auto [middle, half] = ranges[first + k];
            for (std::size_t c = 0; c < unknown.cuts.size() && half > 0; ++c) {
                if (unknown.cuts[c].weight > 0)
                    source[slots[unknown.cuts[c].node]][k] +=
                        (double(field[unknown.given[c]]) - middle) / half;
            }
        }
    };
    std::vector<T> solved(fields * count);
    const auto take = [&](std::size_t group, const auto& block) {
        const std::size_t first = group * multigrid.width;
        for (std::uint32_t node = 0; node < count; ++node) {
            const auto value = block.value(node);
            for (std::size_t k = 0; k < (std::min)(multigrid.width, fields - first); ++k)
                solved[(first + k) * count + node] =
                    static_cast<T>(ranges[first + k].middle + ranges[first + k].half * value[k]);
        }
    };
    // Errors refer to values in [−1, 1], whose range is 2.
    const grid::CycleGoal goal{fields, 2 * options.tolerance, options.max_cycles};
    const Status status =
        grid::solve_groups(grid::MultigridGroups{multigrid, goal, fill}, report, take, running);
    report.multigrid.error_estimate *= 0.5;
    report.multigrid.error_bound *= 0.5;
    if (status != Status::ok) return status;
    for (std::size_t f = 0; f < fields; ++f) {
        for (std::size_t node = 0; node < count; ++node)
            values[f * size + unknown.cells[node]] = solved[f * count + node];
    }
    return Status::ok;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI

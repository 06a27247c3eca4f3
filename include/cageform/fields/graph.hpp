// Discrete harmonic functions on graphs, by sparse factorisation. Applications: number puzzles in which
// each number is the mean of its neighbours, networks of resistors, random walks. For large grids use
// fields/dirichlet.hpp. Not included by cageform.hpp.
#pragma once

#include <cageform/core/types/scalar_range.hpp>
#include <cageform/core/view.hpp>
#include <cageform/fields/detail/graph_equations.hpp>
#include <cageform/fields/types/graph.hpp>
#include <cageform/grid/lattice/lattice.hpp>
#include <cageform/grid/types/solver_report.hpp>
#include <cageform/parallel/running.hpp>

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

struct GraphOptions {
    /// Allows negative conductances. Values may then leave the range of the given values, and a unique
    /// solution may not exist.
    bool allow_negative = false;
};

/// The neighbours of a grid cell.
enum class CellNeighbours : std::uint8_t {
    face, ///< cells with a common face: 2, 4, 6 in 1D, 2D, 3D
    all,  ///< also cells with a common corner: 2, 8, 26 in 1D, 2D, 3D
};

/// Returns links of conductance 1 between neighbouring cells of a grid with fewer than 2³² cells.
template <std::size_t D>
std::vector<GraphLink> grid_links(const CellBox<D>& cells, CellNeighbours neighbours) {
    std::size_t offsets = 1;
    for (std::size_t k = 0; k < D; ++k) offsets *= 3;
    std::vector<GraphLink> links;
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
        const auto index = cells.index(cell);
        // Only offsets after the central (zero) one, so that each pair of cells is visited once.
        for (std::size_t code = offsets / 2 + 1; code < offsets; ++code) {
            auto other = index;
            std::size_t moved = 0, rest = code;
            bool in_grid = true;
            for (std::size_t k = 0; k < D; ++k, rest /= 3) {
                const std::size_t step = rest % 3;
                moved += step != 1 ? 1 : 0;
                other[k] = index[k] + step - 1; // wraps around below zero
                in_grid = in_grid && other[k] < cells.cells[k];
            }
            if (in_grid && (neighbours == CellNeighbours::all || moved == 1))
                links.push_back({std::uint32_t(cell), std::uint32_t(cells.number(other)), 1.0});
        }
    }
    return links;
}

/// Solves for the unknown nodes c of any number of fields: Σ k_cd (u_c − u_d) = 0 over the links of c.
///
///   given    #nodes; 0 if the value is unknown
///   values   fields of #nodes each, one after the other; reads given values and writes unknown ones, only
///            if the status is ok
///   returns  values accurate to a few roundings of the largest given value, for any ratio of conductances.
///            With negative conductances, the error is below 1e-6 of the largest value
///   cost     one factorisation, O(n^1.5) for planar graphs of n unknown nodes; 16 fields cost one pass
///            over the factors. Reports progress before each pass
///   fails    index_out_of_range, input_malformed (a link from a node to itself) and weights_not_positive
///            (SolverReport::culprit is the link); value_not_finite (the index in `values`);
///            cells_unreached (the first unknown node without a path to a given one); not_converged (a
///            singular matrix, or values out of the range of T); cancelled; out_of_memory
template <MutableScalarRange V>
Evaluation solve_graph(const Graph& graph, std::span<const std::uint8_t> given, V&& values,
                       const GraphOptions& options = {}, const Running& running = {}) {
    using T = detail::element_t<V>;
    const std::span<T> fields(values);
    const std::size_t size = graph.nodes;
    CAGEFORM_ASSERT(given.size() == size && (size == 0 ? fields.empty() : fields.size() % size == 0),
                    "one mark per node, values of whole fields");
    return detail::guarded_evaluation([&](SolverReport& report) {
        Status status = detail::check_graph(graph, options.allow_negative, report);
        if (status != Status::ok) return status;
        for (std::size_t field = 0; field < fields.size(); field += size) {
            for (std::size_t node = 0; node < size; ++node) {
                if (given[node] == 0 || std::isfinite(fields[field + node])) continue;
                report.culprit = field + node;
                return Status::value_not_finite;
            }
        }
        detail::GraphEquations equations(graph, given);
        if (status = detail::prepare(equations, report); status != Status::ok) return status;
        const auto nodes = equations.nodes();
        if (nodes.empty()) return running.end(Status::ok);
        std::vector<T> solved(fields.size() / size * nodes.size());
        constexpr std::size_t most = 16; // fields per pass over the factors
        for (std::size_t begin = 0; begin < fields.size(); begin += most * size) {
            if (!running.keep_going(double(begin) / double(fields.size()))) return Status::cancelled;
            const std::size_t count = (std::min)(most, (fields.size() - begin) / size);
            std::vector<double> block(nodes.size() * count);
            equations.for_each_given_link([&](std::size_t row, std::uint32_t from, double k) {
                for (std::size_t f = 0; f < count; ++f)
                    block[row * count + f] += k * double(fields[begin + f * size + from]);
            });
            if (status = equations.solve(block, count); status != Status::ok) return status;
            for (std::size_t f = 0; f < count; ++f) {
                T* const out = &solved[(begin / size + f) * nodes.size()];
                for (std::size_t row = 0; row < nodes.size(); ++row) {
                    out[row] = static_cast<T>(block[row * count + f]);
                    if (!std::isfinite(out[row])) return Status::not_converged;
                }
            }
            report.solves += count;
        }
        if (!running.keep_going(1)) return Status::cancelled;
        for (std::size_t field = 0; field < fields.size() / size; ++field) {
            for (std::size_t row = 0; row < nodes.size(); ++row)
                fields[field * size + nodes[row]] = solved[field * nodes.size() + row];
        }
        return Status::ok;
    });
}

/// Computes the expected number of steps of a random walk from each node to the first given node. A step
/// follows a link with probability proportional to its conductance.
///
///   steps    #nodes, 0 at given nodes; written only if the status is ok
///   fails    as solve_graph; conductances must be positive
template <MutableScalarRange V>
Evaluation expected_steps(const Graph& graph, std::span<const std::uint8_t> given, V&& steps) {
    using T = detail::element_t<V>;
    const std::span<T> out(steps);
    CAGEFORM_ASSERT(given.size() == graph.nodes && out.size() == graph.nodes, "one mark and result per node");
    return detail::guarded_evaluation([&](SolverReport& report) {
        Status status = detail::check_graph(graph, false, report);
        if (status != Status::ok) return status;
        detail::GraphEquations equations(graph, given);
        if (status = detail::prepare(equations, report); status != Status::ok) return status;
        std::vector<double> solved(equations.nodes().size()); // the source: sum of conductances per node
        for (const GraphLink& link : graph.links) {
            for (const std::uint32_t end : {link.a, link.b}) {
                if (equations.row(end) >= 0) solved[std::size_t(equations.row(end))] += link.conductance;
            }
        }
        if (status = equations.solve(solved, 1); status != Status::ok) return status;
        for (const double value : solved) {
            if (!std::isfinite(static_cast<T>(value))) return Status::not_converged;
        }
        for (std::size_t node = 0; node < out.size(); ++node)
            out[node] =
                equations.row(node) < 0 ? T(0) : static_cast<T>(solved[std::size_t(equations.row(node))]);
        return Status::ok;
    });
}

/// Computes the probability that a random walk from node `from` reaches each given node first. The
/// probabilities sum to one. The matrix is symmetric, so one solve suffices: the probabilities are the
/// currents through the given nodes for a unit current into `from`.
///
///   probabilities  #nodes, 0 at unknown nodes; written only if the status is ok
///   fails          as expected_steps; index_out_of_range also for `from`
template <MutableScalarRange V>
Evaluation hit_first(const Graph& graph, std::span<const std::uint8_t> given, std::size_t from,
                     V&& probabilities) {
    using T = detail::element_t<V>;
    const std::span<T> out(probabilities);
    CAGEFORM_ASSERT(given.size() == graph.nodes && out.size() == graph.nodes, "one mark and result per node");
    return detail::guarded_evaluation([&](SolverReport& report) {
        if (from >= graph.nodes) return Status::index_out_of_range;
        Status status = detail::check_graph(graph, false, report);
        if (status != Status::ok) return status;
        detail::GraphEquations equations(graph, given);
        if (status = detail::prepare(equations, report); status != Status::ok) return status;
        std::vector<double> flow(graph.nodes);
        if (equations.row(from) < 0) {
            flow[from] = 1;
        } else {
            std::vector<double> potential(equations.nodes().size());
            potential[std::size_t(equations.row(from))] = 1;
            if (status = equations.solve(potential, 1); status != Status::ok) return status;
            equations.for_each_given_link(
                [&](std::size_t row, std::uint32_t to, double k) { flow[to] += k * potential[row]; });
        }
        for (const double value : flow) {
            if (!std::isfinite(value)) return Status::not_converged;
        }
        for (std::size_t node = 0; node < graph.nodes; ++node) out[node] = static_cast<T>(flow[node]);
        return Status::ok;
    });
}

} // namespace cageform::inline CAGEFORM_ABI

// Discrete harmonic functions on graphs, by sparse factorisation. Uses: number puzzles in which
// each number is the mean of its neighbours; networks of resistors; random walks. For large grids
// see fields/dirichlet.hpp. Not included by cageform.hpp.
#pragma once

#include <cageform/core/types/solver_report.hpp>
#include <cageform/core/view.hpp>
#include <cageform/fields/detail/graph_factors.hpp>
#include <cageform/grid/lattice/lattice.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

struct GraphLink {
    std::uint32_t a, b;
    double conductance;
};

/// A graph. Links may be given more than once; their conductances add up.
struct Graph {
    std::size_t nodes;
    std::span<const GraphLink> links;
};

struct GraphOptions {
    /// Allows negative conductances. Values may then leave the range of those given, and a unique
    /// solution may not exist.
    bool allow_negative = false;
};

/// The neighbours of a grid cell.
enum class Stencil : std::uint8_t {
    face, ///< cells that share a face: 2, 4, 6
    all,  ///< also cells that share a corner: 2, 8, 26
};

/// Returns links of conductance 1 between neighbouring cells of a grid with fewer than 2³² cells.
template <std::size_t D>
std::vector<GraphLink> grid_links(const CellBox<D>& cells, Stencil stencil) {
    std::size_t offsets = 1;
    for (std::size_t k = 0; k < D; ++k) offsets *= 3;
    std::vector<GraphLink> links;
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
        const auto index = cells.index(cell);
        // Visits the offsets after the central (zero) one, and so each pair of cells once.
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
            if (in_grid && (stencil == Stencil::all || moved == 1))
                links.push_back({std::uint32_t(cell), std::uint32_t(cells.number(other)), 1.0});
        }
    }
    return links;
}

namespace detail {

inline Status check_graph(const Graph& graph, bool allow_negative, SolverReport& report) {
    // The ordering stores links in both directions, and its own additions, with 32-bit indices.
    if (4 * (graph.nodes + graph.links.size()) > std::size_t((std::numeric_limits<std::int32_t>::max)()))
        return Status::out_of_memory;
    for (std::size_t n = 0; n < graph.links.size(); ++n) {
        const GraphLink& link = graph.links[n];
        report.culprit = n;
        if (link.a >= graph.nodes || link.b >= graph.nodes) return Status::index_out_of_range;
        if (link.a == link.b) return Status::input_malformed;
        if (!std::isfinite(link.conductance) || (link.conductance <= 0 && !allow_negative))
            return Status::weights_not_positive;
    }
    report.culprit = SolverReport::none;
    return Status::ok;
}

/// The equations of the unknown nodes of a checked graph, and their factors. The values of all
/// fields at a node are contiguous.
class GraphEquations {
public:
    static constexpr std::int32_t given_node = -1;

    GraphEquations(const Graph& graph, std::span<const std::uint8_t> given)
        : graph_(graph)
        , rows_(graph.nodes, given_node) {
        for (std::size_t node = 0; node < graph.nodes; ++node) {
            if (given[node] != 0) continue;
            rows_[node] = std::int32_t(nodes_.size());
            nodes_.push_back(node);
        }
    }

    std::span<const std::size_t> nodes() const noexcept { return nodes_; }
    std::int32_t row(std::size_t node) const noexcept { return rows_[node]; }
    std::size_t bytes() const noexcept { return factors_.bytes(); }

    /// Calls f(row of the unknown node, given node, conductance) for links between unknown and
    /// given nodes.
    template <class F>
    void for_each_given_link(const F& f) const {
        for (const GraphLink& link : graph_.links) {
            if (rows_[link.a] != given_node && rows_[link.b] == given_node)
                f(std::size_t(rows_[link.a]), link.b, link.conductance);
            if (rows_[link.b] != given_node && rows_[link.a] == given_node)
                f(std::size_t(rows_[link.b]), link.a, link.conductance);
        }
    }

    /// Returns the first node that no path connects to a given one, or `none`.
    std::size_t unreached() const {
        std::vector<std::uint32_t> parent(rows_.size());
        for (std::size_t node = 0; node < parent.size(); ++node) parent[node] = std::uint32_t(node);
        const auto root = [&](std::uint32_t node) {
            for (; parent[node] != node; node = parent[node]) parent[node] = parent[parent[node]];
            return node;
        };
        for (const GraphLink& link : graph_.links) {
            if (link.conductance != 0) parent[root(link.a)] = root(link.b);
        }
        std::vector<std::uint8_t> reached(rows_.size());
        for (std::uint32_t node = 0; node < rows_.size(); ++node) {
            if (rows_[node] == given_node) reached[root(node)] = 1;
        }
        for (const std::size_t node : nodes_) {
            if (reached[root(std::uint32_t(node))] == 0) return node;
        }
        return SolverReport::none;
    }

    /// Factorises the equations. Returns not_converged if the matrix is singular.
    Status factorise() {
        excess_.assign(nodes_.size(), {});
        for_each_given_link([&](std::size_t row, std::uint32_t, double k) {
            excess_[row].value += k;
            excess_[row].size += std::fabs(k);
        });
        links_.first.assign(nodes_.size() + 1, 0);
        const auto for_each_unknown = [&](const auto& f) {
            for (const GraphLink& link : graph_.links) {
                negative_ = negative_ || link.conductance < 0;
                if (rows_[link.a] == given_node || rows_[link.b] == given_node) continue;
                f(std::size_t(rows_[link.a]), std::uint32_t(rows_[link.b]), link.conductance);
                f(std::size_t(rows_[link.b]), std::uint32_t(rows_[link.a]), link.conductance);
            }
        };
        for_each_unknown([&](std::size_t row, std::uint32_t, double) { ++links_.first[row + 1]; });
        for (std::size_t row = 0; row < nodes_.size(); ++row) links_.first[row + 1] += links_.first[row];
        links_.node.resize(links_.first.back());
        links_.conductance.resize(links_.first.back());
        auto next = links_.first;
        for_each_unknown([&](std::size_t row, std::uint32_t other, double k) {
            links_.node[next[row]] = other;
            links_.conductance[next[row]++] = k;
        });
        return factors_.factorise(links_, excess_) ? Status::ok : Status::not_converged;
    }

    /// Solves for the fields whose sources are in `values`. With negative conductances pivots
    /// involve cancellation; then one step of iterative refinement follows, and a large correction
    /// means not_converged.
    Status solve(std::vector<double>& values, std::size_t fields) const {
        const std::vector<double> sources = negative_ ? values : std::vector<double>();
        factors_.solve(values, fields);
        if (negative_) {
            constexpr double most = 1e-6; // relative to the largest value
            std::vector<double> change = left(sources, values, fields);
            factors_.solve(change, fields);
            std::vector<double> size(fields), moved(fields);
            for (std::size_t i = 0; i < values.size(); ++i) {
                values[i] += change[i];
                size[i % fields] = std::fmax(size[i % fields], std::fabs(values[i]));
                moved[i % fields] = std::fmax(moved[i % fields], std::fabs(change[i]));
            }
            for (std::size_t f = 0; f < fields; ++f) {
                if (!(moved[f] <= most * size[f])) return Status::not_converged;
            }
        }
        return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); })
                   ? Status::ok
                   : Status::not_converged;
    }

private:
    /// Returns the residual: the sources minus the equations' left-hand side at `values`.
    std::vector<double> left(std::vector<double> sources, std::span<const double> values,
                             std::size_t fields) const {
        for (std::size_t row = 0; row < nodes_.size(); ++row) {
            for (std::size_t f = 0; f < fields; ++f) {
                const double here = values[row * fields + f];
                double& rest = sources[row * fields + f];
                rest -= excess_[row].value * here;
                for (std::size_t at = links_.first[row]; at < links_.first[row + 1]; ++at)
                    rest -= links_.conductance[at] * (here - values[links_.node[at] * fields + f]);
            }
        }
        return sources;
    }

    Graph graph_;
    std::vector<std::int32_t> rows_;
    std::vector<std::size_t> nodes_;
    Adjacency links_;                          // between unknown nodes
    std::vector<GraphFactors::Excess> excess_; // of the links to given nodes
    bool negative_ = false;
    GraphFactors factors_;
};

/// Checks and factorises the equations; returns ok also if nothing is unknown.
inline Status prepare(GraphEquations& equations, SolverReport& report) {
    report.cells = equations.nodes().size();
    report.culprit = equations.unreached();
    if (report.culprit != SolverReport::none) return Status::cells_unreached;
    if (equations.nodes().empty()) return Status::ok;
    const Status status = equations.factorise();
    report.bytes = equations.bytes();
    return status;
}

} // namespace detail

/// Solves for the unknown nodes c of any number of fields: Σ k_cd (u_c − u_d) = 0 over the links of
/// c.
///
///   given    #nodes; 0 where the value is unknown
///   values   fields of #nodes each, one after the other; given values are read, unknown ones
///            written, only when the status is ok
///   returns  values accurate to a few roundings of the largest given one, however far conductances
///            differ; with negative ones as accurate as double permits, within 1e-6 of the largest
///   cost     one factorisation, O(n^1.5) for planar graphs of n unknown nodes; 16 fields cost one
///            pass over the factors. Progress is reported before each
///   fails    index_out_of_range, input_malformed (a link from a node to itself) and
///            weights_not_positive (SolverReport::culprit is the link); value_not_finite (the index
///            in `values`); cells_unreached (the first unknown node without a path to a given one);
///            not_converged (a singular matrix, or values beyond T); cancelled; out_of_memory
template <MutableScalarRange V>
Evaluation solve_graph(const Graph& graph, std::span<const std::uint8_t> given, V&& values,
                       const GraphOptions& options = {}, const Running& running = {}) {
    using T = detail::element_t<V>;
    const std::span<T> fields(values);
    const std::size_t size = graph.nodes;
    CAGEFORM_ASSERT(given.size() == size && (size == 0 ? fields.empty() : fields.size() % size == 0),
                    "a mark for each node, and whole fields");
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
        status = detail::prepare(equations, report);
        if (status != Status::ok) return status;
        const auto nodes = equations.nodes();
        if (nodes.empty()) return running.end(Status::ok);
        std::vector<T> solved(fields.size() / size * nodes.size());
        constexpr std::size_t most = 16; // fields at a time: one pass over the factors serves all
        for (std::size_t begin = 0; begin < fields.size(); begin += most * size) {
            if (!running.keep_going(double(begin) / double(fields.size()))) return Status::cancelled;
            const std::size_t count = (std::min)(most, (fields.size() - begin) / size);
            std::vector<double> block(nodes.size() * count);
            equations.for_each_given_link([&](std::size_t row, std::uint32_t from, double k) {
                for (std::size_t f = 0; f < count; ++f)
                    block[row * count + f] += k * double(fields[begin + f * size + from]);
            });
            status = equations.solve(block, count);
            if (status != Status::ok) return status;
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

/// Finds the expected number of steps of a random walk from each node until it reaches a given one.
/// A step follows a link with probability proportional to its conductance.
///
///   steps    #nodes, 0 at given ones; written only when the status is ok
///   fails    as solve_graph; conductances must be positive
template <MutableScalarRange V>
Evaluation expected_steps(const Graph& graph, std::span<const std::uint8_t> given, V&& steps) {
    using T = detail::element_t<V>;
    const std::span<T> out(steps);
    CAGEFORM_ASSERT(given.size() == graph.nodes && out.size() == graph.nodes, "one of each a node");
    return detail::guarded_evaluation([&](SolverReport& report) {
        Status status = detail::check_graph(graph, false, report);
        if (status != Status::ok) return status;
        detail::GraphEquations equations(graph, given);
        status = detail::prepare(equations, report);
        if (status != Status::ok) return status;
        std::vector<double> solved(equations.nodes().size()); // the source: sum of conductances at each node
        for (const GraphLink& link : graph.links) {
            for (const std::uint32_t end : {link.a, link.b}) {
                if (equations.row(end) >= 0) solved[std::size_t(equations.row(end))] += link.conductance;
            }
        }
        status = equations.solve(solved, 1);
        if (status != Status::ok) return status;
        for (const double value : solved) {
            if (!std::isfinite(static_cast<T>(value))) return Status::not_converged;
        }
        for (std::size_t node = 0; node < out.size(); ++node)
            out[node] =
                equations.row(node) < 0 ? T(0) : static_cast<T>(solved[std::size_t(equations.row(node))]);
        return Status::ok;
    });
}

/// Finds the probability that a random walk from node `from` reaches each given node first. The
/// probabilities sum to one. Because the matrix is symmetric, one solve suffices: they are the
/// currents that leave through the given nodes if a unit current enters at `from`.
///
///   probabilities  #nodes, 0 at unknown ones; written only when the status is ok
///   fails          as expected_steps; index_out_of_range also for `from`
template <MutableScalarRange V>
Evaluation hit_first(const Graph& graph, std::span<const std::uint8_t> given, std::size_t from,
                     V&& probabilities) {
    using T = detail::element_t<V>;
    const std::span<T> out(probabilities);
    CAGEFORM_ASSERT(given.size() == graph.nodes && out.size() == graph.nodes, "one of each a node");
    return detail::guarded_evaluation([&](SolverReport& report) {
        if (from >= graph.nodes) return Status::index_out_of_range;
        Status status = detail::check_graph(graph, false, report);
        if (status != Status::ok) return status;
        detail::GraphEquations equations(graph, given);
        status = detail::prepare(equations, report);
        if (status != Status::ok) return status;
        std::vector<double> flow(graph.nodes);
        if (equations.row(from) < 0) {
            flow[from] = 1;
        } else {
            std::vector<double> potential(equations.nodes().size());
            potential[std::size_t(equations.row(from))] = 1;
            status = equations.solve(potential, 1);
            if (status != Status::ok) return status;
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

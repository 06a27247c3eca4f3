// Discrete harmonic functions on graphs, by Eigen's sparse factorisation: puzzles of numbers, each
// the mean of its neighbours; networks of resistors; random walks. For large grids see
// grid/dirichlet.hpp. Not part of cageform.hpp.
#pragma once

#include <cageform/grid/evaluation.hpp>
#include <cageform/grid/lattice.hpp>

#include <Eigen/SparseCholesky>

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

/// Links may be given more than once; their conductances add up.
struct Graph {
    std::size_t nodes;
    std::span<const GraphLink> links;
};

struct GraphOptions {
    /// Values may then leave the range of those given, and a unique solution may not exist.
    bool allow_negative = false;
};

/// The neighbours of a cell of a grid.
enum class Stencil : std::uint8_t {
    face, ///< those that share a face: 2, 4, 6
    all,  ///< those that share a corner, too: 2, 8, 26
};

/// Links of conductance 1 between the neighbours of a grid of fewer than 2³² cells.
template <std::size_t D>
std::vector<GraphLink> grid_links(const CellBox<D>& cells, Stencil stencil) {
    std::size_t offsets = 1;
    for (std::size_t k = 0; k < D; ++k) offsets *= 3;
    std::vector<GraphLink> links;
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
        const auto index = cells.index(cell);
        // The offsets after the middle one, which is no offset: each pair of cells once.
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
    if (graph.nodes > std::size_t(std::numeric_limits<std::int32_t>::max())) return Status::out_of_memory;
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

/// The equations of the unknown nodes of a checked graph, and their factors.
class GraphEquations {
public:
    using Vector = Eigen::VectorXd;
    static constexpr std::int32_t given_node = -1;

    GraphEquations(const Graph& graph, std::span<const std::uint8_t> given)
        : graph_(graph)
        , rows_(graph.nodes, given_node) {
        for (std::size_t node = 0; node < graph.nodes; ++node) {
            if (given[node] != 0) continue;
            rows_[node] = std::int32_t(nodes_.size());
            nodes_.push_back(node);
        }
        degrees_ = Vector::Zero(Eigen::Index(nodes_.size()));
        for (const GraphLink& link : graph.links) {
            for (const std::uint32_t end : {link.a, link.b}) {
                if (rows_[end] != given_node) degrees_[rows_[end]] += link.conductance;
            }
        }
    }

    std::span<const std::size_t> nodes() const noexcept { return nodes_; }
    const Vector& degrees() const noexcept { return degrees_; }
    std::int32_t row(std::size_t node) const noexcept { return rows_[node]; }

    /// The first of the nodes that no path leads from to a given one, or `none`.
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

    /// not_converged for a matrix that is singular to rounding.
    Status factorise() {
        std::vector<Eigen::Triplet<double>> entries;
        for (Eigen::Index row = 0; row < degrees_.size(); ++row)
            entries.emplace_back(row, row, degrees_[row]);
        double largest = 0;
        bool negative = false;
        for (const GraphLink& link : graph_.links) {
            largest = std::fmax(largest, std::fabs(link.conductance));
            negative = negative || link.conductance < 0;
            if (rows_[link.a] == given_node || rows_[link.b] == given_node) continue;
            entries.emplace_back(rows_[link.a], rows_[link.b], -link.conductance);
            entries.emplace_back(rows_[link.b], rows_[link.a], -link.conductance);
        }
        Eigen::SparseMatrix<double> matrix(degrees_.size(), degrees_.size());
        matrix.setFromTriplets(entries.begin(), entries.end());
        factors_.compute(matrix);
        if (factors_.info() != Eigen::Success) return Status::not_converged;
        // Positive conductances may be small beside others. With negative ones a small pivot is
        // what cancellation leaves.
        const double least = negative ? 0x1p-40 * largest : 0.0;
        for (const double pivot : factors_.vectorD()) {
            if (!(std::fabs(pivot) > least) || !std::isfinite(pivot)) return Status::not_converged;
        }
        return Status::ok;
    }

    Vector solve(const Vector& source) const { return factors_.solve(source); }

private:
    Graph graph_;
    std::vector<std::int32_t> rows_;
    std::vector<std::size_t> nodes_;
    Vector degrees_;
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors_;
};

/// Checks and factorises; ok also where nothing is unknown.
inline Status prepare(GraphEquations& equations, SolverReport& report) {
    report.cells = equations.nodes().size();
    report.culprit = equations.unreached();
    if (report.culprit != SolverReport::none) return Status::cells_unreached;
    return equations.nodes().empty() ? Status::ok : equations.factorise();
}

} // namespace detail

/// Fills in the unknown nodes c of any number of fields: Σ k_cd (u_c − u_d) = 0 over the links of c.
///
///   given    #nodes; 0 where the value is unknown
///   values   fields of #nodes each, one after the other; given values are read, unknown ones are
///            written when the status is ok, and not before
///   cost     one factorisation, O(n^1.5) for planar graphs of n unknown nodes; a field costs one
///            pass over the factors. The progress is asked before each field
///   fails    index_out_of_range, input_malformed (a link from a node to itself) and
///            weights_not_positive (SolverReport::culprit is the link); value_not_finite (the place
///            in `values`); cells_unreached (the first unknown node without a path to a given one);
///            not_converged (a singular matrix, or values beyond T); cancelled; out_of_memory
template <Scalar T>
Evaluation solve_graph(const Graph& graph, std::span<const std::uint8_t> given, std::span<T> values,
                       const GraphOptions& options = {}, const Running& running = {}) {
    const std::size_t size = graph.nodes;
    CAGEFORM_ASSERT(given.size() == size && (size == 0 ? values.empty() : values.size() % size == 0),
                    "a mark for each node, and whole fields");
    return detail::guarded_evaluation([&](SolverReport& report) {
        Status status = detail::check_graph(graph, options.allow_negative, report);
        if (status != Status::ok) return status;
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (given[i % size] == 0 || std::isfinite(values[i])) continue;
            report.culprit = i;
            return Status::value_not_finite;
        }
        detail::GraphEquations equations(graph, given);
        status = detail::prepare(equations, report);
        if (status != Status::ok || equations.nodes().empty()) return status;
        const auto nodes = equations.nodes();
        std::vector<T> solved;
        for (std::size_t field = 0; field < values.size(); field += size) {
            if (!running.keep_going(double(field) / double(values.size()))) return Status::cancelled;
            Eigen::VectorXd source = Eigen::VectorXd::Zero(Eigen::Index(nodes.size()));
            const auto add = [&](std::uint32_t to, std::uint32_t from, double conductance) {
                if (equations.row(to) >= 0 && equations.row(from) < 0)
                    source[equations.row(to)] += conductance * double(values[field + from]);
            };
            for (const GraphLink& link : graph.links) {
                add(link.a, link.b, link.conductance);
                add(link.b, link.a, link.conductance);
            }
            for (const double value : equations.solve(source)) {
                solved.push_back(static_cast<T>(value));
                if (!std::isfinite(solved.back())) return Status::not_converged;
            }
            ++report.solves;
        }
        for (std::size_t i = 0; i < solved.size(); ++i)
            values[i / nodes.size() * size + nodes[i % nodes.size()]] = solved[i];
        return Status::ok;
    });
}

/// The expected number of steps of a random walk from each node until it is at a given one, where a
/// step takes a link with a probability proportional to its conductance.
///
///   steps    #nodes, 0 at given ones; written when the status is ok, and not before
///   fails    as solve_graph; conductances are positive
template <Scalar T>
Evaluation expected_steps(const Graph& graph, std::span<const std::uint8_t> given, std::span<T> steps) {
    CAGEFORM_ASSERT(given.size() == graph.nodes && steps.size() == graph.nodes, "one of each a node");
    return detail::guarded_evaluation([&](SolverReport& report) {
        Status status = detail::check_graph(graph, false, report);
        if (status != Status::ok) return status;
        detail::GraphEquations equations(graph, given);
        status = detail::prepare(equations, report);
        if (status != Status::ok) return status;
        Eigen::VectorXd solved(0);
        if (!equations.nodes().empty()) solved = equations.solve(equations.degrees());
        for (const double value : solved) {
            if (!std::isfinite(static_cast<T>(value))) return Status::not_converged;
        }
        for (std::size_t node = 0; node < steps.size(); ++node)
            steps[node] = equations.row(node) < 0 ? T(0) : static_cast<T>(solved[equations.row(node)]);
        return Status::ok;
    });
}

/// The probability with which a random walk from node `from` meets each given node first. They sum
/// to one. One solve, since the matrix is symmetric: what flows out where a unit flows in.
///
///   probabilities  #nodes, 0 at unknown ones; written when the status is ok, and not before
///   fails          as expected_steps; index_out_of_range also for `from`
template <Scalar T>
Evaluation hit_first(const Graph& graph, std::span<const std::uint8_t> given, std::size_t from,
                     std::span<T> probabilities) {
    CAGEFORM_ASSERT(given.size() == graph.nodes && probabilities.size() == graph.nodes, "one of each a node");
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
            Eigen::VectorXd source = Eigen::VectorXd::Zero(Eigen::Index(equations.nodes().size()));
            source[equations.row(from)] = 1;
            const Eigen::VectorXd potential = equations.solve(source);
            const auto add = [&](std::uint32_t to, std::uint32_t at, double conductance) {
                if (equations.row(to) < 0 && equations.row(at) >= 0)
                    flow[to] += conductance * potential[equations.row(at)];
            };
            for (const GraphLink& link : graph.links) {
                add(link.a, link.b, link.conductance);
                add(link.b, link.a, link.conductance);
            }
        }
        for (const double value : flow) {
            if (!std::isfinite(value)) return Status::not_converged;
        }
        for (std::size_t node = 0; node < graph.nodes; ++node)
            probabilities[node] = static_cast<T>(flow[node]);
        return Status::ok;
    });
}

} // namespace cageform::inline CAGEFORM_ABI

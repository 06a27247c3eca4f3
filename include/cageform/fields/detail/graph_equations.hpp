// Checks a graph, and solves the equations of its unknown nodes.
#pragma once

#include <cageform/core/detail/disjoint_sets.hpp>
#include <cageform/fields/detail/graph_factors.hpp>
#include <cageform/fields/types/graph.hpp>
#include <cageform/grid/types/solver_report.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

inline Status check_graph(const Graph& graph, bool allow_negative, SolverReport& report) {
    // The ordering stores links in both directions, and additional entries, with 32-bit indices.
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

/// The equations of the unknown nodes of a valid graph, and their factors. The values of all fields at a
/// node are contiguous.
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

    /// Calls f(row of the unknown node, given node, conductance) for links between unknown and given nodes.
    template <class F>
    void for_each_given_link(const F& f) const {
        for (const GraphLink& link : graph_.links) {
            if (rows_[link.a] != given_node && rows_[link.b] == given_node)
                f(std::size_t(rows_[link.a]), link.b, link.conductance);
            if (rows_[link.b] != given_node && rows_[link.a] == given_node)
                f(std::size_t(rows_[link.b]), link.a, link.conductance);
        }
    }

    /// Returns the first node without a path to a given node, or SolverReport::none.
    std::size_t unreached() const {
        DisjointSets components(rows_.size());
        for (const GraphLink& link : graph_.links) {
            if (link.conductance != 0) components.join(link.a, link.b);
        }
        std::vector<std::uint8_t> reached(rows_.size());
        for (std::uint32_t node = 0; node < rows_.size(); ++node) {
            if (rows_[node] == given_node) reached[components.find(node)] = 1;
        }
        for (const std::size_t node : nodes_) {
            if (reached[components.find(std::uint32_t(node))] == 0) return node;
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

    /// Solves for the fields with sources in `values`. Negative conductances cause cancellation in pivots.
    /// One step of iterative refinement then follows, and a large correction gives not_converged.
    Status solve(std::vector<double>& values, std::size_t fields) const {
        const std::vector<double> sources = negative_ ? values : std::vector<double>();
        factors_.solve(values, fields);
        if (negative_) {
            constexpr double most = 1e-6; // relative to the largest value
            std::vector<double> change = residual(sources, values, fields);
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
    /// Returns the sources minus the left-hand side of the equations at `values`.
    std::vector<double> residual(std::vector<double> sources, std::span<const double> values,
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
    Adjacency links_;                          ///< links between unknown nodes
    std::vector<GraphFactors::Excess> excess_; ///< per row, sum over the links to given nodes
    bool negative_ = false;
    GraphFactors factors_;
};

/// Checks and factorises the equations; returns ok if no node is unknown.
inline Status prepare(GraphEquations& equations, SolverReport& report) {
    report.cells = equations.nodes().size();
    report.culprit = equations.unreached();
    if (report.culprit != SolverReport::none) return Status::cells_unreached;
    if (equations.nodes().empty()) return Status::ok;
    const Status status = equations.factorise();
    report.bytes = equations.bytes();
    return status;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// The discretisation of the Laplace equation on the tree: one row of a sparse matrix per node.
//
// Every row has the form diagonal · u(node) − Σ weight · u(neighbour) = Σ weight · (boundary value) with
// positive weights. The diagonal is their sum plus NodeEquation::screening. The corrections of a near field
// are an exception: they also add negative weights of boundary values (coordinates/harmonic/near_rows.hpp).
// The matrix is not symmetric: if the equation of node a contains node b, the equation of b need not contain
// a.
// grid/tree/node_equation.hpp has the formulas, grid/tree/hierarchy.hpp makes coarser levels from these rows,
// and grid/tree/multigrid.hpp solves them.
#pragma once

#include <cageform/grid/tree/level_rows.hpp>
#include <cageform/grid/tree/node_equation.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// One entry of the right-hand side: the weight of a handle's boundary value in a node's equation.
struct TreeData {
    std::uint32_t handle, node;
    float weight;
};

/// The equations of all nodes, each multiplied by the volume around its node.
struct TreeLinks {
    detail::TreeEquations equations;
    Buffer<TreeData> data;  ///< sorted by handle, then by node
    Buffer<float> volume;   ///< per node: the product over the axes of the mean link length
    double least_share = 1; ///< the smallest factor of a second difference (shares_of_axes)
    /// Per node: the factor g of the unknown v in u = g v; empty: 1 (detail::scale_by_decay).
    Buffer<float> decay;

    void append(const TreeLinks& other) {
        equations.append(other.equations);
        data.append(other.data.begin(), other.data.end());
        volume.append(other.volume.begin(), other.volume.end());
        least_share = (std::min)(least_share, other.least_share);
    }
};

} // namespace grid

namespace detail {

/// Appends the row of a node to the equations. `data` as for links_of.
template <std::size_t D, class Data>
void append_row(const NodeEquation<D>& equation, const Data& data, grid::TreeLinks& out) {
    auto& [neighbours, diagonals] = out.equations;
    double diagonal = equation.screening;
    for (const auto& term : equation.terms) {
        if (term.node != grid::TreeNodes<D>::none) {
            neighbours.entries.push_back({term.node, float(term.weight)});
            continue;
        }
        data.for_each_weight(term.value, [&](std::uint32_t handle, double of_handle) {
            const auto amount = float(term.weight * of_handle);
            if (!(amount > 0)) return;
            out.data.push_back({handle, equation.node, amount});
            diagonal += double(amount);
        });
    }
    neighbours.end_row();
    const auto row = neighbours.of(neighbours.rows() - 1);
    std::sort(row.begin(), row.end(), [](const auto& a, const auto& b) { return a.column < b.column; });
    for (const auto& entry : row) diagonal += double(entry.weight);
    diagonals.push_back(diagonal);
    out.volume.push_back(float(equation.volume));
    out.least_share = (std::min)(out.least_share, equation.least_share);
}

/// Equations without corrections.
struct NoCorrections {
    template <std::size_t D>
    void add(const NodeEquation<D>&, grid::TreeLinks&) const noexcept {}
    void finish(grid::TreeLinks&) const noexcept {}
};

/// Sorts data by handle, then by node.
inline void sort_data(Buffer<grid::TreeData>& data) {
    std::uint32_t handles = 0;
    for (const auto& entry : data) handles = (std::max)(handles, entry.handle + 1);
    Buffer<std::size_t> ends(std::size_t{handles} + 1, 0);
    for (const auto& entry : data) ++ends[entry.handle + 1];
    for (std::size_t h = 0; h < handles; ++h) ends[h + 1] += ends[h];
    Buffer<grid::TreeData> sorted;
    sorted.resize(data.size());
    for (const auto& entry : data) sorted[ends[entry.handle]++] = entry;
    for (std::size_t h = 0; h < handles; ++h) {
        std::sort(sorted.data() + (h == 0 ? 0 : ends[h - 1]), sorted.data() + ends[h],
                  [](const auto& a, const auto& b) { return a.node < b.node; });
    }
    data = std::move(sorted);
}

/// Replaces the unknowns u of a screened equation by v = u/g, g = e^(−κd). d is the distance of a node from
/// the nearest node with data, along links. The sum of all functions u decreases about like g, so the sum of
/// all v is of the order of 1: limits of errors of v are relative to u. Rows are multiplied by g too.
///
///   rate  κ, in units of the tree
template <std::size_t D>
void scale_by_decay(double rate, const grid::TreeNodes<D>& nodes, grid::TreeLinks& links) {
    detail::LevelRows& neighbours = links.equations.neighbours;
    const std::size_t count = links.equations.diagonal.size();
    Buffer<float> distance(count, (std::numeric_limits<float>::max)());
    for (const auto& entry : links.data) distance[entry.node] = 0;
    bool changes = true;
    const auto update = [&](std::uint32_t n) {
        const auto here = node_position<D>(nodes.index(n));
        for (const auto& entry : neighbours.of(n)) {
            const auto there = node_position<D>(nodes.index(entry.column));
            const float to = distance[entry.column] + float(length(there - here));
            if (!(to < distance[n])) continue;
            distance[n] = to;
            changes = true;
        }
    };
    while (changes) { // Morton order has near nodes close together, so that a few sweeps suffice
        changes = false;
        for (std::uint32_t n = 0; n < count; ++n) update(n);
        for (auto n = std::uint32_t(count); n-- > 0;) update(n);
    }
    constexpr double least = 1e-12; // products of two factors times weights are normal floats
    links.decay.reserve(count);
    for (const float d : distance)
        links.decay.push_back(float((std::max)(std::exp(-rate * double(d)), least)));
    for (std::uint32_t n = 0; n < count; ++n) {
        const auto g = double(links.decay[n]);
        links.equations.diagonal[n] *= g * g;
        for (auto& entry : neighbours.of(n))
            entry.weight = float(g * double(links.decay[entry.column]) * double(entry.weight));
    }
    for (auto& entry : links.data) entry.weight *= links.decay[entry.node];
}

} // namespace detail
namespace grid {

/// Returns the equations of all nodes.
///
///   data         data.for_each_weight(value, f) calls f(handle, weight) for every handle with non-zero
///                weight at a point of the boundary; weights must not be negative
///   corrections  changes equations next to the boundary (detail::NearCorrections). Each call of
///                the loop's body has a copy. add(equation, out) is called before the row of a node is
///                appended to `out`, and finish(out) after the last row of a run of nodes
template <std::size_t D, class Data = detail::LinearBoundaryData<D>,
          class Corrections = detail::NoCorrections>
TreeLinks links_of(const CutTree<D>& tree, const TreeNodes<D>& nodes, const Data& data = {},
                   const Corrections& corrections = {}, const Running& running = {}) {
    TreeLinks links = detail::joined_runs<TreeLinks>(running, nodes.count(), 2048, [&] {
        return [&data, corrections = Corrections(corrections),
                equation = detail::NodeEquationMaker<D>(tree, nodes)](std::size_t begin, std::size_t end,
                                                                      TreeLinks& out) mutable {
            for (std::size_t node = begin; node < end; ++node) {
                const auto& of_node = equation(std::uint32_t(node));
                corrections.add(of_node, out);
                detail::append_row(of_node, data, out);
            }
            corrections.finish(out);
        };
    });
    detail::sort_data(links.data);
    links.equations.neighbours.shrink_to_fit();
    if (tree.screening() > 0) detail::scale_by_decay(std::sqrt(tree.screening()), nodes, links);
    return links;
}

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI

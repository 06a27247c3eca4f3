// The interface of a boundary on a grid, for embedding and sampling.
#pragma once

#include <cageform/cage/types/boundary_value.hpp>
#include <cageform/core/status.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/lattice/cut_stencil.hpp>
#include <cageform/grid/lattice/lattice.hpp>
#include <cageform/grid/lattice/node_runs.hpp>

#include <concepts>
#include <optional>
#include <span>

namespace cageform::inline CAGEFORM_ABI::grid {

/// A point where a lattice line meets the boundary, in units of the lattice: node i of an axis is at i.
template <std::size_t D>
struct Crossing {
    std::uint32_t line; ///< index of the line (CellBox::line)
    bool separates;     ///< whether inside and outside change here; false where the line only touches
    double position;    ///< along the line
    BoundaryValue<D> value;
    bool from_below = true, from_above = true; ///< whether the value applies to links from that side
};

/// The crossings along each axis, sorted by line and position.
template <std::size_t D>
using Crossings = std::array<Buffer<Crossing<D>>, D>;

template <std::size_t D>
void sort_along_lines(Buffer<Crossing<D>>& crossings) {
    std::sort(crossings.begin(), crossings.end(), [](const Crossing<D>& a, const Crossing<D>& b) {
        return a.line != b.line ? a.line < b.line : a.position < b.position;
    });
}

/// A node closer to a crossing than this (in spacings) is on the boundary and not an unknown.
inline constexpr double on_boundary_distance = 1e-9;

template <std::size_t D>
struct FixedNode {
    typename NodeRuns<D>::Index index;
    BoundaryValue<D> value;
};

/// A boundary that `embed` can place on a lattice. All positions and distances are in units of the lattice.
///
///   lattice()        has a node for each of its cells, the first at its origin
///   crossings()      the crossings with the lattice lines, sorted; on every line an even number of them
///                    has `separates` set
///   nearest(node)    the data of the boundary point nearest to a node
///   fixed_nodes()    nodes that are not unknowns, each at most once, in any order; a vector or buffer
///   too_thin_bone()  a handle of a bone for which the lattice is too coarse
template <class B>
concept EmbeddableBoundary = requires(const B& boundary, const typename NodeRuns<B::dimension>::Index& node) {
    { boundary.lattice() } -> std::convertible_to<const Lattice<double, B::dimension>&>;
    { boundary.crossings() } -> std::same_as<Crossings<B::dimension>>;
    { boundary.nearest(node) } -> std::same_as<BoundaryValue<B::dimension>>;
    { boundary.fixed_nodes() } -> std::convertible_to<std::span<const FixedNode<B::dimension>>>;
    { boundary.too_thin_bone() } -> std::same_as<std::optional<std::uint32_t>>;
};

template <std::size_t D>
struct Located {
    PointState state;       ///< inside, outside, on_boundary
    BoundaryValue<D> value; ///< the boundary data there if the point is on the boundary
};

/// A boundary that supports sampling between the nodes, in units of the lattice.
///
///   index_cells(slack)                  prepares the other functions; cells within `slack` of the boundary
///                                       are cut
///   locate(p, tolerance, nodes)         the location of a point of the lattice: on the boundary within the
///                                       tolerance; nullopt if the boundary in its cell does not decide
///                                       whether it is inside
///   sample(p, nodes)                    the stencil of a point strictly inside, exact for linear functions
///   free_distance(p, axis, up, limit)   the distance from `p` along an axis to the boundary, at most `limit`
template <class B>
concept SampledBoundary = requires(B& prepared, const B& boundary, const Vec<double, B::dimension>& p,
                                   const NodeRuns<B::dimension>& nodes, double length) {
    prepared.index_cells(length);
    { boundary.locate(p, length, nodes) } -> std::same_as<std::optional<Located<B::dimension>>>;
    { boundary.sample(p, nodes) } -> std::same_as<CutStencil<B::dimension>>;
    { boundary.free_distance(p, std::size_t{0}, true, length) } -> std::same_as<double>;
};

} // namespace cageform::inline CAGEFORM_ABI::grid

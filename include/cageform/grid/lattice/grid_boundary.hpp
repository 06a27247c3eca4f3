// What a boundary has to tell, so that a problem can be laid into a lattice and be sampled between
// the nodes.
//
// A boundary of another kind is a class in a file of its own and a specialisation of GridBoundaryOf
// for its cages.
#pragma once

#include <cageform/cage/detail/boundary_value.hpp>
#include <cageform/core/detail/buffer.hpp>
#include <cageform/core/status.hpp>
#include <cageform/grid/lattice.hpp>
#include <cageform/grid/lattice/cut_stencil.hpp>
#include <cageform/grid/lattice/node_runs.hpp>

#include <concepts>
#include <optional>
#include <span>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// A lattice line meets the boundary. In units of the lattice: node i of an axis lies at i.
template <std::size_t D>
struct Crossing {
    std::uint32_t line; ///< its number, see CellBox::line
    bool turns;         ///< inside and outside change here (not where the line only touches)
    double position;    ///< along the line
    BoundaryValue<D> value;
    bool from_below = true, from_above = true; ///< the value is that of links from below, from above
};

/// Crossings along each axis, sorted by line and position.
template <std::size_t D>
using Crossings = std::array<Buffer<Crossing<D>>, D>;

template <std::size_t D>
void sort_along_lines(Buffer<Crossing<D>>& crossings) {
    std::sort(crossings.begin(), crossings.end(), [](const Crossing<D>& a, const Crossing<D>& b) {
        return a.line != b.line ? a.line < b.line : a.position < b.position;
    });
}

/// A node nearer to a crossing than this (in spacings) is on the boundary and no unknown.
inline constexpr double on_boundary_distance = 1e-9;

/// A node whose value is given.
template <std::size_t D>
struct FixedNode {
    typename NodeRuns<D>::Index index;
    BoundaryValue<D> value;
};

/// A boundary that `embed` can lay into a lattice. All positions and distances are in units of the
/// lattice.
///
///   lattice()        its cells are the nodes along each axis, the first at its origin
///   crossings()      with the lattice lines, sorted; along every line an even number of them turns
///   nearest(node)    the data of the boundary place nearest to a node
///   fixed_nodes()    nodes that are no unknowns, each at most once, in any order; a vector or buffer
///   too_thin_bone()  a handle that the lattice is too coarse for, whatever its crossings say
template <class B>
concept EmbeddableBoundary = requires(const B& boundary, const typename NodeRuns<B::dimension>::Index& node) {
    { boundary.lattice() } -> std::convertible_to<const Lattice<double, B::dimension>&>;
    { boundary.crossings() } -> std::same_as<Crossings<B::dimension>>;
    { boundary.nearest(node) } -> std::same_as<BoundaryValue<B::dimension>>;
    { boundary.fixed_nodes() } -> std::convertible_to<std::span<const FixedNode<B::dimension>>>;
    { boundary.too_thin_bone() } -> std::same_as<std::optional<std::uint32_t>>;
};

/// Where a place lies.
template <std::size_t D>
struct Located {
    PointState state;       ///< inside, outside, on_boundary
    BoundaryValue<D> value; ///< there, if it is on the boundary
};

/// A boundary up to which values between the nodes can be read. In units of the lattice.
///
///   index_cells(slack)  prepares the others; what comes as near to the boundary as `slack` is cut
///   locate(p, tolerance, nodes)
///                       where a place of the lattice lies, on the boundary if that is no farther
///                       than the tolerance; none where what passes its cell does not tell
///   sample(p, nodes)    the stencil of a place strictly inside, exact for linear functions
///   free_distance(p, axis, up, limit)
///                       from `p`, a place of the lattice, along an axis, up or down, to the
///                       boundary; at most `limit`
template <class B>
concept SampledBoundary = requires(B& prepared, const B& boundary, const Vec<double, B::dimension>& p,
                                   const NodeRuns<B::dimension>& nodes, double length) {
    prepared.index_cells(length);
    { boundary.locate(p, length, nodes) } -> std::same_as<std::optional<Located<B::dimension>>>;
    { boundary.sample(p, nodes) } -> std::same_as<CutStencil<B::dimension>>;
    { boundary.free_distance(p, std::size_t{0}, true, length) } -> std::same_as<double>;
};

/// All that a solver on a grid asks of a boundary.
template <class B>
concept GridBoundary = EmbeddableBoundary<B> && SampledBoundary<B>;

/// `type` is what a kind of cage is on a lattice, made from the cage and the lattice; left out for
/// other types.
template <class Cage>
struct GridBoundaryOf;

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI

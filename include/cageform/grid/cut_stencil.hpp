// Values between nodes, right up to a boundary that passes between them.
#pragma once

#include <cageform/cage/boundary_value.hpp>
#include <cageform/grid/node_runs.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The value at a point as a mean of values at nodes and on the boundary; serves any number of fields.
template <std::size_t D>
struct CutStencil {
    struct Node {
        std::uint32_t node;
        double share;
    };
    struct Place { ///< on the boundary
        BoundaryValue<D> value;
        double share;
    };
    static constexpr std::size_t most_nodes = std::size_t{1} << D;

    std::array<Node, most_nodes> nodes;
    std::array<Place, D * most_nodes> places; ///< as many as D orders of the axes can meet
    std::uint32_t node_count = 0, place_count = 0;

    void add(std::uint32_t node, double share) noexcept {
        for (std::uint32_t n = 0; n < node_count; ++n) {
            if (nodes[n].node != node) continue;
            nodes[n].share += share;
            return;
        }
        nodes[node_count++] = {node, share};
    }
    void add(const BoundaryValue<D>& value, double share) noexcept { places[place_count++] = {value, share}; }
};

/// Adds to a stencil what a point inside is a mean of: linear along one axis of its cell after the other, and where the
/// boundary lies before the cell's end on that way, its value there in the stead of what lies beyond.
///
///   p        in units of the lattice; low, the lower corner of its cell
///   order    of the axes; `step` axes are done
///   share    of the whole
///   cast     cast(p, axis, end, position, value): whether the boundary lies between p and `end` along an axis; where, and
///            its data there
///   nearest  nearest(index): the data nearest to a node that is no unknown, hence on the boundary up to rounding
template <std::size_t D, class Cast, class Nearest>
void gather_cut(CutStencil<D>& stencil, const Vec<double, D>& p, const std::array<std::int32_t, D>& low,
                const std::array<std::size_t, D>& order, std::size_t step, double share,
                const NodeRuns<D>& nodes, const Cast& cast, const Nearest& nearest) noexcept {
    if (step == D) {
        typename NodeRuns<D>::Index index;
        for (std::size_t k = 0; k < D; ++k) index[k] = std::int32_t(p[k]);
        const auto node = nodes.find(index);
        if (node != NodeRuns<D>::none) {
            stencil.add(node, share);
        } else {
            stencil.add(nearest(index), share);
        }
        return;
    }
    const std::size_t axis = order[step];
    double begin = low[axis], end = low[axis] + 1;
    BoundaryValue<D> at_begin, at_end;
    const bool cut_begin = cast(p, axis, begin, begin, at_begin);
    const bool cut_end = cast(p, axis, end, end, at_end);
    const double length = end - begin;
    const double at = length > 0 ? (p[axis] - begin) / length : 0.0;
    const auto take = [&](bool cut, double place, const BoundaryValue<D>& value, double part) {
        if (!(part > 0)) return;
        if (cut) {
            stencil.add(value, part);
            return;
        }
        auto q = p;
        q[axis] = place;
        gather_cut<D>(stencil, q, low, order, step + 1, part, nodes, cast, nearest);
    };
    take(cut_begin, begin, at_begin, share * (1 - at));
    take(cut_end, end, at_end, share * at);
}

} // namespace cageform::inline CAGEFORM_ABI

// Interpolation inside a leaf, up to the boundary that cuts it. It is used for the ghost values at hanging
// nodes (grid/tree/node_equation.hpp), the prolongation between levels (grid/tree/hierarchy.hpp), and samples
// without blended models (coordinates/harmonic/leaf_models.hpp).
#pragma once

#include <cageform/grid/tree/nodes.hpp>

namespace cageform::inline CAGEFORM_ABI {
namespace detail {

/// Interpolates at a point of a cell: without facets, multilinearly between the corners. In a cell with
/// facets it interpolates linearly along one axis after the other. A segment ends on the boundary if the
/// boundary is nearer than the rim of the cell. The result is the mean over the cyclic orders of the axes
/// along which the point lies strictly inside the cell. It never exceeds the interpolated values, and is
/// exact for linear functions. On the rim of a cell it depends only on values on the rim, so neighbouring
/// cells agree.
///
///   sink  sink.at_node(index, share) for a corner inside, sink.at_boundary(value, point, share) for a
///         point on the boundary
template <std::size_t D, class Sink>
class LeafGather {
public:
    using Cell = typename grid::CellTree<D>::Cell;
    using Index = typename grid::CellTree<D>::Index;

    LeafGather(const grid::TreeBoundary<D>& boundary, const grid::TreeNodes<D>& nodes, Sink& sink)
        : boundary_(boundary)
        , nodes_(nodes)
        , sink_(sink) {}

    /// Interpolates at a point of the closed cell, which must be inside and not on a facet.
    ///
    ///   facets  those that intersect the cell
    void gather(const Cell& cell, std::span<const std::uint32_t> facets, Vec<double, D> p) {
        cell_ = cell;
        facets_ = facets;
        std::array<std::size_t, D> free{};
        std::size_t count = 0;
        for (std::size_t k = 0; k < D; ++k) {
            const double low = cell.low[k], high = low + cell.size;
            p[k] = std::clamp(p[k], low, high);
            if (p[k] > low && p[k] < high) free[count++] = k;
        }
        if (facets.empty() || count == 0) {
            along(p, 1, std::span(free).first(count));
            return;
        }
        std::array<std::size_t, D> order{};
        for (std::size_t first = 0; first < count; ++first) {
            for (std::size_t k = 0; k < count; ++k) order[k] = free[(first + k) % count];
            along(p, 1.0 / double(count), std::span(order).first(count));
        }
    }

private:
    /// Interpolates along the first of the remaining axes, between the ends of the segment through p.
    void along(const Vec<double, D>& p, double share, std::span<const std::size_t> axes) {
        if (axes.empty()) {
            at_corner(p, share);
            return;
        }
        const std::size_t axis = axes.front();
        const double low = cell_.low[axis], high = low + cell_.size;
        std::optional<grid::Hit<D>> below, above;
        if (!facets_.empty()) {
            below = boundary_.first_hit(facets_, {p, axis, false, p[axis] - low});
            above = boundary_.first_hit(facets_, {p, axis, true, high - p[axis]});
        }
        const double begin = below ? below->position : low, end = above ? above->position : high;
        const double at = end > begin ? (p[axis] - begin) / (end - begin) : 0.0;
        const auto take = [&](const std::optional<grid::Hit<D>>& hit, double position, double weight) {
            if (!(weight > 0)) return;
            auto q = p;
            q[axis] = position;
            if (hit) {
                sink_.at_boundary(hit->value, q, weight);
            } else {
                along(q, weight, axes.subspan(1));
            }
        };
        take(below, begin, share * (1 - at));
        take(above, end, share * at);
    }
    void at_corner(const Vec<double, D>& p, double share) {
        Index index{};
        for (std::size_t k = 0; k < D; ++k) index[k] = std::int32_t(p[k]);
        if (nodes_.find(index) != grid::TreeNodes<D>::none) {
            sink_.at_node(index, share);
        } else { // a corner that is not a node lies on the boundary, up to rounding
            sink_.at_boundary(boundary_.nearest(facets_, p).value, p, share);
        }
    }

    const grid::TreeBoundary<D>& boundary_;
    const grid::TreeNodes<D>& nodes_;
    Sink& sink_;
    Cell cell_{};
    std::span<const std::uint32_t> facets_;
};

} // namespace detail
namespace grid {

/// A sink of LeafGather that collects the value as a stencil.
template <std::size_t D>
struct StencilSink {
    const TreeNodes<D>& nodes;
    CutStencil<D>& stencil;

    void at_node(const typename TreeNodes<D>::Index& index, double share) {
        stencil.add(nodes.find(index), share);
    }
    void at_boundary(const BoundaryValue<D>& value, const Vec<double, D>& /*position*/, double share) {
        stencil.add(value, share);
    }
};

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI

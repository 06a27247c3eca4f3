// A stencil that gives the value at a point from nodes and boundary values, and the rays that find
// its ends.
#pragma once

#include <cageform/cage/types/boundary_value.hpp>
#include <cageform/grid/lattice/lattice.hpp>
#include <cageform/grid/lattice/node_runs.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// The value at a point as a weighted sum of values at nodes and on the boundary. Serves any number
/// of fields.
template <std::size_t D>
struct CutStencil {
    struct Node {
        std::uint32_t node;
        double share;
    };
    struct BoundaryPoint { ///< a point on the boundary
        BoundaryValue<D> value;
        double share;
    };
    static constexpr std::size_t corners = std::size_t{1} << D; ///< of a cell
    /// Enough for the boundary points that D orders of the axes can meet, in the plane also for a
    /// harmonic mean (grid/tree/harmonic_mean.hpp), plus the nearest point of the boundary.
    static constexpr std::size_t most_nodes = D == 2 ? 32 : corners,
                                 most_boundary_points = 1 + (D == 2 ? 32 : D * corners);

    std::array<Node, most_nodes> nodes;
    std::array<BoundaryPoint, most_boundary_points> boundary_points;
    std::uint32_t node_count = 0, boundary_count = 0;

    void add(std::uint32_t node, double share) noexcept {
        for (std::uint32_t n = 0; n < node_count; ++n) {
            if (nodes[n].node != node) continue;
            nodes[n].share += share;
            return;
        }
        nodes[node_count++] = {node, share};
    }
    void add(const BoundaryValue<D>& value, double share) noexcept {
        boundary_points[boundary_count++] = {value, share};
    }
    void scale(double factor) noexcept {
        for (std::uint32_t n = 0; n < node_count; ++n) nodes[n].share *= factor;
        for (std::uint32_t n = 0; n < boundary_count; ++n) boundary_points[n].share *= factor;
    }
};

/// A ray from a point along an axis, up or down. In units of the lattice.
template <std::size_t D>
struct AxisRay {
    Vec<double, D> from;
    std::size_t axis;
    bool up;
    double length; ///< the ray meets nothing farther than this

    /// Returns how far ahead of the start a coordinate of the axis lies; negative if it lies on the
    /// other side.
    double distance(double position) const noexcept {
        return up ? position - from[axis] : from[axis] - position;
    }
};

/// The point where a ray meets a boundary.
template <std::size_t D>
struct Hit {
    double position; ///< on the ray's axis
    BoundaryValue<D> value;
};

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI

// The stencil of a point over nodes and boundary values, and the rays that find the boundary.
#pragma once

#include <cageform/cage/types/boundary_value.hpp>
#include <cageform/grid/lattice/lattice.hpp>
#include <cageform/grid/lattice/node_runs.hpp>

namespace cageform::inline CAGEFORM_ABI::grid {

/// The value at a point as a weighted sum of values at nodes and on the boundary, for any function.
template <std::size_t D>
struct CutStencil {
    struct Node {
        std::uint32_t node;
        double share;
    };
    struct BoundaryPoint {
        BoundaryValue<D> value;
        double share;
    };
    static constexpr std::size_t corners = std::size_t{1} << D; ///< number of corners of a cell
    /// Capacity of the stencil. Linear interpolation needs boundary points for D orders of the axes, and the
    /// nearest point of the boundary. In 2D the capacity also suffices for a harmonic mean
    /// (grid/tree/harmonic_mean.hpp).
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

/// A ray from a point along an axis, in units of the lattice.
template <std::size_t D>
struct AxisRay {
    Vec<double, D> from;
    std::size_t axis;
    bool up;
    double length; ///< maximum distance

    /// Returns the signed distance of a coordinate from the start, in the direction of the ray.
    double distance(double position) const noexcept {
        return up ? position - from[axis] : from[axis] - position;
    }
};

template <std::size_t D>
struct Hit {
    double position; ///< on the ray's axis
    BoundaryValue<D> value;
};

} // namespace cageform::inline CAGEFORM_ABI::grid

// Values between nodes, right up to a boundary that passes between them.
#pragma once

#include <cageform/cage/detail/boundary_value.hpp>
#include <cageform/grid/lattice.hpp>
#include <cageform/grid/lattice/node_runs.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI {
namespace grid {

/// The value at a point as a mean of values at nodes and on the boundary; serves any number of
/// fields.
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
    static constexpr std::size_t corners = std::size_t{1} << D; ///< of a cell
    /// As many places as D orders of the axes can meet, in the plane as a mean takes
    /// (grid/tree/harmonic_mean.hpp), and the nearest place of the boundary.
    static constexpr std::size_t most_nodes = D == 2 ? 32 : corners,
                                 most_places = 1 + (D == 2 ? 32 : D * corners);

    std::array<Node, most_nodes> nodes;
    std::array<Place, most_places> places;
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
    void scale(double factor) noexcept {
        for (std::uint32_t n = 0; n < node_count; ++n) nodes[n].share *= factor;
        for (std::uint32_t n = 0; n < place_count; ++n) places[n].share *= factor;
    }
};

/// From a place along an axis, up or down. In units of the lattice.
template <std::size_t D>
struct AxisRay {
    Vec<double, D> from;
    std::size_t axis;
    bool up;
    double length; ///< what lies farther is not met

    /// How far ahead a coordinate of the axis lies; negative behind.
    double distance(double position) const noexcept {
        return up ? position - from[axis] : from[axis] - position;
    }
};

/// Where a ray meets a boundary.
template <std::size_t D>
struct Hit {
    double position; ///< on the ray's axis
    BoundaryValue<D> value;
};

} // namespace grid

} // namespace cageform::inline CAGEFORM_ABI

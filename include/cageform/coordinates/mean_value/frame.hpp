// What the formulas of mean value weights in the plane and in space are given, and what they
// return.
#pragma once

#include <cageform/cage/detail/primitives.hpp>
#include <cageform/coordinates/detail/boundary_data.hpp>
#include <cageform/core/affine/compensated_sum.hpp>
#include <cageform/core/affine/dual.hpp>

#include <array>
#include <type_traits>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// How a cage hangs together: its facets (edges in the plane, faces in space), turned alike.
template <std::size_t D>
struct MeanValueTopology;

/// A cage in the numbers that the formula takes, its vertices moved and scaled.
template <class S, std::size_t D>
struct MeanValueFrame;

/// Frames are worked out in double at least.
template <class S>
using Precise = std::common_type_t<S, double>;

/// Of a facet turned as in a topology; of unit length.
inline Vec<double, 2> outward_normal(const Corners<2>& facet) noexcept {
    const auto e = facet[1] - facet[0];
    return (1 / length(e)) * Vec<double, 2>{e[1], -e[0]};
}
inline Vec<double, 3> outward_normal(const Corners<3>& facet) noexcept {
    const auto n = cross(facet[1] - facet[0], facet[2] - facet[0]);
    return (1 / length(n)) * n;
}

/// Where the formula is not to be used, and where it changes; lengths of the frame.
template <class S>
struct MeanValueLimits {
    S near_distance; ///< points nearer to the boundary than this are flagged
    S far_distance;  ///< and so are points farther than this from the cage
    S beside; ///< in space: points nearer to a face's plane, but not over the face, have a formula of their own
};

/// Memory for the formula: a number for each handle, and in space for each edge.
template <class N>
struct WeightRows {
    std::vector<N> weights, edges;

    template <class Topology>
    explicit WeightRows(const Topology& topology, std::size_t handles)
        : weights(handles)
        , edges(topology.edge_count()) {}

    N sum() const noexcept {
        return compensated_sums<N, 1>(weights.size(),
                                      [&](std::size_t i, auto& total) { total[0] += weights[i]; })[0];
    }
};

/// What the formula for a kind of cage is written in: how it hangs together, its numbers, memory, and
/// the data on its boundary.
template <class Cage>
struct MeanValueForm {
    using Topology = MeanValueTopology<Cage::dimension>;
    template <class S>
    using Frame = MeanValueFrame<S, Cage::dimension>;
    template <class N>
    using Rows = WeightRows<N>;
    using Data = BoundaryData<Cage>;

    static Data data(const Cage& /*cage*/) noexcept { return {}; }
};

/// The sum of the weights, positive inside and negative outside (Hormann & Floater 2006, sec. 4.1
/// and 4.2), and one in the lanes that the limits flag, zero in the others.
template <class N>
struct WeightSum {
    N sum;
    ValueOf<N> special;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

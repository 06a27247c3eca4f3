// Inputs and outputs of the mean value formulas.
#pragma once

#include <cageform/cage/detail/primitives.hpp>
#include <cageform/cage/types/boundary_value.hpp>
#include <cageform/core/affine/compensated_sum.hpp>
#include <cageform/core/affine/dual.hpp>

#include <type_traits>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The connectivity of a cage: its facets (edges in 2D, triangles in 3D), consistently oriented.
template <std::size_t D>
struct MeanValueTopology;

/// The tables of a cage, with its vertices moved and scaled.
template <class S, std::size_t D>
struct MeanValueFrame;

/// The scalar of tables while they are computed: at least double.
template <class S>
using Precise = std::common_type_t<S, double>;

/// Returns the unit normal of a facet that is oriented as in a topology.
inline Vec<double, 2> outward_normal(const Corners<2>& facet) noexcept {
    const auto e = facet[1] - facet[0];
    return (1 / length(e)) * Vec<double, 2>{e[1], -e[0]};
}
inline Vec<double, 3> outward_normal(const Corners<3>& facet) noexcept {
    const auto n = cross(facet[1] - facet[0], facet[2] - facet[0]);
    return (1 / length(n)) * n;
}

/// Limits of the formula, in lengths of the frame.
template <class S>
struct MeanValueLimits {
    S near_distance; ///< points nearer to the boundary are flagged
    S far_distance;  ///< points farther from the cage are flagged
    /// 3D: points nearer to a face's plane, but not over the face, use `sum_beside_face`.
    S beside;
};

/// Scratch memory of the formula: a number per handle, and in 3D per edge.
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

/// The types of the formula for a kind of cage.
template <class Cage>
struct MeanValueForm {
    using Topology = MeanValueTopology<Cage::dimension>;
    template <class S>
    using Frame = MeanValueFrame<S, Cage::dimension>;
    template <class N>
    using Rows = WeightRows<N>;
    using Data = LinearBoundaryData<Cage::dimension>;

    static Data data(const Cage& /*cage*/) noexcept { return {}; }
};

/// The sum of the weights, positive inside and negative outside (Hormann & Floater 2006, sec. 4.1 and 4.2).
/// `special` is 1 in lanes flagged by the limits, else 0.
template <class N>
struct WeightSum {
    N sum;
    ValueOf<N> special;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

// The formula of three-point weights in a convex polygon, for any kind of number.
#pragma once

#include <cageform/coordinates/detail/compensated_sum.hpp>
#include <cageform/core/buffer.hpp>

#include <cmath>
#include <type_traits>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A convex cage in the numbers that the formula takes, its vertices moved and scaled.
template <class S>
struct ThreePointFrame {
    struct Corner {
        Vec<S, 2> position;
        Vec<S, 2> edge; ///< the edge that starts here, the inside to its left
        S extent;       ///< |edge_x| + |edge_y|
        S bend;         ///< the edge before × this one
    };
    Buffer<Corner> corners;
    S square = 1; ///< the square of the frame's unit of length, in the user's

    ThreePointFrame() = default;
    /// `at` in the user's order, counter-clockwise or (not `left`) clockwise.
    template <class Number>
    ThreePointFrame(const Buffer<Vec<Number, 2>>& at, bool left, S unit)
        : square(unit * unit) {
        const Number sign = left ? 1 : -1;
        const std::size_t count = at.size();
        corners.reserve(count);
        for (std::size_t i = 0; i < count; ++i) {
            const auto before = at[i] - at[i > 0 ? i - 1 : count - 1];
            const auto edge = at[i + 1 < count ? i + 1 : 0] - at[i];
            corners.push_back({vec_cast<S>(at[i]), vec_cast<S>(sign * edge),
                               static_cast<S>(std::fabs(edge[0]) + std::fabs(edge[1])),
                               static_cast<S>(sign * cross(before, edge))});
        }
    }
};

/// The sum of the weights; and masks, one in the lanes where it holds and zero in the others.
template <class N>
struct ThreePointSum {
    N sum;
    ValueOf<N> beside;  ///< nearer to the line of an edge than `near`, on either side
    ValueOf<N> outside; ///< farther than that beyond the line of an edge
};

/// The vector from the point to a vertex, and c = f(|u|²).
template <class N>
struct ThreePointSpoke {
    Vec<ValueOf<N>, 2> u;
    N c;
};

/// A_i, the cross product of the vector to a vertex and the edge that starts there, inverted; and
/// (c_{i+1} − c_i) / A_i.
template <class N>
struct ThreePointEdge {
    N inverse, rise;
};

/// Floater, Hormann & Kós, A general construction of barycentric coordinates over convex polygons
/// (Adv. Comput. Math. 24, 2006), before normalising; twice areas in place of areas, which halves
/// all weights:
///
///   w_i = K_i c_i / (A_{i−1} A_i) + (c_{i+1} − c_i) / A_i − (c_i − c_{i−1}) / A_{i−1}
///
/// K_i is a constant of the cage, so that next to the boundary nothing cancels. A_i is taken with
/// the edge: with the next vertex in its place it would cancel.
///
///   is_constant  whether all differences of c are zero; they are then left out
template <bool is_constant, class N, class S, class F>
CAGEFORM_DETAIL_FLATTEN ThreePointSum<N> weigh_three_points(const ThreePointFrame<S>& cage, const F& f,
                                                            S near, const Vec<ValueOf<N>, 2>& p,
                                                            std::vector<N>& weights) noexcept {
    using X = ValueOf<N>;
    const X zero(S(0)), one(S(1)), square(cage.square);
    const std::size_t count = cage.corners.size();
    X beside = zero, outside = zero;
    const auto spoke = [&](std::size_t i) -> ThreePointSpoke<N> {
        const auto& at = cage.corners[i].position;
        const Vec<X, 2> u{X(at[0]) - p[0], X(at[1]) - p[1]};
        const X rr = square * (u[0] * u[0] + u[1] * u[1]);
        return {u, f(with_gradient<N, 2>(rr, (X(S(-2)) * square) * u))};
    };
    const auto edge = [&](std::size_t i, const auto& from, const auto& to) -> ThreePointEdge<N> {
        const auto& corner = cage.corners[i];
        const X ex(corner.edge[0]), ey(corner.edge[1]), limit(near * corner.extent);
        const N area = with_gradient<N, 2>(from.u[0] * ey - from.u[1] * ex, {-ey, ex});
        beside = select(value_of(area) <= limit, one, beside);
        outside = select(value_of(area) < -limit, one, outside);
        const N inverse = one / area;
        if constexpr (is_constant)
            return {inverse, N(zero)};
        else
            return {inverse, (to.c - from.c) * inverse};
    };
    const auto first = spoke(0);
    auto from = first;
    auto before = edge(count - 1, spoke(count - 1), first);
    for (std::size_t i = 0; i < count; ++i) {
        const auto to = i + 1 < count ? spoke(i + 1) : first;
        const auto here = edge(i, from, to);
        const N product = (X(cage.corners[i].bend) * before.inverse) * here.inverse;
        if constexpr (is_constant)
            weights[i] = product * from.c;
        else
            weights[i] = product * from.c + (here.rise - before.rise);
        from = to;
        before = here;
    }
    const auto sums =
        compensated_sums<N, 1>(count, [&](std::size_t i, auto& total) { total[0] += weights[i]; });
    return {sums[0], beside, outside};
}

} // namespace cageform::inline CAGEFORM_ABI::detail

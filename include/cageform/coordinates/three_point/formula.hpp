// The formula of three-point weights in a convex polygon.
#pragma once

#include <cageform/core/affine/compensated_sum.hpp>
#include <cageform/core/types/buffer.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The tables of a convex cage, with its vertices moved and scaled.
template <class S>
struct ThreePointFrame {
    struct Corner {
        Vec<S, 2> position;
        Vec<S, 2> edge; ///< the edge that starts here times `scale`, with the inside on its left
        S scale;        ///< a power of two, so that the length is in [1/2, 1)
        S bend;         ///< the previous scaled edge × this one
    };
    Buffer<Corner> corners;
    S square = 1; ///< the square of the frame's unit of length, in the user's unit
    S sign = 1;   ///< −1 if edges are reversed

    ThreePointFrame() = default;
    /// `at` in the user's order, counter-clockwise if `left`, else clockwise.
    template <class Number>
    ThreePointFrame(const Buffer<Vec<Number, 2>>& at, bool left, S unit)
        : square(unit * unit)
        , sign(left ? S(1) : S(-1)) {
        const std::size_t count = at.size();
        corners.reserve(count);
        const auto scaled = [&](std::size_t i, Number& scale) {
            const auto edge = at[i + 1 < count ? i + 1 : 0] - at[i];
            int exponent = 0;
            std::frexp(std::sqrt(dot(edge, edge)), &exponent);
            scale = std::ldexp(Number(1), -exponent);
            return (Number(sign) * scale) * edge;
        };
        Number scale = 1;
        auto before = scaled(count - 1, scale);
        for (std::size_t i = 0; i < count; ++i) {
            const auto edge = scaled(i, scale);
            corners.push_back({vec_cast<S>(at[i]), vec_cast<S>(edge), static_cast<S>(scale),
                               static_cast<S>(Number(sign) * cross(before, edge))});
            before = edge;
        }
    }
};

/// The sum of the weights, and two masks: 1 where the condition holds, else 0.
template <class N>
struct ThreePointSum {
    N sum;
    ValueOf<N> beside;  ///< within twice `near_distance` of the line of an edge, or beyond it
    ValueOf<N> outside; ///< farther than `near_distance` beyond the line of an edge
};

/// The vector u from the point to a vertex, and c = f(|u|²); `square` is the square of the unit.
template <class N>
struct ThreePointSpoke {
    using X = ValueOf<N>;
    Vec<X, 2> u;
    N c;

    template <class S, class F>
    ThreePointSpoke(const Vec<S, 2>& vertex, const Vec<X, 2>& p, const F& f, const X& square) noexcept
        : u{X(vertex[0]) - p[0], X(vertex[1]) - p[1]}
        , c(f(with_gradient<N, 2>(square * (u[0] * u[0] + u[1] * u[1]), (X(S(-2)) * square) * u))) {}
};

/// How the differences of c along edges are computed.
enum class DifferenceFormula : std::uint8_t { none, of_squares, of_any };

/// Returns (c_{i+1} − c_i) times the scale of the edge. For c = r² this is e·(u_i + u_{i+1}), which does not
/// cancel along short edges as the difference of squares does.
template <DifferenceFormula differences, class N, class S>
N scaled_rise(const ThreePointFrame<S>& cage, const typename ThreePointFrame<S>::Corner& corner,
              const ThreePointSpoke<N>& from, const ThreePointSpoke<N>& to) noexcept {
    using X = ValueOf<N>;
    if constexpr (differences == DifferenceFormula::of_squares) {
        const X factor(cage.sign * cage.square);
        const Vec<X, 2> edge{factor * X(corner.edge[0]), factor * X(corner.edge[1])};
        return with_gradient<N, 2>(edge[0] * (from.u[0] + to.u[0]) + edge[1] * (from.u[1] + to.u[1]),
                                   X(S(-2)) * edge);
    } else {
        return X(corner.scale) * (to.c - from.c);
    }
}

/// Computes the unnormalised weights of Floater, Hormann & Kós, A general construction of barycentric
/// coordinates over convex polygons (Adv. Comput. Math. 24, 2006). Doubled areas halve all weights:
///
///   w_i = K_i c_i / (A_{i−1} A_i) + (c_{i+1} − c_i) / A_i − (c_i − c_{i−1}) / A_{i−1}
///
/// K_i is a constant of the cage, so nothing cancels next to the boundary. A_i is computed from the edge;
/// from the next vertex it would cancel. Edges are scaled to a length of about 1, so A_i is about the
/// distance from the edge's line, and one minimum finds the nearest line. K_i / (A_{i−1} A_i) does not
/// change.
///
///   differences  none if f is constant, without differences of c; of_squares if f = r²
template <DifferenceFormula differences, class N, class S, class F>
CAGEFORM_DETAIL_FLATTEN ThreePointSum<N> three_point_weights(const ThreePointFrame<S>& cage, const F& f,
                                                             S near_distance, const Vec<ValueOf<N>, 2>& p,
                                                             std::vector<N>& weights) noexcept {
    using X = ValueOf<N>;
    const X zero(S(0)), one(S(1)), square(cage.square);
    const std::size_t count = cage.corners.size();
    X least((std::numeric_limits<S>::max)());
    const auto invert_area = [&](const auto& corner, const Vec<X, 2>& u) -> N {
        const X ex(corner.edge[0]), ey(corner.edge[1]);
        const N area = with_gradient<N, 2>(u[0] * ey - u[1] * ex, {-ey, ex});
        least = (min)(value_of(area), least);
        return one / area;
    };
    const auto& last = cage.corners[count - 1];
    const ThreePointSpoke<N> before(last.position, p, f, square);
    ThreePointSpoke<N> from(cage.corners[0].position, p, f, square);
    N inverse_before = invert_area(last, before.u);
    N rise_before = scaled_rise<differences>(cage, last, before, from) * inverse_before;
    for (std::size_t i = 0; i < count; ++i) {
        const auto& corner = cage.corners[i];
        const ThreePointSpoke<N> to(cage.corners[i + 1 < count ? i + 1 : 0].position, p, f, square);
        const N inverse = invert_area(corner, from.u);
        if constexpr (differences == DifferenceFormula::none) {
            weights[i] = (X(corner.bend) * inverse_before) * inverse;
        } else {
            const N rise = scaled_rise<differences>(cage, corner, from, to) * inverse;
            weights[i] = (X(corner.bend) * inverse_before) * inverse * from.c + (rise - rise_before);
            rise_before = rise;
        }
        inverse_before = inverse;
        from = to;
    }
    const auto sums =
        compensated_sums<N, 1>(count, [&](std::size_t i, auto& total) { total[0] += weights[i]; });
    const X limit(near_distance);
    return {sums[0], select(least <= limit, one, zero), select(least < -limit, one, zero)};
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// The formula of mean value weights in 2D.
#pragma once

#include <cageform/cage/detail/loop_sides.hpp>
#include <cageform/cage/polygon.hpp>
#include <cageform/coordinates/mean_value/frame.hpp>
#include <cageform/core/types/buffer.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template <>
struct MeanValueTopology<2> {
    struct Loop {
        std::size_t begin, end;
    };
    Buffer<Loop> loops;
    /// The edges by start vertex, with the inside on the left.
    std::vector<std::array<std::uint32_t, 2>> facets;

    static std::size_t edge_count() noexcept { return 0; } ///< 2D needs no memory per edge

    MeanValueTopology() = default;
    template <Scalar T>
    explicit MeanValueTopology(const Polygon<T>& polygon) {
        for (std::size_t k = 0; k < polygon.loops().size(); ++k) {
            const auto& loop = polygon.loops()[k];
            const bool left = detail::inside_is_left(polygon, k);
            loops.push_back({loop.begin, loop.end});
            loop.for_each_edge([&](std::size_t i, std::size_t j) {
                const auto from = std::uint32_t(left ? i : j), to = std::uint32_t(left ? j : i);
                facets.push_back({from, to});
            });
        }
    }
};

template <class S>
struct MeanValueFrame<S, 2> {
    struct Corner {
        Vec<S, 2> position;
        Vec<S, 2> edge; ///< the edge that starts here, with the inside on its left
        S extent;       ///< |edge_x| + |edge_y|
    };
    Buffer<MeanValueTopology<2>::Loop> loops;
    Buffer<Corner> corners;

    MeanValueFrame() = default;
    MeanValueFrame(const MeanValueTopology<2>& topology, const Buffer<Vec<Precise<S>, 2>>& at)
        : loops(topology.loops) {
        corners.reserve(at.size());
        for (std::size_t i = 0; i < at.size(); ++i) {
            const auto [from, to] = topology.facets[i];
            const auto edge = vec_cast<S>(at[to] - at[from]);
            corners.push_back({vec_cast<S>(at[i]), edge, std::fabs(edge[0]) + std::fabs(edge[1])});
        }
    }
};

/// The vector u from the point to a vertex, its squared length and its length. `inverse_r` is set only for
/// numbers with estimated roots, and by `for_each_seen_edge`.
template <class N>
struct Spoke {
    using X = ValueOf<N>;
    Vec<X, 2> u;
    X rr;
    N r, inverse_r;

    template <class S>
    Spoke(const Vec<S, 2>& vertex, const Vec<X, 2>& p) noexcept
        : u{X(vertex[0]) - p[0], X(vertex[1]) - p[1]}
        , rr(u[0] * u[0] + u[1] * u[1]) {
        if constexpr (estimates_roots<N>) {
            const auto both = root_and_inverse(rr);
            r = both.root;
            inverse_r = both.inverse;
        } else {
            const X root = sqrt(rr);
            r = with_gradient<N>(root, (X(-1) / root) * u);
        }
    }
};

/// The signed angle α of an edge e, as seen from the point. The vectors u and v lead from the point to the
/// ends of e. c = u × e is |u||v| sin α; it is computed from the edge because u × v cancels far away. s is
/// |u||v| (1 + |cos α|).
template <class N>
struct SeenEdge {
    using X = ValueOf<N>;
    decltype(X() < X()) acute;
    N c, s;
    /// Of tan(α/2): sin α/(1 + cos α) for acute angles, else (1 − cos α)/sin α, so that nothing cancels.
    N numerator, denominator;

    template <class S>
    SeenEdge(const Spoke<N>& from, const Spoke<N>& to, const Vec<S, 2>& edge) noexcept {
        const auto &u = from.u, &v = to.u;
        const X ex(edge[0]), ey(edge[1]);
        c = with_gradient<N, 2>(u[0] * ey - u[1] * ex, {-ey, ex});
        const N d = with_gradient<N, 2>(u[0] * v[0] + u[1] * v[1], {-(u[0] + v[0]), -(u[1] + v[1])});
        acute = X(0) < value_of(d);
        s = from.r * to.r + select(acute, d, -d); // |d|; its derivative at d = 0 is that of −d
        numerator = select(acute, c, s);
        denominator = select(acute, s, c);
    }
};

/// Computes the unnormalised weights of Floater, Mean value coordinates (CAGD 20, 2003), eq. (2.1):
///
///   w_i = (t_{i−1} + t_i) / r_i,   t_i = tan(α_i/2),   α_i the signed angle C_i p C_{i+1}
///
/// A single division, by the tangent's denominator times |v|, yields the
/// tangent and 1/|v|, unless 1/|v| comes with the root.
template <class N, class S>
WeightSum<N> compute_weights(const MeanValueFrame<S, 2>& cage, const MeanValueLimits<S>& limits,
                             const Vec<ValueOf<N>, 2>& p, WeightRows<N>& rows) noexcept {
    using X = ValueOf<N>;
    const X zero(S(0)), one(S(1)), on_vertex(limits.near_distance * limits.near_distance),
        far2(limits.far_distance * limits.far_distance);
    // The smallest distances from a vertex and from an edge. At an edge |c| is small and d is not positive.
    X special = zero, least_rr((std::numeric_limits<S>::max)()), least_clearance = least_rr;
    for (const auto& loop : cage.loops) {
        const Spoke<N> first(cage.corners[loop.begin].position, p);
        special = select(far2 < first.rr, one, special);
        Spoke<N> from = first;
        N t_before = zero, t_first = zero, inverse_r = zero;
        for (std::size_t i = loop.begin; i < loop.end; ++i) {
            const auto& corner = cage.corners[i];
            const Spoke<N> to = i + 1 < loop.end ? Spoke<N>(cage.corners[i + 1].position, p) : first;
            least_rr = (min)(to.rr, least_rr);
            const SeenEdge<N> edge(from, to, corner.edge);
            const N &numerator = edge.numerator, &denominator = edge.denominator;
            least_clearance =
                (min)(abs(value_of(denominator)) - X(limits.near_distance * corner.extent), least_clearance);
            N t, inverse_next;
            if constexpr (estimates_roots<N>) {
                t = numerator / denominator;
                inverse_next = to.inverse_r;
            } else {
                const N inverse = one / (denominator * to.r);
                t = numerator * to.r * inverse;
                inverse_next = denominator * inverse;
            }
            if (i == loop.begin) {
                t_first = t;
            } else {
                rows.weights[i] = (t_before + t) * inverse_r;
            }
            t_before = t;
            inverse_r = inverse_next;
            from = to;
        }
        rows.weights[loop.begin] = (t_before + t_first) * inverse_r;
    }
    special = select(least_rr <= on_vertex, one, special);
    special = select(least_clearance <= zero, one, special);
    return {rows.sum(), special};
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// The formula of Green coordinates in 2D, for SIMD registers of points.
#pragma once

#include <cageform/coordinates/green/frame.hpp>
#include <cageform/coordinates/mean_value/plane.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template <class S>
struct GreenFrame<S, 2> {
    struct Edge {
        std::uint32_t from, to; ///< the inside is on the left
        Vec<S, 2> along;        ///< t, of unit length
        S length, inverse;      ///< L, 1/L
    };
    Buffer<Vec<S, 2>> vertices;
    Buffer<Edge> edges;
    S gauge = 0; ///< 1 + ln R for the unit of length R in the logarithms

    GreenFrame() = default;
    GreenFrame(const MeanValueTopology<2>& topology, const Buffer<Vec<double, 2>>& at, double diagonal)
        : gauge(S(1 + std::log(diagonal))) {
        for (const auto& v : at) vertices.push_back(vec_cast<S>(v));
        for (const auto& [from, to] : topology.facets) {
            const auto edge = at[to] - at[from];
            const double length = detail::length(edge);
            edges.push_back({from, to, vec_cast<S>((1 / length) * edge), S(length), S(1 / length)});
        }
    }
};

/// The vertices relative to the points.
template <class S>
struct GreenRows<S, 2> {
    struct Corner {
        Vec<Simd<S>, 2> u; ///< C − p
        Simd<S> rr, log;   ///< |u|², ln |u|
    };
    std::vector<Corner> corners;

    explicit GreenRows(const GreenFrame<S, 2>& frame)
        : corners(frame.vertices.size()) {}
};

/// The integrals of an edge from A to B, relative to the points: s₁ = A·t, s₂ = B·t, d = A·n, and the angle θ
/// that the edge subtends, zero for points on the edge.
template <class S>
struct EdgeIntegrals {
    Simd<S> s1, s2, d, theta, touched;

    EdgeIntegrals(const typename GreenFrame<S, 2>::Edge& edge, const typename GreenRows<S, 2>::Corner& a,
                  const typename GreenRows<S, 2>::Corner& b, S near_distance) noexcept {
        using X = Simd<S>;
        const X zero(S(0)), one(S(1)), reach(near_distance), tx(edge.along[0]), ty(edge.along[1]);
        s1 = a.u[0] * tx + a.u[1] * ty;
        s2 = b.u[0] * tx + b.u[1] * ty;
        // Computed from the nearer end, so that next to a vertex the angles of its two edges cancel.
        const auto from_a = a.rr <= b.rr;
        const X x = select(from_a, a.u[0], b.u[0]), y = select(from_a, a.u[1], b.u[1]);
        d = x * ty - y * tx;
        const X size = abs(d);
        const auto on_line = both(size <= reach, both(s1 <= zero, zero <= s2));
        const auto on_edge = on_line | ((min)(a.rr, b.rr) <= reach * reach);
        const X seen = angle(X(edge.length) * size, a.u[0] * b.u[0] + a.u[1] * b.u[1]);
        theta = select(on_edge, zero, select(d < zero, zero - seen, seen));
        touched = select(on_edge, one, zero);
    }
};

/// Computes the coordinates of Lipman, Levin, Cohen-Or: Green Coordinates (ACM Trans. Graph. 27,
/// 2008), sec. 4, from integrals over the edges:
///
///   2πL φ_a += s₂ θ − d ℓ,   2πL φ_b += d ℓ − s₁ θ,   ℓ = ln(|B|/|A|)
///   2π ψ = −(s₂ ln|B| − s₁ ln|A| − L + d θ)
///
/// The derivative of s₂ θ − d ℓ has another term, L/|A|² times A rotated. It cancels against the same term of
/// the previous edge, so both are left out:
///
///   2πL ∇φ_b = −2πL ∇φ_a = θ t − ℓ n,   2π ∇ψ = ℓ t + θ n
///
/// ψ is divided by the handle's length L. `rows` must be zero on entry.
template <bool gradients, class S>
GreenSum<S> integrate(const GreenFrame<S, 2>& cage, S near_distance, const Vec<Simd<S>, 2>& p,
                      GreenRows<S, 2>& seen, Lanes<S>* rows) noexcept {
    using X = Simd<S>;
    constexpr S pi = S(3.14159265358979323846);
    const std::size_t vertices = cage.vertices.size(), handles = vertices + cage.edges.size();
    for (std::size_t i = 0; i < vertices; ++i) {
        auto& corner = seen.corners[i];
        for (std::size_t k = 0; k < 2; ++k) corner.u[k] = X(cage.vertices[i][k]) - p[k];
        corner.rr = corner.u[0] * corner.u[0] + corner.u[1] * corner.u[1];
        corner.log = X(S(0.5)) * log((max)(corner.rr, X(least_square<S>)));
    }
    X angles(S(0)), touched(S(0));
    for (std::size_t e = 0; e < cage.edges.size(); ++e) {
        const auto& edge = cage.edges[e];
        const auto &a = seen.corners[edge.from], &b = seen.corners[edge.to];
        const EdgeIntegrals<S> of(edge, a, b, near_distance);
        angles += of.theta;
        touched = (max)(touched, of.touched);
        const X ratio = b.log - a.log, share(edge.inverse / (2 * pi));
        if constexpr (gradients) {
            const X t[2] = {X(edge.along[0]), X(edge.along[1])}, n[2] = {t[1], -t[0]};
            for (std::size_t k = 0; k < 2; ++k) {
                const X slope = share * (of.theta * t[k] - ratio * n[k]);
                add(slope, rows[k * handles + edge.to]);
                add(-slope, rows[k * handles + edge.from]);
                (share * (ratio * t[k] + of.theta * n[k])).store(rows[k * handles + vertices + e]);
            }
        } else {
            add(share * (of.s2 * of.theta - of.d * ratio), rows[edge.from]);
            add(share * (of.d * ratio - of.s1 * of.theta), rows[edge.to]);
            const X logs = of.s2 * b.log - of.s1 * a.log - X(cage.gauge * edge.length);
            (-(share * (logs + of.d * of.theta))).store(rows[vertices + e]);
        }
    }
    return {X(1 / (2 * pi)) * angles, touched};
}

} // namespace cageform::inline CAGEFORM_ABI::detail

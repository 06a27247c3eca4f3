// The facing prior of maximum entropy coordinates: mean value weights of the facets that face the point.
//
//     q_k = Σ_f √μ_f w_fk     over the facets f of vertex k whose inner side is towards p
//
// m_f is the integral of the unit vectors from p over the projection of facet f to the unit circle or sphere
// about p, μ_f = |m_f|, and w_fk are the mean value weights: Σ_k w_fk (C_k − p) = m_f. All terms are
// positive.
#pragma once

#include <cageform/coordinates/mean_value/plane.hpp>
#include <cageform/coordinates/mean_value/space.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Calls f(i, next, from, to, edge) for each edge: its two corners, the spokes to them, and the SeenEdge.
/// Returns the sum of all mean value weights, which is positive inside and negative outside. `special` of the
/// result is 1 in lanes of points near an edge or a vertex.
template <class N, class S, class F>
WeightSum<ValueOf<N>> for_each_seen_edge(const MeanValueFrame<S, 2>& cage, const MeanValueLimits<S>& limits,
                                         const Vec<ValueOf<N>, 2>& p, const F& f) noexcept {
    using X = ValueOf<N>;
    const X zero(S(0)), one(S(1)), on_vertex(limits.near_distance * limits.near_distance);
    X least_rr((std::numeric_limits<S>::max)()), least_clearance = least_rr, sum = zero;
    const auto spoke_to = [&](std::size_t i) {
        Spoke<N> spoke(cage.corners[i].position, p);
        if constexpr (!estimates_roots<N>) spoke.inverse_r = one / spoke.r;
        return spoke;
    };
    for (const auto& loop : cage.loops) {
        const Spoke<N> first = spoke_to(loop.begin);
        Spoke<N> from = first;
        for (std::size_t i = loop.begin; i < loop.end; ++i) {
            const auto& corner = cage.corners[i];
            const std::size_t next = i + 1 == loop.end ? loop.begin : i + 1;
            const Spoke<N> to = next == loop.begin ? first : spoke_to(next);
            least_rr = (min)(to.rr, least_rr);
            const SeenEdge<N> edge(from, to, corner.edge);
            least_clearance = (min)(abs(value_of(edge.denominator)) - X(limits.near_distance * corner.extent),
                                    least_clearance);
            sum = sum + value_of(edge.numerator) / value_of(edge.denominator) *
                            (value_of(from.inverse_r) + value_of(to.inverse_r));
            f(i, next, from, to, edge);
            from = to;
        }
    }
    X special = select(least_rr <= on_vertex, one, zero);
    special = select(least_clearance <= zero, one, special);
    return {sum, special};
}

/// Computes the prior in `rows.weights`. Returns the result of `for_each_seen_edge`.
template <class N, class S>
WeightSum<ValueOf<N>> compute_facing(const MeanValueFrame<S, 2>& cage, const MeanValueLimits<S>& limits,
                                     const Vec<ValueOf<N>, 2>& p, WeightRows<N>& rows) noexcept {
    using X = ValueOf<N>;
    for (N& q : rows.weights) q = N(X(S(0)));
    return for_each_seen_edge<N>(cage, limits, p,
                                 [&](std::size_t i, std::size_t next, const Spoke<N>& from,
                                     const Spoke<N>& to, const SeenEdge<N>& edge) {
                                     const N &a = edge.numerator, &b = edge.denominator;
                                     const N half_mu = a / sqrt(a * a + b * b);
                                     const N facing = select(X(S(0)) < value_of(edge.c),
                                                             sqrt(X(S(2)) * half_mu) * (a / b), N(X(S(0))));
                                     rows.weights[i] += facing * from.inverse_r;
                                     rows.weights[next] += facing * to.inverse_r;
                                 });
}

template <class N, class S>
WeightSum<ValueOf<N>> compute_facing(const MeanValueFrame<S, 3>& cage, const MeanValueLimits<S>& limits,
                                     const Vec<ValueOf<N>, 3>& p, WeightRows<N>& rows) noexcept {
    using X = ValueOf<N>;
    constexpr S edge_on = S(1e-9); // of the distance beside a face: its share is below (1e-9)^(3/2)
    const X zero(S(0));
    X special = start_weights<N, S>(cage, limits, p, rows), sum = zero;
    for (const auto& face : cage.faces) {
        const auto g = angles_at<N, S>(face, rows);
        const auto w = face_weights<N, S>(face, g, limits, p, special);
        sum = sum + value_of(w[0]) + value_of(w[1]) + value_of(w[2]);
        const N height = linear<N>(face.offset, face.normal, p);
        X inmost = zero;
        for (std::size_t k = 0; k < 3; ++k)
            inmost = (min)(inmost, X(face.across_offset[k]) - inner(face.across[k], p));
        // m = n Σ w H − ½ H Σ g ν
        const N total = w[0] + (w[1] + w[2]);
        N across = g[0] * g[0] + (g[1] * g[1] + g[2] * g[2]);
        for (std::size_t k = 0; k < 3; ++k)
            across = across + X(S(2) * face.cosine[k]) * (g[(k + 1) % 3] * g[(k + 2) % 3]);
        const N mu = height * sqrt(total * total + X(S(0.25)) * across);
        const auto faces = both(-(X(edge_on) * inmost) < value_of(height), zero < value_of(height));
        const N root = sqrt(select(faces, mu, N(X(S(1)))));
        for (std::size_t k = 0; k < 3; ++k) {
            const auto counts = both(faces, zero < value_of(w[k]));
            rows.weights[face.corner[k]] += select(counts, root * w[k], N(zero));
        }
    }
    return {sum, special};
}

} // namespace cageform::inline CAGEFORM_ABI::detail

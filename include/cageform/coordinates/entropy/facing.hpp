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

/// Computes the prior in `rows.weights`. Returns the sum of all mean value weights, which is positive inside
/// and negative outside. Flags points near the boundary as `compute_weights` does.
template <class N, class S>
WeightSum<ValueOf<N>> compute_facing(const MeanValueFrame<S, 2>& cage, const MeanValueLimits<S>& limits,
                                     const Vec<ValueOf<N>, 2>& p, WeightRows<N>& rows) noexcept {
    using X = ValueOf<N>;
    const X zero(S(0)), one(S(1)), on_vertex(limits.near_distance * limits.near_distance);
    X special = zero, least_rr((std::numeric_limits<S>::max)()), least_clearance = least_rr, sum = zero;
    for (N& q : rows.weights) q = N(zero);
    for (const auto& loop : cage.loops) {
        const Spoke<N> first(cage.corners[loop.begin].position, p);
        const N first_inverse = one / first.r;
        Spoke<N> from = first;
        N from_inverse = first_inverse;
        for (std::size_t i = loop.begin; i < loop.end; ++i) {
            const auto& corner = cage.corners[i];
            const bool is_last = i + 1 == loop.end;
            const std::size_t next = is_last ? loop.begin : i + 1;
            const Spoke<N> to = is_last ? first : Spoke<N>(cage.corners[next].position, p);
            const N to_inverse = is_last ? first_inverse : one / to.r;
            least_rr = (min)(to.rr, least_rr);
            const auto &u = from.u, &v = to.u;
            const X ex(corner.edge[0]), ey(corner.edge[1]);
            const N c = with_gradient<N, 2>(u[0] * ey - u[1] * ex, {-ey, ex});
            const N d = with_gradient<N, 2>(u[0] * v[0] + u[1] * v[1], {-(u[0] + v[0]), -(u[1] + v[1])});
            const auto acute = zero < value_of(d);
            const N s = from.r * to.r + select(acute, d, -d);
            const N numerator = select(acute, c, s), denominator = select(acute, s, c); // of tan(α/2)
            least_clearance =
                (min)(abs(value_of(denominator)) - X(limits.near_distance * corner.extent), least_clearance);
            const N tangent = numerator / denominator;
            const N half_mu = numerator / sqrt(numerator * numerator + denominator * denominator);
            const N facing = select(zero < value_of(c), sqrt(X(S(2)) * half_mu) * tangent, N(zero));
            rows.weights[i] += facing * from_inverse;
            rows.weights[next] += facing * to_inverse;
            sum = sum + value_of(tangent) * (value_of(from_inverse) + value_of(to_inverse));
            from = to;
            from_inverse = to_inverse;
        }
    }
    special = select(least_rr <= on_vertex, one, special);
    special = select(least_clearance <= zero, one, special);
    return {sum, special};
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

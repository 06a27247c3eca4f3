// The published priors of maximum entropy coordinates in the plane (Hormann, Sukumar, Maximum entropy
// coordinates for arbitrary polytopes, SGP 2008):
//
//     q_k = 1/(ρ_(k−1) ρ_k)     ρ of the two edges of vertex k
//
// With the vectors a and b to the ends of an edge: MEC-1 has ρ = |a| + |b| − |a − b|, and MEC-2 has
// ρ = |a||b| + a·b.
#pragma once

#include <cageform/coordinates/mean_value/plane.hpp>
#include <cageform/core/detail/simd_exp.hpp>
#include <cageform/core/detail/simd_log.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Computes the prior in `rows.weights`, times a factor. Returns as `compute_facing`.
///
///   is_first  whether to compute MEC-1 instead of MEC-2
template <class N, class S>
WeightSum<ValueOf<N>> compute_published(const MeanValueFrame<S, 2>& cage, const MeanValueLimits<S>& limits,
                                        const Vec<ValueOf<N>, 2>& p, bool is_first,
                                        WeightRows<N>& rows) noexcept {
    using X = ValueOf<N>;
    const auto found = compute_facing<N, S>(cage, limits, p, rows); // for its sum and its flags
    for (N& q : rows.weights) q = N(X(S(0)));
    for (const auto& loop : cage.loops) {
        for (std::size_t i = loop.begin; i < loop.end; ++i) {
            const std::size_t next = i + 1 == loop.end ? loop.begin : i + 1;
            const auto& corner = cage.corners[i];
            const Spoke<N> from(corner.position, p), to(cage.corners[next].position, p);
            const auto &u = from.u, &v = to.u;
            const X ex(corner.edge[0]), ey(corner.edge[1]);
            const N c = with_gradient<N, 2>(u[0] * ey - u[1] * ex, {-ey, ex});
            const N d = with_gradient<N, 2>(u[0] * v[0] + u[1] * v[1], {-(u[0] + v[0]), -(u[1] + v[1])});
            const auto acute = X(S(0)) < value_of(d);
            const N s = from.r * to.r + select(acute, d, -d); // |a||b| + |a·b|
            N rho = select(acute, s, c * c / s);
            if (is_first) {
                const X edge(std::sqrt(corner.edge[0] * corner.edge[0] + corner.edge[1] * corner.edge[1]));
                rho = rho / (from.r + to.r + N(edge));
            }
            const N logarithm = log(rho);
            rows.weights[i] += -logarithm;
            rows.weights[next] += -logarithm;
        }
    }
    X most((std::numeric_limits<S>::lowest)());
    for (const N& q : rows.weights) most = (max)(most, value_of(q));
    for (N& q : rows.weights) q = exp(q - N(most));
    return found;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// The published priors of maximum entropy coordinates in the plane (Hormann, Sukumar, Maximum entropy
// coordinates for arbitrary polytopes, SGP 2008):
//
//     q_k = 1/(ρ_(k−1) ρ_k)     ρ of the two edges of vertex k
//
// With the vectors a and b to the ends of an edge: MEC-1 has ρ = |a| + |b| − |a − b|, and MEC-2 has
// ρ = |a||b| + a·b.
#pragma once

#include <cageform/coordinates/entropy/facing.hpp>
#include <cageform/core/detail/simd_exp.hpp>
#include <cageform/core/detail/simd_log.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Computes the prior in `rows.weights`, with a common factor, which cancels in the weights. Returns the
/// result of `for_each_seen_edge`.
///
///   is_first  whether to compute MEC-1 instead of MEC-2
template <class N, class S>
WeightSum<ValueOf<N>> compute_published(const MeanValueFrame<S, 2>& cage, const MeanValueLimits<S>& limits,
                                        const Vec<ValueOf<N>, 2>& p, bool is_first,
                                        WeightRows<N>& rows) noexcept {
    using X = ValueOf<N>;
    for (N& q : rows.weights) q = N(X(S(0)));
    const auto found = for_each_seen_edge<N>(
        cage, limits, p,
        [&](std::size_t i, std::size_t next, const Spoke<N>& from, const Spoke<N>& to,
            const SeenEdge<N>& edge) {
            N rho = select(edge.acute, edge.s, edge.c * edge.c / edge.s);
            if (is_first)
                rho = rho / (from.r + to.r + N(X(S(length(vec_cast<double>(cage.corners[i].edge))))));
            const N logarithm = log(rho);
            rows.weights[i] += -logarithm;
            rows.weights[next] += -logarithm;
        });
    X most((std::numeric_limits<S>::lowest)());
    for (const N& q : rows.weights) most = (max)(most, value_of(q));
    for (N& q : rows.weights) q = exp(q - N(most));
    return found;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

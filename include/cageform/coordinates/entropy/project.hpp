// Projects rows of weights, with derivatives.
#pragma once

#include <cageform/core/affine/dual.hpp>
#include <cageform/core/affine/entropy_solver.hpp>

#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Added to the values of a row whose largest is 1, so that all handles count: they surround a place that
/// lies on the boundary up to rounding.
inline constexpr double least_prior = 1e-9;

/// Projects the prior q by EntropySolver. Returns 1 in lanes that converged.
///
///   N        a scalar, a register, or a Dual of one; the derivatives of Dual numbers are along the axes
///   q        the prior; of Dual numbers also the result: the weights with their derivatives
///   u        u(k): the vector from the point to handle k; its derivative is −1
///   prior    scratch memory, #q for Dual numbers, else 0
///   weights  the weights
///   skipped  1 in lanes whose weights are not needed
template <class N, std::size_t D, class U>
ValueOf<N> project_rows(std::span<N> q, const U& u, [[maybe_unused]] std::span<ValueOf<N>> prior,
                        std::span<ValueOf<N>> weights, const ValueOf<N>& skipped) noexcept {
    using X = ValueOf<N>;
    using S = ScalarOf<X>;
    if constexpr (!has_gradient<N>) {
        EntropySolver<X, D, U> solver(q, u, weights);
        const X converged = solver.solve(skipped, false), inverse = X(S(1)) / solver.sum();
        for (X& w : weights) w = w * inverse;
        return converged;
    } else {
        for (std::size_t k = 0; k < q.size(); ++k) prior[k] = q[k].value;
        EntropySolver<X, D, U> solver(prior, u, weights);
        const X converged = solver.solve(skipped, true), inverse = X(S(1)) / solver.sum();
        // One more step with derivatives: λ' = K⁻¹ ∂(Σ w u), and Σ w u = 0.
        const auto place = [&](std::size_t k) {
            Vec<N, D> to;
            const Vec<X, D> value = u(k);
            for (std::size_t c = 0; c < D; ++c) {
                to[c] = N(value[c]);
                to[c].gradient[c] = X(S(-1));
            }
            return to;
        };
        Vec<N, D> mean{}, multiplier;
        for (std::size_t c = 0; c < D; ++c) multiplier[c] = N(solver.multiplier()[c]);
        const auto weight = [&](std::size_t k, const Vec<N, D>& to) { // w_k, with the slope of q e^(−λ·u)
            N exponent{};
            for (std::size_t c = 0; c < D; ++c) exponent = exponent - multiplier[c] * to[c];
            const X value = inverse * weights[k];
            const X over = X(S(1)) / select(X(S(0)) < prior[k], prior[k], X(S(1)));
            N w(value);
            for (std::size_t c = 0; c < D; ++c)
                w.gradient[c] = value * (over * q[k].gradient[c] + exponent.gradient[c]);
            return w;
        };
        for (std::size_t k = 0; k < q.size(); ++k) {
            const auto to = place(k);
            const N w = weight(k, to);
            for (std::size_t c = 0; c < D; ++c) mean[c] = mean[c] + w * to[c];
        }
        const auto factors = solver.factors();
        for (std::size_t axis = 0; axis < D; ++axis) {
            Vec<X, D> slope;
            for (std::size_t c = 0; c < D; ++c) slope[c] = mean[c].gradient[axis];
            slope = factors.solve(slope);
            for (std::size_t c = 0; c < D; ++c) multiplier[c].gradient[axis] = slope[c];
        }
        N sum{};
        for (std::size_t k = 0; k < q.size(); ++k) {
            q[k] = weight(k, place(k));
            sum = sum + q[k];
        }
        for (N& w : q) w = w / sum;
        return converged;
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// Anderson acceleration of a fixed-point iteration.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/pose/detail/cholesky.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Accelerates x ← g(x) by the previous steps (Walker, Ni, Anderson acceleration for fixed-point iterations,
/// SIAM J. Numer. Anal. 49 (2011), sec. 2): with f = g(x) − x, the step is g − Σ θ_j Δg_j, where θ minimises
/// |f − Σ θ_j Δf_j|.
///
///   memory  2 (history + 1) vectors
///   cost    (3 history + 2) passes over a vector
class Anderson {
public:
    static constexpr std::size_t most = 10;

    /// Allocates for vectors of `blocks` blocks. May throw std::bad_alloc.
    void reset(std::size_t blocks, std::size_t history) {
        blocks_ = blocks;
        history_ = history < most ? history : most;
        memory_.resize(history_ == 0 ? 0 : 2 * (history_ + 1) * blocks);
        forget();
    }
    bool is_on() const noexcept { return history_ > 0; }
    void forget() noexcept {
        steps_ = 0;
        has_last_ = false;
    }

    /// Replaces x by the accelerated step.
    ///
    ///   x  the argument of g; out: the accelerated step
    ///   g  the step without acceleration
    void step(Lanes<double>* x, const Lanes<double>* g) noexcept {
        Lanes<double>*const last_g = row(0), *const last_f = row(1);
        if (has_last_) {
            const std::size_t at = steps_ % history_;
            Lanes<double>*const dg = row(2 + 2 * at), *const df = row(3 + 2 * at);
            for (std::size_t b = 0; b < blocks_; ++b) {
                const DoubleLanes f = DoubleLanes::load(g[b]) - DoubleLanes::load(x[b]);
                (DoubleLanes::load(g[b]) - DoubleLanes::load(last_g[b])).store(dg[b]);
                (f - DoubleLanes::load(last_f[b])).store(df[b]);
            }
            ++steps_;
        }
        has_last_ = true;
        for (std::size_t b = 0; b < blocks_; ++b) {
            (DoubleLanes::load(g[b]) - DoubleLanes::load(x[b])).store(last_f[b]);
            last_g[b] = g[b];
            x[b] = g[b];
        }
        const std::size_t count = steps_ < history_ ? steps_ : history_;
        double theta[most];
        if (count == 0 || !find_factors(count, theta)) return;
        for (std::size_t j = 0; j < count; ++j) {
            const Lanes<double>* const dg = row(2 + 2 * j);
            const DoubleLanes factor(theta[j]);
            for (std::size_t b = 0; b < blocks_; ++b)
                (DoubleLanes::load(x[b]) - factor * DoubleLanes::load(dg[b])).store(x[b]);
        }
    }

private:
    using DoubleLanes = Simd<double>;

    Lanes<double>* row(std::size_t n) noexcept { return memory_.data() + n * blocks_; }

    double product(std::size_t m, std::size_t n) noexcept {
        DoubleLanes sum(0);
        for (std::size_t b = 0; b < blocks_; ++b)
            sum = multiply_add(DoubleLanes::load(row(m)[b]), DoubleLanes::load(row(n)[b]), sum);
        return ordered_sum(sum);
    }

    /// Solves the normal equations, regularised by 1e-10 of their trace. Returns whether they are solvable.
    bool find_factors(std::size_t count, double* theta) noexcept {
        double a[most][most], trace = 0;
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t j = 0; j <= i; ++j) a[i][j] = product(3 + 2 * i, 3 + 2 * j);
            trace += a[i][i];
            theta[i] = product(3 + 2 * i, 1);
        }
        for (std::size_t i = 0; i < count; ++i) {
            a[i][i] += 1e-10 * trace;
            for (std::size_t j = 0; j <= i; ++j) {
                for (std::size_t k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
                if (j < i)
                    a[i][j] /= a[j][j];
                else if (a[i][i] > 0)
                    a[i][i] = std::sqrt(a[i][i]);
                else
                    return false;
            }
        }
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t k = 0; k < i; ++k) theta[i] -= a[i][k] * theta[k];
            theta[i] /= a[i][i];
        }
        for (std::size_t i = count; i-- > 0;) {
            for (std::size_t k = i + 1; k < count; ++k) theta[i] -= a[k][i] * theta[k];
            theta[i] /= a[i][i];
        }
        return true;
    }

    std::size_t blocks_ = 0, history_ = 0, steps_ = 0;
    bool has_last_ = false;
    std::vector<Lanes<double>> memory_; ///< g and f of the previous step, then pairs Δg, Δf of earlier steps
};

} // namespace cageform::inline CAGEFORM_ABI::detail

// Weights for the points of a star such that their weighted mean is exact for harmonic polynomials, in 2D.
//
// Standard finite differences are exact for all cubics. For harmonic functions it is enough that weights are
// exact for the real and imaginary parts of the powers of z. Equations have non-negative weights that are
// exact up to the third or fourth power. So the value of a node is a mean and never exceeds the values of its
// star. Samples first try weights of either sign with Σ |weight| ≤ 4, which are exact up to a higher power
// (harmonic_mean_of in grid/tree/star.hpp). Such samples can exceed the values at the nodes;
// coordinates/harmonic/cut_samples.hpp clamps the results to [0, 1].
//
// On a square of equal cells the result is the nine-point formula (Collatz, The Numerical Treatment of
// Differential Equations, 1960, ch. V). Next to smaller cells and to the boundary the weights solve a small
// constrained least-squares problem.
#pragma once

#include <cageform/grid/tree/screening.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Computes weights with sum 1 such that the weighted mean of each power of z relative to the centre is 0.
/// Among these it finds the weights of least Σ (weight distance²)². If they must be non-negative, it
/// removes the point of the most negative weight and solves again, until no weight is negative.
class HarmonicMean {
public:
    static constexpr std::size_t most = 32; ///< maximum number of points
    static constexpr unsigned most_degree = 4;

    void clear() noexcept { count_ = 0; }
    std::size_t count() const noexcept { return count_; }
    /// Adds a point by its offset from the centre. Scale the offsets to about 1 or less.
    ///
    ///   screening  κ² of the equation Δu = κ²u, in units of the offsets. If it is not 0, solutions of that
    ///              equation replace the powers of z (screened_factor), and the sum of the weights is below 1
    void add(const Vec<double, 2>& offset, double screening) noexcept {
        Moments& m = moments_[count_];
        constexpr double nearest = 0.03; // lower bound of the distance for the prior
        const double square = (std::max)(dot(offset, offset), nearest * nearest);
        prior_[count_++] = 1 / (square * square);
        const auto factor = [square = screening * dot(offset, offset)](std::size_t degree) {
            return square > 0 ? screened_factor<2>(unsigned(degree), square) : 1.0;
        };
        m[0] = factor(0);
        double re = 1, im = 0;
        for (std::size_t k = 1; k <= most_degree; ++k) {
            const double next = re * offset[0] - im * offset[1];
            im = re * offset[1] + im * offset[0];
            re = next;
            const double of_degree = factor(k);
            m[2 * k - 1] = re * of_degree;
            m[2 * k] = im * of_degree;
        }
    }

    /// Finds non-negative weights. Returns the highest degree, from `highest` down to `least`, for which
    /// they are exact, or 0 if there are none.
    unsigned solve(unsigned highest, unsigned least) noexcept {
        for (unsigned degree = highest; degree >= least; --degree) {
            if (solve_moments(2 * degree + 1)) return degree;
        }
        return 0;
    }
    /// Finds weights of either sign with Σ |weight| ≤ `limit`; returns their degree like `solve`.
    unsigned solve_signed(unsigned highest, unsigned least, double limit) noexcept {
        std::array<bool, most> all{};
        for (std::size_t n = 0; n < count_; ++n) all[n] = true;
        for (unsigned degree = highest; degree >= least; --degree) {
            set_least(all, 2 * degree + 1);
            double sum = 0;
            for (std::size_t n = 0; n < count_; ++n) sum += std::fabs(weights_[n]);
            if (sum <= limit && is_exact(2 * degree + 1)) return degree;
        }
        return 0;
    }
    double weight(std::size_t n) const noexcept { return weights_[n]; }

private:
    static constexpr std::size_t rows = 2 * most_degree + 1;
    using Moments = std::array<double, rows>;

    /// Finds non-negative weights for a number of moments by an active-set method.
    bool solve_moments(std::size_t moments) noexcept {
        std::array<bool, most> left{};
        for (std::size_t n = 0; n < count_; ++n) left[n] = true;
        for (std::size_t count = count_; 2 * count >= moments;) {
            set_least(left, moments);
            std::size_t worst = count_;
            for (std::size_t n = 0; n < count_; ++n) {
                if (left[n] && weights_[n] < 0 && (worst == count_ || weights_[n] < weights_[worst]))
                    worst = n;
            }
            if (worst == count_) return is_exact(moments);
            left[worst] = false;
            --count;
        }
        return false;
    }
    /// Whether the sum of the weights is 1 and every moment is 0.
    bool is_exact(std::size_t moments) const noexcept {
        Moments sum{};
        for (std::size_t n = 0; n < count_; ++n) {
            for (std::size_t k = 0; k < moments; ++k) sum[k] += weights_[n] * moments_[n][k];
        }
        sum[0] -= 1;
        double largest = 0;
        for (std::size_t k = 0; k < moments; ++k) largest = (std::max)(largest, std::fabs(sum[k]));
        return largest <= 1e-9;
    }
    /// Solves the constrained least-squares problem with Lagrange multipliers λ: weights = prior Mᵀ λ,
    /// where (M prior Mᵀ) λ = (1, 0, …).
    void set_least(const std::array<bool, most>& left, std::size_t moments) noexcept {
        std::array<Moments, rows> a{};
        for (std::size_t n = 0; n < count_; ++n) {
            if (!left[n]) continue;
            for (std::size_t i = 0; i < moments; ++i) {
                const double weighted = prior_[n] * moments_[n][i];
                for (std::size_t j = 0; j <= i; ++j) a[i][j] += weighted * moments_[n][j];
            }
        }
        Moments x{};
        x[0] = 1;
        for (std::size_t i = 0; i < moments; ++i) { // Cholesky
            const double whole = a[i][i];
            for (std::size_t j = 0; j <= i; ++j) {
                double sum = a[i][j];
                for (std::size_t k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
                if (j < i) {
                    a[i][j] = sum * a[j][j];
                } else { // the inverse; 0 if a moment depends linearly on those before
                    a[i][i] = sum > 1e-12 * whole ? 1 / std::sqrt(sum) : 0;
                }
            }
            for (std::size_t k = 0; k < i; ++k) x[i] -= a[i][k] * x[k];
            x[i] *= a[i][i];
        }
        for (std::size_t i = moments; i-- > 0;) {
            for (std::size_t k = i + 1; k < moments; ++k) x[i] -= a[k][i] * x[k];
            x[i] *= a[i][i];
        }
        for (std::size_t n = 0; n < count_; ++n) {
            double sum = 0;
            for (std::size_t k = 0; k < moments && left[n]; ++k) sum += x[k] * moments_[n][k];
            weights_[n] = prior_[n] * sum;
        }
    }

    std::array<Moments, most> moments_;
    std::array<double, most> prior_, weights_;
    std::size_t count_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

// Sparse weights of one vertex: a small quadratic program on the simplex.
#pragma once

#include <cageform/config.hpp>

#include <array>
#include <cmath>
#include <cstddef>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Minimises wᵀQw − 2fᵀw for w ≥ 0, Σw = 1 by an active set method (after Lawson and Hanson, Solving Least
/// Squares Problems, 1974, ch. 23). Q is positive definite.
class SimplexWeights {
public:
    static constexpr std::size_t max_candidates = 24;

    std::size_t count = 0;
    std::array<std::array<double, max_candidates>, max_candidates> q;
    std::array<double, max_candidates> f;
    /// In: a feasible start. Out: the solution.
    std::array<double, max_candidates> w;

    /// Makes the start feasible: divides weights by their sum, or sets the first one to 1.
    void start() noexcept {
        double sum = 0;
        for (std::size_t c = 0; c < count; ++c) sum += w[c];
        for (std::size_t c = 0; c < count; ++c) w[c] = sum > 0 ? w[c] / sum : c == 0 ? 1 : 0;
    }
    /// Solves; while more than `influences` weights are positive, removes the smallest and solves again.
    void solve(std::size_t influences) noexcept {
        size_ = 0;
        for (std::size_t c = 0; c < count; ++c) {
            if (w[c] > 0) active_[size_++] = c;
        }
        double trace = 0;
        for (std::size_t c = 0; c < count; ++c) trace += q[c][c];
        const double tolerance = 1e-10 * trace / double(count);
        std::size_t last = count;
        for (std::size_t step = 0; step < 4 * max_candidates; ++step) {
            if (!move_to_minimum()) continue;
            const std::size_t next = steepest(tolerance);
            if (next == count || next == last) break;
            last = next;
            w[next] = 0;
            active_[size_++] = next;
        }
        while (size_ > influences) {
            std::size_t least = 0;
            for (std::size_t a = 1; a < size_; ++a) {
                if (w[active_[a]] < w[active_[least]]) least = a;
            }
            drop(least);
            normalise();
            while (!move_to_minimum()) {}
        }
    }

    /// Returns wᵀQw − 2fᵀw.
    double value() const noexcept {
        double sum = 0;
        for (std::size_t a = 0; a < size_; ++a) {
            double row = -2 * f[active_[a]];
            for (std::size_t b = 0; b < size_; ++b) row += q[active_[a]][active_[b]] * w[active_[b]];
            sum += row * w[active_[a]];
        }
        return sum;
    }

private:
    void drop(std::size_t a) noexcept {
        w[active_[a]] = 0;
        for (--size_; a < size_; ++a) active_[a] = active_[a + 1];
    }
    void normalise() noexcept {
        double sum = 0;
        for (std::size_t a = 0; a < size_; ++a) sum += w[active_[a]];
        for (std::size_t a = 0; a < size_; ++a)
            w[active_[a]] = sum > 0 ? w[active_[a]] / sum : 1 / double(size_);
    }
    /// Moves to the minimum over the active weights with sum 1. Stops where a weight reaches 0 and removes
    /// that weight. Returns true if the minimum was reached.
    bool move_to_minimum() noexcept {
        if (size_ == 1) {
            w[active_[0]] = 1;
            return true;
        }
        std::array<double, max_candidates> y;
        minimum(y);
        double fraction = 1;
        std::size_t first = size_;
        for (std::size_t a = 0; a < size_; ++a) {
            if (y[a] > 0) continue;
            const double here = w[active_[a]], to = here / (here - y[a]);
            if (first < size_ && !(to < fraction)) continue;
            first = a;
            fraction = here > 0 ? to : 0;
        }
        for (std::size_t a = 0; a < size_; ++a) {
            double& x = w[active_[a]];
            x = first == size_ ? y[a] : std::fmax(0.0, x + fraction * (y[a] - x));
        }
        if (first == size_) return true;
        drop(first);
        normalise();
        return false;
    }
    /// Minimum over the active weights with sum 1, without bounds.
    void minimum(std::array<double, max_candidates>& y) noexcept {
        std::array<double, max_candidates> ones;
        for (std::size_t r = 0; r < size_; ++r) {
            const std::size_t i = active_[r];
            for (std::size_t c = 0; c <= r; ++c) {
                double sum = q[i][active_[c]];
                for (std::size_t k = 0; k < c; ++k) sum -= l_[r][k] * l_[c][k];
                l_[r][c] = c < r ? sum * inverse_[c] : sum;
            }
            inverse_[r] = 1 / std::sqrt(std::fmax(l_[r][r], 1e-14 * q[i][i]));
            double one = 1, right = f[i];
            for (std::size_t k = 0; k < r; ++k) {
                one -= l_[r][k] * ones[k];
                right -= l_[r][k] * y[k];
            }
            ones[r] = one * inverse_[r];
            y[r] = right * inverse_[r];
        }
        double sum_one = 0, sum = 0;
        for (std::size_t r = size_; r-- > 0;) {
            for (std::size_t k = r + 1; k < size_; ++k) {
                ones[r] -= l_[k][r] * ones[k];
                y[r] -= l_[k][r] * y[k];
            }
            ones[r] *= inverse_[r];
            y[r] *= inverse_[r];
            sum_one += ones[r];
            sum += y[r];
        }
        const double level = (1 - sum) / sum_one;
        for (std::size_t r = 0; r < size_; ++r) y[r] += level * ones[r];
    }
    double slope(std::size_t c) const noexcept {
        double g = -f[c];
        for (std::size_t a = 0; a < size_; ++a) g += q[c][active_[a]] * w[active_[a]];
        return g;
    }
    /// Candidate of steepest descent, or `count`.
    std::size_t steepest(double tolerance) const noexcept {
        double level = 0;
        for (std::size_t a = 0; a < size_; ++a) level += w[active_[a]] * slope(active_[a]);
        std::size_t best = count;
        double least = level - tolerance;
        for (std::size_t c = 0; c < count; ++c) {
            if (w[c] > 0) continue;
            const double g = slope(c);
            if (g < least) {
                least = g;
                best = c;
            }
        }
        return best;
    }

    std::size_t size_ = 0;
    std::array<std::size_t, max_candidates + 1> active_;
    std::array<std::array<double, max_candidates>, max_candidates> l_;
    std::array<double, max_candidates> inverse_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

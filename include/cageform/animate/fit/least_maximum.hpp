// Fits in the sup norm by iteratively reweighted least squares.
#pragma once

#include <cageform/animate/fit/fit_errors.hpp>
#include <cageform/animate/fit/normal_equations.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Minimises the maximum error over `count` coefficients of a piece, from index `first` on. Repeats a
/// least-squares fit whose sample weights are multiplied by the errors (Lawson 1961); keeps the best piece.
class LeastMaximum {
public:
    LeastMaximum(const FitProblem& problem, const FitPiece& piece, std::size_t first, std::size_t count)
        : problem_(problem)
        , first_(first)
        , count_(count) {
        weight_.fill(1);
        for (std::size_t k = 0; k < samples; ++k) {
            const double v = 0.5 - 0.5 * std::cos(3.141592653589793 * (double(k) + 0.5) / double(samples));
            sample(piece, v, k);
        }
    }

    void improve(FitPiece& piece) {
        double least = largest_error(problem_, piece);
        for (int round = 0; round < 40; ++round) {
            const Coefficients solution = weighted_least_squares();
            double largest = 0;
            std::array<double, samples> error{};
            for (std::size_t k = 0; k < samples; ++k) {
                double left = rest_[k];
                for (std::size_t i = 0; i < count_; ++i) left -= basis_[k][i] * solution[i];
                error[k] = std::fabs(left);
                largest = std::fmax(largest, error[k]);
            }
            if (!(largest > 0)) return;
            // The small constant keeps weights positive.
            for (std::size_t k = 0; k < samples; ++k) weight_[k] *= error[k] / largest + 1e-12;
            if (largest >= least) continue;
            FitPiece moved = piece;
            for (std::size_t i = 0; i < count_; ++i) moved.polynomial.c[first_ + i] = solution[i];
            if (const double exact = largest_error(problem_, moved); exact < least) {
                least = exact;
                piece = moved;
            }
        }
    }

private:
    /// Computes the free basis polynomials at a sample, and the curve minus the fixed terms.
    void sample(const FitPiece& piece, double fraction, std::size_t k) {
        const std::size_t d = problem_.options.degree;
        const double t = piece.begin + fraction * (piece.end - piece.begin);
        const double u = (problem_.function.time()(t) - piece.x_begin) / piece.length();
        rest_[k] = problem_.function.value()(t);
        for (std::size_t j = 0; j <= d; ++j) {
            const double value = binomials[d][j] * std::pow(u, double(j)) * std::pow(1 - u, double(d - j));
            if (j >= first_ && j < first_ + count_) {
                basis_[k][j - first_] = value;
            } else {
                rest_[k] -= piece.polynomial.c[j] * value;
            }
        }
    }

    Coefficients weighted_least_squares() const noexcept {
        FitMatrix normal{};
        Coefficients right{};
        for (std::size_t k = 0; k < samples; ++k) {
            for (std::size_t i = 0; i < count_; ++i) {
                for (std::size_t j = 0; j <= i; ++j) normal[i][j] += weight_[k] * basis_[k][i] * basis_[k][j];
                right[i] += weight_[k] * rest_[k] * basis_[k][i];
            }
        }
        solve_symmetric(normal, right, count_);
        return right;
    }

    static constexpr std::size_t samples = 48;
    const FitProblem& problem_;
    std::size_t first_, count_;
    std::array<Coefficients, samples> basis_{};
    std::array<double, samples> rest_{}, weight_{};
};

} // namespace cageform::inline CAGEFORM_ABI::detail

// The normal equations of a fitted piece: G b = l for its Bernstein coefficients b, with the Gram
// matrix G of the basis and the load vector l of the curve.
#pragma once

#include <cageform/animate/fit/linear_systems.hpp>
#include <cageform/core/detail/gauss.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// ∫ B_a B_b over [0, 1] of two Bernstein polynomials of degree n; 0 for an index out of range.
inline double bernstein_product(std::size_t n, std::size_t a, std::size_t b) noexcept {
    if (a > n || b > n) return 0;
    return binomials[n][a] * binomials[n][b] / (binomials[2 * n][a + b] * double(2 * n + 1));
}

/// G_ij = w0 ∫ B_i B_j dx + w1 ∫ B_i' B_j' dx on an interval of length h.
inline FitMatrix gram_matrix(const FitProblem& problem, double h) noexcept {
    const std::size_t d = problem.options.degree;
    const double of_values = problem.options.value_weight * h;
    const double of_slopes = problem.options.slope_weight * double(d * d) / h;
    FitMatrix gram{};
    for (std::size_t i = 0; i <= d; ++i) {
        for (std::size_t j = 0; j <= d; ++j) {
            // B_i' = d (B_(i−1) − B_i), of degree d − 1. Index −1 wraps to one out of range.
            const double slopes = bernstein_product(d - 1, i - 1, j - 1) -
                                  bernstein_product(d - 1, i - 1, j) - bernstein_product(d - 1, i, j - 1) +
                                  bernstein_product(d - 1, i, j);
            gram[i][j] = of_values * bernstein_product(d, i, j) + of_slopes * slopes;
        }
    }
    return gram;
}

/// All Bernstein polynomials of degree d at u, and all of degree d − 1.
struct BernsteinBasis {
    Coefficients values{}, lower{};

    BernsteinBasis(std::size_t d, double u) noexcept {
        lower[0] = 1;
        for (std::size_t n = 1; n < d; ++n) raise(lower, n, u);
        values = lower;
        raise(values, d, u);
    }

private:
    /// Raises the degree from n − 1 to n.
    static void raise(Coefficients& b, std::size_t n, double u) noexcept {
        for (std::size_t i = n; i > 0; --i) b[i] = (1 - u) * b[i] + u * b[i - 1];
        b[0] *= 1 - u;
    }
};

/// l_j = w0 ∫ C B_j dx + w1 ∫ C' B_j' dx. With the curve's parameter as variable, integrands are polynomials.
template <std::size_t Nodes>
Coefficients load_by_rule(const FitProblem& problem, const FitPiece& piece) {
    const auto& rule = Gauss<Nodes>::rule();
    const auto &time = problem.function.time(), &value = problem.function.value();
    const std::size_t d = problem.options.degree;
    const double h = piece.length(), width = piece.end - piece.begin;
    Coefficients load{};
    for (std::size_t n = 0; n < Nodes; ++n) {
        const double t = piece.begin + width * rule.node[n];
        const BernsteinBasis basis(d, (time(t) - piece.x_begin) / h);
        const double weight = rule.weight[n] * width;
        const double of_value = problem.options.value_weight * weight * value(t) * time.slope(t);
        const double of_slope = problem.options.slope_weight * weight * value.slope(t) * double(d) / h;
        for (std::size_t j = 0; j <= d; ++j) {
            const double slope = (j > 0 ? basis.lower[j - 1] : 0) - (j < d ? basis.lower[j] : 0);
            load[j] += of_value * basis.values[j] + of_slope * slope;
        }
    }
    return load;
}

/// The exact load: integrands have degree 3 d + 5, and a rule of N nodes is exact to degree 2 N − 1.
inline Coefficients load(const FitProblem& problem, const FitPiece& piece) {
    return problem.options.degree == 3 ? load_by_rule<8>(problem, piece) : load_by_rule<11>(problem, piece);
}

/// Solves for `count` coefficients of a piece, from index `first` on; the others are fixed.
inline void solve_normal_equations(const FitProblem& problem, FitPiece& piece, std::size_t first,
                                   std::size_t count) {
    const FitMatrix gram = gram_matrix(problem, piece.length());
    const Coefficients right = load(problem, piece);
    auto& b = piece.polynomial.c;
    FitMatrix free{};
    Coefficients rest{};
    for (std::size_t i = 0; i < count; ++i) {
        rest[i] = right[first + i];
        for (std::size_t j = 0; j <= problem.options.degree; ++j) {
            if (j >= first && j < first + count) {
                free[i][j - first] = gram[first + i][j];
            } else {
                rest[i] -= gram[first + i][j] * b[j];
            }
        }
    }
    solve_symmetric(free, rest, count);
    for (std::size_t i = 0; i < count; ++i) b[first + i] = rest[i];
}

} // namespace cageform::inline CAGEFORM_ABI::detail

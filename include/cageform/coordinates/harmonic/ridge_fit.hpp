// A least squares fit with a ridge.
#pragma once

#include <cageform/config.hpp>

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Solves a weighted least squares fit. The share of a datum in a function is its factor in the coefficient
/// of the function.
///
///   basis   #data · #functions values, data after data
///   weight  #data
///   ridge   #functions
///   shares  gets #functions · #data values, function after function
class RidgeFit {
public:
    void solve(std::span<const double> basis, std::span<const double> weight, std::span<const double> ridge,
               std::vector<double>& shares) {
        const std::size_t n = ridge.size(), data = weight.size();
        matrix_.assign(n * n, 0.0);
        for (std::size_t d = 0; d < data; ++d) {
            const double* const b = basis.data() + d * n;
            for (std::size_t i = 0; i < n; ++i) {
                const double factor = weight[d] * b[i];
                for (std::size_t j = 0; j <= i; ++j) matrix_[i * n + j] += factor * b[j];
            }
        }
        for (std::size_t i = 0; i < n; ++i) matrix_[i * n + i] += ridge[i];
        for (std::size_t i = 0; i < n; ++i) { // Cholesky, in place
            for (std::size_t j = 0; j <= i; ++j) {
                double sum = matrix_[i * n + j];
                for (std::size_t k = 0; k < j; ++k) sum -= matrix_[i * n + k] * matrix_[j * n + k];
                matrix_[i * n + j] = i == j ? std::sqrt(sum) : sum / matrix_[j * n + j];
            }
        }
        shares.resize(n * data);
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t d = 0; d < data; ++d) shares[i * data + d] = weight[d] * basis[d * n + i];
        }
        const auto subtract = [&](std::size_t i, std::size_t k, double factor) {
            for (std::size_t d = 0; d < data; ++d) shares[i * data + d] -= factor * shares[k * data + d];
        };
        const auto divide = [&](std::size_t i) {
            const double factor = 1 / matrix_[i * n + i];
            for (std::size_t d = 0; d < data; ++d) shares[i * data + d] *= factor;
        };
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t k = 0; k < i; ++k) subtract(i, k, matrix_[i * n + k]);
            divide(i);
        }
        for (std::size_t i = n; i-- > 0;) {
            for (std::size_t k = i + 1; k < n; ++k) subtract(i, k, matrix_[k * n + i]);
            divide(i);
        }
    }

private:
    std::vector<double> matrix_; ///< the lower triangle
};

} // namespace cageform::inline CAGEFORM_ABI::detail

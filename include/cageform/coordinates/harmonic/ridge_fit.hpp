// A least squares fit with a ridge.
#pragma once

#include <cageform/config.hpp>

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Solves a weighted least squares fit. Returns the shares of data in functions: #functions · #data values,
/// function after function. The share of a datum is its factor in the coefficient of the function.
///
///   basis   #data · #functions values, data after data
///   weight  #data
///   ridge   #functions
inline std::vector<double> ridge_fit(std::span<const double> basis, std::span<const double> weight,
                                     std::span<const double> ridge) {
    const std::size_t n = ridge.size(), data = weight.size();
    std::vector<double> matrix(n * n), shares(n * data); // of the matrix the lower triangle
    for (std::size_t d = 0; d < data; ++d) {
        const double* const b = basis.data() + d * n;
        for (std::size_t i = 0; i < n; ++i) {
            const double weighted = weight[d] * b[i];
            for (std::size_t j = 0; j <= i; ++j) matrix[i * n + j] += weighted * b[j];
            shares[i * data + d] = weighted;
        }
    }
    for (std::size_t i = 0; i < n; ++i) { // Cholesky, in place
        matrix[i * n + i] += ridge[i];
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = matrix[i * n + j];
            for (std::size_t k = 0; k < j; ++k) sum -= matrix[i * n + k] * matrix[j * n + k];
            matrix[i * n + j] = i == j ? std::sqrt(sum) : sum / matrix[j * n + j];
        }
    }
    const auto subtract = [&](std::size_t i, std::size_t k, double factor) {
        for (std::size_t d = 0; d < data; ++d) shares[i * data + d] -= factor * shares[k * data + d];
    };
    const auto divide = [&](std::size_t i) {
        const double factor = 1 / matrix[i * n + i];
        for (std::size_t d = 0; d < data; ++d) shares[i * data + d] *= factor;
    };
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < i; ++k) subtract(i, k, matrix[i * n + k]);
        divide(i);
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) subtract(i, k, matrix[k * n + i]);
        divide(i);
    }
    return shares;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

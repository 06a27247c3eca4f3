// A least-squares fit with a ridge.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/core/types/blocks.hpp>
#include <cageform/core/types/buffer.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Solves a weighted least-squares fit. The share of a datum is its factor in a function's coefficient. Cost:
/// O(#functions² (#functions + #data)).
///
///   width   number of columns computed, at least #functions
///   basis   #data rows: the values of the functions at a datum, padded by zeros
///   weight  #data
///   ridge   #functions
///   shares  out: #functions rows of #data shares, in SIMD blocks padded by zeros
template <std::size_t width, std::size_t most>
void ridge_fit(std::span<const std::array<double, most>> basis, std::span<const double> weight,
               std::span<const double> ridge, Buffer<Lanes<double>>& shares) {
    using X = Simd<double>;
    const std::size_t n = ridge.size(), data = weight.size(), blocks = block_count<double>(data);
    std::array<std::array<double, width>, width>
        matrix;                        // only the upper triangle matters; full rows are faster
    std::array<double, width> inverse; // reciprocals of the diagonal
    for (std::size_t i = 0; i < n; ++i) {
        std::array<double, width> row{};
        row[i] = ridge[i];
        for (std::size_t d = 0; d < data; ++d) {
            const double weighted = weight[d] * basis[d][i];
            for (std::size_t j = 0; j < width; ++j) row[j] += weighted * basis[d][j];
        }
        matrix[i] = row;
    }
    for (std::size_t k = 0; k < n; ++k) { // Cholesky, in place
        inverse[k] = 1 / std::sqrt(matrix[k][k]);
        for (double& x : matrix[k]) x *= inverse[k];
        for (std::size_t i = k + 1; i < n; ++i) {
            const double factor = matrix[k][i];
            for (std::size_t j = 0; j < width; ++j) matrix[i][j] -= factor * matrix[k][j];
        }
    }
    shares.resize(n * blocks);
    for (std::size_t b = 0; b < blocks; ++b) {
        std::array<X, width> x;
        for (std::size_t i = 0; i < n; ++i) {
            Lanes<double> weighted;
            for (std::size_t lane = 0; lane < lane_count<double>; ++lane) {
                const std::size_t d = b * lane_count<double> + lane;
                weighted[lane] = d < data ? weight[d] * basis[d][i] : 0;
            }
            x[i] = X::load(weighted);
        }
        for (std::size_t k = 0; k < n; ++k) {
            x[k] *= X(inverse[k]);
            for (std::size_t i = k + 1; i < n; ++i) x[i] -= X(matrix[k][i]) * x[k];
        }
        for (std::size_t k = n; k-- > 0;) {
            x[k] *= X(inverse[k]);
            for (std::size_t i = 0; i < k; ++i) x[i] -= X(matrix[i][k]) * x[k];
            x[k].store(shares[k * blocks + b]);
        }
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail

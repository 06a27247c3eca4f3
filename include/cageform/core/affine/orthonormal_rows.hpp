// Orthonormalises the columns of a matrix that is stored by rows.
#pragma once

#include <cageform/core/types/buffer.hpp>
#include <cageform/core/vec.hpp>

#include <array>
#include <cmath>
#include <utility>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The factorisation A = QR, with orthonormal columns of Q. Columns of A that depend linearly on
/// earlier ones are zero in Q.
template <std::size_t K>
class OrthonormalRows {
public:
    /// Gram–Schmidt, each column orthogonalised twice (Giraud, Langou, Rozložník, The loss of
    /// orthogonality in the Gram–Schmidt orthogonalization process, Comput. Math. Appl. 50 (2005)).
    explicit OrthonormalRows(Buffer<Vec<double, K>> rows)
        : q_(std::move(rows)) {
        for (std::size_t k = 0; k < K; ++k) {
            const double given = std::sqrt(inner(k, k));
            if (given == 0) { // or its square underflows
                for (auto& row : q_) row[k] = 0;
                continue;
            }
            for (const int pass : {1, 2}) {
                (void)pass;
                for (std::size_t j = 0; j < k; ++j) {
                    const double projection = inner(j, k);
                    triangle_[k][j] += projection;
                    for (auto& row : q_) row[k] -= projection * row[j];
                }
            }
            const double rest = std::sqrt(inner(k, k));
            triangle_[k][k] = rest > 2 * epsilon<double> * given ? 1 / rest : 0;
            for (auto& row : q_) row[k] *= triangle_[k][k];
        }
    }

    const Vec<double, K>& operator[](std::size_t row) const noexcept { return q_[row]; }
    /// Returns Rᵀ below the diagonal; on the diagonal the inverses of R's diagonal, or 0 for a zero
    /// column of Q.
    const Vec<Vec<double, K>, K>& triangle() const noexcept { return triangle_; }

private:
    double inner(std::size_t j, std::size_t k) const noexcept {
        double sum = 0;
        for (const auto& row : q_) sum += row[j] * row[k];
        return sum;
    }

    Buffer<Vec<double, K>> q_;
    Vec<Vec<double, K>, K> triangle_{};
};

/// Returns R⁻ᵀ x for a `triangle` of OrthonormalRows: the row of Q for a row x of A.
template <class X, class S, std::size_t K>
std::array<X, K> in_basis(const Vec<Vec<S, K>, K>& triangle, const std::array<X, K>& x) noexcept {
    std::array<X, K> z;
    for (std::size_t k = 0; k < K; ++k) {
        z[k] = x[k];
        for (std::size_t j = 0; j < k; ++j) z[k] = z[k] - X(triangle[k][j]) * z[j];
        z[k] = z[k] * X(triangle[k][k]);
    }
    return z;
}

/// Returns R⁻¹ z: the coefficients of A's columns whose sum is Q z; 0 for zero columns of Q.
template <std::size_t K>
Vec<double, K> coefficients(const Vec<Vec<double, K>, K>& triangle, Vec<double, K> z) noexcept {
    for (std::size_t k = K; k-- > 0;) {
        for (std::size_t j = k + 1; j < K; ++j) z[k] -= triangle[j][k] * z[j];
        z[k] *= triangle[k][k];
    }
    return z;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

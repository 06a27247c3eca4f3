// Symmetric matrices of a few rows: sums of outer products, their axes and their equations.
#pragma once

#include <cageform/core/vec.hpp>

#include <Eigen/Jacobi>

#include <algorithm>
#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Row by row.
template <std::size_t N>
using SquareMatrix = Vec<Vec<double, N>, N>;

/// m += a bᵀ.
template <std::size_t N>
void add_outer_product(SquareMatrix<N>& m, const Vec<double, N>& a, const Vec<double, N>& b) noexcept {
    for (std::size_t r = 0; r < N; ++r) m[r] = m[r] + a[r] * b;
}

/// m a.
template <std::size_t N>
Vec<double, N> product(const SquareMatrix<N>& m, const Vec<double, N>& a) noexcept {
    Vec<double, N> result{};
    for (std::size_t r = 0; r < N; ++r) result[r] = dot(m[r], a);
    return result;
}

/// The x of m x = b, m positive definite: Cholesky's factors.
template <std::size_t N>
Vec<double, N> solve_positive_definite(SquareMatrix<N> m, Vec<double, N> b) noexcept {
    for (std::size_t r = 0; r < N; ++r) {
        for (std::size_t c = 0; c <= r; ++c) {
            for (std::size_t k = 0; k < c; ++k) m[r][c] -= m[r][k] * m[c][k];
            m[r][c] = c < r ? m[r][c] / m[c][c] : std::sqrt(m[r][r]);
        }
        for (std::size_t k = 0; k < r; ++k) b[r] -= m[r][k] * b[k];
        b[r] /= m[r][r];
    }
    for (std::size_t r = N; r-- > 0;) {
        for (std::size_t k = r + 1; k < N; ++k) b[r] -= m[k][r] * b[k];
        b[r] /= m[r][r];
    }
    return b;
}

/// The eigenvalues of a symmetric matrix, and eigenvectors of unit length.
template <std::size_t N>
struct PrincipalAxes {
    Vec<double, N> values{};
    SquareMatrix<N> vectors{}; ///< the rows

    double least() const noexcept { return *std::min_element(values.v, values.v + N); }
    double largest() const noexcept { return *std::max_element(values.v, values.v + N); }
};

/// Jacobi's rotations, row by row. Golub, Van Loan, Matrix Computations, 4th ed., sec. 8.5.
template <std::size_t N>
PrincipalAxes<N> principal_axes(SquareMatrix<N> m) {
    PrincipalAxes<N> axes;
    double rounding = 0;
    for (std::size_t k = 0; k < N; ++k) {
        axes.vectors[k][k] = 1;
        rounding += 0.125 * epsilon<double> * std::fabs(m[k][k]);
    }
    bool turned = true;
    for (int sweep = 0; turned && sweep < 30; ++sweep) { // five or six as a rule
        turned = false;
        for (std::size_t p = 0; p < N; ++p) {
            for (std::size_t q = p + 1; q < N; ++q) {
                if (!(std::fabs(m[p][q]) > rounding)) continue;
                turned = true;
                Eigen::JacobiRotation<double> rotation;
                rotation.makeJacobi(m[p][p], m[p][q], m[q][q]);
                const double c = rotation.c(), s = rotation.s();
                const auto turn = [c, s](auto& a, auto& b) {
                    const auto old = a;
                    a = c * old - s * b;
                    b = s * old + c * b;
                };
                turn(m[p], m[q]);
                for (std::size_t r = 0; r < N; ++r) turn(m[r][p], m[r][q]);
                m[p][q] = m[q][p] = 0;
                turn(axes.vectors[p], axes.vectors[q]);
            }
        }
    }
    for (std::size_t k = 0; k < N; ++k) axes.values[k] = m[k][k];
    return axes;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

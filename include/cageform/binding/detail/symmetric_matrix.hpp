// Small symmetric matrices: sums of outer products, and their eigenvalues and eigenvectors.
#pragma once

#include <cageform/core/vec.hpp>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Stored by rows.
template <std::size_t N>
using SquareMatrix = Vec<Vec<double, N>, N>;

/// Adds a bᵀ to m.
template <std::size_t N>
void add_outer_product(SquareMatrix<N>& m, const Vec<double, N>& a, const Vec<double, N>& b) noexcept {
    for (std::size_t r = 0; r < N; ++r) m[r] = m[r] + a[r] * b;
}

/// Returns m a.
template <std::size_t N>
Vec<double, N> product(const SquareMatrix<N>& m, const Vec<double, N>& a) noexcept {
    Vec<double, N> result{};
    for (std::size_t r = 0; r < N; ++r) result[r] = dot(m[r], a);
    return result;
}

/// Eigen's matrix for N rows. All N up to 8 share one type, so that its decompositions are compiled
/// once. Does not allocate.
template <std::size_t N>
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, int(N < 8 ? 8 : N),
                                  int(N < 8 ? 8 : N)>;

/// The eigenvalues of a symmetric matrix in increasing order, and eigenvectors of unit length.
template <std::size_t N>
struct PrincipalAxes {
    Vec<double, N> values{};
    SquareMatrix<N> vectors{}; ///< the rows

    double least() const noexcept { return values[0]; }
    double largest() const noexcept { return values[N - 1]; }
};

template <std::size_t N>
PrincipalAxes<N> principal_axes(const SquareMatrix<N>& m) {
    const Eigen::Map<const Eigen::MatrixXd> matrix(m[0].v, long(N), long(N));
    const Eigen::SelfAdjointEigenSolver<SmallMatrix<N>> solver(matrix);
    PrincipalAxes<N> axes;
    for (std::size_t k = 0; k < N; ++k) {
        axes.values[k] = solver.eigenvalues()[long(k)];
        for (std::size_t r = 0; r < N; ++r) axes.vectors[k][r] = solver.eigenvectors()(long(r), long(k));
    }
    return axes;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

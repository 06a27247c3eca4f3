// Symmetric matrices of a few rows: sums of outer products, their axes and their equations.
#pragma once

#include <cageform/core/vec.hpp>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <type_traits>

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

/// Eigen's matrix of the same numbers: one type for all sizes up to eight, so that its decompositions
/// are compiled once, and nothing is allocated.
template <std::size_t N>
auto eigen_matrix(const SquareMatrix<N>& m) {
    constexpr int capacity = N < 8 ? 8 : int(N);
    using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, capacity, capacity>;
    return Matrix(Eigen::Map<const Eigen::MatrixXd>(m[0].v, long(N), long(N)));
}

/// The x of m x = b, m positive definite.
template <std::size_t N>
Vec<double, N> solve_positive_definite(const SquareMatrix<N>& m, Vec<double, N> b) {
    eigen_matrix<N>(m).llt().solveInPlace(Eigen::Map<Eigen::VectorXd>(b.v, long(N)));
    return b;
}

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
    const auto matrix = eigen_matrix<N>(m);
    const Eigen::SelfAdjointEigenSolver<std::remove_const_t<decltype(matrix)>> solver(matrix);
    PrincipalAxes<N> axes;
    for (std::size_t k = 0; k < N; ++k) {
        axes.values[k] = solver.eigenvalues()[long(k)];
        for (std::size_t r = 0; r < N; ++r) axes.vectors[k][r] = solver.eigenvectors()(long(r), long(k));
    }
    return axes;
}

} // namespace cageform::inline CAGEFORM_ABI::detail

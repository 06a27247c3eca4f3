// Linear solvers of a fit: a small dense one per piece, and a banded one for all pieces. (Eigen's
// solvers take five seconds to compile.)
#pragma once

#include <cageform/animate/fit/fit_problem.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

using FitMatrix = std::array<Coefficients, most_coefficients>;

/// Solves the first `n` equations A x = b by A = L D Lᵀ. A is symmetric and positive semidefinite up to
/// rounding. Overwrites `b` with x; an unknown without a positive pivot is 0.
inline void solve_symmetric(FitMatrix& a, Coefficients& b, std::size_t n) noexcept {
    for (std::size_t k = 0; k < n; ++k) {
        for (std::size_t i = k + 1; i < n; ++i) {
            const double factor = a[k][k] > 0 ? a[i][k] / a[k][k] : 0;
            for (std::size_t j = k + 1; j <= i; ++j) a[i][j] -= factor * a[j][k];
            b[i] -= factor * b[k];
        }
    }
    for (std::size_t k = n; k-- > 0;) {
        for (std::size_t i = k + 1; i < n; ++i) b[k] -= a[i][k] * b[i];
        b[k] = a[k][k] > 0 ? b[k] / a[k][k] : 0;
    }
}

/// A square matrix with `band` diagonals on either side of the main one.
class BandedMatrix {
public:
    BandedMatrix(std::size_t size, std::size_t band)
        : size_(size)
        , band_(band)
        , entries_(size * width()) {}

    /// For |row − column| ≤ band; above the diagonal up to 2 band, the fill-in of row exchanges.
    double& operator()(std::size_t row, std::size_t column) noexcept {
        return entries_[row * width() + column + band_ - row];
    }

    /// Solves A x = b by Gaussian elimination with partial pivoting. Overwrites `b` with x, and A. Not
    /// finite if A is singular. O(size · band²).
    void solve(std::span<double> b) noexcept {
        BandedMatrix& a = *this;
        for (std::size_t k = 0; k < size_; ++k) {
            const std::size_t last_row = (std::min)(size_, k + band_ + 1),
                              end = (std::min)(size_, k + 2 * band_ + 1);
            std::size_t pivot = k;
            for (std::size_t i = k + 1; i < last_row; ++i) {
                if (std::fabs(a(i, k)) > std::fabs(a(pivot, k))) pivot = i;
            }
            if (pivot != k) {
                for (std::size_t j = k; j < end; ++j) std::swap(a(k, j), a(pivot, j));
                std::swap(b[k], b[pivot]);
            }
            for (std::size_t i = k + 1; i < last_row; ++i) {
                const double factor = a(i, k) / a(k, k);
                if (factor == 0) continue;
                for (std::size_t j = k + 1; j < end; ++j) a(i, j) -= factor * a(k, j);
                b[i] -= factor * b[k];
            }
        }
        for (std::size_t k = size_; k-- > 0;) {
            const std::size_t end = (std::min)(size_, k + 2 * band_ + 1);
            for (std::size_t j = k + 1; j < end; ++j) b[k] -= a(k, j) * b[j];
            b[k] /= a(k, k);
        }
    }

private:
    /// Row i stores the columns i − band to i + 2 band.
    std::size_t width() const noexcept { return 3 * band_ + 1; }

    std::size_t size_, band_;
    std::vector<double> entries_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

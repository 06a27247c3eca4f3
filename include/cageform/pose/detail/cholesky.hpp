// Cholesky factorisation of a dense matrix, and solves for several right-hand sides at once.
#pragma once

#include <cageform/core/detail/simd.hpp>

#include <cmath>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Subtracts `factor[k]` times a row from D vectors, in blocks [first, last).
template <std::size_t D>
CAGEFORM_DETAIL_INLINE inline void subtract_row(const Lanes<double>* row, std::size_t first, std::size_t last,
                                                const Vec<double, D>& factor, Lanes<double>* const (&to)[D]) {
    for (std::size_t b = first; b < last; ++b) {
        const Simd<double> x = Simd<double>::load(row[b - first]);
        for (std::size_t k = 0; k < D; ++k)
            (Simd<double>::load(to[k][b]) - Simd<double>(factor[k]) * x).store(to[k][b]);
    }
}

/// Factors a symmetric positive definite matrix: A = L Lᵀ. Rows are padded by zeros to whole blocks.
///
///   memory  #unknowns² doubles
///   cost    `factor` #unknowns³ / 3 operations, `solve` 2 D #unknowns²
class Cholesky {
public:
    static constexpr std::size_t none = ~std::size_t{0};

    std::size_t size() const noexcept { return size_; }

    /// Allocates a matrix of zeros. May throw std::bad_alloc.
    void reset(std::size_t size) {
        size_ = size;
        diagonal_.assign(size, 0);
        lower_begin_.assign(size + 1, 0);
        upper_begin_.assign(size + 1, 0);
        for (std::size_t i = 0; i < size; ++i) {
            lower_begin_[i + 1] = lower_begin_[i] + block_count<double>(i);
            upper_begin_[i + 1] = upper_begin_[i] + block_count<double>(size) - i / lane_count<double>;
        }
        clear(lower_, lower_begin_[size]);
        clear(upper_, upper_begin_[size]);
    }

    /// Returns entry (i, j), i ≤ j, to be set before `factor`.
    double& at(std::size_t i, std::size_t j) noexcept {
        const std::size_t first = i / lane_count<double>;
        return upper_[upper_begin_[i] + j / lane_count<double> - first][j % lane_count<double>];
    }

    /// Factors the matrix in place. Returns the first unknown with a pivot that is not positive, relative to
    /// its diagonal entry, or none.
    std::size_t factor() noexcept {
        constexpr std::size_t lanes = lane_count<double>;
        for (std::size_t i = 0; i < size_; ++i) {
            Lanes<double>* const row = &upper_[upper_begin_[i]];
            const std::size_t first = i / lanes;
            const double given = at(i, i);
            for (std::size_t j = 0; j < i; ++j) {
                const double factor = at(j, i);
                if (factor == 0) continue;
                const Lanes<double>* const above = &upper_[upper_begin_[j] + first - j / lanes];
                const Simd<double> x(factor);
                for (std::size_t b = 0; b < block_count<double>(size_) - first; ++b)
                    (Simd<double>::load(row[b]) - x * Simd<double>::load(above[b])).store(row[b]);
            }
            const double pivot = row[0][i % lanes];
            if (!(pivot > 16 * epsilon<double> * given) || !is_finite(pivot)) return i;
            diagonal_[i] = 1 / std::sqrt(pivot);
            for (std::size_t lane = 0; lane < i % lanes; ++lane) row[0][lane] = 0;
            for (std::size_t b = 0; b < block_count<double>(size_) - first; ++b)
                (Simd<double>(diagonal_[i]) * Simd<double>::load(row[b])).store(row[b]);
        }
        for (std::size_t i = 0; i < size_; ++i) {
            for (std::size_t j = 0; j < i; ++j) lower_[lower_begin_[i] + j / lanes][j % lanes] = at(j, i);
        }
        for (std::size_t i = 0; i < size_; ++i) at(i, i) = 0; // as in `lower_`
        return none;
    }

    /// Replaces D right-hand sides by the solutions.
    template <std::size_t D>
    void solve(Lanes<double>* const (&x)[D]) const noexcept {
        constexpr std::size_t lanes = lane_count<double>;
        for (std::size_t j = 0; j < size_; ++j) {
            const Vec<double, D> value = scaled(x, j);
            subtract_row<D>(&upper_[upper_begin_[j]], j / lanes, block_count<double>(size_), value, x);
        }
        for (std::size_t j = size_; j-- > 0;) {
            const Vec<double, D> value = scaled(x, j);
            if (j > 0) subtract_row<D>(&lower_[lower_begin_[j]], 0, block_count<double>(j), value, x);
        }
    }

private:
    static void clear(std::vector<Lanes<double>>& rows, std::size_t count) {
        rows.resize(count);
        for (auto& row : rows) Simd<double>(0).store(row);
    }
    template <std::size_t D>
    Vec<double, D> scaled(Lanes<double>* const (&x)[D], std::size_t j) const noexcept {
        constexpr std::size_t lanes = lane_count<double>;
        Vec<double, D> value;
        for (std::size_t k = 0; k < D; ++k) value[k] = x[k][j / lanes][j % lanes] *= diagonal_[j];
        return value;
    }

    std::size_t size_ = 0;
    std::vector<double> diagonal_;                       ///< reciprocals of the diagonal of L
    std::vector<Lanes<double>> lower_, upper_;           ///< L and Lᵀ, without their diagonals
    std::vector<std::size_t> lower_begin_, upper_begin_; ///< first blocks of rows
};

} // namespace cageform::inline CAGEFORM_ABI::detail

// The normal equations of the lattice of a wrap.
#pragma once

#include <cageform/fit/detail/wrap_lattice.hpp>

#include <Eigen/SparseCholesky>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A symmetric matrix over some handles of a lattice. Handles couple if they are at most `reach` apart along
/// each axis.
///
///   memory  729 numbers per unknown
class LatticeMatrix {
    static constexpr std::size_t reach = 4, side = 2 * reach + 1, stencil = side * side * side;

public:
    /// Makes a zero matrix. Throws std::bad_alloc.
    ///
    ///   unknowns  handles, ascending
    LatticeMatrix(const std::array<std::size_t, 3>& counts, const std::vector<std::uint32_t>& unknowns)
        : counts_(counts)
        , unknowns_(unknowns)
        , slot_(counts[0] * counts[1] * counts[2], no_slot)
        , entries_(unknowns.size() * stencil) {
        for (std::size_t n = 0; n < unknowns.size(); ++n) slot_[unknowns[n]] = std::uint32_t(n);
    }

    /// Adds weight · (row a)ᵀ (row b). Rows whose cells are more than one apart along an axis do not couple.
    void add_product(const LatticeRows& rows, std::size_t a, std::size_t b, double weight) noexcept {
        if (!are_near(rows.first[a], rows.first[b])) return;
        const std::size_t base = centre + offset(rows.first[a], rows.first[b]);
        const double *of_a = rows.weights.data() + a * LatticeRows::width,
                     *of_b = rows.weights.data() + b * LatticeRows::width;
        for (std::size_t m = 0; m < LatticeRows::width; ++m) {
            const std::size_t x = m % 4, y = m / 4 % 4, z = m / 16;
            const std::size_t handle = rows.first[a] + (z * counts_[1] + y) * counts_[0] + x;
            if (slot_[handle] == no_slot) continue;
            double* const to = &entries_[slot_[handle] * stencil + base - (z * side + y) * side - x];
            const double factor = weight * of_a[m];
            for (std::size_t run = 0; run < 16; ++run) {
                double* const at = to + (run / 4 * side + run % 4) * side;
                for (std::size_t n = 0; n < 4; ++n) at[n] += factor * of_b[4 * run + n];
            }
        }
    }
    /// Handle i must be an unknown.
    void add_entry(std::size_t i, std::size_t j, double x) noexcept {
        entries_[slot_[i] * stencil + centre + offset(i, j)] += x;
    }
    double trace() const noexcept {
        double sum = 0;
        for (std::size_t n = 0; n < unknowns_.size(); ++n) sum += entries_[n * stencil + centre];
        return sum;
    }
    /// Sets the matrix to a + factor · b. All have the same unknowns.
    void set_sum(const LatticeMatrix& a, double factor, const LatticeMatrix& b) noexcept {
        for (std::size_t n = 0; n < entries_.size(); ++n)
            entries_[n] = a.entries_[n] + factor * b.entries_[n];
    }
    void clear() noexcept { std::fill(entries_.begin(), entries_.end(), 0); }

    /// Moves the handles that are not unknowns to the right-hand sides (#handles): subtracts their entries
    /// times their positions.
    void subtract_fixed(const std::vector<Point>& pose, std::vector<Point>& right) const noexcept {
        if (unknowns_.size() == slot_.size()) return;
        for (std::size_t n = 0; n < unknowns_.size(); ++n) {
            for (std::size_t at = 0; at < stencil; ++at) {
                const double entry = entries_[n * stencil + at];
                if (entry == 0) continue;
                const auto j = std::size_t(std::ptrdiff_t(unknowns_[n]) + displacement(at));
                if (slot_[j] == no_slot) right[unknowns_[n]] = right[unknowns_[n]] - entry * pose[j];
            }
        }
    }

    /// Returns the lower triangle. Throws std::bad_alloc.
    Eigen::SparseMatrix<double> lower() const {
        const auto size = Eigen::Index(unknowns_.size());
        Eigen::SparseMatrix<double> lower(size, size);
        lower.reserve(size * 172);
        for (std::size_t n = 0; n < unknowns_.size(); ++n) {
            lower.startVec(Eigen::Index(n));
            const double* entry = &entries_[n * stencil];
            for (std::size_t at = 0; at < stencil; ++at, ++entry) {
                if (*entry == 0) continue;
                const std::uint32_t row = slot_[std::size_t(std::ptrdiff_t(unknowns_[n]) + displacement(at))];
                if (row >= n && row != no_slot) lower.insertBack(Eigen::Index(row), Eigen::Index(n)) = *entry;
            }
        }
        lower.finalize();
        return lower;
    }

private:
    static constexpr std::size_t centre = (reach * side + reach) * side + reach;
    static constexpr std::uint32_t no_slot = ~std::uint32_t{0};

    std::array<std::size_t, 3> place(std::size_t i) const noexcept {
        return {i % counts_[0], i / counts_[0] % counts_[1], i / counts_[0] / counts_[1]};
    }
    bool are_near(std::size_t i, std::size_t j) const noexcept {
        const auto a = place(i), b = place(j);
        bool near_all = true;
        for (std::size_t k = 0; k < 3; ++k) near_all = near_all && a[k] <= b[k] + 1 && b[k] <= a[k] + 1;
        return near_all;
    }
    /// Returns the offset in the stencil from handle i to handle j, modulo the size of std::size_t.
    std::size_t offset(std::size_t i, std::size_t j) const noexcept {
        const auto a = place(i), b = place(j);
        return ((b[2] - a[2]) * side + b[1] - a[1]) * side + b[0] - a[0];
    }
    /// Returns the number of handles from the centre of a stencil to one of its entries.
    std::ptrdiff_t displacement(std::size_t at) const noexcept {
        const auto nx = std::ptrdiff_t(counts_[0]), ny = std::ptrdiff_t(counts_[1]);
        constexpr auto r = std::ptrdiff_t(reach), s = std::ptrdiff_t(side);
        const auto n = std::ptrdiff_t(at);
        return ((n / (s * s) - r) * ny + n / s % s - r) * nx + n % s - r;
    }

    std::array<std::size_t, 3> counts_;
    std::vector<std::uint32_t> unknowns_, slot_; ///< `slot_`: #handles, the index among the unknowns
    std::vector<double> entries_; ///< #unknowns · 729: by handle i, the entries (i, j) by the offset of j
};

/// The Cholesky factors of a LatticeMatrix.
class LatticeFactors {
public:
    /// Returns whether the matrix is positive definite. Throws std::bad_alloc.
    bool factor(const LatticeMatrix& matrix) {
        const Eigen::SparseMatrix<double> lower = matrix.lower();
        if (lower.nonZeros() != entries_) factors_.analyzePattern(lower);
        entries_ = lower.nonZeros();
        factors_.factorize(lower);
        return factors_.info() == Eigen::Success;
    }
    /// Replaces the right-hand sides of the unknowns by the solution.
    void solve(std::vector<Point>& x) const {
        using Rows = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>;
        Rows right(x.data()->v, Eigen::Index(x.size()), 3);
        right = factors_.solve(Eigen::MatrixX3d(right));
    }

private:
    Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factors_;
    Eigen::Index entries_ = -1; ///< number of entries of the last matrix
};

inline LatticeMatrix WrapLattice::matrix(const std::vector<std::uint32_t>& unknowns) const {
    return {counts_, unknowns};
}

inline void WrapLattice::add_ridge(LatticeMatrix& matrix, const std::vector<char>& is_unknown,
                                   double factor) const noexcept {
    std::size_t stride = 1;
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t n = 0; n < size(); ++n) {
            const std::size_t i = n / stride % counts_[k];
            if (i + 2 >= counts_[k] || !is_unknown[n] || !is_unknown[n + stride] ||
                !is_unknown[n + 2 * stride])
                continue;
            const double scale = size_[k] / cell_; // in cells
            const double a = scale * (splines_[k].greville(i + 1) - splines_[k].greville(i)),
                         b = scale * (splines_[k].greville(i + 2) - splines_[k].greville(i + 1));
            const double of[3] = {2 / (a * (a + b)), -2 / (a * b), 2 / (b * (a + b))};
            for (std::size_t r = 0; r < 3; ++r) {
                for (std::size_t c = 0; c < 3; ++c)
                    matrix.add_entry(n + r * stride, n + c * stride, factor * of[r] * of[c]);
            }
        }
        stride *= counts_[k];
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail

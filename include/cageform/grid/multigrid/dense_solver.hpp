// Solves the equations of the coarsest level by a Cholesky factorisation.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/grid/multigrid/equations.hpp>
#include <cageform/grid/multigrid/node_values.hpp>

#include <cmath>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

class DenseSolver {
public:
    DenseSolver() = default;

    template <std::size_t D>
    explicit DenseSolver(const Equations<D>& e) {
        const std::size_t n = e.nodes.count();
        std::vector<double> matrix(n * n);
        e.nodes.for_each([&](const auto& index, std::uint32_t node) {
            for (std::size_t p = 0; p < StencilPositions<D>::count; ++p) {
                const auto m = e.nodes.find(shifted<D>(index, StencilPositions<D>::offset(p)));
                if (m != grid::NodeRuns<D>::none) matrix[node * n + m] += e.stencil(node)[p];
            }
        });
        if (factorise(matrix.data(), n)) store(matrix.data(), n);
    }

    /// Whether there are no factors: default-constructed, or the matrix is not positive definite.
    bool empty() const noexcept { return factor_.empty(); }

    /// Computes u = A⁻¹ b by forward and backward substitution.
    void solve(const Buffer<NodeRow>& b, Buffer<NodeRow>& u) const noexcept {
        using Vector = Simd<float>;
        const float* factor = factor_.data();
        const auto substitute = [&](const NodeRow& right, std::size_t begin,
                                    std::size_t end) CAGEFORM_DETAIL_INLINE {
            Vector sum(0.0f), other(0.0f); // two independent sums hide the latency of additions
            for (; begin + 1 < end; begin += 2, factor += 2) {
                sum = sum + Vector(factor[0]) * Vector::load(u[begin]);
                other = other + Vector(factor[1]) * Vector::load(u[begin + 1]);
            }
            if (begin < end) sum = sum + Vector(*factor++) * Vector::load(u[begin]);
            return Vector(*factor++) * Vector::load(right) - (sum + other);
        };
        const std::size_t n = u.size();
        for (std::size_t i = 0; i < n; ++i) substitute(b[i], 0, i).store(u[i]);
        for (std::size_t i = n; i-- > 0;) substitute(u[i], i + 1, n).store(u[i]);
    }
    std::size_t bytes() const noexcept { return factor_.size() * sizeof(float); }

private:
    /// Factorises A = L Lᵀ, and stores L row by row over the lower half of A. Returns false if A is not
    /// positive definite. Subtracts each column from the remaining matrix at once, which avoids dependent
    /// sums.
    static bool factorise(double* a, std::size_t n) {
        std::vector<double> column(n);
        for (std::size_t k = 0; k < n; ++k) {
            if (!(a[k * n + k] > 0)) return false;
            const double pivot = a[k * n + k] = std::sqrt(a[k * n + k]);
            for (std::size_t i = k + 1; i < n; ++i) {
                double* const row = a + i * n;
                column[i] = row[k] /= pivot;
                for (std::size_t j = k + 1; j <= i; ++j) row[j] -= column[i] * column[j];
            }
        }
        return true;
    }

    void store(const double* factor, std::size_t n) {
        const auto put = [&](double x) { factor_.push_back(float(x)); };
        for (std::size_t i = 0; i < n; ++i) {
            const double pivot = factor[i * n + i];
            for (std::size_t j = 0; j < i; ++j) put(factor[i * n + j] / pivot);
            put(1 / pivot);
        }
        for (std::size_t i = n; i-- > 0;) {
            const double pivot = factor[i * n + i];
            for (std::size_t j = i + 1; j < n; ++j) put(factor[j * n + i] / pivot);
            put(1 / pivot);
        }
    }

    /// The rows of L, then its columns from the last to the first, in the order in which `solve` reads them.
    std::vector<float> factor_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

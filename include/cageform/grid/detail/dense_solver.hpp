// The equations of the coarsest level, solved at once by Cholesky's factors.
#pragma once

#include <cageform/core/detail/simd.hpp>
#include <cageform/grid/detail/equations.hpp>
#include <cageform/grid/detail/node_values.hpp>

#include <Eigen/Cholesky>

namespace cageform::inline CAGEFORM_ABI::detail {

class DenseSolver {
public:
    DenseSolver() = default;

    template <std::size_t D>
    explicit DenseSolver(const Equations<D>& e) {
        const auto n = Eigen::Index(e.nodes.count());
        Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
        e.nodes.for_each([&](const auto& index, std::uint32_t node) {
            for (std::size_t p = 0; p < Places<D>::count; ++p) {
                const auto m = e.nodes.find(shifted<D>(index, Places<D>::offset(p)));
                if (m != grid::NodeRuns<D>::none)
                    a(Eigen::Index(node), Eigen::Index(m)) += e.stencil(node)[p];
            }
        });
        const Eigen::LLT<Eigen::MatrixXd> llt(a);
        if (llt.info() != Eigen::Success) return;
        const Eigen::MatrixXd factor = llt.matrixL();
        for (Eigen::Index i = 0; i < n; ++i) {
            for (Eigen::Index j = 0; j < i; ++j) factor_.push_back(float(factor(i, j) / factor(i, i)));
            factor_.push_back(float(1 / factor(i, i)));
        }
        for (Eigen::Index i = n; i-- > 0;) {
            for (Eigen::Index j = i + 1; j < n; ++j) factor_.push_back(float(factor(j, i) / factor(i, i)));
            factor_.push_back(float(1 / factor(i, i)));
        }
    }

    /// Whether there are no factors: none were asked for, or the matrix has none.
    bool empty() const noexcept { return factor_.empty(); }

    /// u = A⁻¹ b, by a forward and a backward substitution.
    void solve(const std::vector<NodeRow>& b, std::vector<NodeRow>& u) const noexcept {
        using Vector = Simd<float>;
        const float* factor = factor_.data();
        const auto substitute = [&](const NodeRow& right, std::size_t begin, std::size_t end) {
            Vector sum(0.0f), other(0.0f); // two sums side by side hide the time an addition takes
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
    std::vector<float> factor_; ///< rows of L, then its columns from the last, as `solve` reads them
};

} // namespace cageform::inline CAGEFORM_ABI::detail

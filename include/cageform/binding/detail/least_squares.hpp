// Linear least squares by normal equations, one row at a time.
#pragma once

#include <cageform/core/status.hpp>
#include <cageform/core/vec.hpp>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

#include <cmath>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Minimises Σ_rows weight · |Σ coefficient · x − right|² for several right-hand sides. The normal
/// equations are summed, scaled to a unit diagonal and factored (L D Lᵀ), with one step of iterative
/// refinement. The matrix is dense for few unknowns, else sparse.
///
///  cost  O(Σ terms²) for the rows; then O(unknowns³ / 3), or the cost of the fill-in
class LeastSquares {
public:
    struct Term {
        std::uint32_t unknown;
        double coefficient;
    };
    struct Solution {
        Status status = Status::ok; ///< fit_not_determined: the scaled matrix is numerically singular
        double pivot_ratio = 1;     ///< the least pivot over the largest; 1 for no unknowns
        std::vector<double> values; ///< unknown · sides + side; empty unless the status is ok
    };

    /// `most_dense` is the largest number of unknowns with a dense matrix.
    LeastSquares(std::size_t unknowns, std::size_t sides, std::size_t most_dense = 1000)
        : is_dense_(unknowns <= most_dense)
        , right_(Matrix::Zero(Eigen::Index(unknowns), Eigen::Index(sides))) {
        const auto size = Eigen::Index(unknowns);
        if (is_dense_)
            dense_ = Matrix::Zero(size, size);
        else
            sparse_.resize(size, size);
    }

    /// Adds a row.
    ///
    ///  terms   with distinct unknowns
    ///  right   one number per side
    ///  weight  not negative
    void add(std::span<const Term> terms, std::span<const double> right, double weight) {
        if (!(weight > 0)) return;
        for (const Term& term : terms) {
            for (std::size_t side = 0; side < right.size(); ++side)
                right_(Eigen::Index(term.unknown), Eigen::Index(side)) +=
                    weight * term.coefficient * right[side];
        }
        if (is_dense_) {
            for (const Term& a : terms) {
                for (const Term& b : terms) {
                    if (a.unknown >= b.unknown)
                        dense_(Eigen::Index(a.unknown), Eigen::Index(b.unknown)) +=
                            weight * a.coefficient * b.coefficient;
                }
            }
            return;
        }
        const double root = std::sqrt(weight);
        for (const Term& term : terms)
            batch_.emplace_back(batch_rows_, Index(term.unknown), root * term.coefficient);
        ++batch_rows_;
        if (batch_.size() >= terms_of_batch) add_batch();
    }

    Solution solve() {
        if (right_.rows() == 0) return {};
        if (is_dense_) return solve_by<Eigen::LDLT<Matrix>>(dense_);
        add_batch();
        return solve_by<Eigen::SimplicialLDLT<Sparse>>(sparse_);
    }

private:
    using Matrix = Eigen::MatrixXd;
    using Index = std::int64_t;
    using Sparse = Eigen::SparseMatrix<double, Eigen::ColMajor, Index>;
    static constexpr std::size_t terms_of_batch = std::size_t{1} << 18;

    /// Adds the collected rows at once, since changing a sparse matrix is slow.
    void add_batch() {
        Sparse rows(Eigen::Index(batch_rows_), right_.rows());
        rows.setFromTriplets(batch_.begin(), batch_.end());
        const Sparse products = rows.transpose() * rows;
        sparse_ += Sparse(products.triangularView<Eigen::Lower>());
        batch_.clear();
        batch_rows_ = 0;
    }

    /// `matrix` is the lower triangle.
    template <class Factors, class M>
    Solution solve_by(const M& matrix) const {
        const Eigen::VectorXd diagonal = matrix.diagonal();
        Solution solution{Status::fit_not_determined, 0, {}};
        if (!(diagonal.minCoeff() > 0)) return solution;
        const Eigen::VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
        const M scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
        const Factors factors(scaled);
        const Eigen::VectorXd pivots = factors.vectorD();
        if (factors.info() == Eigen::Success) solution.pivot_ratio = pivots.minCoeff() / pivots.maxCoeff();
        if (!(solution.pivot_ratio > 8 * double(right_.rows()) * epsilon<double>)) return solution;
        const auto solve = [&](const Matrix& right) -> Matrix {
            return scale.asDiagonal() * factors.solve(scale.asDiagonal() * right);
        };
        Matrix x = solve(right_);
        const Matrix missing = right_ - matrix.template selfadjointView<Eigen::Lower>() * x;
        x += solve(missing);
        for (Eigen::Index row = 0; row < x.rows(); ++row) {
            for (Eigen::Index side = 0; side < x.cols(); ++side) solution.values.push_back(x(row, side));
        }
        solution.status = Status::ok;
        return solution;
    }

    bool is_dense_;
    Matrix dense_; ///< the lower triangle
    Sparse sparse_;
    Matrix right_; ///< one column per side
    std::vector<Eigen::Triplet<double, Index>> batch_;
    Index batch_rows_ = 0;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

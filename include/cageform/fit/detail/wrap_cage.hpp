// The cage of a wrap, and its normal equations.
#pragma once

#include <cageform/fit/detail/dense_rows.hpp>
#include <cageform/pose/detail/pose_system.hpp>
#include <cageform/pose/detail/stretches.hpp>

#include <Eigen/Core>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A symmetric matrix over the handles of a cage. Rows are collected and added as one product.
class DenseMatrix {
public:
    explicit DenseMatrix(std::size_t handles)
        : entries_(Matrix::Zero(Eigen::Index(handles), Eigen::Index(handles))) {}

    /// Adds weight · ((row a)ᵀ (row b) + (row b)ᵀ (row a)) / 2.
    void add_product(const DenseRows& rows, std::size_t a, std::size_t b, double weight) {
        const std::size_t n = rows.handles;
        const auto of = [&](std::size_t row) {
            return Eigen::Map<const Eigen::VectorXd>(rows.weights.data() + row * n, Eigen::Index(n));
        };
        if (left_.cols() == 0) {
            left_.resize(Eigen::Index(n), batch);
            right_.resize(Eigen::Index(n), batch);
        }
        left_.col(filled_) = 0.5 * weight * of(a);
        right_.col(filled_) = of(b);
        if (++filled_ == batch) add_batch();
    }
    void add_entry(std::size_t i, std::size_t j, double x) {
        entries_(Eigen::Index(i), Eigen::Index(j)) += x;
    }
    double trace() {
        add_batch();
        return entries_.trace();
    }
    /// Sets the matrix to a + factor · b.
    void set_sum(DenseMatrix& a, double factor, DenseMatrix& b) {
        entries_ = a.entries() + factor * b.entries();
    }
    void clear() noexcept { entries_.setZero(); }

    /// As LatticeMatrix::subtract_fixed; all handles of a cage are unknowns.
    void subtract_fixed(const std::vector<Vec<double, 3>>& /*pose*/,
                        std::vector<Vec<double, 3>>& /*right*/) const noexcept {}
    const Eigen::MatrixXd& entries() {
        add_batch();
        return entries_;
    }

private:
    using Matrix = Eigen::MatrixXd;
    static constexpr Eigen::Index batch = 256;

    void add_batch() {
        if (filled_ == 0) return;
        const Matrix product = left_.leftCols(filled_) * right_.leftCols(filled_).transpose();
        entries_ += product + product.transpose();
        filled_ = 0;
    }

    Matrix entries_, left_, right_;
    Eigen::Index filled_ = 0;
};

/// The Cholesky factors of a DenseMatrix.
class DenseFactors {
public:
    /// Returns whether the matrix is positive definite. Throws std::bad_alloc.
    bool factor(DenseMatrix& matrix) {
        const Eigen::MatrixXd& entries = matrix.entries();
        const auto size = std::size_t(entries.rows());
        factors_.reset(size);
        for (std::size_t n = 0; n < size; ++n) {
            for (std::size_t m = n; m < size; ++m)
                factors_.at(n, m) = entries(Eigen::Index(n), Eigen::Index(m));
        }
        solution_.reset(size);
        return factors_.factor() == Cholesky::none;
    }
    /// Replaces the right-hand sides by the solution.
    void solve(std::vector<Vec<double, 3>>& x) noexcept {
        for (std::size_t n = 0; n < x.size(); ++n) solution_.set(n, x[n]);
        solution_.with_axes([&](auto& axes) { factors_.solve(axes); });
        for (std::size_t n = 0; n < x.size(); ++n) x[n] = solution_.get(n);
    }

private:
    Cholesky factors_;
    AxisVectors<3> solution_;
};

/// The weights and gradients of any coordinates, in the units of a wrap.
class WrapCage {
    using Point = Vec<double, 3>;

public:
    using Rows = DenseRows;
    using Matrix = DenseMatrix;
    using Factors = DenseFactors;

    WrapCage(std::vector<Point> rest, EvaluateCage evaluate)
        : rest_(std::move(rest))
        , evaluate_(std::move(evaluate)) {}

    std::size_t size() const noexcept { return rest_.size(); }
    const std::vector<Point>& rest() const noexcept { return rest_; }
    DenseMatrix matrix(const std::vector<std::uint32_t>& /*unknowns*/) const { return DenseMatrix(size()); }
    Status weights(std::span<const Point> points, DenseRows& rows) const {
        return evaluate_(points, false, rows);
    }
    /// As WrapLattice::gradients; the cage is the first stage, so there is no map before it.
    Status gradients(std::span<const Point> points, std::span<const LinearMap<double, 3>> /*before*/,
                     DenseRows& rows) const {
        return evaluate_(points, true, rows);
    }
    void add_ridge(DenseMatrix& /*matrix*/, const std::vector<char>& /*is_unknown*/,
                   double /*factor*/) const noexcept {}

private:
    std::vector<Point> rest_;
    EvaluateCage evaluate_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

// Affine rows whose mean square is the identity: what packing measures and restores Σ wκ and Σ wH
// with.
#pragma once

#include <cageform/coordinates/detail/affine_rows.hpp>

#include <Eigen/Eigenvalues>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The affine rows of the handles, centred at the mean of the points and scaled so that their mean
/// square is the identity: what Σ wκ and Σ wH are taken with.
template <std::size_t D>
class Moments {
public:
    static constexpr int size = int(D) + 1;
    using Column = Eigen::Matrix<double, size, 1>;
    using Matrix = Eigen::Matrix<double, size, size>;

    template <Scalar T>
    explicit Moments(const HandleView<T, D>& handles)
        : columns_(handles.count) {
        AffineFrame<double, D> frame; // at the mean of the points
        const double points = double(handles.count - handles.vector_count());
        for (std::size_t i = 0; i < handles.count; ++i) {
            for (std::size_t k = 0; k < D && handles.is_point(i); ++k)
                frame.centre[k] += double(handles.rest[i][k]) / points;
        }
        const AffineRows<double, D> rows(handles, frame);
        Matrix square = Matrix::Zero();
        for (std::size_t i = 0; i < handles.count; ++i) {
            columns_[i] = rows.column(i);
            square += columns_[i] * columns_[i].transpose() / double(handles.count);
        }
        const Matrix whiten = power(square, -0.5);
        for (auto& a : columns_) a = whiten * a;
        inverse_of_all_ = power(sum_of_squares([](std::size_t) { return true; }), -1);
    }

    const Column& operator[](std::size_t handle) const { return columns_[handle]; }
    /// The best affine fit to values at all handles is Σ_i fit(i) · value_i, against these columns.
    Column fit(std::size_t handle) const { return inverse_of_all_ * columns_[handle]; }

    template <class Chosen>
    Matrix sum_of_squares(const Chosen& chosen) const {
        Matrix sum = Matrix::Zero();
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            if (chosen(i)) sum += columns_[i] * columns_[i].transpose();
        }
        return sum;
    }
    /// Of a symmetric matrix; directions without extent are left out.
    static Matrix power(const Matrix& m, double exponent) {
        const Eigen::SelfAdjointEigenSolver<Matrix> solver(m);
        Column values = solver.eigenvalues();
        const double least = values.maxCoeff() * 1e-12;
        for (double& x : values) x = x > least ? std::pow(x, exponent) : 0;
        return solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
    }
    static double least_extent(const Matrix& m) {
        return Eigen::SelfAdjointEigenSolver<Matrix>(m, Eigen::EigenvaluesOnly).eigenvalues()[0];
    }

private:
    std::vector<Column> columns_;
    Matrix inverse_of_all_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

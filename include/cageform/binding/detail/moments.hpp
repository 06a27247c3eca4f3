// Normalised affine rows of the handles, which packing uses to measure and restore Σ wκ and Σ wH.
#pragma once

#include <cageform/binding/detail/symmetric_matrix.hpp>
#include <cageform/core/affine/affine_rows.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The affine rows (κ, H) of the handles, centred at the mean of the points and scaled so that their
/// mean square is the identity. The row sum Σ w a of a point's weights determines Σ wκ and Σ wH.
template <std::size_t D>
class Moments {
public:
    using Column = Vec<double, D + 1>;
    using Matrix = SquareMatrix<D + 1>;

    template <Scalar T>
    explicit Moments(const HandleView<T, D>& handles)
        : columns_(handles.count) {
        AffineFrame<double, D> frame; // centred at the mean of the points
        const double points = double(handles.point_count());
        for (std::size_t i = 0; i < handles.count; ++i) {
            for (std::size_t k = 0; k < D && handles.is_point(i); ++k)
                frame.centre[k] += double(handles.rest[i][k]) / points;
        }
        const AffineRows<double, D> rows(handles, frame);
        Matrix square{};
        for (std::size_t i = 0; i < handles.count; ++i) {
            columns_[i] = rows[i];
            add_outer_product(square, 1 / double(handles.count) * rows[i], rows[i]);
        }
        const Matrix whiten = power(square, -0.5);
        for (auto& a : columns_) a = product(whiten, a);
        inverse_of_all_ = power(sum_of_squares([](std::size_t) { return true; }), -1);
    }

    std::size_t size() const { return columns_.size(); }
    const Column& operator[](std::size_t handle) const { return columns_[handle]; }
    /// Returns the coefficient of a handle in the least-squares affine fit: Σ_i fit(i) · value_i,
    /// relative to these columns.
    Column fit(std::size_t handle) const { return product(inverse_of_all_, columns_[handle]); }

    template <class Chosen>
    Matrix sum_of_squares(const Chosen& chosen) const {
        Matrix sum{};
        for (std::size_t i = 0; i < columns_.size(); ++i) {
            if (chosen(i)) add_outer_product(sum, columns_[i], columns_[i]);
        }
        return sum;
    }
    /// Returns a power of a symmetric matrix; vanishing eigenvalues are omitted.
    static Matrix power(const Matrix& m, double exponent) {
        const PrincipalAxes<D + 1> axes = principal_axes(m);
        Matrix result{};
        for (std::size_t k = 0; k <= D; ++k) {
            if (axes.values[k] > axes.largest() * 1e-12)
                add_outer_product(result, std::pow(axes.values[k], exponent) * axes.vectors[k],
                                  axes.vectors[k]);
        }
        return result;
    }

private:
    std::vector<Column> columns_;
    Matrix inverse_of_all_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

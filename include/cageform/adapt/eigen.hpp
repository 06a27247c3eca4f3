// Adapts Eigen: vectors as points, and rows or columns of matrices as ranges of points, without a copy.
#pragma once

#include <cageform/core/types/scalar_range.hpp>
#include <cageform/core/view.hpp>

#include <Eigen/Core>

/// Adapts column and row vectors of fixed size: Eigen::Vector2d, Eigen::RowVector3f, …
template <class T, int Rows, int Cols, int Options, int MaxRows, int MaxCols>
    requires((Rows == 1 || Cols == 1) && Rows > 0 && Cols > 0)
struct cageform::PointTraits<Eigen::Matrix<T, Rows, Cols, Options, MaxRows, MaxCols>> {
    using P = Eigen::Matrix<T, Rows, Cols, Options, MaxRows, MaxCols>;
    using scalar = T;
    static constexpr std::size_t dimension = std::size_t(Rows) * std::size_t(Cols);
    static T get(const P& p, std::size_t axis) noexcept { return p[Eigen::Index(axis)]; }
    static void set(P& p, std::size_t axis, T x) noexcept { p[Eigen::Index(axis)] = x; }
};

static_assert(cageform::MutablePoint<Eigen::Vector2d> && cageform::MutablePoint<Eigen::RowVector3f>);

namespace cageform::inline CAGEFORM_ABI {

/// Views the rows of a #P × D matrix as points. The matrix may have either storage order and may be a
/// map or a block of a larger matrix. The view is writable if the matrix is not const.
template <std::size_t D, class M>
auto points_in_rows(M&& matrix) noexcept {
    using T = detail::element_t<std::remove_reference_t<M>>;
    CAGEFORM_ASSERT(matrix.cols() == Eigen::Index(D), "one column per axis");
    return StridedPoints<T, D>(matrix.data(), std::size_t(matrix.rows()),
                               matrix.rowStride() * std::ptrdiff_t(sizeof(T)),
                               matrix.colStride() * std::ptrdiff_t(sizeof(T)));
}

/// Views the columns of a D × #P matrix as points.
template <std::size_t D, class M>
auto points_in_columns(M&& matrix) noexcept {
    using T = detail::element_t<std::remove_reference_t<M>>;
    CAGEFORM_ASSERT(matrix.rows() == Eigen::Index(D), "one row per axis");
    return StridedPoints<T, D>(matrix.data(), std::size_t(matrix.cols()),
                               matrix.colStride() * std::ptrdiff_t(sizeof(T)),
                               matrix.rowStride() * std::ptrdiff_t(sizeof(T)));
}

/// Deleted for temporaries, which the view would outlive.
template <std::size_t D, class M>
    requires(std::is_base_of_v<Eigen::PlainObjectBase<M>, M>)
auto points_in_rows(M&& matrix) = delete;
template <std::size_t D, class M>
    requires(std::is_base_of_v<Eigen::PlainObjectBase<M>, M>)
auto points_in_columns(M&& matrix) = delete;

} // namespace cageform::inline CAGEFORM_ABI

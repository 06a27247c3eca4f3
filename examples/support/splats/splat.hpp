#pragma once

// Covariances of 3D Gaussian splats (Kerbl, Kopanas, Leimkühler, Drettakis, SIGGRAPH 2023): affine maps,
// conversion to rotation and scale, splitting.

#include "files/mesh_file.hpp"

#include <array>
#include <cstddef>

namespace cageform_support {

/// A matrix as columns: column k is the image of axis k, as in clone_jacobians().
using Matrix3 = std::array<Point3, 3>;

inline constexpr Matrix3 identity3{Point3{1, 0, 0}, Point3{0, 1, 0}, Point3{0, 0, 1}};

Point3 product(const Matrix3& a, const Point3& x);
Matrix3 product(const Matrix3& a, const Matrix3& b);
Matrix3 transposed(const Matrix3& a);
double determinant(const Matrix3& a);
double length_of(const Point3& v); ///< without protection from overflow

/// Singular value decomposition A = left · diag(sizes) · rightᵀ with orthogonal matrices. Sizes are not
/// negative and not sorted. If the columns of A are orthogonal, their order is kept and `right` is the
/// identity.
struct SingularValues {
    Matrix3 left = identity3;
    Point3 sizes{};
    Matrix3 right = identity3;

    std::size_t largest() const; ///< the axis of the largest size
};

/// Accepts every finite matrix. For sizes below 1e-14 of the largest, axes are chosen to complete `left` to a
/// rotation. Each size is accurate relative to its own column, even if sizes differ much, since A·Aᵀ is not
/// formed. One-sided Jacobi rotations by Hestenes: Demmel, Veselić, SIAM J. Matrix Anal. 13, 1992.
SingularValues singular_values(const Matrix3& a);

/// The orthogonal matrix nearest to J: Q of the polar decomposition J = Q·P. If det J < 0, it is a rotation
/// with a reflection; if J is singular, a rotation.
Matrix3 nearest_orthogonal(const Matrix3& jacobian);

/// The shape of a splat in files, with the covariance R·diag(e^2s)·Rᵀ.
struct SplatShape {
    std::array<double, 4> rotation{1, 0, 0, 0}; ///< R as a quaternion w, x, y, z of any length
    Point3 log_scales{};                        ///< s: logarithms of standard deviations along the axes
};

/// The least logarithm of a standard deviation that shape_of() returns, for flat splats. Its exponential is
/// near the smallest normal number of single precision.
inline constexpr double least_log_scale = -87;

/// A factor F of the covariance F·Fᵀ: its columns are the half axes of the ellipsoid of one standard
/// deviation. A quaternion of length 0 counts as no rotation.
Matrix3 factor_of(const SplatShape& shape);

/// The shape with covariance F·Fᵀ, for every finite factor. The rotation is proper even if det F < 0, since
/// an ellipsoid is its own mirror image.
///
///   values   of F
SplatShape shape_of(SingularValues values);

/// Half of a splat. The halves' centres are offset from that of the whole by ±offset.
struct HalfSplat {
    Point3 offset;
    Matrix3 factor;

    /// Opacity of a half, relative to the whole.
    static constexpr double opacity = 0.70710678118654752; // 1/√2
};

/// Splits a splat at rest across the axis that is longest in the pose. Both halves have half of the mass
/// (opacity times volume) and half of the variance along that axis; their centres are 1/√2 standard
/// deviations from that of the whole. The pair has the mean, second moments and mass of the splat, at rest
/// and in every affine pose. The density along the axis is flat in the middle.
///
///   factor   of the splat at rest
///   posed    singular values of J · factor, for a pose with Jacobian J
HalfSplat half_of(const Matrix3& factor, const SingularValues& posed);

} // namespace cageform_support

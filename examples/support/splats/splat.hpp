#pragma once

// Splats of 3D Gaussian splatting (Kerbl, Kopanas, Leimkühler, Drettakis, SIGGRAPH 2023) as volumes: their
// covariance under an affine map, as rotation and scale again, and in two halves.

#include "files/obj_file.hpp"

#include <array>
#include <cstddef>

namespace cageform_support {

/// A matrix by its columns: column k is the image of axis k, as clone_jacobians() writes it.
using Matrix3 = std::array<Point3, 3>;

inline constexpr Matrix3 identity3{Point3{1, 0, 0}, Point3{0, 1, 0}, Point3{0, 0, 1}};

Point3 product(const Matrix3& a, const Point3& x);
Matrix3 product(const Matrix3& a, const Matrix3& b);
Matrix3 transposed(const Matrix3& a);
double determinant(const Matrix3& a);
double length_of(const Point3& v); ///< as far as its square is a number

/// A = left · diag(sizes) · rightᵀ with orthogonal matrices. The sizes are not negative and not sorted: a
/// matrix whose columns are at right angles keeps their order, and then `right` is the identity.
struct SingularValues {
    Matrix3 left = identity3;
    Point3 sizes{};
    Matrix3 right = identity3;

    std::size_t largest() const; ///< the axis of the largest size
};

/// Works for every finite matrix, singular ones too: where sizes are below 1e-14 of the largest, their axes
/// are any that complete `left` to a rotation. The sizes are exact to rounding relative to their own column,
/// also where they differ much (Hestenes' one-sided rotations; Demmel, Veselić, SIAM J. Matrix Anal. 13,
/// 1992). The product A·Aᵀ, which would lose the small ones, is not formed.
SingularValues singular_values(const Matrix3& a);

/// The orthogonal matrix nearest to J, the rotation of its polar decomposition J = Q·P. Where J turns space
/// over, its determinant is −1, a rotation with a reflection; where J is singular, it is a rotation.
Matrix3 nearest_orthogonal(const Matrix3& jacobian);

/// The shape of a splat as files have it. It stands for the covariance R·diag(e^2s)·Rᵀ.
struct SplatShape {
    std::array<double, 4> rotation{1, 0, 0, 0}; ///< R as a quaternion w, x, y, z, of any length
    Point3 log_scales{};                        ///< s: logarithms of standard deviations along the axes
};

/// The least logarithm of a standard deviation that is computed: single precision ends there. A flat
/// splat has it, unless it has less at rest.
inline constexpr double least_log_scale = -87;

/// A factor of the splat's covariance F·Fᵀ: its columns are the half axes of the ellipsoid of one
/// standard deviation. A quaternion of length 0 stands for no rotation.
Matrix3 factor_of(const SplatShape& shape);

/// The shape whose covariance is F·Fᵀ, for every finite factor. The rotation is proper even where F turns
/// space over: an ellipsoid is its own mirror image.
///
///   values   of F
SplatShape shape_of(SingularValues values);

/// Half of a splat: its centre is offset from that of the whole, and the other half's by as much the other
/// way.
struct HalfSplat {
    Point3 offset;
    Matrix3 factor;

    /// The opacity of a half: as a share of that of the whole.
    static constexpr double opacity = 0.70710678118654752; // 1/√2
};

/// Cuts a splat at rest across the axis that a pose makes its longest. Both halves have half of the mass
/// (opacity times volume) and half of the variance along that axis; their centres lie 1/√2 of a standard
/// deviation from that of the whole. The pair has the mean, the second moment and the mass of the splat, at
/// rest and in every affine pose; its density along the axis is flat in the middle and has no dip.
///
///   factor   of the splat at rest
///   posed    singular values of J · factor, where the pose has the Jacobian J
HalfSplat half_of(const Matrix3& factor, const SingularValues& posed);

} // namespace cageform_support

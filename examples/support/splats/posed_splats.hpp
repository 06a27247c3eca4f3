#pragma once

// Deforms splats of a scene: covariance, colours and normals, and splits splats that are stretched.

#include "splats/splat.hpp"
#include "splats/splat_file.hpp"

#include <array>
#include <cstddef>

namespace cageform_support {

/// A splat at rest, or a part of a split splat.
struct SplatPart {
    std::size_t row = 0; ///< in the scene; it holds the numbers of the whole splat until write_posed()
    Point3 place;
    Matrix3 factor = identity3;
    double size = 0;    ///< largest standard deviation of the whole splat at rest
    double opacity = 1; ///< relative to the whole splat
};

SplatPart part_of(const SplatFile& scene, std::size_t row);

/// The ellipsoid of a deformed part: singular values of J · factor.
SingularValues posed_shape(const SplatPart& part, const Matrix3& jacobian);

/// Length of a deformed part relative to the whole splat at rest; 1 if the splat has size 0.
double stretch_of(const SplatPart& part, const SingularValues& posed);

/// Splits a part into two halves, see half_of().
///
///   row   of the second half, a copy of the row of the whole
std::array<SplatPart, 2> halves_of(const SplatPart& part, const SingularValues& posed, std::size_t row);

/// Writes a deformed part to its row. Its covariance is JΣJᵀ. Harmonics are rotated by the orthogonal matrix
/// nearest to J, including reflections; normals transform as surface normals. Everything else is unchanged;
/// if J is the identity, only the position and the values of split parts change.
void write_posed(SplatFile& scene, const SplatPart& part, const Point3& place, const Matrix3& jacobian,
                 const SingularValues& posed);

} // namespace cageform_support

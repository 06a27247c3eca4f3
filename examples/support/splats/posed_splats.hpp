#pragma once

// Splats of a scene as a pose has them: with their covariance, colours, normals, and in parts where they
// are stretched.

#include "splats/splat.hpp"
#include "splats/splat_file.hpp"

#include <array>
#include <cstddef>

namespace cageform_support {

/// A splat at rest, or a part of one that has been split.
struct SplatPart {
    std::size_t row = 0; ///< of the scene: until it is posed its other numbers are those of the whole
    Point3 place;
    Matrix3 factor = identity3;
    double size = 0;    ///< the largest standard deviation of the whole at rest
    double opacity = 1; ///< as a share of that of the whole
};

SplatPart part_of(const SplatFile& scene, std::size_t row);

/// The ellipsoid of a part in a pose: singular values of J · factor.
SingularValues posed_shape(const SplatPart& part, const Matrix3& jacobian);

/// Returns the length of a posed part, as a share of that of the whole splat at rest. A splat of no length
/// is not stretched.
double stretch_of(const SplatPart& part, const SingularValues& posed);

/// Cuts a part in two, as half_of() says.
///
///   row   of the second half, a copy of the row of the whole
std::array<SplatPart, 2> halves_of(const SplatPart& part, const SingularValues& posed, std::size_t row);

/// Writes a part to its row as a pose has it. Its covariance is JΣJᵀ, its harmonics turn by the orthogonal
/// matrix nearest to J (reflections too: nearest_orthogonal()), normals turn as those of a surface, and all
/// else stays. Where J is the identity the row keeps its bytes but for the place and the parts' numbers.
void write_posed(SplatFile& scene, const SplatPart& part, const Point3& place, const Matrix3& jacobian,
                 const SingularValues& posed);

} // namespace cageform_support

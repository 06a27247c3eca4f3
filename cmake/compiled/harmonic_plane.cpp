// Compiles the solvers of harmonic coordinates in the plane.
#include "instantiate.hpp"

#include <cageform/coordinates/harmonic/adaptive.impl.hpp>
#include <cageform/coordinates/harmonic/uniform.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

CAGEFORM_HARMONIC(float, 2)
CAGEFORM_HARMONIC(double, 2)

} // namespace cageform::inline CAGEFORM_ABI

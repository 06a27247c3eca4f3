// Compiles the solvers of harmonic coordinates in space.
#include "instantiate.hpp"

#include <cageform/coordinates/harmonic/adaptive.impl.hpp>
#include <cageform/coordinates/harmonic/uniform.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

CAGEFORM_HARMONIC(float, 3)
CAGEFORM_HARMONIC(double, 3)

} // namespace cageform::inline CAGEFORM_ABI

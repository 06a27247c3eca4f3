// Compiles mean value coordinates in the plane.
#include "instantiate.hpp"

#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/mean_value/evaluation.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

CAGEFORM_MEAN_VALUE(Polygon<float>, float)
CAGEFORM_MEAN_VALUE(Polygon<double>, double)

} // namespace cageform::inline CAGEFORM_ABI

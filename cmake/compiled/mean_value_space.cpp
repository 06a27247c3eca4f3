// Compiles mean value coordinates in space.
#include "instantiate.hpp"

#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/mean_value/evaluation.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

CAGEFORM_MEAN_VALUE(TriangleMesh<float>, float)
CAGEFORM_MEAN_VALUE(TriangleMesh<double>, double)
CAGEFORM_MEAN_VALUE(PolyhedralMesh<float>, float)
CAGEFORM_MEAN_VALUE(PolyhedralMesh<double>, double)

} // namespace cageform::inline CAGEFORM_ABI

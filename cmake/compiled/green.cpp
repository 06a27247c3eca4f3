// Compiles Green coordinates.
#include "instantiate.hpp"

#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/green/evaluation.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

#define CAGEFORM_GREEN(Cage, T, D)                                                                           \
    CAGEFORM_EVALUATION(detail::GreenEvaluation<Cage>, T)                                                    \
    CAGEFORM_COMPILE auto detail::GreenEvaluation<Cage>::nearest_boundary(const Vec<T, D>&, std::span<T>)    \
        const->Vec<T, D>;                                                                                    \
    CAGEFORM_COMPILE void detail::GreenEvaluation<Cage>::prepare();
CAGEFORM_GREEN(Polygon<float>, float, 2)
CAGEFORM_GREEN(Polygon<double>, double, 2)
CAGEFORM_GREEN(TriangleMesh<float>, float, 3)
CAGEFORM_GREEN(TriangleMesh<double>, double, 3)
CAGEFORM_GREEN(PolyhedralMesh<float>, float, 3)
CAGEFORM_GREEN(PolyhedralMesh<double>, double, 3)

} // namespace cageform::inline CAGEFORM_ABI

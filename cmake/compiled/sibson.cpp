// Compiles natural neighbour coordinates.
#include "instantiate.hpp"

#include <cageform/coordinates/sibson/evaluation.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

using Sibson = SibsonCoordinates<CAGEFORM_T, CAGEFORM_D>;
CAGEFORM_EVALUATION(Sibson, CAGEFORM_T)
CAGEFORM_COMPILE Vec<CAGEFORM_T, CAGEFORM_D> Sibson::nearest_boundary(const Vec<CAGEFORM_T, CAGEFORM_D>&,
                                                                      std::span<CAGEFORM_T>) const;
CAGEFORM_COMPILE Status Sibson::prepare();

} // namespace cageform::inline CAGEFORM_ABI

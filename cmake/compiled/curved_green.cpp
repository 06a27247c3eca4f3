// Compiles Green coordinates of curved cages, in the plane.
#include "instantiate.hpp"

#if CAGEFORM_D == 2
#include <cageform/coordinates/curved_green/evaluation.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

using Curved = CurvedGreenCoordinates<CAGEFORM_T>;
CAGEFORM_EVALUATION(Curved, CAGEFORM_T)
CAGEFORM_COMPILE Vec<CAGEFORM_T, 2> Curved::nearest_boundary(const Vec<CAGEFORM_T, 2>&,
                                                             std::span<CAGEFORM_T>) const;
CAGEFORM_COMPILE detail::OutsideDistance<2>
Curved::distance_outside(const Vec<CAGEFORM_T, 2>&) const noexcept;
CAGEFORM_COMPILE void Curved::prepare(const CurvedGreenOptions<CAGEFORM_T>&);

} // namespace cageform::inline CAGEFORM_ABI
#endif

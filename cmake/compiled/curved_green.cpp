// Compiles Green coordinates of curved cages (2D).
#include "instantiate.hpp"

#if CAGEFORM_D == 2
#include <cageform/coordinates/curved_green/evaluation.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

#define CAGEFORM_CURVED(T, D)                                                                                \
    CAGEFORM_EVALUATION(T, CurvedGreenCoordinates<T>)                                                        \
    CAGEFORM_COMPILE Vec<T, D> CurvedGreenCoordinates<T>::nearest_boundary(const Vec<T, D>&, std::span<T>)   \
        const;                                                                                               \
    CAGEFORM_COMPILE detail::OutsideDistance<D> CurvedGreenCoordinates<T>::distance_outside(                 \
        const Vec<T, D>&) const noexcept;                                                                    \
    CAGEFORM_COMPILE void CurvedGreenCoordinates<T>::prepare(const CurvedGreenOptions<T>&);
CAGEFORM_FOR_SCALARS(CAGEFORM_CURVED, 2)

} // namespace cageform::inline CAGEFORM_ABI
#endif

// Compiles natural neighbour coordinates.
#include "instantiate.hpp"

#include <cageform/coordinates/sibson/evaluation.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

#define CAGEFORM_SIBSON(T, D)                                                                                \
    CAGEFORM_EVALUATION(T, SibsonCoordinates<T, D>)                                                          \
    CAGEFORM_COMPILE Vec<T, D> SibsonCoordinates<T, D>::nearest_boundary(const Vec<T, D>&, std::span<T>)     \
        const;                                                                                               \
    CAGEFORM_COMPILE Status SibsonCoordinates<T, D>::prepare();
CAGEFORM_FOR_SCALARS(CAGEFORM_SIBSON, CAGEFORM_D)

} // namespace cageform::inline CAGEFORM_ABI

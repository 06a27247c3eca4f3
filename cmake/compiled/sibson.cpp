// Compiles natural neighbour coordinates.
#include "instantiate.hpp"

#include <cageform/coordinates/sibson/evaluation.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

#define CAGEFORM_SIBSON(T, D)                                                                                \
    CAGEFORM_COMPILE Evaluation SibsonCoordinates<T, D>::evaluate(                                           \
        BlockView<const T>, BlockView<T>, std::span<PointState>, const Running&) const;                      \
    CAGEFORM_COMPILE Evaluation SibsonCoordinates<T, D>::evaluate_gradients(                                 \
        BlockView<const T>, BlockView<T>, std::span<PointState>, const Running&) const;                      \
    CAGEFORM_COMPILE Vec<T, D> SibsonCoordinates<T, D>::nearest_boundary(const Vec<T, D>&, std::span<T>)     \
        const;                                                                                               \
    CAGEFORM_COMPILE Status SibsonCoordinates<T, D>::prepare();
CAGEFORM_SIBSON(float, 2)
CAGEFORM_SIBSON(float, 3)
CAGEFORM_SIBSON(double, 2)
CAGEFORM_SIBSON(double, 3)

} // namespace cageform::inline CAGEFORM_ABI

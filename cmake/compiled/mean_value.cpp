// Compiles mean value coordinates.
#include "instantiate.hpp"

#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/mean_value/evaluation.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

#define CAGEFORM_MEAN_VALUE(Cage, T, D)                                                                      \
    CAGEFORM_EVALUATION(T, detail::MeanValueEvaluation<Cage>)                                                \
    CAGEFORM_COMPILE Status detail::MeanValueEvaluation<Cage>::prepare();
CAGEFORM_FOR_CAGES(CAGEFORM_MEAN_VALUE)

} // namespace cageform::inline CAGEFORM_ABI

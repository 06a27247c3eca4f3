// Compiles mean value coordinates.
#include "instantiate.hpp"

#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/mean_value/evaluation.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

#define CAGEFORM_MEAN_VALUE(Cage, T, D)                                                                      \
    CAGEFORM_EVALUATION(detail::MeanValueEvaluation<Cage>, T)                                                \
    CAGEFORM_COMPILE void detail::MeanValueEvaluation<Cage>::prepare();
CAGEFORM_FOR_CAGES(CAGEFORM_MEAN_VALUE, CAGEFORM_T)

} // namespace cageform::inline CAGEFORM_ABI

// Compiles Green coordinates.
#include "instantiate.hpp"

#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/green/evaluation.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

#define CAGEFORM_GREEN(Cage, T, D)                                                                           \
    CAGEFORM_EVALUATION(T, detail::GreenEvaluation<Cage>)                                                    \
    CAGEFORM_COMPILE auto detail::GreenEvaluation<Cage>::nearest_boundary(const Vec<T, D>&, std::span<T>)    \
        const -> Vec<T, D>;                                                                                  \
    CAGEFORM_COMPILE Status detail::GreenEvaluation<Cage>::prepare();
CAGEFORM_FOR_CAGES(CAGEFORM_GREEN)

} // namespace cageform::inline CAGEFORM_ABI

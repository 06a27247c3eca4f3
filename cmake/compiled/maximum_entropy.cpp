// Compiles maximum entropy coordinates.
#include "instantiate.hpp"

#include <cageform/coordinates/entropy/evaluation.impl.hpp>
#include <cageform/coordinates/maximum_entropy.hpp>

namespace cageform::inline CAGEFORM_ABI {

#define CAGEFORM_MAXIMUM_ENTROPY(Cage, T, D) CAGEFORM_EVALUATION(T, detail::EntropyEvaluation<Cage>)
CAGEFORM_FOR_CAGES(CAGEFORM_MAXIMUM_ENTROPY)

} // namespace cageform::inline CAGEFORM_ABI

// Compiles the solvers of harmonic coordinates in the space.
#include "instantiate.hpp"

#include <cageform/coordinates/harmonic/adaptive.impl.hpp>
#include <cageform/coordinates/harmonic/uniform.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#define CAGEFORM_HARMONIC(T)                                                                                 \
    CAGEFORM_COMPILE Status make_adaptive(std::shared_ptr<const PlacedCage<3>>, SolverReport&,               \
                                          std::shared_ptr<CageFunctions<T, 3>>&);                            \
    CAGEFORM_COMPILE Status make_uniform(std::shared_ptr<const PlacedCage<3>>, SolverReport&,                \
                                         std::shared_ptr<CageFunctions<T, 3>>&);
CAGEFORM_FOR_SCALARS(CAGEFORM_HARMONIC)

} // namespace cageform::inline CAGEFORM_ABI::detail

// Compiles the solvers of harmonic coordinates.
#include "instantiate.hpp"

#include <cageform/coordinates/harmonic/adaptive.impl.hpp>
#include <cageform/coordinates/harmonic/uniform.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#define CAGEFORM_SOLVER(make_solver)                                                                         \
    CAGEFORM_COMPILE Status make_solver(std::shared_ptr<const PlacedCage<CAGEFORM_D>>, SolverReport&,        \
                                        std::shared_ptr<CageFunctions<CAGEFORM_T, CAGEFORM_D>>&,             \
                                        const Running&);
CAGEFORM_SOLVER(make_adaptive)
CAGEFORM_SOLVER(make_uniform)

} // namespace cageform::inline CAGEFORM_ABI::detail

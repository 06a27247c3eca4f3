// Compiles the solvers of harmonic coordinates.
#include "instantiate.hpp"

#include <cageform/coordinates/harmonic/adaptive.impl.hpp>
#include <cageform/coordinates/harmonic/uniform.impl.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

#define CAGEFORM_SOLVER(make_solver, T, D)                                                                   \
    CAGEFORM_COMPILE Status make_solver(std::shared_ptr<const PlacedCage<D>>, SolverReport&,                 \
                                        std::shared_ptr<CageFunctions<T, D>>&, const Running&);
#define CAGEFORM_SOLVERS(T, D) CAGEFORM_SOLVER(make_adaptive, T, D) CAGEFORM_SOLVER(make_uniform, T, D)
CAGEFORM_FOR_SCALARS(CAGEFORM_SOLVERS, CAGEFORM_D)

} // namespace cageform::inline CAGEFORM_ABI::detail

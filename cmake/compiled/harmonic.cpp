// Compiles the solvers of harmonic coordinates.
#include "instantiate.hpp"

#include <cageform/coordinates/harmonic/adaptive.impl.hpp>
#include <cageform/coordinates/harmonic/uniform.impl.hpp>

namespace cageform::inline CAGEFORM_ABI {

#define CAGEFORM_SOLVER(Solver, T, D)                                                                        \
    CAGEFORM_COMPILE Status Solver::operator()(std::shared_ptr<const SolverInput<D>>, SolverReport&,         \
                                               std::shared_ptr<CageFunctions<T, D>>&, const Running&) const;
#define CAGEFORM_SOLVERS(T, D) CAGEFORM_SOLVER(AdaptiveGrid, T, D) CAGEFORM_SOLVER(UniformGrid, T, D)
CAGEFORM_FOR_SCALARS(CAGEFORM_SOLVERS, CAGEFORM_D)

} // namespace cageform::inline CAGEFORM_ABI

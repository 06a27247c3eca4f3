// Definition of UniformGrid. Not included if the program links cageform::compiled.
#pragma once

#include <cageform/coordinates/harmonic/multigrid_solver.hpp>
#include <cageform/coordinates/harmonic/solution.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>

namespace cageform::inline CAGEFORM_ABI {

template <class T, std::size_t D>
Status UniformGrid::operator()(std::shared_ptr<const SolverInput<D>> input, SolverReport& report,
                               std::shared_ptr<CageFunctions<T, D>>& made, const Running& running) const {
    return make_functions<MultigridSolver<D>, T>(std::move(input), report, made, running);
}

} // namespace cageform::inline CAGEFORM_ABI

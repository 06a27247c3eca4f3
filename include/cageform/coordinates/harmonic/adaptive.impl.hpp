// Definition of AdaptiveGrid. Not included if the program links cageform::compiled.
#pragma once

#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/harmonic/solution.hpp>
#include <cageform/coordinates/harmonic/tree_solver.hpp>

namespace cageform::inline CAGEFORM_ABI {

template <class T, std::size_t D>
Status AdaptiveGrid::operator()(std::shared_ptr<const SolverInput<D>> input, SolverReport& report,
                                std::shared_ptr<CageFunctions<T, D>>& made, const Running& running) const {
    if (input->options.resolution != 0) return Status::solver_not_supported;
    return make_functions<TreeSolver<D>, T>(std::move(input), report, made, running);
}

} // namespace cageform::inline CAGEFORM_ABI

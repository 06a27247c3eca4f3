// Defines the function behind HarmonicCoordinates. harmonic.hpp includes it, unless the program links
// cageform::compiled.
#pragma once

#include <cageform/coordinates/harmonic/solution.hpp>
#include <cageform/coordinates/harmonic/tree_solver.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template <class T, std::size_t D>
Status make_adaptive(std::shared_ptr<const PlacedCage<D>> cage, SolverReport& report,
                     std::shared_ptr<CageFunctions<T, D>>& made, const Running& running) {
    return make_functions<TreeSolver<D>, T>(std::move(cage), report, made, running);
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// A solver of harmonic coordinates on a uniform grid of given resolution.
#pragma once

#include <cageform/coordinates/harmonic.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Solves on a uniform grid (harmonic/multigrid_solver.hpp) with HarmonicOptions::resolution cells along the
/// cage's longest side: `HarmonicCoordinates coordinates(cage, {.resolution = 128}, UniformGrid{})`. The
/// default, AdaptiveGrid, is faster for the same accuracy. Errors on a uniform grid decrease regularly with
/// the resolution.
///
///   accuracy  of order h² in the cell size h away from the boundary, and around treated 2D corners. A corner
///             is treated if no other part of the boundary lies within h (within 2h if too few nodes for a
///             fit lie within h; grid/corners/corner_functions.hpp). Of order h^(π/ω) next to an untreated
///             corner or 3D edge of interior angle ω
///   smooth    not continuous: weights jump between cells, by at most about the error
///   cost      as AdaptiveGrid; #V more numbers in memory for each point next to a treated corner
///   fails     as AdaptiveGrid, but not accuracy_not_supported; tolerance_not_positive;
///             resolution_not_supported if the resolution is not set or out of range
struct UniformGrid {
    template <class T, std::size_t D>
    Status operator()(std::shared_ptr<const SolverInput<D>> input, SolverReport& report,
                      std::shared_ptr<CageFunctions<T, D>>& made, const Running& running) const;
};

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/coordinates/harmonic/uniform.impl.hpp>
#endif

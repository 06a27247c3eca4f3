// How harmonic functions are made.
#pragma once

#include <cageform/grid/averaging_pyramid.hpp>
#include <cageform/grid/sample.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Which solver makes the functions.
enum class HarmonicSolver : std::uint8_t {
    multigrid,         ///< all functions sixteen by sixteen, boundary where it is (grid/multigrid.hpp)
    averaging_pyramid, ///< the papers' own, the historical baseline (grid/averaging_pyramid.hpp)
};

struct MultigridOptions {
    double tolerance = 1e-6;      ///< of the discrete solution's error, by SolverReport::error_estimate
    std::size_t max_cycles = 60;  ///< not_converged when they do not suffice
    bool corner_functions = true; ///< treat the singularities at corners (grid/corner_functions.hpp)
};

struct HarmonicOptions {
    HarmonicSolver solver = HarmonicSolver::multigrid;
    std::size_t resolution = 128; ///< cells along the cage's longest side; 8 … 16384
    MultigridOptions multigrid{};

    // Of the averaging pyramid alone; its resolution counts a margin of four cells.
    AveragingOptions averaging{.tolerance = 1e-6};
    Interpolation interpolation = Interpolation::multilinear;
    std::size_t handles_at_once = 16; ///< functions kept in memory together while points are sampled
};

} // namespace cageform::inline CAGEFORM_ABI

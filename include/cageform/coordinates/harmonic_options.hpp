// How harmonic functions are made.
#pragma once

#include <cageform/grid/pyramid/averaging_pyramid.hpp>
#include <cageform/grid/pyramid/sample.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Which solver makes the functions.
enum class HarmonicSolver : std::uint8_t {
    multigrid,         ///< sixteen functions at a time, boundary where it is
    averaging_pyramid, ///< the papers' own, the historical baseline: of coordinates with
                       ///< WithAveragingPyramid alone (coordinates/pyramid_solver.hpp)
};

struct MultigridOptions {
    /// Of the discrete solution, SolverReport::error_estimate, on the uniform grid; on the adaptive one
    /// the accuracy says how far to solve.
    double tolerance = 1e-6;
    std::size_t max_cycles = 60;  ///< not_converged when they do not suffice
    bool corner_functions = true; ///< on the uniform grid: treat corners apart (grid/corner_functions.hpp)
};

struct HarmonicOptions {
    HarmonicSolver solver = HarmonicSolver::multigrid;
    /// The largest error wanted of a weight, 1e-5 … 0.1, which an adaptive grid is made for
    /// (coordinates/tree_solver.hpp). In the plane it is met. In space it is met where faces are large,
    /// up to edges and corners, within 1.5 times next to reflex edges; and in thin parts and deep below
    /// small faces, where three times that was measured. Less deep than a small face is wide it is not,
    /// as its hat falls off within a cell or two: by up to a tenth of a weight, as
    /// SolverReport::grid_error says.
    double accuracy = 1e-3;
    /// Other than 0: a uniform grid of so many cells along the cage's longest side instead, 8 … 16384,
    /// in space 8 … 1024; `accuracy` is not looked at.
    std::size_t resolution = 0;
    /// In bytes. What takes more on one thread (hierarchy and block, with `solve` the functions kept)
    /// is refused before it is tried. The default is 8 GiB, 1 GiB where addresses have 32 bits.
    std::size_t memory_limit = std::size_t{1} << (sizeof(std::size_t) > 4 ? 33 : 30);
    MultigridOptions multigrid{};

    // Of the averaging pyramid alone, which needs a resolution; that counts a margin of four cells.
    grid::AveragingOptions averaging{.tolerance = 1e-6};
    grid::Interpolation interpolation = grid::Interpolation::multilinear;
    std::size_t handles_at_once = 16; ///< functions solved and sampled together
};

} // namespace cageform::inline CAGEFORM_ABI

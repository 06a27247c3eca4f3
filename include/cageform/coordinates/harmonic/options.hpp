// Options of harmonic coordinates.
#pragma once

#include <cageform/config.hpp>

#include <cstddef>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

namespace grid {

/// The neighbours whose mean a cell's value is.
enum class Stencil : std::uint8_t {
    /// 2, 4 or 6 (in 1D, 2D, 3D): the usual discrete Laplace equation.
    face_neighbours,
    all_neighbours, ///< 2, 8 or 26, including diagonals, with equal weights: "harmonic crosswords"
};

struct AveragingOptions {
    Stencil stencil = Stencil::face_neighbours;
    /// The pyramid ends at this many cells a side; if it is not below the grid's own size, there is
    /// one level.
    std::size_t coarsest = 16;
    double tolerance = 1e-5;         ///< τ: sweeps end when the mean change of a cell is below it; 0: never
    std::size_t max_sweeps = 100000; ///< on each level
    /// Sweeps start with the given values of interior cells instead of 0. There is then one level,
    /// whatever `coarsest` is.
    bool first_guess = false;
};

enum class Interpolation : std::uint8_t {
    nearest_cell, ///< the look-up of the papers: constant within a cell
    multilinear,  ///< between the 2^D nearest centres, leaving out exterior ones
};

} // namespace grid

/// The solver that computes the functions.
enum class HarmonicSolver : std::uint8_t {
    multigrid, ///< sixteen functions at a time, with the exact boundary position
    /// The solver of the papers, as a historical baseline; coordinates need WithAveragingPyramid
    /// (papers/pyramid_solver.hpp) to use it.
    averaging_pyramid,
};

struct MultigridOptions {
    /// The error at which the cycles stop on the uniform grid (SolverReport::Multigrid::error_estimate). On
    /// the adaptive grid HarmonicOptions::accuracy decides instead.
    double tolerance = 1e-6;
    std::size_t max_cycles = 60; ///< not_converged if more are needed
    /// On the uniform grid: treats corners separately (grid/corners/corner_functions.hpp).
    bool corner_functions = true;
};

/// The range of HarmonicOptions::resolution.
inline constexpr std::size_t least_resolution = 8;
template <std::size_t D>
inline constexpr std::size_t most_resolution = D == 2 ? 16384 : 1024;

struct HarmonicOptions {
    HarmonicSolver solver = HarmonicSolver::multigrid;
    /// The largest error of a weight, 1e-5 … 0.1, for which an adaptive grid is made
    /// (coordinates/harmonic/tree_solver.hpp). In 2D errors stay within the accuracy. In 3D, depending
    /// on the cage, 93 to 100 % of the points do. The largest errors measured are ten times the
    /// accuracy, next to vertices where reflex edges meet (`bench_smoothness weights`). 3D cages with
    /// cells inside or with faces of more than three corners have no near field
    /// (coordinates/harmonic/near_rows.hpp). Errors in such cages can reach 0.1 at points
    /// whose distance from a small face is less than the width of the face.
    /// SolverReport::grid_error estimates the largest error.
    double accuracy = 1e-3;
    /// For UniformHarmonicCoordinates: this many cells along the cage's longest side, 8 … 16384, in
    /// 3D 8 … 1024. `accuracy` is then ignored.
    std::size_t resolution = 0;
    /// In bytes. A solve that needs more on one thread (hierarchy and block, with `solve` also the kept
    /// functions) is refused before it starts; SolverReport::cells and bytes then estimate it. The default
    /// is 8 GiB, 1 GiB where addresses have 32 bits.
    std::size_t memory_limit = std::size_t{1} << (sizeof(std::size_t) > 4 ? 33 : 30);
    MultigridOptions multigrid{};

    // For the averaging pyramid only, which needs a resolution and adds a margin of four cells
    // within it.
    grid::AveragingOptions averaging{.tolerance = 1e-6};
    grid::Interpolation interpolation = grid::Interpolation::multilinear;
    std::size_t handles_at_once = 16; ///< functions solved and sampled together
};

} // namespace cageform::inline CAGEFORM_ABI

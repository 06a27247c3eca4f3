// How harmonic functions are made.
#pragma once

#include <cageform/config.hpp>

#include <cstddef>
#include <cstdint>

namespace cageform::inline CAGEFORM_ABI {

namespace grid {

/// Which neighbours a cell is the mean of.
enum class Stencil : std::uint8_t {
    face_neighbours, ///< 2, 4 or 6 (in 1D, 2D, 3D): the usual discrete Laplace equation
    all_neighbours,  ///< 2, 8 or 26, diagonals included, all alike: "harmonic crosswords"
};

struct AveragingOptions {
    Stencil stencil = Stencil::face_neighbours;
    std::size_t coarsest = 16; ///< the pyramid ends at this many cells a side; ≥ the grid's: one level
    double tolerance = 1e-5;   ///< τ: sweeps end when the mean change of a cell is below it; 0: never
    std::size_t max_sweeps = 100000; ///< on each level
    bool first_guess = false;        ///< sweeps begin with the values that interior cells have, not with 0;
                                     ///< there is one level then, whatever `coarsest`
};

enum class Interpolation : std::uint8_t {
    nearest_cell, ///< the papers' look-up: constant within a cell
    multilinear,  ///< between the 2^D nearest centres, leaving out exterior ones
};

} // namespace grid

/// Which solver makes the functions.
enum class HarmonicSolver : std::uint8_t {
    multigrid,         ///< sixteen functions at a time, boundary where it is
    averaging_pyramid, ///< the papers' own, the historical baseline: of coordinates with
                       ///< WithAveragingPyramid alone (papers/pyramid_solver.hpp)
};

struct MultigridOptions {
    /// Of the discrete solution, SolverReport::error_estimate, on the uniform grid; on the adaptive one
    /// the accuracy says how far to solve.
    double tolerance = 1e-6;
    std::size_t max_cycles = 60; ///< not_converged when they do not suffice
    bool corner_functions =
        true; ///< on the uniform grid: treat corners apart (grid/corners/corner_functions.hpp)
};

struct HarmonicOptions {
    HarmonicSolver solver = HarmonicSolver::multigrid;
    /// The largest error wanted of a weight, 1e-5 … 0.1, which an adaptive grid is made for
    /// (coordinates/harmonic/tree_solver.hpp). In the plane it is met. In space it is met where faces are large,
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

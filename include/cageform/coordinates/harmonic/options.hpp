// Options of harmonic coordinates.
#pragma once

#include <cageform/config.hpp>

#include <cstddef>

namespace cageform::inline CAGEFORM_ABI {

struct MultigridOptions {
    /// UniformGrid: the error at which cycles stop (SolverReport::Multigrid::error_estimate). For
    /// AdaptiveGrid see HarmonicOptions::accuracy.
    double tolerance = 1e-6;
    std::size_t max_cycles = 60; ///< the status is not_converged if more are needed
    /// UniformGrid: treats corners separately (grid/corners/corner_functions.hpp).
    bool corner_functions = true;
};

/// The range of HarmonicOptions::resolution.
inline constexpr std::size_t least_resolution = 8;
template <std::size_t D>
inline constexpr std::size_t most_resolution = D == 2 ? 16384 : 1024;

struct HarmonicOptions {
    /// AdaptiveGrid: the error of weights, 1e-5 … 0.1, for which the grid is made (harmonic/tree_solver.hpp).
    /// In 2D all errors are within it, in 3D those of 93 to 100 % of the points, depending on the cage. The
    /// largest measured errors are ten times the accuracy, next to vertices where reflex edges meet
    /// (`bench_smoothness weights`). 3D cages with interior cells or faces of more than three corners have no
    /// near field (harmonic/near_rows.hpp); their errors can reach 0.1 at points nearer to a small face than
    /// its width. SolverReport::grid_error estimates the largest error.
    double accuracy = 1e-3;
    /// UniformGrid: number of cells along the cage's longest side, 8 … 16384, in 3D 8 … 1024. UniformGrid
    /// ignores `accuracy`. AdaptiveGrid: 0.
    std::size_t resolution = 0;
    /// Limit in bytes. If a solve needs more on one thread (hierarchy, block, and for `solve` the kept
    /// functions), it is refused before it starts. SolverReport::cells and bytes are then estimates.
    /// Default: 8 GiB, or 1 GiB for 32-bit addresses.
    std::size_t memory_limit = std::size_t{1} << (sizeof(std::size_t) > 4 ? 33 : 30);
    MultigridOptions multigrid{};
    /// κ times the diagonal of the box around the cage, of local harmonic coordinates (HarmonicCoordinates).
    /// 0: harmonic coordinates. 40 leaves out a fifth of the weights above 1 % in 2D, a tenth in 3D.
    double locality = 0;
    /// The largest locality. With a larger one, the functions vanish in the middle of wide cages.
    static constexpr double most_locality = 40;
};

} // namespace cageform::inline CAGEFORM_ABI

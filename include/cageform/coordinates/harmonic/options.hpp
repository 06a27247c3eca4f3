// Options of harmonic coordinates.
#pragma once

#include <cageform/config.hpp>

#include <cstddef>

namespace cageform::inline CAGEFORM_ABI {

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
    /// The largest error of a weight, 1e-5 … 0.1, for which an adaptive grid is made
    /// (coordinates/harmonic/tree_solver.hpp). In 2D errors stay within the accuracy. In 3D, depending
    /// on the cage, 93 to 100 % of the points do. The largest errors measured are ten times the
    /// accuracy, next to vertices where reflex edges meet (`bench_smoothness weights`). 3D cages with
    /// cells inside or with faces of more than three corners have no near field
    /// (coordinates/harmonic/near_rows.hpp). Errors in such cages can reach 0.1 at points
    /// whose distance from a small face is less than the width of the face.
    /// SolverReport::grid_error estimates the largest error.
    double accuracy = 1e-3;
    /// For UniformGrid: this many cells along the cage's longest side, 8 … 16384, in
    /// 3D 8 … 1024. `accuracy` is then ignored.
    std::size_t resolution = 0;
    /// In bytes. A solve that needs more on one thread (hierarchy and block, with `solve` also the kept
    /// functions) is refused before it starts; SolverReport::cells and bytes then estimate it. The default
    /// is 8 GiB, 1 GiB where addresses have 32 bits.
    std::size_t memory_limit = std::size_t{1} << (sizeof(std::size_t) > 4 ? 33 : 30);
    MultigridOptions multigrid{};
};

} // namespace cageform::inline CAGEFORM_ABI

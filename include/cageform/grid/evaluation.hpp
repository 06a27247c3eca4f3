// The outcome of evaluating coordinates, and what a solver tells of its work.
#pragma once

#include <cageform/core/running.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// What a solver did. All zero for closed forms.
struct SolverReport {
    static constexpr std::size_t none = ~std::size_t{0};

    std::size_t cells = 0;  ///< unknowns of one function
    std::size_t cycles = 0; ///< of the multigrid, the most that a function took
    double convergence_factor =
        0; ///< error after a multigrid cycle over that before, the worst met above the tolerance
    double error_estimate = 0; ///< of the discrete solution: what the multigrid stops on (grid/multigrid.hpp)
    double error_bound = 0;    ///< the same by the maximum principle alone, far above it
    std::size_t bytes = 0;     ///< of the hierarchy and one block of functions
    std::size_t unseen_handle = none;      ///< with Status::grid_too_coarse: the first that no node feels,
    std::size_t sufficient_resolution = 0; ///< and a resolution at which all are felt; 0: none is offered
    std::size_t culprit = none;     ///< with rim_not_given or value_not_finite of solve_dirichlet: where
    std::size_t crowded_cells = 0;  ///< cells that hold edges which do not share a vertex: the grid is
                                    ///< too coarse to tell them apart
    std::size_t solves = 0;         ///< functions solved
    std::size_t sweeps = 0;         ///< of the averaging solver on the finest grid, over all functions
    std::size_t unconverged = 0;    ///< functions whose tolerance was not met
    double largest_mean_change = 0; ///< of the averaging solver's last sweep, over all functions
    double seconds = 0;             ///< wall-clock time

    /// Adds what the solver did for other functions: counts and times add up, of the rest the worst is kept. Culprits and
    /// unseen handles are left as they are.
    void add(const SolverReport& part) noexcept {
        cells += part.cells;
        cycles = std::max(cycles, part.cycles);
        convergence_factor = std::max(convergence_factor, part.convergence_factor);
        error_estimate = std::max(error_estimate, part.error_estimate);
        error_bound = std::max(error_bound, part.error_bound);
        bytes = std::max(bytes, part.bytes);
        crowded_cells += part.crowded_cells;
        solves += part.solves;
        sweeps += part.sweeps;
        unconverged += part.unconverged;
        largest_mean_change = std::max(largest_mean_change, part.largest_mean_change);
        seconds += part.seconds;
    }
};

/// Outcome of evaluating a coordinate type for a batch of points.
struct Evaluation {
    Status status = Status::ok;
    SolverReport solver;
};

} // namespace cageform::inline CAGEFORM_ABI

// The outcome of evaluating coordinates, and what a solver tells of its work.
#pragma once

#include <cageform/core/running.hpp>

#include <algorithm>
#include <array>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// A corner in the plane or an edge in space that a grid may be too coarse for.
struct CornerError {
    static constexpr double notable = 0.01; ///< an error worth a warning

    std::array<std::size_t, 2> handles{}; ///< the edge's ends; in the plane both are the corner
    double error = 0;                     ///< that it makes of a weight at most, by an estimate; in [0, 1]
    std::size_t resolution = 0; ///< if that is notable, one at which it is not; 0: no grid is so fine
};

/// Why an adaptive grid is as fine as it is somewhere.
enum class SizeReason : std::uint8_t {
    largest,         ///< the largest cells allowed
    thickness,       ///< of the cage, cells across it
    facet,           ///< the least altitude of a face, in the plane the length of an edge
    singular_edge,   ///< in space: a reflex edge or the rim of a wall
    singular_vertex, ///< a corner, the end of a wall, in space the end of a reflex edge
    bone,            ///< the radius of a bone, or what is near it
};
/// In words, of an enumerator.
constexpr const char* to_string(SizeReason reason) noexcept {
    switch (reason) {
    case SizeReason::largest: return "the largest cells allowed";
    case SizeReason::thickness: return "the thickness of the cage";
    case SizeReason::facet: return "the size of a face";
    case SizeReason::singular_edge: return "a reflex edge";
    case SizeReason::singular_vertex: return "a corner";
    case SizeReason::bone: return "a bone";
    }
    return "unknown";
}

/// What a solver did. All zero for closed forms.
struct SolverReport {
    static constexpr std::size_t none = ~std::size_t{0};

    // Of every solver.
    std::size_t cells = 0;       ///< unknowns of one function
    std::size_t solves = 0;      ///< functions solved
    std::size_t unconverged = 0; ///< functions whose tolerance a solve that failed has not met
    std::size_t bytes = 0;       ///< of what all functions share and of one group of functions
    double seconds = 0;          ///< wall-clock time of solving, and of sampling what is not kept

    // Of the multigrid, the worst over all functions (grid/multigrid.hpp).
    std::size_t cycles = 0;
    double convergence_factor = 0; ///< error after a cycle over that before, above the tolerance
    double error_estimate = 0;     ///< of the discrete solution: what the cycles stop on
    double error_bound = 0;        ///< the same by the maximum principle alone, far above it

    /// Every edge in space, in the plane the corners with fewer than ten cells of room (without
    /// MultigridOptions::corner_functions all); of a Box none. The largest estimate is meant to be
    /// above all errors and less than fifteen times the largest (grid/corners/corner_errors.hpp).
    std::vector<CornerError> corners;

    // Of an adaptive grid (coordinates/harmonic/tree_solver.hpp).
    /// At up to a thousand places spread over its cells, by an estimate, how far the largest error of a
    /// weight is that the grid leaves. In cells that facets pass they are largest.
    std::vector<float> grid_errors;
    double finest_size = 0;                         ///< of its cells, in units of the cage; 0: none
    std::array<double, 3> finest_place{};           ///< in one of them or beside it
    SizeReason finest_reason = SizeReason::largest; ///< why they are so small

    // Of the averaging pyramid (papers/averaging_pyramid.hpp).
    std::size_t sweeps = 0;         ///< on the finest grid, over all functions
    double largest_mean_change = 0; ///< of the last sweep, over all functions
    std::size_t crowded_cells = 0;  ///< cells that hold edges or faces without a common vertex

    // Of what is refused.
    std::size_t unseen_handle = none; ///< grid_too_coarse: the first handle whose data meets no link
    /// A resolution that would do, where grid_too_coarse or out_of_memory say that the given one does
    /// not; 0: none is offered. With out_of_memory `bytes` is what was asked for, if known; of an
    /// adaptive grid by an estimate, a factor of two off at most on the cages measured.
    std::size_t sufficient_resolution = 0;
    /// On an adaptive grid in space: an accuracy that would do, where out_of_memory says that the given
    /// one does not, by an estimate; 0: none is offered.
    double sufficient_accuracy = 0;
    /// The place in what is refused: a cell or value (fields/dirichlet.hpp), a node or link
    /// (fields/graph.hpp), a stroke (fields/strokes.hpp).
    std::size_t culprit = none;
    std::size_t unreached_cells = 0; ///< cells_unreached: in all parts without a given value

    /// What grid_errors do not exceed at a part of their places, in [0, 1]. Of all of them it has been
    /// measured between half and four times the largest error anywhere.
    double grid_error(double part = 1) const {
        if (grid_errors.empty()) return 0;
        auto sorted = grid_errors;
        std::sort(sorted.begin(), sorted.end());
        return double(sorted[std::size_t(part * double(sorted.size() - 1))]);
    }

    /// Where the largest error is to be feared, of error 0 where nowhere; with a resolution at which
    /// no corner's is notable.
    CornerError worst_corner() const noexcept {
        CornerError worst;
        std::size_t resolution = 0;
        bool reachable = true;
        for (const CornerError& corner : corners) {
            if (corner.error > CornerError::notable) {
                resolution = (std::max)(resolution, corner.resolution);
                reachable = reachable && corner.resolution != 0;
            }
            if (corner.error > worst.error) worst = corner;
        }
        worst.resolution = reachable ? resolution : 0;
        return worst;
    }

    /// Adds what was done for other functions: counts and times add up, of the rest the worst is
    /// kept. What is refused stays as it is.
    void add(const SolverReport& part) {
        cells += part.cells;
        solves += part.solves;
        unconverged += part.unconverged;
        bytes = (std::max)(bytes, part.bytes);
        seconds += part.seconds;
        cycles = (std::max)(cycles, part.cycles);
        convergence_factor = (std::max)(convergence_factor, part.convergence_factor);
        error_estimate = (std::max)(error_estimate, part.error_estimate);
        error_bound = (std::max)(error_bound, part.error_bound);
        add_corners(part.corners);
        add_grid_errors(part.grid_errors);
        if (part.finest_size > 0 && !(finest_size > 0 && finest_size <= part.finest_size)) {
            finest_size = part.finest_size;
            finest_place = part.finest_place;
            finest_reason = part.finest_reason;
        }
        sweeps += part.sweeps;
        largest_mean_change = (std::max)(largest_mean_change, part.largest_mean_change);
        crowded_cells += part.crowded_cells;
    }

private:
    /// Of other functions on the same grid, or of another grid.
    void add_grid_errors(const std::vector<float>& more) {
        if (grid_errors.size() != more.size()) {
            grid_errors.insert(grid_errors.end(), more.begin(), more.end());
            return;
        }
        for (std::size_t n = 0; n < more.size(); ++n) grid_errors[n] = (std::max)(grid_errors[n], more[n]);
    }
    /// The list of other functions of the same cage, whose corners are the same, or of another cage.
    void add_corners(const std::vector<CornerError>& more) {
        const auto same = [](const CornerError& a, const CornerError& b) { return a.handles == b.handles; };
        if (!std::equal(corners.begin(), corners.end(), more.begin(), more.end(), same)) {
            corners.insert(corners.end(), more.begin(), more.end());
            return;
        }
        for (std::size_t n = 0; n < more.size(); ++n) {
            if (more[n].error > corners[n].error) corners[n] = more[n];
        }
    }
};

/// Outcome of evaluating a coordinate type for a batch of points.
struct Evaluation {
    Status status = Status::ok;
    SolverReport solver;
};

namespace detail {

/// Runs f(report), which returns a Status, under the memory guard.
template <class F>
Evaluation guarded_evaluation(const F& f) {
    Evaluation evaluation;
    evaluation.status = guard_memory([&] { return f(evaluation.solver); });
    return evaluation;
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI

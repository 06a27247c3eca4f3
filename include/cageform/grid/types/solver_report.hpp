// The report of a solver: how much work it did, how accurate the result is, and why it refused a problem.
#pragma once

#include <cageform/core/detail/guard_memory.hpp>

#include <algorithm>
#include <array>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// The estimated error at a corner in the plane or an edge in space for which a grid may be too coarse.
struct CornerError {
    static constexpr double notable = 0.01; ///< errors from this value on are worth a warning

    std::array<std::size_t, 2> handles{}; ///< the ends of the edge; in the plane both are the corner
    double error = 0;                     ///< the largest error of a weight there, an estimate; in [0, 1]
    /// If the error is notable: a resolution at which it is not; 0: no grid is fine enough.
    std::size_t resolution = 0;
};

/// Why the cells of an adaptive grid are as small as they are at some point.
enum class SizeReason : std::uint8_t {
    largest,         ///< the largest allowed cell size
    thickness,       ///< the thickness of the cage: several cells must fit across it
    facet,           ///< the size of a face: its least altitude, in the plane the length of an edge
    singular_edge,   ///< a reflex edge or the rim of a wall, in space
    singular_vertex, ///< a corner or the end of a wall; in space also the end of a reflex edge
    bone,            ///< the radius of a bone, or its distance to other parts
};
/// Returns a reason in words.
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

/// The report of a solver. Every solver fills the first group of fields. Each other group belongs to one kind
/// of solver. Unfilled groups keep their initial values; coordinate types with closed forms fill none.
struct SolverReport {
    static constexpr std::size_t none = ~std::size_t{0};

    // ---- every solver ---------------------------------------------------------------------------
    std::size_t cells = 0;  ///< the number of unknowns of one function
    std::size_t solves = 0; ///< the number of functions solved
    /// The number of functions that a failed solve left above the tolerance.
    std::size_t unconverged = 0;
    /// Memory of the data that all functions share, plus that of one group of functions.
    std::size_t bytes = 0;
    double seconds = 0; ///< wall-clock time of solving, including sampling if samples are not kept

    /// Multigrid (grid/multigrid/multigrid.hpp): the worst over all functions.
    struct Multigrid {
        /// The number of multigrid cycles.
        std::size_t cycles = 0;
        double convergence_factor = 0; ///< error after a cycle / error before it, while above the tolerance
        /// The error of the discrete solution, an estimate; it decides when the cycles stop.
        double error_estimate = 0;
        double error_bound = 0; ///< an upper bound of that error, by the maximum principle; far above it

        /// In space, error estimates at all edges. In the plane, error estimates at the corners with fewer
        /// than ten cells of room; without MultigridOptions::corner_functions, at all corners. A
        /// PolyhedralMesh has none. In about 340 binds of random cages, the largest estimate was 1.2 to 65
        /// times the largest error (grid/corners/corner_errors.hpp).
        std::vector<CornerError> corners;
    };
    Multigrid multigrid;

    /// The adaptive grid (coordinates/harmonic/tree_solver.hpp).
    struct Tree {
        /// Estimates of the largest error that the grid causes in any weight, at up to a thousand points
        /// spread over its cells. They are largest in cells that facets intersect.
        std::vector<float> grid_errors;
        /// The size of the smallest cells, in units of the cage; 0: no grid was made.
        double finest_size = 0;
        std::array<double, 3> finest_position{}; ///< a point in one of the smallest cells, or next to it
        SizeReason finest_reason = SizeReason::largest; ///< why they are so small
    };
    Tree tree;

    /// A solver of your own that sweeps over its grid.
    struct Relaxation {
        std::size_t sweeps = 0;         ///< sweeps over the finest grid, summed over all functions
        double largest_mean_change = 0; ///< the largest change in the last sweep, over all functions
    };
    Relaxation relaxation;
    /// Number of places where the grid does not separate parts of the boundary. fields/strokes.hpp: links
    /// that more than one stroke cuts. Your own solver: cells with facets that have no common vertex.
    std::size_t unresolved_cells = 0;

    // ---- refused problems: the culprit, and what would work -------------------------------------
    /// For grid_too_coarse: the first handle whose data reaches no link of the grid.
    std::size_t unseen_handle = none;
    /// For grid_too_coarse and out_of_memory: a sufficient resolution; 0: unknown. With out_of_memory
    /// `bytes` holds the required memory, if known. For an adaptive grid it is an estimate, within a
    /// factor of two on the measured cages.
    std::size_t sufficient_resolution = 0;
    /// For out_of_memory on an adaptive grid: an accuracy that fits the limit, by estimate; 0: unknown.
    double sufficient_accuracy = 0;
    /// The index of the input that is refused: a cell or value (fields/dirichlet.hpp), a node or
    /// link (fields/graph.hpp), a stroke (fields/strokes.hpp).
    std::size_t culprit = none;
    /// For cells_unreached: the number of cells in all components without a given value.
    std::size_t unreached_cells = 0;

    /// Returns a quantile of tree.grid_errors: the fraction `quantile` of the estimates, in [0, 1], does not
    /// exceed the result. In measurements, grid_error(1) was half to four times the largest error anywhere.
    double grid_error(double quantile = 1) const {
        if (tree.grid_errors.empty()) return 0;
        auto sorted = tree.grid_errors;
        std::sort(sorted.begin(), sorted.end());
        return double(sorted[std::size_t(quantile * double(sorted.size() - 1))]);
    }

    /// Returns the corner with the largest estimate, or one with error 0 if there is none. The resolution of
    /// the result suffices for all corners; 0: no error is notable, or no grid is fine enough.
    CornerError worst_corner() const noexcept {
        CornerError worst;
        std::size_t resolution = 0;
        bool reachable = true;
        for (const CornerError& corner : multigrid.corners) {
            if (corner.error > CornerError::notable) {
                resolution = (std::max)(resolution, corner.resolution);
                reachable = reachable && corner.resolution != 0;
            }
            if (corner.error > worst.error) worst = corner;
        }
        worst.resolution = reachable ? resolution : 0;
        return worst;
    }

    /// Merges the report of other functions. Counts and times are added; other fields keep the
    /// worst. The group of refused problems stays unchanged.
    void add(const SolverReport& other) {
        cells += other.cells;
        solves += other.solves;
        unconverged += other.unconverged;
        bytes = (std::max)(bytes, other.bytes);
        seconds += other.seconds;
        multigrid.cycles = (std::max)(multigrid.cycles, other.multigrid.cycles);
        multigrid.convergence_factor =
            (std::max)(multigrid.convergence_factor, other.multigrid.convergence_factor);
        multigrid.error_estimate = (std::max)(multigrid.error_estimate, other.multigrid.error_estimate);
        multigrid.error_bound = (std::max)(multigrid.error_bound, other.multigrid.error_bound);
        add_corners(other.multigrid.corners);
        add_grid_errors(other.tree.grid_errors);
        if (other.tree.finest_size > 0 &&
            !(tree.finest_size > 0 && tree.finest_size <= other.tree.finest_size)) {
            tree.finest_size = other.tree.finest_size;
            tree.finest_position = other.tree.finest_position;
            tree.finest_reason = other.tree.finest_reason;
        }
        relaxation.sweeps += other.relaxation.sweeps;
        relaxation.largest_mean_change =
            (std::max)(relaxation.largest_mean_change, other.relaxation.largest_mean_change);
        unresolved_cells += other.unresolved_cells;
    }

private:
    /// Merges the estimates of other functions. For the same grid, keeps the larger estimate at each point;
    /// for another grid, appends the estimates.
    void add_grid_errors(const std::vector<float>& more) {
        if (tree.grid_errors.size() != more.size()) {
            tree.grid_errors.insert(tree.grid_errors.end(), more.begin(), more.end());
            return;
        }
        for (std::size_t n = 0; n < more.size(); ++n)
            tree.grid_errors[n] = (std::max)(tree.grid_errors[n], more[n]);
    }
    /// Merges the corners of other functions. For the same cage, keeps the larger error at each corner; for
    /// another cage, appends the corners.
    void add_corners(const std::vector<CornerError>& more) {
        const auto same = [](const CornerError& a, const CornerError& b) { return a.handles == b.handles; };
        if (!std::equal(multigrid.corners.begin(), multigrid.corners.end(), more.begin(), more.end(), same)) {
            multigrid.corners.insert(multigrid.corners.end(), more.begin(), more.end());
            return;
        }
        for (std::size_t n = 0; n < more.size(); ++n) {
            if (more[n].error > multigrid.corners[n].error) multigrid.corners[n] = more[n];
        }
    }
};

/// The outcome of evaluating a coordinate type for a batch of points.
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

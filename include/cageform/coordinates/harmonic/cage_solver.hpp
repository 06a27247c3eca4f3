// The interface between solved coordinates and their solvers.
//
// HarmonicCoordinates own the cage and the options and know no particular solver. A solver knows its
// problem, but neither the driver nor threads. To add a solver, write a model of CageSolver and use
//     HarmonicCoordinates<T, D, Cage, OnlySolver<YourSolver>>
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/boundary_data.hpp>
#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/grid/solve_groups.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI {

/// The input of a solver: a cage that `check` accepts, with its options and its boundary data.
template <class C, class SolverOptions>
struct CageProblem {
    using Cage = C;
    using Options = SolverOptions;
    using scalar = typename Cage::scalar;
    static constexpr std::size_t dimension = Cage::dimension;

    CageProblem(Cage its_cage, const Options& its_options)
        : cage(std::move(its_cage))
        , report(check(cage))
        , options(its_options)
        , tolerance(report.status == Status::ok ? coincidence_tolerance(bounds_of(cage.vertices()))
                                                : scalar(0)) {
        if (report.status == Status::ok) data = detail::BoundaryData<Cage>(cage, options);
    }

    /// An empty problem, refused with a status.
    explicit CageProblem(Status refused)
        : report{refused, {}} {}

    Cage cage;
    CageReport report; ///< status and warnings; solvers only get problems whose status is ok
    Options options;
    scalar tolerance = 0;              ///< coincidence_tolerance of the cage
    detail::BoundaryData<Cage> data{}; ///< set if the cage is sound
};

/// The memory that a solver will need, in bytes.
struct SolverMemory {
    std::size_t hierarchy = 0; ///< once, for all functions
    std::size_t block = 0;     ///< for one group of functions, on each thread
};

/// Solves for the functions of a cage's handles. It is a GroupSolver, and every handle is in one group.
///
///   Problem                    the CageProblem it solves
///   make(problem, report, made)
///                              makes all that does not depend on boundary data (grid, hierarchy)
///                              and writes the number of cells to `report`, or returns another status
///                              than ok. The problem outlives the solver
///   memory()                   the size of that, and of a block
///   Functions, keep(block)     the functions of a solved group
///   Samples, samples(batch, first, last)
///                              stencils from which the value of any function at points first …
///                              last − 1 is computed; also sets where the points lie (batch.states).
///                              Points beyond batch.points.points have the value 0
///   sample(samples, group, functions, rows)
///                              fills the rows of weights of a group at those points; `functions` is a
///                              block or kept Functions. Different groups are sampled concurrently
///   finish(samples, rows)      called once all groups are sampled
template <class S>
concept CageSolver = grid::GroupSolver<S> &&
    requires(const S& solver, const typename S::Problem& problem, std::optional<S>& made,
             SolverReport& report, const typename S::Block& block, const typename S::Functions& functions,
             typename S::Samples& samples, const detail::Batch<typename S::Problem::scalar>& batch,
             std::size_t n) {
    { S::make(problem, report, made) } -> std::same_as<Status>;
    { solver.memory() } -> std::same_as<SolverMemory>;
    { solver.keep(block) } -> std::same_as<typename S::Functions>;
    { solver.samples(batch, n, n) } -> std::same_as<typename S::Samples>;
    solver.sample(samples, n, block, batch.rows);
    solver.sample(samples, n, functions, batch.rows);
    solver.finish(samples, batch.rows);
};

/// A solver whose functions can be differentiated, by differences of samples up to a cell apart.
///
///   spacing(p)                 the grid spacing at a point, in units of the cage
///   state_of(p)                where a point lies, as `samples` finds it
///   free_distance(p, axis, up, limit)
///                              the distance from a point inside to the boundary, along an axis, up or
///                              down, in such spacings; at most `limit`
template <class S>
concept DifferentiableSolver = CageSolver<S> &&
    requires(const S& solver, const Vec<typename S::Problem::scalar, S::Problem::dimension>& p,
             std::size_t axis, bool up, double limit) {
    { solver.spacing(p) } -> std::same_as<double>;
    { solver.state_of(p) } -> std::same_as<PointState>;
    { solver.free_distance(p, axis, up, limit) } -> std::same_as<double>;
};

/// A cell of a solver's grid, a square or a cube, in the units of the cage.
template <Scalar T, std::size_t D>
struct GridCell {
    Vec<T, D> low; ///< its lower corner
    T size;        ///< along each axis
    bool is_cut;   ///< the cage crosses it or comes very near; else the whole cell lies inside
};

namespace detail {

/// Returns the memory limit of a solver's options, or the largest number if they have none.
template <class Options>
std::size_t memory_limit([[maybe_unused]] const Options& options) noexcept {
    if constexpr (requires { options.memory_limit; }) {
        return options.memory_limit;
    } else {
        return (std::numeric_limits<std::size_t>::max)();
    }
}

} // namespace detail

/// A solver that can start from the functions of another cage of a similar shape.
///
///   Guess                      constructed from (solver, the solver before, the functions that it has
///                              kept, and for each handle its old number or none: ~0)
///   takes_guess()              whether it can use a guess for this problem
///   solve(group, block, work, &guess)
///                              `solve` of a group starting from the guess, to the same tolerance
template <class S>
concept WarmSolver = CageSolver<S> &&
    std::constructible_from<typename S::Guess, const S&, const S&, std::span<const typename S::Functions>,
                            std::span<const std::size_t>> &&
    requires(const S& solver, typename S::Block& block, std::size_t group, grid::GroupWork& work,
             const typename S::Guess* guess) {
    { solver.takes_guess() } -> std::same_as<bool>;
    { solver.solve(group, block, work, guess) } -> std::same_as<Status>;
};

/// A choice with one solver only.
template <CageSolver S>
struct OnlySolver {
    using Options = typename S::Problem::Options;

    template <class Use>
    static Status choose(const Options& /*options*/, const Use& use) {
        return use(std::type_identity<S>{});
    }
};

} // namespace cageform::inline CAGEFORM_ABI

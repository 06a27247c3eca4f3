// The interface between the functions of a cage and a solver.
//
// A solver knows its input, but neither the driver nor threads nor coordinates. To add one, write a model of
// CageSolver, include solution.hpp, and use
//     HarmonicCoordinates(cage, options, make_functions<YourSolver<D>, T, D>)
#pragma once

#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/harmonic/cage_functions.hpp>
#include <cageform/grid/solve_groups.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI {

/// Solves for the functions of a cage's handles. It is a GroupSolver, and every handle is in one group.
///
///   dimension                  D, of its SolverInput<D>
///   make(input, report, made, running)
///                              makes all that does not depend on boundary data (grid, hierarchy)
///                              and writes the number of cells to `report`, or returns another status
///                              than ok. The input outlives the solver. It may use running.parallel;
///                              progress is reported by `solve` alone
///   memory()                   the size of that, and of a block
///   Functions, keep(block)     the functions of a solved group
///   Samples, samples(batch, points)
///                              stencils from which the value of any function is computed at the points
///                              with these numbers; also sets where the points lie (batch.states).
///                              Points beyond batch.points.points have the value 0
///   order(batch)               optional: the numbers of all points of all blocks, in the order in which
///                              the points are sampled; else ascending
///   sample(samples, group, functions, rows)
///                              fills the rows of weights of a group at those points; `functions` is a
///                              block or kept Functions. Different groups are sampled concurrently
///   finish(samples, rows)      called once all groups are sampled
///
/// Batches and rows have the scalar T of the coordinates.
template <class S, class T = double>
concept CageSolver = grid::GroupSolver<S> &&
    requires(const S& solver, const SolverInput<S::dimension>& input, std::optional<S>& made,
             SolverReport& report, const typename S::Block& block, const typename S::Functions& functions,
             typename S::Samples& samples, const Batch<T>& batch, const Running& running,
             std::span<const std::size_t> points, std::size_t n) {
    { S::make(input, report, made, running) } -> std::same_as<Status>;
    { solver.memory() } -> std::same_as<SolverMemory>;
    { solver.keep(block) } -> std::same_as<typename S::Functions>;
    { solver.samples(batch, points) } -> std::same_as<typename S::Samples>;
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
template <class S, class T = double>
concept DifferentiableSolver = CageSolver<S, T> &&
    requires(const S& solver, const Vec<double, S::dimension>& p, std::size_t axis, bool up, double limit) {
    { solver.spacing(p) } -> std::same_as<double>;
    { solver.state_of(p) } -> std::same_as<PointState>;
    { solver.free_distance(p, axis, up, limit) } -> std::same_as<double>;
};

/// A solver that can make stencils of derivatives.
///
///   has_gradient_samples()     whether the solver makes such stencils for this cage
///   gradient_samples(batch, points)
///                              as `samples`, for derivatives per unit of length. `sample` and `finish`
///                              write row axis · #handles + handle. Values of points outside do not change
template <class S, class T = double>
concept BlendedSolver = DifferentiableSolver<S, T> &&
    requires(const S& solver, const Batch<T>& batch, typename S::GradientSamples& samples,
             const typename S::Functions& functions, std::span<const std::size_t> points, std::size_t n) {
    { solver.has_gradient_samples() } -> std::same_as<bool>;
    { solver.gradient_samples(batch, points) } -> std::same_as<typename S::GradientSamples>;
    solver.sample(samples, n, functions, batch.rows);
    solver.finish(samples, batch.rows);
};

} // namespace cageform::inline CAGEFORM_ABI

// The interface between the functions of a cage and a solver.
//
// A solver depends on its input, but not on the driver, threads or coordinates. To add one, write a model of
// CageSolver, include solution.hpp, and use
//     HarmonicCoordinates(cage, options, make_functions<YourSolver<D>, T, D>)
#pragma once

#include <cageform/coordinates/detail/evaluate_blocks.hpp>
#include <cageform/coordinates/harmonic/cage_functions.hpp>
#include <cageform/grid/solve_groups.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI {

/// A solver for the functions of a cage's handles: a GroupSolver whose groups partition the handles.
///
///   dimension                  D, of its SolverInput<D>
///   make(input, report, made, running)
///                              makes all that does not depend on boundary values (grid, hierarchy) and
///                              writes the number of cells to `report`, or returns a status other than ok.
///                              The input outlives the solver. May use running.parallel; must not report
///                              progress
///   memory()                   the memory of the result, and of a block
///   Functions, keep(block)     the functions of a solved group
///   Samples, samples(batch, points)
///                              stencils that evaluate functions at the points with these indices. Also sets
///                              batch.states. Functions are 0 at indices from batch.points.points on
///   order(batch)               optional: the indices of all points of all blocks in sampling order; default
///                              ascending
///   sample(samples, group, functions, rows)
///                              fills the rows of weights of a group at those points; `functions` is a block
///                              or kept Functions. Different groups are sampled concurrently
///   finish(samples, rows)      called after all groups are sampled
///
/// Batches and rows have the scalar T of the coordinates.
template <class S, class T = double>
concept CageSolver =
    grid::GroupSolver<S> &&
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

/// A solver whose functions are differentiated by differences of samples up to a cell apart.
///
///   spacing(p)                 the grid spacing at a point, in units of the cage
///   state_of(p)                the state of a point, as found by `samples`
///   free_distance(p, axis, up, limit)
///                              the distance from an inside point to the boundary along an axis, up or down,
///                              in grid spacings; at most `limit`
template <class S, class T = double>
concept DifferentiableSolver =
    CageSolver<S, T> &&
    requires(const S& solver, const Vec<double, S::dimension>& p, std::size_t axis, bool up, double limit) {
        { solver.spacing(p) } -> std::same_as<double>;
        { solver.state_of(p) } -> std::same_as<PointState>;
        { solver.free_distance(p, axis, up, limit) } -> std::same_as<double>;
    };

/// A solver with stencils of derivatives.
///
///   has_gradient_samples()     whether there are such stencils for this cage
///   gradient_samples(batch, points)
///                              as `samples`, for derivatives per unit of length. `sample` and `finish` write
///                              row axis · #handles + handle. Rows are unchanged at outside points
template <class S, class T = double>
concept BlendedSolver =
    DifferentiableSolver<S, T> &&
    requires(const S& solver, const Batch<T>& batch, typename S::GradientSamples& samples,
             const typename S::Functions& functions, std::span<const std::size_t> points, std::size_t n) {
        { solver.has_gradient_samples() } -> std::same_as<bool>;
        { solver.gradient_samples(batch, points) } -> std::same_as<typename S::GradientSamples>;
        solver.sample(samples, n, functions, batch.rows);
        solver.finish(samples, batch.rows);
    };

} // namespace cageform::inline CAGEFORM_ABI

// The one concept that every coordinate type models, and what an evaluation is told and tells.
#pragma once

#include <cageform/cage/check.hpp>
#include <cageform/core/blocks.hpp>
#include <cageform/core/parallel.hpp>

#include <functional>
#include <new>
#include <stdexcept>

namespace cageform::inline CAGEFORM_ABI {

/// body(begin, end); see core/parallel.hpp.
using RangeBody = std::function<void(std::size_t, std::size_t)>;
/// parallel_for(count, grain, body); see core/parallel.hpp.
using ParallelFor = std::function<void(std::size_t, std::size_t, const RangeBody&)>;
/// Called on the calling thread with the fraction done, in [0, 1] and never falling; false cancels.
using Progress = std::function<bool(double)>;

struct EvaluateOptions {
    ParallelFor parallel = SerialFor{};
    Progress progress{};
};

/// What a solver did. All zero for closed forms.
struct SolverReport {
    static constexpr std::size_t none = ~std::size_t{0};

    std::size_t cells = 0;  ///< unknowns of one function
    std::size_t cycles = 0; ///< of the multigrid, the most that a function took
    double convergence_factor =
        0; ///< error after a multigrid cycle over that before, the worst met above the tolerance
    double error_estimate = 0; ///< of the discrete solution: what the multigrid stops on (grid/multigrid.hpp)
    double error_bound = 0;    ///< the same by the maximum principle alone, far above it
    std::size_t unsettled = 0; ///< functions whose corners could not be fitted, so that no corner was treated
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
};

/// Outcome of evaluating a coordinate type for a batch of points.
struct Evaluation {
    Status status = Status::ok;
    SolverReport solver;
};

/// The constants of a coordinate type: its scalar, its dimension, whether it is defined outside the cage, and
/// whether a point's weights cost the same alone as in a batch.
template <class C>
concept CageCoordinateConstants = requires {
    typename C::scalar;
    requires Scalar<typename C::scalar>;
    { C::dimension } -> std::convertible_to<std::size_t>;
    { C::has_extension } -> std::convertible_to<bool>;
    { C::closed_form } -> std::convertible_to<bool>;
};

/// Coordinates of points with respect to a cage, one weight per *handle*. For the types here a handle is
/// a cage vertex; a type may have others (scaled face normals, say), so nobody assumes weights = vertices.
///
///   handles()           the handles at rest; a pose holds as many points, in the same order
///   cage_report()       faults of the cage; unless its status is ok, `evaluate` returns that status
///   has_extension       whether weights are defined outside the cage
///   closed_form         whether `bind` may evaluate a few points at a time, which keeps them in cache
///   evaluate(points, weights, states, options)
///                       fills the weights of a whole batch (rows of `weights` are handles) and where each
///                       point lies. Points whose state is not_finite on entry are skipped. Weights of
///                       points that are not_finite or unreached, and of outside points when there is no
///                       extension, are left unspecified. Every lane of the last block is written.
///   nearest_boundary(p, row)
///                       weights (#handles) of the boundary point nearest to the finite point `p`, and it
template <class C>
concept CageCoordinates = CageCoordinateConstants<C> &&
    requires(const C& c, BlockView<const typename C::scalar> points, BlockView<typename C::scalar> weights,
             std::span<PointState> states, const EvaluateOptions& options,
             const Vec<typename C::scalar, C::dimension>& p, std::span<typename C::scalar> row) {
    { c.handles() } -> std::same_as<std::span<const Vec<typename C::scalar, C::dimension>>>;
    { c.cage_report() } -> std::same_as<const CageReport&>;
    { c.evaluate(points, weights, states, options) } -> std::same_as<Evaluation>;
    { c.nearest_boundary(p, row) } -> std::same_as<Vec<typename C::scalar, C::dimension>>;
};

/// What `nearest_boundary` is for every type whose handles are a cage's vertices and whose weights on the boundary are
/// its hat functions: `row` (#V) gets the weights of the nearest boundary point, which is returned.
template <class Cage>
Vec<typename Cage::scalar, Cage::dimension>
nearest_boundary_weights(const Cage& cage, const Vec<typename Cage::scalar, Cage::dimension>& p,
                         std::span<typename Cage::scalar> row) noexcept {
    using T = typename Cage::scalar;
    Vec<T, Cage::dimension> place;
    const auto value = nearest_boundary_value(cage, p, place);
    std::fill(row.begin(), row.end(), T(0));
    for (std::size_t n = 0; n < value.handle.size(); ++n)
        row[value.handle[n]] += static_cast<T>(value.weight[n]);
    return place;
}

/// Weights of a single point, a convenience on top of `evaluate`.
///
///   weights  out, #handles
///   returns  where the point lies; `weights` is set for inside and on_boundary, and for outside when
///            the type has an extension, else untouched
template <CageCoordinates C, Point P>
PointState weights_at(const C& coordinates, const P& point, std::span<typename C::scalar> weights) {
    using T = typename C::scalar;
    const std::size_t handles = coordinates.handles().size();
    CAGEFORM_ASSERT(weights.size() == handles, "one weight per handle");
    const auto p = to_vec<T>(point);
    if (!is_finite(p)) return PointState::not_finite;
    std::vector<Lanes<T>> position(C::dimension), block(handles);
    for (std::size_t k = 0; k < C::dimension; ++k) {
        for (T& x : position[k].v) x = p[k];
    }
    PointState state = PointState::unreached;
    const auto evaluation = coordinates.evaluate(BlockView<const T>{position.data(), C::dimension, 1},
                                                 BlockView<T>{block.data(), handles, 1}, {&state, 1}, {});
    if (evaluation.status != Status::ok) return PointState::unreached;
    if (state == PointState::unreached || (state == PointState::outside && !C::has_extension)) return state;
    for (std::size_t i = 0; i < handles; ++i) weights[i] = block[i][0];
    return state;
}

namespace detail {

/// The caller's parallel_for; one left empty is the serial one.
template <class Body>
void in_parallel(const EvaluateOptions& options, std::size_t count, std::size_t grain, const Body& body) {
    if (options.parallel) {
        options.parallel(count, grain, body);
    } else {
        SerialFor{}(count, grain, body);
    }
}

/// Runs body(first, last) over `blocks` (or pieces) in parallel, in at most fifty steps between which the
/// caller's progress is told. Returns Status::cancelled when it says so.
template <class Body>
Status for_each_block(std::size_t blocks, const EvaluateOptions& options, const Body& body) {
    constexpr std::size_t grain = 16;
    const std::size_t step = options.progress ? std::max<std::size_t>(blocks / 50, 16 * grain) : blocks;
    for (std::size_t begin = 0; begin < blocks; begin += step) {
        const std::size_t count = std::min(step, blocks - begin);
        in_parallel(options, count, grain, [&](std::size_t b, std::size_t e) { body(begin + b, begin + e); });
        if (options.progress && !options.progress(double(begin + count) / double(blocks)))
            return Status::cancelled;
    }
    return Status::ok;
}

/// Runs `f`; an allocation that fails becomes Status::out_of_memory (without exceptions it ends the program,
/// as the standard library has it).
template <class F>
Status guard_memory(F&& f) {
#if defined(__cpp_exceptions)
    try {
        return f();
    } catch (const std::bad_alloc&) {
        return Status::out_of_memory;
    } catch (const std::length_error&) {
        return Status::out_of_memory;
    }
#else
    return f();
#endif
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI

// Harmonic coordinates: non-negative, without interior extrema, from a Laplace solve on a grid.
//
// The solvers are this library's multigrids, on an adaptive grid or on a uniform one. The solver of
// the papers, the baseline that they are compared with, is in papers/pyramid_solver.hpp.
#pragma once

#include <cageform/coordinates/harmonic/difference_gradients.hpp>
#include <cageform/coordinates/harmonic/multigrid_solver.hpp>
#include <cageform/coordinates/harmonic/polyhedral_data.hpp>
#include <cageform/coordinates/harmonic/tree_solver.hpp>

#include <numeric>

namespace cageform::inline CAGEFORM_ABI {

/// Chooses the solver for a kind of cage: the adaptive grid, or the uniform grid if
/// HarmonicOptions::resolution is set. To use HarmonicSolver::averaging_pyramid as well, replace
/// this type by WithAveragingPyramid (papers/pyramid_solver.hpp).
template <class C>
struct HarmonicSolverChoice {
    using Options = HarmonicOptions;

    /// Calls use(std::type_identity<Solver>{}), or returns solver_not_supported.
    template <class Use>
    static Status choose(const Options& options, const Use& use) {
        if (options.solver != HarmonicSolver::multigrid) return Status::solver_not_supported;
        if (options.resolution != 0) return use(std::type_identity<MultigridSolver<C>>{});
        return use(std::type_identity<TreeSolver<C>>{});
    }
};

/// Harmonic coordinates: h_i solves ∇²h_i = 0 inside the cage and equals the hat function of vertex
/// i on its boundary. In 2D the cage is a Polygon, in 3D a TriangleMesh, a Box or a PolyhedralMesh,
/// in both a CellComplex. For the faces of a PolyhedralMesh, harmonic coordinates are first solved
/// in each face's plane.
///
/// Joshi, Meyer, DeRose, Green, Sanocki, Harmonic Coordinates for Character Articulation (SIGGRAPH
/// 2007), sec. 3 and 4. For points on vertices, edges and faces the boundary data itself is
/// returned, so weights are exact there.
///
/// The functions do not depend on `T` except for its rounding.
///
///   range     [0, 1], sum 1, Σ h_i C_i = p: all to the tolerance, on every grid
///   accuracy  see HarmonicOptions::accuracy. If a resolution is given: of order h² away from the boundary
///             and around corners with one cell of room (two if that holds too few nodes for a fit;
///             grid/corners/corner_functions.hpp); of order h^(π/ω) next to an untreated corner of
///             interior angle ω, or such an edge in 3D
///   cost      `evaluate` solves #V functions, sixteen at a time (unless `solve` has done so
///             before), and samples them. Running::parallel distributes the groups of sixteen; each
///             thread needs `solver_memory().block` bytes, every point about 80 bytes in 2D and 150 in
///             3D, and #V scalars next to treated corners. Progress is reported before every cycle on
///             the calling thread, which has to take part in the work
///   fails     as check(cage); accuracy_not_supported; resolution_not_supported;
///             tolerance_not_positive; grid_too_coarse; not_converged; cancelled; out_of_memory;
///             solver_not_supported
///
/// Outside the cage they are not defined (no extension); every point inside has values.
template <Scalar T, std::size_t D, class C = std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>,
          class Solvers = HarmonicSolverChoice<C>>
    requires(D == 2 || D == 3)
class HarmonicCoordinates {
public:
    using scalar = T;
    using Cage = C;
    using Options = typename Solvers::Options;
    static constexpr std::size_t dimension = D;
    static constexpr bool has_extension = false;
    static constexpr bool closed_form = false;

    explicit HarmonicCoordinates(Cage cage, const Options& options = {})
        : problem_(make_problem(std::move(cage), options)) {}

    /// Makes a polygon of one loop.
    template <PointRange R>
        requires(D == 2 && range_dimension<R> == 2)
    explicit HarmonicCoordinates(const R& vertices, const Options& options = {})
        : HarmonicCoordinates(Cage(vertices), options) {}
    template <UnknownPointRange R>
    explicit HarmonicCoordinates(const R&, const Options& = {},
                                 detail::PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    /// Makes the mesh from the arguments of a TriangleMesh.
    template <PointRange R, FaceRange F>
        requires(D == 3 && range_dimension<R> == 3 && std::is_same_v<C, TriangleMesh<T>>)
    HarmonicCoordinates(const R& vertices, const F& faces, const Options& options = {})
        : HarmonicCoordinates(Cage(vertices, faces), options) {}
    template <UnknownPointRange R, FaceRange F>
    HarmonicCoordinates(const R&, const F&, const Options& = {},
                        detail::PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    // A copy shares the cage and the solved functions. Moving copies, so no object is ever empty.
    HarmonicCoordinates(const HarmonicCoordinates&) noexcept = default;
    HarmonicCoordinates& operator=(const HarmonicCoordinates&) noexcept = default;

    const Cage& cage() const noexcept { return problem_->cage; }
    const Options& options() const noexcept { return problem_->options; }
    std::span<const Vec<T, D>> handles() const noexcept { return cage().vertices(); }
    const CageReport& cage_report() const noexcept { return problem_->report; }

    /// Solves all functions and keeps them, so that several batches of points can be evaluated. The
    /// reports of those evaluations repeat the report of this solve.
    Evaluation solve(const Running& running = {}) {
        return with_solution([&](const auto& solution, SolverReport& report) {
            if (solution == kept_) return Status::ok;
            const Status status = solution->solve(report, running);
            if (status == Status::ok) kept_ = solution;
            return status;
        });
    }

    /// Solves after an edit of the cage, starting from the functions that `before` has kept. The
    /// tolerance is the same as for `solve`; the less the cage has changed, the fewer cycles are
    /// needed. It is the same as `solve` in these cases: `before` has kept no functions, or used
    /// another solver; the grid is adaptive (half of the time goes into the grid, and functions are
    /// solved only where they are large); the grid is uniform and in 2D with treated corners
    /// (MultigridOptions::corner_functions), where solves are quick.
    ///
    ///   before       coordinates of the cage before the edit; resolution and tolerance may differ
    ///   old_handles  #handles: the number that each handle had before, or ~0 if it is new. Empty: the
    ///                numbers are the same, which requires as many handles as before
    ///   memory       beside that of `solve`, about 100 bytes a cell inside the cage
    Evaluation solve_from(const HarmonicCoordinates& before, std::span<const std::size_t> old_handles = {},
                          const Running& running = {}) {
        return with_solution([&](const auto& solution, SolverReport& report) {
            const std::size_t count = cage().size(), old_count = before.cage().size();
            using S = typename std::remove_cvref_t<decltype(*solution)>::Solver;
            if (solution == kept_) return Status::ok;
            const auto old = before.template kept_by<S>();
            std::vector<std::size_t> same(old_handles.begin(), old_handles.end());
            if (same.empty() && count == old_count) {
                same.resize(count);
                std::iota(same.begin(), same.end(), std::size_t{0});
            }
            bool fits = same.size() == count;
            for (const std::size_t handle : same)
                fits = fits && (handle < old_count || handle == ~std::size_t{0});
            CAGEFORM_ASSERT(fits, "the old number of every handle, or none");
            const Status status = old != nullptr && fits ? solution->solve_from(*old, same, report, running)
                                                         : solution->solve(report, running);
            if (status == Status::ok) kept_ = solution;
            return status;
        });
    }

    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const Running& running = {}) const {
        CAGEFORM_ASSERT(weights.rows == cage().size() && states.size() == points.points,
                        "one row per handle");
        return with_solution([&](const auto& solution, SolverReport& report) {
            return detail::sample_solution(*solution, {points, weights, states}, report, running);
        });
    }

    /// Computes the gradients of all functions at a batch of points, by the multigrid solvers
    /// (solver_not_supported with the averaging pyramid).
    ///
    ///   points     as for `evaluate`; so are the states on entry and on return
    ///   gradients  out, row axis · #handles + handle: the derivative along the axis, per unit of
    ///              length. Those of points outside stay as they are
    ///   accuracy   exact for linear functions: Σ ∇h_i = 0 and Σ C_i ∇h_i = identity to the
    ///              tolerance over h. The error is of order h², within a cell of the boundary of order h.
    ///              For a point on the boundary: the gradient at a point half a cell inside (unreached if
    ///              there is none)
    ///   cost       of evaluating 2D + 1 points for each; unless `solve` has been called, with the
    ///              memory of their weights
    Evaluation evaluate_gradients(BlockView<const T> points, BlockView<T> gradients,
                                  std::span<PointState> states, const Running& running = {}) const {
        CAGEFORM_ASSERT(gradients.rows == D * cage().size() && states.size() == points.points,
                        "a row per axis and handle");
        return with_solution(
            [&]<class S>(const std::shared_ptr<detail::Solution<S>>& solution, SolverReport& report) {
                if constexpr (DifferentiableSolver<S>) {
                    return detail::sample_gradients(*solution, {points, gradients, states}, report, running);
                } else {
                    return Status::solver_not_supported;
                }
            });
    }

    Vec<T, D> nearest_boundary(const Vec<T, D>& p, std::span<T> row) const noexcept {
        return nearest_boundary_weights(cage(), p, row, problem_->data);
    }

    /// Returns the memory that the solver will need; all zero if the cage or the grid is refused,
    /// or if there is no room for the hierarchy itself. The call sets the solver up: this takes a
    /// tenth of the time of solving, and the hierarchy's memory. After `solve` half a block per
    /// group of sixteen is kept.
    SolverMemory solver_memory() const {
        SolverMemory memory;
        (void)with_solution([&](const auto& solution, SolverReport&) {
            memory = solution->solver->memory();
            return Status::ok;
        });
        return memory;
    }

    /// Calls f(GridCell) for every cell of an adaptive grid that is inside the cage or crossed by
    /// it, to show where a cage makes its grid fine. Neighbours are visited together (along the
    /// Morton curve). With the uniform grid it returns solver_not_supported; otherwise it fails and
    /// costs as `solve` does before its first cycle.
    template <class F>
    Evaluation for_each_cell(F&& f) const {
        return with_solution([&](const auto& solution, SolverReport&) {
            if constexpr (requires { solution->solver->for_each_cell(f); }) {
                solution->solver->for_each_cell(f);
                return Status::ok;
            } else {
                return Status::solver_not_supported;
            }
        });
    }

private:
    using Problem = CageProblem<Cage, Options>;

    static std::shared_ptr<const Problem> make_problem(Cage cage, const Options& options) {
        std::shared_ptr<const Problem> problem;
        const Status status = detail::guard_memory([&] {
            problem = std::make_shared<const Problem>(std::move(cage), options);
            return Status::ok;
        });
        if (status == Status::ok) return problem;
        static const Problem none(Status::out_of_memory);
        return {std::shared_ptr<void>(), &none};
    }

    /// Returns the kept functions if they were solved by solver S, else null.
    template <class S>
    std::shared_ptr<const detail::Solution<S>> kept_by() const {
        std::shared_ptr<const detail::Solution<S>> found;
        (void)Solvers::choose(options(), [&]<class R>(std::type_identity<R>) {
            if constexpr (std::is_same_v<R, S>) found = std::static_pointer_cast<detail::Solution<S>>(kept_);
            return Status::ok;
        });
        return found;
    }

    /// Calls use(solution, report) with the kept functions, or with a new solver that has solved
    /// none yet.
    template <class Use>
    Evaluation with_solution(const Use& use) const {
        return detail::guarded_evaluation([&](SolverReport& report) {
            if (cage_report().status != Status::ok) return cage_report().status;
            return Solvers::choose(options(), [&]<class S>(std::type_identity<S>) {
                auto solution = std::static_pointer_cast<detail::Solution<S>>(kept_);
                if (solution) {
                    report = solution->report;
                    return use(solution, report);
                }
                solution = std::make_shared<detail::Solution<S>>();
                const Status status = solution->make(problem_, report);
                return status == Status::ok ? use(solution, report) : status;
            });
        });
    }

    std::shared_ptr<const Problem> problem_;
    std::shared_ptr<void> kept_; ///< a Solution of the solver that the options name
};

/// Deduces the type from the cage: `HarmonicCoordinates coordinates(box)`.
template <Scalar T>
HarmonicCoordinates(Box<T>, const HarmonicOptions& = {}) -> HarmonicCoordinates<T, 3, Box<T>>;
template <Scalar T>
HarmonicCoordinates(TriangleMesh<T>, const HarmonicOptions& = {}) -> HarmonicCoordinates<T, 3>;
template <Scalar T>
HarmonicCoordinates(PolyhedralMesh<T>, const HarmonicOptions& = {})
    -> HarmonicCoordinates<T, 3, PolyhedralMesh<T>>;
template <Scalar T>
HarmonicCoordinates(Polygon<T>, const HarmonicOptions& = {}) -> HarmonicCoordinates<T, 2>;
template <Scalar T, std::size_t D>
HarmonicCoordinates(CellComplex<T, D>, const HarmonicOptions& = {})
    -> HarmonicCoordinates<T, D, CellComplex<T, D>>;
template <PointRangeIn<2> R>
HarmonicCoordinates(const R&, const HarmonicOptions& = {}) -> HarmonicCoordinates<range_scalar_t<R>, 2>;
template <PointRangeIn<3> R, FaceRange F>
HarmonicCoordinates(const R&, const F&, const HarmonicOptions& = {})
    -> HarmonicCoordinates<range_scalar_t<R>, 3>;

} // namespace cageform::inline CAGEFORM_ABI

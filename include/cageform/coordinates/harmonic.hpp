// Harmonic coordinates: non-negative, without interior extrema, from a Laplace solve on a grid.
//
// The grid is adaptive, unless another solver is given: uniform_harmonic.hpp has a uniform grid.
#pragma once

#include <cageform/coordinates/harmonic/cage_functions.hpp>
#include <cageform/core/result.hpp>

#include <cstddef>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Solves on an adaptive grid (harmonic/tree_solver.hpp). Refuses a `resolution` (solver_not_supported).
struct AdaptiveGrid {
    template <class T, std::size_t D>
    Status operator()(std::shared_ptr<const SolverInput<D>> input, SolverReport& report,
                      std::shared_ptr<CageFunctions<T, D>>& made, const Running& running) const;
};

/// Harmonic coordinates: h_i solves ∇²h_i = 0 inside the cage and equals the hat function of vertex
/// i on its boundary. In 2D the cage is a Polygon, in 3D a TriangleMesh or a PolyhedralMesh,
/// in both a CellComplex. On rectangles of a PolyhedralMesh the boundary data is bilinear; for its
/// other planar faces harmonic coordinates are first solved in each face's plane. On fans
/// (PolyhedralOptions) the data is linear on each triangle.
///
/// Joshi, Meyer, DeRose, Green, Sanocki, Harmonic Coordinates for Character Articulation (SIGGRAPH
/// 2007), sec. 3 and 4. For points on vertices, edges and faces the boundary data itself is
/// returned, so weights are exact there.
///
/// The functions do not depend on `T` except for its rounding.
///
///   range     [0, 1], sum 1, Σ h_i C_i = p: all to the tolerance, on every grid
///   smooth    C² inside the cage. C⁰ across walls, and where a negative weight is replaced by 0.
///             In the plane about points with a radius, weights jump by as much as they err. So do weights
///             in space if the cage has cells inside, or faces of more than three corners.
///   accuracy  see HarmonicOptions::accuracy
///   cost      `evaluate` solves #V functions, sixteen at a time (unless `solve` has done so
///             before), and samples them. Running::parallel makes the grid and solves the groups of
///             sixteen; each thread needs `solver_memory().block` bytes, every point about 480 bytes in 2D
///             and 1,500 in 3D. Progress is reported before every cycle on the calling thread, which has to
///             take part in the work
///   compiles  slowly, for it contains a solver; with cageform::compiled the solver is in a library
///   fails     as check(cage); accuracy_not_supported; resolution_not_supported, if the cage is too small
///             for its distance from the origin; grid_too_coarse; not_converged; cancelled;
///             out_of_memory; solver_not_supported, if the options have a resolution
///
/// Outside the cage they are not defined (no extension); every point inside has values.
template <Scalar T, std::size_t D, class C = std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>>
    requires(D == 2 || D == 3)
class HarmonicCoordinates {
public:
    using scalar = T;
    using Cage = C;
    using Options = HarmonicOptions;
    using Solver = HarmonicSolver<T, D>;
    static constexpr std::size_t dimension = D;
    static constexpr bool has_extension = false;
    static constexpr bool closed_form = false;

    explicit HarmonicCoordinates(Cage cage, const Options& options = {}, Solver solver = AdaptiveGrid{})
        : problem_(make_problem(std::move(cage), options, std::move(solver))) {}

    /// Makes a polygon of one loop.
    template <PointRange R>
        requires(D == 2 && range_dimension<R> == 2)
    explicit HarmonicCoordinates(const R& vertices, const Options& options = {},
                                 Solver solver = AdaptiveGrid{})
        : HarmonicCoordinates(Cage(vertices), options, std::move(solver)) {}
    template <UnknownPointRange R>
    explicit HarmonicCoordinates(const R&, const Options& = {},
                                 detail::PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    /// Makes the mesh from the arguments of a TriangleMesh.
    template <PointRange R, FaceRange F>
        requires(D == 3 && range_dimension<R> == 3 && std::is_same_v<C, TriangleMesh<T>>)
    HarmonicCoordinates(const R& vertices, const F& faces, const Options& options = {},
                        Solver solver = AdaptiveGrid{})
        : HarmonicCoordinates(Cage(vertices, faces), options, std::move(solver)) {}
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
        return with_functions(running, [&](const auto& functions, SolverReport& report, const Running& rest) {
            const Status status = functions->solve(report, rest);
            if (status == Status::ok) kept_ = functions;
            return status;
        });
    }

    /// Solves all functions, unless that has been done, and packs them into bytes for a file, so that other
    /// processes sample them without a solve (`load_solution`). Only the adaptive grid's functions are packed
    /// (else solver_not_supported). The bytes depend on cage and options alone, and take twice the memory of
    /// the kept functions meanwhile.
    Result<std::vector<std::byte>, Evaluation> save_solution(const Running& running = {}) {
        Result<std::vector<std::byte>, Evaluation> result;
        result.report = solve(running);
        if (!result) return result;
        result.report.status = detail::guard_memory([&] { return kept_->save(result.value); });
        return result;
    }

    /// Takes the functions that `save_solution` has packed, in place of a solve. Weights are those after
    /// `solve`, to the bit.
    ///
    ///   data   at least the packed functions, for instance a mapped file, aligned to 64 bytes; they are not
    ///          copied: the bytes must not change while these coordinates or copies of them are used
    ///   fails  not_a_solution, blob_version_differs, blob_kind_differs, blob_truncated, blob_corrupt,
    ///          blob_malformed, blob_of_another_cage; blob_of_another_grid: another accuracy, other boundary
    ///          data, or a grid of another machine; solver_not_supported; and as making the grid does
    ///   cost   making the grid, a tenth of a solve, and reading the bytes once
    Evaluation load_solution(std::span<const std::byte> data, const Running& running = {}) {
        kept_.reset();
        return with_functions(running, [&](const auto& functions, SolverReport& report, const Running& rest) {
            const Status status = functions->load(data, report);
            if (status == Status::ok) kept_ = functions;
            return rest.end(status);
        });
    }

    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const Running& running = {}) const {
        CAGEFORM_ASSERT(weights.rows == cage().size() && states.size() == points.points,
                        "one row per handle");
        return with_functions(running, [&](const auto& functions, SolverReport& report, const Running& rest) {
            return functions->sample({points, weights, states}, report, rest);
        });
    }

    /// Computes the gradients of all functions at a batch of points. A solver of your own may have none
    /// (solver_not_supported).
    ///
    ///   points     as for `evaluate`; so are the states on entry and on return
    ///   gradients  out, row axis · #handles + handle: the derivative along the axis, per unit of
    ///              length. Those of points outside stay as they are
    ///   accuracy   exact for linear functions: Σ ∇h_i = 0 and Σ C_i ∇h_i = identity to the
    ///              tolerance over h. Where weights are C²: the continuous derivatives of the weights
    ///              before negative ones become 0. In a cube at accuracy 1e-3, errors of 90 % of the
    ///              gradients, times the root of the mean face area, are at most 1.1e-3
    ///              (`bench_smoothness --cage cube gradients`).
    ///              Elsewhere: differences over a cell, with errors of order h², and of order h within a
    ///              cell of the boundary. A point on the boundary gets the gradient of a point inside, a
    ///              hundredth of a cell away where weights are C², else half a cell. It is unreached if
    ///              there is no such point
    ///   cost       where weights are C²: that of evaluating the points, times 1.3 (scattered points) to 6
    ///              (hundreds in a cell). Elsewhere: that of evaluating 2D + 1 points for each point.
    ///              Unless `solve` has been called, the stencils or weights of all points need memory
    Evaluation evaluate_gradients(BlockView<const T> points, BlockView<T> gradients,
                                  std::span<PointState> states, const Running& running = {}) const {
        CAGEFORM_ASSERT(gradients.rows == D * cage().size() && states.size() == points.points,
                        "a row per axis and handle");
        return with_functions(running, [&](const auto& functions, SolverReport& report, const Running& rest) {
            return functions->sample_gradients({points, gradients, states}, report, rest);
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
        (void)with_functions({}, [&](const auto& functions, SolverReport&, const Running&) {
            memory = functions->memory();
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
        return with_functions({}, [&](const auto& functions, SolverReport&, const Running&) {
            return functions->for_each_cell(std::ref(f));
        });
    }

private:
    struct Problem {
        Problem(Cage its_cage, const Options& its_options, Solver its_solver)
            : cage(std::move(its_cage))
            , report(check(cage))
            , options(its_options)
            , solver(std::move(its_solver)) {
            if (report.status == Status::ok) data_status = detail::HarmonicData<C>::make(cage, options, data);
        }
        /// An empty problem, refused with a status.
        explicit Problem(Status refused)
            : report{refused, {}} {}

        Cage cage;
        CageReport report;
        Options options;
        Solver solver;
        detail::BoundaryData<D> data{};
        Status data_status = Status::ok; ///< of `data`
    };

    static std::shared_ptr<const Problem> make_problem(Cage cage, const Options& options, Solver solver) {
        std::shared_ptr<const Problem> problem;
        const Status status = detail::guard_memory([&] {
            problem = std::make_shared<const Problem>(std::move(cage), options, std::move(solver));
            return Status::ok;
        });
        if (status == Status::ok) return problem;
        static const Problem none(Status::out_of_memory);
        return {std::shared_ptr<void>(), &none};
    }

    /// Calls use(functions, report, rest) with the kept functions, or with new ones, which are not solved
    /// yet. `rest` runs what follows the making of the grid.
    template <class Use>
    Evaluation with_functions(const Running& running, const Use& use) const {
        return detail::guarded_evaluation([&](SolverReport& report) {
            const auto& [cage, cage_report, options, solver, data, data_status] = *problem_;
            if (cage_report.status != Status::ok) return cage_report.status;
            if (data_status != Status::ok) return data_status;
            std::shared_ptr<CageFunctions<T, D>> functions = kept_;
            constexpr double of_grid = 0.25; // the share of the progress
            if (functions) {
                report = functions->report();
            } else {
                auto input = std::make_shared<const SolverInput<D>>(cage, cage_report, options, data);
                Status status = input->status();
                if (status == Status::ok)
                    status = solver(std::move(input), report, functions, running.subtask(0, of_grid));
                if (status != Status::ok) return status;
            }
            return use(functions, report, running.subtask(kept_ ? 0 : of_grid, 1));
        });
    }

    std::shared_ptr<const Problem> problem_;
    std::shared_ptr<CageFunctions<T, D>> kept_; ///< solved functions
};

/// Deduces the type from the cage: `HarmonicCoordinates coordinates(cage)`.
template <Scalar T, class S = AdaptiveGrid>
HarmonicCoordinates(TriangleMesh<T>, const HarmonicOptions& = {}, const S& = {}) -> HarmonicCoordinates<T, 3>;
template <Scalar T, class S = AdaptiveGrid>
HarmonicCoordinates(PolyhedralMesh<T>, const HarmonicOptions& = {}, const S& = {})
    -> HarmonicCoordinates<T, 3, PolyhedralMesh<T>>;
template <Scalar T, class S = AdaptiveGrid>
HarmonicCoordinates(Polygon<T>, const HarmonicOptions& = {}, const S& = {}) -> HarmonicCoordinates<T, 2>;
template <Scalar T, std::size_t D, class S = AdaptiveGrid>
HarmonicCoordinates(CellComplex<T, D>, const HarmonicOptions& = {}, const S& = {})
    -> HarmonicCoordinates<T, D, CellComplex<T, D>>;
template <PointRangeIn<2> R, class S = AdaptiveGrid>
HarmonicCoordinates(const R&, const HarmonicOptions& = {}, const S& = {})
    -> HarmonicCoordinates<range_scalar_t<R>, 2>;
template <PointRangeIn<3> R, FaceRange F, class S = AdaptiveGrid>
HarmonicCoordinates(const R&, const F&, const HarmonicOptions& = {}, const S& = {})
    -> HarmonicCoordinates<range_scalar_t<R>, 3>;

} // namespace cageform::inline CAGEFORM_ABI

#include <cageform/coordinates/harmonic/polyhedral_data.hpp>
#if !defined(CAGEFORM_COMPILED)
#include <cageform/coordinates/harmonic/adaptive.impl.hpp>
#endif

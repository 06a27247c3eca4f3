// Harmonic coordinates: non-negative and without interior extrema, from a Laplace solve on an adaptive grid.
// uniform_harmonic.hpp adds a uniform grid.
#pragma once

#include <cageform/coordinates/harmonic/cage_functions.hpp>
#include <cageform/core/result.hpp>

#include <cstddef>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI {

/// Solves on an adaptive grid (harmonic/tree_solver.hpp). HarmonicOptions::resolution must not be set.
struct AdaptiveGrid {
    template <class T, std::size_t D>
    Status operator()(std::shared_ptr<const SolverInput<D>> input, SolverReport& report,
                      std::shared_ptr<CageFunctions<T, D>>& made, const Running& running) const;
};

/// Harmonic coordinates: h_i solves ∇²h_i = 0 inside the cage and equals the hat function of vertex i on the
/// boundary. The cage is a Polygon in 2D, a TriangleMesh or PolyhedralMesh in 3D, or a CellComplex. On
/// rectangles of a PolyhedralMesh the boundary values are bilinear; on other planar faces they are harmonic
/// coordinates of the face; on fans (PolyhedralOptions) they are linear on each triangle.
///
/// With HarmonicOptions::locality they are *local harmonic coordinates*. Their functions solve ∇²s_i = κ²s_i
/// with the same boundary values, and decrease like e^(−κd) with the distance d by paths inside the cage. The
/// weights are the row nearest to the s_i with sum 1 and Σ w_i C_i = p (coordinates/project.hpp). Points have
/// fewer influences, at the cost of a harmonic solve.
///
/// Joshi, Meyer, DeRose, Green, Sanocki, Harmonic Coordinates for Character Articulation (SIGGRAPH 2007),
/// sec. 3 and 4. Weights of points on vertices, edges and faces are the exact boundary values. The functions
/// depend on `T` only by rounding.
///
///   range     [0, 1], sum 1, Σ h_i C_i = p: all to the tolerance, on every grid; inside, with a
///             locality, to rounding
///   outside   undefined
///   smooth    C² inside the cage; C⁰ across walls and where a negative weight is replaced by 0. Weights jump
///             by about their error around 2D points with a radius, and in 3D if the cage has interior cells
///             or faces of more than three corners
///   accuracy  see HarmonicOptions::accuracy
///   cost      `evaluate` solves #V functions, sixteen at a time, unless `solve` was called before. Then it
///             samples them. Running::parallel makes the grid and solves the groups of sixteen. Memory:
///             `solver_memory().block` bytes per thread, about 480 bytes per point in 2D and 1,500 in 3D.
///             The calling thread must take part in the work, and reports progress before each of its cycles
///   compiles  slowly, because the solver is a template; cageform::compiled has it in a library
///   fails     as check(cage); accuracy_not_supported; locality_not_supported; resolution_not_supported if
///             the cage is too small for its distance from the origin; grid_too_coarse; not_converged;
///             cancelled; out_of_memory;
///             solver_not_supported if the options have a resolution
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

    /// Constructs a polygon of one loop.
    template <PointRange R>
        requires(D == 2 && range_dimension<R> == 2)
    explicit HarmonicCoordinates(const R& vertices, const Options& options = {},
                                 Solver solver = AdaptiveGrid{})
        : HarmonicCoordinates(Cage(vertices), options, std::move(solver)) {}
    template <UnknownPointRange R>
    explicit HarmonicCoordinates(const R&, const Options& = {},
                                 detail::PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    /// Constructs a TriangleMesh.
    template <PointRange R, FaceRange F>
        requires(D == 3 && range_dimension<R> == 3 && std::is_same_v<C, TriangleMesh<T>>)
    HarmonicCoordinates(const R& vertices, const F& faces, const Options& options = {},
                        Solver solver = AdaptiveGrid{})
        : HarmonicCoordinates(Cage(vertices, faces), options, std::move(solver)) {}
    template <UnknownPointRange R, FaceRange F>
    HarmonicCoordinates(const R&, const F&, const Options& = {},
                        detail::PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    // Copies share the cage and the solved functions. A move is a copy, so that no object becomes empty.
    HarmonicCoordinates(const HarmonicCoordinates&) noexcept = default;
    HarmonicCoordinates& operator=(const HarmonicCoordinates&) noexcept = default;

    const Cage& cage() const noexcept { return problem_->cage; }
    const Options& options() const noexcept { return problem_->options; }
    std::span<const Vec<T, D>> handles() const noexcept { return cage().vertices(); }
    const CageReport& cage_report() const noexcept { return problem_->report; }

    /// Solves all functions and keeps them for several batches of points. Later evaluations repeat the report
    /// of this solve.
    Evaluation solve(const Running& running = {}) {
        return with_functions(running, [&](const auto& functions, SolverReport& report, const Running& rest) {
            const Status status = functions->solve(report, rest);
            if (status == Status::ok) kept_ = functions;
            return status;
        });
    }

    /// Solves all functions, unless they are kept, and packs them for `load_solution`. Only for AdaptiveGrid,
    /// else solver_not_supported. The bytes depend on the cage and the options alone. Packing needs twice the
    /// memory of the kept functions.
    Result<std::vector<std::byte>, Evaluation> save_solution(const Running& running = {}) {
        Result<std::vector<std::byte>, Evaluation> result;
        result.report = solve(running);
        if (!result) return result;
        result.report.status = detail::guard_memory([&] { return kept_->save(result.value); });
        return result;
    }

    /// Takes functions that `save_solution` packed, in place of a solve. The weights are bitwise equal to
    /// those after `solve`.
    ///
    ///   data   the packed functions, for example a mapped file, aligned to 64 bytes. They are not copied:
    ///          the bytes must not change while these coordinates or their copies are used
    ///   fails  not_a_solution, blob_version_differs, blob_kind_differs, blob_truncated, blob_corrupt,
    ///          blob_malformed, blob_of_another_cage; blob_of_another_grid (another accuracy, boundary data
    ///          or machine); solver_not_supported; and all failures of making the grid
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

    /// Computes the gradients of all functions at a batch of points. Custom solvers may have no gradients
    /// (solver_not_supported).
    ///
    ///   points, states   as for `evaluate`
    ///   gradients        out, row axis · #handles + handle: the derivative along the axis, per unit of
    ///                    length. Unchanged for points outside
    ///   accuracy   exact for linear functions: Σ ∇h_i = 0 and Σ C_i ∇h_i = identity, to the tolerance over
    ///              the cell size. Where weights are C²: the derivatives of the weights before negative
    ///              weights are replaced. In a cube at accuracy 1e-3, 90 % of the gradients have an error of
    ///              at most 1.1e-3 / √(mean face area) (`bench_smoothness --cage cube gradients`).
    ///              Elsewhere: differences over a cell, with errors of second order in the cell size, or of
    ///              first order within a cell of the boundary. A point on the boundary gets the gradient of a
    ///              point inside, a hundredth of a cell away where weights are C², else half a cell. If no
    ///              such point lies inside, the boundary point is unreached
    ///   cost       where weights are C²: 1.3 (scattered points) to 6 (hundreds per cell) times that of
    ///              evaluating the points. Elsewhere: 2D + 1 evaluations per point. Unless `solve` was
    ///              called, the stencils or weights of all points are in memory together
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

    /// Returns the memory that the solver needs; zeros if the cage or the grid is refused, or if the
    /// hierarchy does not fit. The call makes the grid: a tenth of the time of a solve, and the hierarchy's
    /// memory. `solve` keeps half a block per group of sixteen.
    SolverMemory solver_memory() const {
        SolverMemory memory;
        (void)with_functions({}, [&](const auto& functions, SolverReport&, const Running&) {
            memory = functions->memory();
            return Status::ok;
        });
        return memory;
    }

    /// Calls f(GridCell) for every cell of an adaptive grid that is inside the cage or intersects its
    /// boundary, in the order of the Morton curve. Returns solver_not_supported for other grids. Otherwise,
    /// failures and cost are those of `solve` before its first cycle.
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
        /// An empty problem with a status.
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
        const Status status = detail::guard_memory(
            [&] { problem = std::make_shared<const Problem>(std::move(cage), options, std::move(solver)); });
        if (status == Status::ok) return problem;
        static const Problem none(Status::out_of_memory);
        return {std::shared_ptr<void>(), &none};
    }

    /// Calls use(functions, report, rest) with the kept functions, or with new, unsolved functions. `rest` is
    /// the share of `running` after making the grid.
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

// Harmonic coordinates: non-negative, without interior extrema, from a Laplace solve on a grid.
//
// Two solvers: the multigrid of this library, and the papers' own as the baseline it is measured against.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/grid/averaging_pyramid.hpp>
#include <cageform/grid/corner_functions.hpp>
#include <cageform/grid/multigrid.hpp>
#include <cageform/grid/rasterise.hpp>
#include <cageform/grid/sample.hpp>

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>

namespace cageform::inline CAGEFORM_ABI {

/// Which solver makes the functions.
enum class HarmonicSolver : std::uint8_t {
    multigrid,         ///< all functions sixteen by sixteen, boundary where it is (grid/multigrid.hpp)
    averaging_pyramid, ///< the papers' own, the historical baseline (grid/averaging_pyramid.hpp)
};

struct MultigridOptions {
    double tolerance = 1e-6;      ///< of the discrete solution's error, by SolverReport::error_estimate
    std::size_t max_cycles = 60;  ///< not_converged when they do not suffice
    bool corner_functions = true; ///< treat the singularities at corners (grid/corner_functions.hpp)
};

struct HarmonicOptions {
    HarmonicSolver solver = HarmonicSolver::multigrid;
    std::size_t resolution = 128; ///< cells along the cage's longest side; 8 … 16384
    MultigridOptions multigrid{};

    // Of the averaging pyramid alone; its resolution counts a margin of four cells.
    AveragingOptions averaging{.tolerance = 1e-6};
    Interpolation interpolation = Interpolation::multilinear;
    std::size_t handles_at_once = 16; ///< functions kept in memory together while points are sampled
};

template <Scalar T, std::size_t D>
class HarmonicCoordinates;

/// Harmonic coordinates in the plane: ∇²h_i = 0 inside, on the boundary the hat function of vertex i.
///
/// Joshi, Meyer, DeRose, Green, Sanocki, Harmonic Coordinates for Character Articulation (SIGGRAPH 2007),
/// sec. 3 and 4. On vertices and edges the boundary data itself is taken, so they are exact there.
///
/// With the multigrid (the default), solved to the digits of double whatever `T`:
///   range     [0, 1], sum 1, Σ h_i C_i = p: all to the tolerance, at every resolution
///   accuracy  of order h² in the open and around corners with ten cells of room (grid/corner_functions.hpp); next to
///             an untreated corner of interior angle ω of order h^(π/ω)
///   cost      `evaluate` solves #V functions, sixteen at a time (unless `solve` has done so before), and samples them.
///             EvaluateOptions::parallel shares the sixteens out; each thread needs `solver_memory().block` bytes,
///             every point 430 bytes. The progress is asked after every cycle on the calling thread
///   fails     as check(cage); resolution_not_supported; tolerance_not_positive; grid_too_coarse; not_converged;
///             cancelled; out_of_memory
///
/// With the averaging pyramid:
///   range     [0, 1] to rounding (a mean of values in [0, 1]), before `bind` restores linear precision; sum to 1
///             as far as the solver got: its tolerance is on the change of a sweep, not on the error
///   accuracy  cells on the boundary are a staircase, which leaves a residual Σwc − p of about half a cell; `bind`
///             restores linear precision, the report says by how much
///   cost      on one thread; memory: handles_at_once (after `solve`: #V) scalars a cell and once 2 words a cell
///   fails     the same, but for grid_too_coarse
///
/// Outside the cage they are not defined (no extension). With the averaging pyramid a point inside none of whose
/// surrounding cells has a value is unreached; with the multigrid every point inside has one.
template <Scalar T>
class HarmonicCoordinates<T, 2> {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 2;
    static constexpr bool has_extension = false;
    static constexpr bool closed_form = false;

    explicit HarmonicCoordinates(Polygon<T> cage, const HarmonicOptions& options = {})
        : cage_(std::move(cage))
        , options_(options)
        , report_(check(cage_))
        , tolerance_(report_.status == Status::ok ? coincidence_tolerance(bounds_of(cage_.vertices()))
                                                  : T(0)) {}

    template <PointRange R>
        requires(range_dimension<R> == 2)
    explicit HarmonicCoordinates(const R& vertices, const HarmonicOptions& options = {})
        : HarmonicCoordinates(Polygon<T>(vertices), options) {}

    const Polygon<T>& cage() const noexcept { return cage_; }
    const HarmonicOptions& options() const noexcept { return options_; }
    std::span<const Vec<T, 2>> handles() const noexcept { return cage_.vertices(); }
    const CageReport& cage_report() const noexcept { return report_; }

    /// Solves all functions and keeps them, for several batches of points to be evaluated; their reports repeat
    /// this solve's.
    Evaluation solve(const EvaluateOptions& options = {}) {
        Solution solution;
        Evaluation evaluation;
        if (options_.solver == HarmonicSolver::multigrid) {
            evaluation.status = detail::guard_memory([&] {
                return on_grid(evaluation.solver, options,
                               [&](std::shared_ptr<Grid> grid, const EvaluateOptions& rising) {
                                   grid->kept.resize(grid->groups);
                                   const Status status = solve_groups(
                                       *grid, evaluation.solver, rising,
                                       [&](std::size_t group, typename Multigrid<2>::Block& block,
                                           const CornerFunctions::Coefficients& at_corners) {
                                           auto& kept = grid->kept[group];
                                           kept.at_corners = at_corners;
                                           for (std::uint32_t n = 0; n < grid->multigrid.unknowns(); ++n)
                                               kept.values.push_back(block.value(n));
                                       });
                                   if (status == Status::ok && evaluation.solver.unsettled == 0)
                                       kept_grid_ = std::move(grid);
                                   return status;
                               });
            });
            if (evaluation.status == Status::ok) kept_report_ = evaluation.solver;
            return evaluation;
        }
        evaluation.status = detail::guard_memory([&] {
            Status status = begin(solution, evaluation.solver);
            if (status == Status::ok)
                status = solve_handles(solution, 0, cage_.size(), evaluation.solver, options.progress);
            return status;
        });
        if (evaluation.status == Status::ok) {
            kept_ = std::move(solution);
            kept_report_ = evaluation.solver;
        }
        return evaluation;
    }

    Evaluation evaluate(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                        const EvaluateOptions& options = {}) const {
        CAGEFORM_ASSERT(weights.rows == cage_.size() && states.size() == points.points, "one row per handle");
        Evaluation evaluation;
        if (options_.solver == HarmonicSolver::multigrid) {
            evaluation.status = detail::guard_memory(
                [&] { return evaluate_grid(points, weights, states, options, evaluation.solver); });
            return evaluation;
        }
        evaluation.status = detail::guard_memory([&] {
            if (!kept_.fields.empty()) {
                evaluation.solver = kept_report_;
                return detail::for_each_block(points.blocks(), options, [&](std::size_t b, std::size_t e) {
                    sample_blocks(kept_, 0, b, e, points, weights, states);
                });
            }
            Solution solution;
            Status status = begin(solution, evaluation.solver);
            if (points.points == 0) return status;
            const std::size_t group = std::max<std::size_t>(1, options_.handles_at_once);
            for (std::size_t first = 0; first < cage_.size() && status == Status::ok; first += group) {
                const std::size_t count = std::min(group, cage_.size() - first);
                status = solve_handles(solution, first, count, evaluation.solver, options.progress);
                if (status != Status::ok) break;
                detail::in_parallel(options, points.blocks(), 64, [&](std::size_t b, std::size_t e) {
                    sample_blocks(solution, first, b, e, points, weights, states);
                });
            }
            return status;
        });
        return evaluation;
    }

    Vec<T, 2> nearest_boundary(const Vec<T, 2>& p, std::span<T> row) const noexcept {
        return nearest_boundary_weights(cage_, p, row);
    }

    /// What the multigrid will need, in bytes; all zero where the cage or the grid is refused. The cost is that of
    /// setting the solver up, some hundredths of solving.
    struct SolverMemory {
        std::size_t hierarchy = 0; ///< once
        std::size_t block = 0; ///< sixteen functions: on each thread, and after `solve` about half of it per sixteen
    };
    SolverMemory solver_memory() const {
        std::shared_ptr<const Grid> grid;
        SolverReport report;
        if (make_grid(grid, report, options_.multigrid.corner_functions) != Status::ok) return {};
        return {grid->multigrid.bytes(), grid->multigrid.block_bytes()};
    }

private:
    // ---- the multigrid ----

    /// Sixteen functions: at the nodes, and what they have of each corner's.
    struct Functions {
        std::vector<Multigrid<2>::Values> values;
        CornerFunctions::Coefficients at_corners;

        const Multigrid<2>::Values& value(std::uint32_t node) const noexcept { return values[node]; }
    };

    /// The problem on the grid and its solver; after `solve` the functions too.
    struct Grid {
        Grid(const Polygon<T>& polygon, const Lattice<double, 2>& with_lattice, const Crossings<2>& crossings,
             PolygonBoundary<T> with, bool with_corners)
            : lattice(with_lattice)
            , boundary(std::move(with))
            , problem(embed<2>({std::int32_t(lattice.cells[0]), std::int32_t(lattice.cells[1])}, crossings,
                               [this](const auto& node) { return boundary.nearest(node); }))
            , corners(with_corners ? CornerFunctions(polygon, lattice, problem) : CornerFunctions())
            , multigrid(problem.nodes, problem.cuts, corners.sources())
            , groups((polygon.size() + Multigrid<2>::width - 1) / Multigrid<2>::width) {
            boundary.index_cells();
            std::size_t slot = 0;
            std::vector<std::uint32_t> slots(problem.nodes.count());
            for (; slot < multigrid.source_count(); ++slot)
                slots[multigrid.source_node(slot)] = std::uint32_t(slot);
            for (const CutLink& cut : problem.cuts) cut_slots.push_back(slots[cut.node]);
            corners.set_slots(slots);
        }
        Lattice<double, 2> lattice;
        PolygonBoundary<T> boundary;
        EmbeddedProblem<2> problem;
        CornerFunctions corners;
        Multigrid<2> multigrid;
        std::vector<std::uint32_t> cut_slots; ///< of each cut link in Block::source
        std::size_t groups;                   ///< of sixteen functions
        std::vector<Functions> kept;          ///< by group
    };

    /// Centred on the cage's box, so that a symmetric cage has symmetric functions; sides of an axis-aligned cage
    /// whose extents divide evenly lie on lattice lines.
    Lattice<double, 2> lattice_of(std::size_t resolution) const noexcept {
        const auto bounds = bounds_of(cage_.vertices());
        const auto lower = vec_cast<double>(bounds.lower), extent = vec_cast<double>(bounds.upper) - lower;
        Lattice<double, 2> lattice;
        lattice.spacing = std::max(extent[0], extent[1]) / double(resolution);
        for (std::size_t k = 0; k < 2; ++k) {
            const double links = std::ceil(extent[k] / lattice.spacing - on_boundary_distance);
            lattice.cells[k] = std::size_t(links) + 1;
            lattice.origin[k] = lower[k] + 0.5 * (extent[k] - links * lattice.spacing);
        }
        return lattice;
    }

    template <class GridPointer>
    Status make_grid(GridPointer& grid, SolverReport& report, bool with_corners) const {
        constexpr std::size_t most = 16384;
        if (report_.status != Status::ok) return report_.status;
        if (options_.resolution < 8 || options_.resolution > most) return Status::resolution_not_supported;
        if (!(options_.multigrid.tolerance > 0)) return Status::tolerance_not_positive;
        const auto lattice = lattice_of(options_.resolution);
        PolygonBoundary<T> boundary(cage_, lattice);
        const auto crossings = boundary.crossings();
        const auto seen = seen_handles<2>(crossings, cage_.size());
        const auto unseen = std::find(seen.begin(), seen.end(), false);
        if (unseen != seen.end()) {
            report.unseen_handle = std::size_t(unseen - seen.begin());
            for (std::size_t finer = 2 * options_.resolution; finer <= most; finer *= 2) {
                const auto there =
                    seen_handles<2>(PolygonBoundary<T>(cage_, lattice_of(finer)).crossings(), cage_.size());
                if (std::find(there.begin(), there.end(), false) != there.end()) continue;
                report.sufficient_resolution = finer;
                break;
            }
            return Status::grid_too_coarse;
        }
        grid = std::make_shared<Grid>(cage_, lattice, crossings, std::move(boundary), with_corners);
        report.cells = grid->multigrid.unknowns();
        report.bytes = grid->multigrid.bytes() + grid->multigrid.block_bytes();
        return Status::ok;
    }

    /// Solves group after group and hands each to take(group, block, at_corners), on the threads of `options`.
    template <class Take>
    Status solve_groups(const Grid& grid, SolverReport& report, const EvaluateOptions& options,
                        const Take& take) const {
        const auto start = std::chrono::steady_clock::now();
        const auto caller = std::this_thread::get_id();
        std::atomic<std::size_t> done{0};
        std::atomic<bool> cancelled{false};
        double told = 0;
        std::mutex report_access;
        std::vector<typename Multigrid<2>::Block> spare; // as many as threads at work together
        detail::in_parallel(options, grid.groups, 1, [&](std::size_t begin, std::size_t end) {
            typename Multigrid<2>::Block block;
            {
                const std::lock_guard lock(report_access);
                if (!spare.empty()) {
                    block = std::move(spare.back());
                    spare.pop_back();
                }
            }
            if (block.empty()) block = grid.multigrid.make_block();
            for (std::size_t group = begin; group < end && !cancelled; ++group) {
                const auto keep_going = [&](double fraction) {
                    if (std::this_thread::get_id() == caller && options.progress) {
                        told = std::max(told, (double(done) + fraction) / double(grid.groups));
                        if (!options.progress(told)) cancelled = true;
                    }
                    return !cancelled;
                };
                SolverReport part;
                CornerFunctions::Coefficients at_corners;
                if (!solve_group(grid, group, block, at_corners, part, keep_going)) return;
                if (part.unsettled == 0) take(group, block, at_corners);
                ++done;
                keep_going(0);
                const std::lock_guard lock(report_access);
                report.solves += part.solves;
                report.unconverged += part.unconverged;
                report.unsettled += part.unsettled;
                report.cycles = std::max(report.cycles, part.cycles);
                report.convergence_factor = std::max(report.convergence_factor, part.convergence_factor);
                report.error_estimate = std::max(report.error_estimate, part.error_estimate);
                report.error_bound = std::max(report.error_bound, part.error_bound);
            }
            const std::lock_guard lock(report_access);
            spare.push_back(std::move(block));
        });
        report.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return cancelled ? Status::cancelled : report.unconverged > 0 ? Status::not_converged : Status::ok;
    }

    /// Functions 16·group …; false when cancelled.
    template <class KeepGoing>
    bool solve_group(const Grid& grid, std::size_t group, typename Multigrid<2>::Block& block,
                     CornerFunctions::Coefficients& at_corners, SolverReport& report,
                     const KeepGoing& keep_going) const {
        constexpr std::size_t width = Multigrid<2>::width;
        const std::size_t first = group * width, count = std::min(width, cage_.size() - first);
        for (auto& values : block.source) values.fill(0.0);
        for (std::size_t c = 0; c < grid.problem.cuts.size(); ++c) {
            const auto& value = grid.problem.values[c];
            for (std::size_t n = 0; n < BoundaryValue<2>::most; ++n) {
                if (value.handle[n] < first || value.handle[n] >= first + count) continue;
                block.source[grid.cut_slots[c]][value.handle[n] - first] +=
                    grid.problem.cuts[c].weight * value.weight[n];
            }
        }
        const auto largest = [&](const Multigrid<2>::Values& values) {
            return *std::max_element(values.begin(), values.begin() + std::ptrdiff_t(count));
        };
        at_corners = grid.corners.start(first, block.source);
        auto error = grid.multigrid.start(block);
        double before = 0, change_before = 0;
        bool settled = false;
        for (;;) {
            report.error_estimate = largest(error.estimate);
            if (report.cycles > 1 && before > options_.multigrid.tolerance)
                report.convergence_factor =
                    std::max(report.convergence_factor, report.error_estimate / before);
            // The corners' coefficients follow the solution and the solution them, a few times each.
            double change = 0;
            if (!settled) {
                auto fitted = grid.corners.fit(first, block, at_corners);
                change = grid.corners.difference(fitted, at_corners);
                settled = report.cycles > 1 && change > 0.7 * change_before;
                if (settled && change > options_.multigrid.tolerance) {
                    report.unsettled = count;
                    return true; // in vain: see on_grid
                }
                if (!settled) {
                    const auto disturbance = grid.corners.replace(at_corners, fitted, block.source);
                    error.estimate = Multigrid<2>::disturb(block, disturbance);
                    change_before = change;
                }
            }
            if (block.is_refined() &&
                std::max(report.error_estimate, change) <= options_.multigrid.tolerance)
                break;
            if (report.cycles == options_.multigrid.max_cycles) {
                report.unconverged = count;
                break;
            }
            if (!keep_going(double(report.cycles) / double(report.cycles + 4))) return false;
            before = largest(error.estimate);
            error = grid.multigrid.cycle(block);
            ++report.cycles;
        }
        report.error_bound = largest(error.bound);
        report.solves = count;
        return true;
    }

    Status evaluate_grid(BlockView<const T> points, BlockView<T> weights, std::span<PointState> states,
                         const EvaluateOptions& options, SolverReport& report) const {
        if (kept_grid_) {
            report = kept_report_;
            return sample_grid(*kept_grid_, points, weights, states, options, report);
        }
        return on_grid(report, options,
                       [&](const std::shared_ptr<Grid>& grid, const EvaluateOptions& rising) {
                           return sample_grid(*grid, points, weights, states, rising, report);
                       });
    }

    /// Runs use(grid, options); where corners do not settle, once more without treating any: all functions have to be treated
    /// alike to sum to 1.
    template <class Use>
    Status on_grid(SolverReport& report, const EvaluateOptions& options, const Use& use) const {
        EvaluateOptions rising = options;
        double highest = 0;
        if (options.progress) {
            rising.progress = [&](double done) {
                highest = std::max(highest, done);
                return options.progress(highest);
            };
        }
        for (const bool with_corners : {options_.multigrid.corner_functions, false}) {
            std::shared_ptr<Grid> grid;
            const std::size_t unsettled = report.unsettled;
            report = {};
            Status status = make_grid(grid, report, with_corners);
            if (status == Status::ok) status = use(grid, rising);
            if (status != Status::ok || !with_corners || report.unsettled == 0) {
                report.unsettled += unsettled;
                return status;
            }
        }
        return Status::ok;
    }

    /// The weights of points from a grid's functions, kept or solved now.
    Status sample_grid(const Grid& grid, BlockView<const T> points, BlockView<T> weights,
                       std::span<PointState> states, const EvaluateOptions& options,
                       SolverReport& report) const {
        if (points.points == 0) return Status::ok;

        std::vector<PointStencil> stencils(points.blocks() * lane_count<T>);
        detail::in_parallel(options, points.blocks(), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin * lane_count<T>; i < end * lane_count<T>; ++i)
                stencils[i] = stencil_at(grid, i, points, states);
        });
        // What corners add to a point's weights is kept until all of them are known.
        std::vector<std::size_t> corrected;
        for (std::size_t i = 0; i < stencils.size(); ++i) {
            if (stencils[i].correction.corner != CornerFunctions::Correction::none) corrected.push_back(i);
        }
        std::vector<T> added(corrected.size() * cage_.size());
        const auto sample = [&](std::size_t group, const auto& solution,
                                const CornerFunctions::Coefficients& at_corners) {
            const std::size_t first = group * Multigrid<2>::width;
            for (std::size_t i = 0; i < stencils.size(); ++i)
                sample_group(stencils[i].mean, solution, first, i, weights);
            for (std::size_t n = 0; n < corrected.size(); ++n) {
                std::array<double, Multigrid<2>::width> more{};
                CornerFunctions::apply(stencils[corrected[n]].correction, at_corners, more);
                for (std::size_t k = 0; k < more.size() && first + k < cage_.size(); ++k)
                    added[n * cage_.size() + first + k] = static_cast<T>(more[k]);
            }
        };
        Status status = Status::ok;
        if (!grid.kept.empty()) {
            status = detail::for_each_block(grid.groups, options, [&](std::size_t begin, std::size_t end) {
                for (std::size_t group = begin; group < end; ++group)
                    sample(group, grid.kept[group], grid.kept[group].at_corners);
            });
        } else {
            status = solve_groups(grid, report, options,
                                  [&](std::size_t group, typename Multigrid<2>::Block& block,
                                      const CornerFunctions::Coefficients& at_corners) {
                                      sample(group, block, at_corners);
                                  });
        }
        if (status != Status::ok) return status;
        for (std::size_t n = 0; n < corrected.size(); ++n)
            add_corner(std::span<const T>(added).subspan(n * cage_.size(), cage_.size()), corrected[n],
                       weights);
        return Status::ok;
    }

    /// What a point's weights are made of.
    struct PointStencil {
        CutStencil<2> mean;
        CornerFunctions::Correction correction;
    };

    /// Where point `i` lies and its stencil; lanes beyond the points have empty ones.
    PointStencil stencil_at(const Grid& grid, std::size_t i, BlockView<const T> points,
                            std::span<PointState> states) const {
        PointStencil stencil;
        if (i >= points.points || states[i] == PointState::not_finite) return stencil;
        const auto p = block_point<2>(points, i);
        states[i] = locate(cage_, p, tolerance_);
        if (states[i] == PointState::inside) {
            stencil.mean = grid.boundary.sample(p, grid.problem.nodes);
            stencil.correction = grid.corners.correction(
                grid.lattice.in_cells(vec_cast<double>(p)), stencil.mean, [&](std::uint32_t node) {
                    const auto index = grid.problem.nodes.index(node);
                    return Vec<double, 2>{double(index[0]), double(index[1])};
                });
        }
        if (states[i] == PointState::on_boundary) {
            const auto place = nearest_on_boundary(cage_, p);
            stencil.mean.add(BoundaryValue<2>{{std::uint32_t(place.i), std::uint32_t(place.j)},
                                              {1 - double(place.s), double(place.s)}},
                             1.0);
        }
        return stencil;
    }
    template <class Solution> // a block of the multigrid, or functions that were kept
    void sample_group(const CutStencil<2>& mean, const Solution& solution, std::size_t first, std::size_t i,
                      BlockView<T> weights) const noexcept {
        constexpr std::size_t width = Multigrid<2>::width;
        const std::size_t count = std::min(width, cage_.size() - first);
        Multigrid<2>::Values value{};
        for (std::uint32_t n = 0; n < mean.node_count; ++n) {
            const auto& at_node = solution.value(mean.nodes[n].node);
            for (std::size_t k = 0; k < width; ++k) value[k] += mean.nodes[n].share * at_node[k];
        }
        for (std::uint32_t n = 0; n < mean.place_count; ++n) {
            const auto& place = mean.places[n];
            for (std::size_t h = 0; h < BoundaryValue<2>::most; ++h) {
                const std::size_t k = place.value.handle[h] - first;
                if (k < count) value[k] += place.share * place.value.weight[h];
            }
        }
        // A mean of boundary data is in [0, 1]; the solver's error may not leave it.
        auto* const row = weights.block(i / lane_count<T>) + first;
        for (std::size_t k = 0; k < count; ++k)
            row[k][i % lane_count<T>] = static_cast<T>(std::clamp(value[k], 0.0, 1.0));
    }
    /// Adds as much of a corner's part as keeps all weights of the point in [0, 1]: all of it, unless the grid is
    /// too coarse for the corner. The part sums to 0 and moves no point, so any share of it may be taken.
    void add_corner(std::span<const T> part, std::size_t i, BlockView<T> weights) const noexcept {
        auto* const row = weights.block(i / lane_count<T>);
        const std::size_t lane = i % lane_count<T>;
        const T allowed = static_cast<T>(options_.multigrid.tolerance); // what the clamp may take away
        T share = 1;
        for (std::size_t k = 0; k < part.size(); ++k) {
            const T w = row[k][lane], room = allowed + (part[k] < 0 ? w : T(1) - w);
            if (room < share * std::fabs(part[k])) share = room / std::fabs(part[k]);
        }
        for (std::size_t k = 0; k < part.size(); ++k)
            row[k][lane] = std::clamp(row[k][lane] + share * part[k], T(0), T(1));
    }

    // ---- the averaging pyramid ----

    struct Solution {
        GridDomain<T, 2> domain;
        std::vector<std::vector<T>> fields; // one for each handle of the group at hand
    };

    Status begin(Solution& solution, SolverReport& report) const {
        if (report_.status != Status::ok) return report_.status;
        if (options_.resolution < 8 || options_.resolution > 16384) return Status::resolution_not_supported;
        if (!(options_.averaging.tolerance > 0)) return Status::tolerance_not_positive;
        solution.domain = rasterise(cage_, lattice_about(bounds_of(cage_.vertices()), options_.resolution));
        report.crowded_cells = solution.domain.crowded_cells;
        return Status::ok;
    }

    /// Solves for handles first … first + count − 1.
    Status solve_handles(Solution& solution, std::size_t first, std::size_t count, SolverReport& report,
                         const Progress& progress) const {
        const auto start = std::chrono::steady_clock::now();
        const GridDomain<T, 2>& domain = solution.domain;
        AveragingPyramid<T, 2> pyramid(domain.lattice, domain.tags, options_.averaging);
        report.cells = pyramid.unknowns();
        solution.fields.assign(count, {});
        Status status = Status::ok;
        for (std::size_t n = 0; n < count && status == Status::ok; ++n) {
            const std::size_t handle = first + n;
            auto& field = solution.fields[n];
            field.assign(domain.tags.size(), T(0));
            for (std::size_t b = 0; b < domain.boundary_cells.size(); ++b) {
                const auto& place = domain.places[b];
                if (place.i == handle) field[domain.boundary_cells[b]] = T(1) - place.s;
                if (place.j == handle) field[domain.boundary_cells[b]] = place.s;
            }
            const double done = double(handle) / double(cage_.size());
            const auto outcome =
                pyramid.solve(std::span<T>(field), [&] { return !progress || progress(done); });
            if (outcome.cancelled) return Status::cancelled;
            ++report.solves;
            report.sweeps += outcome.sweeps;
            report.largest_mean_change = std::max(report.largest_mean_change, outcome.mean_change);
            if (!outcome.converged) {
                ++report.unconverged;
                status = Status::not_converged;
            }
            if (progress && !progress(double(handle + 1) / double(cage_.size()))) return Status::cancelled;
        }
        report.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return status;
    }

    /// Rows `first` … of the weights of blocks [begin, end), from the fields of a solution.
    void sample_blocks(const Solution& solution, std::size_t first, std::size_t begin, std::size_t end,
                       BlockView<const T> points, BlockView<T> weights, std::span<PointState> states) const {
        const auto& domain = solution.domain;
        constexpr std::size_t lanes = lane_count<T>;
        for (std::size_t b = begin; b < end; ++b) {
            auto* const row = weights.block(b) + first;
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const std::size_t i = b * lanes + lane;
                for (std::size_t n = 0; n < solution.fields.size(); ++n) row[n][lane] = T(0);
                if (i >= points.points || states[i] == PointState::not_finite) continue;
                const auto p = block_point<2>(points, i);
                states[i] = locate(cage_, p, tolerance_);
                if (states[i] == PointState::outside) continue;
                if (states[i] == PointState::on_boundary) {
                    const auto place = nearest_on_boundary(cage_, p);
                    if (place.i - first < solution.fields.size()) row[place.i - first][lane] = T(1) - place.s;
                    if (place.j - first < solution.fields.size()) row[place.j - first][lane] = place.s;
                    continue;
                }
                const auto stencil = sample_stencil(domain.lattice, std::span<const CellTag>(domain.tags), p,
                                                    options_.interpolation);
                if (stencil.count == 0) states[i] = PointState::unreached;
                for (std::size_t n = 0; n < solution.fields.size(); ++n) {
                    row[n][lane] = stencil.sample(std::span<const T>(solution.fields[n]));
                }
            }
        }
    }

    Polygon<T> cage_;
    HarmonicOptions options_;
    CageReport report_;
    T tolerance_;
    Solution kept_;
    std::shared_ptr<const Grid> kept_grid_;
    SolverReport kept_report_;
};

using HarmonicCoordinates2f = HarmonicCoordinates<float, 2>;
using HarmonicCoordinates2d = HarmonicCoordinates<double, 2>;

} // namespace cageform::inline CAGEFORM_ABI

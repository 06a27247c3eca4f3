// Harmonic coordinates: non-negative, without interior extrema, from a Laplace solve on a grid.
#pragma once

#include <cageform/coordinates/coordinate.hpp>
#include <cageform/grid/averaging_pyramid.hpp>
#include <cageform/grid/rasterise.hpp>
#include <cageform/grid/sample.hpp>

#include <chrono>

namespace cageform::inline CAGEFORM_ABI {

/// Which solver makes the functions.
enum class HarmonicSolver : std::uint8_t {
    averaging_pyramid, ///< the papers' own, the historical baseline (grid/averaging_pyramid.hpp)
};

struct HarmonicOptions {
    HarmonicSolver solver = HarmonicSolver::averaging_pyramid;
    std::size_t resolution = 128; ///< cells along the cage's longest side, margin included; 8 … 16384
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
///   range     [0, 1] to rounding (a mean of values in [0, 1]), before `bind` restores linear precision; sum to 1
///             as far as the solver got: its tolerance is on the change of a sweep, not on the error
///   accuracy  with the averaging pyramid: cells on the boundary are a staircase, which leaves a residual
///             Σwc − p of about half a cell; `bind` restores linear precision, the report says by how much
///   cost      on one thread (EvaluateOptions::parallel serves the sampling): `evaluate` solves #V functions, unless `solve` has done so before, then samples them;
///             memory: handles_at_once (after `solve`: #V) scalars a cell and once 2 words a cell
///   fails     as check(cage); resolution_not_supported; tolerance_not_positive; not_converged; cancelled
///   outside   not defined (no extension)
///
/// Point states: unreached is a point inside the cage none of whose surrounding cells has a value.
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

private:
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

    /// Solves for handles first … first + count − 1. The domain and its data are apart from the solver, the
    /// solver apart from the sampling: another solver is another branch here.
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
    SolverReport kept_report_;
};

using HarmonicCoordinates2f = HarmonicCoordinates<float, 2>;
using HarmonicCoordinates2d = HarmonicCoordinates<double, 2>;

} // namespace cageform::inline CAGEFORM_ABI

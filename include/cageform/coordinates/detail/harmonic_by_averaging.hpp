// Harmonic functions of a polygon by the papers' solver: the historical baseline.
#pragma once

#include <cageform/coordinates/detail/harmonic_on_grid.hpp>
#include <cageform/grid/rasterise.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

template <Scalar T>
class HarmonicByAveraging {
public:
    using Cage = HarmonicOnGrid<Polygon<T>>; ///< the polygon with its options and its report

    /// Solves all functions and keeps them.
    Status solve(const Cage& cage, const Running& options, SolverReport& report) {
        Solution solution;
        Status status = begin(cage, solution, report);
        if (status == Status::ok)
            status = solve_handles(cage, solution, 0, cage.cage().size(), report, options.progress);
        if (status == Status::ok) {
            kept_ = std::move(solution);
            kept_report_ = report;
        }
        return status;
    }

    Status evaluate(const Cage& cage, BlockView<const T> points, BlockView<T> weights,
                    std::span<PointState> states, const Running& options, SolverReport& report) const {
        if (!kept_.fields.empty()) {
            report = kept_report_;
            return for_each_block(points.blocks(), options, [&](std::size_t b, std::size_t e) {
                sample_blocks(cage, kept_, 0, b, e, points, weights, states);
            });
        }
        Solution solution;
        Status status = begin(cage, solution, report);
        if (points.points == 0) return status;
        const std::size_t handles = cage.cage().size();
        const std::size_t group = std::max<std::size_t>(1, cage.options().handles_at_once);
        for (std::size_t first = 0; first < handles && status == Status::ok; first += group) {
            const std::size_t count = std::min(group, handles - first);
            status = solve_handles(cage, solution, first, count, report, options.progress);
            if (status != Status::ok) break;
            in_parallel(options, points.blocks(), 64, [&](std::size_t b, std::size_t e) {
                sample_blocks(cage, solution, first, b, e, points, weights, states);
            });
        }
        return status;
    }

private:
    struct Solution {
        GridDomain<T, 2> domain;
        std::vector<std::vector<T>> fields; // one for each handle of the group at hand
    };

    static Status begin(const Cage& cage, Solution& solution, SolverReport& report) {
        if (cage.cage_report().status != Status::ok) return cage.cage_report().status;
        if (cage.options().resolution < 8 || cage.options().resolution > 16384)
            return Status::resolution_not_supported;
        if (!(cage.options().averaging.tolerance > 0)) return Status::tolerance_not_positive;
        solution.domain = rasterise(
            cage.cage(), lattice_about(bounds_of(cage.cage().vertices()), cage.options().resolution));
        report.crowded_cells = solution.domain.crowded_cells;
        return Status::ok;
    }

    /// Solves for handles first … first + count − 1.
    static Status solve_handles(const Cage& cage, Solution& solution, std::size_t first, std::size_t count,
                                SolverReport& report, const Progress& progress) {
        const auto start = std::chrono::steady_clock::now();
        const GridDomain<T, 2>& domain = solution.domain;
        AveragingPyramid<T, 2> pyramid(domain.lattice, domain.tags, cage.options().averaging);
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
            const double done = double(handle) / double(cage.cage().size());
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
            if (progress && !progress(double(handle + 1) / double(cage.cage().size())))
                return Status::cancelled;
        }
        report.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return status;
    }

    /// Rows `first` … of the weights of blocks [begin, end), from the fields of a solution.
    static void sample_blocks(const Cage& cage, const Solution& solution, std::size_t first,
                              std::size_t begin, std::size_t end, BlockView<const T> points,
                              BlockView<T> weights, std::span<PointState> states) {
        const auto& domain = solution.domain;
        constexpr std::size_t lanes = lane_count<T>;
        for (std::size_t b = begin; b < end; ++b) {
            auto* const row = weights.block(b) + first;
            for (std::size_t lane = 0; lane < lanes; ++lane) {
                const std::size_t i = b * lanes + lane;
                for (std::size_t n = 0; n < solution.fields.size(); ++n) row[n][lane] = T(0);
                if (i >= points.points || states[i] == PointState::not_finite) continue;
                const auto p = block_point<2>(points, i);
                states[i] = locate(cage.cage(), p, cage.tolerance());
                if (states[i] == PointState::outside) continue;
                if (states[i] == PointState::on_boundary) {
                    const auto place = nearest_on_boundary(cage.cage(), p);
                    if (place.i - first < solution.fields.size()) row[place.i - first][lane] = T(1) - place.s;
                    if (place.j - first < solution.fields.size()) row[place.j - first][lane] = place.s;
                    continue;
                }
                const auto stencil = sample_stencil(domain.lattice, std::span<const CellTag>(domain.tags), p,
                                                    cage.options().interpolation);
                if (stencil.count == 0) states[i] = PointState::unreached;
                for (std::size_t n = 0; n < solution.fields.size(); ++n) {
                    row[n][lane] = stencil.sample(std::span<const T>(solution.fields[n]));
                }
            }
        }
    }

    Solution kept_;
    SolverReport kept_report_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

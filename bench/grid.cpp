// How long does the Laplace equation take for all functions of a cage?
//
// The unknowns are the cells inside a star (2D, 25 functions) and a bumpy ball (3D, 112 functions). Boundary
// values are given at the cells around them, as on the staircase grids of the papers. The multigrid solves to
// an estimated error of 1e-6. Peers: the papers' averaging sweeps (to a mean change of 1e-5, which leaves
// errors of some hundredths), Eigen's factorisation, and CHOLMOD's if installed. The limit is moving the
// memory of the solution once. Then the colours of a hundred strokes with two sides are diffused over a
// canvas.
#include "averaging/averaging_pyramid.hpp"
#include "counted.hpp"

#include <cageform/fields/strokes.hpp>
#include <cageform/grid/multigrid/groups.hpp>
#include <cageform/parallel/threads.hpp>

#include <Eigen/SparseCholesky>
#include <benchmark/benchmark.h>

#include <numeric>
#include <random>

#if defined(CAGEFORM_BENCH_CHOLMOD)
#include <Eigen/CholmodSupport>
#endif

namespace {

using cageform::Vec;
using cageform::grid::CutLink;
using cageform::grid::Multigrid;
using cageform::grid::NodeRuns;
using cageform_sources::averaging::CellTag;

/// Cells inside a figure with the extent [−1.5, 1.5]^D.
template <std::size_t D>
struct Problem {
    static constexpr std::size_t functions = D == 2 ? 25 : 112;

    explicit Problem(std::int32_t n) {
        box.cells.fill(std::size_t(n));
        typename NodeRuns<D>::Index size;
        size.fill(n);
        nodes = NodeRuns<D>(size);
        const auto place = [&](std::size_t cell) {
            Vec<double, D> p{};
            for (std::size_t k = 0; k < D; ++k) p[k] = 3 * (double(box.index(cell)[k]) + 0.5) / n - 1.5;
            return p;
        };
        tags.assign(box.size(), CellTag::exterior);
        for (std::size_t row = 0; row < box.size(); row += std::size_t(n)) {
            for (std::int32_t x = 0; x < n; ++x) {
                if (!inside(place(row + std::size_t(x)))) continue;
                tags[row + std::size_t(x)] = CellTag::interior;
                nodes.add_run(x, x + 1);
                cells.push_back(row + std::size_t(x));
            }
            nodes.end_row();
        }
        nodes.for_each_end([&](const auto&, std::uint32_t node, std::size_t direction) {
            const std::size_t step = box.stride(direction / 2);
            const std::size_t given = (direction & 1) != 0 ? cells[node] + step : cells[node] - step;
            tags[given] = CellTag::boundary;
            cuts.push_back({node, std::uint8_t(direction), 1.0});
            given_cells.push_back(given);
            given_places.push_back(place(given));
        });
        // Hat-like functions at about `functions` boundary positions.
        for (std::size_t k = 0; k < functions; ++k)
            centres.push_back(given_places[(2 * k + 1) * given_places.size() / (2 * functions)]);
    }
    double data(std::size_t function, std::size_t cut) const {
        const auto d = given_places[cut] - centres[function];
        return std::exp(-(D == 2 ? 20.0 : 12.0) * dot(d, d));
    }

    cageform::CellBox<D> box;
    NodeRuns<D> nodes;
    std::vector<CellTag> tags;
    std::vector<std::size_t> cells; ///< of the nodes
    std::vector<CutLink> cuts;
    std::vector<std::size_t> given_cells; ///< of the cuts, and their positions
    std::vector<Vec<double, D>> given_places, centres;

private:
    static bool inside(const Vec<double, D>& p) {
        const double r = std::sqrt(dot(p, p)), angle = std::atan2(p[1], p[0]);
        if constexpr (D == 2) {
            return r < 1 + 0.35 * std::sin(5 * angle) + 0.1 * std::cos(3 * angle);
        } else {
            const double height = std::acos(std::clamp(p[2] / std::fmax(r, 1e-9), -1.0, 1.0));
            return r < 1 + 0.3 * std::cos(3 * height) + 0.15 * std::sin(height) * std::cos(5 * angle);
        }
    }
};

template <std::size_t D>
void multigrid(benchmark::State& state) {
    const Problem<D> problem(std::int32_t(state.range(0)));
    cageform::Running running;
    if (state.range(1) > 1) running.parallel = cageform::ThreadedFor{unsigned(state.range(1))};
    cageform::SolverReport report;
    std::size_t bytes = 0;
    const cageform_bench::Counted counted;
    for (auto _ : state) {
        const Multigrid<D> solver(problem.nodes, problem.cuts, {});
        const auto slot = solver.source_slots();
        const auto fill = [&](std::size_t first, std::size_t count, auto& source) {
            for (std::size_t c = 0; c < problem.cuts.size(); ++c) {
                auto& row = source[slot[problem.cuts[c].node]];
                for (std::size_t k = 0; k < count; ++k) row[k] += problem.data(first + k, c);
            }
        };
        const cageform::grid::MultigridGroups groups{
            solver, cageform::grid::CycleGoal{problem.functions, 1e-6, 60}, fill};
        const auto use = [](std::size_t, const auto& block) { benchmark::DoNotOptimize(block.value(0)); };
        report = {};
        if (solve_groups(groups, report, use, running) != cageform::Status::ok)
            state.SkipWithError("did not converge");
        bytes = solver.bytes() + std::size_t(state.range(1)) * solver.block_bytes();
    }
    state.counters["unknowns"] = double(problem.nodes.count());
    state.counters["cycles"] = double(report.multigrid.cycles);
    state.counters["MB"] = double(bytes) / 1e6;
}

template <std::size_t D>
void papers_sweeps(benchmark::State& state) {
    const Problem<D> problem(std::int32_t(state.range(0)));
    cageform_sources::averaging::AveragingOptions options;
    options.tolerance = 1e-5;
    std::vector<double> field(problem.box.size());
    std::size_t sweeps = 0;
    for (auto _ : state) {
        cageform_sources::averaging::AveragingPyramid<double, D> pyramid(problem.box, problem.tags, options);
        sweeps = 0;
        for (std::size_t k = 0; k < problem.functions; ++k) {
            std::fill(field.begin(), field.end(), 0.0);
            for (std::size_t c = 0; c < problem.cuts.size(); ++c)
                field[problem.given_cells[c]] = problem.data(k, c);
            const auto outcome = pyramid.solve(std::span<double>(field));
            if (!outcome.converged) state.SkipWithError("did not converge");
            sweeps += outcome.sweeps;
        }
        benchmark::ClobberMemory();
    }
    state.counters["unknowns"] = double(problem.nodes.count());
    state.counters["sweeps"] = double(sweeps) / double(problem.functions);
}

/// One factorisation, then all right-hand sides.
template <class Factor, std::size_t D>
void factorise(benchmark::State& state) {
    const Problem<D> problem(std::int32_t(state.range(0)));
    const int n = int(problem.nodes.count());
    std::vector<int> number(problem.box.size(), -1);
    for (int i = 0; i < n; ++i) number[problem.cells[std::size_t(i)]] = i;
    for (auto _ : state) {
        Eigen::SparseMatrix<double> a(n, n);
        a.reserve(Eigen::VectorXi::Constant(n, int(D) + 1));
        for (int i = 0; i < n; ++i) { // lower triangle
            a.insert(i, i) = 2.0 * double(D);
            for (std::size_t k = 0; k < D; ++k) {
                const int above = number[problem.cells[std::size_t(i)] + problem.box.stride(k)];
                if (above >= 0) a.insert(above, i) = -1;
            }
        }
        const Factor factor(a);
        if (factor.info() != Eigen::Success) state.SkipWithError("not factorised");
        constexpr std::size_t together = 28;
        for (std::size_t first = 0; first < problem.functions; first += together) {
            const std::size_t count = std::min(together, problem.functions - first);
            Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n, Eigen::Index(count));
            for (std::size_t c = 0; c < problem.cuts.size(); ++c) {
                for (std::size_t k = 0; k < count; ++k)
                    right(problem.cuts[c].node, Eigen::Index(k)) += problem.data(first + k, c);
            }
            const Eigen::MatrixXd solution = factor.solve(right);
            benchmark::DoNotOptimize(solution.data());
        }
    }
    state.counters["unknowns"] = double(n);
}
template <std::size_t D>
void ldlt(benchmark::State& state) {
    factorise<Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>, D>(state);
}
BENCHMARK_TEMPLATE(ldlt, 2)->ArgName("n")->Arg(256)->Arg(1024)->Unit(benchmark::kMillisecond);
#if defined(CAGEFORM_BENCH_CHOLMOD)
template <std::size_t D>
void cholmod(benchmark::State& state) {
    factorise<Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>, Eigen::Lower>, D>(state);
}
BENCHMARK_TEMPLATE(cholmod, 2)->ArgName("n")->Arg(256)->Arg(1024)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(cholmod, 3)->ArgName("n")->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
#endif

/// Reads and writes the values of each function once, in float: a lower bound for a sweep of any solver.
template <std::size_t D>
void limit_move_solution(benchmark::State& state) {
    const Problem<D> problem(std::int32_t(state.range(0)));
    constexpr std::size_t groups = (Problem<D>::functions + Multigrid<D>::width - 1) / Multigrid<D>::width;
    std::vector<cageform::Lanes<float>> rows(problem.nodes.count());
    for (auto& row : rows) std::fill(std::begin(row.v), std::end(row.v), 0.0f);
    for (auto _ : state) {
        for (std::size_t group = 0; group < groups; ++group) {
            for (auto& row : rows) {
                for (float& x : row.v) x += 1;
            }
            benchmark::ClobberMemory();
        }
    }
    state.counters["unknowns"] = double(problem.nodes.count());
}

/// Arcs across the unit square with a colour and an opacity at their ends: four channels.
std::vector<cageform::Stroke<float>> arcs() {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::vector<cageform::Stroke<float>> strokes(100);
    for (auto& stroke : strokes) {
        const Vec<float, 2> centre{0.15f + 0.7f * uniform(random), 0.15f + 0.7f * uniform(random)};
        const float radius = 0.02f + 0.12f * uniform(random), first = 6.28f * uniform(random);
        constexpr int points = 40;
        for (int i = 0; i < points; ++i) {
            const float turn = first + 3 * float(i) / points;
            stroke.points.push_back(centre + radius * Vec<float, 2>{std::cos(turn), std::sin(turn)});
        }
        for (int i = 0; i < 4 * points; ++i) stroke.left.push_back(uniform(random));
        for (int i = 0; i < 4 * points; ++i) stroke.right.push_back(uniform(random));
    }
    return strokes;
}
constexpr cageform::Bounds<float, 2> canvas{{0, 0}, {1, 1}};

/// To 1e-6 and to 1e-3, which is below the resolution of eight bits per channel.
void strokes(benchmark::State& state) {
    const auto drawing = arcs();
    cageform::SolverReport report;
    for (auto _ : state) {
        cageform::Diffusion<float> field(canvas, std::size_t(state.range(0)), 4);
        for (const auto& stroke : drawing) {
            if (field.add(stroke) != cageform::Status::ok) state.SkipWithError("a stroke");
        }
        const auto solved = field.solve({.tolerance = state.range(1) == 6 ? 1e-6 : 1e-3});
        if (solved.status != cageform::Status::ok) state.SkipWithError(to_string(solved.status));
        report = solved.solver;
        benchmark::DoNotOptimize(field.field(3).data());
    }
    state.counters["unknowns"] = double(report.cells);
    state.counters["cycles"] = double(report.multigrid.cycles);
}

/// Writes four channels of the canvas once.
void limit_write_canvas(benchmark::State& state) {
    std::vector<float> fields(4 * std::size_t(state.range(0)) * std::size_t(state.range(0)));
    float value = 0;
    for (auto _ : state) {
        std::fill(fields.begin(), fields.end(), value += 1);
        benchmark::ClobberMemory();
    }
}

#if defined(CAGEFORM_BENCH_CHOLMOD)
/// Solves the same strokes as marked cells, without flow through the border.
void cholmod_strokes(benchmark::State& state) {
    const int n = int(state.range(0));
    const auto size = std::size_t(n) * std::size_t(n);
    std::vector<std::array<float, 4>> data(size);
    std::vector<bool> given(size, false);
    for (const auto& stroke : arcs()) {
        for (std::size_t i = 0; i + 1 < stroke.points.size(); ++i) {
            for (int k = 0; k < 200; ++k) {
                const auto p =
                    stroke.points[i] + (float(k) / 200) * (stroke.points[i + 1] - stroke.points[i]);
                const std::size_t cell =
                    std::size_t(p[1] * float(n)) * std::size_t(n) + std::size_t(p[0] * float(n));
                given[cell] = true;
                std::copy_n(stroke.left.begin() + std::ptrdiff_t(4 * i), 4, data[cell].begin());
            }
        }
    }
    std::vector<int> number(size, -1);
    int count = 0;
    for (std::size_t cell = 0; cell < size; ++cell) {
        if (!given[cell]) number[cell] = count++;
    }
    for (auto _ : state) {
        std::vector<Eigen::Triplet<double>> entries;
        Eigen::MatrixXd right = Eigen::MatrixXd::Zero(count, 4);
        for (std::size_t cell = 0; cell < size; ++cell) {
            if (number[cell] < 0) continue;
            const int i = number[cell], x = int(cell % std::size_t(n)), y = int(cell / std::size_t(n));
            double diagonal = 0;
            for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
                if (x + dx < 0 || x + dx >= n || y + dy < 0 || y + dy >= n) continue;
                const std::size_t other = std::size_t(y + dy) * std::size_t(n) + std::size_t(x + dx);
                ++diagonal;
                if (number[other] > i) entries.emplace_back(number[other], i, -1.0);
                for (int c = 0; number[other] < 0 && c < 4; ++c)
                    right(i, c) += double(data[other][std::size_t(c)]);
            }
            entries.emplace_back(i, i, diagonal);
        }
        Eigen::SparseMatrix<double> a(count, count);
        a.setFromTriplets(entries.begin(), entries.end());
        const Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor(a);
        if (factor.info() != Eigen::Success) state.SkipWithError("not factorised");
        const Eigen::MatrixXd solution = factor.solve(right);
        benchmark::DoNotOptimize(solution.data());
    }
    state.counters["unknowns"] = double(count);
}
BENCHMARK(cholmod_strokes)->ArgName("n")->Arg(1024)->Unit(benchmark::kMillisecond);
#endif

void grids_2d(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"n", "threads"})->Unit(benchmark::kMillisecond)->UseRealTime();
    for (const int n : {256, 1024}) benchmark->Args({n, 1});
    for (const int threads : {2, 4}) benchmark->Args({1024, threads});
}
void grids_3d(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"n", "threads"})->Unit(benchmark::kMillisecond)->UseRealTime();
    for (const int n : {64, 128}) benchmark->Args({n, 1});
    for (const int threads : {2, 4}) benchmark->Args({128, threads});
}

} // namespace

BENCHMARK_TEMPLATE(multigrid, 2)->Apply(grids_2d);
BENCHMARK_TEMPLATE(multigrid, 3)->Apply(grids_3d);
BENCHMARK(strokes)
    ->ArgNames({"n", "digits"})
    ->Args({1024, 6})
    ->Args({1024, 3})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(limit_write_canvas)->ArgName("n")->Arg(1024)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(papers_sweeps, 2)->ArgName("n")->Arg(256)->Arg(1024)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(papers_sweeps, 3)->ArgName("n")->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(limit_move_solution, 2)->ArgName("n")->Arg(1024)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(limit_move_solution, 3)->ArgName("n")->Arg(128)->Unit(benchmark::kMillisecond);

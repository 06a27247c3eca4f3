// How long does `bind` take by harmonic coordinates, by points, handles, resolution and accuracy?
//
// Peers in 3D: the multigrid solve alone, the papers' solver, and mean value coordinates.
#include "../tests/support/cages.hpp"
#include "../tests/support/fingers.hpp"
#include "averaging/pyramid_solver.hpp"
#include "run_bind.hpp"
#include "workloads.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/cage/box_mesh.hpp>
#include <cageform/coordinates/harmonic/multigrid_solver.hpp>
#include <cageform/coordinates/harmonic/tree_solver.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>
#include <cageform/parallel/threads.hpp>

#include <ctime>
#include <map>
#include <numbers>
#include <sys/resource.h>

namespace {

using namespace cageform_bench;

/// Makes new coordinates each time, because they hold the solved planes of the faces.
template <VaseOf of>
void bind_harmonic_vase(benchmark::State& state) {
    const auto cage = vase<of, double>();
    const auto points = points_inside_vase();
    cageform::HarmonicOptions options;
    options.resolution = std::size_t(state.range(0));
    for (auto _ : state) {
        const auto result =
            cageform::bind(cageform::HarmonicCoordinates(cage, options, cageform::UniformGrid{}), points);
        benchmark::DoNotOptimize(result.value.view().weights.data);
        state.counters["solver_s"] = result.report.solver.seconds;
    }
    finish(state, points.size(), cage.size());
}

template <class T, class Solver>
void bind_harmonic(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    cageform::HarmonicOptions options;
    options.resolution = std::size_t(state.range(2));
    run_bind(state, cageform::HarmonicCoordinates<T, 2>(cage, options, Solver{}),
             points_inside(cage, std::size_t(state.range(0))));
}

/// A cube with 98 vertices (four divisions per axis) and 2,562 points on a sphere in it. Blender's Mesh
/// Deform binds this case with 32 cells, but takes minutes with 64.
void bind_harmonic_cube(benchmark::State& state) {
    const auto cube = cageform::box_mesh<double>({-1, -1, -1}, {1, 1, 1}, {4, 4, 4});
    std::vector<cageform::Vec<double, 3>> points;
    constexpr std::size_t count = 2562;
    for (std::size_t i = 0; i < count; ++i) { // a Fibonacci spiral
        const double z = 1 - 2 * (double(i) + 0.5) / double(count), r = std::sqrt(1 - z * z);
        const double t = double(i) * std::numbers::pi * (3 - std::sqrt(5.0));
        points.push_back({0.8 * r * std::cos(t), 0.8 * r * std::sin(t), 0.8 * z});
    }
    cageform::HarmonicOptions options;
    options.resolution = std::size_t(state.range(0));
    run_bind(state, cageform::HarmonicCoordinates(cube, options, cageform::UniformGrid{}), points);
}

/// Equations of the harmonic functions of a mesh, for the multigrid solver alone.
struct MeshProblem {
    MeshProblem(const cageform::TriangleMesh<double>& cage, const cageform::HarmonicOptions& options)
        : input(cage, check(cage), options) {
        cageform::SolverReport report;
        (void)cageform::detail::EmbeddedCage<3>::make(input, report, grid);
    }

    /// Solves for all functions; each block overwrites the last one. Returns the maximum number of cycles.
    std::size_t solve() const {
        const cageform::grid::Multigrid<3> multigrid(grid->problem().nodes, grid->problem().cuts, {});
        const auto slots = multigrid.source_slots();
        const auto fill = [&](std::size_t first, std::size_t count, auto& source) {
            grid->add_data(first, count, slots, std::span(source));
        };
        const cageform::grid::CycleGoal goal{input.handles, 1e-6, 60};
        cageform::SolverReport report;
        (void)solve_groups(cageform::grid::MultigridGroups{multigrid, goal, fill}, report,
                           [](std::size_t, const auto& block) { benchmark::DoNotOptimize(block.value(0)); });
        return report.multigrid.cycles;
    }

    cageform::SolverInput<3> input;
    std::optional<cageform::detail::EmbeddedCage<3>> grid;
};

/// Alternates with the solve alone (not timed), so that both run under the same load. bind/solve and its
/// inverse are ratios of processor time. solver_s is the solver's time reported by `bind`, including
/// sampling.
void bind_harmonic_mesh(benchmark::State& state) {
    const auto cage = bumpy112<double>();
    const auto points = points_inside_bumpy112();
    cageform::HarmonicOptions options;
    options.resolution = std::size_t(state.range(0));
    const cageform::HarmonicCoordinates coordinates(cage, options, cageform::UniformGrid{});
    const MeshProblem problem(cage, options);
    cageform::SolverReport solver;
    double solver_seconds = 0;
    std::clock_t binding = 0, solving = 0;
    for (auto _ : state) {
        const auto begin = std::clock();
        const auto result = cageform::bind(coordinates, points);
        benchmark::DoNotOptimize(result.value.view().weights.data);
        const auto bound = std::clock();
        state.PauseTiming();
        solver = result.report.solver;
        solver_seconds += solver.seconds;
        const std::size_t cycles = problem.solve();
        if (!result) state.SkipWithError(to_string(result.status()));
        if (cycles != solver.multigrid.cycles || problem.grid->problem().nodes.count() != solver.cells)
            state.SkipWithError("the separate solve has another problem");
        solving += std::clock() - bound;
        binding += bound - begin;
        state.ResumeTiming();
    }
    finish(state, points.size(), cage.size());
    state.counters["bind/solve"] = double(binding) / double(solving);
    state.counters["solve_share"] = double(solving) / double(binding);
    state.counters["solver_s"] = benchmark::Counter(solver_seconds, benchmark::Counter::kAvgIterations);
    state.counters["MB"] = double(solver.bytes) / 1e6;
    state.counters["cycles"] = double(solver.multigrid.cycles);
    state.counters["unknowns"] = double(solver.cells);
}

/// Binds the same mesh by the papers' solver and settings: float, one function at a time, sweeps to a mean
/// change of 1e-5, nearest-cell lookup. Joshi et al. 2007, table 1: 262 s, where mean value coordinates took
/// 443 s.
void bind_papers_mesh(benchmark::State& state) {
    using namespace cageform_sources::averaging;
    const auto cage = bumpy112<float>();
    std::vector<cageform::Vec<float, 3>> points;
    for (const auto& p : points_inside_bumpy112()) points.push_back(cageform::vec_cast<float>(p));
    cageform::HarmonicOptions options;
    options.resolution = std::size_t(state.range(0));
    const AveragingSolver solver{
        .sweeps = {.tolerance = 1e-5}, .interpolation = Interpolation::nearest_cell, .handles_at_once = 1};
    const cageform::HarmonicCoordinates coordinates(cage, options, solver);
    cageform::BindReport report;
    for (auto _ : state) {
        const auto result = cageform::bind(coordinates, points);
        benchmark::DoNotOptimize(result.value.view().weights.data);
        report = result.report;
        if (report.status != cageform::Status::ok) state.SkipWithError(to_string(report.status));
    }
    finish(state, points.size(), cage.size());
    const auto lattice = lattice_about(cageform::bounds_of(cage.vertices()), options.resolution);
    state.counters["solver_s"] = report.solver.seconds;
    state.counters["MB"] = double(report.solver.bytes) / 1e6;
    state.counters["bytes/cell"] = double(report.solver.bytes) / double(lattice.size());
    state.counters["sweeps"] = double(report.solver.relaxation.sweeps) / double(cage.size());
    state.counters["residual/h"] = report.residual_restored.value / double(lattice.spacing);
    state.counters["unknowns"] = double(report.solver.cells);
}

using cageform_tests::Fingers;

using Mesh = cageform::TriangleMesh<double>;
using Harmonic = cageform::HarmonicCoordinates<double, 3>;

/// On the adaptive grid with an accuracy of 1e-4 times the argument, or on the uniform grid of a resolution.
template <bool adaptive>
Harmonic harmonic(const Mesh& cage, const benchmark::State& state) {
    if (adaptive) return Harmonic(cage, {.accuracy = 1e-4 * double(state.range(0))});
    return Harmonic(cage, {.resolution = std::size_t(state.range(0))}, cageform::UniformGrid{});
}

/// A bind and its costs; solver_s is the time of cycles and sampling, without the grid.
cageform::Binding<double, 3> bind_on_grid(benchmark::State& state, const Harmonic& coordinates,
                                          const std::vector<cageform::Vec<double, 3>>& points,
                                          const cageform::Running& running = {}) {
    auto [binding, report] = cageform::bind(coordinates, points, {}, running);
    if (report.status != cageform::Status::ok) state.SkipWithError(to_string(report.status));
    state.counters["handles"] = double(coordinates.handles().size());
    state.counters["nodes"] = double(report.solver.cells);
    state.counters["solver_s"] = report.solver.seconds;
    state.counters["MB"] = double(report.solver.bytes) / 1e6;
    return std::move(binding);
}

/// Maximum weight error at the reference points, and costs.
template <bool adaptive>
void bind_fingers(benchmark::State& state) {
    static const Fingers fingers(CAGEFORM_BENCH_FINGERS);
    const auto coordinates = harmonic<adaptive>(Mesh(fingers.vertices, fingers.faces), state);
    for (auto _ : state) {
        const auto binding = bind_on_grid(state, coordinates, fingers.points);
        double error = 0;
        for (std::size_t i = 0; i < binding.point_count(); ++i) {
            for (std::size_t h = 0; h < binding.handle_count(); ++h)
                error = std::max(error, std::fabs(binding.weight(i, h) - fingers.weights[i][h]));
        }
        state.counters["error"] = error;
    }
}

/// Binds the cage with its hands scaled by 1 / argument, to an accuracy of 2e-3: the cost of finer parts.
void bind_smaller_fingers(benchmark::State& state) {
    static const Fingers fingers(CAGEFORM_BENCH_FINGERS);
    auto vertices = fingers.vertices;
    for (auto& p : vertices) { // before the rotation, the hands begin at x = ±70
        const auto before = cageform_tests::turned_about_123(p, -1);
        const double side = before[0] < 0 ? -1 : 1, size = 1 / double(state.range(0));
        if (side * before[0] <= 70.5) continue;
        const cageform::Vec<double, 3> wrist{70 * side, 138.5, 0};
        p = cageform_tests::turned_about_123(wrist + size * (before - wrist), 1);
    }
    const Harmonic coordinates(Mesh(vertices, fingers.faces), {.accuracy = 2e-3});
    for (auto _ : state)
        benchmark::DoNotOptimize(bind_on_grid(state, coordinates, fingers.points).view().weights.data);
}

/// With several threads, for the grid and for the functions.
void bind_fingers_threads(benchmark::State& state) {
    static const Fingers fingers(CAGEFORM_BENCH_FINGERS);
    const Harmonic coordinates(Mesh(fingers.vertices, fingers.faces), {.accuracy = 2e-3});
    const cageform::ThreadedFor threads{unsigned(state.range(0))};
    for (auto _ : state)
        benchmark::DoNotOptimize(
            bind_on_grid(state, coordinates, fingers.points, {.parallel = threads}).view().weights.data);
}

/// Binds thousands of points inside the finger cage, near its skin, to a packed binding of half floats
/// without weights below 1e-4. peak_MB is the peak of the process so far.
void pack_fingers(benchmark::State& state) {
    static const Fingers fingers(CAGEFORM_BENCH_FINGERS);
    const Mesh cage(fingers.vertices, fingers.faces);
    std::vector<cageform::Vec<float, 3>> vertices, points;
    for (const auto& v : fingers.vertices) vertices.push_back(cageform::vec_cast<float>(v));
    cageform_tests::Random random(7);
    const std::size_t count = std::size_t(state.range(0)) * 1000;
    while (points.size() < count) {
        const auto& face = fingers.faces[random.below(fingers.faces.size())];
        double u = random.uniform(0, 1), v = random.uniform(0, 1);
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        const auto &a = fingers.vertices[std::size_t(face[0])], &b = fingers.vertices[std::size_t(face[1])],
                   &c = fingers.vertices[std::size_t(face[2])];
        const auto normal = cross(b - a, c - a);
        const auto p = a + u * (b - a) + v * (c - a) -
                       (random.uniform(0.01, 0.15) / cageform::detail::length(normal)) * normal;
        points.push_back(cageform::vec_cast<float>(p));
    }
    const cageform::HarmonicCoordinates<float, 3> coordinates(vertices, fingers.faces, {.accuracy = 2e-3});
    const cageform::StreamedPackOptions options{
        .pack = {.format = cageform::WeightFormat::half, .threshold = 1e-4}};
    const auto stated = cageform::pack_memory(coordinates, points.size(), options);
    for (auto _ : state) {
        const auto result = cageform::pack(coordinates, points, options);
        if (!result) state.SkipWithError(to_string(result.status()));
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        state.counters["peak_MB"] = double(usage.ru_maxrss) / 1e3;
        state.counters["stated_MB"] = double(stated.solver + stated.functions + stated.batch) / 1e6;
        state.counters["blob_MB"] = double(result.report.packed.bytes) / 1e6;
        state.counters["dense_MB"] = double(result.report.packed.dense_bytes) / 1e6;
        state.counters["weights"] = result.report.packed.weights_per_point;
        state.counters["distance/size"] = result.report.packed.distance.value / result.report.packed.size;
        state.counters["mean_distance/size"] = result.report.packed.mean_distance / result.report.packed.size;
        state.counters["outside"] = double(result.report.bound.outside.size());
        state.counters["solver_s"] = result.report.bound.solver.seconds;
    }
}

/// BUMPY112, for which a uniform grid works well. Errors of the weights at the 8,019 points (maximum, middle
/// point) against a grid of 256 cells. That reference differs from one of 384 cells by at most 4e-3, 5e-5 at
/// the middle point.
template <bool adaptive>
void bind_bumpy(benchmark::State& state) {
    static const auto points = points_inside_bumpy112();
    static const auto fine =
        cageform::bind(Harmonic(bumpy112<double>(), {.resolution = 256}, cageform::UniformGrid{}), points)
            .value;
    const auto coordinates = harmonic<adaptive>(bumpy112<double>(), state);
    for (auto _ : state) {
        const auto binding = bind_on_grid(state, coordinates, points);
        state.PauseTiming();
        std::vector<double> errors(points.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            for (std::size_t h = 0; h < binding.handle_count(); ++h)
                errors[i] = std::max(errors[i], std::fabs(binding.weight(i, h) - fine.weight(i, h)));
        }
        std::sort(errors.begin(), errors.end());
        state.counters["error"] = errors.back();
        state.counters["middle_error"] = errors[errors.size() / 2];
        state.ResumeTiming();
    }
}

/// BUMPY112 with each face split into four, argument times, bound to an accuracy of 2e-3: the cost of
/// handles.
void bind_divided_bumpy(benchmark::State& state) {
    const auto whole = bumpy112<double>();
    std::vector<cageform::Vec<double, 3>> vertices(whole.vertices().begin(), whole.vertices().end());
    std::vector<std::array<std::uint32_t, 3>> faces(whole.faces().begin(), whole.faces().end());
    for (int n = 0; n < state.range(0); ++n) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [at, added] = middles.insert({std::minmax(a, b), std::uint32_t(vertices.size())});
            if (added) vertices.push_back(0.5 * (vertices[a] + vertices[b]));
            return at->second;
        };
        std::vector<std::array<std::uint32_t, 3>> finer;
        for (const auto& [a, b, c] : faces) {
            const auto ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        faces = std::move(finer);
    }
    const auto points = points_inside_bumpy112();
    const Harmonic coordinates(Mesh(vertices, faces), {.accuracy = 2e-3});
    for (auto _ : state)
        benchmark::DoNotOptimize(bind_on_grid(state, coordinates, points).view().weights.data);
}

/// Points, normals and tangents of as many vertices as the puppet of examples/make_character, on a surface in
/// BUMPY112. bind/solve is a ratio of processor times; `solve` alone is not timed.
void bind_harmonic_figure(benchmark::State& state) {
    const auto cage = bumpy112<float>();
    std::vector<cageform::Vec<float, 3>> points, normals;
    constexpr std::size_t count = 8066;
    for (std::size_t i = 0; i < count; ++i) { // a Fibonacci spiral, two thirds of the way to the cage
        const double z = 1 - 2 * (double(i) + 0.5) / double(count), r = std::sqrt(1 - z * z);
        const double t = double(i) * std::numbers::pi * (3 - std::sqrt(5.0)), theta = std::acos(z);
        const double size = 2.0 / 3 * (1 + 0.35 * std::cos(3 * theta) + 0.25 * r * std::cos(4 * t));
        normals.push_back({float(r * std::cos(t)), float(r * std::sin(t)), float(z)});
        points.push_back(float(size) * normals.back());
    }
    cageform::HarmonicOptions options;
    options.resolution = std::size_t(state.range(0));
    const cageform::HarmonicCoordinates<float, 3> coordinates(cage, options, cageform::UniformGrid{});
    std::clock_t binding = 0, solving = 0;
    for (auto _ : state) {
        const auto begin = std::clock();
        const auto result = cageform::bind(coordinates, cageform::FigurePoints{points, normals});
        benchmark::DoNotOptimize(result.value.points.view().weights.data);
        const auto bound = std::clock();
        state.PauseTiming();
        if (!result) state.SkipWithError(to_string(result.status()));
        auto solved = coordinates;
        if (solved.solve().status != cageform::Status::ok) state.SkipWithError("the separate solve failed");
        solving += std::clock() - bound;
        binding += bound - begin;
        state.ResumeTiming();
    }
    finish(state, points.size(), cage.size());
    state.counters["bind/solve"] = double(binding) / double(solving);
}

/// Harmonic against mean value coordinates for many points: the papers expect harmonic coordinates to be
/// faster. Binds 10² to 10⁶ points in BUMPY112 into recycled memory. The second argument is the number of
/// cells of the harmonic grid; 0: mean value. All rows:
///
///     bench_bind --benchmark_filter=crossing
void crossing_of_types(benchmark::State& state) {
    const auto cage = bumpy112<float>();
    const auto points = points_inside(bumpy112<double>(), std::size_t(state.range(0)), 2);
    if (state.range(1) == 0) {
        run_bind(state, cageform::MeanValueCoordinates<float, 3>(cage), points, true);
    } else {
        cageform::HarmonicOptions options;
        options.resolution = std::size_t(state.range(1));
        run_bind(state, cageform::HarmonicCoordinates<float, 3>(cage, options, cageform::UniformGrid{}),
                 points, true);
    }
}

void points_and_cells(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "cells"})->Unit(benchmark::kMillisecond);
    for (const int cells : {0, 64, 128}) {
        for (int points = 100; points <= 1'000'000; points *= 10) benchmark->Args({points, cells});
    }
}
void growing_grid(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "handles", "resolution"})->Unit(benchmark::kMillisecond);
    for (const int resolution : {64, 128, 256, 512, 1024}) benchmark->Args({10000, 25, resolution});
    for (const int handles : {8, 50, 100}) benchmark->Args({10000, handles, 256});
}
void threads(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgName("threads")->Arg(1)->Arg(2)->Arg(4)->Unit(benchmark::kMillisecond)->UseRealTime();
}

} // namespace

BENCHMARK_TEMPLATE(bind_harmonic_vase, VaseOf::polygons)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_harmonic_vase, VaseOf::triangles)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_harmonic, double, cageform::UniformGrid)->Apply(growing_grid);
BENCHMARK_TEMPLATE(bind_harmonic, double, cageform_sources::averaging::AveragingSolver)->Apply(growing_grid);
BENCHMARK(bind_harmonic_cube)
    ->ArgName("resolution")
    ->Arg(32)
    ->Arg(64)
    ->Arg(128)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(bind_harmonic_mesh)->ArgName("resolution")->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK(bind_papers_mesh)->ArgName("resolution")->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_fingers, true)
    ->ArgName("accuracy_e-4")
    ->Arg(50)
    ->Arg(20)
    ->Arg(10)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_fingers, false)->ArgName("resolution")->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK(bind_smaller_fingers)->ArgName("times")->Arg(1)->Arg(2)->Arg(4)->Unit(benchmark::kMillisecond);
BENCHMARK(pack_fingers)
    ->ArgName("thousand_points")
    ->Arg(100)
    ->Arg(1000)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(bind_fingers_threads)->Apply(threads);
BENCHMARK_TEMPLATE(bind_bumpy, true)
    ->ArgName("accuracy_e-4")
    ->Arg(100)
    ->Arg(50)
    ->Arg(20)
    ->Arg(10)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_bumpy, false)
    ->ArgName("resolution")
    ->Arg(16)
    ->Arg(32)
    ->Arg(64)
    ->Arg(128)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(bind_divided_bumpy)->ArgName("times")->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);
BENCHMARK(crossing_of_types)->Apply(points_and_cells);
BENCHMARK(bind_harmonic_figure)->ArgName("resolution")->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);

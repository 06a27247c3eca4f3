// How long does a bind take, against points and handles, for each coordinate type?
//
// Beside mean value: the plain textbook loop (no boundary cases, no report), and the time it takes to merely
// write as many weights, which no bind can beat.
#include "workloads.hpp"

#include <cageform/cageform.hpp>

#include <benchmark/benchmark.h>

namespace {

using namespace cageform_bench;

void finish(benchmark::State& state, std::size_t points) {
    state.counters["points/s"] =
        benchmark::Counter(double(points), benchmark::Counter::kIsIterationInvariantRate);
    state.SetComplexityN(std::int64_t(points));
}

/// `again` binds into the memory of the bind before, as an editor does; else every bind takes new memory.
template <class Coordinates, class Points>
void run_bind(benchmark::State& state, const Coordinates& coordinates, const Points& points,
              bool again = false) {
    cageform::Binding<typename Coordinates::scalar, Coordinates::dimension> recycled;
    if (again) recycled = cageform::bind(coordinates, points).binding;
    for (auto _ : state) {
        auto result = cageform::bind(coordinates, points, {}, std::move(recycled));
        if (result.report.status != cageform::Status::ok)
            state.SkipWithError(to_string(result.report.status));
        benchmark::DoNotOptimize(result.binding.view().weights.data);
        benchmark::ClobberMemory();
        recycled = again ? std::move(result.binding) : decltype(recycled){};
    }
    finish(state, points.size());
}

template <class T>
void bind_barycentric(benchmark::State& state) {
    const std::vector<Point> triangle{{0, 0}, {3, 0}, {0, 3}};
    run_bind(state, cageform::BarycentricCoordinates<T, 2>(triangle),
             points_inside(triangle, std::size_t(state.range(0))));
}

template <class T>
void bind_mean_value(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    run_bind(state, cageform::MeanValueCoordinates<T, 2>(cage),
             points_inside(cage, std::size_t(state.range(0))));
}

template <class T>
void bind_mean_value_again(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    run_bind(state, cageform::MeanValueCoordinates<T, 2>(cage),
             points_inside(cage, std::size_t(state.range(0))), true);
}

/// The weights alone: no checks of points, no report, no restored precision; as one would call it in a batch.
template <class T>
void evaluate_mean_value(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    const auto points = points_inside(cage, std::size_t(state.range(0)));
    const cageform::MeanValueCoordinates<T, 2> coordinates(cage);
    const std::size_t blocks = cageform::block_count<T>(points.size());
    std::vector<cageform::Lanes<T>> rest(blocks * 2), weights(blocks * cage.size());
    const cageform::BlockView<T> rest_view{rest.data(), 2, points.size()};
    const cageform::BlockView<T> weight_view{weights.data(), cage.size(), points.size()};
    for (std::size_t i = 0; i < blocks * cageform::lane_count<T>; ++i) {
        for (std::size_t k = 0; k < 2; ++k) rest_view(i, k) = T(points[std::min(i, points.size() - 1)][k]);
    }
    std::vector<cageform::PointState> states(points.size());
    for (auto& lanes : weights) lanes[0] = T(0); // the system hands out memory when it is first written
    for (auto _ : state) {
        const auto evaluation = coordinates.evaluate(rest_view, weight_view, states);
        if (evaluation.status != cageform::Status::ok) state.SkipWithError(to_string(evaluation.status));
        benchmark::ClobberMemory();
    }
    finish(state, points.size());
}

void plain_mean_value(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    const auto points = points_inside(cage, std::size_t(state.range(0)));
    const std::size_t m = cage.size();
    std::vector<double> weights(points.size() * m), x(m), y(m), r(m), t(m);
    for (auto _ : state) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            for (std::size_t k = 0; k < m; ++k) {
                x[k] = cage[k][0] - points[i][0];
                y[k] = cage[k][1] - points[i][1];
                r[k] = std::sqrt(x[k] * x[k] + y[k] * y[k]);
            }
            for (std::size_t k = 0; k < m; ++k) {
                const std::size_t n = k + 1 < m ? k + 1 : 0;
                t[k] = (x[k] * y[n] - y[k] * x[n]) / (r[k] * r[n] + x[k] * x[n] + y[k] * y[n]);
            }
            double* const w = &weights[i * m];
            double sum = 0;
            for (std::size_t k = 0; k < m; ++k) {
                w[k] = (t[k > 0 ? k - 1 : m - 1] + t[k]) / r[k];
                sum += w[k];
            }
            for (std::size_t k = 0; k < m; ++k) w[k] /= sum;
        }
        benchmark::ClobberMemory();
    }
    finish(state, points.size());
}

/// Writing as many weights as a bind does: into new memory, or (again) into memory in use.
void limit_write_weights(benchmark::State& state, bool again) {
    const std::size_t count = std::size_t(state.range(0) * state.range(1));
    double value = 1;
    std::vector<cageform::Lanes<double>> weights(cageform::block_count<double>(count));
    for (auto& lanes : weights) lanes[0] = value;
    for (auto _ : state) {
        if (!again) weights = std::vector<cageform::Lanes<double>>();
        weights.resize(cageform::block_count<double>(count));
        value += 1;
        for (auto& lanes : weights) {
            for (double& w : lanes.v) w = value;
        }
        benchmark::DoNotOptimize(weights.data());
        benchmark::ClobberMemory();
    }
    finish(state, std::size_t(state.range(0)));
}

template <class T, cageform::HarmonicSolver Solver>
void bind_harmonic(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    cageform::HarmonicOptions options;
    options.solver = Solver;
    options.resolution = std::size_t(state.range(2));
    options.averaging.tolerance = 1e-5;
    run_bind(state, cageform::HarmonicCoordinates<T, 2>(cage, options),
             points_inside(cage, std::size_t(state.range(0))));
}

/// A cube of 98 vertices (four divisions along each axis) and 2,562 points on a sphere in it: the case that Blender's Mesh
/// Deform binds at 32 cells and not in minutes at 64.
void bind_harmonic_cube(benchmark::State& state) {
    const cageform::Box<double> cube({-1, -1, -1}, {1, 1, 1}, {4, 4, 4});
    std::vector<cageform::Vec<double, 3>> points;
    constexpr std::size_t count = 2562;
    for (std::size_t i = 0; i < count; ++i) { // a Fibonacci spiral
        const double z = 1 - 2 * (double(i) + 0.5) / double(count), r = std::sqrt(1 - z * z);
        const double t = double(i) * std::numbers::pi * (3 - std::sqrt(5.0));
        points.push_back({0.8 * r * std::cos(t), 0.8 * r * std::sin(t), 0.8 * z});
    }
    cageform::HarmonicOptions options;
    options.resolution = std::size_t(state.range(0));
    run_bind(state, cageform::HarmonicCoordinates(cube, options), points);
}

void points_and_handles(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "handles"});
    for (const int points : {152, 10000, 1000000}) benchmark->Args({points, 25});
    for (const int points : {152, 10000, 100000}) benchmark->Args({points, 100});
    benchmark->Unit(benchmark::kMicrosecond);
}
void growing_points(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "handles"})->Unit(benchmark::kMicrosecond)->Complexity();
    for (int points = 1000; points <= 64000; points *= 4) benchmark->Args({points, 25});
}
void growing_grid(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "handles", "resolution"})->Unit(benchmark::kMillisecond);
    for (const int resolution : {64, 128, 256, 512, 1024}) benchmark->Args({10000, 25, resolution});
    for (const int handles : {8, 50, 100}) benchmark->Args({10000, handles, 256});
}

} // namespace

BENCHMARK_TEMPLATE(bind_barycentric, float)->Arg(10000)->Arg(1000000)->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(bind_barycentric, double)->Arg(10000)->Arg(1000000)->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(bind_mean_value, double)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_mean_value, float)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_mean_value_again, double)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_mean_value_again, float)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_mean_value, double)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_mean_value, float)->Apply(points_and_handles);
BENCHMARK(plain_mean_value)->Apply(points_and_handles);
BENCHMARK_CAPTURE(limit_write_weights, new, false)->Apply(points_and_handles);
BENCHMARK_CAPTURE(limit_write_weights, again, true)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_mean_value, double)->Name("bind_mean_value growth")->Apply(growing_points);
BENCHMARK_TEMPLATE(bind_harmonic, double, cageform::HarmonicSolver::multigrid)->Apply(growing_grid);
BENCHMARK_TEMPLATE(bind_harmonic, double, cageform::HarmonicSolver::averaging_pyramid)->Apply(growing_grid);
BENCHMARK(bind_harmonic_cube)
    ->ArgName("resolution")
    ->Arg(32)
    ->Arg(64)
    ->Arg(128)
    ->Unit(benchmark::kMillisecond);

// Key-frame curves: fits them, and evaluates many at one time. Peer: solving the cubic at every evaluation.
#include "curve_comparators.hpp"

#include <cageform/animate/compile.hpp>
#include <cageform/clip/curves/curve_bank.hpp>
#include <cageform/parallel/threads.hpp>

#include <benchmark/benchmark.h>

#include <random>

namespace {

using namespace cageform;
using namespace cageform_bench;

/// A Bézier key interval from (0, 0) to (1, 1) with random handles in the interval and values in [-1, 2].
std::vector<BezierCurve> random_curves(std::size_t count) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> time(0, 1), value(-1, 2);
    std::vector<BezierCurve> curves;
    while (curves.size() < count) {
        const BezierCurve curve{
            {{{0, 0}, {time(random), value(random)}, {time(random), value(random)}, {1, 1}}}};
        if (check(curve).status == Status::ok) curves.push_back(curve);
    }
    return curves;
}

/// One key per second, random handles in their intervals.
std::vector<Key> random_keys(std::size_t count, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> time(0, 1), value(-1, 2);
    std::vector<Key> keys(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double at = double(i);
        keys[i].time = at;
        keys[i].value = value(random);
        keys[i].kind = KeyKind::bezier;
        keys[i].in_handle = {at - time(random), value(random)};
        keys[i].out_handle = {at + time(random), value(random)};
    }
    return keys;
}

/// All coordinates of a 112-vertex cage over ten seconds, fitted to one pixel of 1920.
constexpr std::size_t curves_of_cage = 112 * 3, seconds = 10;
template <class T>
std::vector<PiecewiseCubic<T>> cage_curves() {
    std::vector<PiecewiseCubic<T>> curves;
    for (std::uint32_t k = 0; k < curves_of_cage; ++k)
        curves.push_back(compile<T>(random_keys(seconds + 1, k)).value.curve);
    return curves;
}
/// Curves as functions of time, solved for the parameter.
template <class Function>
std::vector<std::vector<Function>> cage_functions() {
    std::vector<std::vector<Function>> curves(curves_of_cage);
    for (std::uint32_t k = 0; k < curves_of_cage; ++k) {
        const auto keys = random_keys(seconds + 1, k);
        for (std::size_t i = 0; i < seconds; ++i) curves[k].emplace_back(key_interval(keys, i));
    }
    return curves;
}

void finish(benchmark::State& state, std::size_t values) {
    state.counters["per_value"] =
        benchmark::Counter(double(state.iterations()) * double(values),
                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// Fewest pieces within 1/1024.
void fit_to_tolerance(benchmark::State& state) {
    const auto curves = random_curves(1000);
    std::size_t pieces = 0;
    for (auto _ : state) {
        pieces = 0;
        for (const auto& curve : curves) pieces += fit(curve, 1.0 / 1024).value.pieces();
    }
    finish(state, curves.size());
    state.counters["pieces"] = double(pieces) / double(curves.size());
}

void compile_million_keys(benchmark::State& state) {
    const auto keys = random_keys(1000000, 1);
    for (auto _ : state) {
        int calls = 0;
        TrackOptions options;
        options.tolerance = 1.0 / 1024;
        Running running;
        running.progress = [&](double) { return ++calls > 0; };
        const auto track = compile<double>(keys, options, running);
        if (!track) state.SkipWithError(to_string(track.status()));
        state.counters["progress_calls"] = calls;
    }
    finish(state, keys.size());
}

/// All curves of a cage, with several threads.
void compile_cage(benchmark::State& state) {
    std::vector<std::vector<Key>> keys;
    for (std::uint32_t k = 0; k < curves_of_cage; ++k) keys.push_back(random_keys(seconds + 1, k));
    const ThreadedFor threads{unsigned(state.range(0))};
    for (auto _ : state) {
        const auto clip = compile<float, 3>(keys, {}, {.parallel = threads});
        if (!clip) state.SkipWithError(to_string(clip.status()));
        benchmark::DoNotOptimize(clip.report.sup_error);
    }
    finish(state, curves_of_cage * seconds);
}

/// At sixty frames per second, or at random times.
template <class T, bool forward>
void bank(benchmark::State& state) {
    const CurveBank<T> curves(cage_curves<T>());
    auto cursor = curves.make_cursor();
    std::vector<T> out(curves.size());
    std::mt19937 random(3);
    std::uniform_real_distribution<T> anywhere(0, T(seconds));
    std::size_t frame = 0;
    for (auto _ : state) {
        curves.sample(forward ? T(frame++ % (60 * seconds)) / 60 : anywhere(random), cursor, out);
        benchmark::DoNotOptimize(out.data());
        benchmark::ClobberMemory();
    }
    finish(state, curves.size());
    state.counters["bytes"] = double(curves.bytes());
}
template <class Function>
void solved(benchmark::State& state) {
    const auto curves = cage_functions<Function>();
    std::vector<double> out(curves.size());
    std::size_t frame = 0;
    for (auto _ : state) {
        const double x = double(frame++ % (60 * seconds)) / 60;
        for (std::size_t k = 0; k < curves.size(); ++k) out[k] = curves[k][std::size_t(x)](x);
        benchmark::DoNotOptimize(out.data());
        benchmark::ClobberMemory();
    }
    finish(state, curves.size());
}

/// One curve at a random time; a single key interval needs no search.
template <class Evaluate>
void run_single(benchmark::State& state, const Evaluate& evaluate, std::size_t curves) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> anywhere(0, 1);
    std::vector<double> times(4096);
    for (double& x : times) x = anywhere(random);
    std::size_t n = 0;
    for (auto _ : state) {
        double sum = 0;
        for (const double x : times) sum += evaluate(n++ % curves, x);
        benchmark::DoNotOptimize(sum);
    }
    finish(state, times.size());
}
void single_pieces(benchmark::State& state) {
    std::vector<PiecewiseCubic<double>> pieces;
    for (const auto& curve : random_curves(64)) {
        const BezierFit fitted = fit(curve, screen_tolerance).value;
        std::vector<CubicPiece<double>> cubics;
        for (std::size_t i = 0; i < fitted.pieces(); ++i) cubics.push_back(cubic_piece<double>(fitted, i));
        pieces.emplace_back(std::move(cubics), 1.0);
    }
    run_single(state, [&](std::size_t k, double x) { return pieces[k](x); }, pieces.size());
}
template <class Function>
void single_solved(benchmark::State& state) {
    std::vector<Function> functions;
    for (const auto& curve : random_curves(64)) functions.emplace_back(curve);
    run_single(state, [&](std::size_t k, double x) { return functions[k](x); }, functions.size());
}

BENCHMARK(fit_to_tolerance)->Unit(benchmark::kMillisecond);
BENCHMARK(compile_million_keys)->Unit(benchmark::kSecond)->Iterations(1);
BENCHMARK(compile_cage)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Arg(4)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_TEMPLATE(bank, float, true)->Name("bank<float>/forward");
BENCHMARK_TEMPLATE(bank, double, true)->Name("bank<double>/forward");
BENCHMARK_TEMPLATE(bank, float, false)->Name("bank<float>/anywhere");
BENCHMARK_TEMPLATE(bank, double, false)->Name("bank<double>/anywhere");
BENCHMARK_TEMPLATE(solved, NewtonFunction);
BENCHMARK_TEMPLATE(solved, ClosedFormFunction);
BENCHMARK_TEMPLATE(solved, BezierFunction);
BENCHMARK(single_pieces);
BENCHMARK_TEMPLATE(single_solved, NewtonFunction);
BENCHMARK_TEMPLATE(single_solved, ClosedFormFunction);

} // namespace

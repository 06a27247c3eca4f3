// Frames of a PoseSolver for 25 to 762 handles: one iteration; a click (set_pins); a click and the first
// frame; the samples and their bytes. The limit is the arithmetic alone.
//
// fit: a pose of BUMPY112 recovered from 8,019 points by gradients (lesson 22). `missed` is the RMS distance
// of the points from their targets, relative to the figure's size.
#include "workloads.hpp"

#include <cageform/binding/pose_samples.hpp>
#include <cageform/clone/clone_transposed.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/pose/pose_solver.hpp>

#include <benchmark/benchmark.h>

namespace {

using cageform::MeanValueCoordinates;
using cageform::PoseOptions;
using cageform::PoseSampleOptions;
using cageform::PoseSolver;
using cageform::Status;
using cageform::Vec;

/// A cage with seven pins at samples of its inside; the last one is dragged.
template <class C>
class Drag {
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;

public:
    Drag(const C& coordinates, const PoseSampleOptions& sampling, const PoseOptions& options) {
        auto samples = pose_samples(coordinates, sampling);
        if (!samples) return;
        const std::size_t count = samples.value.points.size();
        for (std::size_t n = 0; n < 7; ++n) pins_.push_back(samples.value.points[(2 * n + 1) * count / 14]);
        auto bound = cageform::bind(coordinates, pins_);
        binding_ = std::move(bound.value);
        solver_ = PoseSolver<T, D>(std::move(samples.value), options);
        pose_.resize(solver_.samples().handle_count());
        if (!click()) pose_.clear();
    }
    bool is_good() const { return !pose_.empty(); }
    bool click() { return solver_.set_pins({.binding = binding_.view()}) == Status::ok; }
    /// One frame with a new position of the last pin.
    std::size_t frame() {
        auto targets = pins_;
        const T reach = T(0.1 * solver_.samples().size);
        targets.back()[0] += reach * T(1 + frames_ % 7) / 7;
        ++frames_;
        return solver_.solve(targets, pose_).iterations;
    }
    const cageform::PoseSamples<T, D>& samples() const { return solver_.samples(); }

private:
    std::vector<Vec<T, D>> pins_, pose_;
    cageform::Binding<T, D> binding_;
    PoseSolver<T, D> solver_;
    std::size_t frames_ = 0;
};

template <class T>
auto star_25() {
    std::vector<Vec<T, 2>> cage;
    for (const auto& p : cageform_bench::star(25)) cage.push_back(cageform::vec_cast<T>(p));
    return MeanValueCoordinates(cage);
}
template <class T>
auto bumpy() {
    return MeanValueCoordinates(cageform_bench::bumpy112<T>());
}
template <class T>
auto box_300() {
    return MeanValueCoordinates(cageform_bench::divided_box<T>({4, 7, 11}, 0.1));
}
template <class T>
auto box_762() {
    return MeanValueCoordinates(cageform_bench::divided_box<T>({10, 10, 14}, 0.1));
}

/// A frame of 32 iterations; one iteration is counted as 1/33 of it, because a last pass makes the report.
void iteration(benchmark::State& state, const auto& coordinates) {
    Drag drag(coordinates, {}, {.iterations = 32});
    if (!drag.is_good()) return state.SkipWithError("not posed");
    for (auto _ : state) benchmark::DoNotOptimize(drag.frame());
    const auto& samples = drag.samples();
    state.counters["handles"] = double(samples.handle_count());
    state.counters["rotations"] = double(samples.cluster_count);
    state.counters["kB"] = double(samples.bytes()) / 1000;
    state.counters["µs_iteration"] = benchmark::Counter(33e-6, benchmark::Counter::kIsIterationInvariantRate |
                                                                   benchmark::Counter::kInvert);
}
void frame(benchmark::State& state, const auto& coordinates) {
    Drag drag(coordinates, {}, {});
    if (!drag.is_good()) return state.SkipWithError("not posed");
    for (auto _ : state) benchmark::DoNotOptimize(drag.frame());
}
void click(benchmark::State& state, const auto& coordinates) {
    Drag drag(coordinates, {}, {});
    if (!drag.is_good()) return state.SkipWithError("not posed");
    for (auto _ : state) benchmark::DoNotOptimize(drag.click());
}
void first_frame(benchmark::State& state, const auto& coordinates) {
    Drag drag(coordinates, {}, {});
    if (!drag.is_good()) return state.SkipWithError("not posed");
    for (auto _ : state) {
        if (!drag.click()) state.SkipWithError("not clicked");
        benchmark::DoNotOptimize(drag.frame());
    }
    state.counters["kB_blob"] = double(pack(drag.samples()).value.bytes().size()) / 1000;
}
void sample(benchmark::State& state, const auto& coordinates) {
    for (auto _ : state) benchmark::DoNotOptimize(pose_samples(coordinates).value.stiffness.data());
}
/// As many multiply-adds as one iteration, 4 C H D² + 2 H² D operations, in registers alone.
void limit(benchmark::State& state, std::size_t handles, std::size_t rotations, std::size_t dimension) {
    using X = cageform::detail::Simd<float>;
    const std::size_t operations =
        4 * rotations * handles * dimension * dimension + 2 * handles * handles * dimension;
    const std::size_t steps = operations / (2 * 8 * cageform::lane_count<float>);
    X sums[8], factor(1.0000001f), term(1e-7f);
    for (auto& sum : sums) sum = X(1.0f);
    for (auto _ : state) {
        for (std::size_t n = 0; n < steps; ++n) {
            for (auto& sum : sums) sum = multiply_add(sum, factor, term);
        }
        benchmark::DoNotOptimize(sums);
    }
}

/// Conjugate gradients for the squared distances: one clone and one transposed clone per step.
template <class T>
void fit(benchmark::State& state) {
    using Points = std::vector<Vec<T, 3>>;
    Points points;
    for (const auto& p : cageform_bench::points_inside_bumpy112()) points.push_back(cageform::vec_cast<T>(p));
    const auto mesh = cageform_bench::bumpy112<T>();
    const auto bound = cageform::bind(MeanValueCoordinates<T, 3>(mesh), points);
    const Points rest(mesh.vertices().begin(), mesh.vertices().end());
    Points sought = rest, targets(points.size()), gap, moves(points.size()), pose, slope(rest.size()), way;
    for (auto& h : sought)
        h = h + Vec<T, 3>{T(0.2) * h[2] * h[2], T(0.3) * std::sin(h[0]), T(0.2) * h[0] * h[1]};
    if (!bound || clone(bound.value, sought, targets) != Status::ok) return state.SkipWithError("not bound");
    const auto product = [](const Points& a, const Points& b) {
        double sum = 0;
        for (std::size_t i = 0; i < a.size(); ++i) sum += double(dot(a[i], b[i]));
        return sum;
    };
    const auto add = [](Points& a, double factor, const Points& b) {
        for (std::size_t i = 0; i < a.size(); ++i) a[i] = a[i] + T(factor) * b[i];
    };
    for (auto _ : state) {
        pose = rest;
        gap = points;
        add(gap, -1, targets);
        way.assign(rest.size(), {});
        double last = 1;
        for (std::int64_t step = 0; step < state.range(0); ++step) {
            if (clone_transposed(bound.value, gap, slope) != Status::ok) state.SkipWithError("no gradient");
            const double size = product(slope, slope);
            for (auto& w : way) w = T(step == 0 ? 0 : size / last) * w;
            add(way, -1, slope);
            last = size;
            auto ahead = rest;
            add(ahead, 1, way);
            std::fill(moves.begin(), moves.end(), Vec<T, 3>{});
            if (clone(bound.value, ahead, moves, {.mode = cageform::CloneMode::add}) != Status::ok)
                state.SkipWithError("not cloned");
            const double square = product(moves, moves);
            if (!(square > 0)) break;
            add(pose, size / square, way);
            add(gap, size / square, moves);
        }
        benchmark::DoNotOptimize(pose.data());
    }
    if (clone(bound.value, pose, moves) != Status::ok) return state.SkipWithError("not cloned");
    add(moves, -1, targets);
    const auto box = cageform::bounds_of(std::span<const Vec<T, 3>>(rest));
    state.counters["missed"] =
        std::sqrt(product(moves, moves) / double(points.size())) / double(box.diagonal());
}

#define CAGEFORM_BENCH_POSE(name, cage, handles, rotations, dimension)                                       \
    BENCHMARK_CAPTURE(iteration, name##_float, cage<float>())->Unit(benchmark::kMicrosecond);                \
    BENCHMARK_CAPTURE(iteration, name##_double, cage<double>())->Unit(benchmark::kMicrosecond);              \
    BENCHMARK_CAPTURE(limit, name, handles, rotations, dimension)->Unit(benchmark::kMicrosecond);            \
    BENCHMARK_CAPTURE(frame, name##_float, cage<float>())->Unit(benchmark::kMicrosecond);                    \
    BENCHMARK_CAPTURE(click, name##_double, cage<double>())->Unit(benchmark::kMillisecond);                  \
    BENCHMARK_CAPTURE(first_frame, name##_float, cage<float>())->Unit(benchmark::kMillisecond);              \
    BENCHMARK_CAPTURE(first_frame, name##_double, cage<double>())->Unit(benchmark::kMillisecond);            \
    BENCHMARK_CAPTURE(sample, name##_double, cage<double>())->Unit(benchmark::kMillisecond);
CAGEFORM_BENCH_POSE(plane_25, star_25, 25, 200, 2)
CAGEFORM_BENCH_POSE(space_112, bumpy, 112, 224, 3)
CAGEFORM_BENCH_POSE(space_300, box_300, 300, 400, 3)
CAGEFORM_BENCH_POSE(space_762, box_762, 762, 400, 3)
BENCHMARK_TEMPLATE(fit, float)
    ->ArgName("steps")
    ->Arg(0)
    ->Arg(10)
    ->Arg(30)
    ->Arg(100)
    ->Arg(300)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(fit, double)
    ->ArgName("steps")
    ->Arg(10)
    ->Arg(30)
    ->Arg(100)
    ->Arg(300)
    ->Unit(benchmark::kMillisecond);

} // namespace

// Frames of a PoseSolver for 25 to 762 handles: one iteration, a click, and the samples, beside the limit of
// arithmetic.
#include "workloads.hpp"

#include <cageform/coordinates/mean_value.hpp>
#include <cageform/pose/pose_samples.hpp>
#include <cageform/pose/pose_solver.hpp>

#include <benchmark/benchmark.h>

namespace {

using cageform::MeanValueCoordinates;
using cageform::PoseOptions;
using cageform::PoseSampleOptions;
using cageform::PoseSolver;
using cageform::Status;
using cageform::Vec;

/// A cage with seven pins at samples of its inside, the last of which is dragged.
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
    /// A frame, with the last pin at another place.
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

/// A frame of 32 iterations; the time of one is a 33rd, because a last pass makes the report.
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
void sample(benchmark::State& state, const auto& coordinates) {
    for (auto _ : state) benchmark::DoNotOptimize(pose_samples(coordinates).value.stiffness.data());
}
/// As many products and sums as an iteration has, 4 C H D² + 2 H² D operations, in registers alone.
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

#define CAGEFORM_BENCH_POSE(name, cage, handles, rotations, dimension)                                       \
    BENCHMARK_CAPTURE(iteration, name##_float, cage<float>())->Unit(benchmark::kMicrosecond);                \
    BENCHMARK_CAPTURE(iteration, name##_double, cage<double>())->Unit(benchmark::kMicrosecond);              \
    BENCHMARK_CAPTURE(limit, name, handles, rotations, dimension)->Unit(benchmark::kMicrosecond);            \
    BENCHMARK_CAPTURE(frame, name##_float, cage<float>())->Unit(benchmark::kMicrosecond);                    \
    BENCHMARK_CAPTURE(click, name##_double, cage<double>())->Unit(benchmark::kMillisecond);                  \
    BENCHMARK_CAPTURE(sample, name##_double, cage<double>())->Unit(benchmark::kMillisecond);
CAGEFORM_BENCH_POSE(plane_25, star_25, 25, 100, 2)
CAGEFORM_BENCH_POSE(space_112, bumpy, 112, 224, 3)
CAGEFORM_BENCH_POSE(space_300, box_300, 300, 400, 3)
CAGEFORM_BENCH_POSE(space_762, box_762, 762, 400, 3)

} // namespace

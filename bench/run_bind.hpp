// Binds and evaluations of bench_bind.
#pragma once

#include "counted.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/parallel/running.hpp>

#include <benchmark/benchmark.h>

namespace cageform_bench {

/// per_weight: time / (points · handles).
inline void finish(benchmark::State& state, std::size_t points, std::size_t handles) {
    using benchmark::Counter;
    state.counters["points/s"] = Counter(double(points), Counter::kIsIterationInvariantRate);
    state.counters["handles"] = double(handles);
    state.counters["per_weight"] =
        Counter(double(points * handles), Counter::kIsIterationInvariantRate | Counter::kInvert);
    state.SetComplexityN(std::int64_t(points));
}

/// `again` reuses the memory of the last bind, as an editor does; otherwise each bind allocates.
template <class Coordinates, class Points>
void run_bind(benchmark::State& state, const Coordinates& coordinates, const Points& points,
              bool again = false, const cageform::Running& running = {}) {
    cageform::Binding<typename Coordinates::scalar, Coordinates::dimension> recycled;
    if (again) recycled = cageform::bind(coordinates, points).value;
    const Counted counted;
    for (auto _ : state) {
        auto result = cageform::bind(coordinates, points, {}, std::move(recycled), running);
        if (!result) state.SkipWithError(to_string(result.status()));
        benchmark::DoNotOptimize(result.value.view().weights.data);
        benchmark::ClobberMemory();
        recycled = again ? std::move(result.value) : decltype(recycled){};
    }
    finish(state, points.size(), coordinates.handles().size());
}

enum class Wanted { weights, gradients };

/// Weights or gradients alone, into existing memory: no checks of points, no report, no restored precision.
template <class C, class Points>
void run_evaluate(benchmark::State& state, const C& coordinates, const Points& points,
                  Wanted wanted = Wanted::weights) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    const std::size_t handles = coordinates.handles().size();
    const std::size_t rows = wanted == Wanted::weights ? handles : D * handles;
    const std::size_t blocks = cageform::block_count<T>(points.size());
    std::vector<cageform::Lanes<T>> rest(blocks * D), results(blocks * rows);
    const cageform::BlockView<T> rest_view{rest.data(), D, points.size()};
    const cageform::BlockView<T> result_view{results.data(), rows, points.size()};
    for (std::size_t i = 0; i < blocks * cageform::lane_count<T>; ++i) {
        for (std::size_t k = 0; k < D; ++k) rest_view(i, k) = T(points[std::min(i, points.size() - 1)][k]);
    }
    std::vector<cageform::PointState> states(points.size());
    for (auto& lanes : results) lanes[0] = T(0); // touches the memory, so that its pages exist
    const Counted counted;
    for (auto _ : state) {
        const auto evaluation = wanted == Wanted::weights
                                    ? coordinates.evaluate(rest_view, result_view, states)
                                    : coordinates.evaluate_gradients(rest_view, result_view, states);
        if (evaluation.status != cageform::Status::ok) state.SkipWithError(to_string(evaluation.status));
        benchmark::ClobberMemory();
    }
    finish(state, points.size(), handles);
}

} // namespace cageform_bench

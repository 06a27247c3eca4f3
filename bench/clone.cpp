// How near is a clone to merely reading its weights?
//
// Beside it: reading the same memory and adding it up, and Eigen's dense product W · C (the better of its two
// storage orders).
#include <cageform/binding/binding.hpp>
#include <cageform/clone/clone.hpp>

#include <Eigen/Core>
#include <benchmark/benchmark.h>

namespace {

template <class T, std::size_t D>
struct Workload {
    std::size_t points, handles;
    cageform::Binding<T, D> binding;
    std::vector<cageform::Vec<T, D>> pose, out;

    explicit Workload(const benchmark::State& state)
        : points(std::size_t(state.range(0)))
        , handles(std::size_t(state.range(1))) {
        const std::size_t blocks = cageform::block_count<T>(points);
        std::vector<cageform::Lanes<T>> weights(blocks * handles), rest(blocks * D);
        std::uint32_t random = 1;
        for (auto* lines : {&weights, &rest}) {
            for (auto& lanes : *lines) {
                for (T& x : lanes.v)
                    x = T(random = random * 1664525u + 1013904223u) * T(0x1p-32) / T(handles);
            }
        }
        std::vector<cageform::Vec<T, D>> handles_at_rest(handles);
        pose.resize(handles);
        for (std::size_t h = 0; h < handles; ++h) {
            for (std::size_t k = 0; k < D; ++k) {
                handles_at_rest[h][k] = T(h + k);
                pose[h][k] = T(h) + T(0.5);
            }
        }
        out.resize(points);
        binding =
            cageform::Binding<T, D>(std::move(weights), std::move(rest), std::move(handles_at_rest), points);
    }

    void finish(benchmark::State& state) const {
        state.counters["points/s"] =
            benchmark::Counter(double(points), benchmark::Counter::kIsIterationInvariantRate);
        state.SetBytesProcessed(std::int64_t(state.iterations()) *
                                std::int64_t(points * handles * sizeof(T)));
    }
};

template <class T, std::size_t D>
void clone_dense(benchmark::State& state) {
    Workload<T, D> work(state);
    for (auto _ : state) {
        const auto status = cageform::clone(work.binding, work.pose, work.out);
        if (status != cageform::Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
    work.finish(state);
}

template <class T, std::size_t D>
void limit_read_weights(benchmark::State& state) {
    Workload<T, D> work(state);
    const auto weights = work.binding.view().weights;
    const std::size_t lines = weights.blocks() * weights.rows;
    for (auto _ : state) {
        // Eight sums, so that the additions of a sum do not wait for each other.
        std::array<cageform::detail::Pack<T>, 8> sums;
        sums.fill(T(0));
        for (std::size_t i = 0; i + 8 <= lines; i += 8) {
            for (std::size_t s = 0; s < 8; ++s)
                sums[s] = sums[s] + cageform::detail::Pack<T>::load(weights.data[i + s]);
        }
        benchmark::DoNotOptimize(sums);
    }
    work.finish(state);
}

template <class T, std::size_t D, int Order>
void eigen_product(benchmark::State& state) {
    using Weights = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Order>;
    using Points = Eigen::Matrix<T, Eigen::Dynamic, int(D), D == 1 ? Eigen::ColMajor : Order>;
    const Workload<T, D> work(state);
    const Weights weights = Weights::Random(Eigen::Index(work.points), Eigen::Index(work.handles));
    const Points handles = Points::Random(Eigen::Index(work.handles), Eigen::Index(D));
    Points out(Eigen::Index(work.points), Eigen::Index(D));
    for (auto _ : state) {
        out.noalias() = weights * handles;
        benchmark::DoNotOptimize(out.data());
        benchmark::ClobberMemory();
    }
    work.finish(state);
}

void sizes_2d(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "handles"})
        ->Unit(benchmark::kMicrosecond)
        ->Args({152, 25})
        ->Args({1000000, 25});
}
void sizes_3d(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "handles"})
        ->Unit(benchmark::kMicrosecond)
        ->Args({8019, 112})
        ->Args({100000, 112});
}

} // namespace

#define CAGEFORM_BENCH_CLONE(T)                                                                              \
    BENCHMARK_TEMPLATE(clone_dense, T, 2)->Apply(sizes_2d);                                                  \
    BENCHMARK_TEMPLATE(limit_read_weights, T, 2)->Apply(sizes_2d);                                           \
    BENCHMARK_TEMPLATE(eigen_product, T, 2, Eigen::RowMajor)->Apply(sizes_2d);                               \
    BENCHMARK_TEMPLATE(eigen_product, T, 2, Eigen::ColMajor)->Apply(sizes_2d);                               \
    BENCHMARK_TEMPLATE(clone_dense, T, 3)->Apply(sizes_3d);                                                  \
    BENCHMARK_TEMPLATE(limit_read_weights, T, 3)->Apply(sizes_3d);                                           \
    BENCHMARK_TEMPLATE(eigen_product, T, 3, Eigen::RowMajor)->Apply(sizes_3d);                               \
    BENCHMARK_TEMPLATE(eigen_product, T, 3, Eigen::ColMajor)->Apply(sizes_3d);

CAGEFORM_BENCH_CLONE(float)
CAGEFORM_BENCH_CLONE(double)

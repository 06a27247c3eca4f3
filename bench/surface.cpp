// How long does it take to make the weights of bones on a mesh?
//
// A bumpy torus of 10,240 and 163,840 vertices, twenty bones along its core. Harmonic weights, bone heat with and without
// the question what a vertex sees, the cotangents and flips alone, and what it takes to read the factor of the equations
// once for every bone: no direct solver can do with less.
#include <cageform/surface/skin.hpp>

#include <benchmark/benchmark.h>

namespace {

using cageform::Vec;
constexpr std::size_t bones = 20;

struct Torus {
    std::vector<Vec<double, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> faces;
    std::vector<cageform::BoneSegment> core;

    explicit Torus(std::int64_t around) {
        const auto n = std::uint32_t(around), m = n * 5 / 8;
        for (std::uint32_t i = 0; i < n; ++i) {
            for (std::uint32_t j = 0; j < m; ++j) {
                const double u = 2 * std::numbers::pi * i / n, v = 2 * std::numbers::pi * j / m;
                const double r = 0.35 + 0.05 * std::sin(9 * u) * std::cos(4 * v);
                const double R = 1 + r * std::cos(v);
                vertices.push_back({R * std::cos(u), R * std::sin(u), r * std::sin(v)});
                const std::uint32_t a = i * m + j, b = (i + 1) % n * m + j, c = (i + 1) % n * m + (j + 1) % m,
                                    d = i * m + (j + 1) % m;
                faces.push_back({a, b, c});
                faces.push_back({a, c, d});
            }
        }
        for (std::size_t b = 0; b < bones; ++b) {
            const auto at = [&](double part) {
                const double u = 2 * std::numbers::pi * (double(b) + part) / double(bones);
                return Vec<double, 3>{std::cos(u), std::sin(u), 0};
            };
            core.push_back({at(0), at(1)});
        }
    }
};

void count(benchmark::State& state, const Torus& torus, const cageform::SurfaceReport& report) {
    state.counters["vertices"] = double(torus.vertices.size());
    state.counters["flips"] = double(report.flips);
}

void cotangents(benchmark::State& state) {
    const Torus torus(state.range(0));
    cageform::SurfaceReport report;
    for (auto _ : state) {
        const auto weights = cageform::cotangent_weights(torus.vertices, torus.faces);
        if (weights.report.status != cageform::Status::ok) state.SkipWithError("refused");
        report = weights.report;
        benchmark::DoNotOptimize(weights.links.data());
    }
    count(state, torus, report);
}

void harmonic(benchmark::State& state) {
    const Torus torus(state.range(0));
    cageform::SurfaceReport report;
    for (auto _ : state) {
        const auto skin = cageform::harmonic_skin(torus.vertices, torus.faces, torus.core);
        if (skin.report.status != cageform::Status::ok) state.SkipWithError("refused");
        report = skin.report.mesh;
        benchmark::DoNotOptimize(skin.weights.data());
    }
    count(state, torus, report);
}

template <cageform::BoneVisibility visibility>
void heat(benchmark::State& state) {
    const Torus torus(state.range(0));
    cageform::SurfaceReport report;
    for (auto _ : state) {
        const auto skin =
            cageform::bone_heat(torus.vertices, torus.faces, torus.core, {.visibility = visibility});
        if (skin.report.status != cageform::Status::ok) state.SkipWithError("refused");
        report = skin.report.mesh;
        benchmark::DoNotOptimize(skin.weights.data());
    }
    count(state, torus, report);
}

/// 42 numbers a vertex and 70 are in the factors of such meshes; a number and its row take 12 bytes.
void limit_read_factor(benchmark::State& state) {
    const std::size_t vertices = std::size_t(state.range(0) * (state.range(0) * 5 / 8));
    const std::size_t fill = vertices > 50000 ? 70 : 42;
    std::vector<std::uint64_t> factor(vertices * fill * 12 / 8, 1);
    for (auto _ : state) {
        for (std::size_t field = 0; field < bones; ++field) {
            std::uint64_t sum = 0;
            for (const std::uint64_t word : factor) sum += word;
            benchmark::DoNotOptimize(sum);
            benchmark::ClobberMemory();
        }
    }
    state.counters["vertices"] = double(vertices);
}

void sizes(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgName("around")->Unit(benchmark::kMillisecond);
    for (const int n : {128, 512}) benchmark->Arg(n);
}

} // namespace

BENCHMARK(cotangents)->Apply(sizes);
BENCHMARK(harmonic)->Apply(sizes);
BENCHMARK_TEMPLATE(heat, cageform::BoneVisibility::inside)->Apply(sizes);
BENCHMARK_TEMPLATE(heat, cageform::BoneVisibility::ignored)->Apply(sizes);
BENCHMARK(limit_read_factor)->Apply(sizes);

// How long do the weights of bones on a mesh take?
//
// Bumpy tori with 10,240 and 163,840 vertices and twenty bones along the core. Measures harmonic weights,
// bone heat with and without the visibility test, and cotangents and flips alone. Peers for the heat
// equations: Eigen's LDLT (used by libigl's harmonic functions), and CHOLMOD if installed (single-threaded
// with OMP_THREAD_LIMIT=1, like the others). Limits for any solver with this elimination order: its
// multiplications as one dense matrix product, and reading the factors forwards and backwards per 16 bones.
#include <cageform/fields/skin.hpp>
#include <cageform/parallel/threads.hpp>

#include <Eigen/SparseCholesky>
#include <benchmark/benchmark.h>

#if defined(CAGEFORM_BENCH_CHOLMOD)
#include <Eigen/CholmodSupport>
#endif

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
        if (!weights) state.SkipWithError("refused");
        report = weights.report;
        benchmark::DoNotOptimize(weights.value.links.data());
    }
    count(state, torus, report);
}

void harmonic(benchmark::State& state) {
    const Torus torus(state.range(0));
    cageform::SurfaceReport report;
    for (auto _ : state) {
        const auto skin = cageform::harmonic_skin(torus.vertices, torus.faces, torus.core);
        if (!skin) state.SkipWithError("refused");
        report = skin.report.mesh;
        benchmark::DoNotOptimize(skin.value.data());
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
        if (!skin) state.SkipWithError("refused");
        report = skin.report.mesh;
        benchmark::DoNotOptimize(skin.value.data());
    }
    count(state, torus, report);
}

void heat_threads(benchmark::State& state) {
    const Torus torus(state.range(0));
    const cageform::ThreadedFor threads{unsigned(state.range(1))};
    for (auto _ : state) {
        const auto skin =
            cageform::bone_heat(torus.vertices, torus.faces, torus.core, {}, {.parallel = threads});
        if (!skin) state.SkipWithError("refused");
        benchmark::DoNotOptimize(skin.value.data());
    }
}

/// Links each vertex to the bone of its part of the torus.
struct HeatEquations {
    std::size_t vertices, nodes;
    std::vector<cageform::GraphLink> links;

    explicit HeatEquations(std::int64_t around) {
        const Torus torus(around);
        const auto weights = cageform::cotangent_weights(torus.vertices, torus.faces).value;
        vertices = torus.vertices.size();
        nodes = vertices + bones;
        links = weights.links;
        for (std::size_t i = 0; i < vertices; ++i) {
            const auto bone = std::uint32_t(vertices + i * bones / vertices);
            links.push_back({std::uint32_t(i), bone, weights.areas[i] / (0.35 * 0.35)});
        }
    }
};

void equations(benchmark::State& state) {
    const HeatEquations heat(state.range(0));
    std::vector<std::uint8_t> given(heat.vertices);
    given.resize(heat.nodes, 1);
    std::vector<double> values(heat.nodes * bones);
    for (std::size_t b = 0; b < bones; ++b) values[b * heat.nodes + heat.vertices + b] = 1;
    for (auto _ : state) {
        const auto done = cageform::solve_graph({heat.nodes, heat.links}, given, std::span(values));
        if (done.status != cageform::Status::ok) state.SkipWithError("refused");
        benchmark::DoNotOptimize(values.data());
    }
    state.counters["vertices"] = double(heat.vertices);
}

template <class Solver>
void equations_by(benchmark::State& state) {
    const HeatEquations heat(state.range(0));
    const auto size = Eigen::Index(heat.vertices);
    for (auto _ : state) {
        std::vector<Eigen::Triplet<double>> entries;
        Eigen::MatrixXd values = Eigen::MatrixXd::Zero(size, Eigen::Index(bones));
        for (const auto& [a, b, k] : heat.links) {
            entries.emplace_back(a, a, k);
            if (b >= heat.vertices) {
                values(a, Eigen::Index(b - heat.vertices)) += k;
                continue;
            }
            entries.emplace_back(b, b, k);
            entries.emplace_back(a, b, -k);
            entries.emplace_back(b, a, -k);
        }
        Eigen::SparseMatrix<double> matrix(size, size);
        matrix.setFromTriplets(entries.begin(), entries.end());
        const Solver solver(matrix);
        if (solver.info() != Eigen::Success) state.SkipWithError("not factorised");
        const Eigen::MatrixXd solved = solver.solve(values);
        benchmark::DoNotOptimize(solved.data());
    }
    state.counters["vertices"] = double(heat.vertices);
}

/// As many operations as the factorisations: 0.05e9 and 5.8e9.
void limit_multiply(benchmark::State& state) {
    constexpr Eigen::Index size = 256; // 2 · 256³ operations per product
    const int products = state.range(0) > 200 ? 174 : 2;
    const Eigen::MatrixXd a = Eigen::MatrixXd::Random(size, size), b = Eigen::MatrixXd::Random(size, size);
    Eigen::MatrixXd product(size, size);
    for (auto _ : state) {
        for (int n = 0; n < products; ++n) {
            product.noalias() = a * b;
            benchmark::DoNotOptimize(product.data());
            benchmark::ClobberMemory();
        }
    }
}

/// The factors of these meshes have 51 and 84 numbers per vertex.
void limit_read_factor(benchmark::State& state) {
    const std::size_t vertices = std::size_t(state.range(0) * (state.range(0) * 5 / 8));
    const std::size_t fill = vertices > 50000 ? 84 : 51;
    std::vector<std::uint64_t> factor(vertices * fill, 1);
    for (auto _ : state) {
        for (std::size_t pass = 0; pass < 2 * ((bones + 15) / 16); ++pass) {
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
BENCHMARK(heat_threads)
    ->ArgNames({"around", "threads"})
    ->ArgsProduct({{512}, {1, 2, 4}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(equations)->Apply(sizes);
BENCHMARK_TEMPLATE(equations_by, Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>)->Apply(sizes);
#if defined(CAGEFORM_BENCH_CHOLMOD)
BENCHMARK_TEMPLATE(equations_by, Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>>)->Apply(sizes);
#endif
BENCHMARK(limit_multiply)->Apply(sizes);
BENCHMARK(limit_read_factor)->Apply(sizes);

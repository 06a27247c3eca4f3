// How long do Sibson coordinates take? Peer: CGAL's natural neighbours in 2D, if installed.
#include "run_bind.hpp"

#include <cageform/coordinates/sibson.hpp>
#include <cageform/parallel/threads.hpp>

#if defined(CAGEFORM_BENCH_CGAL)
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/natural_neighbor_coordinates_2.h>
#endif

#include <numbers>

namespace {

using namespace cageform_bench;

/// Uniform random sites or points in the cube [-1, 1]^D times `size`.
template <std::size_t D>
std::vector<cageform::Vec<double, D>> anywhere(std::size_t count, double size, std::uint64_t seed) {
    std::vector<cageform::Vec<double, D>> points(count);
    std::uint64_t x = seed;
    for (auto& p : points) {
        for (std::size_t k = 0; k < D; ++k) {
            x = x * 6364136223846793005u + 1442695040888963407u;
            p[k] = size * (double(x >> 11) * 0x1p-52 - 1);
        }
    }
    return points;
}

/// Sites: check, triangulation, and with degree 3 gradients.
template <std::size_t D>
void make_sibson(benchmark::State& state) {
    const auto sites = anywhere<D>(std::size_t(state.range(0)), 1, 1);
    const cageform::SibsonOptions options{.degree = int(state.range(1))};
    for (auto _ : state) {
        const cageform::SibsonCoordinates<double, D> sibson(sites, options);
        if (sibson.cage_report().status != cageform::Status::ok)
            state.SkipWithError(to_string(sibson.cage_report().status));
        benchmark::ClobberMemory();
    }
    state.counters["sites/s"] =
        benchmark::Counter(double(sites.size()), benchmark::Counter::kIsIterationInvariantRate);
}

/// Into recycled memory.
template <class T, std::size_t D>
void bind_sibson(benchmark::State& state) {
    const auto sites = anywhere<D>(std::size_t(state.range(1)), 1, 1);
    run_bind(state, cageform::SibsonCoordinates<T, D>(sites, {.degree = int(state.range(2))}),
             anywhere<D>(std::size_t(state.range(0)), 0.9, 2), true);
}

/// 3D, degree 1, several threads.
void bind_sibson_threads(benchmark::State& state) {
    run_bind(state, cageform::SibsonCoordinates<double, 3>(anywhere<3>(400, 1, 1)),
             anywhere<3>(100000, 0.9, 2), true,
             {.parallel = cageform::ThreadedFor{unsigned(state.range(0))}});
}

/// Weights alone, into existing memory.
template <std::size_t D>
void evaluate_sibson(benchmark::State& state) {
    const auto sites = anywhere<D>(std::size_t(state.range(1)), 1, 1);
    run_evaluate(state, cageform::SibsonCoordinates<double, D>(sites),
                 anywhere<D>(std::size_t(state.range(0)), 0.9, 2));
}

/// Twenty stacked rings of twelve sites, like the control points of a sleeve; many are cospherical.
template <std::size_t D>
std::vector<cageform::Vec<double, D>> rings() {
    std::vector<cageform::Vec<double, D>> sites;
    for (int k = 0; k < 20; ++k) {
        for (int i = 0; i < 12; ++i) {
            const double t = 2 * std::numbers::pi * i / 12;
            if constexpr (D == 3) sites.push_back({std::cos(t), std::sin(t), 0.5 * (k - 9.5)});
            if constexpr (D == 2)
                sites.push_back({0.05 * (k + 1) * std::cos(t), 0.05 * (k + 1) * std::sin(t)});
        }
    }
    return sites;
}

enum class Sites { anywhere, in_rings };

/// Natural neighbours and their weights as a short list per point, like CGAL. `exact`: the share of points
/// that need exact arithmetic.
template <std::size_t D, Sites kind>
void sibson_neighbours(benchmark::State& state) {
    constexpr bool in_rings = kind == Sites::in_rings;
    const auto sites = in_rings ? rings<D>() : anywhere<D>(std::size_t(state.range(1)), 1, 1);
    const auto points = anywhere<D>(std::size_t(state.range(0)), in_rings ? 0.6 : 0.9, 2);
    const cageform::detail::NaturalNeighbours<D> neighbours(
        sites, cageform::coincidence_tolerance(
                   cageform::bounds_of(std::span<const cageform::Vec<double, D>>(sites))));
    typename cageform::detail::NaturalNeighbours<D>::Scratch scratch;
    scratch.gradients = false;
    std::size_t exact = 0, found = 0;
    for (auto _ : state) {
        exact = found = 0;
        for (const auto& p : points) {
            scratch.cell.exact = false;
            (void)neighbours.find(p, scratch);
            benchmark::DoNotOptimize(scratch.found.data());
            exact += scratch.cell.exact ? 1 : 0;
            found += scratch.found.size();
        }
    }
    finish(state, points.size(), sites.size());
    state.counters["exact"] = double(exact) / double(points.size());
    state.counters["neighbours"] = double(found) / double(points.size());
}

#if defined(CAGEFORM_BENCH_CGAL)
/// CGAL with the same sites and points; each search starts near the first neighbour of the last point.
void sibson_neighbours_of_cgal(benchmark::State& state) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    using Triangulation = CGAL::Delaunay_triangulation_2<Kernel>;
    using Weight = std::pair<Triangulation::Vertex_handle, double>;
    const auto as_it_is = [](const Weight& weight) { return weight; };
    Triangulation triangulation;
    for (const auto& p : anywhere<2>(std::size_t(state.range(1)), 1, 1)) triangulation.insert({p[0], p[1]});
    const auto points = anywhere<2>(std::size_t(state.range(0)), 0.9, 2);
    std::vector<Weight> weights;
    for (auto _ : state) {
        Triangulation::Face_handle face = triangulation.finite_faces_begin();
        for (const auto& p : points) {
            weights.clear();
            const auto result = CGAL::natural_neighbor_coordinates_2(
                triangulation, Kernel::Point_2(p[0], p[1]), std::back_inserter(weights), as_it_is, face);
            for (auto& [site, weight] : weights) weight /= result.second;
            if (!weights.empty()) face = weights.front().first->face();
            benchmark::DoNotOptimize(weights.data());
        }
        benchmark::ClobberMemory();
    }
    finish(state, points.size(), std::size_t(state.range(1)));
}
#endif

void sites_and_degree(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"sites", "degree"})->Unit(benchmark::kMicrosecond);
    for (const int degree : {1, 3}) benchmark->Args({400, degree});
    benchmark->Args({20000, 1});
}
void points_sites_degree(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "sites", "degree"})->Unit(benchmark::kMicrosecond);
    for (const int degree : {1, 3}) benchmark->Args({100000, 400, degree});
}

} // namespace

BENCHMARK_TEMPLATE(make_sibson, 2)->Apply(sites_and_degree);
BENCHMARK_TEMPLATE(make_sibson, 3)->Apply(sites_and_degree);
BENCHMARK_TEMPLATE(bind_sibson, double, 2)->Apply(points_sites_degree);
BENCHMARK_TEMPLATE(bind_sibson, double, 3)->Apply(points_sites_degree);
BENCHMARK_TEMPLATE(bind_sibson, float, 3)->Apply(points_sites_degree);
BENCHMARK(bind_sibson_threads)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Arg(4)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_TEMPLATE(evaluate_sibson, 2)->Args({100000, 400})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(evaluate_sibson, 3)->Args({100000, 400})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(sibson_neighbours, 2, Sites::anywhere)->Args({100000, 400})->Unit(benchmark::kMicrosecond);
#if defined(CAGEFORM_BENCH_CGAL)
BENCHMARK(sibson_neighbours_of_cgal)->Args({100000, 400})->Unit(benchmark::kMicrosecond);
#endif
BENCHMARK_TEMPLATE(sibson_neighbours, 3, Sites::anywhere)->Args({100000, 400})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(sibson_neighbours, 2, Sites::in_rings)->Args({10000, 240})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(sibson_neighbours, 3, Sites::in_rings)->Args({10000, 240})->Unit(benchmark::kMicrosecond);

// Measures the cost of make_cage, and the tightness and clearance of its cages.
//
// Counters: `loose` is the area or volume relative to the figure grown by the margin. `clearance` is the
// exact minimum distance between cage and figure over the margin (0 or less: they intersect). `angle` is the
// smallest angle of the cage in degrees. Peer in 3D: CGAL's alpha wrap, if installed, with the margin as
// offset (Portaneri et al., Alpha wrapping with an offset, 2022). It is simplified to the same number of
// vertices (Garland & Heckbert 1997). The environment variable CAGEFORM_BENCH_OBJ adds OBJ files, separated
// by ':'. 3D cages are made with one thread and with two; the column CPU sums over the threads:
//
//     CAGEFORM_BENCH_OBJ=hand.obj:horse.obj build/bench/bench/bench_enclose --benchmark_filter=cage_space/

#include "workloads.hpp"

#include <cageform/enclose/make_cage.hpp>
#include <cageform/enclose/make_cage_3d.hpp>
#include <cageform/parallel/threads.hpp>

#include <benchmark/benchmark.h>

#ifdef CAGEFORM_BENCH_CGAL
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <CGAL/alpha_wrap_3.h>
#endif

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <sstream>
#include <string>

namespace {

using cageform::Vec;
using Mesh = cageform_bench::ObjMesh;

/// A grid of `rings` × `columns` vertices, closed in both directions.
template <class Place>
Mesh closed_grid(std::uint32_t rings, std::uint32_t columns, const Place& place) {
    Mesh mesh;
    for (std::uint32_t i = 0; i < rings; ++i) {
        for (std::uint32_t j = 0; j < columns; ++j) {
            mesh.vertices.push_back(
                place(2 * std::numbers::pi * i / rings, 2 * std::numbers::pi * j / columns));
            const std::uint32_t a = i * columns + j, b = i * columns + (j + 1) % columns;
            const std::uint32_t c = (i + 1) % rings * columns + j,
                                d = (i + 1) % rings * columns + (j + 1) % columns;
            mesh.faces.push_back({a, c, d});
            mesh.faces.push_back({a, d, b});
        }
    }
    return mesh;
}
/// A torus whose tube has waves of a given amplitude.
Mesh torus(std::uint32_t rings, std::uint32_t columns, double waves) {
    return closed_grid(rings, columns, [&](double u, double v) {
        const double r = 0.35 * (1 + waves * std::sin(9 * u) * std::cos(4 * v));
        return Vec<double, 3>{(1 + r * std::cos(v)) * std::cos(u), (1 + r * std::cos(v)) * std::sin(u),
                              r * std::sin(v)};
    });
}
/// A torus without every eighth face. Each face has its own, slightly moved vertices.
Mesh soup() {
    const Mesh whole = torus(60, 24, 0);
    Mesh torn;
    for (std::uint32_t f = 0; f < whole.faces.size(); ++f) {
        if (f % 8 == 0) continue;
        const auto first = std::uint32_t(torn.vertices.size());
        for (std::uint32_t k = 0; k < 3; ++k) {
            const double shift = 0.01 * std::sin(double(37 * f + 11 * k));
            torn.vertices.push_back(whole.vertices[whole.faces[f][k]] + Vec<double, 3>{shift, -shift, shift});
        }
        torn.faces.push_back({first, first + 1, first + 2});
    }
    return torn;
}
/// Two plates at a distance of a hundredth of their length.
Mesh plates() {
    Mesh mesh;
    constexpr std::uint32_t n = 20;
    for (const double z : {0.0, 0.02}) {
        const auto first = std::uint32_t(mesh.vertices.size());
        for (std::uint32_t i = 0; i <= n; ++i) {
            for (std::uint32_t j = 0; j <= n; ++j) {
                mesh.vertices.push_back({2.0 * i / n, 1.0 * j / n, z});
                if (i == n || j == n) continue;
                const std::uint32_t a = first + i * (n + 1) + j;
                mesh.faces.push_back({a, a + n + 1, a + n + 2});
                mesh.faces.push_back({a, a + n + 2, a + 1});
            }
        }
    }
    return mesh;
}

struct Figure {
    std::string name;
    Mesh mesh;
};
const std::vector<Figure>& figures() {
    static const std::vector<Figure> all = [] {
        std::vector<Figure> made{{"torus", torus(60, 24, 0)},
                                 {"soup", soup()},
                                 {"plates", plates()},
                                 {"wavy_100k", torus(300, 166, 0.1)},
                                 {"wavy_500k", torus(600, 416, 0.1)}};
        const char* own = std::getenv("CAGEFORM_BENCH_OBJ");
        std::istringstream files(own != nullptr ? own : "");
        for (std::string file; std::getline(files, file, ':');) {
            made.push_back(
                {std::filesystem::path(file).stem().string(), cageform_bench::read_obj(file.c_str())});
            if (!made.back().mesh.faces.empty()) continue;
            std::fprintf(stderr, "CAGEFORM_BENCH_OBJ: no faces in %s\n", file.c_str());
            std::exit(2);
        }
        return made;
    }();
    return all;
}

/// Figures, numbers of vertices, numbers of threads.
void cases(benchmark::internal::Benchmark* b, std::int64_t most_threads) {
    b->ArgNames({"figure", "vertices", "threads"})->Unit(benchmark::kMillisecond)->Iterations(1);
    for (std::int64_t n = 0; n < std::int64_t(figures().size()); ++n) {
        for (const int vertices : {60, 120, 300}) {
            for (std::int64_t threads = 1; threads <= most_threads; ++threads)
                b->Args({n, vertices, threads});
        }
    }
}
void on_one_and_two_threads(benchmark::internal::Benchmark* b) {
    cases(b->MeasureProcessCPUTime(), 2);
}

void report(benchmark::State& state, const cageform::MakeCageReport& made) {
    state.counters["vertices"] = double(made.vertices);
    state.counters["loose"] = made.area / made.tightest_area;
    state.counters["clearance"] = made.clearance / made.margin;
    state.counters["angle"] = made.least_angle;
}

/// A cage around a tree of strokes.
void cage_plane(benchmark::State& state) {
    std::vector<cageform::DrawnSegment<double>> tree;
    const auto grow = [&](const auto& self, Vec<double, 2> from, double angle, double size,
                          int depth) -> void {
        const Vec<double, 2> to{from[0] + size * std::cos(angle), from[1] + size * std::sin(angle)};
        tree.push_back({from, to, 0.05 * size});
        if (depth == 0) return;
        for (const double turn : {-0.5, 0.4}) self(self, to, angle + turn, 0.75 * size, depth - 1);
    };
    grow(grow, {0, 0}, std::numbers::pi / 2, 1, 8);
    cageform::MakeCageOptions options;
    options.vertices = std::size_t(state.range(0));
    cageform::MakeCageReport made;
    for (auto _ : state) {
        made = cageform::make_cage(tree, options).report;
    }
    if (made.status != cageform::Status::ok) return state.SkipWithError(to_string(made.status));
    report(state, made);
}
BENCHMARK(cage_plane)->Arg(16)->Arg(24)->Arg(40)->Unit(benchmark::kMillisecond);

void cage_space(benchmark::State& state) {
    const auto& [name, mesh] = figures()[std::size_t(state.range(0))];
    state.SetLabel(name);
    cageform::MakeCageOptions options;
    options.vertices = std::size_t(state.range(1));
    const cageform::ThreadedFor threads{unsigned(state.range(2))};
    cageform::MakeCageReport made;
    for (auto _ : state) {
        made = make_cage(mesh.vertices, mesh.faces, options, {.parallel = threads, .progress = {}}).report;
    }
    if (made.status != cageform::Status::ok) return state.SkipWithError(to_string(made.status));
    report(state, made);
    state.counters["tunnels"] = double(made.tunnels);
}
BENCHMARK(cage_space)->Apply(on_one_and_two_threads);

#ifdef CAGEFORM_BENCH_CGAL
void cage_space_cgal(benchmark::State& state) {
    namespace simplification = CGAL::Surface_mesh_simplification;
    using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
    using Wrap = CGAL::Surface_mesh<Point>;
    const auto& [name, mesh] = figures()[std::size_t(state.range(0))];
    state.SetLabel(name);
    const double margin =
        0.02 * cageform::bounds_of(std::span<const Vec<double, 3>>(mesh.vertices)).diagonal();
    std::vector<Point> points;
    for (const auto& p : mesh.vertices) points.emplace_back(p[0], p[1], p[2]);
    Wrap wrap;
    for (auto _ : state) {
        wrap.clear();
        CGAL::alpha_wrap_3(points, mesh.faces, 2 * margin, margin, wrap);
        const auto edges = std::size_t(3 * state.range(1));
        simplification::edge_collapse(wrap, simplification::Count_stop_predicate<Wrap>(edges));
    }
    wrap.collect_garbage();
    Mesh cage;
    for (const auto v : wrap.vertices()) {
        const Point& p = wrap.point(v);
        cage.vertices.push_back({p.x(), p.y(), p.z()});
    }
    double volume = 0;
    for (const auto f : wrap.faces()) {
        std::array<std::uint32_t, 3> face{};
        std::size_t k = 0;
        for (const auto v : CGAL::vertices_around_face(wrap.halfedge(f), wrap)) face[k++] = std::uint32_t(v);
        cage.faces.push_back(face);
        const auto& p = cage.vertices;
        volume += dot(p[face[0]], cross(p[face[1]], p[face[2]])) / 6;
    }
    const cageform::TriangleMesh<double> mesh_cage(cage.vertices, cage.faces);
    std::vector<cageform::detail::Corners<3>> corners;
    for (const auto& face : mesh.faces)
        corners.push_back({mesh.vertices[face[0]], mesh.vertices[face[1]], mesh.vertices[face[2]]});
    cageform::MakeCageOptions options;
    options.vertices = 120;
    const auto ours = make_cage(mesh.vertices, mesh.faces, options);
    state.counters["vertices"] = double(cage.vertices.size());
    state.counters["loose"] = volume / ours.report.tightest_area;
    state.counters["clearance"] =
        cageform::detail::exact_clearance<double>(mesh_cage, corners, 2 * margin) / margin;
    state.counters["angle"] = cageform::detail::least_angle(mesh_cage);
    state.counters["tunnels"] =
        1 - (double(cage.vertices.size()) - double(cage.faces.size()) / 2) / 2; // of one shell
}
void on_one_thread(benchmark::internal::Benchmark* b) {
    cases(b, 1);
}
BENCHMARK(cage_space_cgal)->Apply(on_one_thread);
#endif

} // namespace

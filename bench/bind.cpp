// How long does a bind take, against points and handles, for each coordinate type?
//
// Beside mean value: Wachspress and discrete harmonic in a convex cage, the plain textbook loop (no boundary cases,
// no report), as beside Green coordinates, and the time it takes to merely write as many weights, which no bind can
// beat. Beside harmonic coordinates in space: the bare solve of their equations.
#include "../tests/support/cages.hpp"
#include "../tests/support/fingers.hpp"
#include "workloads.hpp"

#include <cageform/binding/bind_figure.hpp>
#include <cageform/binding/bind_packed.hpp>
#include <cageform/cageform.hpp>
#include <cageform/coordinates/pyramid_solver.hpp>
#include <cageform/core/threads.hpp>

#include <benchmark/benchmark.h>
#if defined(CAGEFORM_BENCH_CGAL)
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/natural_neighbor_coordinates_2.h>
#endif

#include <ctime>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <sys/resource.h>

namespace {

using namespace cageform_bench;

/// per_weight: the time over points · handles.
void finish(benchmark::State& state, std::size_t points, std::size_t handles) {
    using benchmark::Counter;
    state.counters["points/s"] = Counter(double(points), Counter::kIsIterationInvariantRate);
    state.counters["handles"] = double(handles);
    state.counters["per_weight"] =
        Counter(double(points * handles), Counter::kIsIterationInvariantRate | Counter::kInvert);
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
    finish(state, points.size(), coordinates.handles().size());
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

enum class Wanted { weights, gradients };

/// Weights or gradients alone, into memory that is there: no checks of points, no report, no restored precision.
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
    for (auto& lanes : results) lanes[0] = T(0); // the system hands out memory when it is first written
    for (auto _ : state) {
        const auto evaluation = wanted == Wanted::weights
                                    ? coordinates.evaluate(rest_view, result_view, states)
                                    : coordinates.evaluate_gradients(rest_view, result_view, states);
        if (evaluation.status != cageform::Status::ok) state.SkipWithError(to_string(evaluation.status));
        benchmark::ClobberMemory();
    }
    finish(state, points.size(), handles);
}

template <class T>
void evaluate_mean_value(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    run_evaluate(state, cageform::MeanValueCoordinates<T, 2>(cage),
                 points_inside(cage, std::size_t(state.range(0))));
}

template <class T>
void gradients_of_mean_value(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    run_evaluate(state, cageform::MeanValueCoordinates<T, 2>(cage),
                 points_inside(cage, std::size_t(state.range(0))), Wanted::gradients);
}

/// Closed forms in a convex cage: into recycled memory.
template <class Coordinates>
void bind_convex(benchmark::State& state) {
    const auto cage = egg(std::size_t(state.range(1)));
    run_bind(state, Coordinates(cage), points_inside(cage, std::size_t(state.range(0))), true);
}

template <class Coordinates, Wanted wanted>
void evaluate_convex(benchmark::State& state) {
    const auto cage = egg(std::size_t(state.range(1)));
    run_evaluate(state, Coordinates(cage), points_inside(cage, std::size_t(state.range(0))), wanted);
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
    finish(state, points.size(), cage.size());
}

template <class T>
void bind_mean_value_mesh(benchmark::State& state) {
    run_bind(state, cageform::MeanValueCoordinates<T, 3>(bumpy112<T>()), points_inside_bumpy112());
}

template <class T>
void evaluate_mean_value_mesh(benchmark::State& state) {
    run_evaluate(state, cageform::MeanValueCoordinates<T, 3>(bumpy112<T>()), points_inside_bumpy112());
}

template <class T>
void gradients_of_mean_value_mesh(benchmark::State& state) {
    run_evaluate(state, cageform::MeanValueCoordinates<T, 3>(bumpy112<T>()), points_inside_bumpy112(),
                 Wanted::gradients);
}

/// By faces as they are, or cut into triangles.
enum class VaseOf { polygons, triangles };
template <VaseOf of, class T>
auto vase() {
    if constexpr (of == VaseOf::polygons)
        return vase112<T>();
    else
        return vase112<T>().triangles();
}
std::vector<cageform::Vec<double, 3>> points_inside_vase() {
    return points_inside(vase112<double>().triangles(), 8019, 2);
}

template <class T, VaseOf of, Wanted wanted>
void evaluate_vase(benchmark::State& state) {
    const auto cage = vase<of, T>();
    run_evaluate(state, cageform::MeanValueCoordinates<T, 3, std::remove_const_t<decltype(cage)>>(cage),
                 points_inside_vase(), wanted);
}

/// The coordinates made anew each time: the faces' planes are solved with them.
template <VaseOf of>
void bind_harmonic_vase(benchmark::State& state) {
    const auto cage = vase<of, double>();
    const auto points = points_inside_vase();
    cageform::HarmonicOptions options;
    options.resolution = std::size_t(state.range(0));
    for (auto _ : state) {
        const auto result = cageform::bind(cageform::HarmonicCoordinates(cage, options), points);
        benchmark::DoNotOptimize(result.binding.view().weights.data);
        state.counters["solver_s"] = result.report.solver.seconds;
    }
    finish(state, points.size(), cage.size());
}

/// Ju, Schaefer & Warren 2005, sec. 3, one point and one face after the other. With u the unit vectors to a
/// face's corners, of edge k opposite to corner k: n_k = u_i × u_j of its ends, θ_k = 2 asin(|u_i − u_j|/2);
/// then m = Σ ½ θ_k n_k/|n_k| and w_k = n_k·m / (n_k·u_k |C_k − p|).
void plain_mean_value_mesh(benchmark::State& state) {
    const auto cage = bumpy112<double>();
    const auto points = points_inside_bumpy112();
    const std::size_t m = cage.size();
    std::vector<double> weights(points.size() * m), distance(m);
    std::vector<cageform::Vec<double, 3>> u(m);
    for (auto _ : state) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            double* const w = &weights[i * m];
            for (std::size_t k = 0; k < m; ++k) {
                u[k] = cage[k] - points[i];
                distance[k] = std::sqrt(dot(u[k], u[k]));
                u[k] = (1 / distance[k]) * u[k];
                w[k] = 0;
            }
            for (const auto& face : cage.faces()) {
                cageform::Vec<double, 3> n[3], mean{0, 0, 0};
                for (std::size_t k = 0; k < 3; ++k) {
                    const auto &a = u[face[(k + 1) % 3]], &b = u[face[(k + 2) % 3]];
                    n[k] = cross(a, b);
                    const double angle = 2 * std::asin(std::min(1.0, 0.5 * std::sqrt(dot(a - b, a - b))));
                    mean = mean + (0.5 * angle / std::sqrt(dot(n[k], n[k]))) * n[k];
                }
                const double det = dot(n[0], u[face[0]]); // n_k·u_k of every k
                for (std::size_t k = 0; k < 3; ++k) w[face[k]] += dot(n[k], mean) / (det * distance[face[k]]);
            }
            double sum = 0;
            for (std::size_t k = 0; k < m; ++k) sum += w[k];
            for (std::size_t k = 0; k < m; ++k) w[k] /= sum;
        }
        benchmark::ClobberMemory();
    }
    finish(state, points.size(), m);
}

/// In the plane, into recycled memory.
template <class T>
void bind_green(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    run_bind(state, cageform::GreenCoordinates<T, 2>(cage), points_inside(cage, std::size_t(state.range(0))),
             true);
}

template <class T, Wanted wanted>
void evaluate_green(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    run_evaluate(state, cageform::GreenCoordinates<T, 2>(cage),
                 points_inside(cage, std::size_t(state.range(0))), wanted);
}

/// The closed form, one point and one edge after the other: an angle and a logarithm each.
void plain_green(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    const auto points = points_inside(cage, std::size_t(state.range(0)));
    const std::size_t m = cage.size();
    std::vector<double> weights(points.size() * 2 * m);
    for (auto _ : state) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            double* const w = &weights[i * 2 * m];
            for (std::size_t k = 0; k < m; ++k) w[k] = 0;
            for (std::size_t k = 0; k < m; ++k) {
                const std::size_t n = k + 1 < m ? k + 1 : 0;
                const double ax = cage[k][0] - points[i][0], ay = cage[k][1] - points[i][1];
                const double bx = cage[n][0] - points[i][0], by = cage[n][1] - points[i][1];
                const double length = std::hypot(bx - ax, by - ay), tx = (bx - ax) / length,
                             ty = (by - ay) / length, size = 2 * std::numbers::pi * length;
                const double s1 = ax * tx + ay * ty, s2 = bx * tx + by * ty, d = ax * ty - ay * tx;
                const double theta = std::atan2(ax * by - ay * bx, ax * bx + ay * by);
                const double la = 0.5 * std::log(ax * ax + ay * ay), lb = 0.5 * std::log(bx * bx + by * by);
                w[k] += (s2 * theta - d * (lb - la)) / size;
                w[n] += (d * (lb - la) - s1 * theta) / size;
                w[m + k] = -(s2 * lb - s1 * la - length + d * theta) / size;
            }
        }
        benchmark::ClobberMemory();
    }
    finish(state, points.size(), 2 * m);
}

template <class T>
void bind_green_mesh(benchmark::State& state) {
    run_bind(state, cageform::GreenCoordinates<T, 3>(bumpy112<T>()), points_inside_bumpy112(), true);
}

template <class T, Wanted wanted>
void evaluate_green_mesh(benchmark::State& state) {
    run_evaluate(state, cageform::GreenCoordinates<T, 3>(bumpy112<T>()), points_inside_bumpy112(), wanted);
}

/// The closed form by solid angles (van Oosterom & Strackee 1983), one point and one face after the other: an angle and
/// three logarithms each.
void plain_green_mesh(benchmark::State& state) {
    const auto cage = bumpy112<double>();
    const auto points = points_inside_bumpy112();
    const std::size_t m = cage.size(), handles = m + cage.faces().size();
    std::vector<double> weights(points.size() * handles);
    for (auto _ : state) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            double* w = &weights[i * handles];
            for (std::size_t k = 0; k < m; ++k) w[k] = 0;
            std::size_t f = m;
            for (const auto& face : cage.faces()) {
                cageform::Vec<double, 3> u[3], across[3];
                double r[3], lines[3], rho[3];
                for (std::size_t k = 0; k < 3; ++k) {
                    u[k] = cage[face[k]] - points[i];
                    r[k] = std::sqrt(dot(u[k], u[k]));
                }
                auto normal = cross(u[1] - u[0], u[2] - u[0]);
                const double twice = std::sqrt(dot(normal, normal));
                normal = (1 / twice) * normal;
                const double height = dot(normal, u[0]);
                const double angle = 2 * std::atan2(dot(u[0], cross(u[1], u[2])),
                                                    r[0] * r[1] * r[2] + dot(u[0], u[1]) * r[2] +
                                                        dot(u[1], u[2]) * r[0] + dot(u[2], u[0]) * r[1]);
                double potential = -height * angle;
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
                    const auto edge = u[b] - u[a];
                    const double length = std::sqrt(dot(edge, edge));
                    lines[k] = std::log((r[a] + r[b] + length) / (r[a] + r[b] - length));
                    across[k] = (1 / length) * cross(edge, normal);
                    rho[k] = dot(across[k], u[a]);
                    potential += rho[k] * lines[k];
                }
                for (std::size_t k = 0; k < 3; ++k) {
                    double sum = 0;
                    for (std::size_t l = 0; l < 3; ++l) sum += dot(across[k], across[l]) * lines[l];
                    const double altitude = dot(across[k], u[(k + 1) % 3] - u[k]);
                    w[face[k]] += (rho[k] * angle + height * sum) / (4 * std::numbers::pi * altitude);
                }
                w[f++] = potential / (4 * std::numbers::pi * std::sqrt(twice / 2));
            }
        }
        benchmark::ClobberMemory();
    }
    finish(state, points.size(), handles);
}

/// Sites or points anywhere in the cube [-1, 1]^D times `size`; the points after those of other seeds' streams.
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

/// Sites: the check, the triangulation, and with degree 3 the gradients.
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

/// Weights alone, into memory that is there.
template <std::size_t D>
void evaluate_sibson(benchmark::State& state) {
    const auto sites = anywhere<D>(std::size_t(state.range(1)), 1, 1);
    run_evaluate(state, cageform::SibsonCoordinates<double, D>(sites),
                 anywhere<D>(std::size_t(state.range(0)), 0.9, 2));
}

/// Twenty rings of twelve sites one above the other: control points as a sleeve has them, with many on a sphere.
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

/// Natural neighbours and their weights, a short list for each point, as CGAL gives them. `exact`: the share of
/// points whose weights double could not give.
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
/// CGAL's of the same sites and points, each search from beside the last point's first neighbour.
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
    finish(state, std::size_t(state.range(0)), std::size_t(state.range(1)));
}

template <class T, cageform::HarmonicSolver Solver>
void bind_harmonic(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    cageform::HarmonicOptions options;
    options.solver = Solver;
    options.resolution = std::size_t(state.range(2));
    options.averaging.tolerance = 1e-5;
    using Solvers = std::conditional_t<Solver == cageform::HarmonicSolver::multigrid,
                                       cageform::HarmonicSolverChoice<cageform::Polygon<T>>,
                                       cageform::WithAveragingPyramid<cageform::Polygon<T>>>;
    run_bind(state, cageform::HarmonicCoordinates<T, 2, cageform::Polygon<T>, Solvers>(cage, options),
             points_inside(cage, std::size_t(state.range(0))));
}

/// A cube of 98 vertices (four divisions along each axis) and 2,562 points on a sphere in it: the case that
/// Blender's Mesh Deform binds at 32 cells and not in minutes at 64.
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

/// The equations that the harmonic functions of a mesh solve, for the multigrid alone.
struct MeshProblem {
    using Cage = cageform::TriangleMesh<double>;

    MeshProblem(const Cage& cage, const cageform::HarmonicOptions& options)
        : problem(cage, options) {
        cageform::SolverReport report;
        (void)cageform::detail::EmbeddedCage<Cage>::make(problem, report, grid);
    }

    /// All functions, each block's values lost to the next; returns the most cycles.
    std::size_t solve() const {
        const cageform::grid::Multigrid<3> multigrid(grid->problem().nodes, grid->problem().cuts, {});
        const auto slots = multigrid.source_slots();
        const auto fill = [&](std::size_t first, std::size_t count, auto& source) {
            grid->add_data(first, count, slots, std::span(source));
        };
        const cageform::grid::CycleGoal goal{problem.cage.size(), 1e-6, 60};
        cageform::SolverReport report;
        (void)solve_groups(cageform::grid::MultigridGroups{multigrid, goal, fill}, report,
                           [](std::size_t, const auto& block) { benchmark::DoNotOptimize(block.value(0)); });
        return report.cycles;
    }

    cageform::CageProblem<Cage, cageform::HarmonicOptions> problem;
    std::optional<cageform::detail::EmbeddedCage<Cage>> grid;
};

/// In turns with the bare solve (not in the time), so that both meet the same machine. bind/solve and its
/// inverse are of processor time; solver_s is what `bind` reports as its solver's, sampling included.
void bind_harmonic_mesh(benchmark::State& state) {
    const auto cage = bumpy112<double>();
    const auto points = points_inside_bumpy112();
    cageform::HarmonicOptions options;
    options.resolution = std::size_t(state.range(0));
    const cageform::HarmonicCoordinates coordinates(cage, options);
    const MeshProblem problem(cage, options);
    cageform::SolverReport solver;
    double solver_seconds = 0;
    std::clock_t binding = 0, solving = 0;
    for (auto _ : state) {
        const auto begin = std::clock();
        const auto result = cageform::bind(coordinates, points);
        benchmark::DoNotOptimize(result.binding.view().weights.data);
        const auto bound = std::clock();
        state.PauseTiming();
        solver = result.report.solver;
        solver_seconds += solver.seconds;
        const std::size_t cycles = problem.solve();
        if (result.report.status != cageform::Status::ok)
            state.SkipWithError(to_string(result.report.status));
        if (cycles != solver.cycles || problem.grid->problem().nodes.count() != solver.cells)
            state.SkipWithError("the bare solve is of another problem");
        solving += std::clock() - bound;
        binding += bound - begin;
        state.ResumeTiming();
    }
    finish(state, points.size(), cage.size());
    state.counters["bind/solve"] = double(binding) / double(solving);
    state.counters["solve_share"] = double(solving) / double(binding);
    state.counters["solver_s"] = benchmark::Counter(solver_seconds, benchmark::Counter::kAvgIterations);
    state.counters["MB"] = double(solver.bytes) / 1e6;
    state.counters["cycles"] = double(solver.cycles);
    state.counters["unknowns"] = double(solver.cells);
}

/// The same by the papers' own solver as they ran it: float, one function at a time, sweeps until the mean change is
/// 1e-5, the nearest cell looked up. Joshi et al. 2007, table 1: 262 s, where mean value took 443 s.
void bind_papers_mesh(benchmark::State& state) {
    using Cage = cageform::TriangleMesh<float>;
    const auto cage = bumpy112<float>();
    std::vector<cageform::Vec<float, 3>> points;
    for (const auto& p : points_inside_bumpy112()) points.push_back(cageform::vec_cast<float>(p));
    cageform::HarmonicOptions options;
    options.resolution = std::size_t(state.range(0));
    options.averaging.tolerance = 1e-5;
    options.interpolation = cageform::grid::Interpolation::nearest_cell;
    options.handles_at_once = 1;
    const cageform::HarmonicCoordinates<float, 3, Cage, cageform::OnlySolver<cageform::PyramidSolver<Cage>>>
        coordinates(cage, options);
    cageform::BindReport report;
    for (auto _ : state) {
        const auto result = cageform::bind(coordinates, points);
        benchmark::DoNotOptimize(result.binding.view().weights.data);
        report = result.report;
        if (report.status != cageform::Status::ok) state.SkipWithError(to_string(report.status));
    }
    finish(state, points.size(), cage.size());
    const auto lattice =
        cageform::grid::lattice_about(cageform::bounds_of(cage.vertices()), options.resolution);
    state.counters["solver_s"] = report.solver.seconds;
    state.counters["MB"] = double(report.solver.bytes) / 1e6;
    state.counters["bytes/cell"] = double(report.solver.bytes) / double(lattice.size());
    state.counters["sweeps"] = double(report.solver.sweeps) / double(cage.size());
    state.counters["residual/h"] = report.residual_restored.value / double(lattice.spacing);
    state.counters["unknowns"] = double(report.solver.cells);
}

using cageform_tests::Fingers;

using Mesh = cageform::TriangleMesh<double>;
using AnyGrid = cageform::HarmonicCoordinates<double, 3, Mesh>;

/// On the adaptive grid by the accuracy asked for, 1e-4 times the argument, or on the uniform one of a resolution.
template <bool adaptive>
cageform::HarmonicOptions options_of(const benchmark::State& state) {
    cageform::HarmonicOptions options;
    if (adaptive)
        options.accuracy = 1e-4 * double(state.range(0));
    else
        options.resolution = std::size_t(state.range(0));
    return options;
}

/// A bind, with what it takes; solver_s is of the cycles and of sampling, without the grid.
cageform::Binding<double, 3> bind_on_grid(benchmark::State& state, const AnyGrid& coordinates,
                                          const std::vector<cageform::Vec<double, 3>>& points,
                                          const cageform::Running& running = {}) {
    auto [binding, report] = cageform::bind(coordinates, points, {}, running);
    if (report.status != cageform::Status::ok) state.SkipWithError(to_string(report.status));
    state.counters["handles"] = double(coordinates.handles().size());
    state.counters["nodes"] = double(report.solver.cells);
    state.counters["solver_s"] = report.solver.seconds;
    state.counters["MB"] = double(report.solver.bytes) / 1e6;
    return std::move(binding);
}

/// The largest error of a weight at the reference points, and what it takes.
template <bool adaptive>
void bind_fingers(benchmark::State& state) {
    static const Fingers fingers(CAGEFORM_BENCH_FINGERS);
    const AnyGrid coordinates(Mesh(fingers.vertices, fingers.faces), options_of<adaptive>(state));
    for (auto _ : state) {
        const auto binding = bind_on_grid(state, coordinates, fingers.points);
        double error = 0;
        for (std::size_t i = 0; i < binding.point_count(); ++i) {
            for (std::size_t h = 0; h < binding.handle_count(); ++h)
                error = std::max(error, std::fabs(binding.weight(i, h) - fingers.weights[i][h]));
        }
        state.counters["error"] = error;
    }
}

/// The same cage with its hands at 1 / argument of their size, bound to an accuracy of 2e-3: what finer parts cost.
void bind_smaller_fingers(benchmark::State& state) {
    static const Fingers fingers(CAGEFORM_BENCH_FINGERS);
    auto vertices = fingers.vertices;
    for (auto& p : vertices) { // hands begin at x = ±70 of the cage as it was before it was turned
        const auto before = cageform_tests::turned_about_123(p, -1);
        const double side = before[0] < 0 ? -1 : 1, size = 1 / double(state.range(0));
        if (side * before[0] <= 70.5) continue;
        const cageform::Vec<double, 3> wrist{70 * side, 138.5, 0};
        p = cageform_tests::turned_about_123(wrist + size * (before - wrist), 1);
    }
    const AnyGrid coordinates(Mesh(vertices, fingers.faces), {.accuracy = 2e-3});
    for (auto _ : state)
        benchmark::DoNotOptimize(bind_on_grid(state, coordinates, fingers.points).view().weights.data);
}

/// The same bind on some threads: the grid is made by one, the functions are solved by all.
void bind_fingers_threads(benchmark::State& state) {
    static const Fingers fingers(CAGEFORM_BENCH_FINGERS);
    const AnyGrid coordinates(Mesh(fingers.vertices, fingers.faces), {.accuracy = 2e-3});
    const cageform::ThreadedFor threads{unsigned(state.range(0))};
    for (auto _ : state)
        benchmark::DoNotOptimize(
            bind_on_grid(state, coordinates, fingers.points, {.parallel = threads}).view().weights.data);
}

/// Thousands of points inside the finger cage, near its skin: bound straight into a packed binding of
/// half floats without weights below 1e-4. peak_MB is of the process until now.
void bind_packed_fingers(benchmark::State& state) {
    static const Fingers fingers(CAGEFORM_BENCH_FINGERS);
    const Mesh cage(fingers.vertices, fingers.faces);
    std::vector<cageform::Vec<float, 3>> vertices, points;
    for (const auto& v : fingers.vertices) vertices.push_back(cageform::vec_cast<float>(v));
    cageform_tests::Random random(7);
    const std::size_t count = std::size_t(state.range(0)) * 1000;
    while (points.size() < count) {
        const auto& face = fingers.faces[random.below(fingers.faces.size())];
        double u = random.uniform(0, 1), v = random.uniform(0, 1);
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        const auto &a = fingers.vertices[std::size_t(face[0])], &b = fingers.vertices[std::size_t(face[1])],
                   &c = fingers.vertices[std::size_t(face[2])];
        const auto normal = cross(b - a, c - a);
        const auto p = a + u * (b - a) + v * (c - a) -
                       (random.uniform(0.01, 0.15) / cageform::detail::length(normal)) * normal;
        points.push_back(cageform::vec_cast<float>(p));
    }
    const cageform::HarmonicCoordinates<float, 3> coordinates(vertices, fingers.faces, {.accuracy = 2e-3});
    const cageform::BindPackedOptions options{
        .pack = {.format = cageform::WeightFormat::half, .threshold = 1e-4}};
    const auto stated = cageform::bind_packed_memory(coordinates, points.size(), options);
    for (auto _ : state) {
        const auto result = cageform::bind_packed(coordinates, points, options);
        if (result.packed.status != cageform::Status::ok)
            state.SkipWithError(to_string(result.packed.status));
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        state.counters["peak_MB"] = double(usage.ru_maxrss) / 1e3;
        state.counters["stated_MB"] = double(stated.solver + stated.functions + stated.batch) / 1e6;
        state.counters["blob_MB"] = double(result.packed.bytes) / 1e6;
        state.counters["dense_MB"] = double(result.packed.dense_bytes) / 1e6;
        state.counters["weights"] = result.packed.weights_per_point;
        state.counters["distance/size"] = result.packed.distance.value / result.packed.size;
        state.counters["mean_distance/size"] = result.packed.mean_distance / result.packed.size;
        state.counters["outside"] = double(result.bound.outside.size());
        state.counters["solver_s"] = result.bound.solver.seconds;
    }
}

/// BUMPY112, whose inside suits a uniform grid: the errors of weights at the 8,019 points, the largest of all and that of the
/// middle point, beside a grid of 256 cells. That one differs by 4e-3 at most, 5e-5 in the middle, from one of 384.
template <bool adaptive>
void bind_bumpy(benchmark::State& state) {
    static const auto points = points_inside_bumpy112();
    static const auto fine = cageform::bind(AnyGrid(bumpy112<double>(), {.resolution = 256}), points).binding;
    const AnyGrid coordinates(bumpy112<double>(), options_of<adaptive>(state));
    for (auto _ : state) {
        const auto binding = bind_on_grid(state, coordinates, points);
        state.PauseTiming();
        std::vector<double> errors(points.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            for (std::size_t h = 0; h < binding.handle_count(); ++h)
                errors[i] = std::max(errors[i], std::fabs(binding.weight(i, h) - fine.weight(i, h)));
        }
        std::sort(errors.begin(), errors.end());
        state.counters["error"] = errors.back();
        state.counters["middle_error"] = errors[errors.size() / 2];
        state.ResumeTiming();
    }
}

/// BUMPY112 with each face cut in four as often as the argument says, bound to an accuracy of 2e-3: what
/// handles cost.
void bind_divided_bumpy(benchmark::State& state) {
    const auto whole = bumpy112<double>();
    std::vector<cageform::Vec<double, 3>> vertices(whole.vertices().begin(), whole.vertices().end());
    std::vector<std::array<std::uint32_t, 3>> faces(whole.faces().begin(), whole.faces().end());
    for (int n = 0; n < state.range(0); ++n) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [at, added] = middles.insert({std::minmax(a, b), std::uint32_t(vertices.size())});
            if (added) vertices.push_back(0.5 * (vertices[a] + vertices[b]));
            return at->second;
        };
        std::vector<std::array<std::uint32_t, 3>> finer;
        for (const auto& [a, b, c] : faces) {
            const auto ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        faces = std::move(finer);
    }
    const auto points = points_inside_bumpy112();
    const AnyGrid coordinates(Mesh(vertices, faces), {.accuracy = 2e-3});
    for (auto _ : state)
        benchmark::DoNotOptimize(bind_on_grid(state, coordinates, points).view().weights.data);
}

/// Points, normals and tangents of as many vertices as the puppet of examples/make_character has, on a surface in
/// BUMPY112. bind/solve is of processor time, beside `solve` alone (not in the time).
void bind_harmonic_figure(benchmark::State& state) {
    const auto cage = bumpy112<float>();
    std::vector<cageform::Vec<float, 3>> points, normals;
    constexpr std::size_t count = 8066;
    for (std::size_t i = 0; i < count; ++i) { // a Fibonacci spiral, two thirds of the way to the cage
        const double z = 1 - 2 * (double(i) + 0.5) / double(count), r = std::sqrt(1 - z * z);
        const double t = double(i) * std::numbers::pi * (3 - std::sqrt(5.0)), theta = std::acos(z);
        const double size = 2.0 / 3 * (1 + 0.35 * std::cos(3 * theta) + 0.25 * r * std::cos(4 * t));
        normals.push_back({float(r * std::cos(t)), float(r * std::sin(t)), float(z)});
        points.push_back(float(size) * normals.back());
    }
    cageform::HarmonicOptions options;
    options.resolution = std::size_t(state.range(0));
    const cageform::HarmonicCoordinates<float, 3> coordinates(cage, options);
    std::clock_t binding = 0, solving = 0;
    for (auto _ : state) {
        const auto begin = std::clock();
        const auto result = cageform::bind_figure(coordinates, cageform::FigurePoints{points, normals});
        benchmark::DoNotOptimize(result.figure.points.view().weights.data);
        const auto bound = std::clock();
        state.PauseTiming();
        if (result.report.status != cageform::Status::ok)
            state.SkipWithError(to_string(result.report.status));
        auto solved = coordinates;
        if (solved.solve().status != cageform::Status::ok) state.SkipWithError("the solve alone");
        solving += std::clock() - bound;
        binding += bound - begin;
        state.ResumeTiming();
    }
    finish(state, points.size(), cage.size());
    state.counters["bind/solve"] = double(binding) / double(solving);
}

/// Where the papers say that harmonic coordinates win, for many points: a bind of 10² to 10⁶ points in BUMPY112 into
/// recycled memory. The second argument is the harmonic grid's cells; 0: mean value. All rows:
///
///     bench_bind --benchmark_filter=crossing
void crossing_of_types(benchmark::State& state) {
    const auto cage = bumpy112<float>();
    const auto points = points_inside(bumpy112<double>(), std::size_t(state.range(0)), 2);
    if (state.range(1) == 0) {
        run_bind(state, cageform::MeanValueCoordinates<float, 3>(cage), points, true);
    } else {
        cageform::HarmonicOptions options;
        options.resolution = std::size_t(state.range(1));
        run_bind(state, cageform::HarmonicCoordinates<float, 3>(cage, options), points, true);
    }
}

void points_and_cells(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "cells"})->Unit(benchmark::kMillisecond);
    for (const int cells : {0, 64, 128}) {
        for (int points = 100; points <= 1'000'000; points *= 10) benchmark->Args({points, cells});
    }
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
void sites_and_degree(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"sites", "degree"})->Unit(benchmark::kMicrosecond);
    for (const int degree : {1, 3}) benchmark->Args({400, degree});
    benchmark->Args({20000, 1});
}
void points_sites_degree(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "sites", "degree"})->Unit(benchmark::kMicrosecond);
    for (const int degree : {1, 3}) benchmark->Args({100000, 400, degree});
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
BENCHMARK_TEMPLATE(gradients_of_mean_value, double)->Args({10000, 25})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(gradients_of_mean_value, float)->Args({10000, 25})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(bind_convex, cageform::MeanValueCoordinates2d)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_convex, cageform::WachspressCoordinates2d)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_convex, cageform::DiscreteHarmonicCoordinates2d)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_convex, cageform::MeanValueCoordinates2d, Wanted::weights)
    ->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_convex, cageform::WachspressCoordinates2d, Wanted::weights)
    ->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_convex, cageform::WachspressCoordinates2f, Wanted::weights)
    ->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_convex, cageform::DiscreteHarmonicCoordinates2d, Wanted::weights)
    ->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_convex, cageform::WachspressCoordinates2d, Wanted::gradients)
    ->Apply(points_and_handles);
BENCHMARK(plain_mean_value)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_green, double)->Args({1000000, 25})->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_green, float)->Args({1000000, 25})->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_green, double, Wanted::weights)->Args({10000, 25})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(evaluate_green, float, Wanted::weights)->Args({10000, 25})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(evaluate_green, double, Wanted::gradients)
    ->Args({10000, 25})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(plain_green)->Args({10000, 25})->Unit(benchmark::kMicrosecond);
BENCHMARK(plain_green)->Args({1000000, 25})->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_green_mesh, double)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_green_mesh, float)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_green_mesh, double, Wanted::weights)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_green_mesh, float, Wanted::weights)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_green_mesh, double, Wanted::gradients)->Unit(benchmark::kMillisecond);
BENCHMARK(plain_green_mesh)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(make_sibson, 2)->Apply(sites_and_degree);
BENCHMARK_TEMPLATE(make_sibson, 3)->Apply(sites_and_degree);
BENCHMARK_TEMPLATE(bind_sibson, double, 2)->Apply(points_sites_degree);
BENCHMARK_TEMPLATE(bind_sibson, double, 3)->Apply(points_sites_degree);
BENCHMARK_TEMPLATE(bind_sibson, float, 3)->Apply(points_sites_degree);
BENCHMARK_TEMPLATE(evaluate_sibson, 2)->Args({100000, 400})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(evaluate_sibson, 3)->Args({100000, 400})->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(limit_write_weights, of_sibson, true)->Args({100000, 400})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(sibson_neighbours, 2, Sites::anywhere)->Args({100000, 400})->Unit(benchmark::kMicrosecond);
#if defined(CAGEFORM_BENCH_CGAL)
BENCHMARK(sibson_neighbours_of_cgal)->Args({100000, 400})->Unit(benchmark::kMicrosecond);
#endif
BENCHMARK_TEMPLATE(sibson_neighbours, 3, Sites::anywhere)->Args({100000, 400})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(sibson_neighbours, 2, Sites::in_rings)->Args({10000, 240})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(sibson_neighbours, 3, Sites::in_rings)->Args({10000, 240})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(bind_mean_value_mesh, double)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_mean_value_mesh, float)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_mean_value_mesh, double)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_mean_value_mesh, float)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(gradients_of_mean_value_mesh, double)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(gradients_of_mean_value_mesh, float)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_vase, double, VaseOf::polygons, Wanted::weights)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_vase, double, VaseOf::triangles, Wanted::weights)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_vase, float, VaseOf::polygons, Wanted::weights)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_vase, float, VaseOf::triangles, Wanted::weights)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_vase, double, VaseOf::polygons, Wanted::gradients)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_harmonic_vase, VaseOf::polygons)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_harmonic_vase, VaseOf::triangles)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK(plain_mean_value_mesh)->Unit(benchmark::kMillisecond);
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
BENCHMARK(bind_harmonic_mesh)->ArgName("resolution")->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK(bind_papers_mesh)->ArgName("resolution")->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_fingers, true)
    ->ArgName("accuracy_e-4")
    ->Arg(50)
    ->Arg(20)
    ->Arg(10)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_fingers, false)->ArgName("resolution")->Arg(256)->Unit(benchmark::kMillisecond);
BENCHMARK(bind_smaller_fingers)->ArgName("times")->Arg(1)->Arg(2)->Arg(4)->Unit(benchmark::kMillisecond);
BENCHMARK(bind_packed_fingers)
    ->ArgName("thousand_points")
    ->Arg(100)
    ->Arg(1000)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(bind_fingers_threads)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->Arg(4)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_TEMPLATE(bind_bumpy, true)
    ->ArgName("accuracy_e-4")
    ->Arg(100)
    ->Arg(50)
    ->Arg(20)
    ->Arg(10)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_bumpy, false)
    ->ArgName("resolution")
    ->Arg(16)
    ->Arg(32)
    ->Arg(64)
    ->Arg(128)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(bind_divided_bumpy)->ArgName("times")->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);
BENCHMARK(crossing_of_types)->Apply(points_and_cells);
BENCHMARK(bind_harmonic_figure)->ArgName("resolution")->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);

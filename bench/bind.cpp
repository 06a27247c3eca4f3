// How long does `bind` take by closed forms, by points, handles and coordinate type?
//
// Peers of mean value coordinates: CGAL's mean value coordinates if installed, a plain textbook loop, and in
// a convex cage Wachspress and discrete harmonic coordinates. Green coordinates also have a textbook loop.
// Textbook loops have no boundary cases and no report. The limit is writing as many weights. See
// bind_harmonic.cpp, bind_lattice.cpp and bind_sibson.cpp for other types.
#include "run_bind.hpp"
#include "workloads.hpp"

#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/curved_green.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/maximum_entropy.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/three_point.hpp>
#include <cageform/parallel/threads.hpp>

#if defined(CAGEFORM_BENCH_CGAL)
#include <CGAL/Barycentric_coordinates_2/Mean_value_coordinates_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#endif

#include <numbers>

namespace {

using namespace cageform_bench;
using cageform::EntropyPrior;

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

/// With several threads, into recycled memory; 2D, then 3D.
template <class T>
void bind_mean_value_threads(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    run_bind(state, cageform::MeanValueCoordinates<T, 2>(cage),
             points_inside(cage, std::size_t(state.range(0))), true,
             {.parallel = cageform::ThreadedFor{unsigned(state.range(2))}});
}
template <class T>
void bind_mean_value_mesh_threads(benchmark::State& state) {
    run_bind(state, cageform::MeanValueCoordinates<T, 3>(bumpy112<T>()), points_inside_bumpy112(), true,
             {.parallel = cageform::ThreadedFor{unsigned(state.range(0))}});
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

/// Closed forms in a convex cage, into recycled memory.
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

#if defined(CAGEFORM_BENCH_CGAL)
/// CGAL's weights by its faster formula, including edges. `again` as in run_bind.
void mean_value_of_cgal(benchmark::State& state, bool again) {
    namespace barycentric = CGAL::Barycentric_coordinates;
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    using Polygon = std::vector<Kernel::Point_2>;
    const auto cage = star(std::size_t(state.range(1)));
    Polygon polygon, points;
    for (const auto& v : cage) polygon.emplace_back(v[0], v[1]);
    for (const auto& p : points_inside(cage, std::size_t(state.range(0)))) points.emplace_back(p[0], p[1]);
    std::vector<double> weights(points.size() * cage.size());
    for (auto _ : state) {
        if (!again) weights = std::vector<double>();
        weights.resize(points.size() * cage.size());
        barycentric::Mean_value_coordinates_2<Polygon, Kernel> mean_value(
            polygon, barycentric::Computation_policy_2::FAST_WITH_EDGE_CASES);
        double* out = weights.data();
        for (const auto& p : points) out = mean_value(p, out);
        benchmark::DoNotOptimize(weights.data());
        benchmark::ClobberMemory();
    }
    finish(state, points.size(), cage.size());
}
#endif

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

template <class T, VaseOf of, Wanted wanted>
void evaluate_vase(benchmark::State& state) {
    const auto cage = vase<of, T>();
    run_evaluate(state, cageform::MeanValueCoordinates<T, 3, std::remove_const_t<decltype(cage)>>(cage),
                 points_inside_vase(), wanted);
}

template <class T, Wanted wanted, EntropyPrior prior = EntropyPrior::facing>
void evaluate_maximum_entropy(benchmark::State& state) {
    const auto cage = star(std::size_t(state.range(1)));
    run_evaluate(state, cageform::MaximumEntropyCoordinates<T, 2>(cage, prior),
                 points_inside(cage, std::size_t(state.range(0))), wanted);
}
template <class T, Wanted wanted>
void evaluate_maximum_entropy_mesh(benchmark::State& state) {
    run_evaluate(state, cageform::MaximumEntropyCoordinates(bumpy112<T>()), points_inside_bumpy112(), wanted);
}
template <class T>
void bind_maximum_entropy_mesh(benchmark::State& state) {
    run_bind(state, cageform::MaximumEntropyCoordinates(bumpy112<T>()), points_inside_bumpy112());
}

/// Ju, Schaefer & Warren 2005, sec. 3, one point and face at a time. u: unit vectors to the corners of a
/// face. Edge k is opposite to corner k. n_k = u_i × u_j of the ends of edge k, θ_k = 2 asin(|u_i − u_j|/2),
/// m = Σ ½ θ_k n_k/|n_k|, w_k = n_k·m / (n_k·u_k |C_k − p|).
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
                const double det = dot(n[0], u[face[0]]); // n_k·u_k for all k
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

/// 2D, into recycled memory.
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

/// Connects vertices by lines (degree 1) or by cubics that bulge outwards by 0.07 of their length. Posed
/// edges are cubics.
template <class T, std::size_t degree>
cageform::CurvedGreenCoordinates<T> curved_green(std::size_t m) {
    const auto vertices = star(m);
    std::vector<typename cageform::CurvedPolygon<T>::Loop> loops(1);
    for (std::size_t k = 0; k < m; ++k) {
        const auto a = vertices[k], b = vertices[(k + 1) % m], along = b - a;
        const Point out{0.1 * along[1], -0.1 * along[0]};
        auto& edge = loops[0].emplace_back();
        edge.push_back(vec_cast<T>(a));
        if (degree == 3) {
            edge.push_back(vec_cast<T>(a + (1 / 3.0) * along + out));
            edge.push_back(vec_cast<T>(b - (1 / 3.0) * along + out));
        }
        edge.push_back(vec_cast<T>(b));
    }
    return cageform::CurvedGreenCoordinates<T>(cageform::CurvedPolygon<T>(std::move(loops)));
}

template <class T, std::size_t degree>
void bind_curved_green(benchmark::State& state) {
    run_bind(state, curved_green<T, degree>(std::size_t(state.range(1))),
             points_inside(star(std::size_t(state.range(1))), std::size_t(state.range(0))), true);
}

template <class T, std::size_t degree, Wanted wanted>
void evaluate_curved_green(benchmark::State& state) {
    run_evaluate(state, curved_green<T, degree>(std::size_t(state.range(1))),
                 points_inside(star(std::size_t(state.range(1))), std::size_t(state.range(0))), wanted);
}

/// Closed form, one point and edge at a time: an angle and a logarithm each.
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

/// Closed form by solid angles (van Oosterom & Strackee 1983), one point and face at a time: an angle and
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

/// Writes as many weights as a bind, into new memory or (again) into memory in use.
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
void points_handles_threads(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "handles", "threads"})->Unit(benchmark::kMicrosecond)->UseRealTime();
    for (const int threads : {1, 2, 4}) benchmark->Args({1000000, 25, threads});
}
void threads(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgName("threads")->Arg(1)->Arg(2)->Arg(4)->Unit(benchmark::kMillisecond)->UseRealTime();
}

} // namespace

BENCHMARK_TEMPLATE(bind_barycentric, float)->Arg(10000)->Arg(1000000)->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(bind_barycentric, double)->Arg(10000)->Arg(1000000)->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(bind_mean_value, double)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_mean_value, float)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_mean_value_again, double)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_mean_value_again, float)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_mean_value_threads, double)->Apply(points_handles_threads);
BENCHMARK_TEMPLATE(evaluate_mean_value, double)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_mean_value, float)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(gradients_of_mean_value, double)->Args({10000, 25})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(gradients_of_mean_value, float)->Args({10000, 25})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(bind_convex, cageform::MeanValueCoordinates<double, 2>)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_convex, cageform::WachspressCoordinates<double>)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(bind_convex, cageform::DiscreteHarmonicCoordinates<double>)->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_convex, cageform::MeanValueCoordinates<double, 2>, Wanted::weights)
    ->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_convex, cageform::WachspressCoordinates<double>, Wanted::weights)
    ->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_convex, cageform::WachspressCoordinates<float>, Wanted::weights)
    ->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_convex, cageform::DiscreteHarmonicCoordinates<double>, Wanted::weights)
    ->Apply(points_and_handles);
BENCHMARK_TEMPLATE(evaluate_convex, cageform::WachspressCoordinates<double>, Wanted::gradients)
    ->Apply(points_and_handles);
BENCHMARK(plain_mean_value)->Apply(points_and_handles);
#if defined(CAGEFORM_BENCH_CGAL)
BENCHMARK_CAPTURE(mean_value_of_cgal, new, false)->Apply(points_and_handles);
BENCHMARK_CAPTURE(mean_value_of_cgal, again, true)->Apply(points_and_handles);
#endif
BENCHMARK_TEMPLATE(evaluate_maximum_entropy, double, Wanted::weights)
    ->Args({10000, 25})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(evaluate_maximum_entropy, float, Wanted::weights)
    ->Args({10000, 25})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(evaluate_maximum_entropy, double, Wanted::weights, EntropyPrior::mec1)
    ->Args({10000, 25})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(evaluate_maximum_entropy, double, Wanted::weights, EntropyPrior::mec2)
    ->Args({10000, 25})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(evaluate_maximum_entropy, double, Wanted::gradients)
    ->Args({10000, 25})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(bind_green, double)->Args({1000000, 25})->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_green, float)->Args({1000000, 25})->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_green, double, Wanted::weights)->Args({10000, 25})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(evaluate_green, float, Wanted::weights)->Args({10000, 25})->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(evaluate_green, double, Wanted::gradients)
    ->Args({10000, 25})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(bind_curved_green, double, 1)->Args({1000000, 25})->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_curved_green, double, 3)->Args({1000000, 25})->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_curved_green, float, 1)->Args({1000000, 25})->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_curved_green, float, 3)->Args({1000000, 25})->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_curved_green, double, 1, Wanted::weights)
    ->Args({10000, 25})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(evaluate_curved_green, double, 3, Wanted::weights)
    ->Args({10000, 25})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(evaluate_curved_green, double, 3, Wanted::gradients)
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
BENCHMARK_CAPTURE(limit_write_weights, of_sibson, true)->Args({100000, 400})->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(limit_write_weights, of_lattice, true)
    ->Args({1000000, 64})
    ->Args({500000, 64}) // as many bytes as in float
    ->Args({100000, 1000})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_mean_value_mesh, double)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_mean_value_mesh, float)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_mean_value_mesh_threads, double)->Apply(threads);
BENCHMARK_TEMPLATE(evaluate_mean_value_mesh, double)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_mean_value_mesh, float)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(gradients_of_mean_value_mesh, double)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(gradients_of_mean_value_mesh, float)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_vase, double, VaseOf::polygons, Wanted::weights)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_vase, double, VaseOf::triangles, Wanted::weights)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_vase, float, VaseOf::polygons, Wanted::weights)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_vase, float, VaseOf::triangles, Wanted::weights)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_vase, double, VaseOf::polygons, Wanted::gradients)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_maximum_entropy_mesh, double, Wanted::weights)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_maximum_entropy_mesh, float, Wanted::weights)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(evaluate_maximum_entropy_mesh, double, Wanted::gradients)->Unit(benchmark::kMillisecond);
BENCHMARK_TEMPLATE(bind_maximum_entropy_mesh, double)->Unit(benchmark::kMillisecond);
BENCHMARK(plain_mean_value_mesh)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(limit_write_weights, new, false)->Apply(points_and_handles);
BENCHMARK_CAPTURE(limit_write_weights, again, true)->Apply(points_and_handles);
BENCHMARK_CAPTURE(limit_write_weights, again, true) // 3D; as many bytes as 112 handles in float
    ->ArgNames({"points", "handles"})
    ->Args({8019, 112})
    ->Args({8019, 56})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_TEMPLATE(bind_mean_value, double)->Name("bind_mean_value growth")->Apply(growing_points);

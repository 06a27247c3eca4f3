// How long do lattices take: weights, binds, packing as sparse rows, and clones by both bindings? The limit
// for weights is writing as many (bind.cpp).
#include "run_bind.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/lattice.hpp>

namespace {

using namespace cageform_bench;

/// A cubic lattice in the unit cube.
template <class T>
cageform::LatticeCoordinates<T, 3> lattice_of(std::int64_t side) {
    cageform::Transform<T, 3> box{};
    for (std::size_t k = 0; k < 3; ++k) box.columns[k][k] = 1;
    const cageform::LatticeAxis axis{.points = std::size_t(side)};
    return cageform::LatticeCoordinates<T, 3>({axis, axis, axis}, box);
}

/// Random points in the unit cube.
template <class T>
std::vector<cageform::Vec<T, 3>> points_of(std::int64_t count) {
    std::vector<cageform::Vec<T, 3>> points(static_cast<std::size_t>(count));
    std::uint64_t x = 1;
    for (auto& p : points) {
        for (T& coordinate : p.v) {
            x = x * 6364136223846793005u + 1442695040888963407u;
            coordinate = T(double(x >> 11) * 0x1p-53);
        }
    }
    return points;
}

template <class T>
void evaluate_lattice(benchmark::State& state) {
    run_evaluate(state, lattice_of<T>(state.range(1)), points_of<T>(state.range(0)));
}

/// Into recycled memory.
template <class T>
void bind_lattice(benchmark::State& state) {
    run_bind(state, lattice_of<T>(state.range(1)), points_of<T>(state.range(0)), true);
}

constexpr double least_weight = 1e-6; ///< smaller weights are dropped from packed rows

template <class T>
cageform::StreamedPackOptions pack_options() {
    return {.pack = {.format = cageform::WeightFormat::scalar, .threshold = least_weight}};
}

template <class T>
void pack_lattice(benchmark::State& state) {
    const auto lattice = lattice_of<T>(state.range(1));
    const auto points = points_of<T>(state.range(0));
    const Counted counted;
    for (auto _ : state) {
        const auto packed = cageform::pack(lattice, points, pack_options<T>());
        if (!packed) state.SkipWithError(to_string(packed.status()));
        state.counters["MB"] = double(packed.value.bytes().size()) / 1e6;
        state.counters["weights"] = packed.report.packed.weights_per_point;
    }
    finish(state, points.size(), lattice.handles().size());
}

/// Moves all control points of a lattice and clones the points by `binding`.
template <class T, class Binding>
void run_clone(benchmark::State& state, const cageform::LatticeCoordinates<T, 3>& lattice,
               const Binding& binding) {
    std::vector<cageform::Vec<T, 3>> pose(lattice.handles().begin(), lattice.handles().end());
    for (auto& p : pose) p[0] += p[1] * p[2];
    std::vector<cageform::Vec<T, 3>> out(std::size_t(state.range(0)));
    const Counted counted;
    for (auto _ : state) {
        const auto status = cageform::clone(binding, pose, out);
        if (status != cageform::Status::ok) state.SkipWithError(to_string(status));
        benchmark::ClobberMemory();
    }
    finish(state, out.size(), pose.size());
}

template <class T>
void clone_lattice(benchmark::State& state) {
    const auto lattice = lattice_of<T>(state.range(1));
    const auto bound = cageform::bind(lattice, points_of<T>(state.range(0)));
    run_clone(state, lattice, bound.value.view());
}
template <class T>
void clone_packed_lattice(benchmark::State& state) {
    const auto lattice = lattice_of<T>(state.range(1));
    const auto packed = cageform::pack(lattice, points_of<T>(state.range(0)), pack_options<T>());
    run_clone(state, lattice, packed.value.view());
}

/// Free-form deformation as published, and as in PyGeM: Bernstein polynomials by powers and binomial
/// coefficients, and a sum over all control points in every frame.
void plain_lattice(benchmark::State& state) {
    const auto side = std::size_t(state.range(1)), degree = side - 1;
    const auto points = points_of<double>(state.range(0));
    std::vector<cageform::Vec<double, 3>> moves, out(points.size()); // of the control points, z innermost
    std::vector<double> choose(side, 1);
    for (std::size_t k = 1; k < side; ++k) choose[k] = choose[k - 1] * double(side - k) / double(k);
    const auto place = [&](std::size_t k) { return double(k) / double(degree); };
    for (std::size_t i = 0; i < side; ++i) {
        for (std::size_t j = 0; j < side; ++j) {
            for (std::size_t k = 0; k < side; ++k) moves.push_back({place(j) * place(k), 0, 0});
        }
    }
    std::array<std::vector<double>, 3> values{};
    for (auto& of_axis : values) of_axis.resize(side);
    const Counted counted;
    for (auto _ : state) {
        for (std::size_t n = 0; n < points.size(); ++n) {
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double u = points[n][axis];
                for (std::size_t k = 0; k < side; ++k)
                    values[axis][k] =
                        choose[k] * std::pow(u, double(k)) * std::pow(1 - u, double(degree - k));
            }
            auto moved = points[n];
            const auto* move = moves.data();
            for (const double x : values[0]) {
                for (const double y : values[1]) {
                    for (const double z : values[2]) moved = moved + (x * y * z) * *move++;
                }
            }
            out[n] = moved;
        }
        benchmark::ClobberMemory();
    }
    finish(state, out.size(), moves.size());
}

void points_and_side(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"points", "side"})->Unit(benchmark::kMillisecond);
    benchmark->Args({1000000, 4});
    benchmark->Args({100000, 10});
}

} // namespace

BENCHMARK_TEMPLATE(evaluate_lattice, double)->Apply(points_and_side);
BENCHMARK_TEMPLATE(evaluate_lattice, float)->Apply(points_and_side);
BENCHMARK(plain_lattice)->Apply(points_and_side);
BENCHMARK_TEMPLATE(bind_lattice, double)->Apply(points_and_side);
BENCHMARK_TEMPLATE(pack_lattice, double)->Apply(points_and_side);
BENCHMARK_TEMPLATE(pack_lattice, float)->Apply(points_and_side);
BENCHMARK_TEMPLATE(clone_lattice, double)->Apply(points_and_side);
BENCHMARK_TEMPLATE(clone_packed_lattice, double)->Apply(points_and_side);
BENCHMARK_TEMPLATE(clone_packed_lattice, float)->Apply(points_and_side);

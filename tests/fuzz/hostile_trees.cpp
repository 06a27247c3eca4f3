// Makes cages that are hard for an adaptive grid: sharp wedges of many faces, bodies that all but touch,
// slits, plates, gaps down to 1e-9, numbers near the ends of float. Nothing may crash, the memory allowed
// is kept, what is refused is refused by name and with the bytes, and weights are a mean. A program of its
// own, for sanitizers:
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all -Iinclude
//             -isystem /usr/include/eigen3 -Itests tests/fuzz/hostile_trees.cpp -o hostile_trees
//     ./hostile_trees FIRST_SEED COUNT
#include "support/cages.hpp"
#include "support/meshes.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/harmonic.hpp>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

namespace {

using namespace cageform;
using cageform_tests::MeshData;
using cageform_tests::Random;

#define REQUIRE(condition)                                                                                   \
    if (!(condition)) {                                                                                      \
        std::fprintf(stderr, "seed %llu, line %d: %s\n", seed, __LINE__, #condition);                        \
        std::abort();                                                                                        \
    }

double small(Random& random, double least) {
    return std::pow(10.0, random.uniform(std::log10(least), 0));
}

void append(MeshData& data, const MeshData& more) {
    const int first = int(data.vertices.size());
    data.vertices.insert(data.vertices.end(), more.vertices.begin(), more.vertices.end());
    for (auto face : more.faces) {
        for (int& v : face) v += first;
        data.faces.push_back(face);
    }
}
MeshData box(Random& random, int most) {
    const auto cells = [&] { return 1 + int(random.below(std::size_t(most))); };
    return cageform_tests::divided_box({cells(), cells(), cells()}, 1.0);
}
/// Upper and lower faces meet at x = 0 in an edge of many pieces.
MeshData wedge(Random& random) {
    auto data = cageform_tests::divided_box({4 + int(random.below(12)), 1 + int(random.below(12)), 1}, 1.0);
    double lowest = 0, length = 0;
    for (const auto& p : data.vertices) lowest = std::min(lowest, p[0]);
    length = -2 * lowest;
    const double height = small(random, 1e-7), rim = small(random, 1e-6);
    for (auto& p : data.vertices) p[2] *= height * (rim + (p[0] - lowest) / length);
    return data;
}
/// Boxes one above the other, by less and less apart, or with a common plane.
MeshData stack(Random& random) {
    MeshData data;
    double z = 0;
    for (std::size_t n = 0; n < 2 + random.below(3); ++n) {
        auto more = box(random, 3);
        double lowest = 0;
        for (const auto& p : more.vertices) lowest = std::min(lowest, p[2]);
        for (auto& p : more.vertices) p[2] += z - lowest;
        for (const auto& p : more.vertices) z = std::max(z, p[2]);
        z += random.below(4) == 0 ? 0 : small(random, 1e-9);
        append(data, more);
    }
    return data;
}
/// A box with a gap in it, open at one side.
MeshData slit(Random& random) {
    auto data = cageform_tests::divided_box({4, 3, 3}, 1.0);
    const double width = small(random, 1e-9);
    for (auto& p : data.vertices) { // the middle layer of cells becomes thin
        if (std::fabs(p[2]) < 1) p[2] *= width;
    }
    return data;
}
template <class T>
TriangleMesh<T> hostile_mesh(Random& random) {
    MeshData data;
    switch (random.below(7)) {
    case 0: data = wedge(random); break;
    case 1: data = stack(random); break;
    case 2: data = slit(random); break;
    case 3: data = cageform_tests::random_mesh(random.bits()); break;
    case 4: // a plate or a needle
        data = box(random, 4);
        for (auto& p : data.vertices) p[2] *= 1e-3;
        break;
    case 5: // many faces
        data = box(random, random.below(40) == 0 ? 58 : 8);
        for (auto& p : data.vertices) {
            for (std::size_t k = 0; k < 3; ++k) p[k] += random.uniform(-0.2, 0.2);
        }
        break;
    default: // vertices anywhere
        data = box(random, 2);
        for (auto& p : data.vertices) {
            for (std::size_t k = 0; k < 3; ++k) p[k] += random.uniform(-0.6, 0.6);
        }
    }
    const double turn = random.below(3) == 0 ? 0 : random.uniform(0, 3),
                 flat = random.below(4) == 0 ? small(random, 1e-7) : 1;
    const double scale = random.below(8) == 0 ? std::pow(10.0, random.uniform(-30, 30)) : 1;
    std::vector<Vec<T, 3>> vertices;
    for (const auto& p : data.vertices) {
        const Vec<double, 3> q{std::cos(turn) * p[0] - std::sin(turn) * p[2], flat * p[1],
                               std::sin(turn) * p[0] + std::cos(turn) * p[2]};
        vertices.push_back(vec_cast<T>(scale * q));
    }
    return {vertices, data.faces};
}

template <class T>
Polygon<T> hostile_polygon(Random& random) {
    auto points = cageform_tests::random_star<double>(random.bits());
    const double flat = random.below(2) == 0 ? small(random, 1e-9) : 1;
    if (random.below(3) == 0) { // a wedge of many edges
        points.clear();
        const int edges = 1 + int(random.below(300));
        const double height = small(random, 1e-9);
        for (int n = 0; n <= edges; ++n) points.push_back({double(n) / edges, 0});
        for (int n = edges; n > 0; --n) points.push_back({double(n) / edges, height * n / edges});
    } else if (random.below(3) == 0) { // a slit
        const double width = small(random, 1e-9), depth = random.uniform(0.1, 0.99);
        points = {{0, 0}, {0.5 - width, 0}, {0.5, depth}, {0.5 + width, 0}, {1, 0}, {1, 1}, {0, 1}};
    }
    const double scale = random.below(8) == 0 ? std::pow(10.0, random.uniform(-30, 30)) : 1;
    std::vector<Vec<T, 2>> vertices;
    for (const auto& p : points) vertices.push_back({T(scale * p[0]), T(scale * flat * p[1])});
    return Polygon<T>(vertices);
}

template <class C>
Status take(const C& cage, Random& random, unsigned long long seed) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    HarmonicOptions options;
    options.accuracy = std::pow(10.0, random.uniform(-3, -1));
    options.memory_limit = std::size_t{1} << (22 + random.below(4));
    const HarmonicCoordinates<T, D, C> coordinates(cage, options);
    std::vector<Vec<T, D>> points;
    for (int n = 0; n < 20; ++n) {
        Vec<T, D> p{};
        for (int k = 0; k < 4; ++k) p = p + T(0.25) * cage.vertices()[random.below(cage.size())];
        points.push_back(p);
    }
    const BindOptions as_solved{.linear_precision = LinearPrecision::leave};
    const auto [binding, report] = bind(coordinates, points, as_solved);
    if (report.status == Status::out_of_memory) {
        REQUIRE(report.solver.bytes > options.memory_limit);
        REQUIRE(report.solver.sufficient_accuracy == 0 ||
                report.solver.sufficient_accuracy > options.accuracy);
        return report.status;
    }
    if (report.status != Status::ok) {
        REQUIRE(report.status == coordinates.cage_report().status ||
                report.status == Status::resolution_not_supported);
        return report.status;
    }
    REQUIRE(report.solver.bytes <= options.memory_limit);
    REQUIRE(report.solver.tree.finest_size > 0 && std::isfinite(report.solver.grid_error()));
    for (std::size_t i = 0; i < points.size(); ++i) {
        double sum = 0;
        for (std::size_t h = 0; h < binding.handle_count(); ++h) {
            const auto w = double(binding.weight(i, h));
            REQUIRE(w >= -1e-6 && w <= 1 + 1e-6);
            sum += w;
        }
        REQUIRE(std::fabs(sum - 1) <=
                    0.3 * options.accuracy * std::sqrt(double(binding.handle_count())) + 1e-4 ||
                sum == 0);
    }
    return report.status;
}

} // namespace

int main(int count, char** arguments) {
    const unsigned long long first = count > 1 ? std::strtoull(arguments[1], nullptr, 10) : 0;
    const unsigned long long cages = count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 10000;
    std::map<std::string, std::size_t> outcomes;
    for (unsigned long long seed = first; seed < first + cages; ++seed) {
        Random random(seed);
        const Status status = seed % 4 == 0   ? take(hostile_polygon<double>(random), random, seed)
                              : seed % 4 == 1 ? take(hostile_mesh<double>(random), random, seed)
                              : seed % 4 == 2 ? take(hostile_polygon<float>(random), random, seed)
                                              : take(hostile_mesh<float>(random), random, seed);
        ++outcomes[to_string(status)];
    }
    for (const auto& [text, times] : outcomes) std::printf("%9zu  %s\n", times, text.c_str());
}

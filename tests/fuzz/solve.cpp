// Harmonic coordinates of hostile polygons and meshes on tiny grids: a bind ends with a status, and what it
// says is ok keeps the laws. Not a part of the tests; compile with clang and run for as long as there is
// time:
//
//     clang++ -std=c++20 -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all -Iinclude
//             -isystem /usr/include/eigen3 tests/fuzz/solve.cpp -o fuzz_solve
//     ASAN_OPTIONS=quarantine_size_mb=8:malloc_context_size=4 ./fuzz_solve COUNT [SEED]
#include "../support/cages.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>

#include <cstdio>
#include <cstdlib>
#include <map>

using cageform::Status;
using cageform::Vec;
using cageform_tests::Random;

namespace {

/// A coordinate: of a small lattice, near another one, or extreme.
double coordinate(Random& random) {
    switch (random.below(24)) {
    case 0: return random.uniform(-1, 1) * std::pow(10.0, random.uniform(-12, 2));
    case 1: return double(random.below(5)) + std::pow(10.0, random.uniform(-17, -3));
    case 2: return std::pow(10.0, random.uniform(-300, 300));
    default: return random.below(3) == 0 ? random.uniform(0, 4) : double(random.below(5));
    }
}

template <class T, std::size_t D>
std::vector<Vec<T, D>> places(Random& random, std::size_t count) {
    std::vector<Vec<T, D>> all(count);
    for (auto& p : all) {
        for (std::size_t k = 0; k < D; ++k) p[k] = T(coordinate(random));
    }
    return all;
}

template <class T>
cageform::Polygon<T> random_polygon(Random& random) {
    auto vertices = random.below(2) == 0 ? places<T, 2>(random, 3 + random.below(6))
                                         : cageform_tests::random_star<T>(random.bits() % 1000);
    if (random.below(3) == 0) { // a gap: a vertex moved to almost another one
        const auto& other = vertices[random.below(vertices.size())];
        vertices[random.below(vertices.size())] = {other[0] + T(random.uniform(-0.01, 0.01)), other[1]};
    }
    return cageform::Polygon<T>(vertices);
}

/// A tetrahedron or a prism, perhaps with a vertex out of place.
template <class T>
cageform::TriangleMesh<T> random_solid(Random& random) {
    using Faces = std::vector<std::array<int, 3>>;
    if (random.below(2) == 0)
        return {places<T, 3>(random, 4), Faces{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
    const T height = T(random.uniform(0.01, 3));
    std::vector<Vec<T, 3>> vertices;
    for (const T z : {T(0), height}) {
        for (const auto& [x, y] : {std::array{0, 0}, std::array{3, 0}, std::array{0, 2}})
            vertices.push_back({T(x), T(y), z});
    }
    vertices[random.below(6)] = places<T, 3>(random, 1)[0];
    return {vertices,
            Faces{{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}}};
}

/// Cells inside, wherever they come to lie.
template <class T>
cageform::CellComplex<T, 2> random_complex(Random& random) {
    cageform::CellComplex<T, 2> complex(random_polygon<T>(random));
    if (random.below(2) == 0) (void)complex.add_chain(places<T, 2>(random, 2 + random.below(3)));
    if (random.below(2) == 0) (void)complex.add_point(places<T, 2>(random, 1)[0], T(random.uniform(-0.1, 1)));
    return complex;
}

std::map<Status, std::size_t> outcomes;

template <class Cage>
void bind_to(const Cage& cage, Random& random) {
    using T = typename Cage::scalar;
    constexpr std::size_t D = Cage::dimension;
    // The cages are what is hostile: fine grids are rare, so that a million take minutes.
    const bool fine = random.below(256) == 0;
    cageform::HarmonicOptions options{.resolution = 8 + random.below(fine ? (D == 2 ? 40 : 8) : 3)};
    options.multigrid.corner_functions = random.below(4) != 0;
    options.memory_limit = 1u << 28;
    auto points = places<T, D>(random, 1 + random.below(4));
    points.insert(points.end(), cage.vertices().begin(), cage.vertices().end());
    const cageform::HarmonicCoordinates coordinates(cage, options, cageform::UniformGrid{});
    const auto outside = random.below(2) == 0 ? cageform::OutsidePoints::nearest_boundary
                                              : cageform::OutsidePoints::keep_in_place;
    const auto [binding, report] = cageform::bind(coordinates, points, {.outside = outside});
    ++outcomes[report.status];
    const auto expect = [&](bool law, const char* what) {
        if (law) return;
        std::printf("%s: %s\n", what, to_string(report.status));
        std::abort();
    };
    expect(report.status == Status::ok || binding.point_count() == 0, "nothing is half made");
    if (report.status != Status::ok) return;
    expect(report.partition_error.value <= 1e-3, "weights sum to one");
    for (const auto& corner : report.solver.multigrid.corners) {
        expect(corner.error >= 0 && corner.error <= 1, "errors of corners are numbers");
        expect(std::max(corner.handles[0], corner.handles[1]) < cage.size(), "corners are of the cage");
    }
}

} // namespace

int main(int argc, char** argv) {
    const std::size_t count = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1000;
    const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0;
    for (std::size_t n = 0; n < count; ++n) {
        Random random(seed + n);
        if (std::getenv("SHOW") != nullptr)
            std::fprintf(stderr, "%llu\n", static_cast<unsigned long long>(seed + n));
        switch (random.below(5)) {
        case 0: bind_to(random_polygon<float>(random), random); break;
        case 1: bind_to(random_polygon<double>(random), random); break;
        case 2: bind_to(random_complex<double>(random), random); break;
        case 3: bind_to(random_solid<float>(random), random); break;
        default: bind_to(random_solid<double>(random), random);
        }
    }
    for (const auto& [status, times] : outcomes) std::printf("%9zu %s\n", times, to_string(status));
}

// Laws of nearest places: against all faces one by one, with and without normals, on open meshes and flat faces.
#include "../support/meshes.hpp"
#include "../support/progress.hpp"

#include <cageform/fit/closest_places.hpp>

namespace closest_places_tests {

using namespace cageform_tests;
using cageform::ClosestPlaces;
using cageform::SurfaceMesh;
using cageform::detail::nearest_on_triangle;
using cageform::detail::point_of;
using cageform::detail::with_normal;
using V = Vec<double, 3>;

namespace {

template <std::size_t N>
Vec<double, N> random_place(Random& random) {
    Vec<double, N> p{};
    for (double& x : p.v) x = random.uniform(-1, 1);
    return p;
}

template <std::size_t N>
void check_triangle(Random& random, bool flat) {
    std::array<Vec<double, N>, 3> corners;
    for (auto& corner : corners) corner = random_place<N>(random);
    if (flat) corners[2] = 0.3 * corners[0] + 0.7 * corners[1];
    const auto p = random_place<N>(random);
    const auto weights = nearest_on_triangle(p, corners);
    const auto distance2 = [&](const std::array<double, 3>& w) {
        const auto e = point_of(w, corners) - p;
        return dot(e, e);
    };
    CHECK(std::fabs(weights[0] + weights[1] + weights[2] - 1) <= 1e-14);
    for (const double w : weights) CHECK(w >= 0);
    for (int n = 0; n < 200;
         ++n) { // the distance is convex, so steps of any size towards other places suffice
        const double u = random.uniform(0, 1), v = random.uniform(0, 1 - u),
                     t = std::pow(random.uniform(0, 1), 4);
        const std::array<double, 3> other{u, v, 1 - u - v};
        std::array<double, 3> mixed;
        for (std::size_t k = 0; k < 3; ++k) mixed[k] = (1 - t) * weights[k] + t * other[k];
        CHECK(distance2(weights) <= distance2(mixed) + 1e-13);
    }
}

} // namespace

TEST_CASE("the nearest place of a triangle is the nearest in any dimension", "[fit]") {
    const int seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    for (const bool flat : {false, true}) {
        check_triangle<2>(random, flat);
        check_triangle<3>(random, flat);
        check_triangle<6>(random, flat);
    }
}

TEST_CASE("the nearest place of a surface is the nearest of all faces, with any guess", "[fit]") {
    const int seed = GENERATE(seeds(6));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    MeshData data = sphere(3);
    for (V& v : data.vertices) v = random.uniform(0.8, 1.2) * v;
    data.faces.resize(400); // open
    data.faces.push_back({0, 0, 1});
    const SurfaceMesh mesh(data.vertices, data.faces);
    const double kappa = seed % 2 == 0 ? 0 : random.uniform(0.05, 0.5);
    const ClosestPlaces surface(mesh.vertices(), mesh.faces(), kappa);
    CHECK(surface.skipped_faces() == 1);
    std::map<std::pair<int, int>, int> edges;
    for (const auto& face : data.faces) {
        for (std::size_t k = 0; k < 3; ++k) ++edges[std::minmax(face[k], face[(k + 1) % 3])];
    }
    for (int n = 0; n < 100; ++n) {
        const V p = 1.5 * random_place<3>(random), normal = random_place<3>(random);
        double least = 1e300;
        for (const auto& face : mesh.faces()) {
            if (face[0] == face[1]) continue;
            std::array<Vec<double, 6>, 3> corners;
            for (std::size_t k = 0; k < 3; ++k)
                corners[k] = with_normal(mesh.vertices()[face[k]], surface.normals()[face[k]], kappa);
            const auto q = with_normal(p, normal, kappa);
            const auto e = point_of(nearest_on_triangle(q, corners), corners) - q;
            least = std::fmin(least, dot(e, e));
        }
        const auto guess = std::uint32_t(random.below(400));
        for (const std::uint32_t of : {cageform::no_vertex, guess}) {
            const ClosestPlaces::Place at = surface.find(p, normal, of);
            REQUIRE(at.face < mesh.faces().size());
            const auto& face = mesh.faces()[at.face];
            V mixed{};
            for (std::size_t k = 0; k < 3; ++k) mixed = mixed + at.weights[k] * surface.normals()[face[k]];
            const double square =
                dot(at.place - p, at.place - p) + kappa * kappa * dot(mixed - normal, mixed - normal);
            CHECK(std::fabs(square - least) <= 1e-12);
            bool on_rim = false;
            for (const auto& [edge, count] : edges) {
                for (const std::uint32_t i : face)
                    on_rim = on_rim || (count == 1 && (int(i) == edge.first || int(i) == edge.second));
            }
            CHECK(surface.is_on_rim(at.face) == on_rim);
        }
    }
}

TEST_CASE("distances from a surface are exact, and invariant to the order of faces", "[fit]") {
    const MeshData data = sphere(4);
    std::vector<V> points;
    Random random(3);
    for (int n = 0; n < 500; ++n)
        points.push_back(random.uniform(1.1, 3) * data.vertices[random.below(data.vertices.size())]);
    const SurfaceMesh mesh(data.vertices, data.faces);
    const auto distances = ClosestPlaces(mesh.vertices(), mesh.faces()).distances(points);
    std::vector<double> expected; // a vertex is the nearest place of the points above it
    for (const V& p : points) expected.push_back(std::sqrt(dot(p, p)) - 1);
    const double mean = std::accumulate(expected.begin(), expected.end(), 0.0) / 500;
    CHECK(std::fabs(distances.mean - mean) <= 1e-12);
    CHECK(std::fabs(distances.largest - expected[distances.farthest]) <= 1e-12);
    std::sort(expected.begin(), expected.end());
    CHECK(std::fabs(distances.largest - expected.back()) <= 1e-12);
    CHECK(std::fabs(distances.upper - expected[474]) <= 1e-12);
    auto faces = data.faces;
    std::reverse(faces.begin(), faces.end());
    const SurfaceMesh other(data.vertices, faces);
    const auto again = ClosestPlaces(other.vertices(), other.faces()).distances(points);
    CHECK(std::fabs(again.mean - distances.mean) <= 1e-14);

    const auto none = ClosestPlaces{}.distances(points);
    CHECK((none.mean == 0 && none.largest == 0));
}

} // namespace closest_places_tests

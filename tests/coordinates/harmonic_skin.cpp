// Harmonic weights in space next to the skin: the near field that takes the kinks of the data out of equations and
// samples, and errors against walks on spheres.
#include "catch.hpp"
#include "support/effort.hpp"
#include "support/fingers.hpp"
#include "support/meshes.hpp"
#include "support/walk_on_spheres.hpp"
#include "support/weights.hpp"

#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/harmonic/near_rows.hpp>
#include <cageform/core/threads.hpp>
#include <cageform/grid/tree/boundary.hpp>

namespace harmonic_skin_tests {

using namespace cageform_tests;
using cageform::TriangleMesh;
using cageform::Vec;

namespace {

double length(const Vec<double, 3>& v) {
    return std::sqrt(dot(v, v));
}
Vec<double, 3> random_direction(WalkNumbers& numbers) {
    const double z = 2 * numbers.next() - 1, turn = 2 * std::numbers::pi * numbers.next();
    return {std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z};
}
/// The largest difference of the weights at each point from those known, ascending.
std::vector<double> errors(const Fingers& fingers, double accuracy) {
    const cageform::HarmonicCoordinates<double, 3> coordinates(fingers.cage(), {.accuracy = accuracy});
    const auto weights = evaluate_all(coordinates, fingers.points);
    REQUIRE(weights.status() == cageform::Status::ok);
    std::vector<double> found;
    for (std::size_t n = 0; n < fingers.points.size(); ++n) {
        double worst = 0;
        for (std::size_t i = 0; i < fingers.vertices.size(); ++i)
            worst = (std::max)(worst, std::fabs(weights.rows[n][i] - fingers.weights[n][i]));
        found.push_back(worst);
    }
    std::sort(found.begin(), found.end());
    return found;
}

} // namespace

TEST_CASE("the corrections of a row keep constants and positions, whatever is near",
          "[coordinates][harmonic][space][property]") {
    const int seed = GENERATE(seeds(24));
    CAPTURE(seed);
    const auto mesh = random_mesh(std::uint64_t(seed)).mesh<double>();
    const cageform::CellComplex<double, 3> cage(mesh);
    const cageform::grid::TreeBoundary<3> boundary(cage, 12, 1e-12, 1);
    const cageform::detail::NearField field(boundary, cage.boundary());
    cageform::detail::NearRows rows(field, 0);
    std::size_t corrected = 0;
    for (const auto& p : points_below_faces(mesh, 20, std::uint64_t(seed))) {
        WalkNumbers numbers(std::uint64_t(seed), 1000 + corrected);
        Vec<double, 3> foot;
        const auto value = nearest_boundary_value(mesh, p, foot);
        const auto x = boundary.in_units(p);
        const double free = length(boundary.in_units(foot) - x);
        // A mean over three pairs of places about x, and one over the nearest place of the boundary and its image.
        rows.begin(7, x, 2 * free);
        for (std::uint32_t n = 0; n < 3; ++n) {
            const auto way = 0.9 * free * random_direction(numbers);
            rows.at_node(2 * n, x + way, 0.5);
            rows.at_node(2 * n + 1, x - way, 0.5);
        }
        rows.at_boundary(value, 0.5);
        rows.at_node(6, 2.0 * x - field.position(value), 0.5);
        double sum = 0, size = 0;
        Vec<double, 3> moved{};
        rows.flush([&](std::uint32_t number, std::uint32_t vertex, double amount) {
            CHECK(number == 7);
            sum += amount;
            size += std::fabs(amount);
            moved = moved + amount * (boundary.in_units(mesh[vertex]) - x);
            ++corrected;
        });
        CHECK(std::fabs(sum) <= 1e-12 * (1 + size));
        CHECK(length(moved) <= 1e-9 * (1 + size) * length(boundary.in_units(mesh[0]) - x));
    }
    CHECK(corrected > 0);
}

TEST_CASE("on a flat side of the cage twice the double layer of a vertex is its hat, kinks included",
          "[coordinates][harmonic][space]") {
    const auto mesh = divided_box({8, 8, 8}, 0.125).mesh<double>();
    const cageform::CellComplex<double, 3> cage(mesh);
    const cageform::grid::TreeBoundary<3> boundary(cage, 12, 1e-12, 1);
    const cageform::detail::NearField field(boundary, cage.boundary());
    cageform::detail::NearPatch patch(field);
    for (int n = 0; n < 12; ++n) {
        WalkNumbers numbers(3, std::uint64_t(n));
        const Vec<double, 3> p{0.2 * numbers.next() - 0.1, 0.2 * numbers.next() - 0.1, 1e-7 - 0.5};
        Vec<double, 3> foot;
        const auto value = nearest_boundary_value(mesh, p, foot);
        const auto x = boundary.in_units(p);
        REQUIRE(patch.look(x, 0.2 / boundary.unit()));
        patch.evaluate(std::span(&x, 1), 0);
        double all = 0;
        for (std::size_t v = 0; v < patch.vertices().size(); ++v) {
            double hat = 0;
            for (std::size_t k = 0; k < 3; ++k)
                hat += value.handle[k] == patch.vertices()[v] ? value.weight[k] : 0.0;
            CHECK(std::fabs(2 * patch.layer(v, 0) - hat) <= 1e-4);
            all += hat;
        }
        CHECK(std::fabs(all - 1) <= 1e-12); // the corners of the face below are all there
    }
}

TEST_CASE("next to the skin of thin fingers errors are as small as was asked for",
          "[coordinates][harmonic][space][oracle]") {
    const Fingers fingers(CAGEFORM_TEST_DATA "/fingers", 1, "skin.txt");
    constexpr double accuracy = 5e-3;
    REQUIRE(fingers.points.size() == 40);
    const auto found = errors(fingers, accuracy);
    CAPTURE(found);
    // Without the near field the median is 1e-2, nine of ten are within 3e-2, all within 7e-2.
    CHECK(found[20] <= 0.5 * accuracy);
    CHECK(found[36] <= accuracy);
    CHECK(found.back() <= 3 * accuracy);
}

TEST_CASE("weights next to the skin depend neither on other points nor on threads",
          "[coordinates][harmonic][space][property]") {
    const auto mesh = Fingers(CAGEFORM_TEST_DATA "/fingers").cage();
    cageform::HarmonicCoordinates<double, 3> coordinates(mesh, {.accuracy = 5e-2});
    // Some in one leaf: each is followed by one nearby.
    auto points = points_below_faces(mesh, 12, 11);
    for (std::size_t n = 0; n < 12; ++n) {
        Vec<double, 3> foot;
        (void)nearest_boundary_value(mesh, points[n], foot);
        points.push_back(points[n] + 0.1 * (foot - points[n]));
    }
    const auto together = evaluate_all(coordinates, points);
    REQUIRE(together.status() == cageform::Status::ok);
    CHECK(together.rows == evaluate_all(coordinates, points, {.parallel = cageform::ThreadedFor{3}}).rows);
    REQUIRE(coordinates.solve({.parallel = cageform::ThreadedFor{2}}).status == cageform::Status::ok);
    const auto kept = evaluate_all(coordinates, points);
    for (std::size_t n = 0; n < points.size(); n += 5)
        CHECK(kept.rows[n] == evaluate_all(coordinates, std::vector{points[n]}).rows[0]);
}

TEST_CASE("faces may be oriented inwards, about a cavity too", "[coordinates][harmonic][space]") {
    constexpr double accuracy = 1e-2;
    auto inner = divided_box({2, 2, 2}, 0.3), data = divided_box({3, 3, 3}, 0.5);
    for (auto& face : inner.faces) {
        for (int& v : face) v += int(data.vertices.size());
    }
    data.vertices.insert(data.vertices.end(), inner.vertices.begin(), inner.vertices.end());
    auto same = data.faces, against = data.faces, turned = data.faces;
    for (auto face : inner.faces) {
        same.push_back(face);
        std::swap(face[0], face[1]);
        against.push_back(face);
    }
    turned = against;
    for (auto& face : turned) std::swap(face[0], face[1]);
    const std::vector<Vec<double, 3>> points{
        {0.31, 0.02, 0.05}, {0.7, 0.1, -0.2}, {0.74, 0.74, 0.1}, {-0.4, 0.35, 0.3}, {0.5, -0.4, 0.6}};
    const auto weights_of = [&](const auto& faces) {
        const cageform::HarmonicCoordinates<double, 3> coordinates(TriangleMesh<double>(data.vertices, faces),
                                                                   {.accuracy = accuracy});
        const auto weights = evaluate_all(coordinates, points);
        REQUIRE(weights.status() == cageform::Status::ok);
        return weights.rows;
    };
    const auto expected = weights_of(against);
    for (const auto& rows : {weights_of(same), weights_of(turned)}) {
        for (std::size_t n = 0; n < points.size(); ++n) {
            for (std::size_t i = 0; i < rows[n].size(); ++i)
                CHECK(std::fabs(rows[n][i] - expected[n][i]) <= accuracy);
        }
    }
    const TriangleMesh<double> mesh(data.vertices, against);
    for (std::size_t n = 0; n < points.size(); ++n) {
        const auto known = walk_on_spheres(mesh, points[n], effort(4000, 1000), n);
        for (std::size_t i = 0; i < mesh.size(); ++i)
            CHECK(std::fabs(expected[n][i] - known.weight[i]) <= 3 * accuracy + 4 * known.error[i]);
    }
}

TEST_CASE("on one side of a slit nothing comes from the other side", "[coordinates][harmonic][space]") {
    // Two boxes side by side on a floor, a hundredth of their width apart.
    constexpr double gap = 0.01;
    const std::vector<std::array<double, 2>> loop{{0, 0},       {2 + gap, 0}, {2 + gap, 2}, {1 + gap, 2},
                                                  {1 + gap, 1}, {1, 1},       {1, 2},       {0, 2}};
    std::vector<Vec<double, 3>> vertices;
    for (const double z : {0.0, 1.0}) {
        for (const auto& [x, y] : loop) vertices.push_back({x, y, z});
    }
    std::vector<std::array<int, 3>> faces;
    for (const auto& [a, b, c] :
         std::vector<std::array<int, 3>>{{0, 1, 4}, {0, 4, 5}, {1, 2, 4}, {2, 3, 4}, {0, 5, 7}, {5, 6, 7}}) {
        faces.push_back({a, c, b});
        faces.push_back({8 + a, 8 + b, 8 + c});
    }
    for (int k = 0; k < 8; ++k) {
        const int l = (k + 1) % 8;
        faces.push_back({k, l, 8 + l});
        faces.push_back({k, 8 + l, 8 + k});
    }
    const TriangleMesh<double> mesh(vertices, faces);
    const std::vector<Vec<double, 3>> points{
        {0.99, 1.7, 0.5}, {1.02, 1.7, 0.5}, {0.97, 1.95, 0.2}, {1.03, 1.9, 0.9}, {0.95, 1.5, 0.4}};
    const cageform::HarmonicCoordinates<double, 3> coordinates(mesh, {.accuracy = 1e-2});
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == cageform::Status::ok);
    for (std::size_t n = 0; n < points.size(); ++n) {
        const auto known = walk_on_spheres(mesh, points[n], effort(2000, 1000), n);
        CAPTURE(n);
        for (std::size_t i = 0; i < mesh.size(); ++i)
            CHECK(std::fabs(weights.rows[n][i] - known.weight[i]) <= 1e-2 + 4 * known.error[i]);
    }
}

TEST_CASE("where hundreds of faces meet weights are still a mean", "[coordinates][harmonic][space]") {
    constexpr int around = 360;
    std::vector<Vec<double, 3>> vertices{{0, 0, 1}, {0, 0, -0.2}};
    std::vector<std::array<int, 3>> faces;
    for (int k = 0; k < around; ++k) {
        const double turn = 2 * std::numbers::pi * k / around;
        vertices.push_back({std::cos(turn), std::sin(turn), 0});
        faces.push_back({0, 2 + k, 2 + (k + 1) % around});
        faces.push_back({1, 2 + (k + 1) % around, 2 + k});
    }
    const TriangleMesh<double> mesh(vertices, faces);
    const cageform::HarmonicCoordinates<double, 3> coordinates(mesh, {.accuracy = 2e-2});
    const auto points = points_anywhere(mesh, 20, 3);
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == cageform::Status::ok);
    for (std::size_t n = 0; n < points.size(); ++n) {
        double sum = 0;
        Vec<double, 3> mean{};
        for (std::size_t i = 0; i < mesh.size(); ++i) {
            CHECK((weights.rows[n][i] >= 0 && weights.rows[n][i] <= 1));
            sum += weights.rows[n][i];
            mean = mean + weights.rows[n][i] * mesh[i];
        }
        CHECK(std::fabs(sum - 1) <= 2e-3);
        CHECK(length(mean - points[n]) <= 2e-2);
    }
}

} // namespace harmonic_skin_tests

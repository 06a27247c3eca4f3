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
/// The largest difference of the weights at each point from those of walks, ascending.
std::vector<double> errors(const TriangleMesh<double>& mesh, const std::vector<Vec<double, 3>>& points,
                           double accuracy, std::uint64_t walks) {
    const cageform::HarmonicCoordinates<double, 3> coordinates(mesh, {.accuracy = accuracy});
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == cageform::Status::ok);
    std::vector<double> found;
    for (std::size_t n = 0; n < points.size(); ++n) {
        const auto known = walk_on_spheres(mesh, points[n], walks, n);
        double worst = 0;
        for (std::size_t i = 0; i < mesh.size(); ++i)
            worst = (std::max)(worst, std::fabs(weights.rows[n][i] - known.weight[i]));
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
        patch.evaluate(std::span(&x, 1));
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
    const auto mesh = Fingers(CAGEFORM_TEST_DATA "/fingers").cage();
    constexpr double accuracy = 5e-3;
    const auto found = errors(mesh, points_below_faces(mesh, 8, 5), accuracy, effort(10000, 2000));
    CAPTURE(found);
    // The noise of the walks is up to 5e-3. Without the near field nine of ten are within 8e-2, all within 0.2.
    CHECK(found[found.size() / 2] <= 2 * accuracy);
    CHECK(found[found.size() - 2] <= 3 * accuracy);
    CHECK(found.back() <= 6 * accuracy);
}

} // namespace harmonic_skin_tests

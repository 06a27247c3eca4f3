#include "cli/mesh_folds.hpp"

#include "catch.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/cage/box_mesh.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace mesh_folds_tests {

using namespace cageform_support;

namespace {

using Points = std::vector<Point3>;

/// A bar of 8 x 2 x 2 cubes, each of six tetrahedra around a diagonal.
MeshFile bar() {
    MeshFile mesh;
    mesh.name = "bar.mesh";
    const std::array<std::uint32_t, 3> points{9, 3, 3}, step{1, 9, 27};
    for (std::uint32_t i = 0; i < 9 * 3 * 3; ++i) {
        const std::array<std::uint32_t, 3> at{i % 9, i / 9 % 3, i / 27};
        mesh.vertices.push_back({0.5 * at[0], 0.5 * at[1], 0.5 * at[2]});
        bool is_corner = true;
        for (std::size_t k = 0; k < 3; ++k) is_corner = is_corner && at[k] + 1 < points[k];
        for (std::size_t a = 0; is_corner && a < 3; ++a) {
            for (std::size_t b = 0; b < 3; ++b) {
                if (b != a) mesh.tetrahedra.push_back({i, i + step[a], i + step[a] + step[b], i + 37});
            }
        }
    }
    return mesh;
}

/// The bar deformed by a box-shaped cage, one end of which is turned about the bar's axis and pushed.
struct Bent {
    MeshFile mesh = bar();
    cageform::PolyhedralMesh<double> cage =
        cageform::box_mesh<double>({-0.1, -0.1, -0.1}, {4.1, 1.1, 1.1}, {4, 1, 1});
    cageform::MeanValueCoordinates<double, 3, cageform::PolyhedralMesh<double>> coordinates{cage};
    Points rest{cage.vertices().begin(), cage.vertices().end()}, pose = rest;

    explicit Bent(double degrees, unsigned seed) {
        std::mt19937_64 random(seed);
        std::uniform_real_distribution<double> push(-0.4, 0.4);
        for (Point3& p : pose) {
            const double angle = degrees * std::numbers::pi / 180 * (p[0] / 4), y = p[1] - 0.5,
                         z = p[2] - 0.5;
            p = {p[0] + push(random), 0.5 + std::cos(angle) * y - std::sin(angle) * z + push(random),
                 0.5 + std::sin(angle) * y + std::cos(angle) * z + push(random)};
        }
    }
    Points pose_at(double step) const {
        Points between;
        for (std::size_t i = 0; i < rest.size(); ++i) between.push_back(on_the_way(rest[i], pose[i], step));
        return between;
    }
    Points moved(double step) const {
        const auto binding = cageform::bind(coordinates, mesh.vertices);
        REQUIRE(binding);
        Points out(mesh.vertices.size());
        REQUIRE(cageform::clone(binding.value, pose_at(step), out) == cageform::Status::ok);
        return out;
    }
};

/// The smallest V'/V of all cells, in long double.
double least_ratio(const MeshFile& mesh, const Points& moved) {
    const auto volume = [](const Points& at, const std::array<std::uint32_t, 4>& cell) {
        const auto edge = [&](std::size_t k) {
            return cageform::vec_cast<long double>(at[cell[k]] - at[cell[0]]);
        };
        return dot(edge(1), cross(edge(2), edge(3)));
    };
    long double least = 2;
    for (const auto& cell : mesh.tetrahedra)
        least = std::min(least, volume(moved, cell) / volume(mesh.vertices, cell));
    return double(least);
}

} // namespace

TEST_CASE("the largest step before a fold is that of bisection", "[mesh_folds]") {
    int stopped = 0;
    for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
        CAPTURE(seed);
        const Bent bent(50 * seed, seed);
        const double threshold = seed % 2 == 0 ? 0.2 : 0;
        const Points all = bent.moved(1);
        const MeshFolds folds = folds_of_cells(bent.mesh, all, {threshold});
        REQUIRE(folds.fault().empty());
        CHECK(folds.places == 192);
        CHECK(std::fabs(folds.report.least_determinant - least_ratio(bent.mesh, all)) <= 1e-12);
        const double step = folds.step.step;
        if (folds.step.culprit == cageform::StepReport::nowhere) {
            CHECK(step == 1);
            continue;
        }
        ++stopped;
        // Every vertex moves along a line, whether the step is taken by the vertices or by the cage.
        const auto ratio_at = [&](double t) { return least_ratio(bent.mesh, bent.moved(t)); };
        double above = 0, below = 1;
        for (int n = 0; n < 200; ++n) {
            if (ratio_at(n / 200.0) > threshold) continue;
            below = n / 200.0;
            above = (n - 1) / 200.0;
            break;
        }
        for (int n = 0; n < 45; ++n) {
            const double middle = (above + below) / 2;
            (ratio_at(middle) > threshold ? above : below) = middle;
        }
        CHECK(std::fabs(step - above) <= 1e-8);
        Points there;
        for (std::size_t i = 0; i < all.size(); ++i)
            there.push_back(on_the_way(bent.mesh.vertices[i], all[i], step));
        CHECK(least_ratio(bent.mesh, there) > threshold);
        CHECK(least_ratio(bent.mesh, there) < threshold + 1e-6);
        const std::string text = describe(folds, true);
        CHECK(text.find("then tetrahedron " + std::to_string(folds.step.culprit + 1) + " folds") !=
              text.npos);
        CHECK(text.find(" of 192 tetrahedra") != text.npos);
    }
    CHECK(stopped >= 3);
}

TEST_CASE("folds around vertices do not depend on batches", "[mesh_folds]") {
    const Bent bent(160, 7);
    const std::span<const Point3> vertices(bent.mesh.vertices);
    const auto found_in = [&](std::size_t batch) {
        MeshFolds folds;
        for (std::size_t first = 0; first < vertices.size(); first += batch) {
            const auto part = vertices.subspan(first, std::min(batch, vertices.size() - first));
            const auto columns = cageform::bind_jacobians(bent.coordinates, part);
            REQUIRE(columns);
            folds.add(columns.value, bent.rest, bent.pose, first, {0.4});
        }
        CHECK(folds.fault().empty());
        return folds;
    };
    const MeshFolds whole = found_in(vertices.size());
    CHECK(whole.report.count > 0);
    CHECK(whole.step.step < 1);
    CHECK(whole.places == 81);
    for (const std::size_t batch : {1u, 7u, 40u, 80u}) {
        const MeshFolds parts = found_in(batch);
        CHECK(describe(parts, false) == describe(whole, false));
        CHECK(parts.step.step == whole.step.step);
        CHECK(parts.step.culprit == whole.step.culprit);
        CHECK(parts.report.folded == whole.report.folded);
    }
}

TEST_CASE("a tetrahedron that is flat at rest is reported", "[mesh_folds]") {
    MeshFile mesh = bar();
    mesh.tetrahedra[4] = {0, 1, 2, 3};
    const MeshFolds folds = folds_of_cells(mesh, mesh.vertices, {});
    CHECK(folds.fault() == "tetrahedron 5: the simplex has no volume relative to its size");
    CHECK(describe(folds, false) ==
          "folds: not known: tetrahedron 5: the simplex has no volume relative to its size\n");
}

} // namespace mesh_folds_tests

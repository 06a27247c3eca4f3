// Boxes of rectangles as cages of harmonic coordinates: the laws to the solver's tolerance, and the oracle.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/oracle.hpp"
#include "../support/uniform_harmonic.hpp"
#include "../support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/cage/box_mesh.hpp>
#include <cageform/parallel/threads.hpp>

namespace harmonic_box_tests {

using namespace cageform_tests;
using cageform::box_mesh;
using cageform::epsilon;
using cageform::PolyhedralMesh;

namespace {

template <class T>
using Harmonic = cageform_tests::UniformHarmonic<T, 3, PolyhedralMesh<T>>;
template <class T>
using Points3 = std::vector<Vec<T, 3>>;
using Divisions = std::array<std::size_t, 3>;

template <class T>
struct Box {
    Vec<T, 3> lower, upper;
    Divisions divisions;
    PolyhedralMesh<T> mesh() const { return box_mesh(lower, upper, divisions); }
};

template <class T>
Box<T> random_box(std::uint64_t seed) {
    Random random(seed);
    const double scale = std::pow(10.0, random.uniform(-3, 3));
    Box<T> box;
    for (std::size_t k = 0; k < 3; ++k) {
        const double low = random.uniform(-2, 2) * scale;
        box.lower[k] = T(low);
        box.upper[k] = T(low + random.uniform(0.4, 1) * scale);
        box.divisions[k] = 1 + random.below(4);
    }
    return box;
}

/// Points inside, and every tenth on a face.
template <class T>
Points3<T> points_in(const Box<T>& box, std::size_t count, std::uint64_t seed) {
    Random random(seed);
    Points3<T> points(count);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 3; ++k)
            points[i][k] = T(random.uniform(double(box.lower[k]), double(box.upper[k])));
        if (i % 10 == 0)
            points[i][i / 10 % 3] = (i / 30) % 2 == 0 ? box.lower[i / 10 % 3] : box.upper[i / 10 % 3];
    }
    return points;
}

/// The bilinear functions of the rectangle that contains a point on a side of the box.
template <class T>
std::vector<double> bilinear(const Box<T>& box, const PolyhedralMesh<T>& mesh, const Vec<T, 3>& p) {
    std::vector<double> row(mesh.size());
    for (std::size_t i = 0; i < mesh.size(); ++i) {
        row[i] = 1;
        for (std::size_t k = 0; k < 3; ++k) {
            const double step = (double(box.upper[k]) - double(box.lower[k])) / double(box.divisions[k]);
            row[i] *= std::max(0.0, 1 - std::fabs(double(p[k]) - double(mesh[i][k])) / step);
        }
    }
    return row;
}

} // namespace

TEST_CASE("a box has the vertices of its divided sides, and data that is bilinear on them", "[cage][box]") {
    const int seed = GENERATE(seeds(30));
    const auto box = random_box<double>(std::uint64_t(seed));
    CAPTURE(seed, box.divisions);
    const auto mesh = box.mesh();
    const auto [a, b, c] = box.divisions;
    CHECK(mesh.size() == (a + 1) * (b + 1) * (c + 1) - (a - 1) * (b - 1) * (c - 1));
    CHECK(mesh.face_count() == 2 * (a * b + b * c + c * a));
    REQUIRE(check(mesh).status == Status::ok);
    CHECK(check(mesh).faults.empty());
    for (std::size_t i = 1; i < mesh.size(); ++i) { // the first axis is fastest
        const auto p = mesh[i - 1], q = mesh[i];
        CHECK(std::array{p[2], p[1], p[0]} < std::array{q[2], q[1], q[0]});
    }
    const Harmonic<double> coordinates(mesh, {.resolution = 12});
    for (const auto& p : points_in(box, 60, std::uint64_t(seed))) {
        std::vector<double> row(mesh.size());
        const auto on_side = coordinates.nearest_boundary(p, row);
        CHECK(difference(row, bilinear(box, mesh, on_side)) <= 1e-12);
    }
}

TEST_CASE("boxes without volume or with corners that are not finite are named", "[cage][box][status]") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::size_t many = 1'000'000, all = std::numeric_limits<std::size_t>::max();
    for (const Divisions& divisions :
         {Divisions{many, many, many}, {1, all, 1}, {all, all, all}, {4096, 1, 2048}, {0, 1, 1}, {1, 1, 0}}) {
        const auto box = box_mesh<double>({0, 0, 0}, {1, 1, 1}, divisions);
        CHECK(box.size() == 0);
        CHECK(check(box).status != Status::ok);
        CHECK(Harmonic<double>(box, {.resolution = 16}).solve().status == check(box).status);
    }
    CHECK(check(box_mesh<double>({0, 1, 0}, {1, 1, 1})).status != Status::ok);
    CHECK(check(box_mesh<double>({0, nan, 0}, {1, 1, 1})).status == Status::vertex_not_finite);
    const auto fine = box_mesh<double>({0, 0, 0}, {1, 1, 1}, {40, 2, 2}); // more divisions than cells
    const auto coarse =
        evaluate_all(Harmonic<double>(fine, {.resolution = 16}), Points3<double>{{0.5, 0.5, 0.5}});
    CHECK(coarse.status() == Status::grid_too_coarse);
    CHECK(coarse.evaluation.solver.sufficient_resolution == 32);
}

TEST_CASE("weights in a box are those of the oracle", "[coordinates][harmonic][box][oracle]") {
    for (const char* name : {"cube_quads", "box_mixed_diagonals_quads"}) {
        const auto json = read_json(std::string("harmonic3d_") + name);
        const auto& vertices = json["cage"]["vertices"];
        const auto vertex = [&](std::size_t i) {
            return Vec<double, 3>{vertices[i][0], vertices[i][1], vertices[i][2]};
        };
        const auto box = box_mesh<double>(vertex(0), vertex(6));
        Points3<double> points;
        for (const auto& p : json["points"]) points.push_back({p[0], p[1], p[2]});
        for (const std::size_t resolution : {std::size_t{9}, std::size_t{24}, std::size_t{64}}) {
            if (resolution == 64 && (name[0] == 'c' || effort(false, true))) continue; // of one box
            CAPTURE(name, resolution);
            const auto weights = evaluate_all(Harmonic<double>(box, {.resolution = resolution}), points);
            REQUIRE(weights.status() == Status::ok);
            CHECK(weights.evaluation.solver.multigrid.convergence_factor <= 0.2);
            for (std::size_t i = 0; i < points.size(); ++i) {
                for (std::size_t k = 0; k < 8; ++k) {
                    const auto at = std::find(box.vertices().begin(), box.vertices().end(), vertex(k));
                    REQUIRE(at != box.vertices().end());
                    const auto handle = std::size_t(at - box.vertices().begin());
                    // Trilinear functions satisfy the difference equations exactly, so only the solver's
                    // tolerance remains.
                    CHECK(std::fabs(weights.rows[i][handle] - json["coordinates"][i][k].get<double>()) <=
                          1e-6);
                }
            }
        }
    }
}

TEMPLATE_TEST_CASE("weights in a box sum to 1, reproduce the point and stay in [0, 1] at every resolution",
                   "[coordinates][harmonic][box][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(6, 3)));
    const std::size_t resolution = GENERATE(std::size_t{12}, effort<std::size_t>(29, 9));
    CAPTURE(seed, resolution);
    const auto box = random_box<T>(std::uint64_t(seed));
    const auto points = points_in(box, 200, std::uint64_t(seed));
    const auto mesh = box.mesh();
    const Harmonic<T> coordinates(mesh, {.resolution = resolution});
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    const double m = double(mesh.size());
    const double size = distance(box.lower, box.upper) + distance(box.lower, Vec<T, 3>{});
    for (std::size_t i = 0; i < points.size(); ++i) {
        const bool on_face = weights.states[i] == PointState::on_boundary;
        CHECK(weights.states[i] != PointState::outside);
        const double tolerance = (on_face ? 0.0 : 1e-6) + 4 * double(epsilon<T>);
        CHECK(std::fabs(double(sum_of(weights.rows[i])) - 1) <= m * tolerance);
        CHECK(distance(combine(weights.rows[i], mesh.vertices()), points[i]) <= m * tolerance * size);
        for (const T w : weights.rows[i]) CHECK((w >= T(0) && w <= T(1)));
    }
    cageform::Running threaded;
    threaded.parallel = cageform::ThreadedFor{2};
    CHECK((evaluate_all(coordinates, points, threaded).rows == weights.rows));
}

TEST_CASE("a binding in a box follows the cage", "[coordinates][harmonic][box][binding]") {
    const Box<double> box{{-1, -1, -1}, {1, 1, 1}, {2, 3, 1}};
    const auto points = points_in(box, 400, 3);
    const auto [binding, report] = cageform::bind(Harmonic<double>(box.mesh(), {.resolution = 24}), points);
    REQUIRE(report.status == Status::ok);
    CHECK(report.weight_change.value <= 1e-6 * double(binding.handle_count()));
    CHECK(binding.handle_count() == box.mesh().size());
}

} // namespace harmonic_box_tests

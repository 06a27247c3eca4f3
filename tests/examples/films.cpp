#include "catch.hpp"

#include "films/double_curve.hpp"
#include "films/eversion.hpp"
#include "films/homotopy.hpp"
#include "films/self_similar.hpp"
#include "pictures/picture.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/folds.hpp>
#include <cageform/coordinates/lattice.hpp>

#include <numbers>
#include <random>

namespace films_test {

using namespace cageform_sources;
using Complex = std::complex<double>;

constexpr double pi = std::numbers::pi;

double distance(const Point3& a, const Point3& b) {
    const Point3 d = a - b;
    return std::hypot(d[0], d[1], d[2]);
}

const Eversion& eversion() {
    static const Eversion made;
    return made;
}

// ---- sphere_eversion ----

TEST_CASE("the eversion begins and ends with one sphere, whose sides are swapped", "[films]") {
    const EversionStage first = eversion().stage(0), last = eversion().stage(1);
    const auto seed = GENERATE(range(0u, 20u));
    CAPTURE(seed);
    std::mt19937 random(seed);
    const double theta = std::uniform_real_distribution<double>(-pi / 2, pi / 2)(random);
    const double phi = std::uniform_real_distribution<double>(-pi, pi)(random);
    const Point3 p = eversion_point(first, theta, phi);
    CHECK(std::fabs(std::hypot(p[0], p[1], p[2]) - std::sqrt(2.0 / 3)) <= 1e-12);
    CHECK(distance(p, -1.0 * eversion_point(last, theta, phi)) <= 1e-12);
}

TEST_CASE("the volume changes its sign from that of a sphere", "[films]") {
    const double sphere = 4 * pi / 3 * std::pow(2.0 / 3, 1.5);
    const auto volume = [](double time) {
        return volume_of(eversion_mesh(eversion().stage(time), 100, 200));
    };
    const double net = 2e-3; // a mesh of 100 rows is inscribed
    CHECK(std::fabs(volume(0) - sphere) <= net * sphere);
    CHECK(std::fabs(volume(1) + sphere) <= net * sphere);
    CHECK(std::fabs(volume(0.5)) <= 1e-3);
    // The stages of the source after its first, second and third part.
    const double volumes[] = {0.931, 0.373, 0.130};
    for (int leg = 1; leg <= 3; ++leg)
        CHECK(std::fabs(volume_of(eversion_mesh(stage_on_legs(leg), 200, 400)) - volumes[leg - 1]) <= 1e-3);
}

TEST_CASE("the eversion is an immersion at every stage", "[films]") {
    const int n = GENERATE(range(0, 29)); // for the first half: the other one is its mirror image
    CAPTURE(n);
    const EversionStage stage = eversion().stage(n / 56.0);
    const double size = size_of(eversion_mesh(stage, 40, 80));
    CHECK(least_area_factor(stage, 60, 120) > 0.03 * size * size);
}

TEST_CASE("the second half of the eversion is the first one backwards, mirrored and turned", "[films]") {
    const auto seed = GENERATE(range(0u, 12u));
    CAPTURE(seed);
    std::mt19937 random(seed);
    const double time = std::uniform_real_distribution<double>(0, 0.5)(random);
    const double theta = std::uniform_real_distribution<double>(-pi / 2, pi / 2)(random);
    const double phi = std::uniform_real_distribution<double>(-pi, pi)(random);
    const Point3 p = eversion_point(eversion().stage(time), theta, phi);
    // A quarter turn about the axis; θ → −θ swaps the sides.
    const Point3 q = eversion_point(eversion().stage(1 - time), -theta, phi + pi / 2);
    CHECK(distance(q, {p[1], -p[0], p[2]}) <= 1e-12);
}

TEST_CASE("the halfway surface is unchanged by a quarter turn that swaps its sides", "[films]") {
    const EversionStage halfway = eversion().stage(0.5);
    CHECK(halfway.t == 0);
    const auto mesh = eversion_mesh(halfway, 24, 48);
    for (std::size_t row = 0; row <= 24; ++row) {
        for (std::size_t column = 0; column < 48; ++column) {
            const Point3& p = mesh.vertices[row * 48 + column];
            const Point3& q = mesh.vertices[(24 - row) * 48 + (column + 12) % 48];
            REQUIRE(distance(q, {p[1], -p[0], p[2]}) <= 1e-12);
        }
    }
}

TEST_CASE("four sheets of the halfway surface meet in one place", "[films]") {
    const EversionStage halfway = eversion().stage(0.5);
    const double theta = std::asin(std::sqrt(2.0) - 1); // where h is 1
    const Point3 place = eversion_point(halfway, theta, pi / 2);
    for (const auto& [t, phi] : {std::pair{theta, -pi / 2}, {-theta, 0.0}, {-theta, pi}})
        CHECK(distance(eversion_point(halfway, t, phi), place) <= 1e-9);
}

TEST_CASE("no step between 240 frames exceeds a twentieth of the size", "[films]") {
    EversionMesh before = eversion_mesh(eversion().stage(0), 24, 48);
    for (int n = 1; n < 240; ++n) {
        EversionMesh after = eversion_mesh(eversion().stage(n / 239.0), 24, 48);
        double most = 0;
        for (std::size_t i = 0; i < after.vertices.size(); ++i)
            most = std::fmax(most, distance(after.vertices[i], before.vertices[i]));
        CAPTURE(n);
        REQUIRE(most < 0.05 * size_of(after));
        before.vertices.swap(after.vertices);
    }
}

TEST_CASE("double curves lie on both sheets", "[films]") {
    // Two planes intersect in a line; a shared corner is not an intersection.
    const std::vector<Point3> vertices{{0, 0, 0},      {2, 0, 0},      {0, 2, 0},
                                       {0.3, 0.4, -1}, {0.4, 0.3, -1}, {0.5, 0.5, 1}};
    const std::vector<std::array<std::uint32_t, 3>> two{{0, 1, 2}, {3, 4, 5}}, touching{{0, 1, 2}, {0, 4, 5}};
    const auto pieces = double_curve(vertices, two);
    REQUIRE(pieces.size() == 1);
    for (const Point3& p : pieces[0]) CHECK(std::fabs(p[2]) <= 1e-15);
    CHECK(double_curve(vertices, touching).empty());
    CHECK(double_curve(vertices, std::vector<std::array<std::uint32_t, 3>>{}).empty());

    const auto sphere = eversion_mesh(eversion().stage(0), 24, 48);
    CHECK(double_curve(sphere.vertices, sphere.triangles).empty());
    const auto halfway = eversion_mesh(eversion().stage(0.5), 24, 48);
    const auto curve = double_curve(halfway.vertices, halfway.triangles);
    CHECK(curve.size() > 100);
    // All pairs are compared, on a coarser mesh.
    const auto coarse = eversion_mesh(eversion().stage(0.45), 10, 20);
    std::size_t found = 0;
    for (std::size_t f = 0; f < coarse.triangles.size(); ++f) {
        for (std::size_t g = f + 1; g < coarse.triangles.size(); ++g) {
            const std::vector<std::array<std::uint32_t, 3>> pair{coarse.triangles[f], coarse.triangles[g]};
            found += double_curve(coarse.vertices, pair).size();
        }
    }
    CHECK(found > 20);
    CHECK(double_curve(coarse.vertices, coarse.triangles).size() == found);
}

TEST_CASE("a lattice deforms a stage of the eversion, which stays an immersion", "[films]") {
    const int n = GENERATE(0, 2, 4, 6);
    CAPTURE(n);
    const auto mesh = eversion_mesh(eversion().stage(n / 12.0), 16, 32);
    const cageform::Transform<double, 3> box{{Point3{3, 0, 0}, Point3{0, 3, 0}, Point3{0, 0, 3}},
                                             {-1.5, -1.5, -1.5}};
    std::array<cageform::LatticeAxis, 3> axes{};
    for (auto& axis : axes) axis.points = 5;
    const cageform::LatticeCoordinates<double, 3> lattice(axes, box);
    std::vector<Point3> pose(lattice.handles().begin(), lattice.handles().end());
    for (Point3& p : pose) { // a twist about the axis
        const double turn = 0.5 * p[2], c = std::cos(turn), s = std::sin(turn);
        p = {c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
    }
    const auto bound = cageform::bind(lattice, mesh.vertices);
    REQUIRE(bound);
    std::vector<Point3> rest(mesh.vertices.size()), moved(mesh.vertices.size());
    const std::vector<Point3> still(lattice.handles().begin(), lattice.handles().end());
    REQUIRE(cageform::clone(bound.value, still, rest) == cageform::Status::ok);
    for (std::size_t i = 0; i < rest.size(); ++i) REQUIRE(distance(rest[i], mesh.vertices[i]) == 0);
    REQUIRE(cageform::clone(bound.value, pose, moved) == cageform::Status::ok);
    const auto columns = cageform::bind_jacobians(lattice, mesh.vertices);
    REQUIRE(columns);
    CHECK(cageform::report_folds(columns.value, pose).least_determinant > 0.3);
}

// ---- plane_homotopy ----

TEST_CASE("curves that turn equally often are regularly homotopic", "[films]") {
    const int turns = GENERATE(range(-3, 4));
    const auto seed = GENERATE(range(0u, 6u));
    CAPTURE(turns, seed);
    const Homotopy homotopy(random_curve(turns, 2 * seed), random_curve(turns, 2 * seed + 1));
    const auto bound = homotopy.least_speed();
    CHECK(bound.least > 0);
    CHECK(bound.least <= bound.reached);
    for (const double s : {0.0, 0.31, 0.5, 0.77, 1.0}) {
        const auto points = homotopy.points(s);
        CHECK(std::abs(points.back() - points.front()) <= 1e-12);
        CHECK(std::fabs(homotopy.turns(s) - turns) <= 1e-9);
        for (const Complex& v : homotopy.velocities(s)) REQUIRE(std::abs(v) >= bound.least - 1e-12);
    }
}

TEST_CASE("from the circle to a curve with loops no correction is needed", "[films]") {
    const Homotopy homotopy({1}, {1, {0, 2.5}});
    for (const double s : {0.0, 0.2, 0.5, 0.9, 1.0}) {
        for (const Complex& v : homotopy.velocities(s)) REQUIRE(std::fabs(std::abs(v) - 1) <= 1e-12);
    }
}

TEST_CASE("curves of turning number 0 that cancel each other get other starting points", "[films]") {
    const double a = 2.404825557695773;
    const Homotopy homotopy({0, {a}}, {0, {-a, 0.3}});
    CHECK(homotopy.start() > 0);
    CHECK(homotopy.least_speed().least > 0.01);
    CHECK(std::fabs(homotopy.turns(0.5)) <= 1e-9);
}

TEST_CASE("between curves with different turning numbers the velocity vanishes somewhere", "[films]") {
    const auto seed = GENERATE(range(0u, 20u));
    CAPTURE(seed);
    const int from_turns = int(seed % 4) - 1, to_turns = from_turns + (seed % 3 == 0 ? 2 : 1);
    const TurningCurve from = random_curve(from_turns, seed), to = random_curve(to_turns, seed + 100);
    const Homotopy homotopy(from, to);
    CHECK_FALSE(homotopy.is_regular());
    const auto stops = homotopy.stops();
    CHECK(int(stops.size()) >= to_turns - from_turns);
    for (const auto& stop : stops) {
        CHECK(stop.speed <= 1e-13);
        CHECK(stop.s > 0);
        CHECK(stop.s < 1);
    }
    CHECK(std::fabs(homotopy.turns(0) - from_turns) <= 1e-9);
    CHECK(std::fabs(homotopy.turns(1) - to_turns) <= 1e-9);
}

TEST_CASE("from the circle to its mirror image the velocity vanishes halfway", "[films]") {
    const auto stops = Homotopy({1}, {-1}).stops();
    REQUIRE(stops.size() == 2);
    for (const auto& stop : stops) {
        CHECK(std::fabs(stop.s - 0.5) <= 1e-12);
        CHECK(stop.speed <= 1e-15);
    }
}

// ---- zooms ----

using Kind = SelfSimilarCurve::Kind;

TEST_CASE("a level's corners stay in the next one", "[films]") {
    const auto kind = GENERATE(Kind::koch, Kind::peano, Kind::sierpinski);
    const SelfSimilarCurve curve(kind);
    for (int level = 0; level < 4; ++level) {
        for (const double grown : {0.0, 0.4, 1.0}) {
            const auto corners = curve.corners(level), finer = curve.corners(level, grown);
            const std::size_t step = grown > 0 ? curve.parts() : 1;
            REQUIRE(finer.size() == (corners.size() - 1) * step + 1);
            for (std::size_t k = 0; k < corners.size(); ++k) REQUIRE(finer[k * step] == corners[k]);
        }
        const auto grown = curve.corners(level, 1), next = curve.corners(level + 1);
        REQUIRE(grown == next);
    }
}

TEST_CASE("lengths, areas and dimensions of self-similar curves are those of theory", "[films]") {
    const SelfSimilarCurve koch(Kind::koch), peano(Kind::peano), sierpinski(Kind::sierpinski);
    for (int level = 0; level <= 5; ++level) {
        const auto corners = koch.corners(level);
        CHECK(std::fabs(length_of(corners) / 3 - std::pow(4.0 / 3, level)) <= 1e-12 * double(corners.size()));
        const double area = 1 + 0.6 * (1 - std::pow(4.0 / 9, level));
        CHECK(std::fabs(area_of(corners) / (std::sqrt(3.0) / 4) - area) <= 1e-12 * double(corners.size()));
        CHECK(std::fabs(length_of(sierpinski.corners(level)) - 4 * std::pow(2, level)) <= 1e-9);
        if (level <= 4) CHECK(std::fabs(length_of(peano.corners(level)) - std::pow(3, level)) <= 1e-9);
    }
    CHECK(std::fabs(koch.dimension() - 1.261860) <= 5e-7);
    CHECK(std::fabs(peano.dimension() - 2) <= 1e-15);
    CHECK(std::fabs(sierpinski.dimension() - 2) <= 1e-15);
}

/// The pixels of a frame that the curve passes.
std::vector<bool> pixels_of(const SelfSimilarCurve& curve, int level, double time) {
    constexpr std::size_t size = 160;
    Picture picture(size, size);
    const auto line = curve.frame(level, time);
    for (std::size_t k = 1; k < line.size(); ++k)
        picture.line({size * line[k - 1].real(), size * line[k - 1].imag()},
                     {size * line[k].real(), size * line[k].imag()}, 1.5, {0, 0, 0});
    std::vector<bool> dark;
    for (std::size_t i = 0; i < size * size; ++i) dark.push_back(picture.at(i % size, i / size).r < 0.5f);
    return dark;
}

TEST_CASE("the first and last frame of a zoom are equal", "[films]") {
    const auto kind = GENERATE(Kind::koch, Kind::peano, Kind::sierpinski);
    const SelfSimilarCurve curve(kind);
    for (int level = 1; level <= (kind == Kind::peano ? 2 : 3); ++level) {
        const auto first = pixels_of(curve, level, 0), last = pixels_of(curve, level, 1),
                   between = pixels_of(curve, level, 0.5);
        std::size_t unlike = 0, moved = 0;
        for (std::size_t i = 0; i < first.size(); ++i) {
            unlike += first[i] != last[i] ? 1 : 0;
            moved += first[i] != between[i] ? 1 : 0;
        }
        CAPTURE(level);
        CHECK(double(unlike) <= 0.005 * double(first.size()));
        CHECK(double(moved) > 0.02 * double(first.size()));
    }
}

} // namespace films_test

// Gradients of harmonic coordinates, in polygons and boxes.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/gradients.hpp"
#include "../support/larger.hpp"
#include "../support/oracle.hpp"
#include "../support/weights.hpp"

#include <cageform/cage/box_mesh.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>
#include <cageform/parallel/threads.hpp>

namespace harmonic_gradients_tests {

using namespace cageform_tests;
using cageform::epsilon;
using cageform::HarmonicCoordinates;
using cageform::HarmonicOptions;
using cageform::Polygon;

namespace {

/// Σ ∇h_i = 0 and Σ C_i ∇h_i = identity, the consequences of linear precision.
template <class T, std::size_t D, class Coordinates>
void check_laws(const Coordinates& coordinates, const std::vector<Vec<T, D>>& points, double tolerance) {
    const auto gradients = gradients_of<T, D>(coordinates, points);
    REQUIRE(gradients.evaluation.status == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, points[i][0], points[i][1]);
        if (gradients.states[i] == PointState::unreached) continue;
        const auto centre = vec_cast<double>(points[i]);
        Vec<double, D> sum{};
        std::array<Vec<double, D>, D> jacobian{};
        double size = 0;
        for (std::size_t h = 0; h < gradients.rows[i].size(); ++h) {
            const auto g = vec_cast<double>(gradients.rows[i][h]);
            const auto c = vec_cast<double>(coordinates.handles()[h]) - centre;
            size = cageform_tests::larger(size, std::sqrt(dot(c, c)));
            sum = sum + g;
            for (std::size_t k = 0; k < D; ++k) jacobian[k] = jacobian[k] + c[k] * g;
        }
        for (std::size_t k = 0; k < D; ++k) {
            CHECK(std::fabs(sum[k]) * size <= tolerance);
            for (std::size_t l = 0; l < D; ++l)
                CHECK(std::fabs(jacobian[k][l] - (k == l ? 1 : 0)) <= tolerance);
        }
    }
}

/// The error of differences over at least a tenth of a cell, of sums of functions with the solver's error.
template <class T>
double tolerance(std::size_t handles, double cells) {
    return double(handles) * cells * 10 * (1e-8 + 2 * double(epsilon<T>));
}

} // namespace

TEMPLATE_TEST_CASE("gradients keep linear precision up to the boundary",
                   "[coordinates][harmonic][gradients][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(6, 2)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 9);
    const Polygon<T> star(random_star<T>(std::uint64_t(seed)));
    std::vector<Vec<T, 2>> in_plane;
    for (int n = 0; n < 60; ++n) in_plane.push_back(random_inside(star, random, 1e-5));
    for (std::size_t i = 0; i < star.size(); ++i) // vertices and points on edges
        in_plane.push_back(T(0.5) * (star[i] + star[i % 2 == 0 ? i : (i + 1) % star.size()]));
    const HarmonicOptions options{.resolution = 120, .multigrid = {.tolerance = 1e-8}};
    check_laws<T, 2>(HarmonicCoordinates<T, 2>(star, options, cageform::UniformGrid{}), in_plane,
                     tolerance<T>(star.size(), 120));
}

TEST_CASE("gradients in boxes keep linear precision up to the boundary",
          "[coordinates][harmonic][gradients][property]") {
    using T = double;
    const int seed = GENERATE(seeds(effort(6, 2)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 9);
    const Vec<T, 3> lower{T(-1), T(2), T(0)}, upper{T(0.3), T(3), T(2)};
    const auto box = cageform::box_mesh(lower, upper, {1 + std::size_t(seed) % 3, 2, 3});
    std::vector<Vec<T, 3>> in_space;
    for (int n = 0; n < 60; ++n) {
        Vec<T, 3> p;
        for (std::size_t k = 0; k < 3; ++k) p[k] = T(random.uniform(double(lower[k]), double(upper[k])));
        if (n % 10 == 0) p[std::size_t(n) / 10 % 3] = upper[std::size_t(n) / 10 % 3];
        in_space.push_back(p);
    }
    check_laws<T, 3>(HarmonicCoordinates(box, {.resolution = 24, .multigrid = {.tolerance = 1e-8}},
                                         cageform::UniformGrid{}),
                     in_space, tolerance<T>(box.size(), 24));
}

TEST_CASE("gradients converge", "[coordinates][harmonic][gradients]") {
    // On the unit square the functions are bilinear. The reference for the hexagon are differences of a finer
    // grid.
    const Polygon<double> square(Points2<double>{{0, 0}, {1, 0}, {1, 1}, {0, 1}});
    const std::vector<Vec<double, 2>> points{{0.3, 0.4}, {0.01, 0.7}, {0.99, 0.002}, {0.5, 0}, {0, 0}};
    const auto of_square = gradients_of<double, 2>(
        HarmonicCoordinates<double, 2>(square, {.resolution = 50}, cageform::UniformGrid{}), points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto [x, y] = std::pair(points[i][0], points[i][1]);
        // Gradients on the boundary are taken half a cell inside, with this change.
        const double allowed = of_square.states[i] == PointState::on_boundary ? 0.501 / 50 : 3e-4;
        CHECK(distance(of_square.rows[i][0], Vec<double, 2>{y - 1, x - 1}) <= allowed);
        CHECK(distance(of_square.rows[i][2], Vec<double, 2>{y, x}) <= allowed);
    }
    const auto cage = read_oracle("harmonic2d_hexagon").cage<double>();
    Random random(5);
    std::vector<Vec<double, 2>> inside;
    const double size = size_of(cage.vertices());
    for (int n = 0; n < 100; ++n) inside.push_back(random_inside(cage, random, 0.06 * size));
    const auto at = [&](std::size_t resolution) {
        return gradients_of<double, 2>(
            HarmonicCoordinates<double, 2>(
                cage, {.resolution = resolution, .multigrid = {.tolerance = 1e-10}}, cageform::UniformGrid{}),
            inside);
    };
    const auto exact = at(256);
    std::array<double, 2> error{};
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
        const auto coarse = at(k == 0 ? 24 : 96);
        for (std::size_t i = 0; i < inside.size(); ++i) {
            for (std::size_t h = 0; h < cage.size(); ++h)
                error[k] =
                    cageform_tests::larger(error[k], distance(coarse.rows[i][h], exact.rows[i][h]) * size);
        }
    }
    CHECK(error[0] <= 3e-2);
    CHECK(error[1] <= error[0] / 8); // order h² would be a sixteenth
}

TEST_CASE("gradients are unreached where they do not exist", "[coordinates][harmonic][gradients][status]") {
    const Polygon<double> cage(random_star<double>(3));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Vec<double, 2>> points{{1e9, 0}, {nan, 0}};
    HarmonicCoordinates<double, 2> coordinates(cage, {.resolution = 64}, cageform::UniformGrid{});
    const auto gradients = gradients_of<double, 2>(coordinates, points);
    CHECK(gradients.evaluation.status == Status::ok);
    CHECK(gradients.states[0] == PointState::outside);
    CHECK(gradients.states[1] == PointState::not_finite);
}

TEMPLATE_TEST_CASE("gradients are bitwise equal on threads, after a solve, and for part of the points",
                   "[coordinates][harmonic][gradients]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(2));
    CAPTURE(seed);
    const Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
    HarmonicCoordinates<T, 2> coordinates(cage, {.resolution = 40}, cageform::UniformGrid{});
    // More than one batch per thread: inside, on edges, far outside, not finite.
    Random random(std::uint64_t(seed) + 1);
    std::vector<Vec<T, 2>> points;
    while (points.size() < 1501) {
        points.push_back(random_inside(cage, random, 1e-3));
        const std::size_t i = points.size();
        if (i % 7 == 0) points.push_back(cage[i % cage.size()]);
        if (i % 11 == 0) points.push_back({T(1e9), T(0)});
        if (i % 13 == 0) points.push_back({std::numeric_limits<T>::quiet_NaN(), T(0)});
    }
    const auto expected = gradients_of<T, 2>(coordinates, points);
    REQUIRE(expected.evaluation.status == Status::ok);
    const auto check = [&](const std::vector<Vec<T, 2>>& some, std::size_t first, const auto& running) {
        const auto found = gradients_of<T, 2>(coordinates, some, running);
        std::size_t differ = 0;
        for (std::size_t i = 0; i < some.size(); ++i) {
            const PointState state = found.states[i];
            differ += state == expected.states[first + i] ? 0 : 1;
            if (state != PointState::inside && state != PointState::on_boundary) continue;
            for (std::size_t h = 0; h < cage.size(); ++h)
                differ += found.rows[i][h] == expected.rows[first + i][h] ? 0 : 1;
        }
        CHECK(differ == 0);
    };
    cageform::Running threaded;
    threaded.parallel = cageform::ThreadedFor{2};
    check(points, 0, threaded);
    REQUIRE(coordinates.solve(threaded).status == Status::ok);
    check(points, 0, cageform::Running{});
    check(points, 0, threaded);
    check({points.begin() + 100, points.begin() + 153}, 100, threaded);
}

} // namespace harmonic_gradients_tests

// Harmonic coordinates by multigrid: the laws to the solver's tolerance at every resolution, and the oracle.
#include "catch.hpp"
#include "support/effort.hpp"
#include "support/larger.hpp"
#include "support/oracle.hpp"
#include "support/uniform_harmonic.hpp"
#include "support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/parallel/threads.hpp>

#include <numeric>

namespace harmonic_multigrid_tests {

using namespace cageform_tests;
using cageform::epsilon;
using cageform::HarmonicOptions;
using cageform::Polygon;

namespace {

template <class T>
using Harmonic = UniformHarmonic<T, 2>;

template <class T>
Points2<T> points_in(const Polygon<T>& cage, std::size_t count, std::uint64_t seed) {
    Random random(seed);
    Points2<T> points(count);
    for (auto& p : points) p = random_inside(cage, random, 1e-4);
    return points;
}

} // namespace

TEST_CASE("multigrid weights converge to the oracle", "[coordinates][harmonic][oracle]") {
    // Largest errors measured at 64, 256 and 1024 cells, plus a fifth and the solver's tolerance, at points
    // up to 1e-5 diagonals from a corner. At 64 cells the gap between the biped's legs is two cells wide.
    struct Case {
        const char* name;
        double error_64, error_256, error_1024;
    };
    constexpr std::array cases{Case{"triangle", 2e-6, 2e-6, 2e-6},
                               Case{"unit_square", 2e-6, 2e-6, 2e-6},
                               Case{"rectangle", 2e-6, 2e-6, 2e-6},
                               Case{"square_extra_vertex", 2.0e-5, 4.5e-6, 1.3e-6},
                               Case{"hexagon", 6.1e-5, 1.6e-5, 1.6e-6},
                               Case{"l_shape", 2.3e-5, 1.4e-5, 1.8e-6},
                               Case{"star", 1.5e-4, 2.3e-5, 3.0e-6},
                               Case{"spiral", 2.0e-4, 1.8e-5, 3.1e-6},
                               Case{"biped", 9.1e-4, 5.2e-5, 5.5e-6},
                               Case{"cat", 7.2e-4, 1.3e-4, 1.3e-5},
                               Case{"hole_square_square_hole", 3.0e-4, 3.5e-5, 3.2e-6},
                               Case{"straight_chain_square_straight_chain", 1.1e-4, 1.1e-5, 3.2e-6},
                               Case{"splitting_chain_hexagonlike_split_chain", 9.0e-5, 2.4e-5, 3.2e-6},
                               Case{"hole_hexagon_triangle_hole", 1.5e-4, 3.7e-5, 3.0e-6}};
    for (const Case& c : cases) {
        const auto oracle = read_oracle(std::string("harmonic2d_") + c.name);
        const auto cage = oracle.complex<double>();
        for (const auto& [resolution, allowed] :
             {std::pair<std::size_t, double>{64, c.error_64}, {256, c.error_256}, {1024, c.error_1024}}) {
            CAPTURE(c.name, resolution);
            if (resolution > effort(256u, 64u) && (effort(false, true) || c.name != std::string("biped")))
                continue;
            const auto weights = evaluate_all(
                cageform::HarmonicCoordinates(cage, {.resolution = resolution}, cageform::UniformGrid{}),
                oracle.points);
            REQUIRE(weights.status() == Status::ok);
            CHECK(weights.evaluation.solver.multigrid.error_estimate <= 1e-6);
            CHECK(weights.evaluation.solver.multigrid.convergence_factor <= 0.2);
            double error = 0;
            for (std::size_t i = 0; i < oracle.points.size(); ++i)
                error = cageform_tests::larger(error, difference(weights.rows[i], oracle.coordinates[i]));
            CHECK(error <= allowed);
        }
    }
}

TEMPLATE_TEST_CASE("multigrid weights sum to 1, reproduce the point and stay in [0, 1] at every resolution",
                   "[coordinates][harmonic][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(12, 6)));
    const std::size_t resolution = GENERATE(std::size_t{40}, effort<std::size_t>(150, 70));
    CAPTURE(seed, resolution);
    const auto cage = seed % 3 == 0 ? random_rings<T>(std::uint64_t(seed))
                                    : Polygon<T>(random_star<T>(std::uint64_t(seed)));
    const auto points = points_in(cage, 200, std::uint64_t(seed));
    const auto weights = evaluate_all(Harmonic<T>(cage, {.resolution = resolution}), points);
    if (weights.status() == Status::grid_too_coarse) { // a thin ring of the random cage
        CHECK(weights.evaluation.solver.unseen_handle < cage.size());
        CHECK(weights.evaluation.solver.sufficient_resolution > resolution);
        return;
    }
    REQUIRE(weights.status() == Status::ok);
    const double m = double(cage.size());
    const double size = size_of(cage.vertices()); // each function has an error up to the tolerance
    for (std::size_t i = 0; i < points.size(); ++i) {
        CHECK(std::fabs(double(sum_of(weights.rows[i])) - 1) <= m * (1e-6 + double(epsilon<T>)));
        CHECK(distance(combine(weights.rows[i], cage.vertices()), points[i]) <=
              m * (1e-6 + 4 * double(epsilon<T>)) * size);
        for (const T w : weights.rows[i]) CHECK((w >= T(0) && w <= T(1)));
    }
}

TEST_CASE("bind by the multigrid changes weights by at most the solver's error",
          "[coordinates][harmonic][binding]") {
    const Polygon<double> cage(random_star<double>(5));
    const auto report =
        cageform::bind(Harmonic<double>(cage, {.resolution = 64}), points_in(cage, 300, 5)).report;
    REQUIRE(report.status == Status::ok);
    CHECK(report.weight_change.value <= 1e-6 * double(cage.size()));
    CHECK(report.least_weight.value >= -report.weight_change.value - 1e-15);
    CHECK(report.solver.solves == cage.size());
    CHECK(report.solver.multigrid.cycles > 0);
    CHECK(report.solver.multigrid.error_bound >= report.solver.multigrid.error_estimate);
}

TEST_CASE("solving before, in batches or on threads gives the same bits",
          "[coordinates][harmonic][threads]") {
    std::uint64_t seed = 0; // a cage whose functions are solved in three groups
    while (random_star<double>(seed).size() <= 32) ++seed;
    const Polygon<double> cage(random_star<double>(seed));
    const auto points = points_in(cage, 100, 2);
    Harmonic<double> coordinates(cage, {.resolution = 96, .multigrid = {.tolerance = 1e-11}});
    const auto expected = evaluate_all(coordinates, points);
    REQUIRE(expected.status() == Status::ok);
    cageform::Running threaded;
    threaded.parallel = cageform::ThreadedFor{3};
    CHECK(evaluate_all(coordinates, points, threaded).rows == expected.rows);
    REQUIRE(coordinates.solve(threaded).status == Status::ok);
    CHECK(evaluate_all(coordinates, points).rows == expected.rows);
    CHECK(evaluate_all(coordinates, points).evaluation.solver.solves == cage.size());
    for (std::size_t begin = 0; begin < points.size(); begin += 20) {
        const Points2<double> batch(points.begin() + std::ptrdiff_t(begin),
                                    points.begin() + std::ptrdiff_t(begin + 20));
        const auto weights = evaluate_all(coordinates, batch);
        for (std::size_t i = 0; i < 20; ++i) CHECK(weights.rows[i] == expected.rows[begin + i]);
    }
}

TEST_CASE("the multigrid reports progress and can be cancelled", "[coordinates][harmonic][progress]") {
    const Polygon<double> cage(random_star<double>(31));
    const auto points = points_in(cage, 10, 2);
    const Harmonic<double> coordinates(cage, {.resolution = 64});
    double last = 0;
    int calls = 0;
    cageform::Running options;
    options.progress = [&](double done) {
        CHECK(done >= last);
        CHECK(done <= 1);
        last = done;
        ++calls;
        return true;
    };
    CHECK(evaluate_all(coordinates, points, options).status() == Status::ok);
    CHECK(last == 1);
    CHECK(calls >= 5); // after each cycle
    const int stop_at = GENERATE(1, 3, 6);
    int asked = 0;
    options.progress = [&](double) { return ++asked < stop_at; };
    CHECK(evaluate_all(coordinates, points, options).status() == Status::cancelled);
    CHECK(asked == stop_at);
}

TEST_CASE("a solve that is cancelled keeps nothing", "[coordinates][harmonic][progress]") {
    const Polygon<double> cage(random_star<double>(7));
    const HarmonicOptions options{.resolution = 100};
    const auto points = points_in(cage, 20, 3);
    const auto expected = evaluate_all(Harmonic<double>(cage, options), points);
    Harmonic<double> coordinates(cage, options);
    cageform::Running stop;
    stop.progress = [](double done) { return done < 0.7; };
    CHECK(coordinates.solve(stop).status == Status::cancelled);
    CHECK(evaluate_all(coordinates, points).rows == expected.rows);
    CHECK(coordinates.solve().status == Status::ok);
    CHECK(evaluate_all(coordinates, points).rows == expected.rows);
}

TEST_CASE("a grid too coarse for a handle names it, and a sufficient resolution",
          "[coordinates][harmonic][status]") {
    const Points2<double> spiked{{0, 0}, {1, 0}, {1, 0.513}, {1.4, 0.518}, {1, 0.523}, {1, 1}, {0, 1}};
    const Points2<double> points{{0.5, 0.5}};
    const auto coarse = evaluate_all(Harmonic<double>(spiked, {.resolution = 16}), points);
    REQUIRE(coarse.status() == Status::grid_too_coarse);
    const auto& report = coarse.evaluation.solver;
    CHECK(report.unseen_handle < spiked.size());
    REQUIRE(report.sufficient_resolution > 16);
    CHECK(evaluate_all(Harmonic<double>(spiked, {.resolution = report.sufficient_resolution}), points)
              .status() == Status::ok);
}

TEST_CASE("the multigrid's memory is stated beforehand", "[coordinates][harmonic][memory]") {
    const Polygon<double> cage(random_star<double>(31));
    Harmonic<double> coordinates(cage, {.resolution = 128});
    const auto memory = coordinates.solver_memory();
    CHECK(memory.hierarchy > 0);
    const auto report = coordinates.solve().solver;
    CHECK(report.bytes == memory.hierarchy + memory.block);
    CHECK(Harmonic<double>(cage, {.resolution = 4}).solver_memory().block == 0);
}

TEST_CASE("a grid above the memory limit is refused before the solve", "[coordinates][harmonic][memory]") {
    const int seed = GENERATE(seeds(effort(4, 1)));
    const Polygon<double> cage(random_star<double>(std::uint64_t(seed)));
    const Points2<double> points = points_in(cage, 4, 1);
    CAPTURE(seed);
    HarmonicOptions options{.resolution = 16384};
    const auto most = evaluate_all(Harmonic<double>(cage, options), points);
    CHECK(most.status() == Status::out_of_memory);
    CHECK(most.evaluation.solver.bytes > options.memory_limit);

    options.resolution = 1000;
    options.memory_limit = 20'000'000;
    const auto refused = evaluate_all(Harmonic<double>(cage, options), points).evaluation.solver;
    REQUIRE(refused.sufficient_resolution >= 8);
    REQUIRE(refused.sufficient_resolution < 1000);
    options.resolution = refused.sufficient_resolution;
    Harmonic<double> fits(cage, options);
    const auto memory = fits.solver_memory();
    CHECK(memory.hierarchy + memory.block <= options.memory_limit);
    CHECK(memory.hierarchy + memory.block >= options.memory_limit / 3);
    CHECK(evaluate_all(fits, points).status() == Status::ok);
    if (cage.size() <= 16) return;
    const auto kept = fits.solve(); // several groups of functions do not fit
    CHECK(kept.status == Status::out_of_memory);
    CHECK(kept.solver.bytes > options.memory_limit);
}

TEST_CASE("corner functions reduce errors near corners", "[coordinates][harmonic][corners]") {
    for (const char* name : {"l_shape", "star", "hole_square_square_hole"}) {
        CAPTURE(name);
        const auto oracle = read_oracle(std::string("harmonic2d_") + name);
        const auto cage = oracle.cage<double>();
        std::array<double, 2> error{};
        for (const bool treat : {false, true}) {
            const auto weights = evaluate_all(
                Harmonic<double>(cage, {.resolution = 256, .multigrid = {.corner_functions = treat}}),
                oracle.points);
            REQUIRE(weights.status() == Status::ok);
            for (std::size_t i = 0; i < oracle.points.size(); ++i)
                error[treat ? 1 : 0] =
                    std::max(error[treat ? 1 : 0], difference(weights.rows[i], oracle.coordinates[i]));
        }
        CHECK(error[1] < 0.01 * error[0]);
    }
}

namespace {

/// Legs below a body, with gaps of 0.02 to 0.25.
Polygon<double> random_legs(std::uint64_t seed) {
    Random random(seed);
    const auto width = [&](double from, double to) {
        return from * std::pow(to / from, random.uniform(0, 1));
    };
    Points2<double> outline;
    const std::size_t legs = 2 + random.below(3);
    double x = 0;
    for (std::size_t leg = 0; leg < legs; ++leg) {
        const double length = random.uniform(0.3, 0.8);
        outline.push_back({x, -length});
        x += width(0.02, 0.3);
        outline.push_back({x, -length * random.uniform(0.9, 1)});
        if (leg + 1 == legs) break;
        outline.push_back({x, 0});
        x += width(0.02, 0.25);
        outline.push_back({x, random.uniform(-0.01, 0.01)});
    }
    outline.push_back({x, 0.3});
    outline.push_back({0, 0.35});
    const double turn = random.uniform(0, 2 * std::numbers::pi), c = std::cos(turn), s = std::sin(turn);
    for (auto& p : outline) p = {c * p[0] - s * p[1], s * p[0] + c * p[1]};
    return Polygon<double>(outline);
}

/// Points within two cells of every vertex, and anywhere.
Points2<double> points_about_corners(const Polygon<double>& cage, double cell, std::uint64_t seed) {
    Random random(seed);
    auto points = points_in(cage, 40, seed);
    for (const auto& vertex : cage.vertices()) {
        for (int n = 0; n < 16; ++n) {
            const double turn = random.uniform(0, 2 * std::numbers::pi);
            const double distance = cell * std::pow(10.0, random.uniform(-2, 0.3));
            const auto p = vertex + distance * Vec<double, 2>{std::cos(turn), std::sin(turn)};
            if (locate(cage, p, 1e-12) == PointState::inside) points.push_back(p);
        }
    }
    return points;
}

} // namespace

TEST_CASE("no error is above the largest that the report expects at a corner, nor far below it",
          "[coordinates][harmonic][corners][property]") {
    constexpr double with_room = 5e-4; // if all corners have ten free cells
    double decades = 0;
    int notable = 0;
    for (int seed = 0; seed < effort(5, 4); ++seed) {
        const auto cage = seed % 4 == 3 ? Polygon<double>(random_star<double>(std::uint64_t(seed)))
                                        : random_legs(std::uint64_t(seed));
        const auto bounds = cageform::bounds_of(cage.vertices());
        const auto points = points_about_corners(cage, bounds.diagonal() / 60, std::uint64_t(seed));
        const auto fine = evaluate_all(Harmonic<double>(cage, {.resolution = 320}), points);
        const auto error_at = [&](std::size_t resolution, cageform::CornerError& worst) {
            const auto weights = evaluate_all(Harmonic<double>(cage, {.resolution = resolution}), points);
            worst = weights.evaluation.solver.worst_corner();
            double error = weights.status() == Status::ok ? 0 : 1;
            for (std::size_t i = 0; i < points.size(); ++i)
                error = cageform_tests::larger(error, difference(weights.rows[i], fine.rows[i]));
            return error;
        };
        CAPTURE(seed);
        REQUIRE(fine.status() == Status::ok);
        cageform::CornerError worst, then;
        const double error = error_at(40, worst);
        CAPTURE(worst.handles[0], worst.resolution);
        CHECK(error <= std::max(worst.error, with_room));
        CHECK(worst.error <= 1);
        if (error > 1e-3) {
            decades += std::log10(worst.error / error);
            ++notable;
        }
        CHECK((worst.resolution > 40) == (worst.error > cageform::CornerError::notable));
        if (worst.resolution == 0 || worst.resolution > 200) continue;
        CHECK(error_at(worst.resolution, then) <= cageform::CornerError::notable);
        CHECK(then.error <= 2 * cageform::CornerError::notable);
    }
    REQUIRE(notable >= 2);
    CHECK(decades / notable <= 1.3); // a factor of twenty, in the geometric mean
}

TEST_CASE("the expected errors of untreated corners are those found", "[coordinates][harmonic][corners]") {
    for (const char* name : {"l_shape", "star", "hole_square_square_hole", "cat"}) {
        CAPTURE(name);
        const auto oracle = read_oracle(std::string("harmonic2d_") + name);
        const auto weights = evaluate_all(
            cageform::HarmonicCoordinates(oracle.cage<double>(),
                                          {.resolution = 128, .multigrid = {.corner_functions = false}},
                                          cageform::UniformGrid{}),
            oracle.points);
        double error = 0;
        for (std::size_t i = 0; i < oracle.points.size(); ++i)
            error = cageform_tests::larger(error, difference(weights.rows[i], oracle.coordinates[i]));
        const double expected = weights.evaluation.solver.worst_corner().error;
        CHECK(error <= expected);
        CHECK(expected <= 20 * error);
    }
}

TEST_CASE("the adaptive grid takes no resolution, the uniform grid needs one", "[coordinates][harmonic]") {
    const auto star = random_star<double>(3);
    using Adaptive = cageform::HarmonicCoordinates<double, 2>;
    CHECK(Adaptive(star, {.resolution = 64}).solve().status == Status::solver_not_supported);
    CHECK(Harmonic<double>(star, {}).solve().status == Status::resolution_not_supported);
}

} // namespace harmonic_multigrid_tests

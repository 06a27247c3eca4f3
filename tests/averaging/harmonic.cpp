// Harmonic coordinates by the papers' averaging solver, whose cells on the boundary are a staircase.
#include "averaging/pyramid_solver.hpp"
#include "catch.hpp"
#include "support/effort.hpp"
#include "support/gradients.hpp"
#include "support/larger.hpp"
#include "support/meshes.hpp"
#include "support/oracle.hpp"
#include "support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/cage/box_mesh.hpp>

#include <array>

namespace harmonic_tests {

using namespace cageform_tests;
using cageform::epsilon;
using cageform::Polygon;
using namespace cageform_sources::averaging;

namespace {

struct Options {
    std::size_t resolution = 0;
    AveragingOptions averaging{.tolerance = 1e-6};
    Interpolation interpolation = Interpolation::multilinear;
    std::size_t handles_at_once = 16;
};

template <class C>
struct Averaged : cageform::HarmonicCoordinates<typename C::scalar, C::dimension> {
    template <class Cage>
    Averaged(const Cage& cage, const Options& options)
        : Averaged::HarmonicCoordinates(
              cage, {.resolution = options.resolution},
              AveragingSolver{options.averaging, options.interpolation, options.handles_at_once}) {}
};
template <class T>
using Harmonic = Averaged<Polygon<T>>;

constexpr std::array oracles{"triangle",
                             "unit_square",
                             "rectangle",
                             "square_extra_vertex",
                             "hexagon",
                             "l_shape",
                             "star",
                             "spiral",
                             "biped",
                             "cat",
                             "hole_square_square_hole",
                             "hole_hexagon_triangle_hole"};

/// The side of a cell.
template <class C>
double spacing(const C& cage, std::size_t resolution) {
    return double(lattice_about(cageform::bounds_of(cage.vertices()), resolution).spacing);
}

template <class T>
Points2<T> points_inside(const Polygon<T>& cage, int count, std::uint64_t seed) {
    Random random(seed);
    Points2<T> points;
    for (int i = 0; i < count; ++i) points.push_back(random_inside(cage, random, 0));
    return points;
}

template <class T>
const Points2<T> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};

} // namespace

TEMPLATE_TEST_CASE("harmonic weights come near the oracle as the grid becomes finer",
                   "[coordinates][harmonic][oracle]", CAGEFORM_SCALARS) {
    // A boundary cell holds data from up to √½ cells off, so the error is of first order at points a few
    // cells away from the boundary. Next to a corner it does not fall before the cells are smaller than the
    // distance (the oracle has points at 1e-4 of the cage). Largest errors measured at these resolutions,
    // over all points:
    //   triangle, squares, rectangle: 0.027, 0.021     hexagon: 0.036, 0.021
    //   others, not next to corners:  0.17,  0.063     next to corners: 0.31, 0.072
    // They follow from the cages' place on the grid, not from the seed of anything; the bounds are twice as
    // large.
    struct Level {
        std::size_t resolution;
        double simple, hexagon, other, corner, mean;
    };
    double mean_before = 1;
    for (const Level& level :
         {Level{32, 0.06, 0.08, 0.34, 0.62, 0.05}, Level{64, 0.04, 0.04, 0.13, 0.22, 0.025}}) {
        double sum = 0;
        std::size_t count = 0;
        for (const char* name : oracles) {
            const auto oracle = read_oracle(std::string("harmonic2d_") + name);
            REQUIRE(oracle.points.size() == 20);
            const auto cage = oracle.cage<TestType>();
            const Harmonic<TestType> coordinates(
                cage, {.resolution = level.resolution, .averaging = {.tolerance = 1e-7}});
            const auto weights = evaluate_all(coordinates, oracle.points);
            REQUIRE(weights.status() == Status::ok);
            const std::string kind(name);
            for (std::size_t i = 0; i < oracle.points.size(); ++i) {
                CAPTURE(name, level.resolution, i, oracle.tags[i], text(weights.rows[i]));
                const double error = difference(weights.rows[i], oracle.coordinates[i]);
                const bool next_to_corner = oracle.tags[i].starts_with("near_corner");
                const bool simple = kind == "triangle" || kind == "rectangle" || kind == "unit_square" ||
                                    kind == "square_extra_vertex";
                CHECK(error <= (simple              ? level.simple
                                : kind == "hexagon" ? level.hexagon
                                : next_to_corner    ? level.corner
                                                    : level.other));
                CHECK(weights.states[i] == PointState::inside); // never unreached
                if (oracle.tags[i] != "interior") continue;
                sum += error;
                ++count;
            }
        }
        const double mean = sum / double(count);
        CAPTURE(level.resolution, mean);
        CHECK(mean <= level.mean);
        CHECK(mean < 0.7 * mean_before); // first order would halve it
        mean_before = mean;
    }
}

TEMPLATE_TEST_CASE("harmonic weights are in [0, 1] and sum to 1", "[coordinates][harmonic][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(20, 5)));
    const auto interpolation = GENERATE(Interpolation::nearest_cell, Interpolation::multilinear);
    CAPTURE(seed, int(interpolation));
    const auto cage = seed % 2 == 0 ? Polygon<T>(random_star<T>(std::uint64_t(seed)))
                                    : random_rings<T>(std::uint64_t(seed));
    const double tolerance = sizeof(T) == 4 ? 1e-7 : 1e-13;
    const Harmonic<T> coordinates(
        cage, {.resolution = 40, .averaging = {.tolerance = tolerance}, .interpolation = interpolation});
    const auto points = points_inside(cage, 100, std::uint64_t(seed) + 100);
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    const double h = spacing(cage, 40);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (weights.states[i] == PointState::unreached) continue;
        CAPTURE(i, text(weights.rows[i]));
        CHECK(*std::min_element(weights.rows[i].begin(), weights.rows[i].end()) >= T(0));
        CHECK(*std::max_element(weights.rows[i].begin(), weights.rows[i].end()) <= 1 + 4 * epsilon<T>);
        // The sweeps end when a cell changes by `tolerance` in the mean; the way left is longer than that
        // by the square of the cells across.
        CHECK(std::fabs(double(sum_of(weights.rows[i]) - 1)) <= 40 * 40 * tolerance);
        // Values lie up to √½ cells off their place at the boundary, a sample leaves out cells up to √2 off
        // or looks up one up to √½ off; the maximum principle does the rest.
        CHECK(distance(combine(weights.rows[i], cage.vertices()), points[i]) <= (2.13 + 0.01) * h);
    }
}

TEST_CASE("harmonic weights are not negative in the biped", "[coordinates][harmonic][property]") {
    const auto cage = read_oracle("harmonic2d_biped").cage<double>();
    const auto points = points_inside(cage, 2000, 1);
    const Harmonic<double> coordinates(cage, {.resolution = 64, .averaging = {.tolerance = 1e-7}});
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    double least = 1;
    for (const auto& row : weights.rows) least = std::min({least, row[1], row[2], row[5], row[6]});
    CHECK(least >= 0);
}

TEST_CASE("harmonic weights have no maximum inside", "[coordinates][harmonic][property]") {
    // A cell is the mean of its neighbours, so in one of the four directions a weight does not fall.
    const auto cage = read_oracle("harmonic2d_star").cage<double>();
    Harmonic<double> coordinates(
        cage,
        {.resolution = 64, .averaging = {.tolerance = 1e-12}, .interpolation = Interpolation::nearest_cell});
    REQUIRE(coordinates.solve().status == Status::ok);
    const double h = spacing(cage, 64);
    Random random(2);
    for (int n = 0; n < 100; ++n) {
        const auto p = random_inside(cage, random, 3 * h / cageform::bounds_of(cage.vertices()).diagonal());
        const auto w =
            evaluate_all(
                coordinates,
                Points2<double>{p, {p[0] - h, p[1]}, {p[0] + h, p[1]}, {p[0], p[1] - h}, {p[0], p[1] + h}})
                .rows;
        for (std::size_t i = 0; i < cage.size(); ++i) {
            CAPTURE(n, i);
            CHECK(std::fabs(w[0][i] - (w[1][i] + w[2][i] + w[3][i] + w[4][i]) / 4) <= 1e-9);
            CHECK(w[0][i] <= std::max({w[1][i], w[2][i], w[3][i], w[4][i]}) + 1e-9);
        }
    }
}

TEMPLATE_TEST_CASE("solving once and evaluating in batches gives the bits of evaluating at once",
                   "[coordinates][harmonic][solve]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(6, 2)));
    CAPTURE(seed);
    const auto cage = random_rings<T>(std::uint64_t(seed));
    const auto points = points_inside(cage, 60, std::uint64_t(seed) + 200);
    const Options options{.resolution = 32, .averaging = {.tolerance = 1e-6}};
    const auto expected = evaluate_all(Harmonic<T>(cage, options), points);
    REQUIRE(expected.status() == Status::ok);
    CHECK(expected.evaluation.solver.solves == cage.size());

    for (const std::size_t group : {std::size_t(0), std::size_t(1), std::size_t(3), std::size_t(1000)}) {
        Options other = options;
        other.handles_at_once = group;
        const auto weights = evaluate_all(Harmonic<T>(cage, other), points);
        CAPTURE(group);
        CHECK(weights.rows == expected.rows);
        CHECK(weights.states == expected.states);
        CHECK(weights.evaluation.solver.relaxation.sweeps == expected.evaluation.solver.relaxation.sweeps);
    }

    Harmonic<T> coordinates(cage, options);
    const auto solved = coordinates.solve();
    REQUIRE(solved.status == Status::ok);
    CHECK(solved.solver.solves == cage.size());
    CHECK(solved.solver.relaxation.sweeps == expected.evaluation.solver.relaxation.sweeps);
    for (std::size_t begin = 0; begin < points.size(); begin += 20) {
        const Points2<T> batch(points.begin() + std::ptrdiff_t(begin),
                               points.begin() + std::ptrdiff_t(begin + 20));
        const auto weights = evaluate_all(coordinates, batch);
        REQUIRE(weights.status() == Status::ok);
        CHECK(weights.evaluation.solver.solves == cage.size()); // that of the solve
        for (std::size_t i = 0; i < 20; ++i) {
            CHECK(weights.rows[i] == expected.rows[begin + i]);
            CHECK(weights.states[i] == expected.states[begin + i]);
        }
    }
    const Harmonic<T> copy = coordinates; // with what was solved
    CHECK(evaluate_all(copy, points).rows == expected.rows);
    CHECK(evaluate_all(copy, points).evaluation.solver.relaxation.sweeps ==
          expected.evaluation.solver.relaxation.sweeps);
}

TEMPLATE_TEST_CASE("harmonic states are those of locate, or unreached", "[coordinates][harmonic][state]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(20, 5)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 300);
    const auto cage = random_rings<T>(std::uint64_t(seed));
    const auto bounds = cageform::bounds_of(cage.vertices());
    Points2<T> points;
    for (int i = 0; i < 200; ++i) {
        Vec<T, 2> p{};
        for (std::size_t k = 0; k < 2; ++k) {
            const double reach = double(bounds.upper[k] - bounds.lower[k]);
            p[k] = T(
                random.uniform(double(bounds.lower[k]) - 0.3 * reach, double(bounds.upper[k]) + 0.3 * reach));
        }
        points.push_back(p);
    }
    for (std::size_t edge = 0; edge < cage.size(); ++edge)
        points.push_back(on_edge(cage, edge, random.uniform(0, 1)).position);
    const T nan = std::numeric_limits<T>::quiet_NaN();
    points.push_back({nan, 0});
    points.push_back({bounds.lower[0], std::numeric_limits<T>::infinity()});
    const auto weights =
        evaluate_all(Harmonic<T>(cage, {.resolution = 48, .averaging = {.tolerance = 1e-4}}), points);
    REQUIRE(weights.status() == Status::ok);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        const auto expected = cageform::locate(cage, points[i], cageform::coincidence_tolerance(bounds));
        CHECK(weights.states[i] == expected); // 48 cells reach every point of these cages
        inside += expected == PointState::inside;
    }
    CHECK(inside > 5);
}

TEST_CASE("every point inside is reached, by the coarsest grid too", "[coordinates][harmonic][state]") {
    // The cell that holds a point inside is of the boundary or interior, never exterior.
    for (const char* name : oracles) {
        const auto cage = read_oracle(std::string("harmonic2d_") + name).cage<double>();
        const auto points = points_inside(cage, 300, 3);
        for (const auto interpolation : {Interpolation::nearest_cell, Interpolation::multilinear}) {
            const auto weights = evaluate_all(Harmonic<double>(cage, {.resolution = 8,
                                                                      .averaging = {.tolerance = 1e-3},
                                                                      .interpolation = interpolation}),
                                              points);
            REQUIRE(weights.status() == Status::ok);
            CAPTURE(name, int(interpolation));
            CHECK(std::count(weights.states.begin(), weights.states.end(), PointState::inside) == 300);
        }
    }
}

TEST_CASE("harmonic coordinates sample the nearest cell or between cells",
          "[coordinates][harmonic][sample]") {
    // 20 cells, margin of 2 on each side: the unit square takes 16 cells a side, the 16 about its border
    // and the ones beyond being boundary.
    const auto weight = [](Interpolation interpolation, Vec<double, 2> p) {
        const Harmonic<double> coordinates(
            square<double>,
            {.resolution = 20, .averaging = {.tolerance = 1e-13}, .interpolation = interpolation});
        std::array<double, 4> row{};
        CHECK(cageform::weights_at(coordinates, p, row) == PointState::inside);
        return row[2];
    };
    const double cell = 1.0 / 16;
    const auto at = [&](double x, double y) { return Vec<double, 2>{x * cell, y * cell}; };
    const double a = weight(Interpolation::nearest_cell, at(5.5, 7.5));
    const double b = weight(Interpolation::nearest_cell, at(6.5, 7.5));
    CHECK(b > a + 0.01);
    CHECK(weight(Interpolation::nearest_cell, at(5.01, 7.99)) == a);
    CHECK(weight(Interpolation::nearest_cell, at(5.99, 7.01)) == a);
    CHECK(weight(Interpolation::nearest_cell, at(6.01, 7.5)) == b);
    CHECK(weight(Interpolation::multilinear, at(5.5, 7.5)) == Approx(a).epsilon(0).margin(1e-15));
    CHECK(weight(Interpolation::multilinear, at(5.75, 7.5)) ==
          Approx(0.75 * a + 0.25 * b).epsilon(0).margin(1e-15));
}

TEST_CASE("a square's harmonic weights are bilinear but for the staircase", "[coordinates][harmonic]") {
    // The boundary cells at either side of the border (the border runs along cell faces) hold its data, so
    // the solution is that of a square smaller by half a cell.
    const Harmonic<double> coordinates(square<double>, {.resolution = 36, .averaging = {.tolerance = 1e-13}});
    const auto points = points_inside(Polygon<double>(square<double>), 200, 4);
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    const double h = 1.0 / 32;
    const auto shrunk = [&](double x) { return std::clamp((x - h / 2) / (1 - h), 0.0, 1.0); };
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double x = points[i][0], y = points[i][1];
        CAPTURE(i, x, y, text(weights.rows[i]));
        CHECK(difference(weights.rows[i], std::array{(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y}) <=
              h);
        if (std::min({x, y, 1 - x, 1 - y}) < h) continue;
        const double u = shrunk(x), v = shrunk(y);
        // Data along the border is not shrunk: what is left is of half a cell along it.
        CHECK(difference(weights.rows[i], std::array{(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v}) <=
              h / 2);
    }
}

TEMPLATE_TEST_CASE("options of harmonic coordinates out of their range each have a status",
                   "[coordinates][harmonic][status]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto status_of = [](const Options& options) {
        Harmonic<T> coordinates(square<T>, options);
        CHECK(coordinates.cage_report().status == Status::ok); // no fault of the cage
        const auto weights = evaluate_all(coordinates, Points2<T>{{T(0.5), T(0.5)}});
        CHECK(coordinates.solve().status == weights.status());
        return weights.status();
    };
    const Options good{.resolution = 16};
    CHECK(status_of(good) == Status::ok);
    for (const std::size_t resolution :
         {std::size_t(0), std::size_t(4), std::size_t(7), std::size_t(16385), ~std::size_t(0)}) {
        Options options = good;
        options.resolution = resolution;
        CHECK(status_of(options) == Status::resolution_not_supported);
    }
    Options options = good;
    options.resolution = 8;
    CHECK(status_of(options) == Status::ok);
    for (const double tolerance : {0.0, -1e-6, std::numeric_limits<double>::quiet_NaN()}) {
        options = good;
        options.averaging.tolerance = tolerance;
        CHECK(status_of(options) == Status::tolerance_not_positive);
    }
    options = good;
    for (const std::size_t sweeps : {0u, 1u, 2u}) {
        options.averaging.max_sweeps = sweeps;
        CHECK(status_of(options) == Status::not_converged);
    }
}

TEST_CASE("a solver that does not converge says how far it came", "[coordinates][harmonic][status]") {
    const Options options{.resolution = 64, .averaging = {.tolerance = 1e-9, .max_sweeps = 5}};
    Harmonic<double> coordinates(square<double>, options);
    const auto outcome = coordinates.solve();
    CHECK(outcome.status == Status::not_converged);
    CHECK(outcome.solver.unconverged == 1); // stops at the first
    CHECK(outcome.solver.solves == 1);
    CHECK(outcome.solver.relaxation.sweeps == 5);
    CHECK(outcome.solver.relaxation.largest_mean_change > 1e-9);
    CHECK(outcome.solver.cells > 1000);
    CHECK(outcome.solver.unresolved_cells == 0);
    // Nothing half solved is kept.
    CHECK(evaluate_all(coordinates, Points2<double>{{0.5, 0.5}}).status() == Status::not_converged);
}

TEST_CASE("harmonic coordinates report cells too crowded to tell edges apart",
          "[coordinates][harmonic][report]") {
    const auto crowded = [](std::size_t resolution) {
        const Harmonic<double> coordinates(read_oracle("harmonic2d_cat").cage<double>(),
                                           {.resolution = resolution, .averaging = {.tolerance = 1e-2}});
        const auto weights = evaluate_all(coordinates, Points2<double>{{0, 0}});
        CHECK(weights.status() == Status::ok);
        return weights.evaluation.solver.unresolved_cells;
    };
    CHECK(crowded(8) > crowded(64));
    CHECK(crowded(256) == 0);
}

TEST_CASE("harmonic progress never falls and its callback cancels", "[coordinates][harmonic][progress]") {
    const auto cage = read_oracle("harmonic2d_star").cage<double>();
    const auto points = points_inside(cage, 20, 5);
    const Options options{.resolution = 48, .averaging = {.tolerance = 1e-6}, .handles_at_once = 3};
    std::vector<double> told;
    cageform::Running evaluate_options;
    evaluate_options.progress = [&](double done) {
        told.push_back(done);
        return true;
    };
    Harmonic<double> coordinates(cage, options);
    REQUIRE(evaluate_all(coordinates, points, evaluate_options).status() == Status::ok);
    CHECK(told.size() >= cage.size());
    CHECK(std::is_sorted(told.begin(), told.end()));
    CHECK(told.front() >= 0);
    CHECK(told.back() == 1);

    const std::size_t all = told.size();
    for (const std::size_t last : {std::size_t(1), all / 2, all}) {
        std::size_t asked = 0;
        evaluate_options.progress = [&](double) { return ++asked < last; };
        CHECK(evaluate_all(coordinates, points, evaluate_options).status() == Status::cancelled);
        CHECK(asked == last);
    }
    evaluate_options.progress = [](double) { return false; };
    CHECK(coordinates.solve(evaluate_options).status == Status::cancelled);
    CHECK(evaluate_all(coordinates, points).evaluation.solver.solves == cage.size()); // nothing was kept

    // A single long solve can be cancelled before its end.
    Options endless{.resolution = 256, .averaging = {.tolerance = 1e-16, .max_sweeps = 1000000000}};
    std::size_t asked = 0;
    evaluate_options.progress = [&](double) { return ++asked < 20; };
    const auto outcome = Harmonic<double>(cage, endless).solve(evaluate_options);
    CHECK(outcome.status == Status::cancelled);
    CHECK(asked == 20);
}

TEMPLATE_TEST_CASE("harmonic weights at the ends of the scalar's range", "[coordinates][harmonic][scale]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const double scale = sizeof(T) == 4 ? GENERATE(1e-15, 1e15) : GENERATE(1e-150, 1e150);
    Points2<T> vertices{{0, 0}, {T(0.9), T(0.1)}, {T(0.7), T(0.8)}, {T(0.3), T(0.4)}};
    Points2<T> points = points_inside(Polygon<T>(vertices), 50, 6);
    const Options options{.resolution = 24, .averaging = {.tolerance = 1e-6}};
    const auto expected = evaluate_all(Harmonic<T>(vertices, options), points);
    for (auto& v : vertices) v = T(scale) * v;
    for (auto& p : points) p = T(scale) * p;
    const auto weights = evaluate_all(Harmonic<T>(vertices, options), points);
    REQUIRE(weights.status() == Status::ok);
    CHECK(weights.states == expected.states);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        // Vertices and points are rounded anew, which data and samples follow; 1e-4 for a sweep more or less.
        CHECK(difference(weights.rows[i], expected.rows[i]) <= 1e-4 + 1000 * double(epsilon<T>));
    }
}

TEST_CASE("restoring linear precision turns no harmonic weight more negative than it says",
          "[coordinates][harmonic][binding]") {
    const Polygon<double> cage(random_star<double>(5));
    const Harmonic<double> coordinates(cage, {.resolution = 64});
    Random random(5);
    Points2<double> points(300);
    for (auto& p : points) p = random_inside(cage, random);
    const auto report = cageform::bind(coordinates, points).report;
    REQUIRE(report.status == Status::ok);
    CHECK(report.weight_change.value > 0);
    CHECK(report.least_weight.value >= -report.weight_change.value - 1e-12);
}

// ---- in space ----------------------------------------------------------------------------------

namespace {

using Mesh = cageform::TriangleMesh<float>;

/// As the papers do, but for the tolerance.
Options as_published(std::size_t resolution, double tolerance) {
    return {.resolution = resolution,
            .averaging = {.tolerance = tolerance},
            .interpolation = Interpolation::nearest_cell,
            .handles_at_once = 1};
}

} // namespace

TEST_CASE("in space the papers' solver comes near the oracle as the grid becomes finer",
          "[coordinates][harmonic][mesh][oracle]") {
    // Largest errors measured at 16 and 32 cells: cubes 0.028 and 0.011, boxes 0.075 and 0.022, L 0.14 and
    // 0.048,
    // tetrahedron 0.033 and 0.041. They follow from the cages' place on the grid, not from the seed of
    // anything; the
    // bounds are half as large again.
    struct Case {
        const char* name;
        double coarse, fine;
    };
    for (const auto& c :
         {Case{"cube_triangulated", 0.042, 0.017}, Case{"box_mixed_diagonals_triangulated", 0.11, 0.033},
          Case{"l_prism_triangulated", 0.2, 0.072}, Case{"tetrahedron", 0.06, 0.06}}) {
        const auto json = read_json(std::string("harmonic3d_") + c.name);
        MeshData data;
        for (const auto& v : json["cage"]["vertices"]) data.vertices.push_back({v[0], v[1], v[2]});
        for (const auto& f : json["cage"]["faces"]) {
            data.faces.push_back({f[0], f[1], f[2]});
        }
        Points3<double> points;
        for (const auto& p : json["points"]) points.push_back({p[0], p[1], p[2]});
        REQUIRE(points.size() >= 10);
        const auto largest_error = [&](const auto& cage, std::size_t resolution) {
            const Averaged<std::remove_cvref_t<decltype(cage)>> coordinates(
                cage, {.resolution = resolution, .averaging = {.tolerance = 1e-7}});
            const auto weights = evaluate_all(coordinates, points);
            REQUIRE(weights.status() == Status::ok);
            double error = 0;
            for (std::size_t k = 0; k < data.vertices.size(); ++k) {
                for (std::size_t i = 0; i < points.size(); ++i) {
                    const double expected = json["coordinates"][i][k];
                    error = cageform_tests::larger(error, std::fabs(double(weights.rows[i][k]) - expected));
                }
            }
            return error;
        };
        const auto errors = [&](std::size_t resolution) {
            return largest_error(data.mesh<float>(), resolution);
        };
        const double coarse = errors(16), fine = errors(32);
        CAPTURE(c.name, coarse, fine);
        CHECK(coarse <= c.coarse);
        CHECK(fine <= c.fine);
        // First order would halve it. The tetrahedron's functions are linear: the steps' places are all its
        // error.
        if (std::string(c.name) != "tetrahedron") CHECK(fine <= 0.6 * coarse);
    }
}

TEST_CASE("in space the papers' weights are in [0, 1], sum to 1 and are a diagonal off at most",
          "[coordinates][harmonic][mesh][property]") {
    const int seed = GENERATE(seeds(effort(6, 3)));
    const auto interpolation = GENERATE(Interpolation::nearest_cell, Interpolation::multilinear);
    CAPTURE(seed, int(interpolation));
    const auto data = random_mesh(std::uint64_t(seed));
    const auto mesh = data.mesh<float>();
    const auto bounds = cageform::bounds_of(mesh.vertices());
    Points3<float> points(mesh.vertices().begin(), mesh.vertices().end());
    for (const auto& [a, b, c] : mesh.faces()) points.push_back(0.25f * (mesh[a] + mesh[b]) + 0.5f * mesh[c]);
    const std::size_t on = points.size();
    for (const auto& p : points_about(data, 500, 5)) points.push_back(vec_cast<float>(p));
    points.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 0});
    auto options = as_published(20, 1e-8);
    options.interpolation = interpolation;
    const Averaged<Mesh> coordinates(mesh, options);
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    const double h = spacing(mesh, 20), size = size_of(mesh.vertices());
    // Values lie up to half a diagonal off their place at the boundary, as does what is looked up in a
    // cell; between cells a sample leaves out some up to a diagonal off. The maximum principle does the
    // rest.
    const double most = interpolation == Interpolation::nearest_cell ? std::sqrt(3.0) : 1.5 * std::sqrt(3.0);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto state = locate(mesh, points[i], cageform::coincidence_tolerance(bounds));
        CAPTURE(i, int(state));
        CHECK(weights.states[i] == state);
        const auto& row = weights.rows[i];
        if (i < mesh.size()) CHECK(row[i] >= 1 - 1e-5f);
        if (i < on) CHECK(distance(combine(row, mesh.vertices()), points[i]) <= 1e-5 * size);
        if (state != PointState::inside) continue;
        ++inside;
        CHECK(*std::min_element(row.begin(), row.end()) >= 0);
        CHECK(*std::max_element(row.begin(), row.end()) <= 1 + 1e-5f);
        // Sums of all functions are rounded in every cell of a walk to the boundary, of up to 20² steps.
        CHECK(std::fabs(double(sum_of(row)) - 1) <= 400 * double(epsilon<float>));
        CHECK(distance(combine(row, mesh.vertices()), points[i]) <= (most + 0.01) * h + 1e-5 * size);
    }
    CHECK(inside > 8);
    if (interpolation == Interpolation::multilinear) return;
    // Functions that are kept have the same bits; `bind` restores what the staircase leaves, and says so.
    auto solved = coordinates;
    REQUIRE(solved.solve().status == Status::ok);
    points.pop_back(); // which is no number
    CHECK((evaluate_all(solved, points).rows == evaluate_all(coordinates, points).rows));
    const auto report = cageform::bind(solved, points).report;
    REQUIRE(report.status == Status::ok);
    CHECK(report.residual_restored.value > 0.1 * h);
    CHECK(report.residual_restored.value <= (most + 0.01) * h + 1e-5 * size);
    CHECK(report.reproduction_error.value <= 1e-5 * size);
}

TEST_CASE("the papers' solver is a solver without gradients, for polygons and meshes of triangles",
          "[coordinates][harmonic][solver]") {
    STATIC_REQUIRE(cageform::CageSolver<PyramidSolver<float, 2>, float>);
    STATIC_REQUIRE(!cageform::DifferentiableSolver<PyramidSolver<float, 2>, float>);
    STATIC_REQUIRE(cageform::CageSolver<PyramidSolver<double, 3>>);
    const Points2<double> middle{{0.5, 0.5}};
    CHECK(gradients_of<double, 2>(Harmonic<double>(square<double>, {.resolution = 16}), middle)
              .evaluation.status == Status::solver_not_supported);
    cageform::CellComplex<double, 2> with_point{Polygon<double>(square<double>)};
    with_point.add_point(middle[0], 0.1);
    const auto box = cageform::box_mesh<double>({0, 0, 0}, {1, 1, 1});
    for (const Status status :
         {cageform::HarmonicCoordinates(with_point, {.resolution = 16}, AveragingSolver{}).solve().status,
          cageform::HarmonicCoordinates(box, {.resolution = 16}, AveragingSolver{}).solve().status})
        CHECK(status == Status::solver_not_supported);
}

TEST_CASE("in space the papers' solver takes 12 bytes a cell and refuses what is too large",
          "[coordinates][harmonic][mesh][status]") {
    const auto mesh = sphere(2).mesh<float>();
    const Points3<float> middle{{0, 0, 0}};
    const auto lattice = lattice_about(cageform::bounds_of(mesh.vertices()), 128);
    const Averaged<Mesh> coordinates(mesh, as_published(128, 1e-3)); // 2⁷, as theirs
    const auto memory = coordinates.solver_memory();
    CHECK(memory.hierarchy + memory.block <= 12 * lattice.size());
    CHECK(memory.hierarchy + memory.block >= 9 * lattice.size());
    const auto status_of = [&](const Options& options) {
        return evaluate_all(Averaged<Mesh>(mesh, options), middle).status();
    };
    for (const std::size_t resolution : {std::size_t{7}, std::size_t{1025}, ~std::size_t{0}})
        CHECK(status_of(as_published(resolution, 1e-3)) == Status::resolution_not_supported);
    CHECK(status_of(as_published(16, 0)) == Status::tolerance_not_positive);
    auto options = as_published(1024, 1e-3); // 10 GB, before any of it is taken
    const auto refused = evaluate_all(Averaged<Mesh>(mesh, options), middle).evaluation;
    CHECK(refused.status == Status::out_of_memory);
    CHECK(refused.solver.bytes > std::size_t{9} << 30);
    options = as_published(16, 1e-9);
    options.averaging.max_sweeps = 3;
    CHECK(status_of(options) == Status::not_converged);
    // A box thinner than a cell: every cell is of the boundary, and what is inside has the data there.
    const auto thin = cageform::box_mesh<double>({0, 0, 0}, {1, 1, 0.01}).triangles();
    const auto weights = evaluate_all(Averaged<cageform::TriangleMesh<double>>(thin, as_published(16, 1e-6)),
                                      Points3<double>{{0.5, 0.5, 0.005}});
    REQUIRE(weights.status() == Status::ok);
    CHECK(weights.states[0] == PointState::inside);
    CHECK(std::fabs(double(sum_of(weights.rows[0])) - 1) <= 1e-12);
    CHECK(weights.evaluation.solver.cells == 0);
    CHECK(weights.evaluation.solver.unresolved_cells > 100);
}

} // namespace harmonic_tests

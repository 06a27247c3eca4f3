// Harmonic coordinates on an adaptive grid: the accuracy, the oracle, and refusals.
#include "catch.hpp"
#include "support/effort.hpp"
#include "support/fingers.hpp"
#include "support/gradients.hpp"
#include "support/larger.hpp"
#include "support/meshes.hpp"
#include "support/oracle.hpp"
#include "support/weights.hpp"

#include <cageform/cage/box_mesh.hpp>
#include <cageform/coordinates/harmonic/tree_solver.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>
#include <cageform/parallel/threads.hpp>

#include <cstdio>

namespace harmonic_tree_tests {

using namespace cageform_tests;
using cageform::CellComplex;
using cageform::HarmonicOptions;
using cageform::Polygon;
using cageform::TriangleMesh;

namespace {

template <class C>
using Adaptive = cageform::HarmonicCoordinates<typename C::scalar, C::dimension, C>;

template <class C, class Points>
double largest_error(const C& cage, const Points& points, const std::vector<std::vector<double>>& expected,
                     double accuracy) {
    const auto weights = evaluate_all(Adaptive<C>(cage, {.accuracy = accuracy}), points);
    REQUIRE(weights.status() == Status::ok);
    CHECK(weights.evaluation.solver.multigrid.error_estimate <= 0.17 * accuracy);
    CHECK(weights.evaluation.solver.multigrid.convergence_factor <= 0.25);
    CHECK(weights.evaluation.solver.multigrid.convergence_factor > 0.01);
    double error = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        CHECK(weights.states[i] == PointState::inside);
        error = cageform_tests::larger(error, difference(weights.rows[i], expected[i]));
    }
    return error;
}

TEST_CASE("adaptive weights are within the accuracy, in the plane", "[coordinates][harmonic][tree][oracle]") {
    // Some points are within 1e-5 diagonals of a corner or of the end of a chain.
    for (const char* name :
         {"triangle", "unit_square", "rectangle", "square_extra_vertex", "hexagon", "l_shape", "star",
          "biped", "cat", "hole_square_square_hole", "hole_hexagon_triangle_hole",
          "straight_chain_square_straight_chain", "splitting_chain_hexagonlike_split_chain", "spiral"}) {
        CAPTURE(name);
        const auto oracle = read_oracle(std::string("harmonic2d_") + name);
        for (const double accuracy : {1e-2, 1e-3, 1e-4, 1e-5}) {
            if (accuracy < effort(0.0, 1e-3)) break;
            CAPTURE(accuracy);
            const auto error =
                oracle.chain.empty()
                    ? largest_error(oracle.cage<double>(), oracle.points, oracle.coordinates, accuracy)
                    : largest_error(oracle.complex<double>(), oracle.points, oracle.coordinates, accuracy);
            CHECK(error <= accuracy);
        }
    }
}
/// A mesh of tests/data/oracle rotated about (1, 2, 3), so that faces are not aligned with the grid.
double error_of_oracle(const std::string& name, double angle, double accuracy) {
    const auto json = read_json("harmonic3d_" + name);
    const auto turned = [&](const char* key) {
        Points3<double> places;
        for (const auto& p : key[0] == 'p' ? json["points"] : json["cage"]["vertices"])
            places.push_back(turned_about_123({p[0], p[1], p[2]}, angle));
        return places;
    };
    const auto faces = json["cage"]["faces"].get<std::vector<std::array<int, 3>>>();
    return largest_error(TriangleMesh<double>(turned("vertices"), faces), turned("points"),
                         json["coordinates"].get<std::vector<std::vector<double>>>(), accuracy);
}
TEST_CASE("adaptive weights are within the accuracy, in space", "[coordinates][harmonic][tree][oracle]") {
    CHECK(error_of_oracle("tetrahedron", 0.5, 1e-2) <= 1e-4); // the solver's error
    for (const double angle : {2.0, 1.0, 0.0}) {
        if (angle < effort(0.0, 2.0)) break;
        CAPTURE(angle);
        for (const double accuracy : {1e-2, 2e-3}) {
            if (accuracy < effort(0.0, 1e-2)) break;
            CAPTURE(accuracy);
            CHECK(error_of_oracle("cube_triangulated", angle, accuracy) <= accuracy);
            CHECK(error_of_oracle("box_mixed_diagonals_triangulated", angle, accuracy) <= accuracy);
            // Next to its reflex edge.
            CHECK(error_of_oracle("l_prism_triangulated", angle, accuracy) <= 1.5 * accuracy);
        }
    }
#if !defined(CAGEFORM_SANITIZED) // takes a minute there, with the same code
    for (const char* name : {"cube_triangulated", "box_mixed_diagonals_triangulated", "l_prism_triangulated"})
        CHECK(error_of_oracle(name, 0, 2e-4) <= 2e-4);
#endif
}
// A large cage with a small part: 762 handles, fingers 1.7 thick on a body of 180. Reference values are from
// walks on spheres, to 2.5e-4.
#if !defined(CAGEFORM_SANITIZED) // takes minutes there, with code that other tests cover
TEST_CASE("adaptive weights resolve fingers", "[coordinates][harmonic][tree][oracle]") {
    const Fingers fingers(CAGEFORM_TEST_DATA "/fingers");
    constexpr double accuracy = 5e-3;
    const auto error = largest_error(fingers.cage(), fingers.points, fingers.weights, accuracy);
    CHECK(error <= accuracy);
}
#endif

/// Compares with a grid for a tenth of the error.
template <class C, class Points>
void check_estimate(const C& cage, const Points& points, double accuracy) {
    const auto weights = evaluate_all(Adaptive<C>(cage, {.accuracy = accuracy}), points);
    const auto finer = evaluate_all(Adaptive<C>(cage, {.accuracy = 0.1 * accuracy}), points);
    REQUIRE(weights.status() == Status::ok);
    REQUIRE(finer.status() == Status::ok);
    double error = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        error = larger(error, double(difference(weights.rows[i], finer.rows[i])));
    const auto& report = weights.evaluation.solver;
    CAPTURE(error, report.grid_error());
    CHECK(report.grid_error() >= 0.5 * error);
    CHECK(report.grid_error() <= 10 * error);
    CHECK(report.grid_error(0.5) <= report.grid_error(0.9));
    CHECK(report.grid_error(0.9) <= report.grid_error());
    CHECK(report.tree.finest_size > 0);
}
TEST_CASE("the error of an adaptive grid is estimated", "[coordinates][harmonic][tree][property]") {
    for (std::uint64_t seed = 0; seed < effort(4u, 1u); ++seed) {
        CAPTURE(seed);
        Random random(seed + 3);
        const Polygon<double> star(random_star<double>(seed));
        Points2<double> in_plane;
        for (int n = 0; n < 1000; ++n) in_plane.push_back(random_inside(star, random, 1e-4));
        check_estimate(star, in_plane, 0.01);
        if (seed >= 2) continue;
        const auto data = random_mesh(seed);
        const auto mesh = data.mesh<double>();
        Points3<double> in_space;
        for (const auto& p : points_about(data, 2000, seed)) {
            if (locate(mesh, p, 1e-6) == PointState::inside) in_space.push_back(p);
        }
        check_estimate(mesh, in_space, 0.02);
    }
}

/// Random points on facets of a cage, away from their edges, and directions.
template <class C>
class BoundaryPlaces {
    static constexpr std::size_t D = C::dimension;

public:
    BoundaryPlaces(const C& cage, std::uint64_t seed)
        : cage_(cage)
        , random_(seed) {
        for_each_facet(boundary_of(cage), [&](const auto& facet) {
            facets_.emplace_back();
            for (std::size_t k = 0; k < D; ++k) facets_.back()[k] = cage.vertices()[facet[k]];
        });
    }
    Vec<double, D> place() {
        const auto& corners = facets_[random_.below(facets_.size())];
        std::array<double, D> weight{};
        double sum = 0;
        for (double& w : weight) sum += (w = random_.uniform(0.05, 1));
        Vec<double, D> p{};
        for (std::size_t k = 0; k < D; ++k) p = p + (weight[k] / sum) * corners[k];
        return p;
    }
    Vec<double, D> direction() {
        for (;;) {
            Vec<double, D> d{};
            for (std::size_t k = 0; k < D; ++k) d[k] = random_.uniform(-1, 1);
            if (const double square = dot(d, d); square > 0.01 && square <= 1)
                return (1 / std::sqrt(square)) * d;
        }
    }
    /// The boundary values at the boundary point nearest to a point, by handle.
    std::vector<double> data(const Vec<double, D>& p) const {
        Vec<double, D> nearest;
        const auto value = nearest_boundary_value(cage_, p, nearest);
        std::vector<double> data(cage_.size());
        for (std::size_t k = 0; k < value.handle.size(); ++k) data[value.handle[k]] += value.weight[k];
        return data;
    }

private:
    const C& cage_;
    Random random_;
    std::vector<std::array<Vec<double, D>, D>> facets_;
};

/// Differences of weights from boundary values at distances of 10^-15, 10^-14, … 10^-3 diagonals, and the
/// number of points.
struct Approach {
    static constexpr std::size_t distances = 13;
    static double distance(std::size_t n) { return std::pow(10.0, double(n) - 15); }
    std::array<double, distances> largest{};
    std::array<std::size_t, distances> points{};

    template <class C>
    void add(const C& cage, std::uint64_t seed, double accuracy) {
        const double diagonal = bounds_of(cage.vertices()).diagonal();
        BoundaryPlaces<C> boundary(cage, seed);
        std::vector<Vec<double, C::dimension>> inside;
        std::vector<std::size_t> at;
        for (int ray = 0; ray < 40; ++ray) {
            const auto place = boundary.place(), direction = boundary.direction();
            for (std::size_t n = 0; n < distances; ++n) {
                const auto p = place + (distance(n) * diagonal) * direction;
                if (locate(cage, p, 0.0) != PointState::inside) continue;
                inside.push_back(p);
                at.push_back(n);
            }
        }
        const auto weights = evaluate_all(Adaptive<C>(cage, {.accuracy = accuracy}), inside);
        REQUIRE(weights.status() == Status::ok);
        for (std::size_t i = 0; i < inside.size(); ++i) {
            auto& error = largest[at[i]];
            error = larger(error, difference(weights.rows[i], boundary.data(inside[i])));
            ++points[at[i]];
        }
    }
    /// Weights differ from boundary values by at most the slope of the functions, below 200 per diagonal for
    /// these cages.
    void check() const {
        for (std::size_t n = 0; n < distances; ++n) {
            CAPTURE(distance(n));
            CHECK(points[n] > 0);
            CHECK(largest[n] <= 1e-12 + 200 * distance(n));
        }
    }
    void print(const char* what) const {
        std::printf("%s: distance of the point, points, largest distance of a weight from the data\n", what);
        for (std::size_t n = 0; n < distances; ++n)
            std::printf("%8.0e %6zu %9.1e\n", distance(n), points[n], largest[n]);
    }
};
Approach approach_in_plane(std::uint64_t seeds) {
    Approach approach;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        CAPTURE(seed);
        approach.add(Polygon<double>(random_star<double>(1000 + seed)), seed, 1e-3);
    }
    return approach;
}
Approach approach_in_space(std::uint64_t seeds) {
    Approach approach;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        CAPTURE(seed);
        approach.add(random_mesh(1000 + seed).mesh<double>(), seed, 1e-2);
    }
    return approach;
}
TEST_CASE("adaptive weights tend to the boundary values", "[coordinates][harmonic][tree][property]") {
    approach_in_plane(effort(8u, 2u)).check();
    approach_in_space(effort(2u, 1u)).check();
}
TEST_CASE("adaptive weights tend to the boundary values: a table", "[.][table]") {
    const auto plane = approach_in_plane(200), space = approach_in_space(20);
    plane.print("plane, 200 cages");
    space.print("space, 20 cages");
    plane.check();
    space.check();
}
// After rounding to text, a point of the cage may lie on either side of the boundary. It gets the boundary
// values.
TEST_CASE("a figure on its own cage has the boundary values, after rounding to 7 to 17 digits",
          "[coordinates][harmonic][tree][property]") {
    const auto check_figure = [](const auto& cage, std::uint64_t seed, double accuracy) {
        using C = std::decay_t<decltype(cage)>;
        constexpr std::size_t D = C::dimension;
        const double largest = larger(cageform::detail::length(bounds_of(cage.vertices()).lower),
                                      cageform::detail::length(bounds_of(cage.vertices()).upper));
        BoundaryPlaces<C> boundary(cage, seed);
        std::vector<Vec<double, D>> figure;
        std::vector<double> off;
        for (int digits = 7; digits <= 17; ++digits) {
            for (int n = 0; n < 40; ++n) {
                auto p = boundary.place();
                for (std::size_t k = 0; k < D; ++k) {
                    char text[40];
                    std::snprintf(text, sizeof text, "%.*g", digits, p[k]);
                    p[k] = std::strtod(text, nullptr);
                }
                figure.push_back(p);
                off.push_back(std::pow(10.0, 1 - digits) * largest / bounds_of(cage.vertices()).diagonal());
            }
        }
        const auto weights = evaluate_all(Adaptive<C>(cage, {.accuracy = accuracy}), figure);
        REQUIRE(weights.status() == Status::ok);
        std::size_t bound = 0;
        for (std::size_t i = 0; i < figure.size(); ++i) {
            if (weights.states[i] == PointState::outside) continue;
            ++bound;
            CHECK(difference(weights.rows[i], boundary.data(figure[i])) <= 1e-12 + 200 * off[i]);
        }
        CHECK(bound > figure.size() / 3);
    };
    for (std::uint64_t seed = 0; seed < effort(4u, 1u); ++seed) {
        CAPTURE(seed);
        check_figure(Polygon<double>(random_star<double>(2000 + seed)), seed, 1e-3);
        if (seed < 2) check_figure(random_mesh(2000 + seed).mesh<double>(), seed, 1e-2);
    }
}
// Leaves that see little of limbs and corners, least of all of their own corners.
TEST_CASE("adaptive weights of points that see no node of their leaf are within the accuracy",
          "[coordinates][harmonic][tree]") {
    const auto check_place = [](std::uint64_t seed, const Vec<double, 2>& p, double accuracy) {
        CAPTURE(seed, p[0], p[1]);
        const Polygon<double> cage(random_star<double>(seed));
        const auto weights =
            evaluate_all(Adaptive<Polygon<double>>(cage, {.accuracy = accuracy}), Points2<double>{p});
        const auto finer =
            evaluate_all(Adaptive<Polygon<double>>(cage, {.accuracy = 0.1 * accuracy}), Points2<double>{p});
        REQUIRE(weights.status() == Status::ok);
        REQUIRE(finer.status() == Status::ok);
        CHECK(difference(weights.rows[0], finer.rows[0]) <= accuracy);
    };
    check_place(1013, {112.40490538865558, -121.66923619912446}, effort(1e-4, 1e-3));
    check_place(1012, {0.008007936337821828, 0.0025524405685436323}, 1e-3);
}

/// Checks the laws of all weights. On a bone the weights are those of its axis. Weights next to bones do not
/// reproduce the point.
template <class C, class Points>
void check_laws(const C& cage, const Points& points, bool has_bones = false) {
    constexpr std::size_t D = C::dimension;
    constexpr double accuracy = effort(0.02, 0.05);
    Adaptive<C> coordinates(cage, {.accuracy = accuracy});
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    const double size = double(bounds_of(cage.vertices()).diagonal());
    std::size_t inside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        CHECK(weights.states[i] ==
              locate(cage, points[i], cageform::coincidence_tolerance(bounds_of(cage.vertices()))));
        if (!(weights.states[i] == PointState::inside || weights.states[i] == PointState::on_boundary))
            continue;
        ++inside;
        Vec<double, D> p{};
        double sum = 0;
        for (std::size_t k = 0; k < cage.size(); ++k) {
            const auto w = double(weights.rows[i][k]);
            CHECK((w >= 0 && w <= 1));
            sum += w;
            p = p + w * vec_cast<double>(cage.vertices()[k]);
        }
        CHECK(std::fabs(sum - 1) <= 0.5 * accuracy); // each function is solved to a sixth of this
        if (has_bones) continue;
        CHECK(cageform::detail::length(p - vec_cast<double>(points[i])) <= 0.5 * accuracy * size);
    }
    CHECK(inside > 5);
    // Results are bitwise equal for any number of threads. Kept functions drop values below 0.002 of the
    // accuracy.
    const auto threaded = evaluate_all(coordinates, points, {.parallel = cageform::ThreadedFor{3}});
    CHECK(threaded.rows == weights.rows);
    REQUIRE(coordinates.solve().status == Status::ok);
    const auto kept = evaluate_all(coordinates, points);
    for (std::size_t i = 0; i < points.size(); ++i)
        CHECK(difference(kept.rows[i], weights.rows[i]) <= 0.002 * accuracy + 1e-6);
}
TEMPLATE_TEST_CASE("adaptive weights are a mean that reproduces the point",
                   "[coordinates][harmonic][tree][property]", CAGEFORM_SCALARS) {
    for (std::uint64_t seed = 0; seed < effort(4u, 1u); ++seed) {
        CAPTURE(seed);
        const Polygon<TestType> polygon(random_star<TestType>(seed));
        Random random(seed);
        Points2<TestType> points;
        for (int n = 0; n < 40; ++n) points.push_back(random_inside(polygon, random, 1e-6));
        for (const auto& vertex : polygon.vertices()) points.push_back(vertex);
        points.push_back(TestType(0.5) * (polygon.vertices()[0] + polygon.vertices()[1]));
        points.push_back(polygon.vertices()[0] +
                         TestType(100) * (polygon.vertices()[1] - polygon.vertices()[0]));
        check_laws(polygon, points);
    }
    const auto data = random_mesh(2);
    const auto mesh = data.template mesh<TestType>();
    Points3<TestType> points;
    for (const auto& p : points_about(data, 60, 2)) points.push_back(vec_cast<TestType>(p));
    points.push_back(mesh.vertices()[3]);
    check_laws(mesh, points);
}

template <class T, std::size_t D>
std::vector<Vec<T, D>> random_points(const cageform::Bounds<T, D>& bounds, std::size_t count,
                                     std::uint64_t seed) {
    Random random(seed);
    std::vector<Vec<T, D>> points(count);
    for (auto& p : points) {
        for (std::size_t k = 0; k < D; ++k)
            p[k] = T(random.uniform(double(bounds.lower[k]), double(bounds.upper[k])));
    }
    return points;
}
TEMPLATE_TEST_CASE("adaptive weights of every kind of cage are a mean",
                   "[coordinates][harmonic][tree][complex][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto box = cageform::box_mesh<T>({T(-1), T(2), T(0)}, {T(0.3), T(3), T(2)}, {2, 1, 3});
    auto about_box = random_points(bounds_of(box.vertices()), 60, 1);
    about_box.push_back({T(0.3), T(2.7), T(1.1)}); // on a side
    about_box.push_back(box.vertices()[5]);
    check_laws(box, about_box);
    // A square and two triangles on each side.
    const std::vector<std::vector<int>> faces{{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7},
                                              {2, 7, 3},    {0, 4, 6, 2}, {1, 3, 7, 5}};
    Points3<T> corners;
    for (int n = 0; n < 8; ++n) corners.push_back({T(n & 1), T(n >> 1 & 1), T(n >> 2)});
    const cageform::PolyhedralMesh<T> mixed(corners, faces);
    auto about_mixed = random_points(bounds_of(mixed.vertices()), 60, 2);
    about_mixed.push_back({T(0.25), T(0.5), T(0)});
    check_laws(mixed, about_mixed);

    // Interior cells without thickness preserve reproduction of points. Beside bones, weights are a mean.
    CellComplex<T, 2> plane(Polygon<T>(Points2<T>{{0, 0}, {4, 0}, {4, 4}, {0, 4}}));
    (void)plane.add_chain(Points2<T>{{1, 2}, {T(2.25), 2}, {3, T(2.5)}});
    auto about_plane = random_points(bounds_of(plane.vertices()), 80, 3);
    about_plane.push_back({T(1.625), 2}); // on the chain
    about_plane.push_back({T(1.625), T(2.0001)});
    check_laws(plane, about_plane);
    (void)plane.add_point(Vec<T, 2>{2, 3}, T(0.25));
    about_plane.push_back({T(2.1), T(3.1)}); // in the ball
    check_laws(plane, about_plane, true);
    CellComplex<T, 3> space(divided_box({1, 1, 1}, 1.0).template mesh<T>());
    (void)space.add_faces(
        Points3<T>{{T(-0.3), T(-0.3), T(0.3)}, {T(0.3), T(-0.3), T(0.3)}, {0, T(0.3), T(0.25)}},
        Faces{{0, 1, 2}});
    auto about_space = random_points(bounds_of(space.vertices()), 60, 4);
    check_laws(space, about_space);
    (void)space.add_chain(Points3<T>{{T(-0.2), 0, T(-0.1)}, {T(0.2), 0, 0}}, T(0.125));
    about_space.push_back({0, 0, 0}); // in the bone
    check_laws(space, about_space, true);
}
TEST_CASE("on interior cells adaptive weights are their hat functions",
          "[coordinates][harmonic][tree][complex]") {
    CellComplex<double, 2> plane(Polygon<double>(Points2<double>{{0, 0}, {4, 0}, {4, 4}, {0, 4}}));
    (void)plane.add_chain(Points2<double>{{1, 2}, {2.25, 2}, {3, 2.5}});
    (void)plane.add_point(Vec<double, 2>{2, 3}, 0.25);
    const Points2<double> on{{1.625, 2}, {3, 2.5}, {2, 3}, {2.1, 3.1}};
    const std::vector<std::vector<double>> expected{{0, 0, 0, 0, 0.5, 0.5, 0, 0},
                                                    {0, 0, 0, 0, 0, 0, 1, 0},
                                                    {0, 0, 0, 0, 0, 0, 0, 1},
                                                    {0, 0, 0, 0, 0, 0, 0, 1}};
    const auto weights = evaluate_all(Adaptive<CellComplex<double, 2>>(plane, {.accuracy = 0.02}), on);
    REQUIRE(weights.status() == Status::ok);
    for (std::size_t i = 0; i < on.size(); ++i) {
        CHECK(weights.states[i] == PointState::on_boundary);
        CHECK(difference(weights.rows[i], expected[i]) <= 1e-12);
    }
}
TEST_CASE("adaptive weights around a ball in a ball, and a disc in a disc, are the known potential",
          "[coordinates][harmonic][tree][complex]") {
    // The function of a vertex of radius a at the centre of a circle of radius 1 is ln r / ln a; of a sphere,
    // (1/r − 1)/(1/a − 1). Polygons and polyhedra of the same size stand for circle and sphere.
    constexpr double accuracy = 2e-3;
    constexpr int corners = 48;
    constexpr double half = std::numbers::pi / corners;
    const double outer = std::sqrt(2 * half / std::sin(2 * half));
    Points2<double> circle;
    for (int i = 0; i < corners; ++i)
        circle.push_back({outer * std::cos(2 * half * i), outer * std::sin(2 * half * i)});
    CellComplex<double, 2> disc{Polygon<double>(circle)};
    const auto middle = disc.add_point(Vec<double, 2>{0, 0}, 0.1);
    Points2<double> in_disc;
    for (const double r : {0.1001, 0.105, 0.15, 0.3, 0.6, 0.9})
        in_disc.push_back({r * std::cos(9 * r), r * std::sin(9 * r)});
    const auto flat = evaluate_all(Adaptive<CellComplex<double, 2>>(disc, {.accuracy = accuracy}), in_disc);
    REQUIRE(flat.status() == Status::ok);
    for (std::size_t i = 0; i < in_disc.size(); ++i) {
        const double r = cageform::detail::length(in_disc[i]);
        CHECK(std::fabs(flat.rows[i][middle] - std::log(r) / std::log(0.1)) <= accuracy);
    }
    // The same in a large square, for a point hardly thicker than the finest cells: near it linear in ln r.
    CellComplex<double, 2> square(Polygon<double>(Points2<double>{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}));
    auto thinner = square;
    const auto thin = square.add_point(Vec<double, 2>{0.01, 0.003}, 1e-5);
    const auto about = [](double r) { return Vec<double, 2>{0.01 + 0.6 * r, 0.003 + 0.8 * r}; };
    const auto falling = evaluate_all(Adaptive<CellComplex<double, 2>>(square, {.accuracy = accuracy}),
                                      Points2<double>{about(2e-5), about(1e-3), about(5e-2)});
    REQUIRE(falling.status() == Status::ok);
    const double per_e = (falling.rows[0][thin] - 1) / std::log(2.0);
    for (const auto& [i, r] : {std::pair(1, 1e-3), std::pair(2, 5e-2)})
        CHECK(std::fabs(falling.rows[std::size_t(i)][thin] - 1 - per_e * std::log(r / 1e-5)) <= 0.02);
    CHECK(std::fabs(per_e * std::log(1e5) + 1) <= 0.02); // the square's conformal radius is near 1
    // Thinner points are refused, because no cell sees them.
    const auto unseen = thinner.add_point(Vec<double, 2>{0.01, 0.003}, 1e-8);
    const auto refused =
        evaluate_all(Adaptive<CellComplex<double, 2>>(thinner, {.accuracy = accuracy}), in_disc);
    CHECK(refused.status() == Status::grid_too_coarse);
    CHECK(refused.evaluation.solver.unseen_handle == unseen);

    auto round = sphere(3);
    double volume = 0;
    for (const auto& [a, b, c] : round.faces) {
        volume += dot(round.vertices[std::size_t(a)],
                      cross(round.vertices[std::size_t(b)], round.vertices[std::size_t(c)])) /
                  6;
    }
    for (auto& v : round.vertices) v = std::cbrt(4 * std::numbers::pi / 3 / std::fabs(volume)) * v;
    CellComplex<double, 3> ball{round.mesh<double>()};
    const auto heart = ball.add_point(Vec<double, 3>{0, 0, 0}, 0.25);
    const Points3<double> in_ball{{0.251, 0, 0.01}, {0.3, 0.0, 0.1}, {0.2, -0.4, 0.1}, {0.5, 0.5, 0.5}};
    const auto deep = evaluate_all(Adaptive<CellComplex<double, 3>>(ball, {.accuracy = 0.01}), in_ball);
    REQUIRE(deep.status() == Status::ok);
    for (std::size_t i = 0; i < in_ball.size(); ++i) {
        const double r = cageform::detail::length(in_ball[i]);
        CAPTURE(r, deep.rows[i][heart]);
        CHECK(std::fabs(deep.rows[i][heart] - (1 / r - 1) / 3) <= 0.01);
    }
}

TEST_CASE("adaptive weights do not depend on the distance from the origin, until coordinates are too coarse",
          "[coordinates][harmonic][tree][float]") {
    // Some thousand diameters from the origin, a cage of floats has digits for some hundred cells.
    constexpr double accuracy = 5e-3;
    for (std::uint64_t seed = 0; seed < effort(3u, 1u); ++seed) {
        const Polygon<double> star(random_star<double>(seed));
        const double scale = 1 / bounds_of(star.vertices()).diagonal();
        for (const double offset : {100.0, 1000.0, 3000.0}) {
            CAPTURE(seed, offset);
            Points2<float> far_cage, far_points;
            Points2<double> near_cage, near_points;
            const auto add = [&](const Vec<double, 2>& p, auto& far, auto& near) {
                far.push_back({float(scale * p[0] + offset), float(scale * p[1])});
                near.push_back({double(far.back()[0]) - offset, double(far.back()[1])});
            };
            for (const auto& vertex : star.vertices()) add(vertex, far_cage, near_cage);
            Random random(seed + 5);
            for (int n = 0; n < 60; ++n) add(random_inside(star, random, 0.02), far_points, near_points);
            const auto there = evaluate_all(
                Adaptive<Polygon<float>>(Polygon<float>(far_cage), {.accuracy = accuracy}), far_points);
            const auto here = evaluate_all(
                Adaptive<Polygon<double>>(Polygon<double>(near_cage), {.accuracy = accuracy}), near_points);
            REQUIRE(there.status() == Status::ok);
            std::size_t inside = 0;
            for (std::size_t i = 0; i < far_points.size(); ++i) {
                if (there.states[i] != PointState::inside) continue;
                ++inside;
                CHECK(difference(there.rows[i], here.rows[i]) <= accuracy);
            }
            CHECK(inside > 50);
        }
    }
    const Polygon<float> farthest(Points2<float>{{3e4F, 0}, {3e4F + 1, 0}, {3e4F, 1}});
    REQUIRE(check(farthest).status == Status::ok);
    CHECK(evaluate_all(Adaptive<Polygon<float>>(farthest, {.accuracy = accuracy}),
                       Points2<float>{{3e4F + 0.25F, 0.25F}})
              .status() == Status::resolution_not_supported);
}

TEST_CASE("an adaptive solve reports progress and can be cancelled",
          "[coordinates][harmonic][tree][progress]") {
    const auto mesh = divided_box({2, 2, 2}, 1.0).mesh<double>(); // two groups of functions
    const Points3<double> points{{0.1, 0.2, 0.1}, {0.2, -0.1, 0.1}};
    Adaptive<TriangleMesh<double>> coordinates(mesh, {.accuracy = effort(0.02, 0.1)});
    const auto expected = evaluate_all(coordinates, points);
    double last = 0;
    int calls = 0, of_grid = 0; // calls before the grid is made
    cageform::Running running;
    running.progress = [&](double done) {
        CHECK(done >= last);
        CHECK(done <= 1);
        last = done;
        ++calls;
        of_grid += done < 0.25 ? 1 : 0;
        return true;
    };
    CHECK(evaluate_all(coordinates, points, running).status() == Status::ok);
    CHECK(last == 1);
    CHECK(of_grid >= 10);
    CHECK(calls >= of_grid + 3);
    for (const int stop_at : {1, 3, of_grid / 2, of_grid + 1}) {
        int asked = 0;
        running.progress = [&](double) { return ++asked < stop_at; };
        CHECK(evaluate_all(coordinates, points, running).status() == Status::cancelled);
        CHECK(asked == stop_at);
        asked = 0;
        CHECK(coordinates.solve(running).status == Status::cancelled);
        CHECK(evaluate_all(coordinates, points).rows == expected.rows); // no functions are kept
    }
}

template <class C>
void check_cells(const C& cage, std::uint64_t seed) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    std::vector<cageform::GridCell<T, D>> cells;
    const Adaptive<C> coordinates(cage, {.accuracy = 0.02});
    REQUIRE(coordinates.for_each_cell([&](const auto& cell) { cells.push_back(cell); }).status == Status::ok);
    const auto bounds = bounds_of(cage.vertices());
    Random random(seed);
    std::size_t inside = 0;
    for (int n = 0; n < 200; ++n) {
        Vec<T, D> p{};
        for (std::size_t k = 0; k < D; ++k) p[k] = T(random.uniform(bounds.lower[k], bounds.upper[k]));
        std::size_t whole = 0, cut = 0;
        for (const auto& cell : cells) {
            bool holds = true;
            for (std::size_t k = 0; k < D; ++k)
                holds = holds && p[k] >= cell.low[k] && p[k] < cell.low[k] + cell.size;
            whole += holds && !cell.is_cut ? 1 : 0;
            cut += holds && cell.is_cut ? 1 : 0;
        }
        const bool is_inside = locate(cage, p, T(0)) == PointState::inside;
        CHECK((is_inside ? whole + cut == 1 : whole == 0 && cut <= 1));
        inside += is_inside ? 1 : 0;
    }
    CHECK(inside > 0);
}
TEMPLATE_TEST_CASE("the cells of an adaptive grid hold every point inside once",
                   "[coordinates][harmonic][tree][property]", CAGEFORM_SCALARS) {
    for (std::uint64_t seed = 0; seed < effort(4u, 1u); ++seed) {
        CAPTURE(seed);
        check_cells(Polygon<TestType>(random_star<TestType>(seed)), seed);
        check_cells(random_mesh(seed).template mesh<TestType>(), seed);
    }
    const cageform::HarmonicCoordinates<TestType, 2> coordinates(random_star<TestType>(1), {.resolution = 16},
                                                                 cageform::UniformGrid{});
    CHECK(coordinates.for_each_cell([](const auto&) { FAIL("a cell of none"); }).status ==
          Status::solver_not_supported);
}

TEST_CASE("adaptive weights have the boundary values of every kind of face",
          "[coordinates][harmonic][tree][oracle]") {
    constexpr double accuracy = effort(2e-3, 1e-2);
    for (const char* name : {"cube_quads", "box_mixed_diagonals_quads", "l_prism_product"}) {
        CAPTURE(name);
        const auto json = read_json(std::string("harmonic3d_") + name);
        const cageform::PolyhedralMesh<double> mesh(
            json["cage"]["vertices"].get<std::vector<std::array<double, 3>>>(),
            json["cage"]["faces"].get<std::vector<std::vector<int>>>());
        CHECK(largest_error(mesh, json["points"].get<std::vector<std::array<double, 3>>>(),
                            json["coordinates"].get<std::vector<std::vector<double>>>(),
                            accuracy) <= 4 * accuracy); // next to the prism's reflex edge
    }
    // A box without divisions has trilinear functions, for which the equations are exact.
    Random random(17);
    const Vec<double, 3> lower{-1, 2, 0}, upper{0.3, 3, 2};
    const auto box = cageform::box_mesh(lower, upper), divided = cageform::box_mesh(lower, upper, {2, 1, 3});
    Points3<double> points;
    std::vector<std::vector<double>> trilinear;
    for (int n = 0; n < 60; ++n) {
        Vec<double, 3> p{};
        for (std::size_t k = 0; k < 3; ++k) p[k] = random.uniform(lower[k], upper[k]);
        points.push_back(p);
        auto& row = trilinear.emplace_back();
        for (const auto& vertex : box.vertices()) {
            row.push_back(1);
            for (std::size_t k = 0; k < 3; ++k)
                row.back() *= 1 - std::fabs(p[k] - vertex[k]) / (upper[k] - lower[k]);
        }
    }
    CHECK(largest_error(box, points, trilinear, accuracy) <= 0.2 * accuracy);
    const cageform::HarmonicCoordinates uniform(divided, {.resolution = 96}, cageform::UniformGrid{});
    CHECK(largest_error(divided, points, evaluate_all(uniform, points).rows, accuracy) <=
          3e-2); // next to kinks of boundary values
}

TEST_CASE("the cells of an adaptive grid can be as small as a quarter of any bone's radius",
          "[coordinates][harmonic][tree][complex]") {
    const auto box = divided_box({2, 2, 2}, 1).mesh<double>();
    const double longest = 2;
    for (const double radius : {0.3, 1e-3, 1e-4, 3e-5, 1e-5}) {
        CAPTURE(radius);
        CellComplex<double, 3> cage(box);
        (void)cage.add_chain(Points3<double>{{0.7, 1, 1}, {1.3, 1, 1}}, radius);
        const unsigned depth = cageform::detail::TreeCage<3>::depth_of(cage, 1e-12);
        CHECK(std::ldexp(longest, -int(depth)) <= 0.25 * radius);
        CHECK((depth == 16 || std::ldexp(longest, 1 - int(depth)) > 0.25 * radius));
    }
}

TEST_CASE("adaptive weights next to bones are those of a fine uniform grid",
          "[coordinates][harmonic][tree][complex]") {
    constexpr double accuracy = effort(5e-3, 2e-2);
    const auto compare = [](const auto& cage, const auto& points, std::size_t resolution, double most) {
        using C = std::remove_cvref_t<decltype(cage)>;
        const cageform::HarmonicCoordinates uniform(cage, {.resolution = resolution},
                                                    cageform::UniformGrid{});
        const auto expected = evaluate_all(uniform, points);
        const auto weights = evaluate_all(Adaptive<C>(cage, {.accuracy = accuracy}), points);
        REQUIRE(weights.status() == Status::ok);
        double error = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            CHECK(weights.states[i] == expected.states[i]);
            error = larger(error, difference(weights.rows[i], expected.rows[i]));
        }
        CHECK(error <= most);
    };
    for (std::uint64_t seed = 0; seed < effort(3u, 1u); ++seed) {
        CAPTURE(seed);
        Random random(seed + 3);
        CellComplex<double, 2> plane(Polygon<double>(random_star<double>(seed)));
        const double radius = 0.02 * bounds_of(plane.vertices()).diagonal();
        const auto p = random_inside(plane.boundary(), random, 0.05);
        (void)plane.add_point(p, radius);
        Points2<double> points{p};
        for (int n = 0; n < 60; ++n) points.push_back(random_inside(plane.boundary(), random, 1e-3));
        for (int n = 0; n < 8; ++n) {
            const double t = n, distance = random.uniform(radius, 2 * radius);
            points.push_back(p + distance * Vec<double, 2>{std::cos(t), std::sin(t)});
        }
        compare(plane, points, 512, accuracy);
    }
    const auto mesh = divided_box({2, 2, 1}, 1.0).mesh<double>();
    const auto bounds = bounds_of(mesh.vertices());
    const auto middle = 0.5 * (bounds.lower + bounds.upper), side = bounds.upper - bounds.lower;
    CellComplex<double, 3> space(mesh);
    const std::array ends{middle - 0.2 * side, middle + 0.1 * side};
    (void)space.add_chain(ends, 0.12 * side[2]);
    Random random(8);
    Points3<double> points;
    for (int n = 0; n < 80; ++n) {
        Vec<double, 3> p{};
        for (std::size_t k = 0; k < 3; ++k) p[k] = random.uniform(bounds.lower[k], bounds.upper[k]);
        points.push_back(p);
    }
    compare(space, points, 96, 2 * accuracy);
}

/// Σ ∇h_i = 0 and Σ C_i ∇h_i = identity, up to the solver's error over the smallest cells.
template <class C, class Points>
void check_gradients(const C& cage, const Points& points) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    const auto gradients = gradients_of<T, D>(Adaptive<C>(cage, {.accuracy = 1e-3}), points);
    REQUIRE(gradients.evaluation.status == Status::ok);
    const double size = double(bounds_of(cage.vertices()).diagonal());
    std::size_t there = 0;
    double sums = 0, jacobians = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (gradients.states[i] != PointState::inside && gradients.states[i] != PointState::on_boundary)
            continue;
        ++there;
        Vec<double, D> sum{};
        std::array<Vec<double, D>, D> jacobian{};
        for (std::size_t h = 0; h < cage.size(); ++h) {
            const auto g = vec_cast<double>(gradients.rows[i][h]);
            const auto c = vec_cast<double>(cage.vertices()[h]) - vec_cast<double>(points[i]);
            sum = sum + g;
            for (std::size_t k = 0; k < D; ++k) jacobian[k] = jacobian[k] + c[k] * g;
        }
        for (std::size_t k = 0; k < D; ++k) {
            jacobian[k][k] -= 1;
            sums = larger(sums, std::fabs(sum[k]) * size);
            jacobians = larger(jacobians, cageform::detail::length(jacobian[k]));
        }
    }
    CHECK(10 * there >= 9 * points.size());
    CHECK(sums <= 0.05);
    CHECK(jacobians <= 0.05);
}
TEMPLATE_TEST_CASE("adaptive gradients keep linear precision up to the boundary",
                   "[coordinates][harmonic][tree][gradients][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    for (std::uint64_t seed = 0; seed < effort(3u, 1u); ++seed) {
        CAPTURE(seed);
        Random random(seed + 9);
        const Polygon<T> star(random_star<T>(seed));
        Points2<T> in_plane;
        for (int n = 0; n < 60; ++n) in_plane.push_back(random_inside(star, random, 1e-3));
        for (std::size_t i = 0; i + 1 < star.size(); i += 4)
            in_plane.push_back(T(0.5) * (star[i] + star[i + 1]));
        check_gradients(star, in_plane);
    }
    const Vec<T, 3> lower{T(-1), T(2), T(0)}, upper{T(0.3), T(3), T(2)};
    const auto box = cageform::box_mesh(lower, upper, {2, 2, 3});
    Random random(5);
    Points3<T> in_space;
    for (int n = 0; n < 60; ++n) {
        Vec<T, 3> p{};
        for (std::size_t k = 0; k < 3; ++k) p[k] = T(random.uniform(double(lower[k]), double(upper[k])));
        if (n % 10 == 0) p[std::size_t(n) / 10 % 3] = upper[std::size_t(n) / 10 % 3];
        in_space.push_back(p);
    }
    check_gradients(box, in_space);
}
TEST_CASE("adaptive gradients of the unit square are those of bilinear functions",
          "[coordinates][harmonic][tree][gradients]") {
    const Polygon<double> square(Points2<double>{{0, 0}, {1, 0}, {1, 1}, {0, 1}});
    const Points2<double> points{{0.3, 0.4}, {0.05, 0.7}, {0.96, 0.9}, {0.5, 0.1}};
    const auto gradients =
        gradients_of<double, 2>(Adaptive<Polygon<double>>(square, {.accuracy = 1e-3}), points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto [x, y] = std::pair(points[i][0], points[i][1]);
        CHECK(distance(gradients.rows[i][0], Vec<double, 2>{y - 1, x - 1}) <= 2e-3);
        CHECK(distance(gradients.rows[i][2], Vec<double, 2>{y, x}) <= 2e-3);
    }
}

TEST_CASE("unsupported options of an adaptive grid are refused with their own status",
          "[coordinates][harmonic][tree][status]") {
    const auto mesh = divided_box({1, 1, 1}, 1.0).mesh<double>();
    const std::vector<Vec<double, 3>> points{{0, 0, 0}};
    const auto status = [&](const auto& cage, const HarmonicOptions& options) {
        return evaluate_all(Adaptive<std::remove_cvref_t<decltype(cage)>>(cage, options), points).status();
    };
    CHECK(status(mesh, {.accuracy = 0.01}) == Status::ok);
    CHECK(status(mesh, {.accuracy = 1.0}) == Status::accuracy_not_supported);
    CHECK(status(mesh, {.accuracy = -1e-3}) == Status::accuracy_not_supported);
    CHECK(status(mesh, {.accuracy = 1e-9}) == Status::accuracy_not_supported);
    CHECK(status(mesh, {.resolution = 16}) == Status::solver_not_supported); // an option of UniformGrid
    // A cage that needs more memory than allowed is refused, with the number of bytes.
    auto plate = divided_box({1, 1, 1}, 1.0);
    for (auto& p : plate.vertices) p[2] *= 1e-5;
    for (const auto& cage : {mesh, plate.mesh<double>()}) {
        const HarmonicOptions options{.accuracy = 2e-5, .memory_limit = std::size_t{1} << 23};
        const auto refused = evaluate_all(Adaptive<TriangleMesh<double>>(cage, options), points);
        CHECK(refused.status() == Status::out_of_memory);
        CHECK(refused.evaluation.solver.bytes > options.memory_limit);
        const double sufficient = refused.evaluation.solver.sufficient_accuracy;
        if (cage.vertices()[0][2] > -0.1) { // the plate
            CHECK(sufficient == 0);
            continue;
        }
        CHECK(sufficient > options.accuracy);
        CHECK(status(cage, {.accuracy = sufficient, .memory_limit = options.memory_limit}) == Status::ok);
    }
    const Polygon<double> l_shape(
        std::vector<Vec<double, 2>>{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}});
    const HarmonicOptions options{.accuracy = 1e-5, .memory_limit = std::size_t{1} << 21};
    const auto refused =
        evaluate_all(Adaptive<Polygon<double>>(l_shape, options), std::vector<Vec<double, 2>>{{0.5, 0.5}});
    CHECK(refused.status() == Status::out_of_memory);
    CHECK(refused.evaluation.solver.bytes > options.memory_limit);
    const double sufficient = refused.evaluation.solver.sufficient_accuracy;
    CHECK(sufficient > options.accuracy);
    const auto accepted = evaluate_all(
        Adaptive<Polygon<double>>(l_shape, {.accuracy = sufficient, .memory_limit = options.memory_limit}),
        std::vector<Vec<double, 2>>{{0.5, 0.5}});
    CHECK(accepted.status() == Status::ok);
}

} // namespace
} // namespace harmonic_tree_tests

// Laws of harmonic functions: no interior extrema, the mean value property, bilinear functions in rectangles
// with linear sides.
#include "catch.hpp"
#include "pictures/level_lines.hpp"
#include "support/effort.hpp"
#include "support/larger.hpp"
#include "support/meshes.hpp"
#include "support/oracle.hpp"
#include "support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>

#include <numbers>

namespace harmonic_law_tests {

using namespace cageform_tests;
using cageform::HarmonicCoordinates;
using cageform::Vec;

namespace {

constexpr std::array names{"triangle",
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
                           "hole_hexagon_triangle_hole",
                           "straight_chain_square_straight_chain",
                           "splitting_chain_hexagonlike_split_chain"};

/// The distance of a point from the edges of a cage, including chains.
double clearance(const Oracle& oracle, const Vec<double, 2>& p) {
    double least = 1e300;
    const auto extend = [&](const Vec<double, 2>& a, const Vec<double, 2>& b) {
        const auto e = b - a;
        const double t = std::clamp(dot(p - a, e) / dot(e, e), 0.0, 1.0);
        least = std::min(least, distance(p, a + t * e));
    };
    std::size_t first = 0;
    for (const std::size_t size : oracle.loop_sizes) {
        for (std::size_t k = 0; k < size; ++k)
            extend(oracle.vertices[first + k], oracle.vertices[first + (k + 1) % size]);
        first += size;
    }
    for (std::size_t k = 1; k < oracle.chain.size(); ++k)
        extend(oracle.vertices[oracle.chain[k - 1]], oracle.vertices[oracle.chain[k]]);
    return least;
}

/// The largest error of the weights at reference points that are not next to the boundary.
template <class C>
double error_inside(const C& coordinates, const Oracle& oracle) {
    const auto weights = evaluate_all(coordinates, oracle.points);
    REQUIRE(weights.status() == Status::ok);
    double error = 0;
    std::size_t compared = 0;
    for (std::size_t i = 0; i < oracle.points.size(); ++i) {
        if (!oracle.tags[i].ends_with("interior")) continue; // or "part1_interior"
        error = cageform_tests::larger(error, difference(weights.rows[i], oracle.coordinates[i]));
        ++compared;
    }
    REQUIRE(compared >= 10);
    return error;
}

/// A prism of the reference data between z = 0 and z = 1. Its first vertices are its base.
struct Prism {
    nlohmann::json json;
    MeshData data;
    Oracle base;

    explicit Prism(const std::string& name)
        : json(read_json("harmonic3d_" + name + "_triangulated")) {
        for (const auto& v : json["cage"]["vertices"]) data.vertices.push_back({v[0], v[1], v[2]});
        for (const auto& f : json["cage"]["faces"]) data.faces.push_back({f[0], f[1], f[2]});
        for (const auto& v : data.vertices) {
            if (v[2] == 0) base.vertices.push_back({v[0], v[1]});
        }
        base.loop_sizes = {base.vertices.size()};
    }
    double longest() const {
        double size = 0;
        for (const auto& v : base.vertices) size = std::max({size, v[0], v[1]});
        return size;
    }
    /// The distance from the faces; 0 outside.
    double clearance(const Vec<double, 3>& p) const {
        const Vec<double, 2> below{p[0], p[1]};
        if (locate(base.cage<double>(), below, 0.0) != PointState::inside) return 0;
        return std::max(0.0, std::min({p[2], 1 - p[2], harmonic_law_tests::clearance(base, below)}));
    }
    /// The largest error at reference points, except next to edges, where the grid is coarse.
    double error_inside(const HarmonicCoordinates<double, 3>& coordinates) const {
        Points3<double> points;
        for (const auto& p : json["points"]) points.push_back({p[0], p[1], p[2]});
        const auto weights = evaluate_all(coordinates, points);
        REQUIRE(weights.status() == Status::ok);
        double error = 0;
        std::size_t compared = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (clearance(points[i]) < 0.05) continue;
            ++compared;
            for (std::size_t k = 0; k < data.vertices.size(); ++k) {
                const auto exact = json["coordinates"][i][k].get<double>();
                error = cageform_tests::larger(error, std::fabs(weights.rows[i][k] - exact));
            }
        }
        REQUIRE(compared >= 5);
        return error;
    }
};

} // namespace

TEST_CASE("harmonic functions have no interior extrema in polygons", "[coordinates][harmonic][property]") {
    for (const char* name : names) {
        CAPTURE(name);
        const auto oracle = read_oracle(std::string("harmonic2d_") + name);
        const auto cage = oracle.complex<double>();
        HarmonicCoordinates coordinates(cage, {.resolution = 64}, cageform::UniformGrid{});
        const double error = error_inside(coordinates, oracle) + 1e-6; // the solver's tolerance
        const auto bounds = cageform::bounds_of(std::span<const Vec<double, 2>>(oracle.vertices));
        const std::size_t side = 40;
        const double step =
            std::max(bounds.upper[0] - bounds.lower[0], bounds.upper[1] - bounds.lower[1]) / side;
        Points2<double> points;
        std::vector<int> number(side * side, -1); // index among the lattice points inside
        for (std::size_t n = 0; n < side * side; ++n) {
            const Vec<double, 2> p{bounds.lower[0] + (double(n % side) + 0.5) * step,
                                   bounds.lower[1] + (double(n / side) + 0.5) * step};
            // So far inside that the neighbours are inside too, in the same part.
            if (locate(oracle.cage<double>(), p, 0.0) != PointState::inside ||
                clearance(oracle, p) < 1e-3 * step)
                continue;
            number[n] = int(points.size());
            points.push_back(p);
        }
        const auto weights = evaluate_all(coordinates, points);
        REQUIRE(weights.status() == Status::ok);
        std::size_t looked_at = 0;
        for (std::size_t n = side + 1; n + side + 1 < side * side; ++n) {
            if (number[n] < 0 || clearance(oracle, points[std::size_t(number[n])]) < 1.5 * step) continue;
            const auto& here = weights.rows[std::size_t(number[n])];
            for (std::size_t i = 0; i < here.size(); ++i) {
                double least = 2, largest = -1;
                for (const std::size_t other : {n - side - 1, n - side, n - side + 1, n - 1, n + 1,
                                                n + side - 1, n + side, n + side + 1}) {
                    REQUIRE(number[other] >= 0);
                    const double value = weights.rows[std::size_t(number[other])][i];
                    least = std::min(least, value);
                    largest = cageform_tests::larger(largest, value);
                }
                CAPTURE(i);
                CHECK(here[i] <= largest + 2 * error);
                CHECK(here[i] >= least - 2 * error);
            }
            ++looked_at;
        }
        CHECK(looked_at > 60);
    }
}

TEST_CASE("level lines of harmonic functions are not closed and do not end inside",
          "[coordinates][harmonic][property]") {
    for (const char* name : {"l_shape", "star", "spiral", "biped", "cat"}) {
        CAPTURE(name);
        const auto oracle = read_oracle(std::string("harmonic2d_") + name);
        const auto cage = oracle.cage<double>();
        const auto bounds = cageform::bounds_of(cage.vertices());
        constexpr std::size_t side = 70;
        const double step =
            std::max(bounds.upper[0] - bounds.lower[0], bounds.upper[1] - bounds.lower[1]) / side;
        Points2<double> points;
        std::vector<std::size_t> numbers; // indices of the lattice points inside
        for (std::size_t n = 0; n < side * side; ++n) {
            const Vec<double, 2> p{bounds.lower[0] + (double(n % side) + 0.5) * step,
                                   bounds.lower[1] + (double(n / side) + 0.5) * step};
            if (locate(cage, p, 0.0) != PointState::inside || clearance(oracle, p) < 1e-3 * step) continue;
            points.push_back(p);
            numbers.push_back(n);
        }
        const auto weights =
            evaluate_all(HarmonicCoordinates(cage, {.resolution = 128}, cageform::UniformGrid{}), points);
        REQUIRE(weights.status() == Status::ok);
        std::size_t lines = 0;
        for (std::size_t i = 0; i < cage.size(); ++i) {
            std::vector<double> field(side * side, std::numeric_limits<double>::quiet_NaN());
            for (std::size_t k = 0; k < points.size(); ++k) field[numbers[k]] = weights.rows[k][i];
            const auto next_to_outside = [&](const cageform_support::Point2& p) {
                for (const double dx : {-1.0, 0.0, 1.0}) {
                    for (const double dy : {-1.0, 0.0, 1.0}) {
                        const double x = std::round(p.x) + dx, y = std::round(p.y) + dy;
                        if (x < 0 || y < 0 || x >= side || y >= side) return true;
                        if (std::isnan(field[std::size_t(y) * side + std::size_t(x)])) return true;
                    }
                }
                return false;
            };
            for (const double level : {0.05, 0.1, 0.2, 0.35, 0.5, 0.7}) {
                CAPTURE(i, level);
                for (const auto& line : cageform_support::level_lines(field, side, level)) {
                    CHECK(line.front() != line.back());
                    CHECK(next_to_outside(line.front()));
                    CHECK(next_to_outside(line.back()));
                    ++lines;
                }
            }
        }
        CHECK(lines > 20);
    }
}

TEST_CASE("harmonic weights are their mean over a circle and over a disc",
          "[coordinates][harmonic][property]") {
    // Gauss's mean value theorem. 64 points on a circle miss harmonics from the 64th on, which the factor
    // 0.9^64 makes small. A disc uses rings, by Gauss's rule of two points in the square of the radius.
    const double root = std::sqrt(1.0 / 3);
    const std::array rings{std::sqrt((1 - root) / 2), std::sqrt((1 + root) / 2)};
    for (const char* name : names) {
        CAPTURE(name);
        const auto oracle = read_oracle(std::string("harmonic2d_") + name);
        HarmonicCoordinates coordinates(oracle.complex<double>(), {.resolution = 64},
                                        cageform::UniformGrid{});
        const double allowed = 20 * (error_inside(coordinates, oracle) + 1e-6);
        Random random(11);
        Points2<double> points;
        constexpr std::size_t centres = 10, around = 64;
        for (std::size_t n = 0; n < centres; ++n) {
            const auto p = random_inside(oracle.cage<double>(), random, 0.02);
            const double radius = 0.9 * clearance(oracle, p);
            points.push_back(p);
            for (const double share : {1.0, rings[0], rings[1]}) {
                for (std::size_t k = 0; k < around; ++k) {
                    const double angle = 2 * std::numbers::pi * double(k) / around;
                    points.push_back(p + share * radius * Vec<double, 2>{std::cos(angle), std::sin(angle)});
                }
            }
        }
        const auto weights = evaluate_all(coordinates, points);
        REQUIRE(weights.status() == Status::ok);
        for (std::size_t n = 0; n < centres; ++n) {
            const std::size_t first = n * (1 + 3 * around);
            for (std::size_t i = 0; i < weights.rows[first].size(); ++i) {
                double circle = 0, disc = 0;
                for (std::size_t k = 0; k < 3 * around; ++k) {
                    const double value = weights.rows[first + 1 + k][i] / around;
                    (k < around ? circle : disc) += k < around ? value : value / 2;
                }
                CAPTURE(n, i, allowed);
                CHECK(std::fabs(circle - weights.rows[first][i]) <= allowed);
                CHECK(std::fabs(disc - weights.rows[first][i]) <= allowed);
            }
        }
    }
}

TEST_CASE("harmonic functions have no interior extrema in 3D", "[coordinates][harmonic][mesh][property]") {
    for (const char* name : {"cube", "l_prism"}) {
        CAPTURE(name);
        const Prism prism(name);
        HarmonicCoordinates coordinates(prism.data.mesh<double>(), {.resolution = 32},
                                        cageform::UniformGrid{});
        const double error = prism.error_inside(coordinates) + 1e-6; // the solver's tolerance
        constexpr std::size_t side = 17;
        const double step = prism.longest() / side;
        Points3<double> points;
        std::vector<int> number(side * side * side, -1); // index among the lattice points inside
        for (std::size_t n = 0; n < number.size(); ++n) {
            const Vec<double, 3> p{(double(n % side) + 0.5) * step, (double(n / side % side) + 0.5) * step,
                                   (double(n / (side * side)) + 0.5) * step};
            if (prism.clearance(p) < 1e-3 * step) continue;
            number[n] = int(points.size());
            points.push_back(p);
        }
        const auto weights = evaluate_all(coordinates, points);
        REQUIRE(weights.status() == Status::ok);
        std::size_t looked_at = 0;
        for (std::size_t n = 0; n < number.size(); ++n) {
            if (number[n] < 0 || prism.clearance(points[std::size_t(number[n])]) < 1.8 * step) continue;
            std::vector<std::size_t> around;
            for (std::size_t k = 0; k < 27; ++k) {
                const std::size_t other = n + k % 3 - 1 + side * (k / 3 % 3 - 1) + side * side * (k / 9 - 1);
                REQUIRE(number[other] >= 0);
                if (other != n) around.push_back(std::size_t(number[other]));
            }
            for (std::size_t i = 0; i < prism.data.vertices.size(); ++i) {
                double least = 2, largest = -1;
                for (const std::size_t other : around) {
                    least = std::min(least, weights.rows[other][i]);
                    largest = cageform_tests::larger(largest, weights.rows[other][i]);
                }
                CAPTURE(n, i, error);
                const double here = weights.rows[std::size_t(number[n])][i];
                CHECK(here <= largest + 2 * error);
                CHECK(here >= least - 2 * error);
            }
            ++looked_at;
        }
        CHECK(looked_at > 200);
    }
}

TEST_CASE("harmonic weights in 3D are their mean over a sphere", "[coordinates][harmonic][mesh][property]") {
    // Gauss's rule of eight points along the axis, sixteen points on each parallel: exact to degree 15.
    constexpr std::array<std::array<double, 2>, 4> gauss{{{0.1834346424956498, 0.3626837833783620},
                                                          {0.5255324099163290, 0.3137066458778873},
                                                          {0.7966664774136267, 0.2223810344533745},
                                                          {0.9602898564975363, 0.1012285362903763}}};
    for (const char* name : {"cube", "l_prism"}) {
        CAPTURE(name);
        const Prism prism(name);
        HarmonicCoordinates coordinates(prism.data.mesh<double>(), {.resolution = 32},
                                        cageform::UniformGrid{});
        const double error = prism.error_inside(coordinates) + 1e-6; // the solver's tolerance
        Random random(3);
        constexpr std::size_t centres = 8;
        Points3<double> points;
        while (points.size() < centres * (1 + 128)) {
            const double size = prism.longest();
            const Vec<double, 3> p{random.uniform(0, size), random.uniform(0, size), random.uniform(0, 1)};
            const double radius = 0.9 * prism.clearance(p);
            if (radius < 0.09) continue;
            points.push_back(p);
            for (const auto& [height, weight] : gauss) {
                for (const double z : {height, -height}) {
                    for (int k = 0; k < 16; ++k) {
                        const double angle = 2 * std::numbers::pi * k / 16, across = std::sqrt(1 - z * z);
                        points.push_back(p + radius * Vec<double, 3>{across * std::cos(angle),
                                                                     across * std::sin(angle), z});
                    }
                }
            }
        }
        const auto weights = evaluate_all(coordinates, points);
        REQUIRE(weights.status() == Status::ok);
        for (std::size_t n = 0; n < centres; ++n) {
            const std::size_t first = n * (1 + 128);
            for (std::size_t i = 0; i < prism.data.vertices.size(); ++i) {
                double mean = 0;
                for (std::size_t k = 0; k < 128; ++k)
                    mean += gauss[k / 32][1] / 2 * weights.rows[first + 1 + k][i] / 16;
                CAPTURE(n, i, error);
                CHECK(std::fabs(mean - weights.rows[first][i]) <= 20 * error);
            }
        }
    }
}

TEST_CASE("the letter aleph in its square agrees with exact fractions", "[coordinates][harmonic][oracle]") {
    const Points2<double> cage{{1, 1}, {1, 15}, {15, 15}, {15, 1}}, pose{{1, 1}, {5, 20}, {18, 12}, {15, 3}};
    const auto reference = read_json("fields");
    const auto& rows = reference["aleph"];
    Points2<double> points, moved;
    for (const auto& row : rows) points.push_back({row["point"][0], row["point"][1]});
    REQUIRE(points.size() == 6);
    const auto bound = cageform::bind(HarmonicCoordinates(cageform::Polygon<double>(cage)), points);
    REQUIRE(bound.report.status == Status::ok);
    moved.resize(points.size());
    REQUIRE(cageform::clone(bound.value, pose, moved) == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        for (std::size_t k = 0; k < 2; ++k)
            CHECK(moved[i][k] == Approx(rows[i]["clone_numbers"][k].get<double>()).epsilon(0).margin(3e-5));
    }
}

TEST_CASE("linear values around a rectangle are linear in it", "[coordinates][harmonic][property]") {
    // Exercise 11 of the course project: 1, 2, 3, 2 at the corners gives 1 + (x − x₀)/a + (y − y₀)/b.
    const auto seed = GENERATE(range(1u, 6u));
    CAPTURE(seed);
    Random random(seed);
    const double x0 = random.uniform(-3, 3), y0 = random.uniform(-3, 3), a = random.uniform(0.3, 3),
                 b = random.uniform(0.3, 3);
    const cageform::Polygon<double> cage(
        Points2<double>{{x0, y0}, {x0 + a, y0}, {x0 + a, y0 + b}, {x0, y0 + b}});
    Points2<double> points;
    for (int n = 0; n < 100; ++n)
        points.push_back({x0 + a * random.uniform(0.001, 0.999), y0 + b * random.uniform(0.001, 0.999)});
    const auto weights =
        evaluate_all(HarmonicCoordinates(cage, {.resolution = 64}, cageform::UniformGrid{}), points);
    REQUIRE(weights.status() == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto& w = weights.rows[i];
        const double wanted = 1 + (points[i][0] - x0) / a + (points[i][1] - y0) / b;
        CHECK(w[0] + 2 * w[1] + 3 * w[2] + 2 * w[3] == Approx(wanted).epsilon(0).margin(1e-5));
    }
}

} // namespace harmonic_law_tests

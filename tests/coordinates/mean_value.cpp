// Mean value coordinates: reference values, a slow formula with angles, and limits.
#include "catch.hpp"
#include "support/effort.hpp"
#include "support/larger.hpp"
#include "support/oracle.hpp"
#include "support/thin_cages.hpp"
#include "support/weights.hpp"

#include <cageform/coordinates/mean_value.hpp>

#include <array>

namespace mean_value_tests {

using namespace cageform_tests;
using cageform::epsilon;
using cageform::Polygon;

namespace {

template <class T>
using Mean = cageform::MeanValueCoordinates<T, 2>;

constexpr std::array oracles{"triangle",
                             "unit_square",
                             "square_extra_vertex",
                             "rectangle",
                             "hexagon",
                             "l_shape",
                             "star",
                             "spiral",
                             "biped",
                             "cat",
                             "square_square_hole",
                             "hexagon_triangle_hole"};

/// The definition with angles in long double, for points off the boundary.
template <class T>
std::vector<long double> by_definition(const Polygon<T>& cage, const Vec<T, 2>& p) {
    std::vector<long double> w(cage.size(), 0);
    for (std::size_t k = 0; k < cage.loops().size(); ++k) {
        const auto& loop = cage.loops()[k];
        const bool turns_left = cageform::signed_area(cage, loop) > 0;
        const bool hole = cageform::detail::loop_depth(cage, k) % 2 == 1;
        const long double sign = turns_left != hole ? 1 : -1;
        for (std::size_t i = loop.begin; i < loop.end; ++i) {
            const std::size_t j = i + 1 < loop.end ? i + 1 : loop.begin;
            const auto u = cageform::vec_cast<long double>(cage[i]) - cageform::vec_cast<long double>(p);
            const auto v = cageform::vec_cast<long double>(cage[j]) - cageform::vec_cast<long double>(p);
            const long double angle = sign * std::atan2(cross(u, v), dot(u, v));
            w[i] += std::tan(angle / 2) / std::hypot(u[0], u[1]);
            w[j] += std::tan(angle / 2) / std::hypot(v[0], v[1]);
        }
    }
    const long double sum = sum_of(w);
    for (auto& x : w) x /= sum;
    return w;
}

/// The distance of a boundary point from the cage's other vertices and edges: the length over which weights
/// change by about 1.
template <class T>
double room_about(const Polygon<T>& cage, const Vec<T, 2>& place, double diagonal) {
    double room = diagonal;
    const double here = 1e-4 * diagonal;
    cage.for_each_edge([&](std::size_t i, std::size_t j) {
        const double to_edge = double(cageform::nearest_on_edge(cage, i, j, place).distance);
        const double to_vertex = distance(cage[i], place);
        if (to_edge > here) room = std::min(room, to_edge);
        if (to_vertex > here) room = std::min(room, to_vertex);
    });
    return room;
}

template <class T>
Vec<T, 2> middle_of(const Polygon<T>& cage) {
    const auto b = cageform::bounds_of(cage.vertices());
    return T(0.5) * (b.lower + b.upper);
}

/// Points at `distance` diagonals from the cage.
template <class T>
Points2<T> ring_of_points(const Polygon<T>& cage, double distance, int count, Random& random) {
    const auto middle = middle_of(cage);
    const double radius = distance * double(cageform::bounds_of(cage.vertices()).diagonal());
    Points2<T> points;
    for (int i = 0; i < count; ++i) {
        const double angle = random.uniform(0, 6.3);
        points.push_back({T(double(middle[0]) + radius * std::cos(angle)),
                          T(double(middle[1]) + radius * std::sin(angle))});
    }
    return points;
}

} // namespace

TEST_CASE("mean value weights are those of the oracle", "[coordinates][mean_value][oracle]") {
    for (const char* name : oracles) {
        const auto oracle = read_oracle(std::string("meanvalue2d_") + name);
        REQUIRE(oracle.points.size() >= 20);
        const Mean<double> coordinates(oracle.cage<double>());
        const auto weights = evaluate_all(coordinates, oracle.points);
        REQUIRE(weights.status() == Status::ok);
        for (std::size_t i = 0; i < oracle.points.size(); ++i) {
            CAPTURE(name, i, oracle.tags[i], text(weights.rows[i]));
            CHECK(difference(weights.rows[i], oracle.coordinates[i]) <= 1e-12); // measured: 1.4e-15
            CHECK(cageform::to_string(weights.states[i]) ==
                  std::string(oracle.tags[i].starts_with("on_")      ? "on_boundary"
                              : oracle.tags[i].starts_with("inside") ? "inside"
                                                                     : "outside"));
        }
    }
}

TEST_CASE("mean value weights in float are those of the oracle up to the rounding of points",
          "[coordinates][mean_value][oracle]") {
    for (const char* name : oracles) {
        const auto oracle = read_oracle(std::string("meanvalue2d_") + name);
        const auto cage = oracle.cage<float>();
        const auto weights = evaluate_all(Mean<float>(cage), oracle.points);
        REQUIRE(weights.status() == Status::ok);
        // Rounding to float moves points and cage by half an epsilon of their coordinates. Next to a corner,
        // weights change by 1 over the length of the shorter side. Points within 8 epsilon of an edge count
        // as on it.
        const auto bounds = cageform::bounds_of(cage.vertices());
        double shortest = double(bounds.diagonal());
        cage.for_each_edge(
            [&](std::size_t i, std::size_t j) { shortest = std::min(shortest, distance(cage[i], cage[j])); });
        const double size = double(std::max(bounds.diagonal(), bounds.magnitude()));
        const double bound = 16 * double(epsilon<float>) * size / shortest;
        for (std::size_t i = 0; i < oracle.points.size(); ++i) {
            CAPTURE(name, i, oracle.tags[i], bound, text(weights.rows[i]));
            CHECK(difference(weights.rows[i], oracle.coordinates[i]) <=
                  bound * absolute_sum(oracle.coordinates[i]));
        }
    }
}

TEMPLATE_TEST_CASE("mean value weights are those of the definition", "[coordinates][mean_value][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(100, 20)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1000);
    const auto cage = seed % 2 == 0 ? Polygon<T>(random_star<T>(std::uint64_t(seed)))
                                    : random_rings<T>(std::uint64_t(seed));
    const double eps = double(epsilon<T>);
    const double diagonal = double(cageform::bounds_of(cage.vertices()).diagonal());
    const double relative_size = size_of(cage.vertices()) / diagonal;
    Points2<T> points;
    for (int i = 0; i < 40; ++i) points.push_back(random_inside(cage, random, 1e-3));
    for (const double far : {0.7, 1.0, 3.0, 10.0, 30.0, 60.0, 70.0, 100.0, 130.0, 200.0}) {
        for (const auto& p : ring_of_points(cage, far, 8, random)) points.push_back(p);
    }
    const auto weights = evaluate_all(Mean<T>(cage), points);
    REQUIRE(weights.status() == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto expected = by_definition(cage, points[i]);
        const double away = distance(points[i], middle_of(cage)) / diagonal;
        CAPTURE(i, away, text(weights.rows[i]), text(expected));
        // Far away, the sum of the w_i is the remainder of terms larger by a factor of the distance. (The
        // oracle cancels as well, in long double.)
        CHECK(difference(weights.rows[i], expected) <=
              8 * std::max(1.0, away) * eps * relative_size * absolute_sum(expected));
    }
}

TEMPLATE_TEST_CASE("mean value weights sum to 1 and reproduce the point",
                   "[coordinates][mean_value][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(50, 10)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 2000);
    const auto cage = seed % 2 == 0 ? Polygon<T>(random_star<T>(std::uint64_t(seed)))
                                    : random_rings<T>(std::uint64_t(seed));
    const double eps = double(epsilon<T>);
    Points2<T> points;
    for (int i = 0; i < 100; ++i) points.push_back(random_inside(cage, random, 0));
    for (const auto& p : ring_of_points(cage, 0.6, 20, random)) points.push_back(p);
    const auto weights = evaluate_all(Mean<T>(cage), points);
    REQUIRE(weights.status() == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, text(weights.rows[i]));
        const double scale = absolute_sum(weights.rows[i]);
        CHECK(std::fabs(double(sum_of(weights.rows[i]) - 1)) <= 8 * eps * scale);
        CHECK(distance(combine(weights.rows[i], cage.vertices()), points[i]) <=
              8 * eps * scale * size_of(cage.vertices()));
    }
}

TEST_CASE("float weights of thousands of vertices sum to 1", "[coordinates][mean_value]") {
    const auto seed = GENERATE(seeds(4));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const double least = random.uniform(0.5, 1); // teeth
    Points2<float> cage(3000), points(300);
    for (std::size_t i = 0; i < cage.size(); ++i) {
        const double angle = 2 * std::numbers::pi * double(i) / double(cage.size());
        const double radius = i % 2 == 0 ? 1 : least;
        cage[i] = {float(radius * std::cos(angle)), float(radius * std::sin(angle))};
    }
    for (auto& p : points) p = {float(random.uniform(-1.2, 1.2)), float(random.uniform(-1.2, 1.2))};
    for (const auto& row : evaluate_all(Mean<float>(cage), points).rows)
        CHECK(std::fabs(double(sum_of(row) - 1)) <= 12 * double(epsilon<float>) * absolute_sum(row));
}

TEMPLATE_TEST_CASE("mean value weights reproduce points far outside", "[coordinates][mean_value][far]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(50, 10)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 3000);
    const auto cage = seed % 2 == 0 ? Polygon<T>(random_star<T>(std::uint64_t(seed)))
                                    : random_rings<T>(std::uint64_t(seed));
    const double diagonal = double(cageform::bounds_of(cage.vertices()).diagonal());
    const double relative_size = size_of(cage.vertices()) / diagonal;
    for (const double far : {1.0, 10.0, 60.0, 64.0, 100.0, 128.0, 129.0, 1e3, 1e4, 1e5, 1e6}) {
        const auto points = ring_of_points(cage, far, 10, random);
        const auto weights = evaluate_all(Mean<T>(cage), points);
        REQUIRE(weights.status() == Status::ok);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(far, i, text(weights.rows[i]));
            CHECK(weights.states[i] == PointState::outside);
            const double error = distance(combine(weights.rows[i], cage.vertices()), points[i]);
            if constexpr (sizeof(T) == 8) CHECK(error <= 1e-9 * far * diagonal);
            // Up to 128 diagonals in the scalar itself, farther in one with at least 11 more bits.
            const double lost = far <= 128 ? far : sizeof(T) == 4 ? 1 : std::max(1.0, far / 128);
            CHECK(error <= 32 * double(epsilon<T>) * lost * far * diagonal * relative_size);
        }
    }
}

TEMPLATE_TEST_CASE("extremely far points are outside or unreached, with finite weights",
                   "[coordinates][mean_value][far]", CAGEFORM_SCALARS) {
    // The sum of the weights is of the order of 1/distance², which no scalar resolves here.
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(30, 6)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 3500);
    const Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
    for (const double far : {1e12, 1e15, 1e18, 1e25, 1e34}) {
        const auto points = ring_of_points(cage, far, 20, random);
        const auto weights = evaluate_all(Mean<T>(cage), points);
        REQUIRE(weights.status() == Status::ok);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(far, i, text(weights.rows[i]));
            CHECK((weights.states[i] == PointState::outside || weights.states[i] == PointState::unreached));
            if (weights.states[i] != PointState::outside) continue;
            CHECK(std::all_of(weights.rows[i].begin(), weights.rows[i].end(),
                              [](T w) { return cageform::is_finite(w); }));
        }
    }
}

TEMPLATE_TEST_CASE("mean value weights are continuous at edges", "[coordinates][mean_value][limit]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(60, 12)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 4000);
    const auto cage = seed % 2 == 0 ? Polygon<T>(random_star<T>(std::uint64_t(seed)))
                                    : random_rings<T>(std::uint64_t(seed));
    const Mean<T> coordinates(cage);
    const double diagonal = double(cageform::bounds_of(cage.vertices()).diagonal());
    const double rounding = double(epsilon<T>) * size_of(cage.vertices());
    for (int n = 0; n < 12; ++n) {
        const double s = n % 3 == 0 ? 0.0 : random.uniform(0.05, 0.95);
        const auto [first, second, place] = on_edge(cage, random.below(cage.size()), s);
        std::vector<double> limit(cage.size(), 0.0);
        limit[first] = 1 - s;
        limit[second] += s;
        const double room = room_about(cage, place, diagonal);
        const double angle = random.uniform(0, 6.3);
        Points2<T> points{place};
        for (double away = 0.1 * diagonal; away > 1e-17 * diagonal; away /= 2) {
            points.push_back(
                {T(double(place[0]) + away * std::cos(angle)), T(double(place[1]) + away * std::sin(angle))});
        }
        const auto weights = evaluate_all(coordinates, points);
        REQUIRE(weights.status() == Status::ok);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double away = distance(points[i], place);
            if (away > room / 4) continue;
            CAPTURE(n, s, room, away, text(weights.rows[i]), text(limit));
            // 16 is the rate of change of weights per free length. `rounding` is for the position, and for
            // the 8 roundings from the boundary that count as on it.
            CHECK(difference(weights.rows[i], limit) <=
                  16 * (away + rounding) / room + 8 * double(epsilon<T>));
        }
    }
}

TEMPLATE_TEST_CASE("points outside thin cages are outside", "[coordinates][mean_value][state][thin]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(60));
    Random random{std::uint64_t(seed)};
    const double width = std::pow(10.0, random.uniform(sizeof(T) == 4 ? -6.5 : -15, -1));
    const double turn = seed % 2 == 0 ? 0 : random.uniform(0, 6.3);
    CAPTURE(seed, width, turn);
    const auto at = [&](double x, double y) {
        return Vec<T, 2>{T(x * std::cos(turn) - y * std::sin(turn)),
                         T(x * std::sin(turn) + y * std::cos(turn))};
    };
    const double w = width, v = 1 - width;
    check_thin_states(Mean<T>(Points2<T>{at(0, 0), at(1, 0), at(1, w), at(0, w)}), random);
    check_thin_states(Mean<T>(Points2<T>{at(0, 0), at(1, 0), at(1, 1), at(v, 1), at(v, w), at(0, w)}),
                      random);
    const Points2<T> ring{at(0, 0), at(1, 0), at(1, 1), at(0, 1), at(w, w), at(v, w), at(v, v), at(w, v)};
    const std::vector<std::size_t> loops{4, 4};
    const Mean<T> hollow(Polygon<T>(ring, loops));
    check_thin_states(hollow, random);
    check_thin_states(Mean<T>(thin_simplex<T, 2>(random, width)), random);
    if (hollow.cage_report().status != Status::ok) return;
    const auto states = evaluate_all(hollow, Points2<T>{at(0.5, 0.5), at(0.3, 0.6)}).states;
    CHECK(states == std::vector<PointState>{PointState::outside, PointState::outside});
}

TEMPLATE_TEST_CASE("a point in the middle of a thin cage is inside", "[coordinates][mean_value][state][thin]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    for (const double width : {1e-2, 1e-4, sizeof(T) == 4 ? 1e-5 : 1e-9, sizeof(T) == 4 ? 1e-5 : 1e-13}) {
        CAPTURE(width);
        const T w = T(width);
        const Mean<T> bar(Points2<T>{{0, 0}, {1, 0}, {1, w}, {0, w}});
        Points2<T> points;
        for (int i = 1; i < 20; ++i) points.push_back({T(0.05) * T(i), w / 2});
        const auto weights = evaluate_all(bar, points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CHECK(weights.states[i] == PointState::inside);
            CHECK(affine_residual(weights.rows[i], bar.handles(), points[i]) <= 16 * double(epsilon<T>));
        }
    }
}

TEMPLATE_TEST_CASE("mean value states are those of locate", "[coordinates][mean_value][state]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(40, 8)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 6000);
    const auto cage = random_rings<T>(std::uint64_t(seed));
    const auto bounds = cageform::bounds_of(cage.vertices());
    const T tolerance = cageform::coincidence_tolerance(bounds);
    Points2<T> points;
    for (int i = 0; i < 300; ++i) {
        points.push_back({T(random.uniform(double(bounds.lower[0]), double(bounds.upper[0]))),
                          T(random.uniform(double(bounds.lower[1]), double(bounds.upper[1])))});
    }
    for (std::size_t edge = 0; edge < cage.size(); ++edge) {
        const auto [i, j, place] = on_edge(cage, edge, random.uniform(0, 1));
        points.push_back(cage[i]);
        points.push_back(place);
        for (const double away : {1e-1, 1e-2, 1e-3}) {
            const double angle = random.uniform(0, 6.3), radius = away * double(bounds.diagonal());
            points.push_back(
                {place[0] + T(radius * std::cos(angle)), place[1] + T(radius * std::sin(angle))});
        }
    }
    for (const auto& p : ring_of_points(cage, 300, 10, random)) points.push_back(p);
    const auto weights = evaluate_all(Mean<T>(cage), points);
    REQUIRE(weights.status() == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto expected = cageform::locate(cage, points[i], tolerance);
        const double off = double(cageform::nearest_on_boundary(cage, points[i]).distance / tolerance);
        if (off > 0.5 && off < 2) continue; // rounding may decide
        CAPTURE(i, off, points[i][0], points[i][1]);
        CHECK(cageform::to_string(weights.states[i]) == std::string(cageform::to_string(expected)));
    }
}

TEST_CASE("mean value weights are negative in the biped, between its legs",
          "[coordinates][mean_value][negative]") {
    const auto oracle = read_oracle("meanvalue2d_biped");
    const auto cage = oracle.cage<double>();
    const auto bounds = cageform::bounds_of(cage.vertices());
    Points2<double> points;
    for (int x = 0; x <= 80; ++x) {
        for (int y = 0; y <= 130; ++y) {
            const Vec<double, 2> p{bounds.lower[0] + (bounds.upper[0] - bounds.lower[0]) * x / 80.0,
                                   bounds.lower[1] + (bounds.upper[1] - bounds.lower[1]) * y / 130.0};
            if (cageform::locate(cage, p, 1e-9) == PointState::inside) points.push_back(p);
        }
    }
    const auto weights = evaluate_all(Mean<double>(cage), points);
    double least = 0;
    for (const auto& row : weights.rows) least = std::min({least, row[1], row[2], row[5], row[6]});
    CHECK(least < -0.30);
    CHECK(least > -0.32);
}

TEMPLATE_TEST_CASE("mean value weights at the ends of the scalar's range", "[coordinates][mean_value][scale]",
                   CAGEFORM_SCALARS) {
    // Squares of lengths are just representable.
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(10, 2)));
    const double scale = sizeof(T) == 4 ? GENERATE(1e-15, 1e15) : GENERATE(1e-150, 1e150);
    CAPTURE(seed, scale);
    Random random(std::uint64_t(seed) + 7000);
    auto vertices = random_star<T>(std::uint64_t(seed));
    const double unit = double(cageform::bounds_of(Polygon<T>(vertices).vertices()).diagonal());
    for (auto& v : vertices) v = T(1 / unit) * v;
    const Polygon<T> cage(vertices);
    Points2<T> points;
    for (int i = 0; i < 40; ++i) points.push_back(random_inside(cage, random, 1e-2));
    const auto expected = evaluate_all(Mean<T>(cage), points);
    for (auto& v : vertices) v = T(scale) * v;
    for (auto& p : points) p = T(scale) * p;
    for (int i = 0; i < 10; ++i) points.push_back(T(random.uniform(2, 1e5)) * vertices[0]);
    points.push_back(vertices[0]);
    const auto weights = evaluate_all(Mean<T>(Polygon<T>(vertices)), points);
    REQUIRE(weights.status() == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, text(weights.rows[i]));
        if (i < 40) {
            CHECK(weights.states[i] == PointState::inside);
            CHECK(difference(weights.rows[i], expected.rows[i]) <=
                  100 * 8 * double(epsilon<T>)); // 1 / clearance
        } else if (i < 50) {
            CHECK(weights.states[i] == PointState::outside);
            CHECK(distance(combine(weights.rows[i], vertices), points[i]) <=
                  1024 * double(epsilon<T>) * absolute_sum(weights.rows[i]) * size_of(vertices));
        } else {
            CHECK(weights.states[i] == PointState::on_boundary);
            CHECK(weights.rows[i][0] == T(1));
        }
    }
}

TEMPLATE_TEST_CASE("nearest_boundary of mean value coordinates returns the nearest point",
                   "[coordinates][mean_value][nearest]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(20, 4)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 8000);
    const auto cage = random_rings<T>(std::uint64_t(seed));
    const Mean<T> coordinates(cage);
    const double diagonal = double(cageform::bounds_of(cage.vertices()).diagonal());
    for (const auto& p : ring_of_points(cage, 0.4, 20, random)) {
        std::vector<T> row(cage.size(), T(42));
        const auto q = coordinates.nearest_boundary(p, row);
        double nearest = 1e9 * diagonal;
        for (std::size_t edge = 0; edge < cage.size(); ++edge) {
            for (int k = 0; k <= 100; ++k)
                nearest = std::min(nearest, distance(p, on_edge(cage, edge, k / 100.0).position));
        }
        const double rounding = 4 * double(epsilon<T>) * size_of(cage.vertices());
        CHECK(distance(p, q) <= nearest + rounding);
        CHECK(distance(p, q) >= nearest - 0.01 * diagonal); // half a step of the samples
        CHECK(distance(combine(row, cage.vertices()), q) <= rounding);
        CHECK(std::fabs(double(sum_of(row) - 1)) <= double(epsilon<T>));
        CHECK(*std::min_element(row.begin(), row.end()) >= T(0));
    }
}

TEST_CASE("mean value coordinates keep their cage", "[coordinates][mean_value]") {
    const std::vector<std::array<float, 2>> square{{0, 0}, {2, 0}, {2, 2}, {0, 2}};
    const cageform::MeanValueCoordinates<double, 2> coordinates(square);
    CHECK(coordinates.cage().size() == 4);
    CHECK(coordinates.handles().size() == 4);
    CHECK(coordinates.handles()[2] == Vec<double, 2>{2, 2});
    CHECK(coordinates.cage_report().status == Status::ok);
    STATIC_REQUIRE(cageform::MeanValueCoordinates<double, 2>::has_extension);
    std::array<double, 4> row{};
    CHECK(cageform::weights_at(coordinates, Vec<float, 2>{1, 1}, row) == PointState::inside);
    for (const double w : row) CHECK(w == Approx(0.25).epsilon(1e-15));
}

TEST_CASE("points on edges are known at the ends of float's range", "[coordinates][mean_value][scale]") {
    const int exponent = GENERATE(-120, -80, 0, 80, 120);
    CAPTURE(exponent);
    const float scale = std::ldexp(1.0f, exponent);
    std::vector<Vec<float, 2>> cage{{0, 0}, {4, 0}, {4, 3}, {2, 1}, {0, 3}};
    for (auto& c : cage) c = scale * c;
    const cageform::MeanValueCoordinates<float, 2> coordinates(cage);
    REQUIRE(coordinates.cage_report().status == Status::ok);
    std::vector<float> row(cage.size());
    for (std::size_t i = 0; i < cage.size(); ++i) {
        const auto middle = 0.5f * (cage[i] + cage[(i + 1) % cage.size()]);
        CHECK(cageform::weights_at(coordinates, middle, row) == PointState::on_boundary);
        CHECK(cageform::weights_at(coordinates, cage[i], row) == PointState::on_boundary);
    }
}

} // namespace mean_value_tests

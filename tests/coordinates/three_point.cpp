// Three-point coordinates, of Wachspress, discrete harmonic and other functions: exact values, other types,
// and common laws.
#include "catch.hpp"
#include "support/effort.hpp"
#include "support/gradients.hpp"
#include "support/oracle.hpp"
#include "support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/three_point.hpp>

#include <array>

namespace three_point_tests {

using namespace cageform_tests;
using cageform::epsilon;
using cageform::Polygon;
using cageform::ThreePointCoordinates;

namespace {

struct MeanValue { // f = r
    static constexpr bool homogeneous = true;
    template <class X>
    X operator()(const X& rr) const {
        using std::sqrt;
        return sqrt(rr);
    }
};
struct SquareRoot { // f = √r
    static constexpr bool homogeneous = true;
    template <class X>
    X operator()(const X& rr) const {
        using std::sqrt;
        return sqrt(sqrt(rr));
    }
};
struct Hyperbola { // f = √(1 + r²): not homogeneous
    template <class X>
    X operator()(const X& rr) const {
        using std::sqrt;
        return sqrt(X(1) + rr);
    }
};
struct Cubic { // f = r³
    template <class X>
    X operator()(const X& rr) const {
        using std::sqrt;
        return rr * sqrt(rr);
    }
};
struct Zero {
    template <class X>
    X operator()(const X&) const {
        return X(0);
    }
};

template <class T>
using Wachspress = cageform::WachspressCoordinates<T>;
template <class T>
using Harmonic = cageform::DiscreteHarmonicCoordinates<T>;

static_assert(cageform::GradientCoordinates<cageform::WachspressCoordinates<float>>);
static_assert(cageform::GradientCoordinates<cageform::WachspressCoordinates<double>>);
static_assert(cageform::GradientCoordinates<cageform::DiscreteHarmonicCoordinates<float>>);
static_assert(cageform::GradientCoordinates<cageform::DiscreteHarmonicCoordinates<double>>);
static_assert(cageform::GradientCoordinates<ThreePointCoordinates<double, Hyperbola>>);

/// A strictly convex polygon of 3 to 12 vertices, from edges sorted by direction; of either orientation,
/// moved and scaled (10^-3 … 10^3).
template <class T>
Polygon<T> random_convex(std::uint64_t seed) {
    Random random(seed);
    const std::size_t count = 3 + random.below(10);
    const double scale = std::pow(10.0, random.uniform(-3, 3));
    std::vector<Vec<double, 2>> edges(count);
    Vec<double, 2> sum{};
    for (std::size_t i = 0; i + 1 < count; ++i) {
        edges[i] = {random.uniform(-1, 1), random.uniform(-1, 1)};
        sum = sum + edges[i];
    }
    edges.back() = -1.0 * sum;
    std::sort(edges.begin(), edges.end(),
              [](const auto& a, const auto& b) { return std::atan2(a[1], a[0]) < std::atan2(b[1], b[0]); });
    Points2<T> vertices(count);
    Vec<double, 2> at{random.uniform(-2, 2), random.uniform(-2, 2)};
    for (std::size_t i = 0; i < count; ++i) {
        vertices[seed % 2 == 0 ? i : count - 1 - i] = cageform::vec_cast<T>(scale * at);
        at = at + edges[i];
    }
    return Polygon<T>(vertices);
}

/// The reciprocal of the least sine of an outer angle. Rounding of A_i and A_{i−1} corresponds to a point
/// moved by a rounding divided by that sine.
template <class T>
double flatness(const Polygon<T>& cage) {
    double least = 1;
    for (std::size_t i = 0, n = cage.size(); i < n; ++i) {
        const auto at = cageform::vec_cast<double>(cage[i]);
        const auto a = at - cageform::vec_cast<double>(cage[(i + n - 1) % n]);
        const auto b = cageform::vec_cast<double>(cage[(i + 1) % n]) - at;
        least = std::min(least, std::fabs(cross(a, b)) / std::sqrt(dot(a, a) * dot(b, b)));
    }
    return 1 / least;
}

/// A random polygon with outer angles far from zero, also in float.
template <class T>
Polygon<T> random_round(std::uint64_t seed) {
    for (std::uint64_t n = 0;; ++n) {
        auto cage = random_convex<T>(seed + 2 * 7919 * n);
        if (flatness(cage) < 100) return cage;
    }
}

/// Points inside, some within 1e-9 diagonals (float: 1e-4) of edges and vertices.
template <class T>
Points2<T> points_in(const Polygon<T>& cage, Random& random, int count) {
    Points2<T> points;
    const auto bounds = cageform::bounds_of(cage.vertices());
    const auto middle = cageform::vec_cast<T>(
        combine(std::vector<double>(cage.size(), 1.0 / double(cage.size())), cage.vertices()));
    for (int i = 0; i < count; ++i) {
        if (i % 3 != 0) {
            points.push_back(random_inside(cage, random, 1e-4));
        } else {
            const double s = i % 2 == 0 ? random.uniform(0.01, 0.99) : 0;
            const auto place = on_edge(cage, random.below(cage.size()), s).position;
            const double away = std::pow(10.0, random.uniform(sizeof(T) == 8 ? -9 : -4, -1));
            points.push_back(place + T(away) * (middle - place));
        }
        if (cageform::locate(cage, points.back(), cageform::coincidence_tolerance(bounds)) !=
            PointState::inside)
            points.pop_back();
    }
    return points;
}

/// The formula of the papers, in long double.
template <class Cage, class T, class F>
std::vector<long double> by_definition(const Cage& cage, const Vec<T, 2>& p, const F& f) {
    const std::size_t n = cage.size();
    const auto u = [&](std::size_t i) {
        return cageform::vec_cast<long double>(cage[i % n]) - cageform::vec_cast<long double>(p);
    };
    const auto area = [&](std::size_t i, std::size_t j) { return cross(u(i), u(j)); };
    std::vector<long double> w(n);
    for (std::size_t i = n; i < 2 * n; ++i) {
        const auto c = [&](std::size_t k) { return f(dot(u(k), u(k))); };
        const auto before = area(i - 1, i), after = area(i, i + 1);
        w[i - n] = (c(i + 1) * before - c(i) * area(i - 1, i + 1) + c(i - 1) * after) / (before * after);
    }
    const long double sum = sum_of(w);
    for (auto& x : w) x /= sum;
    return w;
}

template <class C>
void check_family(const nlohmann::json& json, const C& coordinates, const char* member, int& compared) {
    const auto points = json["points"].get<std::vector<std::array<double, 2>>>();
    const auto expected = json["members"][member]["coordinates"].get<std::vector<std::vector<double>>>();
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    REQUIRE(expected.size() == points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(member, i, text(weights.rows[i]), text(expected[i]));
        CHECK(weights.states[i] == (i < 6 ? PointState::inside : PointState::on_boundary));
        CHECK(difference(weights.rows[i], expected[i]) <= 1e-13);
        ++compared;
    }
}

} // namespace

TEST_CASE("three-point weights are those of the oracle", "[coordinates][three_point][oracle]") {
    int compared = 0;
    const auto check = [&](const auto& coordinates, const Oracle& oracle) {
        using T = typename std::remove_cvref_t<decltype(coordinates)>::scalar;
        const auto weights = evaluate_all(coordinates, oracle.points);
        REQUIRE(weights.status() == Status::ok);
        for (std::size_t i = 0; i < oracle.points.size(); ++i) {
            CAPTURE(i, oracle.tags[i], text(weights.rows[i]));
            CHECK(difference(weights.rows[i], oracle.coordinates[i]) <=
                  (sizeof(T) == 8 ? 1e-13 : 3e-6)); // points and cage are rounded to float
            if (sizeof(T) == 8) CHECK(weights.states[i] == PointState::inside);
            ++compared;
        }
    };
    for (const char* name : {"triangle", "unit_square", "rectangle", "hexagon"}) {
        CAPTURE(name);
        const auto wachspress = read_oracle(std::string("wachspress2d_") + name);
        check(Wachspress<double>(wachspress.cage<double>()), wachspress);
        check(Wachspress<float>(wachspress.cage<float>()), wachspress);
        const auto harmonic = read_oracle(std::string("discrete_harmonic2d_") + name);
        check(Harmonic<double>(harmonic.cage<double>()), harmonic);
        check(Harmonic<float>(harmonic.cage<float>()), harmonic);
    }
    CHECK(compared >= 4 * 4 * 8);
}

TEST_CASE("the family of six functions is that of exact arithmetic", "[coordinates][three_point][oracle]") {
    int compared = 0;
    for (const char* name : {"kite", "rectangle_1x8", "right_triangle", "unit_square"}) {
        CAPTURE(name);
        const auto json = read_json(std::string("family2d_") + name);
        const Polygon<double> cage(json["cage"]["vertices"].get<std::vector<std::array<double, 2>>>());
        check_family(json, Wachspress<double>(cage), "wachspress", compared);
        check_family(json, Harmonic<double>(cage), "discrete_harmonic", compared);
        check_family(json, ThreePointCoordinates<double, MeanValue>(cage), "mean_value", compared);
        check_family(json, ThreePointCoordinates<double, SquareRoot>(cage), "square_root", compared);
        check_family(json, ThreePointCoordinates<double, Hyperbola>(cage), "hyperbola", compared);
        check_family(json, ThreePointCoordinates<double, Cubic>(cage), "cubic", compared);
    }
    CHECK(compared == 4 * 6 * 8);
}

TEMPLATE_TEST_CASE("three-point weights sum to one, reproduce the point and are those of the definition",
                   "[coordinates][three_point][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(60, 12)));
    CAPTURE(seed);
    const auto cage = random_convex<T>(std::uint64_t(seed));
    Random random(std::uint64_t(seed) + 1);
    const auto points = points_in(cage, random, 60);
    REQUIRE(points.size() > 20);
    const double eps = double(epsilon<T>), flat = flatness(cage), size = size_of(cage.vertices());
    const double diagonal = double(cageform::bounds_of(cage.vertices()).diagonal());
    const auto check = [&](const auto& coordinates, const auto& f) {
        const auto weights = evaluate_all(coordinates, points);
        REQUIRE(weights.status() == Status::ok);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double scale = absolute_sum(weights.rows[i]);
            CAPTURE(i, flat, text(weights.rows[i]));
            CHECK(weights.states[i] == PointState::inside);
            CHECK(std::fabs(double(sum_of(weights.rows[i]) - 1)) <= 8 * eps * scale);
            CHECK(distance(combine(weights.rows[i], cage.vertices()), points[i]) <=
                  32 * eps * size * scale * std::max(1.0, flat / 32));
            CHECK(difference(weights.rows[i], by_definition(cage, points[i], f)) <=
                  16 * eps * size / diagonal * scale * flat);
        }
    };
    check(Wachspress<T>(cage), cageform::Wachspress{});
    check(Harmonic<T>(cage), cageform::DiscreteHarmonic{});
    check(ThreePointCoordinates<T, Hyperbola>(cage), Hyperbola{});
}

TEMPLATE_TEST_CASE("three-point weights agree with other types in special cases",
                   "[coordinates][three_point][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(40, 8)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 2000);
    const double eps = double(epsilon<T>);
    const auto compare = [&](const auto& a, const auto& b, const Points2<T>& points, double bound) {
        const auto one = evaluate_all(a, points), other = evaluate_all(b, points);
        REQUIRE(one.status() == Status::ok);
        REQUIRE(other.status() == Status::ok);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(i, text(one.rows[i]), text(other.rows[i]));
            CHECK(difference(one.rows[i], other.rows[i]) <= bound);
        }
    };
    // In a triangle all types are barycentric coordinates.
    const Polygon<T> triangle(random_simplex<T, 2>(std::uint64_t(seed)));
    const double relative =
        size_of(triangle.vertices()) / double(cageform::bounds_of(triangle.vertices()).diagonal());
    const auto inside = points_in(triangle, random, 30);
    const cageform::BarycentricCoordinates<T, 2> barycentric(triangle);
    compare(Wachspress<T>(triangle), barycentric, inside, 16 * eps * relative);
    compare(Harmonic<T>(triangle), barycentric, inside, 16 * eps * relative);
    if constexpr (sizeof(T) == 8)
        compare(ThreePointCoordinates<T, SquareRoot>(triangle), barycentric, inside, 32 * eps * relative);

    // f = r gives mean value coordinates.
    const auto cage = random_round<T>(std::uint64_t(seed));
    const auto points = points_in(cage, random, 30);
    compare(ThreePointCoordinates<T, MeanValue>(cage), cageform::MeanValueCoordinates<T, 2>(cage), points,
            sizeof(T) == 8 ? 1e-13 : 1e-4);

    // Vertices on a circle: r² is a constant plus a linear function of u, which has no effect on the weights.
    Points2<T> ring(3 + random.below(8));
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const double angle = 6.28 * (double(i) + random.uniform(-0.3, 0.3)) / double(ring.size());
        ring[i] = {T(3 * std::cos(angle)), T(3 * std::sin(angle))};
    }
    const auto in_ring = points_in(Polygon<T>(ring), random, 30);
    compare(Wachspress<T>(ring), Harmonic<T>(ring), in_ring, sizeof(T) == 8 ? 1e-13 : 5e-5);
}

TEST_CASE("discrete harmonic weights of thousands of vertices are accurate in float",
          "[coordinates][three_point]") {
    // Along edges this short, the difference of two squares is mostly rounding, with an error of 4e-5.
    Points2<float> cage(2000), points(100);
    for (std::size_t i = 0; i < cage.size(); ++i) {
        const double angle = 2 * std::numbers::pi * double(i) / double(cage.size());
        cage[i] = {float(std::cos(angle)), float(0.8 * std::sin(angle))};
    }
    Random random(9);
    for (auto& p : points) p = {float(random.uniform(-0.6, 0.6)), float(random.uniform(-0.5, 0.5))};
    const auto weights = evaluate_all(Harmonic<float>(cage), points);
    const auto expected = evaluate_all(Harmonic<double>(cage), points);
    REQUIRE(weights.status() == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        CHECK(difference(weights.rows[i], expected.rows[i]) <= 1e-6);
        CHECK(std::fabs(double(sum_of(weights.rows[i]) - 1)) <= 12 * double(epsilon<float>));
    }
}

TEST_CASE("three-point weights of a turned, moved and scaled cage are the same",
          "[coordinates][three_point][property]") {
    const auto seed = GENERATE(seeds(effort(30, 8)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 3000);
    const auto cage = random_round<double>(std::uint64_t(seed));
    const auto points = points_in(cage, random, 30);
    const double angle = random.uniform(0, 6.3), scale = std::pow(10.0, random.uniform(-2, 2));
    const double c = scale * std::cos(angle), s = scale * std::sin(angle), side = seed % 3 == 0 ? -1 : 1;
    const AffineMap<2> map{{{{c, -s * side}, {s, c * side}}}, {}};
    const Polygon<double> turned(map(cage.vertices()));
    const auto places = map(std::span<const Vec<double, 2>>(points));
    const double relative =
        size_of(cage.vertices()) / double(cageform::bounds_of(cage.vertices()).diagonal());
    const auto check = [&](const auto& a, const auto& b) {
        const auto one = evaluate_all(a, points), other = evaluate_all(b, places);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(i, text(one.rows[i]), text(other.rows[i]));
            CHECK(difference(one.rows[i], other.rows[i]) <= 64 * epsilon<double> * relative * flatness(cage));
        }
    };
    check(Wachspress<double>(cage), Wachspress<double>(turned));
    check(Harmonic<double>(cage), Harmonic<double>(turned));
    check(ThreePointCoordinates<double, SquareRoot>(cage), ThreePointCoordinates<double, SquareRoot>(turned));
}

TEST_CASE("Wachspress weights and those of √(1 + r²) are nowhere negative, those of √r and r² are",
          "[coordinates][three_point][property]") {
    double wachspress = 1, hyperbola = 1;
    int polygons = 0;
    for (std::uint64_t seed = 0; seed < effort(10'000u, 500u); ++seed) {
        const auto cage = random_convex<double>(seed);
        Random random(seed + 4000);
        Points2<double> points;
        for (int i = 0; i < 8; ++i) points.push_back(random_inside(cage, random, 0));
        const auto least = [&](const auto& coordinates) {
            double found = 1;
            for (const auto& row : evaluate_all(coordinates, points).rows)
                found = std::min(found, *std::min_element(row.begin(), row.end()));
            return found;
        };
        const Wachspress<double> coordinates(cage);
        if (coordinates.cage_report().status != Status::ok) continue;
        ++polygons;
        wachspress = std::min(wachspress, least(coordinates));
        hyperbola = std::min(hyperbola, least(ThreePointCoordinates<double, Hyperbola>(cage)) /
                                            std::max(1.0, flatness(cage)));
    }
    CAPTURE(polygons);
    CHECK(polygons >= int(effort(9'990u, 499u)));
    CHECK(wachspress >= 0);
    CHECK(hyperbola >= -8 * epsilon<double>);

    std::vector<double> weights(6);
    const std::vector<std::array<double, 2>> thin{{0, -2}, {3, -4}, {7, -2}, {9, 4}, {7, 3}, {4, 1}};
    const std::array<double, 2> spot{7.79, 2.65};
    REQUIRE(weights_at(ThreePointCoordinates<double, SquareRoot>(thin), spot, weights) == PointState::inside);
    CHECK(weights[5] < -0.015);
    REQUIRE(weights_at(Harmonic<double>(thin), std::array<double, 2>{4, 0.5}, weights) == PointState::inside);
    CHECK(*std::min_element(weights.begin(), weights.end()) < 0);
}

TEMPLATE_TEST_CASE("three-point weights are continuous at edges and vertices",
                   "[coordinates][three_point][limit]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(30, 8)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 5000);
    const auto cage = random_round<T>(std::uint64_t(seed));
    const double diagonal = double(cageform::bounds_of(cage.vertices()).diagonal());
    const auto middle = cageform::vec_cast<double>(
        combine(std::vector<double>(cage.size(), 1.0 / double(cage.size())), cage.vertices()));
    const auto check = [&](const auto& coordinates) {
        for (int n = 0; n < 8; ++n) {
            const double s = n % 3 == 0 ? 0.0 : random.uniform(0.05, 0.95);
            const auto [first, second, place] = on_edge(cage, random.below(cage.size()), s);
            std::vector<double> limit(cage.size(), 0.0);
            limit[first] = 1 - s;
            limit[second] += s;
            Points2<T> points{place};
            for (double away = 1e-3; away > 1e-17; away /= 4)
                points.push_back(cageform::vec_cast<T>(cageform::vec_cast<double>(place) +
                                                       away * (middle - cageform::vec_cast<double>(place))));
            const auto weights = evaluate_all(coordinates, points);
            REQUIRE(weights.status() == Status::ok);
            CHECK(weights.states[0] == PointState::on_boundary);
            const auto slope = difference(weights.rows[1], limit) / distance(points[1], place);
            for (std::size_t i = 0; i < points.size(); ++i) {
                CAPTURE(n, s, i, text(weights.rows[i]), text(limit));
                const double rounding = 16 * double(epsilon<T>) * size_of(cage.vertices());
                CHECK(difference(weights.rows[i], limit) <=
                      (4 * slope + 1 / diagonal) * (distance(points[i], place) + rounding) * 4);
                CHECK(weights.states[i] != PointState::outside);
            }
        }
    };
    check(Wachspress<T>(cage));
    check(Harmonic<T>(cage));
}

TEMPLATE_TEST_CASE("three-point coordinates refuse what is not strictly convex, by vertex",
                   "[coordinates][three_point][status]", CAGEFORM_SCALARS) {
    using T = TestType;
    using Kind = cageform::CageFaultKind;
    using Corners = std::vector<Vec<T, 2>>;
    const auto faults_of = [](const auto& report, Kind kind) {
        std::vector<std::size_t> vertices;
        for (const auto& fault : report.faults) {
            if (fault.kind == kind) vertices.push_back(fault.a);
        }
        return vertices;
    };
    const Corners arrow{{0, 0}, {4, -1}, {1, 0}, {4, 1}}, reversed(arrow.rbegin(), arrow.rend());
    const Harmonic<T> concave(arrow);
    CHECK(concave.cage_report().status == Status::cage_not_convex);
    CHECK(faults_of(concave.cage_report(), Kind::vertex_not_convex) == std::vector<std::size_t>{2});
    CHECK(faults_of(Wachspress<T>(reversed).cage_report(), Kind::vertex_not_convex) ==
          std::vector<std::size_t>{1});
    CHECK(evaluate_all(concave, arrow).status() == Status::cage_not_convex);
    CHECK(cageform::bind(concave, arrow).report.status == Status::cage_not_convex);

    const Corners straight{{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}};
    CHECK(faults_of(Wachspress<T>(straight).cage_report(), Kind::vertex_not_convex) ==
          std::vector<std::size_t>{1});

    const Corners nearly{{0, 0}, {1, -epsilon<T>}, {2, 0}, {2, 2}, {0, 2}}; // convex by a rounding
    CHECK(faults_of(Wachspress<T>(nearly).cage_report(), Kind::vertex_not_convex) ==
          std::vector<std::size_t>{1});

    const Corners two{{0, 0}, {9, 0}, {9, 9}, {0, 9}, {3, 3}, {5, 3}, {4, 4}};
    const Wachspress<T> loops(Polygon<T>(two, std::vector<std::size_t>{4, 3}));
    CHECK(loops.cage_report().status == Status::cage_not_convex);
    CHECK(faults_of(loops.cage_report(), Kind::vertex_not_convex) == std::vector<std::size_t>{4});

    const Corners square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    cageform::CellComplex<T, 2> complex{Polygon<T>(square)};
    CHECK(Wachspress<T>(complex).cage_report().status == Status::ok);
    complex.add_chain(Corners{{T(0.2), T(0.2)}, {T(0.5), T(0.5)}});
    CHECK(Wachspress<T>(complex).cage_report().status == Status::interior_cells_not_supported);

    CHECK(Wachspress<T>(Corners{{0, 0}, {1, 1}, {1, 0}, {0, 1}}).cage_report().status ==
          Status::cage_self_crossing);
    CHECK(Wachspress<T>(Corners{{0, 0}, {1, 0}, {1, 0}, {0, 1}}).cage_report().status ==
          Status::duplicate_vertices);
    CHECK(Wachspress<T>(Corners{{0, 0}, {1, 0}}).cage_report().status == Status::too_few_vertices);
    const T nan = std::numeric_limits<T>::quiet_NaN();
    CHECK(Wachspress<T>(Corners{{0, 0}, {1, nan}, {0, 1}}).cage_report().status == Status::vertex_not_finite);
    CHECK(cageform::bind(Wachspress<T>(Corners{}), square).report.status == Status::too_few_vertices);
}

TEMPLATE_TEST_CASE("three-point coordinates locate points, at any size of the cage",
                   "[coordinates][three_point][state]", CAGEFORM_SCALARS) {
    using T = TestType;
    const T nan = std::numeric_limits<T>::quiet_NaN(), huge = std::numeric_limits<T>::max();
    for (const int exponent :
         sizeof(T) == 8 ? std::vector<int>{0, 500, -500} : std::vector<int>{0, 60, -60}) {
        CAPTURE(exponent);
        const T s = std::ldexp(T(1), exponent), tiny = s * epsilon<T>;
        const Points2<T> cage{{-s, -s}, {2 * s, -s}, {s, s}, {-s, s}};
        const Points2<T> points{
            {0, 0},      {s, s},   {s - tiny, s - tiny}, {0, s},     {0, s + 4 * tiny}, {0, 2 * s},
            {5 * s, -s}, {nan, 0}, {huge, huge},         {-huge, s}, {0, -huge},        {s / 2, -s / 2}};
        const std::array expected{PointState::inside,      PointState::on_boundary, PointState::on_boundary,
                                  PointState::on_boundary, PointState::on_boundary, PointState::outside,
                                  PointState::outside,     PointState::not_finite,  PointState::outside,
                                  PointState::outside,     PointState::outside,     PointState::inside};
        const auto check = [&](const auto& coordinates) {
            const auto weights = evaluate_all(coordinates, points);
            REQUIRE(weights.status() == Status::ok);
            const auto gradients = gradients_of<T, 2>(coordinates, points);
            for (std::size_t i = 0; i < points.size(); ++i) {
                CAPTURE(i);
                CHECK(weights.states[i] == expected[i]);
                CHECK(gradients.states[i] == expected[i]);
            }
            CHECK(weights.rows[1] == std::vector<T>{0, 0, 1, 0}); // next to two edges: the vertex
            CHECK(difference(weights.rows[3], std::vector<T>{0, 0, T(0.5), T(0.5)}) <= 8 * epsilon<T>);
            CHECK(distance(combine(weights.rows[0], cage), points[0]) <= 16 * double(tiny));
        };
        check(Wachspress<T>(cage));
        check(Harmonic<T>(cage));
        // Σ w = 0: there are no weights except on the boundary, whose limits do not depend on f.
        const auto none = evaluate_all(ThreePointCoordinates<T, Zero>(cage), points);
        CHECK(none.states[0] == PointState::unreached);
        CHECK(none.states[3] == PointState::on_boundary);
        CHECK(none.states[5] == PointState::outside);

        const auto bound =
            cageform::bind(Harmonic<T>(cage), points, {.outside = cageform::OutsidePoints::nearest_boundary});
        CHECK(bound.report.status == Status::ok);
        CHECK(bound.report.outside.size() == 5);
        CHECK(bound.report.not_finite == std::vector<std::size_t>{7});
    }
}

TEMPLATE_TEST_CASE("gradients of three-point weights keep the laws and are those of differences",
                   "[coordinates][three_point][gradients]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(20, 6)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 6000);
    const auto cage = random_round<T>(std::uint64_t(seed));
    const double size = double(cageform::bounds_of(cage.vertices()).diagonal());
    auto points = points_in(cage, random, 40);
    const std::size_t inside = points.size();
    for (std::size_t i = 0; i < cage.size(); ++i) {
        points.push_back(cage[i]);
        points.push_back(on_edge(cage, i, random.uniform(0.2, 0.8)).position);
    }
    const auto check = [&](const auto& coordinates, const auto& f) {
        const auto gradients = gradients_of<T, 2>(coordinates, points);
        REQUIRE(gradients.evaluation.status == Status::ok);
        CHECK(gradients.states == evaluate_all(coordinates, points).states);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(i, inside, points[i][0], points[i][1]);
            // Next to an edge, the two large weights cancel in long double in proportion to 1/distance.
            const double away = double(cageform::nearest_on_boundary(cage, points[i]).distance) / size;
            const double lost = i < inside ? double(std::numeric_limits<long double>::epsilon()) / away : 0;
            CHECK(law_error<T, 2>(cage.vertices(), points[i], gradients.rows[i]) <=
                  (sizeof(T) == 8 ? 1e-11 + lost * flatness(cage) : 2e-6));
            if (i >= inside || away < 1e-5) continue; // where differences are less accurate
            // Central differences of the definition, with a step smaller than the distance from the boundary.
            const double h = 1e-4 * size * away;
            std::vector<Vec<double, 2>> expected(cage.size());
            for (std::size_t k = 0; k < 2; ++k) {
                auto below = cageform::vec_cast<long double>(points[i]), above = below;
                below[k] -= static_cast<long double>(h);
                above[k] += static_cast<long double>(h);
                Points2<long double> wide;
                for (const auto& v : cage.vertices()) wide.push_back(cageform::vec_cast<long double>(v));
                const auto a = by_definition(wide, below, f), b = by_definition(wide, above, f);
                for (std::size_t v = 0; v < cage.size(); ++v)
                    expected[v][k] = size * double((b[v] - a[v]) / static_cast<long double>(2 * h));
            }
            CHECK(error_of(gradients.rows[i], expected, size) <= 1e-6);
        }
    };
    check(Wachspress<T>(cage), cageform::Wachspress{});
    check(Harmonic<T>(cage), cageform::DiscreteHarmonic{});
    if constexpr (sizeof(T) == 8) check(ThreePointCoordinates<T, Hyperbola>(cage), Hyperbola{});
}

} // namespace three_point_tests

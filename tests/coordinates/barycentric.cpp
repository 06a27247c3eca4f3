// Barycentric coordinates in one to four dimensions.
#include "catch.hpp"
#include "support/effort.hpp"
#include "support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/barycentric.hpp>

#include <array>

namespace barycentric_tests {

using namespace cageform_tests;
using cageform::BarycentricCoordinates;
using cageform::epsilon;

namespace {

/// Σ β_i c_i in long double, rounded to the scalar.
template <class T, std::size_t D>
Vec<T, D> mix(const std::vector<Vec<T, D>>& corners, const std::vector<double>& shares) {
    return cageform::vec_cast<T>(combine(shares, corners));
}

/// The longest extent of a simplex divided by its least height: the amplification of rounding errors.
template <class T, std::size_t D>
double condition(const std::vector<Vec<T, D>>& corners) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t top = 0; top <= D; ++top) {
        // Gram-Schmidt on the edges from another corner, the edge to the top last: its remainder is the
        // height.
        std::vector<Vec<long double, D>> edges;
        const auto at = [&](std::size_t i) {
            return cageform::vec_cast<long double>(corners[(top + i) % (D + 1)]);
        };
        for (std::size_t i = 2; i <= D + 1; ++i) {
            auto edge = at(i) - at(1);
            for (const auto& e : edges) edge = edge - (dot(edge, e) / dot(e, e)) * e;
            edges.push_back(edge);
        }
        least = std::min(least, double(std::sqrt(dot(edges.back(), edges.back()))));
    }
    return size_of(corners) / least;
}

template <class T, std::size_t D>
struct In {
    using scalar = T;
    static constexpr std::size_t dimension = D;
};

} // namespace

TEMPLATE_TEST_CASE("the worked example: a triangle whose first vertex is moved", "[coordinates][barycentric]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const std::vector<Vec<T, 2>> triangle{{0, 0}, {0, 3}, {3, 3}};
    const BarycentricCoordinates<T, 2> coordinates(triangle);
    std::array<T, 3> beta{};
    REQUIRE(cageform::weights_at(coordinates, Vec<T, 2>{1, 2}, beta) == PointState::inside);
    for (const T b : beta) CHECK(std::fabs(b - T(1) / 3) <= 2 * epsilon<T>);
    const auto bound = cageform::bind(coordinates, std::vector<Vec<T, 2>>{{1, 2}});
    REQUIRE(bound.report.status == Status::ok);
    std::vector<Vec<T, 2>> moved(1);
    REQUIRE(cageform::clone(bound.value, std::vector<Vec<T, 2>>{{4, 1}, {0, 3}, {3, 3}}, moved) ==
            Status::ok);
    CHECK(std::fabs(moved[0][0] - T(7) / 3) <= 4 * epsilon<T>);
    CHECK(std::fabs(moved[0][1] - T(7) / 3) <= 4 * epsilon<T>);
}

TEMPLATE_TEST_CASE("barycentric coordinates of a convex combination are its shares",
                   "[coordinates][barycentric][property]", (In<float, 1>), (In<double, 2>), (In<float, 3>),
                   (In<double, 4>)) {
    using T = typename TestType::scalar;
    constexpr std::size_t D = TestType::dimension;
    const auto seed = GENERATE(seeds(effort(50, 10)));
    CAPTURE(seed, D);
    Random random(std::uint64_t(seed) + 100);
    const auto corners = random_simplex<T, D>(std::uint64_t(seed));
    const BarycentricCoordinates<T, D> coordinates(corners);
    REQUIRE(coordinates.cage_report().status == Status::ok);
    REQUIRE(coordinates.handles().size() == D + 1);
    std::vector<Vec<T, D>> points;
    std::vector<std::vector<double>> shares;
    for (int i = 0; i < 50; ++i) {
        shares.push_back(random_shares(D + 1, random));
        if (i % 2 == 1) { // outside: away from the corner opposite to a face
            const std::size_t away = random.below(D + 1);
            const double by = random.uniform(0.05, 5) + shares.back()[away];
            for (double& s : shares.back()) s += by / double(D);
            shares.back()[away] -= by * (1 + 1 / double(D));
        }
        points.push_back(mix(corners, shares.back()));
    }
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    const double rounding = double(epsilon<T>) * condition(corners);
    CAPTURE(condition(corners));
    REQUIRE(condition(corners) < 500); // checks that the simplices are well-conditioned
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, text(weights.rows[i]), text(shares[i]));
        CHECK(weights.states[i] == (i % 2 == 0 ? PointState::inside : PointState::outside));
        const double scale = absolute_sum(shares[i]);
        CHECK(difference(weights.rows[i], shares[i]) <= 4 * rounding * scale);
        CHECK(std::fabs(double(sum_of(weights.rows[i]) - 1)) <= 4 * double(epsilon<T>) * scale);
        CHECK(distance(combine(weights.rows[i], corners), points[i]) <=
              4 * rounding * scale * size_of(corners));
        const double least = double(*std::min_element(weights.rows[i].begin(), weights.rows[i].end()));
        CHECK((least >= 0) == (i % 2 == 0));
    }
}

TEMPLATE_TEST_CASE("on a face of a simplex the weights are the face's own",
                   "[coordinates][barycentric][property]", (In<float, 1>), (In<double, 2>), (In<float, 3>),
                   (In<double, 4>)) {
    using T = typename TestType::scalar;
    constexpr std::size_t D = TestType::dimension;
    const auto seed = GENERATE(seeds(effort(30, 6)));
    CAPTURE(seed, D);
    Random random(std::uint64_t(seed) + 200);
    const auto corners = random_simplex<T, D>(std::uint64_t(seed));
    const BarycentricCoordinates<T, D> coordinates(corners);
    std::vector<Vec<T, D>> points;
    std::vector<std::vector<double>> shares;
    for (unsigned face = 1; face + 1 < (1u << (D + 1)); ++face) { // vertices, edges, triangles, …
        auto some = random_shares(D + 1, random);
        double sum = 0;
        for (std::size_t i = 0; i <= D; ++i) sum += some[i] *= (face >> i) & 1u;
        for (double& s : some) s /= sum;
        shares.push_back(some);
        points.push_back(mix(corners, some));
    }
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, text(weights.rows[i]), text(shares[i]));
        CHECK(difference(weights.rows[i], shares[i]) <= 4 * double(epsilon<T>) * condition(corners));
        CHECK(weights.states[i] == PointState::on_boundary);
    }
}

TEMPLATE_TEST_CASE("cages that are not a simplex, degenerate or not finite have their own status",
                   "[coordinates][barycentric][status]", (In<float, 1>), (In<double, 2>), (In<float, 3>),
                   (In<double, 4>)) {
    using T = typename TestType::scalar;
    constexpr std::size_t D = TestType::dimension;
    const auto seed = GENERATE(seeds(effort(20, 4)));
    CAPTURE(seed, D);
    Random random(std::uint64_t(seed) + 300);
    const auto good = random_simplex<T, D>(std::uint64_t(seed));
    const auto status_of = [](const std::vector<Vec<T, D>>& corners) {
        const BarycentricCoordinates<T, D> coordinates(corners);
        const auto weights = evaluate_all(coordinates, std::vector<Vec<T, D>>(3));
        CHECK(weights.status() == coordinates.cage_report().status);
        CHECK(weights.states == std::vector<PointState>(3, PointState::unreached)); // unchanged
        return weights.status();
    };
    CHECK(BarycentricCoordinates<T, D>(good).cage_report().status == Status::ok);

    auto corners = good;
    corners.push_back(corners[0]);
    CHECK(status_of(corners) == Status::not_a_simplex);
    corners.resize(D);
    CHECK(status_of(corners) == Status::not_a_simplex);
    CHECK(status_of({}) == Status::not_a_simplex);

    for (const T bad : {std::numeric_limits<T>::quiet_NaN(), -std::numeric_limits<T>::infinity()}) {
        corners = good;
        const std::size_t i = random.below(D + 1);
        corners[i][random.below(D)] = bad;
        CHECK(status_of(corners) == Status::vertex_not_finite);
        const BarycentricCoordinates<T, D> coordinates(corners);
        REQUIRE(coordinates.cage_report().faults.size() == 1);
        CHECK(coordinates.cage_report().faults[0].a == i);
    }

    // A corner on the opposite face, up to rounding.
    corners = good;
    const std::size_t flat = random.below(D + 1);
    auto shares = random_shares(D + 1, random);
    const double missing = shares[flat] / double(D);
    for (double& s : shares) s += missing;
    shares[flat] = 0;
    corners[flat] = mix(good, shares);
    CHECK(status_of(corners) == Status::degenerate_simplex);
    // A corner a thousand times farther from the face than the tolerance.
    const double height = 8000 * double(epsilon<T>) * condition(good);
    for (double& s : shares) s *= 1 - height;
    shares[flat] = height;
    corners[flat] = mix(good, shares);
    CHECK(BarycentricCoordinates<T, D>(corners).cage_report().status == Status::ok);
    corners.assign(D + 1, good[0]);
    CHECK(status_of(corners) == Status::degenerate_simplex);
}

TEMPLATE_TEST_CASE("the nearest boundary point of a simplex is the nearest",
                   "[coordinates][barycentric][nearest]", (In<double, 2>), (In<float, 3>)) {
    using T = typename TestType::scalar;
    constexpr std::size_t D = TestType::dimension;
    const auto seed = GENERATE(seeds(effort(30, 6)));
    CAPTURE(seed, D);
    Random random(std::uint64_t(seed) + 400);
    const auto corners = random_simplex<T, D>(std::uint64_t(seed));
    const BarycentricCoordinates<T, D> coordinates(corners);
    const double size = size_of(corners), rounding = 4 * double(epsilon<T>) * size;

    // A dense lattice on every face.
    constexpr int steps = D == 2 ? 400 : 40;
    std::vector<Vec<long double, D>> samples;
    for (std::size_t opposite = 0; opposite <= D; ++opposite) {
        for (int a = 0; a <= steps; ++a) {
            for (int b = 0; b <= (D == 2 ? 0 : steps - a); ++b) {
                std::vector<double> shares;
                const std::array<int, 3> parts{a, D == 2 ? steps - a : b, steps - a - b};
                for (std::size_t i = 0, n = 0; i <= D; ++i)
                    shares.push_back(i == opposite ? 0.0 : parts[n++] / double(steps));
                samples.push_back(combine(shares, corners));
            }
        }
    }
    for (int n = 0; n < 20; ++n) {
        auto shares = random_shares(D + 1, random);
        if (n % 4 != 0) { // outside, next to faces, edges and vertices
            double sum = 0;
            for (double& s : shares) sum += s += random.uniform(-1, 1);
            for (double& s : shares) s += (1 - sum) / double(D + 1);
        }
        const auto p = mix(corners, shares);
        std::vector<T> row(D + 1, T(42));
        const auto q = coordinates.nearest_boundary(p, row);
        double nearest = 1e9 * size;
        for (const auto& sample : samples) nearest = std::min(nearest, distance(p, sample));
        CAPTURE(n, text(shares), text(row), nearest);
        CHECK(distance(p, q) <= nearest + rounding);
        CHECK(distance(p, q) >= nearest - 1.5 * size / steps); // some sample is that near
        CHECK(distance(combine(row, corners), q) <= rounding);
        CHECK(std::fabs(double(sum_of(row) - 1)) <= 4 * double(epsilon<T>));
        CHECK(*std::min_element(row.begin(), row.end()) >= -4 * epsilon<T>);
        CHECK(*std::min_element(row.begin(), row.end()) <= 4 * epsilon<T>); // on the boundary
    }
}

TEST_CASE("the boundary of a segment is its ends, nearest in four dimensions too",
          "[coordinates][barycentric][nearest]") {
    const BarycentricCoordinates<float, 1> segment(std::vector<Vec<float, 1>>{{1}, {3}});
    std::array<float, 2> row{};
    CHECK(segment.nearest_boundary({-5}, row) == Vec<float, 1>{1});
    CHECK(row == std::array<float, 2>{1, 0});
    CHECK(segment.nearest_boundary({2.5f}, row) == Vec<float, 1>{3});
    CHECK(row == std::array<float, 2>{0, 1});

    using T = double;
    const std::vector<Vec<T, 4>> corners{
        {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    const BarycentricCoordinates<T, 4> simplex(corners);
    std::array<T, 5> shares{};
    const auto q = simplex.nearest_boundary({1, 1, 1, 1}, shares); // the middle of the slanted face
    CHECK(distance(q, Vec<T, 4>{T(0.25), T(0.25), T(0.25), T(0.25)}) <= 4 * double(epsilon<T>));
    CHECK(distance(simplex.nearest_boundary({T(0.5), T(0.25), -1, T(-0.5)}, shares),
                   Vec<T, 4>{T(0.5), T(0.25), 0, 0}) <= 4 * double(epsilon<T>));
    CHECK(shares[4] == T(0));
}

TEMPLATE_TEST_CASE("barycentric coordinates at the ends of the scalar's range",
                   "[coordinates][barycentric][scale]", (In<double, 2>), (In<float, 3>)) {
    using T = typename TestType::scalar;
    constexpr std::size_t D = TestType::dimension;
    const auto seed = GENERATE(seeds(effort(10, 2)));
    const double scale = sizeof(T) == 4 ? GENERATE(1e-15, 1e15) : GENERATE(1e-150, 1e150);
    CAPTURE(seed, scale, D);
    Random random(std::uint64_t(seed) + 500);
    auto corners = random_simplex<T, D>(std::uint64_t(seed));
    const double unit = size_of(corners);
    for (auto& c : corners) c = cageform::vec_cast<T>((scale / unit) * cageform::vec_cast<double>(c));
    const BarycentricCoordinates<T, D> coordinates(corners);
    REQUIRE(coordinates.cage_report().status == Status::ok);
    for (int i = 0; i < 20; ++i) {
        const auto shares = random_shares(D + 1, random);
        std::vector<T> row(D + 1);
        CHECK(cageform::weights_at(coordinates, mix(corners, shares), row) == PointState::inside);
        CHECK(difference(row, shares) <= 1000 * double(epsilon<T>)); // 4 conditions of less than 250
    }
}

TEST_CASE("barycentric coordinates take a two-dimensional cage like the other types",
          "[coordinates][barycentric]") {
    const std::vector<Vec<double, 2>> triangle{{0, 0}, {4, 0}, {0, 2}};
    const cageform::BarycentricCoordinates<double, 2> from_polygon{cageform::Polygon<double>(triangle)};
    const cageform::BarycentricCoordinates<double, 2> from_points(triangle);
    std::array<double, 3> a{}, b{};
    CHECK(cageform::weights_at(from_polygon, Vec<double, 2>{1, 1}, a) == PointState::inside);
    CHECK(cageform::weights_at(from_points, Vec<double, 2>{1, 1}, b) == PointState::inside);
    CHECK(a == b);
    const std::vector<Vec<double, 2>> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const cageform::BarycentricCoordinates<double, 2> of_square{cageform::Polygon<double>(square)};
    CHECK(of_square.cage_report().status == Status::not_a_simplex);
    STATIC_REQUIRE(
        !std::is_constructible_v<cageform::BarycentricCoordinates<double, 3>, cageform::Polygon<double>>);
}

TEST_CASE("barycentric coordinates refuse polygons other than one loop of three",
          "[coordinates][barycentric]") {
    const std::vector<Vec<double, 2>> triangle{{0, 0}, {4, 0}, {0, 2}};
    const std::vector<std::size_t> split{1, 2}, too_many{7};
    const cageform::BarycentricCoordinates<double, 2> two_loops{cageform::Polygon<double>(triangle, split)};
    CHECK(two_loops.cage_report().status == Status::not_a_simplex);
    const cageform::BarycentricCoordinates<double, 2> no_match{cageform::Polygon<double>(triangle, too_many)};
    CHECK(no_match.cage_report().status == Status::loops_do_not_match);
}

TEST_CASE("weights that the scalar cannot hold make a point unreached",
          "[coordinates][barycentric][binding]") {
    const std::vector<Vec<float, 2>> tiny{{0, 0}, {1e-20f, 0}, {0, 1e-20f}};
    const std::vector<Vec<float, 2>> points{{1e20f, 1e20f}, {2e-21f, 2e-21f}};
    const auto [binding, report] = cageform::bind(cageform::BarycentricCoordinates<float, 2>(tiny), points);
    REQUIRE(report.status == Status::ok);
    CHECK(report.unreached == std::vector<std::size_t>{0});
    std::vector<Vec<float, 2>> out(2);
    REQUIRE(cageform::clone(binding, tiny, out) == Status::ok);
    CHECK(out == points);
}

TEST_CASE("a boundary point is found from a point with equal distances", "[coordinates][barycentric]") {
    const std::vector<Vec<double, 2>> triangle{{10, 10}, {14, 10}, {10, 12}};
    const cageform::BarycentricCoordinates<double, 2> coordinates(triangle);
    std::array<double, 3> row{};
    const auto q = coordinates.nearest_boundary({1e160, 11}, row);
    CHECK(sum_of(row) == 1);
    CHECK(distance(q, combine(row, triangle)) == 0);
}

} // namespace barycentric_tests

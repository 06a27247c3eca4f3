#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/larger.hpp"

#include <cageform/cage/detail/loop_sides.hpp>
#include <cageform/cage/polygon.hpp>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace polygon_tests {

using cageform::bounds_of;
using cageform::coincidence_tolerance;
using cageform::epsilon;
using cageform::Polygon;
using cageform::signed_area;
using cageform::Vec;
using cageform::detail::loop_depth;
using cageform_tests::Points2;
using cageform_tests::random_star;

namespace {

using Sizes = std::vector<std::size_t>;
using Edges = std::vector<std::pair<std::size_t, std::size_t>>;

template <class T>
Edges edges_of(const Polygon<T>& polygon) {
    Edges edges;
    polygon.for_each_edge([&](std::size_t i, std::size_t j) { edges.emplace_back(i, j); });
    return edges;
}

/// A square of side 2r around (x, y), counter-clockwise.
template <class T>
void add_square(Points2<T>& points, T x, T y, T r) {
    for (const auto& corner : {Vec<T, 2>{-r, -r}, {r, -r}, {r, r}, {-r, r}})
        points.push_back(Vec<T, 2>{x, y} + corner);
}

} // namespace

TEMPLATE_TEST_CASE("a polygon copies its vertices and closes its loop", "[cage][polygon]", CAGEFORM_SCALARS) {
    Points2<TestType> points{{0, 0}, {3, 0}, {3, 2}, {0, 2}};
    const Polygon<TestType> cage(points);
    points[0] = {9, 9};
    REQUIRE(cage.size() == 4);
    CHECK(cage[0] == Vec<TestType, 2>{0, 0});
    CHECK(cage.vertices()[2] == Vec<TestType, 2>{3, 2});
    REQUIRE(cage.loops().size() == 1);
    CHECK((cage.loops()[0].begin == 0 && cage.loops()[0].end == 4));
    CHECK(cage.loops_match());
    CHECK(edges_of(cage) == Edges{{0, 1}, {1, 2}, {2, 3}, {3, 0}});
}

TEMPLATE_TEST_CASE("each loop closes on itself", "[cage][polygon]", CAGEFORM_SCALARS) {
    Points2<TestType> points;
    add_square<TestType>(points, 0, 0, 4);
    add_square<TestType>(points, 0, 0, 1);
    points.pop_back(); // leaves three for the second loop
    const Polygon<TestType> cage(points, Sizes{4, 3});
    REQUIRE(cage.loops().size() == 2);
    CHECK((cage.loops()[1].begin == 4 && cage.loops()[1].end == 7));
    CHECK(edges_of(cage) == Edges{{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 4}});
}

TEST_CASE("loop sizes that do not add up are kept for check", "[cage][polygon]") {
    const Points2<double> points{{0, 0}, {3, 0}, {3, 2}, {0, 2}};
    constexpr std::size_t most = std::numeric_limits<std::size_t>::max();
    CHECK(Polygon<double>(points, Sizes{4}).loops_match());
    CHECK(Polygon<double>(points, Sizes{}).loops_match()); // no sizes: one loop
    CHECK(!Polygon<double>(points, Sizes{3}).loops_match());
    CHECK(!Polygon<double>(points, Sizes{3, 3}).loops_match());
    CHECK(!Polygon<double>(points, Sizes{5}).loops_match());
    CHECK(!Polygon<double>(points, Sizes{5, most}).loops_match()); // 4 again, modulo 2^64
    CHECK(!Polygon<double>(points, Sizes{most, 5}).loops_match());
}

TEST_CASE("the empty polygon", "[cage][polygon]") {
    const Polygon<float> none;
    CHECK((none.size() == 0 && none.loops().empty() && none.loops_match()));
    CHECK(edges_of(none).empty());
    const Polygon<float> no_points(Points2<float>{});
    CHECK(edges_of(no_points).empty());
}

TEST_CASE("a polygon deduces its scalar and converts to another", "[cage][polygon]") {
    const std::array<std::array<float, 2>, 3> points{{{0, 0}, {0.1f, 0}, {0, 1}}};
    const double raw[3][2] = {{0, 0}, {0.1, 0}, {0, 1}};
    STATIC_REQUIRE(std::is_same_v<decltype(Polygon(points)), Polygon<float>>);
    STATIC_REQUIRE(std::is_same_v<decltype(Polygon(raw)), Polygon<double>>);
    STATIC_REQUIRE(std::is_same_v<decltype(Polygon(raw, Sizes{3})), Polygon<double>>);
    CHECK(Polygon<double>(points)[1] == Vec<double, 2>{double(0.1f), 0});
    CHECK(Polygon<float>(raw)[1] == Vec<float, 2>{0.1f, 0});
    STATIC_REQUIRE(!std::is_constructible_v<Polygon<double>, std::vector<Vec<double, 3>>>);
    STATIC_REQUIRE(!std::is_convertible_v<Points2<double>, Polygon<double>>);
}

TEMPLATE_TEST_CASE("bounds are tight", "[cage][polygon][property]", CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(30));
    CAPTURE(seed);
    const auto points = random_star<TestType>(std::uint64_t(seed));
    const auto bounds = bounds_of(std::span<const Vec<TestType, 2>>(points));
    TestType largest = 0;
    for (std::size_t k = 0; k < 2; ++k) {
        bool lower = false;
        bool upper = false;
        for (const auto& p : points) {
            CHECK((bounds.lower[k] <= p[k] && p[k] <= bounds.upper[k]));
            lower = lower || p[k] == bounds.lower[k];
            upper = upper || p[k] == bounds.upper[k];
            largest = cageform_tests::larger(largest, std::fabs(p[k]));
        }
        CHECK((lower && upper));
    }
    CHECK(bounds.magnitude() == largest);
    const auto d = bounds.upper - bounds.lower;
    CHECK(std::fabs(bounds.diagonal() - std::hypot(d[0], d[1])) <= 4 * epsilon<TestType> * bounds.diagonal());
    const TestType tolerance = coincidence_tolerance(bounds);
    CHECK(tolerance >= 8 * epsilon<TestType> * bounds.diagonal());
    CHECK(tolerance >= 8 * epsilon<TestType> * largest);
    CHECK(tolerance <= 8 * epsilon<TestType> * (bounds.diagonal() + largest));
}

TEST_CASE("the bounds of no points are empty", "[cage][polygon]") {
    const auto bounds = bounds_of(std::span<const Vec<double, 3>>());
    for (std::size_t k = 0; k < 3; ++k) CHECK(bounds.lower[k] > bounds.upper[k]);
}

TEST_CASE("the diagonal of a float cage does not overflow before its coordinates", "[cage][polygon]") {
    const Points2<float> far{{0, 0}, {3e37f, 0}, {3e37f, 4e37f}};
    const auto bounds = bounds_of(std::span<const Vec<float, 2>>(far));
    CHECK(std::fabs(bounds.diagonal() - 5e37f) <= 4 * epsilon<float> * 5e37f);
    const Points2<float> tiny{{0, 0}, {3e-30f, 0}, {3e-30f, 4e-30f}};
    const auto small = bounds_of(std::span<const Vec<float, 2>>(tiny));
    CHECK(std::fabs(small.diagonal() - 5e-30f) <= 4 * epsilon<float> * 5e-30f);
}

TEMPLATE_TEST_CASE("the signed area agrees with the shoelace formula", "[cage][polygon][property]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    auto points = random_star<TestType>(std::uint64_t(seed));
    const Polygon<TestType> cage(points);
    const double area = signed_area(cage, cage.loops()[0]);
    CHECK((area > 0) == (seed % 2 == 0)); // random_star is clockwise for odd seeds

    double shoelaces = 0;
    cage.for_each_edge([&](std::size_t i, std::size_t j) {
        shoelaces += 0.5 * cross(cageform::vec_cast<double>(cage[i]), cageform::vec_cast<double>(cage[j]));
    });
    const double size = bounds_of(cage.vertices()).magnitude();
    const double rounding = 4 * double(points.size()) * epsilon<double> * size * size;
    CHECK(std::fabs(area - shoelaces) <= rounding);

    std::reverse(points.begin(), points.end());
    const Polygon<TestType> reversed(points);
    CHECK(std::fabs(area + signed_area(reversed, reversed.loops()[0])) <= rounding);
}

TEMPLATE_TEST_CASE("loop_depth counts the enclosing loops", "[cage][polygon]", CAGEFORM_SCALARS) {
    // Two nests side by side, with their loops in no order: (0, 0) has squares of 8, 4 and 1; (20, 0) has
    // squares of 6 and 2.
    Points2<TestType> points;
    add_square<TestType>(points, 0, 0, 4);
    add_square<TestType>(points, 20, 0, 2);
    add_square<TestType>(points, 0, 0, 8);
    add_square<TestType>(points, 20, 0, 6);
    add_square<TestType>(points, 0, 0, 1);
    const Polygon<TestType> cage(points, Sizes{4, 4, 4, 4, 4});
    const Sizes expected{1, 1, 0, 0, 2};
    for (std::size_t k = 0; k < 5; ++k) {
        CAPTURE(k);
        CHECK(loop_depth(cage, k) == expected[k]);
        CHECK(signed_area(cage, cage.loops()[k]) > 0);
        CHECK(cageform::detail::inside_is_left(cage, k) == (expected[k] % 2 == 0));
    }
}

} // namespace polygon_tests

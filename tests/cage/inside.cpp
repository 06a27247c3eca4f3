#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/cage/polygon.hpp>

#include <cmath>
#include <numbers>

namespace inside_tests {

using cageform::bounds_of;
using cageform::coincidence_tolerance;
using cageform::epsilon;
using cageform::locate;
using cageform::nearest_on_boundary;
using cageform::nearest_on_edge;
using cageform::PointState;
using cageform::Polygon;
using cageform::Vec;
using cageform::vec_cast;
using cageform_tests::Points2;
using cageform_tests::Random;
using cageform_tests::random_star;

namespace {

using Sizes = std::vector<std::size_t>;

/// Inside by winding numbers: an odd number of loops winds around `p`.
template <class T>
bool inside_by_angles(const Polygon<T>& polygon, const Vec<T, 2>& p) {
    bool inside = false;
    for (const auto& loop : polygon.loops()) {
        double angle = 0;
        for (std::size_t i = loop.begin; i < loop.end; ++i) {
            const std::size_t j = i + 1 < loop.end ? i + 1 : loop.begin;
            const auto u = vec_cast<double>(polygon[i]) - vec_cast<double>(p);
            const auto v = vec_cast<double>(polygon[j]) - vec_cast<double>(p);
            angle += std::atan2(cross(u, v), dot(u, v));
        }
        if (std::lround(angle / (2 * std::numbers::pi)) % 2 != 0) inside = !inside;
    }
    return inside;
}

/// A star with a smaller copy of itself as a hole, and a still smaller copy in it as an island.
template <class T>
Polygon<T> random_nest(std::uint64_t seed) {
    const auto star = random_star<double>(seed);
    Vec<double, 2> centre{0, 0};
    for (const auto& p : star) centre = centre + (1.0 / double(star.size())) * p;
    Points2<T> points;
    for (const double size : {1.0, 0.5, 0.2}) {
        for (const auto& p : star) points.push_back(vec_cast<T>(centre + size * (p - centre)));
    }
    return {points, Sizes{star.size(), star.size(), star.size()}};
}

template <class T>
double distance(const Vec<T, 2>& a, const Vec<T, 2>& b) {
    return std::hypot(double(a[0]) - double(b[0]), double(a[1]) - double(b[1]));
}

template <class T>
T tolerance_of(const Polygon<T>& polygon) {
    return coincidence_tolerance(bounds_of(polygon.vertices()));
}

} // namespace

TEMPLATE_TEST_CASE("locate agrees with winding numbers", "[cage][inside][property]", CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(60));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    for (const auto& cage : {Polygon<TestType>(random_star<TestType>(std::uint64_t(seed))),
                             random_nest<TestType>(std::uint64_t(seed))}) {
        const auto bounds = bounds_of(cage.vertices());
        const double margin = 0.2 * bounds.diagonal();
        std::size_t inside = 0;
        std::size_t outside = 0;
        for (int n = 0; n < 200; ++n) {
            const Vec<TestType, 2> p{
                TestType(random.uniform(bounds.lower[0] - margin, bounds.upper[0] + margin)),
                TestType(random.uniform(bounds.lower[1] - margin, bounds.upper[1] + margin))};
            if (nearest_on_boundary(cage, p).distance <= 2 * tolerance_of(cage)) continue;
            const bool expected = inside_by_angles(cage, p);
            CAPTURE(p[0], p[1]);
            CHECK(locate(cage, p, tolerance_of(cage)) ==
                  (expected ? PointState::inside : PointState::outside));
            CHECK(locate(cage, p, TestType(0)) == (expected ? PointState::inside : PointState::outside));
            ++(expected ? inside : outside);
        }
        CHECK(outside > 20);
        if (cage.loops().size() == 1) CHECK(inside > 0);
    }
}

TEMPLATE_TEST_CASE("locate: rays through vertices and along edges", "[cage][inside]", CAGEFORM_SCALARS) {
    // Whole and half steps meet the height of every vertex and run along the horizontal edges.
    const Points2<TestType> points{{0, 0}, {2, 0}, {2, 1}, {3, 1}, {4, 0}, {5, 2}, {6, 0}, {7, 0}, {7, 4},
                                   {5, 4}, {4, 3}, {3, 4}, {2, 2}, {1, 2}, {1, 4}, {0, 4}, // the outer loop
                                   {5, 3}, {6, 3}, {6, 2}};
    const Polygon<TestType> cage(points, Sizes{16, 3});
    REQUIRE(check(cage).status == cageform::Status::ok);
    for (int x = -2; x <= 16; ++x) {
        for (int y = -2; y <= 10; ++y) {
            const Vec<TestType, 2> p{TestType(x) / 2, TestType(y) / 2};
            CAPTURE(p[0], p[1]);
            const bool touches = nearest_on_boundary(cage, p).distance == 0;
            const auto expected = touches                     ? PointState::on_boundary
                                  : inside_by_angles(cage, p) ? PointState::inside
                                                              : PointState::outside;
            CHECK(locate(cage, p, tolerance_of(cage)) == expected);
            CHECK(locate(cage, p, TestType(0)) == expected); // all numbers here are exact
        }
    }
}

TEMPLATE_TEST_CASE("points on vertices and edges are on the boundary", "[cage][inside][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(60));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto cage = random_nest<T>(std::uint64_t(seed));
    const T tolerance = tolerance_of(cage);
    cage.for_each_edge([&](std::size_t i, std::size_t j) {
        CAPTURE(i);
        CHECK(locate(cage, cage[i], tolerance) == PointState::on_boundary);
        CHECK(locate(cage, cage[i], T(0)) == PointState::on_boundary);
        const T s = T(random.uniform(0, 1));
        const auto on_edge = (T(1) - s) * cage[i] + s * cage[j];
        CHECK(locate(cage, on_edge, tolerance) == PointState::on_boundary);

        // A point four tolerances to either side of the edge's middle is off the edge, and inside on at
        // least one side. Edges with another edge as near are skipped.
        const auto e = cage[j] - cage[i];
        const T length = std::hypot(e[0], e[1]);
        const auto middle = T(0.5) * (cage[i] + cage[j]);
        const auto step = (4 * tolerance / length) * Vec<T, 2>{-e[1], e[0]};
        for (const auto& p : {middle + step, middle - step}) {
            if (nearest_on_boundary(cage, p).distance <= 2 * tolerance) continue;
            CHECK(locate(cage, p, tolerance) ==
                  (inside_by_angles(cage, p) ? PointState::inside : PointState::outside));
        }
    });
}

TEMPLATE_TEST_CASE("far points are outside", "[cage][inside]", CAGEFORM_SCALARS) {
    using T = TestType;
    using limits = std::numeric_limits<T>;
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    const Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
    const T tolerance = tolerance_of(cage);
    for (const T far : {T(1e6), T(1e12), T(1e30), limits::max() / 4, limits::max()}) {
        for (const T x : {-far, T(0), far}) {
            for (const T y : {-far, T(0), far}) {
                if (x == 0 && y == 0) continue;
                CAPTURE(x, y);
                CHECK(locate(cage, Vec<T, 2>{x, y}, tolerance) == PointState::outside);
            }
        }
        // At the exact height of each vertex.
        for (const auto& p : cage.vertices()) {
            CHECK(locate(cage, Vec<T, 2>{far, p[1]}, tolerance) == PointState::outside);
            CHECK(locate(cage, Vec<T, 2>{-far, p[1]}, tolerance) == PointState::outside);
            CHECK(locate(cage, Vec<T, 2>{p[0], far}, tolerance) == PointState::outside);
        }
    }
}

TEMPLATE_TEST_CASE("points that are not finite are not_finite", "[cage][inside]", CAGEFORM_SCALARS) {
    using limits = std::numeric_limits<TestType>;
    const Polygon<TestType> cage(Points2<TestType>{{0, 0}, {1, 0}, {0, 1}});
    for (const TestType x : {limits::quiet_NaN(), limits::infinity(), -limits::infinity()}) {
        for (std::size_t axis = 0; axis < 2; ++axis) {
            Vec<TestType, 2> p{TestType(0.25), TestType(0.25)};
            REQUIRE(locate(cage, p, tolerance_of(cage)) == PointState::inside);
            p[axis] = x;
            CHECK(locate(cage, p, tolerance_of(cage)) == PointState::not_finite);
        }
    }
}

TEMPLATE_TEST_CASE("nearest_on_edge is nearer than any other point of the edge", "[cage][inside][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(100));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
    const auto bounds = bounds_of(cage.vertices());
    const double size = std::fmax(bounds.diagonal(), bounds.magnitude());
    const double rounding = 4 * double(epsilon<T>) * size;
    const std::size_t i = random.below(cage.size());
    const std::size_t j = (i + 1) % cage.size();
    for (int n = 0; n < 20; ++n) {
        const Vec<T, 2> p{cage[i][0] + T(random.uniform(-0.5, 0.5) * bounds.diagonal()),
                          cage[i][1] + T(random.uniform(-0.5, 0.5) * bounds.diagonal())};
        const auto place = nearest_on_edge(cage, i, j, p);
        CHECK((place.i == i && place.j == j));
        CHECK((place.s >= 0 && place.s <= 1));
        const auto by_s = (T(1) - place.s) * cage[i] + place.s * cage[j];
        CHECK(distance(by_s, place.position) <= rounding);
        CHECK(std::fabs(distance(p, place.position) - double(place.distance)) <= rounding);
        for (double s = 0; s <= 1; s += 1.0 / 64) {
            const auto other = (1 - s) * vec_cast<double>(cage[i]) + s * vec_cast<double>(cage[j]);
            CHECK(double(place.distance) <= distance(vec_cast<double>(p), other) + rounding);
        }
    }
}

TEMPLATE_TEST_CASE("nearest_on_edge returns both ends exactly", "[cage][inside][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    const Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
    cage.for_each_edge([&](std::size_t i, std::size_t j) {
        const auto e = cage[j] - cage[i];
        for (const T beyond : {T(0), T(0.5), T(1e6)}) {
            const auto start = nearest_on_edge(cage, i, j, cage[i] - beyond * e);
            CHECK((start.s == 0 && start.position == cage[i]));
            const auto end = nearest_on_edge(cage, i, j, cage[j] + beyond * e);
            CHECK((end.s == 1 && end.position == cage[j]));
            if (beyond == 0) CHECK((start.distance == 0 && end.distance == 0));
        }
    });
}

TEMPLATE_TEST_CASE("nearest_on_boundary is the nearest of all edges", "[cage][inside][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto cage = random_nest<T>(std::uint64_t(seed));
    const auto bounds = bounds_of(cage.vertices());
    for (int n = 0; n < 20; ++n) {
        const double reach = std::pow(10.0, random.uniform(-1, 6)) * bounds.diagonal();
        const Vec<T, 2> p{T(random.uniform(-reach, reach)), T(random.uniform(-reach, reach))};
        const auto nearest = nearest_on_boundary(cage, p);
        bool found = false;
        cage.for_each_edge([&](std::size_t i, std::size_t j) {
            const auto place = nearest_on_edge(cage, i, j, p);
            CHECK(nearest.distance <= place.distance);
            found = found || (nearest.i == i && nearest.j == j && nearest.distance == place.distance &&
                              nearest.s == place.s && nearest.position == place.position);
        });
        CHECK(found);
    }
}

TEMPLATE_TEST_CASE("nearest_on_boundary returns a boundary point for the farthest points", "[cage][inside]",
                   CAGEFORM_SCALARS) {
    // The distance overflows; the point must still be on the boundary.
    using limits = std::numeric_limits<TestType>;
    const Polygon<TestType> cage(Points2<TestType>{{10, 10}, {12, 10}, {10, 13}});
    for (const int x : {-1, 1}) {
        for (const int y : {-1, 1}) {
            const Vec<TestType, 2> p{TestType(x) * limits::max(), TestType(y) * limits::max()};
            const auto place = nearest_on_boundary(cage, p);
            CAPTURE(x, y, place.i, place.j, place.s);
            CHECK(place.i != place.j);
            CHECK((place.s >= 0 && place.s <= 1));
            CHECK(locate(cage, place.position, tolerance_of(cage)) == PointState::on_boundary);
        }
    }
}

} // namespace inside_tests

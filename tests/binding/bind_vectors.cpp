// Vectors bound to points: linear precision, differences of clones, and points without
// weights.
#include "../catch.hpp"
#include "../support/bindings.hpp"
#include "../support/figures.hpp"
#include "../support/uniform_harmonic.hpp"
#include "../support/weights.hpp"

#include <cageform/binding/any_coordinates.hpp>
#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/parallel/threads.hpp>

#include <cstring>

namespace bind_vectors_tests {

using namespace cageform_tests;
using cageform::bind_jacobians;
using cageform::bind_vectors;
using cageform::epsilon;
using cageform::OutsidePoints;
using cageform::Polygon;

namespace {

template <class T, std::size_t D>
using Bary = cageform::BarycentricCoordinates<T, D>;
template <class T, std::size_t D>
using Mean = cageform::MeanValueCoordinates<T, D>;
template <class T>
using Harmonic = cageform_tests::UniformHarmonic<T, 2>;

/// A coordinate type of a random cage, and points inside and on it.
template <class C>
C random_coordinates(std::uint64_t seed) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    if constexpr (std::is_same_v<C, Bary<T, D>>) {
        return C(random_simplex<T, D>(seed));
    } else if constexpr (D == 2) {
        return C(Polygon<T>(random_star<T>(seed)));
    } else {
        return C(random_mesh(seed).mesh<T>());
    }
}
template <class C>
std::vector<Vec<typename C::scalar, C::dimension>> points_within(const C& coordinates, std::uint64_t seed) {
    using T = typename C::scalar;
    constexpr std::size_t D = C::dimension;
    Random random(seed + 5);
    std::vector<Vec<T, D>> points{coordinates.handles()[0]};
    if constexpr (std::is_same_v<C, Bary<T, D>>) {
        for (int n = 0; n < 50; ++n)
            points.push_back(vec_cast<T>(combine(random_shares(D + 1, random), coordinates.handles())));
    } else if constexpr (D == 2) {
        for (int n = 0; n < 50; ++n) points.push_back(random_inside(coordinates.cage(), random, 1e-4));
    } else {
        const auto more = points_in(coordinates.cage(), 49, seed + 5);
        points.insert(points.end(), more.begin(), more.end());
    }
    return points;
}

template <class T, std::size_t D>
bool same_bits(const Vec<T, D>& a, const Vec<T, D>& b) {
    return std::memcmp(&a, &b, sizeof(a)) == 0;
}

} // namespace

TEMPLATE_TEST_CASE("an affine pose transforms every bound vector by its linear part",
                   "[binding][vectors][affine]", (Bary<float, 1>), (Bary<double, 2>), (Bary<float, 3>),
                   (Mean<float, 2>), (Mean<double, 2>), (Mean<float, 3>), (Mean<double, 3>),
                   (Harmonic<float>), (Harmonic<double>)) {
    using T = typename TestType::scalar;
    constexpr std::size_t D = TestType::dimension;
    const auto seed = std::uint64_t(GENERATE(seeds(6)));
    CAPTURE(seed);
    const auto coordinates = random_coordinates<TestType>(seed);
    auto points = points_within(coordinates, seed);
    // The grid does not resolve sharp corners.
    if constexpr (std::is_same_v<TestType, Harmonic<T>>) points.front() = points.back();
    // The error is relative to the length of the vector and to the terms of the weights.
    const double length = seed % 2 == 0 ? 1 : 1e-4;
    const auto vectors = random_points<T, D>(points.size(), length, seed + 1);
    const auto [binding, report] = bind_vectors(coordinates, points, vectors);
    REQUIRE(report.status == Status::ok);
    REQUIRE(report.unreached.empty());
    CHECK(report.on_boundary.size() == (std::is_same_v<TestType, Harmonic<T>> ? 0 : 1));
    CHECK(report.points == points.size());
    Random random(seed + 2);
    const auto handles = coordinates.handles();
    const double size = size_of(handles);
    for (int n = 0; n < 4; ++n) {
        auto map = random_affine<D>(random, size);
        const auto pose = map(handles);
        const auto moved = cloned(binding, pose);
        map.shift = {};
        for (std::size_t i = 0; i < points.size(); ++i) {
            double gross = length; // Σ |w| times the size, the scale of rounding
            for (std::size_t h = 0; h < handles.size(); ++h)
                gross += size * std::fabs(double(binding.weight(i, h)));
            CAPTURE(n, i);
            CHECK(distance(moved[i], map(vec_cast<long double>(vectors[i]))) <=
                  64 * double(epsilon<T>) * gross);
        }
    }
    // The report has the residuals of Σw = 0 and Σwc = t.
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::vector<T> row;
        for (std::size_t h = 0; h < handles.size(); ++h) row.push_back(binding.weight(i, h));
        CHECK(std::fabs(double(sum_of(row))) <=
              report.partition_error.value + 8 * double(epsilon<T>) * absolute_sum(row));
        CHECK(distance(combine(row, handles), vectors[i]) <=
              report.reproduction_error.value +
                  64 * double(epsilon<T>) * (length + size * absolute_sum(row)));
    }
}

TEMPLATE_TEST_CASE("the rest pose gives the bound vectors bit for bit", "[binding][vectors][rest]",
                   (Bary<float, 1>), (Mean<double, 2>), (Mean<float, 3>), (Harmonic<double>)) {
    using T = typename TestType::scalar;
    constexpr std::size_t D = TestType::dimension;
    const auto policy =
        GENERATE(OutsidePoints::extend, OutsidePoints::keep_in_place, OutsidePoints::nearest_boundary);
    const auto coordinates = random_coordinates<TestType>(2);
    auto points = points_within(coordinates, 2);
    points.push_back(points[0]);
    for (std::size_t k = 0; k < D; ++k) points.back()[k] += T(2 * size_of(coordinates.handles()));
    points.push_back(points[0]);
    points.back()[0] = std::numeric_limits<T>::quiet_NaN();
    auto vectors = random_points<T, D>(points.size(), 1, 3);
    vectors[1][0] = -T(0);
    vectors[2] = {};
    vectors[3][D - 1] = std::numeric_limits<T>::infinity();
    const auto [binding, report] = bind_vectors(coordinates, points, vectors, {.outside = policy});
    REQUIRE(report.status == Status::ok);
    CHECK(report.not_finite == std::vector<std::size_t>{3, points.size() - 1});
    CHECK(report.outside == std::vector<std::size_t>{points.size() - 2});
    CHECK(report.unreached.empty());
    const auto at_rest = cloned(binding, coordinates.handles());
    for (std::size_t i = 0; i < points.size(); ++i) CHECK(same_bits(at_rest[i], vectors[i]));
    // Points kept in place do not move in any pose.
    const auto moved = cloned(binding, shaken(coordinates.handles(), size_of(coordinates.handles()), 4));
    CHECK(same_bits(moved[3], vectors[3]));
    CHECK(same_bits(moved[2], vectors[2]));
    CHECK(same_bits(moved.back(), vectors.back()));
    const bool kept = policy == OutsidePoints::keep_in_place ||
                      (policy == OutsidePoints::extend && !TestType::has_extension);
    CHECK(same_bits(moved[points.size() - 2], vectors[points.size() - 2]) == kept);
}

TEST_CASE("bound vectors equal differences of clones", "[binding][vectors][differences]") {
    const auto seed = std::uint64_t(GENERATE(seeds(8)));
    CAPTURE(seed);
    const auto check = [&](const auto& coordinates) {
        using C = std::decay_t<decltype(coordinates)>;
        constexpr std::size_t D = C::dimension;
        const auto handles = coordinates.handles();
        const double size = bounds_of(handles).diagonal(), step = 1e-5 * size;
        auto points = points_within(coordinates, seed);
        points.erase(points.begin());
        const auto vectors = random_points<double, D>(points.size(), 1, seed);
        const auto pose = shaken(handles, 0.2 * size, seed);
        const auto moved = cloned(bind_vectors(coordinates, points, vectors).value, pose);
        std::vector<Vec<double, D>> ahead, behind;
        for (std::size_t i = 0; i < points.size(); ++i) {
            ahead.push_back(points[i] + step * vectors[i]);
            behind.push_back(points[i] - step * vectors[i]);
        }
        const auto a = cloned(cageform::bind(coordinates, ahead).value, pose);
        const auto b = cloned(cageform::bind(coordinates, behind).value, pose);
        for (std::size_t i = 0; i < points.size(); ++i) {
            Vec<double, D> place;
            (void)nearest_boundary_value(coordinates.cage(), points[i], place);
            if (distance(place, points[i]) < 0.01 * size) continue; // third derivatives are large
            CAPTURE(i);
            CHECK(distance(moved[i], (0.5 / step) * (a[i] - b[i])) <= 1e-5);
        }
    };
    check(random_coordinates<Mean<double, 2>>(seed));
    check(random_coordinates<Mean<double, 3>>(seed));
}

TEST_CASE("one vector for all points, and columns of Jacobians, equal those of ranges",
          "[binding][vectors]") {
    const auto coordinates = random_coordinates<Mean<float, 3>>(6);
    const auto points = points_within(coordinates, 6);
    const auto pose = shaken(coordinates.handles(), size_of(coordinates.handles()), 7);
    const auto jacobians = bind_jacobians(coordinates, points);
    REQUIRE(jacobians.report.status == Status::ok);
    for (std::size_t k = 0; k < 3; ++k) {
        Vec<float, 3> axis{};
        axis[k] = 1;
        const std::array<double, 3> of_another_type{axis[0], axis[1], axis[2]};
        const auto expected = cloned(
            bind_vectors(coordinates, points, std::vector<Vec<float, 3>>(points.size(), axis)).value, pose);
        CHECK(cloned(bind_vectors(coordinates, points, axis).value, pose) == expected);
        CHECK(cloned(bind_vectors(coordinates, points, of_another_type).value, pose) == expected);
        CHECK(cloned(jacobians.value[k], pose) == expected);
    }
    CHECK(jacobians.report.on_boundary == std::vector<std::size_t>{0});
}

TEMPLATE_TEST_CASE("vectors with nearest_boundary transform as at the boundary point",
                   "[binding][vectors][outside]", (Mean<double, 2>), (Mean<double, 3>), (Harmonic<double>)) {
    constexpr std::size_t D = TestType::dimension;
    const auto coordinates = random_coordinates<TestType>(5);
    const auto handles = coordinates.handles();
    const double size = bounds_of(handles).diagonal();
    std::vector<Vec<double, D>> outside, nearest;
    Random random(9);
    std::vector<double> row(handles.size());
    for (int n = 0; n < 20; ++n) {
        auto p = handles[std::size_t(n) % handles.size()];
        for (std::size_t k = 0; k < D; ++k) p[k] += size * random.uniform(1, 2);
        outside.push_back(p);
        nearest.push_back(coordinates.nearest_boundary(p, row));
    }
    const auto vectors = random_points<double, D>(outside.size(), 1, 9);
    const auto [binding, report] =
        bind_vectors(coordinates, outside, vectors, {.outside = OutsidePoints::nearest_boundary});
    REQUIRE(report.status == Status::ok);
    // The grid does not resolve sharp corners.
    CHECK(report.outside.size() + report.unreached.size() == outside.size());
    CHECK(report.outside.size() >= (TestType::has_extension ? outside.size() : outside.size() / 4));
    const auto pose = shaken(handles, 0.1 * size, 10);
    const auto expected = cloned(bind_vectors(coordinates, nearest, vectors).value, pose);
    const auto moved = cloned(binding, pose);
    for (std::size_t i = 0; i < outside.size(); ++i) CHECK(distance(moved[i], expected[i]) <= 1e-12);
}

TEST_CASE("AnyCoordinates bind vectors as the contained type", "[binding][vectors]") {
    const auto coordinates = random_coordinates<Mean<double, 3>>(8);
    const auto points = points_within(coordinates, 8);
    const std::array families{Points3<double>(points.size(), Vec<double, 3>{1, -2, 0.5}), points};
    const cageform::AnyCoordinates<double, 3> any(coordinates);
    const auto [bound, report] = bind_vectors(any, points, families);
    const auto [expected, expected_report] = bind_vectors(coordinates, points, families);
    REQUIRE(report.status == Status::ok);
    const auto pose = shaken(coordinates.handles(), 0.1, 8);
    for (std::size_t n = 0; n < 2; ++n) CHECK(cloned(bound[n], pose) == cloned(expected[n], pose));

    const cageform::AnyCoordinates<double, 3> none;
    CHECK(bind_vectors(none, points, families).report.status == Status::coordinates_empty);
    const cageform::AnyCoordinates<double, 3> box(
        Mean<double, 3>(divided_box({2, 2, 2}, 1.0).mesh<double>()));
    for (const double far : {1e-13, 0.25, 7.0}) // across a face of the box from -1 to 1
        CHECK(std::fabs(box.distance_from_boundary({1 + far, 0.2, -0.3}) - far) <= 1e-15 * (1 + far));
}

TEST_CASE("bind_vectors returns a status for invalid input", "[binding][vectors][status]") {
    const Points2<double> points{{0.2, 0.2}};
    const Polygon<double> crossing(Points2<double>{{0, 0}, {1, 1}, {1, 0}, {0, 1}});
    const auto refused = bind_vectors(Mean<double, 2>(crossing), points, Vec<double, 2>{1, 0});
    CHECK(refused.report.status == Status::cage_self_crossing);
    CHECK(refused.value.point_count() == 0);

    const auto coordinates = random_coordinates<Mean<double, 3>>(6);
    const auto many = points_within(coordinates, 6);
    const auto cancelled = bind_vectors(coordinates, many, Vec<double, 3>{1, 0, 0}, {},
                                        {.progress = [](double) { return false; }});
    CHECK(cancelled.report.status == Status::cancelled);
    CHECK(cancelled.value.point_count() == 0);

    const auto none = bind_vectors(coordinates, Points3<double>{}, Vec<double, 3>{1, 0, 0});
    CHECK(none.report.status == Status::ok);
    CHECK(none.value.point_count() == 0);
    CHECK(none.value.handle_count() == coordinates.handles().size());

    // A vector so long that its weights overflow.
    const auto flat = random_coordinates<Mean<float, 2>>(2);
    const auto inside = points_within(flat, 2);
    const auto long_ones =
        bind_vectors(flat, inside, Vec<float, 2>{std::numeric_limits<float>::max(), 0}).report;
    CHECK(long_ones.status == Status::ok);
    CHECK(long_ones.unreached.size() + long_ones.not_finite.size() <= inside.size());
}

TEST_CASE("bound vectors do not depend on threads and pieces", "[binding][vectors][threads]") {
    const auto coordinates = random_coordinates<Mean<double, 2>>(6);
    Random random(3);
    Points2<double> points;
    for (int n = 0; n < 5000; ++n) points.push_back(random_inside(coordinates.cage(), random, 0));
    const auto vectors = random_points<double, 2>(points.size(), 1, 1);
    const auto pose = shaken(coordinates.handles(), 1, 2);
    const auto all = bind_vectors(coordinates, points, vectors).value;
    const auto expected = cloned(all, pose);
    double last = 0;
    cageform::Running running{.parallel = cageform::ThreadedFor{3}};
    running.progress = [&](double done) {
        CHECK(done >= last);
        last = done;
        return true;
    };
    CHECK(cloned(bind_vectors(coordinates, points, vectors, {}, running).value, pose) == expected);
    CHECK(last == 1);
    for (const std::size_t i : {std::size_t{0}, std::size_t{31}, std::size_t{32}, std::size_t{4999}}) {
        const auto alone =
            bind_vectors(coordinates, Points2<double>{points[i]}, Points2<double>{vectors[i]}).value;
        for (std::size_t h = 0; h < alone.handle_count(); ++h) CHECK(alone.weight(0, h) == all.weight(i, h));
    }
}

TEST_CASE("families of vectors are bound independently", "[binding][vectors]") {
    const auto coordinates = random_coordinates<Mean<float, 3>>(3);
    const auto points = points_within(coordinates, 3);
    const auto pose = shaken(coordinates.handles(), 1, 2);
    auto vectors = cageform::tangents_of(random_points<float, 3>(points.size(), 1, 4));
    vectors[1][7] = {}; // of a point without a normal
    const auto [bindings, report] = bind_vectors(coordinates, points, vectors);
    REQUIRE(report.status == Status::ok);
    for (std::size_t n = 0; n < 2; ++n) {
        const auto alone = bind_vectors(coordinates, points, vectors[n]);
        CHECK(cloned(bindings[n], pose) == cloned(alone.value, pose));
        CHECK(alone.report.reproduction_error.value <= report.reproduction_error.value);
    }
    vectors[1][9][2] = std::numeric_limits<float>::quiet_NaN();
    const auto kept = bind_vectors(coordinates, points, vectors); // all vectors of a point or none
    CHECK(kept.report.not_finite == std::vector<std::size_t>{9});
    CHECK(same_bits(cloned(kept.value[0], pose)[9], vectors[0][9]));
}

TEMPLATE_TEST_CASE("tangents of normals are orthonormal to them", "[binding][vectors][tangents]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    Random random(1);
    Points3<T> normals{{0, 0, 1}, {0, 0, -1},       {0, 0, T(-0.0)},
                       {1, 0, 0}, {0, T(1e-30), 0}, {T(1e30), 0, T(1e30)}};
    for (int n = 0; n < 100; ++n)
        normals.push_back({T(random.uniform(-1, 1)), T(random.uniform(-1, 1)), T(random.uniform(-1, 1))});
    const auto given = random_points<T, 3>(normals.size(), 1, 2);
    const auto check = [&](const std::array<Points3<T>, 2>& frames) {
        const auto& [tangents, bitangents] = frames;
        REQUIRE(tangents.size() == normals.size());
        for (std::size_t i = 0; i < normals.size(); ++i) {
            CAPTURE(i);
            if (i == 2) { // no normal
                CHECK(tangents[i] == Vec<T, 3>{});
                CHECK(bitangents[i] == Vec<T, 3>{});
                continue;
            }
            const auto n = vec_cast<long double>(normals[i]), t = vec_cast<long double>(tangents[i]),
                       b = vec_cast<long double>(bitangents[i]);
            CHECK(distance(cross(t, b), (1 / std::sqrt(dot(n, n))) * n) <= 8 * double(epsilon<T>));
            CHECK(std::fabs(double(dot(t, t)) - 1) <= 8 * double(epsilon<T>));
            CHECK(std::fabs(double(dot(t, b))) <= 8 * double(epsilon<T>));
        }
    };
    check(cageform::tangents_of(normals));
    auto tangents = given;
    tangents[0] = {};
    tangents[3] = {T(2), 0, 0}; // along the normal
    const auto frames = cageform::tangents_of(normals, tangents);
    check(frames);
    for (std::size_t i = 6; i < normals.size(); ++i) CHECK(dot(frames[0][i], given[i]) > 0);

    const T nan = std::numeric_limits<T>::quiet_NaN();
    CHECK(!is_finite(cageform::tangents_of(Points3<T>{{nan, 0, 0}})[0][0]));
    const auto [flat] = cageform::tangents_of(Points2<T>{{0, 2}, {T(-1e-30), 0}, {0, 0}});
    CHECK(flat == Points2<T>{{1, 0}, {0, 1}, {0, 0}});
}

} // namespace bind_vectors_tests

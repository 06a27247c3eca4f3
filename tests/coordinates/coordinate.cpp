// The concept of coordinate types, its helpers, and the laws that all types share.
#include "catch.hpp"
#include "support/effort.hpp"
#include "support/larger.hpp"
#include "support/uniform_harmonic.hpp"
#include "support/weights.hpp"

#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/parallel/detail/in_parallel.hpp>

#include <new>
#include <stdexcept>

namespace coordinate_tests {

using namespace cageform_tests;
using cageform::epsilon;
using cageform::Polygon;

namespace {

template <class T>
using Bary = cageform::BarycentricCoordinates<T, 2>;
template <class T>
using Mean = cageform::MeanValueCoordinates<T, 2>;
template <class T>
using Harmonic = cageform_tests::UniformHarmonic<T, 2>;

template <class C>
inline constexpr bool is_barycentric = false;
template <class T>
inline constexpr bool is_barycentric<Bary<T>> = true;
template <class C>
inline constexpr bool is_harmonic = false;
template <class T>
inline constexpr bool is_harmonic<Harmonic<T>> = true;

/// A cage that the type supports: a triangle for barycentric coordinates, else a star.
template <class C>
Points2<typename C::scalar> random_cage(std::uint64_t seed) {
    using T = typename C::scalar;
    if constexpr (is_barycentric<C>) {
        return random_simplex<T, 2>(seed);
    } else {
        return random_star<T>(seed);
    }
}

/// Coordinates of a cage. Harmonic coordinates use a small grid and converge to double accuracy.
template <class C>
C make(const Polygon<typename C::scalar>& cage) {
    if constexpr (is_harmonic<C>) {
        const double tolerance = sizeof(typename C::scalar) == 4 ? 1e-6 : 1e-12;
        return C(cage, {.resolution = 24, .multigrid = {.tolerance = tolerance}});
    } else {
        return C(cage);
    }
}

/// A minimal model of the concept. Each variant below lacks one part.
struct Minimal {
    using scalar = float;
    static constexpr std::size_t dimension = 3;
    static constexpr bool has_extension = false;
    static constexpr bool closed_form = true;

    std::span<const Vec<float, 3>> handles() const { return {}; }
    const cageform::CageReport& cage_report() const { return report; }
    cageform::Evaluation evaluate(cageform::BlockView<const float>, cageform::BlockView<float>,
                                  std::span<PointState>, const cageform::Running&) const {
        return {};
    }
    Vec<float, 3> nearest_boundary(const Vec<float, 3>& p, std::span<float>) const { return p; }

    cageform::CageReport report;
};
struct IntegerScalar : Minimal {
    using scalar = int;
};
struct NoExtensionStated : Minimal {
private:
    using Minimal::has_extension;
};
struct NoClosedFormStated : Minimal {
private:
    using Minimal::closed_form;
};
struct HandlesByValue : Minimal {
    std::vector<Vec<float, 3>> handles() const { return {}; }
};
struct ReportByValue : Minimal {
    cageform::CageReport cage_report() const { return {}; }
};
struct ReturnsStatusOnly : Minimal {
    Status evaluate(cageform::BlockView<const float>, cageform::BlockView<float>, std::span<PointState>,
                    const cageform::Running&) const {
        return Status::ok;
    }
};
struct EvaluateNotConst : Minimal {
    cageform::Evaluation evaluate(cageform::BlockView<const float>, cageform::BlockView<float>,
                                  std::span<PointState>, const cageform::Running&) {
        return {};
    }
};
struct NearestOfOtherDimension : Minimal {
    Vec<float, 2> nearest_boundary(const Vec<float, 3>&, std::span<float>) const { return {}; }
};

} // namespace

TEST_CASE("the coordinate types model the concept, incomplete types do not", "[coordinates][concept]") {
    using cageform::CageCoordinates;
    STATIC_REQUIRE(CageCoordinates<cageform::MeanValueCoordinates<float, 2>>);
    STATIC_REQUIRE(CageCoordinates<cageform::MeanValueCoordinates<double, 2>>);
    STATIC_REQUIRE(CageCoordinates<cageform::HarmonicCoordinates<float, 2>>);
    STATIC_REQUIRE(CageCoordinates<cageform::HarmonicCoordinates<double, 2>>);
    STATIC_REQUIRE(CageCoordinates<cageform::BarycentricCoordinates<float, 2>>);
    STATIC_REQUIRE(CageCoordinates<cageform::BarycentricCoordinates<double, 3>>);
    STATIC_REQUIRE(CageCoordinates<cageform::BarycentricCoordinates<double, 1>>);
    STATIC_REQUIRE(CageCoordinates<cageform::BarycentricCoordinates<float, 4>>);
    STATIC_REQUIRE(CageCoordinates<Minimal>);
    STATIC_REQUIRE(!CageCoordinates<int>);
    STATIC_REQUIRE(!CageCoordinates<Polygon<double>>);
    STATIC_REQUIRE(!CageCoordinates<IntegerScalar>);
    STATIC_REQUIRE(!CageCoordinates<NoExtensionStated>);
    STATIC_REQUIRE(!CageCoordinates<NoClosedFormStated>);
    STATIC_REQUIRE(!CageCoordinates<HandlesByValue>);
    STATIC_REQUIRE(!CageCoordinates<ReportByValue>);
    STATIC_REQUIRE(!CageCoordinates<ReturnsStatusOnly>);
    STATIC_REQUIRE(!CageCoordinates<EvaluateNotConst>);
    STATIC_REQUIRE(!CageCoordinates<NearestOfOtherDimension>);
}

TEMPLATE_TEST_CASE("weights are the unit row on a vertex", "[coordinates][property]", Bary<float>,
                   Mean<float>, Harmonic<double>) {
    using T = typename TestType::scalar;
    const auto seed = GENERATE(seeds(effort(20, 5)));
    CAPTURE(seed);
    const Polygon<T> cage(random_cage<TestType>(std::uint64_t(seed)));
    const auto coordinates = make<TestType>(cage);
    const auto weights = evaluate_all(coordinates, cage.vertices());
    REQUIRE(weights.status() == Status::ok);
    for (std::size_t i = 0; i < cage.size(); ++i) {
        CAPTURE(i, text(weights.rows[i]));
        std::vector<T> unit(cage.size(), T(0));
        unit[i] = T(1);
        CHECK(weights.states[i] == PointState::on_boundary);
        if constexpr (is_barycentric<TestType>) {
            // Errors of an affine function: rounding of vertices up to 3 diagonals from the origin, divided
            // by heights of a third of a diagonal.
            CHECK(difference(weights.rows[i], unit) <= 32 * double(epsilon<T>));
        } else {
            CHECK(weights.rows[i] == unit);
        }
    }
}

TEMPLATE_TEST_CASE("weights on an edge are linear along it and zero elsewhere", "[coordinates][property]",
                   Bary<double>, Mean<double>, Harmonic<float>) {
    using T = typename TestType::scalar;
    const auto seed = GENERATE(seeds(effort(20, 5)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 100);
    const Polygon<T> cage(random_cage<TestType>(std::uint64_t(seed)));
    const auto coordinates = make<TestType>(cage);
    Points2<T> points;
    std::vector<double> along;
    for (std::size_t edge = 0; edge < cage.size(); ++edge) {
        for (int k = 0; k < 4; ++k) {
            along.push_back(random.uniform(0, 1));
            points.push_back(on_edge(cage, edge, along.back()).position);
        }
    }
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    for (std::size_t n = 0; n < points.size(); ++n) {
        const auto [i, j, position] = on_edge(cage, n / 4, along[n]);
        std::vector<double> expected(cage.size(), 0.0);
        expected[i] = 1 - along[n];
        expected[j] = along[n];
        CAPTURE(i, j, along[n], text(weights.rows[n]));
        CHECK(weights.states[n] == PointState::on_boundary);
        // The position itself is rounded by half an epsilon, relative to the length of this edge.
        const double length = distance(cage[i], cage[j]);
        CHECK(difference(weights.rows[n], expected) <=
              8 * double(epsilon<T>) * size_of(cage.vertices()) / length);
        if constexpr (!is_barycentric<TestType>) {
            CHECK(std::count(weights.rows[n].begin(), weights.rows[n].end(), T(0)) >=
                  std::ptrdiff_t(cage.size() - 2));
        }
        CHECK(std::fabs(double(sum_of(weights.rows[n]) - 1)) <= 4 * double(epsilon<T>));
    }
}

TEMPLATE_TEST_CASE("scaling by a power of two does not change a bit of the weights",
                   "[coordinates][invariance]", Bary<double>, Mean<float>, Harmonic<double>) {
    using T = typename TestType::scalar;
    const auto seed = GENERATE(seeds(effort(12, 3)));
    const int power = GENERATE(-20, -1, 3, 25);
    CAPTURE(seed, power);
    Random random(std::uint64_t(seed) + 200);
    auto vertices = random_cage<TestType>(std::uint64_t(seed));
    const Polygon<T> cage(vertices);
    Points2<T> points;
    for (int i = 0; i < 30; ++i) points.push_back(random_inside(cage, random, 0));
    points.push_back(vertices[0]);
    points.push_back(on_edge(cage, 1, 0.3).position);
    for (int i = 0; i < 10; ++i) points.push_back(T(random.uniform(-300, 300)) * vertices[0]);
    const auto before = evaluate_all(make<TestType>(cage), points);
    const T scale = std::ldexp(T(1), power);
    for (auto& v : vertices) v = scale * v;
    for (auto& p : points) p = scale * p;
    const auto after = evaluate_all(make<TestType>(Polygon<T>(vertices)), points);
    REQUIRE(before.status() == Status::ok);
    REQUIRE(after.status() == Status::ok);
    CHECK(before.states == after.states);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (before.states[i] == PointState::outside && !TestType::has_extension) continue;
        CAPTURE(i, text(before.rows[i]), text(after.rows[i]));
        CHECK(before.rows[i] == after.rows[i]);
    }
}

TEMPLATE_TEST_CASE("weights are invariant to moving, turning, scaling and mirroring",
                   "[coordinates][invariance]", Bary<float>, Mean<double>) {
    using T = typename TestType::scalar;
    const auto seed = GENERATE(seeds(effort(50, 12)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 300);
    const auto vertices = random_cage<TestType>(std::uint64_t(seed));
    const Polygon<T> cage(vertices);
    constexpr double clearance = 0.01;
    Points2<T> points;
    for (int i = 0; i < 30; ++i) points.push_back(random_inside(cage, random, clearance));

    const double angle = random.uniform(0, 6.3), scale = std::pow(10, random.uniform(-2, 2));
    const double side = seed % 3 == 0 ? -1 : 1; // mirrored
    const double diagonal = double(cageform::bounds_of(cage.vertices()).diagonal());
    AffineMap<2> map;
    map.rows = {{{scale * std::cos(angle), -side * scale * std::sin(angle)},
                 {scale * std::sin(angle), side * scale * std::cos(angle)}}};
    for (std::size_t k = 0; k < 2; ++k) map.shift[k] = random.uniform(-2, 2) * scale * diagonal;
    const auto moved_vertices = map(cage.vertices());
    const auto moved_points = map(std::span<const Vec<T, 2>>(points));

    const auto before = evaluate_all(make<TestType>(cage), points);
    const auto after = evaluate_all(make<TestType>(Polygon<T>(moved_vertices)), moved_points);
    REQUIRE(before.status() == Status::ok);
    REQUIRE(after.status() == Status::ok);
    CHECK(before.states == after.states);
    // Positions are rounded by epsilon · size. A weight changes by at most a small multiple of 1 / clearance
    // per diagonal.
    const double rounding =
        double(epsilon<T>) * (size_of(vertices) / diagonal + size_of(moved_vertices) / (scale * diagonal));
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, text(before.rows[i]), text(after.rows[i]));
        CHECK(difference(before.rows[i], after.rows[i]) <= 4 * rounding / clearance);
    }
}

TEMPLATE_TEST_CASE("weights do not depend on the direction and start of a loop", "[coordinates][invariance]",
                   Bary<double>, Mean<float>, Harmonic<double>) {
    using T = typename TestType::scalar;
    const auto seed = GENERATE(seeds(effort(20, 5)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 400);
    const auto vertices = random_cage<TestType>(std::uint64_t(seed));
    const Polygon<T> cage(vertices);
    Points2<T> points;
    for (int i = 0; i < 40; ++i) points.push_back(random_inside(cage, random, 1e-2));
    for (int i = 0; i < 10; ++i) points.push_back(T(random.uniform(-5, 5)) * vertices[0]);
    const auto before = evaluate_all(make<TestType>(cage), points);
    REQUIRE(before.status() == Status::ok);

    const std::size_t count = vertices.size();
    const std::size_t start = 1 + random.below(count - 1);
    for (const bool back : {false, true}) {
        std::vector<std::size_t> order;
        for (std::size_t i = 0; i < count; ++i) order.push_back((start + (back ? count - i : i)) % count);
        Points2<T> renamed;
        for (const std::size_t i : order) renamed.push_back(vertices[i]);
        const auto after = evaluate_all(make<TestType>(Polygon<T>(renamed)), points);
        REQUIRE(after.status() == Status::ok);
        CHECK(before.states == after.states);
        for (std::size_t n = 0; n < points.size(); ++n) {
            if (before.states[n] == PointState::outside && !TestType::has_extension) continue;
            std::vector<T> expected;
            for (const std::size_t i : order) expected.push_back(before.rows[n][i]);
            CAPTURE(back, n, text(expected), text(after.rows[n]));
            if constexpr (is_harmonic<TestType>) {
                // Boundary values differ in their last bits, which can change the number of cycles and leave
                // an error of about 1e-12.
                CHECK(difference(expected, after.rows[n]) <= 1e-8);
            } else {
                // Positions are not rounded again. Only the order of sums and products differs. Outside
                // points are within 15 diagonals.
                CHECK(difference(expected, after.rows[n]) <=
                      128 * double(epsilon<T>) * absolute_sum(expected));
            }
        }
    }
}

TEST_CASE("harmonic weights are invariant to mirroring and right-angle turns",
          "[coordinates][harmonic][invariance]") {
    // Right angles preserve the grid; other angles do not. In float, the cage's extreme vertices lie on grid
    // lines and may fall into other cells.
    const auto seed = GENERATE(seeds(effort(10, 2)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 500);
    const auto vertices = random_star<double>(std::uint64_t(seed));
    const Polygon<double> cage(vertices);
    Points2<double> points;
    for (int i = 0; i < 40; ++i) points.push_back(random_inside(cage, random, 1e-2));
    const auto before = evaluate_all(make<Harmonic<double>>(cage), points);
    REQUIRE(before.status() == Status::ok);
    for (const Vec<double, 4>& m : {Vec<double, 4>{-1, 0, 0, 1}, {0, -1, 1, 0}, {0, 1, 1, 0}}) {
        const AffineMap<2> map{{{{m[0], m[1]}, {m[2], m[3]}}}, {0, 0}};
        const auto after = evaluate_all(make<Harmonic<double>>(Polygon<double>(map(cage.vertices()))),
                                        map(std::span<const Vec<double, 2>>(points)));
        REQUIRE(after.status() == Status::ok);
        CHECK(before.states == after.states);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(i, text(before.rows[i]), text(after.rows[i]));
            CHECK(difference(before.rows[i], after.rows[i]) <= 1e-8); // solver error
        }
    }
}

TEMPLATE_TEST_CASE("in a triangle every type is barycentric", "[coordinates][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(30, 7)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 600);
    const Polygon<T> cage(random_simplex<T, 2>(std::uint64_t(seed)));
    Points2<T> points;
    for (int i = 0; i < 40; ++i) points.push_back(random_inside(cage, random, 1e-2));
    const auto expected = evaluate_all(Bary<T>(cage), points);
    const auto mean = evaluate_all(Mean<T>(cage), points);
    const auto harmonic = evaluate_all(make<Harmonic<T>>(cage), points);
    REQUIRE(expected.status() == Status::ok);
    REQUIRE(mean.status() == Status::ok);
    REQUIRE(harmonic.status() == Status::ok);
    // Barycentric coordinates change by 1 over the height of a vertex.
    const double area = std::fabs(cageform::signed_area(cage, cage.loops()[0]));
    double longest = 0;
    cage.for_each_edge([&](std::size_t i, std::size_t j) {
        longest = cageform_tests::larger(longest, distance(cage[i], cage[j]));
    });
    const double height = 2 * area / longest;
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, text(expected.rows[i]), text(mean.rows[i]), text(harmonic.rows[i]));
        CHECK(mean.states[i] == PointState::inside);
        CHECK(expected.states[i] == PointState::inside);
        CHECK(difference(expected.rows[i], mean.rows[i]) <=
              16 * double(epsilon<T>) * size_of(cage.vertices()) / height);
        CHECK(difference(expected.rows[i], harmonic.rows[i]) <= 1e-4);
    }
}

TEMPLATE_TEST_CASE("weights_at returns the result of evaluate, or leaves its output unchanged",
                   "[coordinates][weights_at]", Bary<float>, Mean<double>, Harmonic<float>) {
    using T = typename TestType::scalar;
    const std::vector<Vec<T, 2>> triangle{{0, 0}, {4, 1}, {1, 3}};
    const auto coordinates = make<TestType>(Polygon<T>(triangle));
    const std::vector<Vec<T, 2>> points{{T(1.5), T(1.25)}, {2, T(0.5)}, {4, 1}, {-1, T(0.5)}, {100, 7}};
    const auto expected = evaluate_all(coordinates, points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        std::vector<T> row(3, T(42));
        const PointState state = cageform::weights_at(coordinates, points[i], row);
        CHECK(state == expected.states[i]);
        if (state == PointState::outside && !TestType::has_extension) {
            CHECK(row == std::vector<T>(3, T(42)));
        } else {
            CHECK(row == expected.rows[i]);
        }
    }
    const T nan = std::numeric_limits<T>::quiet_NaN(), infinity = std::numeric_limits<T>::infinity();
    for (const auto& p : {std::array<T, 2>{nan, 0}, {0, nan}, {infinity, 0}, {1, -infinity}}) {
        std::vector<T> row(3, T(42));
        CHECK(cageform::weights_at(coordinates, p, row) == PointState::not_finite);
        CHECK(row == std::vector<T>(3, T(42)));
    }
    const TestType faulty(Polygon<T>(std::vector<Vec<T, 2>>{{0, 0}, {1, 1}, {2, 2}}));
    std::vector<T> row(3, T(42));
    CHECK(cageform::weights_at(faulty, points[0], row) == PointState::unreached);
    CHECK(row == std::vector<T>(3, T(42)));
}

TEMPLATE_TEST_CASE("a faulty cage is refused with its own status", "[coordinates][status]", Mean<float>,
                   Harmonic<double>) {
    using T = typename TestType::scalar;
    const auto status_of = [](const Points2<T>& vertices, std::vector<std::size_t> loops = {}) {
        const TestType coordinates(Polygon<T>(vertices, loops));
        const auto weights = evaluate_all(coordinates, Points2<T>{{T(0.5), T(0.25)}});
        CHECK(weights.states[0] == PointState::unreached); // unchanged
        CHECK(weights.status() == coordinates.cage_report().status);
        return weights.status();
    };
    const T nan = std::numeric_limits<T>::quiet_NaN(), infinity = std::numeric_limits<T>::infinity();
    CHECK(status_of({}) == Status::too_few_vertices);
    CHECK(status_of({{0, 0}, {1, 0}}) == Status::too_few_vertices);
    CHECK(status_of({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {3, 2}) == Status::loops_do_not_match);
    CHECK(status_of({{0, 0}, {1, 0}, {nan, 1}}) == Status::vertex_not_finite);
    CHECK(status_of({{0, 0}, {1, 0}, {1, infinity}}) == Status::vertex_not_finite);
    CHECK(status_of({{0, 0}, {1, 0}, {1, 0}, {0, 1}}) == Status::duplicate_vertices);
    CHECK(status_of({{0, 0}, {1, 1}, {1, 0}, {0, 1}}) == Status::cage_self_crossing);
    CHECK(status_of({{0, 0}, {1, 1}, {3, 3}}) == Status::cage_has_no_area);
}

TEST_CASE("for_each_block covers every block once and reports progress", "[coordinates][detail]") {
    const std::size_t blocks = GENERATE(0u, 1u, 63u, 64u, 65u, 1023u, 1024u, 1025u, 5000u, 200000u);
    const bool told = GENERATE(false, true);
    CAPTURE(blocks, told);
    std::vector<int> visits(blocks);
    std::vector<double> progress;
    cageform::Running options;
    if (told) {
        options.progress = [&](double done) {
            progress.push_back(done);
            return true;
        };
    }
    const auto status =
        cageform::detail::for_each_block(blocks, options, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b) ++visits[b];
        });
    CHECK(status == Status::ok);
    CHECK(std::count(visits.begin(), visits.end(), 1) == std::ptrdiff_t(blocks));
    CHECK(progress.empty() == !told);
    CHECK(std::is_sorted(progress.begin(), progress.end()));
    CHECK(progress.size() <= 51);
    if (!progress.empty()) {
        CHECK(progress.front() > 0);
        CHECK(progress.back() == 1);
    }
}

TEST_CASE("for_each_block stops when cancelled", "[coordinates][detail]") {
    std::size_t asked = 0, visited = 0;
    cageform::Running options;
    options.progress = [&](double) { return ++asked < 3; };
    const auto status = cageform::detail::for_each_block(
        100000, options, [&](std::size_t begin, std::size_t end) { visited += end - begin; });
    CHECK(status == Status::cancelled);
    CHECK(asked == 3);
    CHECK(visited < 100000 / 10);
}

TEST_CASE("an allocation that fails becomes a status, other exceptions pass", "[coordinates][detail]") {
    using cageform::detail::guard_memory;
    CHECK(guard_memory([]() -> Status { throw std::bad_alloc(); }) == Status::out_of_memory);
    CHECK(guard_memory([]() -> Status { throw std::length_error("too long"); }) == Status::out_of_memory);
    CHECK(guard_memory([] { return Status::not_converged; }) == Status::not_converged);
    CHECK_THROWS_AS(guard_memory([]() -> Status { throw std::logic_error("a callback's own"); }),
                    std::logic_error);
}

} // namespace coordinate_tests

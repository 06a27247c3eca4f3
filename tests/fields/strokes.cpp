// Fields diffused from strokes: properties on random drawings, orders of convergence, errors.
#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/effort.hpp"
#include "../support/larger.hpp"

#include <cageform/fields/strokes.hpp>
#include <cageform/parallel/threads.hpp>

namespace strokes_tests {

using cageform::Bounds;
using cageform::Diffusion;
using cageform::Status;
using cageform::Stroke;
using cageform::Vec;
using cageform_tests::Random;

namespace {

constexpr Bounds<double, 2> unit_square{{0, 0}, {1, 1}};

/// Two to five lines of two to six points, half of them with two sides; two channels.
template <class T>
std::vector<Stroke<T>> random_strokes(std::uint64_t seed) {
    Random random(seed);
    std::vector<Stroke<T>> strokes(2 + random.below(4));
    for (auto& stroke : strokes) {
        const std::size_t points = 2 + random.below(5);
        for (std::size_t i = 0; i < points; ++i)
            stroke.points.push_back({T(random.uniform(0.02, 0.98)), T(random.uniform(0.02, 0.98))});
        for (std::size_t i = 0; i < 2 * points; ++i) stroke.left.push_back(T(random.uniform(-3, 5)));
        if (random.below(2) == 0) {
            for (std::size_t i = 0; i < 2 * points; ++i) stroke.right.push_back(T(random.uniform(-3, 5)));
        }
    }
    return strokes;
}
std::vector<Vec<double, 2>> random_places(std::uint64_t seed, std::size_t count) {
    Random random(seed);
    std::vector<Vec<double, 2>> places(count);
    for (auto& p : places) p = {random.uniform(0, 1), random.uniform(0, 1)};
    return places;
}

/// The channels at points, after a successful solve.
template <class T, std::size_t D, class R>
std::vector<T> values_at(Diffusion<T, D>& field, const R& places, double tolerance = 1e-11) {
    const auto solved = field.solve({.tolerance = tolerance, .max_cycles = 100});
    CAPTURE(to_string(solved.status), solved.solver.culprit);
    REQUIRE(solved.status == Status::ok);
    std::vector<T> values(places.size() * field.channels());
    REQUIRE(field.sample(places, std::span(values)) == Status::ok);
    return values;
}
std::vector<double> drawn(const std::vector<Stroke<double>>& strokes,
                          const std::vector<Vec<double, 2>>& places, std::size_t channels = 2) {
    Diffusion<double> field(unit_square, 48, channels);
    for (const auto& stroke : strokes) REQUIRE(field.add(stroke) == Status::ok);
    return values_at(field, places);
}
double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
    REQUIRE(a.size() == b.size());
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double d = std::fabs(a[i] - b[i]);
        most = cageform_tests::larger(most, d); // keeps a NaN
    }
    return most;
}

/// A closed line around a centre, with the values of a function on both sides.
template <class F>
Stroke<double> circle(double radius, std::size_t points, const F& value) {
    Stroke<double> stroke;
    for (std::size_t i = 0; i <= points; ++i) {
        const double turn = 2 * std::numbers::pi * double(i % points) / double(points);
        stroke.points.push_back({radius * std::cos(turn), radius * std::sin(turn)});
        stroke.left.push_back(value(stroke.points.back()));
    }
    return stroke;
}
constexpr Bounds<double, 2> about_unit_circle{{-1.25, -1.25}, {1.25, 1.25}};

/// The root mean square error at random points with `in(p)`.
template <class In, class Exact>
double error_of(Diffusion<double>& field, const In& in, const Exact& exact) {
    std::vector<Vec<double, 2>> places;
    for (auto p : random_places(5, 4000)) {
        p = {2.5 * p[0] - 1.25, 2.5 * p[1] - 1.25};
        if (in(p)) places.push_back(p);
    }
    const auto values = values_at(field, places);
    double squares = 0;
    for (std::size_t i = 0; i < places.size(); ++i)
        squares += (values[i] - exact(places[i])) * (values[i] - exact(places[i]));
    return std::sqrt(squares / double(places.size()));
}

} // namespace

TEMPLATE_TEST_CASE("a diffused field is a mean of the strokes' values", "[grid][strokes][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(30));
    CAPTURE(seed);
    const auto strokes = random_strokes<T>(std::uint64_t(seed));
    Diffusion<T> field({{0, 0}, {1, 1}}, 16 + std::size_t(seed) % 40, 2);
    std::array<T, 2> low{99, 99}, high{-99, -99};
    for (const auto& stroke : strokes) {
        REQUIRE(field.add(stroke) == Status::ok);
        for (const auto* side : {&stroke.left, &stroke.right}) {
            for (std::size_t i = 0; i < side->size(); ++i) {
                low[i % 2] = std::min(low[i % 2], (*side)[i]);
                high[i % 2] = std::max(high[i % 2], (*side)[i]);
            }
        }
    }
    const auto places = random_places(std::uint64_t(seed), 500);
    const auto values = values_at(field, places, 1e-6);
    const T rounding = 64 * cageform::epsilon<T>;
    for (std::size_t i = 0; i < values.size(); ++i) {
        CHECK(values[i] >= low[i % 2] - rounding);
        CHECK(values[i] <= high[i % 2] + rounding);
    }
    for (std::size_t channel = 0; channel < 2; ++channel) {
        REQUIRE(field.field(channel).size() == field.lattice().size());
        for (const T value : field.field(channel)) {
            CHECK(value >= low[channel] - rounding);
            CHECK(value <= high[channel] + rounding);
        }
    }
    // At its end points a stroke has the values given there on the side of the query.
    for (std::size_t cell = 0; cell < field.lattice().size(); ++cell) {
        T value = 0;
        const std::array<Vec<double, 2>, 1> centre{field.lattice().centre(field.lattice().index(cell))};
        std::array<T, 2> both{};
        REQUIRE(field.sample(centre, std::span<T>(both)) == Status::ok);
        value = field.field(0)[cell];
        CHECK(std::fabs(double(both[0]) - double(value)) <= 1e3 * double(cageform::epsilon<T>));
    }
}

TEST_CASE("fields are invariant to translation, and channels are independent", "[grid][strokes][property]") {
    const int seed = GENERATE(seeds(cageform_tests::effort(12, 3)));
    CAPTURE(seed);
    const auto strokes = random_strokes<double>(std::uint64_t(seed));
    const auto places = random_places(std::uint64_t(seed) + 1, 300);
    const auto values = drawn(strokes, places);

    auto mirrored = strokes, turned = strokes, apart = strokes, twice = strokes;
    auto mirrored_places = places, turned_places = places;
    for (auto& p : mirrored_places) p[0] = 1 - p[0];
    for (auto& p : turned_places) p = {1 - p[1], p[0]};
    for (std::size_t s = 0; s < strokes.size(); ++s) {
        for (auto& p : mirrored[s].points) p[0] = 1 - p[0];
        if (!strokes[s].right.empty()) std::swap(mirrored[s].left, mirrored[s].right);
        for (auto& p : turned[s].points) p = {1 - p[1], p[0]};
        for (std::size_t i = 1; i < apart[s].left.size(); i += 2) apart[s].left[i] = double(seed);
        if (strokes[s].right.empty()) twice[s].right = twice[s].left;
    }
    CHECK(largest_difference(drawn(mirrored, mirrored_places), values) < 1e-8);
    CHECK(largest_difference(drawn(turned, turned_places), values) < 1e-8);
    CHECK(largest_difference(drawn(twice, places), values) < 1e-13);
    const auto others = drawn(apart, places);
    double first_channel = 0;
    for (std::size_t i = 0; i < values.size(); i += 2)
        first_channel = cageform_tests::larger(first_channel, std::fabs(values[i] - others[i]));
    CHECK(first_channel < 1e-9);
}

TEST_CASE("a stroke across the canvas has its two values up to the line", "[grid][strokes]") {
    for (const double height :
         {0.5, 0.53, 0.515625, 0.001, 0.9999}) { // through nodes, between, next to the boundary
        CAPTURE(height);
        Diffusion<double> field(unit_square, 32, 1);
        REQUIRE(field.add({{{0, height}, {1, height}}, {1, 1}, {0, 0}, 0}) == Status::ok);
        auto places = random_places(7, 1000);
        for (double above : {1e-6, 1e-9, 1e-3}) {
            places.push_back({0.37, height + above});
            places.push_back({0.37, height - above});
        }
        const auto values = values_at(field, places, 1e-12);
        for (std::size_t i = 0; i < places.size(); ++i)
            CHECK(std::fabs(values[i] - (places[i][1] > height ? 1 : 0)) < 1e-10);
    }
}

TEST_CASE("linear data on closed strokes gives a linear field between them", "[grid][strokes]") {
    const auto linear = [](const Vec<double, 2>& p) { return 0.3 + 1.5 * p[0] - 0.7 * p[1]; };
    Diffusion<double> field(about_unit_circle, 50, 1);
    REQUIRE(field.add(circle(1.1, 7, linear)) == Status::ok); // straight edges: no error of the shape
    REQUIRE(field.add(circle(0.2, 5, linear)) == Status::ok);
    const auto inside = [](const Vec<double, 2>& p) { return std::hypot(p[0], p[1]) < 0.9; };
    CHECK(error_of(field, inside, linear) < 1e-10);
}

TEST_CASE("fields converge with the square of the spacing", "[grid][strokes]") {
    const auto annulus = [](const Vec<double, 2>& p) {
        return 1 - std::log(std::hypot(p[0], p[1])) / std::log(0.25);
    };
    const auto between = [](const Vec<double, 2>& p) {
        return std::hypot(p[0], p[1]) > 0.26 && std::hypot(p[0], p[1]) < 0.99;
    };
    const auto saddle = [](const Vec<double, 2>& p) { return p[0] * p[0] - p[1] * p[1] + 0.5 * p[0] * p[1]; };
    std::array<double, 3> of_annulus{}, of_disc{}, of_sides{};
    for (std::size_t level = 0; level < 3; ++level) {
        const std::size_t resolution = std::size_t{40} << level;
        CAPTURE(resolution);
        Diffusion<double> lines(about_unit_circle, resolution, 1), disc = lines, sides = lines;
        REQUIRE(lines.add(circle(0.25, 1500, [](const auto&) { return 0.0; })) == Status::ok);
        REQUIRE(lines.add(circle(1, 1500, [](const auto&) { return 1.0; })) == Status::ok);
        of_annulus[level] = error_of(lines, between, annulus);
        REQUIRE(disc.add({{{0, 0}}, {0.0}, {}, 0.25}) == Status::ok); // a point with a radius
        REQUIRE(disc.add(circle(1, 1500, [](const auto&) { return 1.0; })) == Status::ok);
        of_disc[level] = error_of(disc, between, annulus);
        auto two_sided = circle(1, 1500, saddle); // the inside is on the left
        two_sided.right.assign(two_sided.left.size(), 7.0);
        REQUIRE(sides.add(two_sided) == Status::ok);
        of_sides[level] = error_of(
            sides, [](const Vec<double, 2>&) { return true; },
            [&](const Vec<double, 2>& p) { return std::hypot(p[0], p[1]) < 1 ? saddle(p) : 7.0; });
    }
    for (const auto& errors : {of_annulus, of_disc, of_sides}) {
        CAPTURE(errors[0], errors[1], errors[2]);
        CHECK(errors[0] > 10 * errors[2]); // 16 in the limit
    }
}

TEST_CASE("fields scale with their values, for values of any size", "[grid][strokes]") {
    // Links cut close to a node have weights up to 1e9: found by tests/fuzz/hostile_strokes.cpp, seed
    // 40016468.
    const auto places = random_places(3, 60);
    const auto field_of = [&](double size) {
        const std::vector<Stroke<double>> strokes{{{{0.1, 0.2}, {0.9, 0.7}}, {-size, size}, {}},
                                                  {{{0.15, 0.8}, {0.8, 0.85}}, {size, 0}, {-size, -size}}};
        return drawn(strokes, places, 1);
    };
    const auto small = field_of(1);
    for (const double size : {1e-300, 1e150, 1.7e308}) {
        CAPTURE(size);
        auto values = field_of(size);
        for (double& value : values) value /= size;
        CHECK(largest_difference(values, small) <= 1e-9);
    }
}

TEST_CASE("a disc far larger than the canvas covers it", "[grid][strokes]") {
    // The crossings of its circle with lattice lines are out of the range of an index (found by a
    // sanitizer).
    for (const double radius : {10.0, 1e12, 1e59, 1e150}) {
        CAPTURE(radius);
        Diffusion<double> field(about_unit_circle, 24, 1);
        REQUIRE(field.add({{{0.1, 0.2}}, {3.0}, {}, radius}) == Status::ok);
        REQUIRE(field.solve().status == Status::ok);
        for (const double value : field.field(0)) CHECK(value == 3);
    }
    // Two discs with infinite radii in cells give the mean of both.
    Diffusion<double> field(about_unit_circle, 24, 1);
    REQUIRE(field.add({{{0.1, 0.2}}, {3.0}, {}, 1.7e308}) == Status::ok);
    REQUIRE(field.add({{{-0.3, 0.1}, {0.2, 0.3}}, {1.0, 1.0}, {}, 1.7e308}) == Status::ok);
    REQUIRE(field.solve().status == Status::ok);
    for (const double value : field.field(0)) CHECK((value >= 1 && value <= 3));
}

TEST_CASE("at the end of a stroke with two sides the error is of first order", "[grid][strokes]") {
    // r^½ sin(θ/2): ±√r on the two sides of a slit along the negative axis, zero ahead of it.
    const auto crack = [](const Vec<double, 2>& p) {
        return std::sqrt(std::hypot(p[0], p[1])) * std::sin(0.5 * std::atan2(p[1], p[0]));
    };
    std::array<double, 3> errors{};
    for (std::size_t level = 0; level < 3; ++level) {
        Diffusion<double> field(about_unit_circle, std::size_t{40} << level, 1);
        Stroke<double> slit;
        for (int i = 400; i >= 0; --i) { // from the boundary of the circle to its centre: the left is above
            const double x = double(i) / 400 * double(i) / 400;
            slit.points.push_back({-x, 0});
            slit.left.push_back(std::sqrt(x));
            slit.right.push_back(-std::sqrt(x));
        }
        REQUIRE(field.add(slit) == Status::ok);
        auto rim = circle(1, 2000, crack);
        rim.points.erase(rim.points.begin() + 1000); // the position of the jump
        rim.left.erase(rim.left.begin() + 1000);
        REQUIRE(field.add(rim) == Status::ok);
        errors[level] =
            error_of(field, [](const Vec<double, 2>& p) { return std::hypot(p[0], p[1]) < 0.9; }, crack);
    }
    CAPTURE(errors[0], errors[1], errors[2]);
    CHECK(errors[1] < 0.65 * errors[0]);
    CHECK(errors[2] < 0.65 * errors[1]);
}

TEMPLATE_TEST_CASE("walls in 3D", "[grid][strokes]", CAGEFORM_SCALARS) {
    using T = TestType;
    const Bounds<T, 3> canvas{{0, 0, 0}, {1, 1, 1}};
    Random random(11);
    std::vector<Vec<T, 3>> places(500);
    for (auto& p : places) p = {T(random.uniform(0, 1)), T(random.uniform(0, 1)), T(random.uniform(0, 1))};
    const T height = T(0.53);
    cageform::Wall<T> floor{{{0, 0, height}, {1, 0, height}, {1, 1, height}, {0, 1, height}},
                            {{0, 1, 2}, {0, 2, 3}},
                            {1, 1, 1, 1},
                            {0, 0, 0, 0}};
    Diffusion<T, 3> field(canvas, 16, 1);
    REQUIRE(field.add(floor) == Status::ok);
    auto values = values_at(field, places, 1e-6);
    for (std::size_t i = 0; i < places.size(); ++i)
        CHECK(std::fabs(values[i] - T(places[i][2] > height ? 1 : 0)) < T(1e-5));

    // Two opposite walls of a mirrored box: linear between them.
    Diffusion<T, 3> between(canvas, 16, 1);
    auto top = floor, bottom = floor;
    for (auto& p : top.points) p[2] = T(0.9);
    for (auto& p : bottom.points) p[2] = T(0.1);
    top.back = bottom.back = {};
    bottom.front = {0, 0, 0, 0};
    REQUIRE(between.add(top) == Status::ok);
    REQUIRE(between.add(bottom) == Status::ok);
    values = values_at(between, places, 1e-6);
    for (std::size_t i = 0; i < places.size(); ++i)
        CHECK(std::fabs(values[i] - std::clamp((places[i][2] - T(0.1)) / T(0.8), T(0), T(1))) < T(1e-5));

    auto faulty = floor;
    faulty.faces[1][0] = 9;
    CHECK(between.add(faulty) == Status::face_without_vertex);
    faulty.faces[1] = {0, 1, 1};
    CHECK(between.add(faulty) == Status::face_without_area);
    faulty.faces.clear();
    CHECK(between.add(faulty) == Status::too_few_vertices);
}

TEST_CASE("invalid strokes are refused and change nothing", "[grid][strokes][status]") {
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 infinity = std::numeric_limits<double>::infinity();
    const Stroke<double> good{{{0.2, 0.2}, {0.8, 0.7}}, {1, 2}, {3, 4}, 0};
    Diffusion<double> field(unit_square, 16, 1);
    std::vector<double> value(1);
    const std::vector<Vec<double, 2>> place{{0.5, 0.6}};
    CHECK(field.solve().status == Status::cells_unreached);
    CHECK(field.sample(place, std::span(value)) == Status::cells_unreached);
    CHECK(field.field(0).empty());
    REQUIRE(field.add(good) == Status::ok);
    REQUIRE(field.solve().status == Status::ok);
    REQUIRE(field.sample(place, std::span(value)) == Status::ok);
    const double before = value[0];

    const auto refused = [&](auto&& change) {
        auto stroke = good;
        change(stroke);
        return field.add(stroke);
    };
    CHECK(refused([](auto& s) { s = {}; }) == Status::too_few_vertices);
    CHECK(refused([](auto& s) { s.points[1] = s.points[0]; }) == Status::too_few_vertices);
    CHECK(refused([](auto& s) { s = {{{0.5, 0.5}}, {1}, {}, 0}; }) == Status::radius_not_positive);
    CHECK(refused([&](auto& s) { s.radius = nan; }) == Status::radius_not_positive);
    CHECK(refused([](auto& s) { s.radius = -1; }) == Status::radius_not_positive);
    CHECK(refused([](auto& s) { s.radius = 0.1; }) == Status::input_malformed); // two sides
    CHECK(refused([&](auto& s) { s.points[0][1] = nan; }) == Status::vertex_not_finite);
    CHECK(refused([](auto& s) { s.points[0][1] = 1.01; }) == Status::interior_cell_outside);
    CHECK(refused([&](auto& s) { s.right[1] = infinity; }) == Status::value_not_finite);
    CHECK(refused([](auto& s) { s.left.push_back(0); }) == Status::input_malformed);
    CHECK(refused([](auto& s) { s.right.pop_back(); }) == Status::input_malformed);
    REQUIRE(field.solve().status == Status::ok);
    REQUIRE(field.sample(place, std::span(value)) == Status::ok);
    CHECK(value[0] == before);

    CHECK(field.solve({.tolerance = 0}).status == Status::tolerance_not_positive);
    CHECK(field.solve({.tolerance = 1e-13, .max_cycles = 1}).status == Status::not_converged);
    cageform::Running cancelled;
    cancelled.progress = [](double) { return false; };
    CHECK(field.solve({}, cancelled).status == Status::cancelled);
    // Later strokes are not tested yet; the first that is too small for the grid is reported.
    REQUIRE(field.add({{{0.4001, 0.4001}, {0.4002, 0.4001}}, {9, 9}, {}, 0}) == Status::ok);
    REQUIRE(field.sample(place, std::span(value)) == Status::ok);
    CHECK(value[0] == before);
    const auto coarse = field.solve();
    CHECK(coarse.status == Status::grid_too_coarse);
    CHECK(coarse.solver.culprit == 1);
    CHECK(field.sample(std::vector<Vec<double, 2>>{{nan, 0}}, std::span(value)) == Status::value_not_finite);
    CHECK(field.sample(std::vector<Vec<double, 2>>(2), std::span(value)) == Status::output_too_small);
    CHECK(value[0] == before);

    const auto status_of = [&](const Bounds<double, 2>& canvas, std::size_t resolution) {
        Diffusion<double> other(canvas, resolution, 1);
        (void)other.add(good);
        return other.solve().status;
    };
    CHECK(status_of(unit_square, 1) == Status::resolution_not_supported);
    CHECK(status_of(unit_square, 20000) == Status::resolution_not_supported);
    CHECK(status_of({{0, 0}, {0, 1}}, 16) == Status::resolution_not_supported);
    CHECK(status_of({{0, 0}, {infinity, 1}}, 16) == Status::resolution_not_supported);
    CHECK(status_of(unit_square, 2) == Status::ok);
}

TEST_CASE("fields do not depend on threads, crowded strokes are counted", "[grid][strokes]") {
    const auto draw = [](std::size_t channels) {
        Diffusion<double> field(unit_square, 40, channels);
        Random random(3);
        for (int n = 0; n < 4; ++n) {
            Stroke<double> stroke{{{0.1, 0.2 + 0.004 * n}, {0.9, 0.3 + 0.004 * n}}, {}, {}, 0};
            for (std::size_t i = 0; i < 2 * channels; ++i) stroke.left.push_back(random.uniform(0, 1));
            REQUIRE(field.add(stroke) == Status::ok);
        }
        return field;
    };
    auto one = draw(35), four = draw(35); // three groups of channels
    cageform::Running running;
    running.parallel = cageform::ThreadedFor{4};
    const auto report = one.solve();
    REQUIRE(report.status == Status::ok);
    CHECK(report.solver.unresolved_cells > 10);
    const auto crowded = [](double second) { // two lines along 31 links
        Diffusion<double> field(unit_square, 40, 1);
        for (const double y : {0.506, second}) {
            REQUIRE(field.add(Stroke<double>{{{0.11, y}, {0.89, y}}, {0, 1}, {}, 0}) == Status::ok);
        }
        return field.solve().solver.unresolved_cells;
    };
    CHECK(std::abs(double(crowded(0.508)) - 31) <= 1);
    CHECK(crowded(0.606) == 0);
    REQUIRE(four.solve({}, running).status == Status::ok);
    for (std::size_t channel = 0; channel < 35; ++channel) {
        const auto a = one.field(channel), b = four.field(channel);
        CHECK(std::equal(a.begin(), a.end(), b.begin(), b.end()));
    }
}

} // namespace strokes_tests

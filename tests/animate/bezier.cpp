// Bézier curves as functions of time: validity, and three evaluation methods.
#include "animate/curves.hpp"
#include "catch.hpp"

#include "../bench/curve_comparators.hpp"
#include "support/larger.hpp"

namespace bezier_tests {

using namespace cageform_tests;
using cageform::BezierFunction;
using cageform::epsilon;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

BezierCurve with_times(double u1, double u2) {
    return bezier(u1, 0.3, u2, 0.8);
}

/// The least derivative of time among samples of the parameter.
double least_velocity(const BezierCurve& curve) {
    long double least = infinity;
    for (int n = 0; n <= 4000; ++n)
        least = std::min(least, velocity_at(curve, static_cast<long double>(n) / 4000)[0]);
    return double(least);
}

/// The parameter at a time by bisection alone, in long double.
long double slow_parameter(const BezierCurve& curve, long double x) {
    long double low = 0, high = 1;
    for (int step = 0; step < 80; ++step) {
        const long double middle = (low + high) / 2;
        (point_at(curve, middle)[0] <= x ? low : high) = middle;
    }
    return (low + high) / 2;
}

} // namespace

TEST_CASE("check accepts exactly the region where time is monotone", "[animate][bezier]") {
    struct Place {
        double u1, u2;
        bool sound, vertical;
    };
    // The specification's list (2.2), the ends of the ellipse and the corners of the square.
    const std::array<Place, 17> places{{{.5, .5, true, false},
                                        {1, .01, true, false},
                                        {1.2, .65, true, false},
                                        {.3, -.2, true, false},
                                        {0, .5, true, true},
                                        {.5, 1, true, true},
                                        {0, 1, true, true},
                                        {1, 0, true, true},
                                        {0, 0, true, true},
                                        {1, 1, true, true},
                                        {4. / 3, 2. / 3, true, true},
                                        {1. / 3, -1. / 3, true, true},
                                        {1. / 3, 2. / 3, true, false},
                                        {1.3, .3, false, false},
                                        {-.05, .5, false, false},
                                        {.5, 1.05, false, false},
                                        {4. / 3 + 1e-6, 2. / 3, false, false}}};
    for (const auto& [u1, u2, sound, vertical] : places) {
        CAPTURE(u1, u2);
        const auto result = cageform::check(with_times(u1, u2));
        CHECK((result.status == Status::ok) == sound);
        if (sound) CHECK(result.vertical_tangent == vertical);
        if (!sound) CHECK(result.status == Status::time_not_monotone);
    }
}

TEST_CASE("check agrees with samples of the derivative of time", "[animate][bezier][property]") {
    std::size_t sound = 0, unsound = 0;
    for (int i = -10; i <= 38; ++i) {
        for (int j = -10; j <= 38; ++j) {
            const double u1 = 0.0371 * i, u2 = 0.0389 * j - 0.013;
            const auto curve = moved(with_times(u1, u2), -3, 7, 0, 1);
            const double least = least_velocity(curve);
            if (std::fabs(least) < 1e-4) continue; // too near the boundary for samples
            CAPTURE(u1, u2, least);
            const auto result = cageform::check(curve);
            CHECK((result.status == Status::ok) == (least > 0));
            CHECK((result.status == Status::ok) == admissible(u1, u2));
            if (result.status == Status::ok) CHECK(!result.vertical_tangent);
            ++(least > 0 ? sound : unsound);
        }
    }
    CHECK(sound > 500);
    CHECK(unsound > 500);
}

TEST_CASE("curves that are not functions of time are rejected with a status", "[animate][bezier]") {
    const auto good = with_times(0.3, 0.6);
    REQUIRE(cageform::check(good).status == Status::ok);
    for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t axis = 0; axis < 2; ++axis) {
            for (const double bad : {not_a_number, infinity, -infinity}) {
                auto curve = good;
                curve.points[k][axis] = bad;
                CHECK(cageform::check(curve).status == Status::value_not_finite);
            }
        }
    }
    auto curve = good;
    curve.points[3][0] = 0;
    CHECK(cageform::check(curve).status == Status::interval_empty);
    curve.points[3][0] = -1;
    CHECK(cageform::check(curve).status == Status::interval_empty);
    curve = moved(good, -1e308, 1, 0, 1);
    curve.points[3][0] = 1e308; // the length overflows
    CHECK(cageform::check(curve).status == Status::interval_empty);
    curve = moved(good, 0, 1e-310, 0, 1); // the inverse length overflows
    CHECK(cageform::check(curve).status == Status::interval_empty);
}

TEST_CASE("BezierFunction evaluates the curve", "[animate][bezier][property]") {
    const auto seed = GENERATE(seeds(200));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 100);
    const auto curve = random_curve(random, seed % 2 == 0 ? 0.02 : 0);
    const BezierFunction function(curve);
    const double length = curve.end() - curve.begin(), size = std::fabs(curve.begin()) + length;
    CHECK(function(curve.begin()) == curve.points[0][1]);
    CHECK(function(curve.end()) == curve.points[3][1]);
    CHECK(function(curve.begin() - length) == curve.points[0][1]);
    CHECK(function(curve.end() + length) == curve.points[3][1]);
    for (int n = 0; n < 50; ++n) {
        const double x = curve.begin() + length * random.uniform(0, 1);
        const double t = function.parameter(x);
        CAPTURE(n, x, t);
        CHECK(std::fabs(double(point_at(curve, t)[0] - x)) <= 8 * epsilon<double> * size);
        CHECK(std::fabs(double(point_at(curve, t)[1]) - function(x)) <=
              16 * epsilon<double> * height_of(curve));
        const auto slow = slow_parameter(curve, x);
        const double speed = double(velocity_at(curve, slow)[0]) / length;
        if (speed > 1e-3) CHECK(std::fabs(double(slow - t)) <= 16 * epsilon<double> * size / length / speed);
        const auto c = derivatives_at(curve, t);
        if (speed > 1e-2) {
            CHECK(function.derivative(x) ==
                  Approx(double(c[1])).epsilon(1e-9).margin(1e-9 * height_of(curve) / length));
            CHECK(function.curvature_at(t) ==
                  Approx(double(c[2])).epsilon(1e-9).margin(1e-9 * height_of(curve) / length / length));
        }
    }
}

TEST_CASE("BezierFunction is accurate at vertical tangents", "[animate][bezier]") {
    for (const auto& [u1, u2] : {std::array{0., 0.},
                                 {0., 1.},
                                 {1., 0.},
                                 {1., 1.},
                                 {4. / 3, 2. / 3},
                                 {1. / 3, -1. / 3},
                                 {0., .5},
                                 {.5, 1.},
                                 {1e-9, 1 - 1e-9},
                                 {1e-300, .5}}) {
        const auto curve = with_times(u1, u2);
        CAPTURE(u1, u2);
        REQUIRE(cageform::check(curve).status == Status::ok);
        const BezierFunction function(curve);
        double before = 0;
        for (int n = 0; n <= 3000; ++n) {
            const double x = double(n) / 3000, t = function.parameter(x);
            CHECK(t >= before); // monotone
            CHECK(std::fabs(double(point_at(curve, t)[0]) - x) <= 8 * epsilon<double>);
            before = t;
        }
        for (const double x : {1e-300, 1e-100, 1e-20, 1 - epsilon<double>})
            CHECK(std::fabs(double(point_at(curve, function.parameter(x))[0]) - x) <= 4 * epsilon<double>);
    }
    CHECK(std::isinf(BezierFunction(with_times(0, 0.5)).derivative(0)));
    CHECK(std::isinf(BezierFunction(with_times(0.5, 1)).derivative(1)));
}

TEST_CASE("at a key with a coincident handle, the slope points to the next control point",
          "[animate][bezier][property]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 300);
    auto curve = random_curve(random);
    curve.points[1] = curve.points[0];
    while (!(cageform::check(curve).status == Status::ok)) {
        curve = random_curve(random);
        curve.points[1] = curve.points[0];
    }
    const auto slope_of = [](const auto& p, const auto& q) { return (q[1] - p[1]) / (q[0] - p[0]); };
    CHECK(BezierFunction(curve).derivative(curve.begin()) ==
          Approx(slope_of(curve.points[0], curve.points[2])).epsilon(1e-9));
    // The same at the other end.
    BezierCurve back;
    for (std::size_t k = 0; k < 4; ++k)
        back.points[k] = {curve.points[0][0] + curve.points[3][0] - curve.points[3 - k][0],
                          curve.points[3 - k][1]};
    back.points[2] = back.points[3];
    REQUIRE(cageform::check(back).status == Status::ok);
    CHECK(BezierFunction(back).derivative(back.end()) ==
          Approx(slope_of(back.points[1], back.points[3])).epsilon(1e-9));
    // Both handles on their keys: a straight line.
    auto line = curve;
    line.points[2] = line.points[3];
    for (const double x : {line.begin(), line.end()})
        CHECK(BezierFunction(line).derivative(x) ==
              Approx(slope_of(line.points[0], line.points[3])).epsilon(1e-9));
    // The next point beside or above the key: a flat or vertical tangent.
    const double along = random.uniform(0.1, 0.9), up = random.uniform(0.1, 2);
    CHECK(BezierFunction(bezier(0, 0, along, 0)).derivative(0) == 0);
    CHECK(BezierFunction(bezier(along, 1, 1, 1)).derivative(1) == 0);
    CHECK(BezierFunction(bezier(0, 0, 0, up)).derivative(0) == infinity);
    CHECK(BezierFunction(bezier(1, 1 - up, 1, 1)).derivative(1) == infinity);
    CHECK(BezierFunction(bezier(1, 1 + up, 1, 1)).derivative(1) == -infinity);
    // Both handles on one key: a straight line too.
    for (const std::size_t key : {std::size_t{0}, std::size_t{3}}) {
        line.points[1] = line.points[2] = line.points[key];
        CHECK(BezierFunction(line).derivative(line.points[key][0]) ==
              Approx(slope_of(line.points[0], line.points[3])).epsilon(1e-9));
    }
}

TEST_CASE("closed forms agree with BezierFunction in each family", "[animate][bezier][closed_form]") {
    struct Family {
        const char* name;
        double u1, u2, tolerance; // of the parameter
    };
    const std::array<Family, 13> families{{{"linear", 1. / 3, 2. / 3, 1e-14},
                                           {"square root, upwards", 1. / 6, 1. / 2, 1e-14},
                                           {"square root, downwards", 1. / 2, 5. / 6, 1e-14},
                                           {"square root, vertical", 0, 1. / 3, 1e-7}, // √ε at the tangent
                                           {"cube root", 0, 0, 1e-14},
                                           {"cube root, end", 1, 1, 1e-5}, // ∛ε at the tangent
                                           {"sinh", 2. / 3, 1. / 3, 1e-13},
                                           {"sinh, steep", 0.95, 0.1, 1e-13},
                                           {"cos of 0", 0.1, 0.35, 1e-12},      // a > 0, before its extrema
                                           {"cos of 2", 0.6, 0.9, 1e-12},       // a > 0, after them
                                           {"cos of 1", 1. / 6, 5. / 6, 1e-13}, // a < 0
                                           {"cos and cosh", 0.005, 0.1, 1e-13}, // one after the other
                                           {"cosh", 0.3, 0.28, 1e-12}}};
    for (const auto& [name, u1, u2, tolerance] : families) {
        const auto curve = moved(with_times(u1, u2), -2, 5, 1, 3);
        REQUIRE(cageform::check(curve).status == Status::ok);
        const BezierFunction robust(curve);
        const cageform_bench::ClosedFormFunction closed(curve);
        double worst = 0;
        for (int n = 0; n <= 1000; ++n) {
            const double x = -2 + 5 * double(n) / 1000;
            worst = cageform_tests::larger(worst, std::fabs(closed.parameter(x) - robust.parameter(x)));
            CHECK(std::fabs(closed(x) - robust(x)) <= 20 * tolerance);
        }
        CAPTURE(name, worst);
        CHECK(worst <= tolerance);
    }
}

TEST_CASE("closed forms lose precision where the cubic term of time is small",
          "[animate][bezier][closed_form]") {
    const auto seed = GENERATE(seeds(300));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 500);
    const auto curve = random_normal_curve(random);
    const BezierFunction robust(curve);
    const cageform_bench::ClosedFormFunction closed(curve);
    // The rounding of (2b³ − 9abc) / 27a³, through the inverse function.
    const double a = std::fabs(robust.time().c3);
    CAPTURE(a);
    for (int n = 0; n <= 200; ++n) {
        const double x = double(n) / 200, t = robust.parameter(x);
        CHECK(std::fabs(closed.parameter(x) - t) <=
              64 * epsilon<double> / (a * a) / std::fmin(robust.time().slope(t), 1));
    }
}

TEST_CASE("Newton's method agrees with BezierFunction on curves with ordered handles",
          "[animate][bezier][newton]") {
    const auto seed = GENERATE(seeds(200));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 700);
    // OpenGEX: handles between the keys, in order. There a single root is promised.
    const double u1 = random.uniform(0.1, 0.5);
    const auto normal = bezier(u1, random.uniform(-1, 2), random.uniform(u1, 0.9), random.uniform(-1, 2));
    const auto curve = moved(normal, random.uniform(-5, 5), random.uniform(0.1, 10), 2, 3);
    const BezierFunction robust(curve);
    const cageform_bench::NewtonFunction newton(curve), exact(curve, 1e-12);
    for (int n = 0; n <= 100; ++n) {
        const double x = curve.begin() + robust.length() * double(n) / 100;
        CHECK(std::fabs(exact(x) - robust(x)) <= 1e-12 * height_of(curve));
        CHECK(std::fabs(newton(x) - robust(x)) <= 1e-9 * height_of(curve)); // the last step is quadratic
    }
}

TEST_CASE("the normal form is the curve from (0, 0) to (1, 1)", "[animate][bezier][property]") {
    const auto seed = GENERATE(seeds(100));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 900);
    auto curve = random_curve(random);
    if (seed % 3 == 0) curve.points[3][1] = curve.points[0][1]; // keys of one value: sheared
    const auto form = normal_form(curve);
    CHECK(form.sheared == (seed % 3 == 0));
    CHECK(form.curve.points[0] == Vec<double, 2>{0, 0});
    CHECK(form.curve.points[3] == Vec<double, 2>{1, 1});
    const BezierFunction original(curve), normal(form.curve);
    for (int n = 0; n <= 50; ++n) {
        const double part = double(n) / 50;
        const double expected = original(form.begin + part * form.length);
        CHECK(std::fabs(form.value_of(part, normal(part)) - expected) <= 1e-11 * (1 + height_of(curve)));
    }
}

} // namespace bezier_tests

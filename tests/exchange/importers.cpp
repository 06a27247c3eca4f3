// Curves of other programs: import, round trips, and errors.
#include "catch.hpp"
#include "support/cages.hpp"
#include "support/larger.hpp"

#include <cageform/exchange/blender.hpp>
#include <cageform/exchange/css.hpp>
#include <cageform/exchange/gltf.hpp>
#include <cageform/exchange/lottie.hpp>
#include <cageform/exchange/unity.hpp>
#include <cageform/exchange/unreal.hpp>

#include <bit>
#include <clocale>
#include <cmath>
#include <cstring>
#include <limits>

/// A curve has begin and end, so Catch2 takes it for a range.
template <>
struct Catch::StringMaker<cageform::BezierCurve> {
    static std::string convert(const cageform::BezierCurve& curve) {
        std::string text;
        for (const auto& p : curve.points)
            text += "(" + Detail::stringify(p[0]) + ", " + Detail::stringify(p[1]) + ") ";
        return text;
    }
};

namespace importers_tests {

using namespace cageform;
using cageform_tests::Random;

#if !defined(CAGEFORM_TEST_FUZZ)
#define CAGEFORM_TEST_FUZZ 100000
#endif

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
constexpr float inff = std::numeric_limits<float>::infinity();
constexpr std::size_t fuzz_count = CAGEFORM_TEST_FUZZ;

using Place = Vec<double, 2>;

BezierCurve curve_of(Place p0, Place p1, Place p2, Place p3) {
    return {{p0, p1, p2, p3}};
}

/// Keys at moderate times and values, with the handles' times in the interval.
BezierCurve random_segment(Random& random) {
    const double begin = random.uniform(-5, 5), length = std::pow(10.0, random.uniform(-2, 2));
    const auto place = [&](double part) { return Place{begin + part * length, random.uniform(-3, 3)}; };
    return curve_of(place(0), place(random.uniform(0, 1)), place(random.uniform(0, 1)), place(1));
}

/// A single-precision number: a multiple of 2^-19 below 32. Computed by rounding, because g++ 12 -O3 -mavx
/// sometimes drops the conversion in double(float(x)).
double single(Random& random, double low, double high) {
    return std::ldexp(std::round(std::ldexp(random.uniform(low, high), 19)), -19);
}

/// The largest distance of control points along an axis, and the largest coordinate there.
double distance(const BezierCurve& a, const BezierCurve& b, std::size_t axis) {
    double most = 0;
    for (std::size_t i = 0; i < 4; ++i)
        most = cageform_tests::larger(most, std::fabs(a.points[i][axis] - b.points[i][axis]));
    return most;
}
double size(const BezierCurve& a, std::size_t axis) {
    double most = 0;
    for (const auto& p : a.points) most = cageform_tests::larger(most, std::fabs(p[axis]));
    return most;
}

/// Control points agree to `roundings` of the largest coordinate, the cost of subtracting and adding a key.
void check_close(const BezierCurve& a, const BezierCurve& b, double roundings = 8) {
    for (std::size_t axis = 0; axis < 2; ++axis)
        CHECK(distance(a, b, axis) <= roundings * epsilon<double> * size(a, axis));
}

bool same_bits(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}
bool same_bits(const BezierCurve& a, const BezierCurve& b) {
    for (std::size_t i = 0; i < 4; ++i) {
        if (!same_bits(a.points[i][0], b.points[i][0]) || !same_bits(a.points[i][1], b.points[i][1]))
            return false;
    }
    return true;
}

/// A failed import has no curve.
bool refused(const Result<KeyInterval>& result, Status status) {
    return result.status() == status && result.value.curve == BezierCurve{};
}

bool consistent(const Result<KeyInterval>& result) {
    return result.status() == Status::ok ? check(result.value.curve).status == Status::ok
                                         : result.value.curve == BezierCurve{};
}

/// The cubic with given values and slopes at both ends, in the Hermite basis of glTF's appendix C.
double hermite(double t0, double v0, double out, double t1, double v1, double in, double time) {
    const double d = t1 - t0, t = (time - t0) / d;
    return (2 * t * t * t - 3 * t * t + 1) * v0 + d * (t * t * t - 2 * t * t + t) * out +
           (-2 * t * t * t + 3 * t * t) * v1 + d * (t * t * t - t * t) * in;
}

/// An arbitrary number, as from a file.
double any_number(Random& random) {
    static constexpr double odd[] = {0,      -0.0,   1,    -1,    0.5,       1.0 / 3, 2.0 / 3,
                                     2,      1e-300, inf,  -inf,  no_number, 1e308,   -1e308,
                                     5e-324, 3e38,   4e38, -4e38, 1e-8,      1e16};
    switch (random.below(4)) {
    case 0: return std::bit_cast<double>(random.bits());
    case 1: return odd[random.below(std::size(odd))];
    default: return random.uniform(-2, 2);
    }
}
float any_float(Random& random) {
    return random.below(8) == 0 ? std::bit_cast<float>(std::uint32_t(random.bits()))
                                : float(random.uniform(-2, 2));
}

const Status malformed = Status::input_malformed;

} // namespace

// CSS

TEST_CASE("the keywords of CSS easing are the curves of the specification", "[animate][import][css]") {
    const auto curve = [](double x1, double y1, double x2, double y2) {
        return curve_of({0, 0}, {x1, y1}, {x2, y2}, {1, 1});
    };
    const auto parsed = [](std::string_view text) {
        const auto result = parse_css_easing(text);
        CAPTURE(std::string(text), result.report.error_at);
        CHECK(result.status() == Status::ok);
        CHECK(result.report.error_at == 0);
        return result.value;
    };
    CHECK(parsed("linear") == curve(0, 0, 1, 1));
    CHECK(parsed("ease") == curve(0.25, 0.1, 0.25, 1));
    CHECK(parsed("ease-in") == curve(0.42, 0, 1, 1));
    CHECK(parsed("ease-out") == curve(0, 0, 0.58, 1));
    CHECK(parsed("ease-in-out") == curve(0.42, 0, 0.58, 1));
    CHECK(parsed(" \t\r\n\fEaSe-IN /* slow */ ") == curve(0.42, 0, 1, 1));
    for (const double x : {0.0, 0.1, 0.5, 0.9, 1.0}) {
        CHECK(BezierFunction(parsed("linear"))(x) == Approx(x).epsilon(0).margin(1e-15));
    }
}

TEST_CASE("cubic-bezier() accepts all CSS numbers", "[animate][import][css]") {
    const std::string text = GENERATE(
        "cubic-bezier(0.25, 0.1, 0.25, 1)", "cubic-bezier(.25,.1,.25,1)", "CUBIC-Bezier( .25 ,.1\n,.25, 1 )",
        "cubic-bezier(+0.25,+1e-1,25E-2,10.0e-1)", "cubic-bezier(/**/.25/* , */,/*)*/.1,.25,1/***/)",
        "/* ease */cubic-bezier(0.250000000000000000000000000000,.1,2.5e-0001,1e+0)");
    CAPTURE(text);
    const auto result = parse_css_easing(text);
    CHECK(result.status() == Status::ok);
    CHECK(result.value == curve_of({0, 0}, {0.25, 0.1}, {0.25, 1}, {1, 1}));
}

TEST_CASE("CSS numbers out of the range of double are infinite or zero", "[animate][import][css]") {
    const auto y1 = [](const std::string& number) {
        const auto result = parse_css_easing("cubic-bezier(0," + number + ",1,1)");
        CAPTURE(number);
        CHECK(result.status() == Status::ok);
        return result.value.points[1][1];
    };
    CHECK(y1("-1e-400") == 0);
    CHECK(y1("1e-99999999999999999999999999") == 0);
    CHECK(y1("0e99999999999999999999999999") == 0);
    CHECK(y1("0." + std::string(500, '0') + "1") == 0);
    CHECK(y1("0." + std::string(500, '0') + "1e501") == 1);
    CHECK(y1("1" + std::string(400, '0') + "e-400") == 1);
    CHECK(y1("5e-324") == 5e-324);
    CHECK(y1("-1.7976931348623157e308") == -1.7976931348623157e308);
    for (const std::string large : {"1e309", "-1e309", "1e99999999999999999999", "100e308"}) {
        const auto result = parse_css_easing("cubic-bezier(0, 0, 1, " + large + ")");
        CHECK(result.status() == Status::value_not_finite);
        CHECK(result.report.error_at == 22);
        CHECK(parse_css_easing("cubic-bezier(" + large + ",0,1,1)").status() == Status::handle_not_allowed);
    }
    CHECK(parse_css_easing("cubic-bezier(0,0,1,1" + std::string(400, '0') + ")").status() ==
          Status::value_not_finite);
}

TEST_CASE("invalid CSS easings are refused with their position", "[animate][import][css]") {
    struct Case {
        std::string text;
        Status status;
        std::size_t at;
    };
    const Case c = GENERATE(values<Case>({
        {"", malformed, 0},
        {"   ", malformed, 3},
        {"easy", malformed, 0},
        {" ease-in-oot", malformed, 1},
        {"ease in", malformed, 5},
        {"ease(", malformed, 4},
        {"ease;", malformed, 4},
        {"ease\xC3\xA9", malformed, 4},
        {std::string("ease\0", 5), malformed, 4},
        {std::string("\0", 1), malformed, 0},
        {"steps(4, end)", malformed, 0},
        {"cubic-bezier", malformed, 12},
        {"cubic-bezier (0,0,1,1)", malformed, 12},
        {"cubic-bezier/**/(0,0,1,1)", malformed, 12},
        {"cubic-bezier(", malformed, 13},
        {"cubic-bezier()", malformed, 13},
        {"cubic-bezier(0,0,1)", malformed, 18},
        {"cubic-bezier(0,0,1,1", malformed, 20},
        {"cubic-bezier(0,0,1,1,1)", malformed, 20},
        {"cubic-bezier(0 0 1 1)", malformed, 15},
        {"cubic-bezier(0,0,1,1) ease", malformed, 22},
        {"cubic-bezier(0,0,1,1))", malformed, 21},
        {"cubic-bezier(0,0,1,1)/* open", malformed, 21},
        {"cubic-bezier(0,0,/*1,1)", malformed, 17},
        {"cubic-bezier(nan,0,1,1)", malformed, 13},
        {"cubic-bezier(inf,0,1,1)", malformed, 13},
        {"cubic-bezier(0x1,0,1,1)", malformed, 14},
        {"cubic-bezier(0%,0,1,1)", malformed, 14},
        {"cubic-bezier(0px,0,1,1)", malformed, 14},
        {"cubic-bezier(1.,0,1,1)", malformed, 14},
        {"cubic-bezier(.,0,1,1)", malformed, 13},
        {"cubic-bezier(0.5.5,0,1,1)", malformed, 16},
        {"cubic-bezier(1e,0,1,1)", malformed, 14},
        {"cubic-bezier(1e+,0,1,1)", malformed, 14},
        {"cubic-bezier(--1,0,1,1)", malformed, 14},
        {"cubic-bezier(+,0,1,1)", malformed, 14},
        {"cubic-bezier(0,5,0,1,1)", malformed, 20}, // a decimal comma makes five numbers
        {"cubic-bezier(calc(0),0,1,1)", malformed, 13},
        {"cubic-bezier(-0.1,0,1,1)", Status::handle_not_allowed, 13},
        {"cubic-bezier(0, 0, 1.0001, 1)", Status::handle_not_allowed, 19},
        {"cubic-bezier(1.2, 0, .65, 1)", Status::handle_not_allowed,
         13}, // time ascends, but not within [0, 1]
    }));
    CAPTURE(c.text);
    const auto result = parse_css_easing(c.text);
    CHECK(result.status() == c.status);
    CHECK(result.report.error_at == c.at);
    CHECK(result.value == BezierCurve{});
}

TEST_CASE("parse_css_easing returns the curve of to_css bit by bit", "[animate][import][css]") {
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    for (int i = 0; i < 200; ++i) {
        const auto y = [&] {
            for (;;) {
                const double number =
                    random.below(2) == 0 ? random.uniform(-2, 3) : std::bit_cast<double>(random.bits());
                if (is_finite(number)) return number;
            }
        };
        const auto x = [&] {
            return random.below(2) == 0 ? random.uniform(0, 1) : std::ldexp(random.uniform(0, 1), -900);
        };
        const auto curve = curve_of({0, 0}, {x(), y()}, {x(), y()}, {1, 1});
        const auto css = to_css(curve);
        CAPTURE(css.value);
        REQUIRE(css.status() == Status::ok);
        const auto back = parse_css_easing(css.value);
        REQUIRE(back.status() == Status::ok);
        CHECK(same_bits(back.value, curve));
    }
}

TEST_CASE("to_css writes the normalised curve", "[animate][import][css]") {
    CHECK(to_css(parse_css_easing("ease").value).value == "cubic-bezier(0.25, 0.1, 0.25, 1)");
    CHECK(to_css(curve_of({8, -1}, {10, -1}, {16, 7}, {16, 3})).value == "cubic-bezier(0.25, 0, 1, 2)");
    CHECK(to_css(curve_of({0, 3}, {1, 3}, {2, 1}, {4, 1})).value ==
          "cubic-bezier(0.25, 0, 0.5, 1)"); // falling
    CHECK(to_css(curve_of({0, 3}, {1, 3}, {2, 3}, {4, 3})).value ==
          "cubic-bezier(0.25, 0, 0.5, 1)"); // constant
    CHECK(to_css(curve_of({0, 0}, {0, 1e300}, {1, -1e-300}, {1, 1})).value ==
          "cubic-bezier(0, 1e+300, 1, -1e-300)");
    const double lowest = std::numeric_limits<double>::denorm_min();
    CHECK(to_css(
              curve_of({0, 0}, {lowest, -1.7976931348623157e308}, {lowest, -2.2250738585072014e-308}, {1, 1}))
              .value == "cubic-bezier(5e-324, -1.7976931348623157e+308, 5e-324, -2.2250738585072014e-308)");
}

TEST_CASE("to_css fails with a status and no text", "[animate][import][css]") {
    const auto status = [](const BezierCurve& curve) {
        const auto css = to_css(curve);
        CHECK(css.value.empty());
        return css.status();
    };
    CHECK(status(curve_of({0, 0}, {1.2, 0}, {0.65, 1}, {1, 1})) ==
          Status::handle_not_allowed); // valid in other formats
    CHECK(status(curve_of({0, 0}, {0.3, 0}, {-0.2, 1}, {1, 1})) == Status::handle_not_allowed);
    CHECK(status(curve_of({0, 0}, {0.3, 1}, {0.6, 0}, {1, 0})) == Status::handle_not_allowed); // equal values
    CHECK(status(curve_of({0, 0}, {-0.1, 0}, {0.5, 1}, {1, 1})) == Status::time_not_monotone);
    CHECK(status(curve_of({0, 0}, {1, 0}, {0, 1}, {0, 1})) == Status::interval_empty);
    CHECK(status(curve_of({0, 0}, {no_number, 0}, {1, 1}, {1, 1})) == Status::value_not_finite);
    CHECK(status(curve_of({0, 0}, {0.5, 1e300}, {1, 1}, {1, 1e-300})) == Status::value_not_finite);
}

TEST_CASE("CSS does not depend on the locale", "[animate][import][css]") {
    const std::string before = std::setlocale(LC_ALL, nullptr);
    bool comma = false;
    for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "pl_PL.UTF-8", "fr_FR.UTF-8", "de_DE"})
        comma = comma || std::setlocale(LC_ALL, name) != nullptr;
    CAPTURE(comma); // most build machines have no locale with a decimal comma
    const auto css = to_css(parse_css_easing("cubic-bezier(.5,.25,.75,1.5)").value);
    std::setlocale(LC_ALL, before.c_str());
    CHECK(css.value == "cubic-bezier(0.5, 0.25, 0.75, 1.5)");
}

// Lottie

TEST_CASE("handles of Lottie are fractions of the interval and the difference of values",
          "[animate][import][lottie]") {
    const LottieEasing easing{{0.25, 0.5}, {0.75, 1.5}, false};
    const auto result = from_lottie(easing, {10, 4}, {30, 0});
    REQUIRE(result.status() == Status::ok);
    CHECK(result.value.kind == KeyKind::bezier);
    CHECK(result.value.curve == curve_of({10, 4}, {15, 2}, {25, -2}, {30, 0}));
    const auto back = to_lottie(result.value.curve);
    CHECK(back.status() == Status::ok);
    CHECK(back.value == easing);
    const auto linear = from_lottie({}, {1, 2}, {3, 8});
    CHECK(linear.value.curve == curve_of({1, 2}, {1, 2}, {3, 8}, {3, 8}));
    CHECK(to_lottie(linear.value.curve).value == LottieEasing{});
    CHECK(to_lottie(result.value.curve, KeyKind::linear).value == LottieEasing{});
}

TEST_CASE("hold in Lottie keeps the first value", "[animate][import][lottie]") {
    const auto result =
        from_lottie({{no_number, 5}, {1, 1}, true}, {10, 4}, {30, no_number}); // i and o may be missing then
    REQUIRE(result.status() == Status::ok);
    CHECK(result.value.kind == KeyKind::hold);
    CHECK(result.value.curve.begin() == 10);
    CHECK(result.value.curve.end() == 30);
    for (const double t : {10.0, 17.0, 30.0}) CHECK(BezierFunction(result.value.curve)(t) == 4);
    const auto back = to_lottie(result.value.curve, KeyKind::hold);
    CHECK(back.status() == Status::ok);
    CHECK(back.value.hold);
}

TEST_CASE("curves survive a round trip through Lottie to rounding", "[animate][import][lottie]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    for (int i = 0; i < 100; ++i) {
        const auto curve = random_segment(random);
        const auto lottie = to_lottie(curve);
        REQUIRE(lottie.status() == Status::ok);
        const auto back = from_lottie(lottie.value, curve.points[0], curve.points[3]);
        REQUIRE(back.status() == Status::ok);
        CHECK(back.value.curve.points[0] == curve.points[0]);
        CHECK(back.value.curve.points[3] == curve.points[3]);
        check_close(curve, back.value.curve);
    }
}

TEST_CASE("curves that Lottie cannot express are refused", "[animate][import][lottie]") {
    const Place a{0, 0}, b{1, 1};
    const auto status = [&](LottieHandle out, LottieHandle in) {
        return from_lottie({out, in, false}, a, b);
    };
    CHECK(refused(status({-0.1, 0}, {1, 1}), Status::handle_not_allowed));
    CHECK(refused(status({0, 0}, {1.1, 1}), Status::handle_not_allowed));
    CHECK(refused(status({no_number, 0}, {1, 1}), Status::value_not_finite));
    CHECK(refused(status({0, 0}, {1, inf}), Status::value_not_finite));
    CHECK(refused(from_lottie({}, b, a), Status::interval_empty));
    CHECK(refused(from_lottie({}, a, {0, 1}), Status::interval_empty));
    CHECK(refused(from_lottie({}, a, {1, no_number}), Status::value_not_finite));
    CHECK(refused(from_lottie({{}, {}, true}, b, a), Status::interval_empty));
    CHECK(refused(from_lottie({{}, {}, true}, {0, inf}, b), Status::value_not_finite));
    CHECK(to_lottie(curve_of(a, {1.2, 0}, {0.65, 1}, b)).status() == Status::handle_not_allowed);
    CHECK(to_lottie(curve_of(a, {0.5, 1}, {0.5, 1}, {1, 0})).status() == Status::handle_not_allowed);
    CHECK(to_lottie(curve_of(a, {-0.5, 1}, {0.5, 1}, b)).status() == Status::time_not_monotone);
    CHECK(to_lottie(curve_of(b, b, a, a), KeyKind::hold).status() == Status::interval_empty);
}

// Blender

namespace {

/// A pair of keys around the interval of a stored curve.
std::pair<BlenderKey, BlenderKey> blender_keys(const BezierCurve& c, KeyKind kind = KeyKind::bezier) {
    const auto& p = c.points;
    return {{p[0], p[0] - Place{1, 0}, p[1], kind}, {p[3], p[2], p[3] + Place{1, 0}, KeyKind::hold}};
}

} // namespace

TEST_CASE("F-curves evaluate as in Blender 3.4.1", "[animate][import][blender]") {
    // fcurve.evaluate() at these times, in single precision
    const std::array<double, 5> times{1, 2.5, 5, 7.5, 9};
    struct Case {
        BezierCurve stored;
        std::array<double, 5> values;
    };
    const std::array<Case, 3> cases{{{curve_of({0, 0}, {8, 0}, {1, 1}, {10, 1}),
                                      {0.005999577231705189, 0.0499538853764534, 0.6869312524795532,
                                       0.9639791250228882, 0.9953790903091431}},
                                     {curve_of({0, 0}, {15, 3}, {4, 1}, {10, 1}),
                                      {0.20067670941352844, 0.5042385458946228, 1.0124807357788086,
                                       1.1007537841796875, 1.0109519958496094}},
                                     {curve_of({0, 0}, {20, 2}, {-10, -1}, {10, 1}),
                                      {0.09999999403953552, 0.25, 0.5, 0.75, 0.8999998569488525}}}};
    for (const auto& [stored, values] : cases) {
        const auto [first, second] = blender_keys(stored);
        const auto result = from_blender(first, second);
        REQUIRE(result.status() == Status::ok);
        for (std::size_t i = 0; i < times.size(); ++i)
            CHECK(BezierFunction(result.value.curve)(times[i]) == Approx(values[i]).epsilon(0).margin(1e-5));
    }
}

TEST_CASE("long handles of F-curves are shortened along their direction", "[animate][import][blender]") {
    const auto limited = [](const BezierCurve& stored, BlenderLimit limit) {
        const auto [first, second] = blender_keys(stored);
        const auto result = from_blender(first, second, limit);
        CHECK(result.status() == Status::ok);
        return result.value.curve;
    };
    const auto each = BlenderLimit::each_handle, both = BlenderLimit::both_together;
    const auto one_long = curve_of({0, 0}, {16, 4}, {6, 1}, {8, 1});
    CHECK(limited(one_long, each) == curve_of({0, 0}, {8, 2}, {6, 1}, {8, 1}));
    const auto long_together = curve_of({0, 0}, {6, 6}, {-2, 11}, {8, 1}); // 6 and 10 of 8
    check_close(limited(long_together, each), curve_of({0, 0}, {6, 6}, {0, 9}, {8, 1}));
    check_close(limited(long_together, both), curve_of({0, 0}, {3, 3}, {3, 6}, {8, 1}));
    const auto crossed = curve_of({0, 0}, {6, 0}, {2, 1}, {8, 1});
    CHECK(limited(crossed, each) == crossed);
    CHECK(limited(crossed, both) == curve_of({0, 0}, {4, 0}, {4, 1}, {8, 1}));
    const auto short_ones = curve_of({0, 0}, {0, 0}, {7, 1}, {8, 1});
    CHECK(limited(short_ones, each) == short_ones);
    CHECK(limited(short_ones, both) == short_ones);
}

TEST_CASE("limited handles of F-curves give valid curves", "[animate][import][blender]") {
    const auto seed = GENERATE(seeds(50));
    const auto limit = GENERATE(BlenderLimit::each_handle, BlenderLimit::both_together);
    CAPTURE(seed, int(limit));
    Random random{std::uint64_t(seed)};
    for (int i = 0; i < 200; ++i) {
        auto stored = random_segment(random);
        const double length = stored.end() - stored.begin();
        stored.points[1][0] = stored.begin() + std::pow(10.0, random.uniform(-3, 3)) * length;
        stored.points[2][0] = stored.end() - std::pow(10.0, random.uniform(-3, 3)) * length;
        const auto [first, second] = blender_keys(stored);
        const auto result = from_blender(first, second, limit);
        REQUIRE(result.status() == Status::ok);
        // Limiting again changes nothing, so to_blender accepts the curve.
        BlenderKey a, b;
        REQUIRE(to_blender(result.value.curve, a, b, KeyKind::bezier, limit) == Status::ok);
        const auto again = from_blender(a, b, limit);
        REQUIRE(again.status() == Status::ok);
        CHECK(distance(result.value.curve, again.value.curve, 0) <=
              8 * epsilon<double> * size(result.value.curve, 0));
        CHECK(distance(result.value.curve, again.value.curve, 1) <=
              1e-10 * size(result.value.curve, 1)); // steep handles
    }
}

TEST_CASE("F-curves survive a round trip bit by bit, and neighbours do not change",
          "[animate][import][blender]") {
    Random random{7};
    for (int i = 0; i < 1000; ++i) {
        const auto curve = random_segment(random);
        BlenderKey first, second;
        first.handle_left = {-100, 1};
        second.handle_right = {100, 2};
        second.interpolation = KeyKind::linear;
        REQUIRE(to_blender(curve, first, second) == Status::ok);
        const auto back = from_blender(first, second);
        REQUIRE(back.status() == Status::ok);
        CHECK(same_bits(back.value.curve, curve));
        CHECK(first.handle_left == Place{-100, 1});
        CHECK(second.handle_right == Place{100, 2});
        CHECK(second.interpolation == KeyKind::linear);
    }
}

TEST_CASE("constant and linear F-curves need no handles", "[animate][import][blender]") {
    const BlenderKey second{{6, 3}, {no_number, no_number}, {0, 0}, KeyKind::bezier};
    const auto hold = from_blender({{2, 1}, {0, 0}, {no_number, no_number}, KeyKind::hold}, second);
    REQUIRE(hold.status() == Status::ok);
    CHECK(hold.value.kind == KeyKind::hold);
    CHECK(BezierFunction(hold.value.curve)(5.9) == 1);
    const auto linear = from_blender({{2, 1}, {0, 0}, {no_number, no_number}, KeyKind::linear}, second);
    REQUIRE(linear.status() == Status::ok);
    CHECK(linear.value.kind == KeyKind::linear);
    CHECK(BezierFunction(linear.value.curve)(3) == Approx(1.5));
    BlenderKey a, b;
    b.co[1] = 17;
    REQUIRE(to_blender(hold.value.curve, a, b, KeyKind::hold) == Status::ok);
    CHECK(a.interpolation == KeyKind::hold);
    CHECK(b.co == Place{6, 17}); // the value is that of the next interval
    CHECK(from_blender(a, b).value.curve == hold.value.curve);
    REQUIRE(to_blender(linear.value.curve, a, b, linear.value.kind) == Status::ok);
    CHECK(from_blender(a, b).value.curve == linear.value.curve);
}

TEST_CASE("invalid F-curves are refused", "[animate][import][blender]") {
    const auto from = [](const BezierCurve& stored, KeyKind kind = KeyKind::bezier) {
        const auto [first, second] = blender_keys(stored, kind);
        return from_blender(first, second);
    };
    const Place a{0, 0}, b{1, 1};
    CHECK(refused(from(curve_of(a, {-0.5, 0}, b, b)), Status::time_not_monotone));
    CHECK(refused(from(curve_of(a, a, {1.5, 0}, b)), Status::time_not_monotone));
    CHECK(refused(from(curve_of(a, {0.5, no_number}, b, b)), Status::value_not_finite));
    CHECK(refused(from(curve_of(a, a, {-inf, 0}, b)), Status::value_not_finite));
    for (const auto kind : {KeyKind::hold, KeyKind::linear, KeyKind::bezier}) {
        CHECK(refused(from(curve_of(b, b, a, a), kind), Status::interval_empty));
        CHECK(refused(from(curve_of(a, a, a, {0, 1}), kind), Status::interval_empty));
        CHECK(refused(from(curve_of(a, a, b, {inf, 1}), kind), Status::value_not_finite));
        CHECK(refused(from(curve_of({0, no_number}, a, b, b), kind), Status::value_not_finite));
    }
    BlenderKey first{{5, 5}, {4, 4}, {6, 6}, KeyKind::linear}, second = first;
    CHECK(to_blender(curve_of(a, {1.2, 0}, {0.65, 1}, b), first, second) == Status::handle_not_allowed);
    CHECK(to_blender(curve_of(a, {0.7, 0}, {0.4, 1}, b), first, second, KeyKind::bezier,
                     BlenderLimit::both_together) == Status::handle_not_allowed);
    CHECK(to_blender(curve_of(a, {-0.1, 0}, {0.4, 1}, b), first, second) == Status::time_not_monotone);
    CHECK(first.co == Place{5, 5}); // nothing is written
    CHECK(second.handle_left == Place{4, 4});
    CHECK(second.interpolation == KeyKind::linear);
}

// Unity

TEST_CASE("unweighted keys of Unity are Hermite cubics", "[animate][import][unity]") {
    UnityKey first{.time = 2, .value = 1, .in_tangent = no_number, .out_tangent = 3},
        second{.time = 5, .value = 4};
    second.in_tangent = -1.5;
    second.out_tangent = inf; // the outer tangents and unused weights have no effect
    first.out_weight = second.in_weight = no_number;
    const auto result = from_unity(first, second);
    REQUIRE(result.status() == Status::ok);
    check_close(result.value.curve, curve_of({2, 1}, {3, 4}, {4, 5.5}, {5, 4}));
    for (double t = 2; t <= 5; t += 0.25)
        CHECK(BezierFunction(result.value.curve)(t) == Approx(hermite(2, 1, 3, 5, 4, -1.5, t)));
}

TEST_CASE("weighted keys of Unity have handles at their weights", "[animate][import][unity]") {
    UnityKey first{.time = 0, .value = 0, .out_tangent = 2, .out_weight = 0.75},
        second{.time = 4, .value = 1};
    second.in_weight = 0.5;
    second.in_tangent = -1;
    const double third = 4.0 / 3;
    first.weighted = WeightedHandles::out;
    second.weighted = WeightedHandles::out; // of the other side
    check_close(from_unity(first, second).value.curve,
                curve_of({0, 0}, {3, 6}, {4 - third, 1 + third}, {4, 1}));
    first.weighted = WeightedHandles::in;
    second.weighted = WeightedHandles::in;
    check_close(from_unity(first, second).value.curve, curve_of({0, 0}, {third, 2 * third}, {2, 3}, {4, 1}));
    first.weighted = second.weighted = WeightedHandles::both;
    CHECK(from_unity(first, second).value.curve == curve_of({0, 0}, {3, 6}, {2, 3}, {4, 1}));
    first.out_weight = second.in_weight = 1; // both handles across the whole interval
    CHECK(from_unity(first, second).value.curve == curve_of({0, 0}, {4, 8}, {0, 5}, {4, 1}));
    first.out_weight = second.in_weight = 0;
    CHECK(from_unity(first, second).value.curve == curve_of({0, 0}, {0, 0}, {4, 1}, {4, 1}));
}

TEST_CASE("an infinite tangent in Unity holds the value", "[animate][import][unity]") {
    const double infinite = GENERATE(+inf, -inf);
    const bool at_second = GENERATE(false, true);
    CAPTURE(infinite, at_second);
    UnityKey first{.time = 1, .value = 7}, second{.time = 2, .value = 9};
    (at_second ? second.in_tangent : first.out_tangent) = infinite;
    const auto result = from_unity(first, second);
    REQUIRE(result.status() == Status::ok);
    CHECK(result.value.kind == KeyKind::hold);
    CHECK(BezierFunction(result.value.curve)(1.999) == 7);
    UnityKey a, b;
    b.value = 9;
    REQUIRE(to_unity(result.value.curve, a, b, result.value.kind) == Status::ok);
    CHECK(a.out_tangent == inf);
    CHECK(b.value == 9);
    CHECK(from_unity(a, b).value.kind == KeyKind::hold);
    CHECK(from_unity(a, b).value.curve == result.value.curve);
}

TEST_CASE("keys of Unity survive a round trip in single precision", "[animate][import][unity]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto number = [&](double low, double high) { return single(random, low, high); };
    for (int i = 0; i < 100; ++i) {
        UnityKey first, second;
        for (UnityKey* key : {&first, &second}) {
            key->time = key == &first ? number(-5, 5) : number(5.01, 20);
            key->value = number(-10, 10);
            key->in_tangent = number(-4, 4);
            key->out_tangent = number(-4, 4);
            key->in_weight = number(0.01, 1);
            key->out_weight = number(0.01, 1);
            key->weighted = WeightedHandles(random.below(4));
        }
        const auto result = from_unity(first, second);
        REQUIRE(result.status() == Status::ok);
        UnityKey a = first, b = second;
        a.out_tangent = b.in_tangent = a.out_weight = b.in_weight = 0;
        REQUIRE(to_unity(result.value.curve, a, b) == Status::ok);
        CHECK(a.time == first.time);
        CHECK(a.value == first.value);
        CHECK(b.time == second.time);
        CHECK(b.value == second.value);
        CHECK(float(a.out_tangent) == float(first.out_tangent));
        CHECK(float(b.in_tangent) == float(second.in_tangent));
        CHECK(a.weighted == first.weighted); // a weight of a third becomes unweighted
        CHECK(b.weighted == second.weighted);
        const bool out = detail::has(first.weighted, WeightedHandles::out);
        const bool in = detail::has(second.weighted, WeightedHandles::in);
        CHECK(float(a.out_weight) == (out ? float(first.out_weight) : 1.0f / 3));
        CHECK(float(b.in_weight) == (in ? float(second.in_weight) : 1.0f / 3));
        check_close(result.value.curve, from_unity(a, b).value.curve);
    }
}

TEST_CASE("curves survive a round trip through Unity to rounding", "[animate][import][unity]") {
    Random random{11};
    for (int i = 0; i < 2000; ++i) {
        auto curve = random_segment(random);
        if (i % 5 == 0) curve.points[1] = curve.points[0]; // handles on their keys
        if (i % 7 == 0) curve.points[2] = curve.points[3];
        UnityKey a, b;
        REQUIRE(to_unity(curve, a, b) == Status::ok);
        const auto back = from_unity(a, b);
        REQUIRE(back.status() == Status::ok);
        check_close(curve, back.value.curve, 16); // one quotient and one product more
    }
    UnityKey a, b;
    REQUIRE(to_unity(curve_of({0, 0}, {0.1, 5}, {0.2, 5}, {2, 1}), a, b, KeyKind::linear) == Status::ok);
    CHECK(a.out_tangent == Approx(0.5));
    CHECK(b.in_tangent == Approx(0.5));
    CHECK(a.weighted == WeightedHandles::none);
}

TEST_CASE("curves that Unity cannot express are refused", "[animate][import][unity]") {
    const UnityKey first{.time = 0, .weighted = WeightedHandles::both};
    const UnityKey second{.time = 1, .value = 1, .weighted = WeightedHandles::both};
    const auto with_first = [&](auto change) {
        UnityKey key = first;
        change(key);
        return from_unity(key, second);
    };
    CHECK(from_unity(first, second).status() == Status::ok);
    CHECK(refused(from_unity(second, first), Status::interval_empty));
    CHECK(refused(from_unity(first, first), Status::interval_empty));
    CHECK(refused(with_first([](auto& k) { k.out_weight = -0.1; }), Status::handle_not_allowed));
    CHECK(refused(with_first([](auto& k) { k.out_weight = 1.1; }), Status::handle_not_allowed));
    CHECK(refused(with_first([](auto& k) { k.out_weight = no_number; }), Status::value_not_finite));
    CHECK(refused(with_first([](auto& k) { k.out_tangent = no_number; }), Status::value_not_finite));
    CHECK(refused(with_first([](auto& k) { k.value = inf; }), Status::value_not_finite));
    CHECK(refused(with_first([](auto& k) { k.time = no_number; }), Status::value_not_finite));
    CHECK(refused(with_first([](auto& k) { k.time = -inf; }), Status::value_not_finite));
    const Place a{0, 0}, b{1, 1};
    UnityKey x{.time = 5}, y{.time = 6};
    CHECK(to_unity(curve_of(a, {0, 0.5}, b, b), x, y) == Status::slope_unbounded);
    CHECK(to_unity(curve_of(a, a, {1, 0.5}, b), x, y) == Status::slope_unbounded);
    CHECK(to_unity(curve_of(a, {1e-39, 1}, b, b), x, y) ==
          Status::slope_unbounded); // infinite in single precision
    CHECK(to_unity(curve_of(a, {1.2, 0}, {0.65, 1}, b), x, y) == Status::handle_not_allowed);
    CHECK(to_unity(curve_of(a, {0.3, 0}, {-0.2, 1}, b), x, y) == Status::handle_not_allowed);
    CHECK(to_unity(curve_of(a, {-0.1, 0}, {0.5, 1}, b), x, y) == Status::time_not_monotone);
    CHECK(x.time == 5); // nothing is written
    CHECK(y.time == 6);
}

// Unreal

TEST_CASE("unweighted keys of Unreal are Hermite cubics", "[animate][import][unreal]") {
    UnrealKey first{.time = 2, .value = 1, .leave_tangent = 3}, second{.time = 5, .value = 4};
    second.arrive_tangent = -1.5;
    first.leave_weight = second.arrive_weight = no_number;
    const auto result = from_unreal(first, second);
    REQUIRE(result.status() == Status::ok);
    for (double t = 2; t <= 5; t += 0.25)
        CHECK(BezierFunction(result.value.curve)(t) == Approx(hermite(2, 1, 3, 5, 4, -1.5, t)));
}

TEST_CASE("weighted keys of Unreal have handles of their length", "[animate][import][unreal]") {
    UnrealKey first{.time = 0, .value = 1, .leave_tangent = 0.75, .leave_weight = 5};
    UnrealKey second{.time = 8, .value = 2, .arrive_tangent = -2.4, .arrive_weight = 13};
    first.weighted = second.weighted = WeightedHandles::both;
    const auto result = from_unreal(first, second);
    REQUIRE(result.status() == Status::ok);
    check_close(result.value.curve, curve_of({0, 1}, {4, 4}, {3, 14}, {8, 2})); // (4, 3) of 5, (5, -12) of 13
    first.weighted = WeightedHandles::in;
    second.weighted = WeightedHandles::out;
    check_close(from_unreal(first, second).value.curve,
                curve_of({0, 1}, {8.0 / 3, 3}, {16.0 / 3, 2 + 2.4 * 8 / 3}, {8, 2}));
}

TEST_CASE("constant and linear keys of Unreal", "[animate][import][unreal]") {
    UnrealKey first{.time = 1, .value = 7, .leave_tangent = no_number}, second{.time = 2, .value = 9};
    first.interpolation = KeyKind::hold;
    const auto hold = from_unreal(first, second);
    CHECK(hold.value.kind == KeyKind::hold);
    CHECK(BezierFunction(hold.value.curve)(1.999) == 7);
    first.interpolation = KeyKind::linear;
    const auto linear = from_unreal(first, second);
    CHECK(linear.value.kind == KeyKind::linear);
    CHECK(BezierFunction(linear.value.curve)(1.5) == Approx(8));
    for (const auto& imported : {hold, linear}) {
        UnrealKey a, b;
        b.value = 9;
        REQUIRE(to_unreal(imported.value.curve, a, b, imported.value.kind) == Status::ok);
        CHECK(b.value == 9);
        const auto back = from_unreal(a, b);
        CHECK(back.value.kind == imported.value.kind);
        CHECK(back.value.curve == imported.value.curve);
    }
}

TEST_CASE("keys of Unreal survive a round trip in single precision", "[animate][import][unreal]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto number = [&](double low, double high) { return single(random, low, high); };
    for (int i = 0; i < 100; ++i) {
        UnrealKey first{.time = number(-5, 5), .value = number(-10, 10), .leave_tangent = number(-4, 4)};
        UnrealKey second{.time = number(10, 20), .value = number(-10, 10), .arrive_tangent = number(-4, 4)};
        first.leave_weight = number(0.1, 5); // shorter than any interval
        second.arrive_weight = number(0.1, 5);
        first.weighted = WeightedHandles(random.below(4));
        second.weighted = WeightedHandles(random.below(4));
        const auto result = from_unreal(first, second);
        REQUIRE(result.status() == Status::ok);
        UnrealKey a = first, b = second;
        a.leave_tangent = a.leave_weight = b.arrive_tangent = b.arrive_weight = 0;
        REQUIRE(to_unreal(result.value.curve, a, b) == Status::ok);
        CHECK(a.time == first.time);
        CHECK(b.value == second.value);
        CHECK(float(a.leave_tangent) == float(first.leave_tangent));
        CHECK(float(b.arrive_tangent) == float(second.arrive_tangent));
        CHECK(a.weighted == first.weighted);
        CHECK(b.weighted == second.weighted);
        if (detail::has(first.weighted, WeightedHandles::out))
            CHECK(float(a.leave_weight) == float(first.leave_weight));
        if (detail::has(second.weighted, WeightedHandles::in))
            CHECK(float(b.arrive_weight) == float(second.arrive_weight));
        check_close(result.value.curve, from_unreal(a, b).value.curve, 16);
    }
}

TEST_CASE("curves survive a round trip through Unreal to rounding", "[animate][import][unreal]") {
    Random random{12};
    for (int i = 0; i < 2000; ++i) {
        auto curve = random_segment(random);
        const double length = curve.end() - curve.begin();
        if (i % 3 == 0) { // past the keys, as far as time allows: u1 = 1.2, u2 = 0.65
            curve.points[1][0] = curve.begin() + 1.2 * length;
            curve.points[2][0] = curve.begin() + 0.65 * length;
        }
        if (i % 5 == 0) curve.points[1] = curve.points[0];
        UnrealKey a, b;
        REQUIRE(to_unreal(curve, a, b) == Status::ok);
        const auto back = from_unreal(a, b);
        REQUIRE(back.status() == Status::ok);
        // The time of a steep handle is computed from its length, so all coordinates have the same
        // rounding.
        const double most = std::max(size(curve, 0), size(curve, 1));
        CHECK(distance(curve, back.value.curve, 0) <= 16 * epsilon<double> * most);
        CHECK(distance(curve, back.value.curve, 1) <= 16 * epsilon<double> * most);
    }
}

TEST_CASE("curves that Unreal cannot express are refused", "[animate][import][unreal]") {
    UnrealKey first{.time = 0}, second{.time = 1, .value = 1};
    first.weighted = second.weighted = WeightedHandles::both;
    const auto with_first = [&](auto change) {
        UnrealKey key = first;
        change(key);
        return from_unreal(key, second);
    };
    CHECK(from_unreal(first, second).status() == Status::ok); // weights of 0
    for (const auto kind : {KeyKind::hold, KeyKind::linear, KeyKind::bezier}) {
        UnrealKey late = second;
        first.interpolation = late.interpolation = kind;
        CHECK(refused(from_unreal(late, first), Status::interval_empty));
        CHECK(refused(from_unreal(first, first), Status::interval_empty));
        CHECK(refused(with_first([](auto& k) { k.time = no_number; }), Status::value_not_finite));
        CHECK(refused(with_first([](auto& k) { k.value = -inf; }), Status::value_not_finite));
    }
    CHECK(refused(with_first([](auto& k) { k.leave_weight = -1; }), Status::time_not_monotone));
    CHECK(refused(with_first([](auto& k) { k.leave_weight = 2; }), Status::time_not_monotone));
    CHECK(refused(with_first([](auto& k) { k.leave_weight = inf; }), Status::value_not_finite));
    CHECK(refused(with_first([](auto& k) { k.leave_tangent = inf; }), Status::value_not_finite));
    CHECK(refused(with_first([](auto& k) { k.leave_tangent = no_number; }), Status::value_not_finite));
    const Place a{0, 0}, b{1, 1};
    UnrealKey x{.time = 5, .leave_tangent = 3}, y{.time = 6};
    CHECK(to_unreal(curve_of(a, {0, 0.5}, b, b), x, y) == Status::slope_unbounded);
    CHECK(to_unreal(curve_of(a, {0.5, 0}, {1, 0.5}, b), x, y) == Status::slope_unbounded);
    CHECK(to_unreal(curve_of(a, {-0.1, 0}, {0.5, 1}, b), x, y) == Status::time_not_monotone);
    CHECK(x.time == 5); // nothing is written
    CHECK(x.leave_tangent == 3);
}

// glTF

namespace {

struct Track {
    std::size_t components = 1;
    std::vector<float> times, values;
};

/// A sampler with moderate numbers.
Track random_track(Random& random) {
    Track track;
    track.components = 1 + random.below(5);
    const std::size_t keys = 2 + random.below(6);
    float time = random.below(2) == 0 ? 0 : float(random.uniform(0, 100));
    for (std::size_t k = 0; k < keys; ++k) {
        track.times.push_back(time);
        time += float(random.uniform(0.01, 3));
        for (std::size_t i = 0; i < 3 * track.components; ++i)
            track.values.push_back(float(random.uniform(-4, 4)));
    }
    for (std::size_t c = 0; c < track.components; ++c) { // unused tangents
        track.values[c] = 0;
        track.values[track.values.size() - 1 - c] = 0;
    }
    return track;
}

} // namespace

TEST_CASE("cubic splines of glTF evaluate as in the specification", "[animate][import][gltf]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const Track track = random_track(random);
    const std::size_t n = track.components;
    const auto result = from_gltf_cubicspline(track.times, track.values, n);
    REQUIRE(result.status() == Status::ok);
    REQUIRE(result.value.size() == (track.times.size() - 1) * n);
    for (std::size_t k = 0; k + 1 < track.times.size(); ++k) {
        for (std::size_t c = 0; c < n; ++c) {
            const auto& curve = result.value[k * n + c];
            REQUIRE(check(curve).status == Status::ok);
            const BezierFunction f(curve);
            const float* v = track.values.data() + 3 * n * k + c;
            for (double part = 0; part <= 1; part += 0.125) {
                const double time = curve.begin() + part * (curve.end() - curve.begin());
                const double value =
                    hermite(track.times[k], v[n], v[2 * n], track.times[k + 1], v[4 * n], v[3 * n], time);
                CHECK(f(time) == Approx(value).epsilon(0).margin(1e-11));
            }
        }
    }
}

TEST_CASE("cubic splines of glTF survive a round trip bit by bit", "[animate][import][gltf]") {
    const auto seed = GENERATE(seeds(200));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const Track track = random_track(random);
    const auto curves = from_gltf_cubicspline(track.times, track.values, track.components);
    REQUIRE(curves.status() == Status::ok);
    const auto back = to_gltf_cubicspline(curves.value, track.components);
    REQUIRE(back.status() == Status::ok);
    CHECK(back.value.times == track.times);
    CHECK(back.value.values == track.values);
}

TEST_CASE("handles keep their values if times are rounded for glTF", "[animate][import][gltf]") {
    // 1/3 and 100.1 are not floats; an interval of 0.0001 at 100 seconds may change by 4 per cent
    const double begin = 100.1, end = 100.1001, third = (end - begin) / 3;
    const auto curve = curve_of({begin, 1}, {begin + third, 2}, {end - third, 5}, {end, 3});
    const auto track = to_gltf_cubicspline({&curve, 1}, 1);
    REQUIRE(track.status() == Status::ok);
    const auto back = from_gltf_cubicspline(track.value.times, track.value.values, 1);
    REQUIRE(back.status() == Status::ok);
    for (std::size_t i = 0; i < 4; ++i)
        CHECK(back.value[0].points[i][1] == Approx(curve.points[i][1]).epsilon(1e-6));
    CHECK(track.value.values.front() == 0);
    CHECK(track.value.values.back() == 0);
}

TEST_CASE("invalid samplers are refused", "[animate][import][gltf]") {
    std::vector<float> times{0, 1, 2}, values(18, 0.5f);
    const auto status = [&](std::size_t components, std::size_t culprit = 0) {
        const auto result = from_gltf_cubicspline(times, values, components);
        if (result.status() != Status::ok) CHECK(result.value.empty());
        CHECK(result.report.culprit == culprit);
        return result.status();
    };
    CHECK(status(2) == Status::ok);
    CHECK(status(0) == malformed);
    CHECK(status(1) == malformed);
    CHECK(status(3) == malformed);
    CHECK(status(std::numeric_limits<std::size_t>::max()) == malformed);
    CHECK(status(std::numeric_limits<std::size_t>::max() / 9 + 3) == malformed); // 9 of them overflow to 18
    values.pop_back();
    CHECK(status(2) == malformed);
    values.assign(18, 0.5f);
    times = {};
    CHECK(status(2) == malformed);
    times = {1};
    CHECK(status(6) == malformed); // one key has no interval
    times = {0, 1, 1};
    CHECK(status(2, 2) == Status::keys_not_ascending);
    times = {0, -1, 2};
    CHECK(status(2, 1) == Status::keys_not_ascending);
    times = {0, 1, inff};
    CHECK(status(2, 2) == Status::value_not_finite);
    times = {float(no_number), 1, 2};
    CHECK(status(2) == Status::value_not_finite);
    times = {0, 1, 2};
    for (std::size_t i = 0; i < values.size(); ++i) {
        values.assign(18, 0.5f);
        values[i] = i % 2 == 0 ? inff : float(no_number);
        CHECK(status(2, i / 6) == Status::value_not_finite);
    }
}

TEST_CASE("curves that glTF cannot express are refused", "[animate][import][gltf]") {
    const auto piece = [](double begin, double end, double v0, double v1) {
        const double third = (end - begin) / 3;
        return curve_of({begin, v0}, {begin + third, v0 + 1}, {end - third, v1 - 1}, {end, v1});
    };
    // two intervals of two components
    const std::vector<BezierCurve> good{piece(0, 1, 0, 1), piece(0, 1, 5, 6), piece(1, 3, 1, 2),
                                        piece(1, 3, 6, 0)};
    auto curves = good;
    const auto status = [&](std::size_t components, std::size_t culprit) {
        const auto result = to_gltf_cubicspline(curves, components);
        if (result.status() != Status::ok) {
            CHECK(result.value.times.empty());
            CHECK(result.value.values.empty());
        }
        CHECK(result.report.culprit == culprit);
        curves = good;
        return result.status();
    };
    CHECK(status(2, 0) == Status::ok);
    CHECK(status(0, 0) == malformed);
    CHECK(status(3, 0) == malformed);
    CHECK(status(5, 0) == malformed);
    CHECK(status(1, 1) == malformed); // the second does not follow the first
    CHECK(status(4, 2) == malformed); // nor are they four components
    curves.clear();
    CHECK(status(2, 0) == malformed);
    curves[3] = piece(1, 3, 6.5, 0); // a jump
    CHECK(status(2, 3) == malformed);
    curves[3] = piece(1, 2, 6, 0); // ends before the other component
    CHECK(status(2, 3) == malformed);
    for (auto& curve : curves) {
        for (auto& p : curve.points) p[0] -= 1; // begins before 0
    }
    CHECK(status(2, 0) == malformed);
    curves[1].points[1][0] += 1e-5; // a handle off its third
    CHECK(status(2, 1) == Status::handle_not_allowed);
    curves[2].points[2][0] -= 1e-5;
    CHECK(status(2, 2) == Status::handle_not_allowed);
    curves[2].points[1][0] = 0.5;
    CHECK(status(2, 2) == Status::time_not_monotone);
    std::swap(curves[2].points[0], curves[2].points[3]);
    CHECK(status(2, 2) == Status::interval_empty);
    curves[3].points[2][1] = no_number;
    CHECK(status(2, 3) == Status::value_not_finite);
    curves[3].points[2][1] = 1e39;
    CHECK(status(2, 3) == Status::value_not_finite);
    curves = {piece(1000, 1000 + 1e-6, 0, 1)}; // one float
    CHECK(status(1, 0) == Status::interval_empty);
    curves = {piece(0, 1e-39, 0, 1)};
    CHECK(status(1, 0) == Status::slope_unbounded);
}

// Fuzzing: CAGEFORM_TEST_FUZZ inputs, also under sanitizers

TEST_CASE("fuzz: bytes and mutated easings give a status", "[animate][import][css][fuzz]") {
    const std::uint64_t seed = 20240611;
    Random random(seed);
    const std::string_view whole[] = {"cubic-bezier(0.25, 0.1, 0.25, 1)",
                                      "cubic-bezier(.1e0,-2E-3,+1,12.5e+2)",
                                      "ease-in-out",
                                      "linear",
                                      " EASE ",
                                      "cubic-bezier(0,0/* c */,1,1)"};
    const std::string_view parts[] = {
        "cubic-bezier(", ",",     ")",      "/*",   "*/", "e",  "E-", "+",   "-",    ".", "0", "1",
        "9999999999",    "1e308", "1e-400", "ease", " ",  "\n", "%",  "nan", "\xff", "("};
    std::size_t sound = 0, wrong = 0;
    std::string first_wrong;
    for (std::size_t i = 0; i < fuzz_count; ++i) {
        std::string text;
        switch (random.below(3)) {
        case 0:
            for (std::size_t n = random.below(40); n > 0; --n) text += char(random.bits() & 0xff);
            break;
        case 1:
            for (std::size_t n = random.below(20); n > 0; --n) text += parts[random.below(std::size(parts))];
            break;
        default:
            text = whole[random.below(std::size(whole))];
            for (std::size_t n = 1 + random.below(4); n > 0; --n) {
                const std::size_t at = random.below(text.size() + 1);
                switch (random.below(4)) {
                case 0: text.insert(at, parts[random.below(std::size(parts))]); break;
                case 1: text.erase(at, 1 + random.below(3)); break;
                case 2: text.insert(at, 1, char(random.bits() & 0xff)); break;
                default: text.insert(at, 1, char('0' + random.below(10)));
                }
            }
        }
        const std::vector<char> exact(text.begin(),
                                      text.end()); // a sanitizer detects a read past the end
        const auto result = parse_css_easing({exact.data(), exact.size()});
        bool good = result.report.error_at <= text.size();
        if (result.status() == Status::ok) {
            ++sound;
            const auto& p = result.value.points;
            good = good && check(result.value).status == Status::ok && p[1][0] >= 0 && p[2][0] <= 1;
            const auto css = to_css(result.value);
            good = good && css.status() == Status::ok && parse_css_easing(css.value).value == result.value;
        } else {
            good = good && result.value == BezierCurve{};
        }
        if (!good && wrong++ == 0) first_wrong = text;
    }
    CAPTURE(seed, first_wrong);
    CHECK(wrong == 0);
    CHECK(sound > fuzz_count / 200); // enough valid inputs
}

TEST_CASE("fuzz: keys give a status or a valid curve", "[animate][import][fuzz]") {
    const std::uint64_t seed = 20240612;
    Random random(seed);
    const auto number = [&] { return any_number(random); };
    const auto place = [&] { return Place{number(), number()}; };
    const auto kind = [&] { return KeyKind(random.below(3)); };
    const auto weighted = [&] { return WeightedHandles(random.below(4)); };
    std::array<std::size_t, 4> sound{};
    std::size_t wrong = 0, wrong_at = 0;
    for (std::size_t i = 0; i < fuzz_count; ++i) {
        const auto limit = BlenderLimit(random.below(2));
        const std::array<Result<KeyInterval>, 4> results{
            from_lottie({{number(), number()}, {number(), number()}, random.below(4) == 0}, place(), place()),
            from_blender({place(), place(), place(), kind()}, {place(), place(), place(), kind()}, limit),
            from_unity({number(), number(), number(), number(), number(), number(), weighted()},
                       {number(), number(), number(), number(), number(), number(), weighted()}),
            from_unreal({number(), number(), number(), number(), number(), number(), weighted(), kind()},
                        {number(), number(), number(), number(), number(), number(), weighted(), kind()})};
        bool good = true;
        for (std::size_t f = 0; f < 4; ++f) {
            good = good && consistent(results[f]);
            if (results[f].status() != Status::ok) continue;
            ++sound[f];
            // Every valid curve can be exported to every format, and the output is finite.
            const auto& curve = results[f].value.curve;
            const auto lottie = to_lottie(curve, kind());
            good = good && is_finite(lottie.value.out.y) && is_finite(lottie.value.in.y);
            BlenderKey b0, b1;
            if (to_blender(curve, b0, b1, KeyKind::bezier, limit) == Status::ok)
                good = good && is_finite(b0.handle_right) && is_finite(b1.handle_left);
            UnityKey u0, u1;
            if (to_unity(curve, u0, u1) == Status::ok)
                good = good && is_finite(u0.out_tangent) && is_finite(u1.in_tangent) && u0.out_weight >= 0 &&
                       u0.out_weight <= 1 && u1.in_weight >= 0 && u1.in_weight <= 1;
            UnrealKey r0, r1;
            if (to_unreal(curve, r0, r1) == Status::ok)
                good = good && is_finite(r0.leave_tangent) && is_finite(r1.arrive_tangent);
            const auto css = to_css(curve);
            good = good && (css.status() == Status::ok) == !css.value.empty();
        }
        if (!good && wrong++ == 0) wrong_at = i;
        // Also any curve.
        const auto curve = curve_of(place(), place(), place(), place());
        BlenderKey b0, b1;
        UnityKey u0, u1;
        UnrealKey r0, r1;
        const bool refuses = check(curve).status != Status::ok;
        const bool all = to_css(curve).status() != Status::ok && to_lottie(curve).status() != Status::ok &&
                         to_blender(curve, b0, b1) != Status::ok && to_unity(curve, u0, u1) != Status::ok &&
                         to_unreal(curve, r0, r1) != Status::ok;
        if (refuses && !all && wrong++ == 0) wrong_at = i;
    }
    CAPTURE(seed, wrong_at);
    CHECK(wrong == 0);
    for (const std::size_t count : sound) CHECK(count > fuzz_count / 200);
}

TEST_CASE("fuzz: arrays give a status or a valid track", "[animate][import][gltf][fuzz]") {
    const std::uint64_t seed = 20240613;
    Random random(seed);
    std::size_t sound = 0, written = 0, wrong = 0, wrong_at = 0;
    for (std::size_t i = 0; i < fuzz_count; ++i) {
        Track track = random_track(random);
        switch (random.below(4)) { // a quarter is left unchanged
        case 0: track.values[random.below(track.values.size())] = any_float(random); break;
        case 1: track.times[random.below(track.times.size())] = any_float(random); break;
        case 2:
            track.values.resize(random.below(40));
            track.times.resize(random.below(5));
            track.components = random.below(4);
            for (float& v : track.values) v = any_float(random);
            for (float& t : track.times) t = any_float(random);
            break;
        default: break;
        }
        auto result = from_gltf_cubicspline(track.times, track.values, track.components);
        bool good = (result.status() == Status::ok) == !result.value.empty();
        if (result.status() == Status::ok) {
            ++sound;
            for (const auto& curve : result.value) good = good && check(curve).status == Status::ok;
            if (random.below(2) == 0) { // corrupt a curve
                auto& p = result.value[random.below(result.value.size())].points;
                p[random.below(4)][random.below(2)] = any_number(random);
            }
            const auto back = to_gltf_cubicspline(result.value, track.components);
            good = good && (back.status() == Status::ok) == !back.value.times.empty();
            if (back.status() == Status::ok) {
                ++written;
                const auto again =
                    from_gltf_cubicspline(back.value.times, back.value.values, track.components);
                good = good && again.status() == Status::ok;
            }
        }
        if (!good && wrong++ == 0) wrong_at = i;
    }
    CAPTURE(seed, wrong_at);
    CHECK(wrong == 0);
    CHECK(sound > fuzz_count / 10);
    CHECK(written > fuzz_count / 20);
}

} // namespace importers_tests

// Piecewise cubics, single and in banks.
#include "catch.hpp"
#include "support/cages.hpp"
#include "support/larger.hpp"

#include <cageform/clip/curves/curve_bank.hpp>
#include <cageform/clip/curves/track.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace piecewise_cubic_tests {

using namespace cageform_tests;
using cageform::CubicPiece;
using cageform::CurveBank;
using cageform::epsilon;
using cageform::Extrapolation;
using cageform::fold_time;
using cageform::PiecewiseCubic;
using cageform::Track;

namespace {

/// Random pieces with jumps between them. Times are multiples of 2^-10.
template <class T>
PiecewiseCubic<T> random_curve(Random& random, std::size_t most = 12, double shift = 0) {
    const std::size_t count = 1 + random.below(most);
    double time = std::floor(random.uniform(-4, 4) * 1024) / 1024 + shift;
    std::vector<CubicPiece<T>> pieces;
    for (std::size_t i = 0; i < count; ++i) {
        const auto c = [&] { return T(random.uniform(-2, 2)); };
        pieces.push_back({T(time), c(), c(), c(), c()});
        time += (1 + double(random.below(1536))) / 1024;
    }
    return {std::move(pieces), T(time)};
}

template <class T>
std::vector<PiecewiseCubic<T>> random_curves(Random& random, std::size_t count) {
    std::vector<PiecewiseCubic<T>> curves;
    for (std::size_t k = 0; k < count; ++k) curves.push_back(random_curve<T>(random));
    return curves;
}

/// The piece by counting; the value and the scale of its rounding in long double.
struct Exact {
    std::size_t piece = 0;
    long double value = 0, slope = 0, size = 0;
};
template <class T>
Exact exact(const PiecewiseCubic<T>& curve, T x) {
    Exact result;
    x = std::min(std::max(x, curve.begin()), curve.end());
    for (const auto& piece : curve.pieces()) {
        if (piece.begin <= x) result.piece = std::size_t(&piece - curve.pieces().data());
    }
    const auto& p = curve.pieces()[result.piece];
    const long double u = static_cast<long double>(x) - p.begin;
    long double power = 1;
    for (const long double c : {p.c0, p.c1, p.c2, p.c3}) {
        result.value += c * power;
        result.size += std::fabs(c * power);
        power *= u;
    }
    result.slope = p.c1 + u * (2 * static_cast<long double>(p.c2) + u * 3 * p.c3);
    result.size =
        cageform_tests::larger(result.size, std::fabs(static_cast<long double>(p.c1)) +
                                                2 * std::fabs(u * p.c2) + 3 * std::fabs(u * u * p.c3));
    return result;
}

/// A time inside a curve, at a knot, or outside.
template <class T>
T random_time(Random& random, const PiecewiseCubic<T>& curve) {
    const T length = curve.end() - curve.begin();
    switch (random.below(6)) {
    case 0: return curve.pieces()[random.below(curve.pieces().size())].begin;
    case 1: return curve.end();
    case 2: return T(double(curve.begin()) - random.uniform(0, 3));
    case 3: return T(double(curve.end()) + random.uniform(0, 3));
    default: return T(double(curve.begin()) + double(length) * random.uniform(0, 1));
    }
}

template <class T>
bool near(T value, long double expected, long double size) {
    return std::fabs(static_cast<long double>(value) - expected) <= 8 * epsilon<T> * size;
}

} // namespace

TEMPLATE_TEST_CASE("a piecewise cubic: pieces, values and slopes", "[animate][piecewise_cubic][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(100));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    const auto curve = random_curve<T>(random);
    std::size_t cursor = 0;
    for (int n = 0; n < 200; ++n) {
        const T x = random_time(random, curve);
        const auto expected = exact(curve, x);
        const T inside = std::min(std::max(x, curve.begin()), curve.end());
        REQUIRE(curve.locate(inside) == expected.piece);
        // For any hint, also out of range.
        REQUIRE(curve.locate(inside, random.below(curve.pieces().size() + 3)) == expected.piece);
        REQUIRE(near(curve(x), expected.value, expected.size));
        REQUIRE(near(curve(x, cursor), curve(x), expected.size));
        REQUIRE(cursor == expected.piece);
        const bool held = x < curve.begin() || x > curve.end();
        REQUIRE(near(curve.derivative(x), held ? 0 : expected.slope, expected.size));
    }
    CHECK(curve.locate(curve.begin() - 1) == 0);
    CHECK(curve.locate(curve.end() + 1) == curve.pieces().size() - 1);
    CHECK(curve(curve.begin() - T(1e6)) == curve.pieces().front().c0);
    CHECK(curve(curve.end() + T(1e6)) == curve(curve.end()));
}

TEST_CASE("slopes are limits of differences", "[animate][piecewise_cubic][property]") {
    const auto seed = GENERATE(seeds(100));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 101);
    const auto curve = random_curve<double>(random);
    for (int n = 0; n < 50; ++n) {
        const double x = random.uniform(curve.begin(), curve.end()), h = 1e-5;
        if (curve.locate(x - h) != curve.locate(x + h) || x - h < curve.begin() || x + h > curve.end())
            continue;
        REQUIRE(curve.derivative(x) ==
                Approx((curve(x + h) - curve(x - h)) / (2 * h)).epsilon(0).margin(1e-7));
    }
}

TEMPLATE_TEST_CASE("sample gives the values of single evaluations", "[animate][piecewise_cubic][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(60));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 201);
    const auto curve = random_curve<T>(random);
    std::vector<T> times, values(100, T(77));
    for (int n = 0; n < 99; ++n) times.push_back(random_time(random, curve));
    if (seed % 3 == 0) std::sort(times.begin(), times.end());
    if (seed % 3 == 1) std::sort(times.rbegin(), times.rend());
    curve.sample(times, values);
    for (std::size_t n = 0; n < times.size(); ++n)
        REQUIRE(near(values[n], curve(times[n]), exact(curve, times[n]).size));
    CHECK(values[99] == 77);
}

TEST_CASE("late times are as accurate as early ones", "[animate][piecewise_cubic][property]") {
    const auto seed = GENERATE(seeds(60));
    CAPTURE(seed);
    for (const double late : {1e6, -1e6, 1e9}) {
        Random random(std::uint64_t(seed) + 301), same(std::uint64_t(seed) + 301);
        const auto curve = random_curve<double>(random);
        const auto shifted = random_curve<double>(same, 12, late);
        const std::array<PiecewiseCubic<double>, 1> both{shifted};
        const CurveBank<double> bank(both);
        auto cursor = bank.make_cursor();
        std::array<double, 8> values{};
        for (int n = 0; n < 100; ++n) {
            const double x = std::floor(random_time(random, curve) * 1024) / 1024; // exact when shifted
            CHECK(near(shifted(x + late), curve(x), exact(curve, x).size));
            CHECK(near(shifted.derivative(x + late), curve.derivative(x), exact(curve, x).size));
            bank.sample(x + late, cursor, values);
            CHECK(near(values[0], curve(x), exact(curve, x).size));
        }
    }
}

TEMPLATE_TEST_CASE("a bank gives the values of its curves", "[animate][bank][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(30));
    CAPTURE(seed);
    for (const std::size_t count : std::array<std::size_t, 7>{1, 7, 8, 15, 16, 17, 336}) {
        CAPTURE(count);
        Random random(std::uint64_t(seed) * 7 + 401);
        const auto curves = random_curves<T>(random, count);
        const CurveBank<T> bank(curves);
        REQUIRE(bank.size() == count);
        auto forth = bank.make_cursor(), jumping = bank.make_cursor();
        std::vector<T> values(count + 1), slopes(count + 1), again(count);
        const auto check_at = [&](T x, auto& cursor) {
            values.back() = slopes.back() = T(77); // nothing is written after the last
            bank.sample(x, cursor, values, slopes);
            bool good = values.back() == 77 && slopes.back() == 77;
            for (std::size_t k = 0; k < count; ++k) {
                const auto expected = exact(curves[k], x);
                const bool held = x < curves[k].begin() || x > curves[k].end();
                good = good && near(values[k], expected.value, expected.size) &&
                       near(slopes[k], held ? 0 : expected.slope, expected.size);
            }
            bank.sample(x, cursor, again); // at the same time, without slopes
            for (std::size_t k = 0; k < count; ++k)
                good = good && near(again[k], values[k], exact(curves[k], x).size);
            CAPTURE(x);
            REQUIRE(good);
        };
        std::vector<T> times;
        for (int n = 0; n < 60; ++n) times.push_back(random_time(random, curves[random.below(count)]));
        for (const T far : {T(-1e6), T(1e6), std::numeric_limits<T>::lowest(), std::numeric_limits<T>::max()})
            times.push_back(far);
        for (const T x : times) check_at(x, jumping);
        std::sort(times.begin(), times.end());
        for (const T x : times) check_at(x, forth);
        std::sort(times.rbegin(), times.rend());
        for (const T x : times) check_at(x, forth);
        // In small steps, forwards and back.
        for (int n = -600; n <= 1400; n += 7) check_at(T(n) / 64, forth);
        for (int n = 1400; n >= -600; n -= 9) check_at(T(n) / 64, forth);
        // Knots and adjacent times, in sequence and after jumps.
        const auto& some = curves[random.below(count)];
        std::vector<T> knots{some.end()};
        for (const auto& piece : some.pieces()) knots.push_back(piece.begin);
        for (const T knot : knots) {
            for (const T x : {std::nextafter(knot, T(-100)), knot, std::nextafter(knot, T(100))}) {
                check_at(x, forth);
                for (const T far : {T(-1e6), T(1e6)}) {
                    jumping = bank.make_cursor();
                    bank.sample(far, jumping, values);
                    check_at(x, jumping);
                }
            }
        }
    }
}

TEST_CASE("cursors of a bank are independent", "[animate][bank]") {
    Random random(3);
    const auto curves = random_curves<double>(random, 40);
    const CurveBank<double> bank(curves);
    auto first = bank.make_cursor(), second = bank.make_cursor();
    std::vector<double> a(40), b(40), expected(40);
    const auto same = [](const std::vector<double>& v, const std::vector<double>& w) {
        return std::equal(v.begin(), v.end(), w.begin(), w.end(),
                          [](double x, double y) { return std::fabs(x - y) <= 1e-12 * (1 + std::fabs(y)); });
    };
    for (int n = 0; n < 200; ++n) {
        const double x = random.uniform(-5, 15), y = random.uniform(-5, 15);
        bank.sample(x, first, a);
        bank.sample(y, second, b);
        auto fresh = bank.make_cursor();
        bank.sample(x, fresh, expected);
        CHECK(same(a, expected));
        auto copy = first;
        bank.sample(y, copy, expected);
        CHECK(same(b, expected));
    }
    // A cursor stays valid for a copied bank.
    const CurveBank<double> elsewhere = bank;
    elsewhere.sample(1.5, first, a);
    bank.sample(1.5, second, b);
    CHECK(same(a, b));
    CHECK(bank.bytes() > 0);
}

TEST_CASE("a bank without curves", "[animate][bank]") {
    const CurveBank<float> bank;
    auto cursor = bank.make_cursor();
    bank.sample(1, cursor, {});
    CHECK(bank.size() == 0);
}

TEMPLATE_TEST_CASE("fold_time follows each extrapolation", "[animate][fold][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    using enum Extrapolation;
    const auto seed = GENERATE(seeds(200));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 601);
    const T begin = T(random.uniform(-3, 3)), end = begin + T(random.uniform(0.1, 5)), length = end - begin;
    const auto any = [&] {
        return std::array{constant, linear, cycle, cycle_with_offset, ping_pong}[random.below(5)];
    };
    for (int n = 0; n < 50; ++n) {
        // The mode of the other end has no effect; inside, neither has.
        const T inside = std::min(end, T(begin + length * T(random.uniform(0, 1))));
        for (const T x : {inside, begin, end}) {
            const auto same = fold_time(x, begin, end, any(), any());
            REQUIRE((same.time == x && same.cycles == 0 && same.beyond == 0));
        }
        const T after = end + T(random.uniform(1e-3, 40)), before = begin - T(random.uniform(1e-3, 40));
        for (const T x : {before, after}) {
            const bool early = x < begin;
            const T edge = early ? begin : end;
            const double margin = 4 * double(epsilon<T>) * (std::fabs(double(x)) + double(length) + 3);
            const auto fold = [&](Extrapolation mode, T time) {
                const auto other = any();
                return fold_time(time, begin, end, early ? mode : other, early ? other : mode);
            };
            const auto held = fold(constant, x), line = fold(linear, x), round = fold(cycle, x);
            const auto higher = fold(cycle_with_offset, x), back = fold(ping_pong, x);
            REQUIRE((held.time == edge && held.cycles == 0 && held.beyond == 0));
            REQUIRE((line.time == edge && line.cycles == 0 && line.beyond == x - edge));
            const double turns = std::floor((double(x) - double(begin)) / double(length));
            for (const auto& f : {round, higher, back}) {
                REQUIRE(double(f.time) >= double(begin));
                REQUIRE(double(f.time) <= double(end) + margin);
                REQUIRE(f.beyond == 0);
            }
            REQUIRE(round.cycles == 0);
            REQUIRE(back.cycles == 0);
            REQUIRE(round.time == higher.time);
            REQUIRE(double(higher.cycles) == turns);
            REQUIRE(double(round.time) + turns * double(length) ==
                    Approx(double(x)).epsilon(0).margin(margin));
            // Ping-pong: mirrored in odd cycles.
            const bool odd = std::fmod(std::fabs(turns), 2) == 1;
            const double mirrored =
                odd ? double(begin) + double(end) - double(round.time) : double(round.time);
            REQUIRE(double(back.time) == Approx(mirrored).epsilon(0).margin(margin));
        }
    }
    for (const auto mode : {constant, linear, cycle, cycle_with_offset, ping_pong}) {
        const T infinite = std::numeric_limits<T>::infinity();
        CHECK(fold_time(infinite, begin, end, mode, mode).time == end);
        CHECK(fold_time(-infinite, begin, end, mode, mode).time == begin);
        if (mode != linear)
            CHECK(fold_time(T(7), T(2), T(2), mode, mode).time == 2); // no length to fold into
    }
}

TEST_CASE("tracks extrapolate as documented", "[animate][track][property]") {
    using enum Extrapolation;
    const auto seed = GENERATE(seeds(100));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 701);
    Track<double> track;
    track.curve = random_curve<double>(random);
    const double begin = track.curve.begin(), end = track.curve.end(), length = end - begin;
    const double first = track.curve(begin), last = track.curve(end);
    const double rise = last - first;
    std::size_t cursor = 0;
    for (int n = 0; n < 60; ++n) {
        const double x = begin + length * random.uniform(-5, 6), part = random.uniform(0, 1) * length;
        const double turn = double(random.below(9)) - 4;
        for (const auto mode : {constant, linear, cycle, cycle_with_offset, ping_pong}) {
            track.before = track.after = mode;
            REQUIRE(track(x, cursor) == track(x));
            REQUIRE(track(begin + part) == track.curve(begin + part));
        }
        // Not near a knot, where rounding of the time would cross a jump.
        const std::size_t piece = track.curve.locate(begin + part);
        if (track.curve.locate(begin + part - 1e-9) != piece ||
            track.curve.locate(begin + part + 1e-9) != piece)
            continue;
        if (part < 1e-9 || part > length - 1e-9) continue;
        const double there = begin + part + turn * length, value = track.curve(begin + part);
        const double scale = 1e-11 * (1 + std::fabs(value) + 8 * std::fabs(rise) + 40);
        track.before = track.after = cycle;
        CHECK(track(there) == Approx(value).epsilon(0).margin(scale));
        track.before = track.after = cycle_with_offset;
        CHECK(track(there) == Approx(value + turn * rise).epsilon(0).margin(scale));
        track.before = track.after = ping_pong;
        CHECK(track(begin + part + 2 * turn * length) == Approx(value).epsilon(0).margin(scale));
        CHECK(track(begin - part - 2 * turn * length) == Approx(value).epsilon(0).margin(scale));
        track.before = track.after = linear;
        CHECK(track(end + part) ==
              Approx(last + part * track.curve.derivative(end)).epsilon(0).margin(scale));
        CHECK(track(begin - part) ==
              Approx(first - part * track.curve.derivative(begin)).epsilon(0).margin(scale));
        track.before = track.after = constant;
        CHECK(track(end + part) == last);
        CHECK(track(begin - part) == first);
    }
    // Continuous at the ends and between cycles.
    const double slope =
        100 * (1 + std::fabs(track.curve.derivative(begin)) + std::fabs(track.curve.derivative(end)));
    for (const auto mode : {constant, linear, cycle_with_offset, ping_pong}) {
        track.before = track.after = mode;
        for (int turn = -4; turn <= 5; ++turn) {
            const double x = begin + turn * length;
            CAPTURE(int(mode), turn);
            CHECK(track(x - 1e-9) == Approx(track(x + 1e-9)).epsilon(0).margin(1e-9 * slope));
            CHECK(track(x) == Approx(track(x + 1e-9)).epsilon(0).margin(1e-9 * slope));
        }
    }
    // The ends may differ.
    track.before = cycle;
    track.after = constant;
    CHECK(track(end + 0.3 * length) == last);
    CHECK(track(begin - 0.25 * length) == Approx(track.curve(end - 0.25 * length)).epsilon(0).margin(1e-9));
}

} // namespace piecewise_cubic_tests

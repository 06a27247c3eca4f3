// Keys to tracks: kinds, tolerances, invalid input.
#include "catch.hpp"
#include "support/cages.hpp"
#include "support/keys.hpp"
#include "support/larger.hpp"

#include <cageform/animate/compile.hpp>

namespace compile_track_tests {

using namespace cageform_tests;
using cageform::BezierFunction;
using cageform::compile;
using cageform::epsilon;
using cageform::Extrapolation;
using cageform::Key;
using cageform::key_interval;
using cageform::KeyKind;
using cageform::Status;
using cageform::TrackOptions;

namespace {

const std::array kinds{KeyKind::hold, KeyKind::linear, KeyKind::hermite,
                       KeyKind::tcb,  KeyKind::bezier, KeyKind::automatic};

/// Two to nine keys of given kinds, with random handles between neighbours and bounded slopes.
std::vector<Key> random_keys(Random& random, std::span<const KeyKind> of) {
    const std::size_t count = 2 + random.below(8);
    double time = random.uniform(-5, 5);
    std::vector<Key> keys;
    for (std::size_t i = 0; i < count; ++i) {
        Key k = key(time, random.below(4) == 0 && i > 0 ? keys.back().value : random.uniform(-3, 3),
                    of[random.below(of.size())]);
        k.in_slope = random.uniform(-3, 3);
        k.out_slope = random.uniform(-3, 3);
        k.tension = random.uniform(-1, 1);
        k.continuity = random.uniform(-1, 1);
        k.bias = random.uniform(-1, 1);
        keys.push_back(k);
        time += random.uniform(0.05, 2);
    }
    for (std::size_t i = 0; i < count; ++i) {
        Key& k = keys[i];
        const double before = i > 0 ? k.time - keys[i - 1].time : 1;
        const double after = i + 1 < count ? keys[i + 1].time - k.time : 1;
        k.in_handle = {k.time - before * random.uniform(0.1, 0.6), k.value + random.uniform(-2, 2)};
        k.out_handle = {k.time + after * random.uniform(0.1, 0.6), k.value + random.uniform(-2, 2)};
    }
    return keys;
}

/// The largest time before a key.
template <class T>
T just_before(double time) {
    return std::nextafter(T(time), std::numeric_limits<T>::lowest());
}

} // namespace

TEMPLATE_TEST_CASE("keys of any kind are met exactly, the curve between them within the tolerance",
                   "[animate][track][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(200));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    const auto keys = random_keys(random, kinds);
    TrackOptions options;
    options.tolerance = std::pow(10.0, random.uniform(-5, -1));
    const auto compiled = compile<T>(keys, options);
    REQUIRE(compiled.status() == Status::ok);
    CHECK(compiled.report.sup_error <= options.tolerance);
    const auto& track = compiled.value;
    CHECK(track.curve.begin() == T(keys.front().time));
    CHECK(track.curve.end() >= T(keys.back().time));
    CHECK(track.curve.end() <= std::nextafter(T(keys.back().time), T(100)));
    // A time in T, and a knot between keys, are off by a rounding: the value by that times the slope.
    const auto rounding = [&](T x) {
        return 32 * double(epsilon<T>) *
               (10 + std::fabs(double(x)) * (10 + std::fabs(double(track.curve.derivative(x)))));
    };
    for (std::size_t i = 0; i < keys.size(); ++i) {
        CAPTURE(i, int(keys[i].kind));
        const T at = T(keys[i].time);
        CHECK(double(track(at)) == Approx(keys[i].value).epsilon(0).margin(rounding(at)));
        if (i + 1 == keys.size()) break;
        const T before = just_before<T>(keys[i + 1].time);
        const double arrives = keys[keys[i].kind == KeyKind::hold ? i : i + 1].value;
        CHECK(double(track(before)) == Approx(arrives).epsilon(0).margin(2 * rounding(before)));
        const BezierFunction function(key_interval(keys, i));
        for (int n = 0; n < 40; ++n) {
            const T x = std::max(at, std::min(before, T(random.uniform(keys[i].time, keys[i + 1].time))));
            const double expected = keys[i].kind == KeyKind::hold ? keys[i].value : function(double(x));
            REQUIRE(std::fabs(double(track(x)) - expected) <= compiled.report.sup_error + rounding(x));
        }
    }
    // Beyond.
    CHECK(track(T(keys.front().time) - 1) == track(T(keys.front().time)));
    CHECK(track(T(keys.back().time) + 1) == track(track.curve.end()));
}

TEST_CASE("the reported error is the maximum", "[animate][track][property]") {
    const auto seed = GENERATE(seeds(60));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 301);
    const std::array bezier{KeyKind::bezier};
    const auto keys = random_keys(random, bezier);
    TrackOptions options;
    options.tolerance = std::pow(10.0, random.uniform(-4, -1));
    const auto compiled = compile<double>(keys, options);
    REQUIRE(compiled.status() == Status::ok);
    double most = 0;
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
        const BezierFunction function(key_interval(keys, i));
        for (int n = 0; n <= 4000; ++n) {
            const double x = keys[i].time + (keys[i + 1].time - keys[i].time) * n / 4000.0;
            most = cageform_tests::larger(most, std::fabs(compiled.value(x) - function(x)));
        }
    }
    CHECK(most <= compiled.report.sup_error + 1e-12);
    CHECK(most >= 0.99 * compiled.report.sup_error);
    CHECK(compiled.report.sup_error <= options.tolerance);
}

TEST_CASE("a tighter tolerance needs more pieces, at the expected rate", "[animate][track]") {
    Random random(7);
    const std::array bezier{KeyKind::bezier};
    const auto keys = random_keys(random, bezier);
    std::size_t pieces = 0;
    for (const double tolerance : {1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5}) {
        TrackOptions options;
        options.tolerance = tolerance;
        const auto compiled = compile<double>(keys, options);
        REQUIRE(compiled.status() == Status::ok);
        CHECK(compiled.value.curve.pieces().size() >= std::max(pieces, keys.size() - 1));
        pieces = compiled.value.curve.pieces().size();
    }
    CHECK(pieces > keys.size() - 1);
}

TEST_CASE("a hold jumps at the next key", "[animate][track][kinds]") {
    const std::array keys{key(1, 5, KeyKind::hold), key(2, -3, KeyKind::hold), key(4, 7, KeyKind::hold)};
    const auto compiled = compile<double>(keys);
    REQUIRE(compiled.status() == Status::ok);
    CHECK(compiled.report.sup_error == 0);
    const auto& track = compiled.value;
    for (const double x : {-9.0, 1.0, 1.5, just_before<double>(2)}) CHECK(track(x) == 5);
    for (const double x : {2.0, 3.0, just_before<double>(4)}) CHECK(track(x) == -3);
    for (const double x : {4.0, std::nextafter(4.0, 5.0), 4.5, 1e9}) CHECK(track(x) == 7);
    for (const double x : {1.0, 1.5, 2.0, 4.0}) CHECK(track.curve.derivative(x) == 0);
}

TEST_CASE("linear is a straight line at constant speed", "[animate][track][kinds][property]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 401);
    const std::array linear{KeyKind::linear};
    const auto keys = random_keys(random, linear);
    const auto compiled = compile<double>(keys);
    REQUIRE(compiled.status() == Status::ok);
    CHECK(compiled.report.sup_error <= 1e-14);
    REQUIRE(compiled.value.curve.pieces().size() == keys.size() - 1);
    for (int n = 0; n < 100; ++n) {
        const std::size_t i = random.below(keys.size() - 1);
        const double part = random.uniform(0, 1), h = keys[i + 1].time - keys[i].time;
        const double rise = keys[i + 1].value - keys[i].value, x = keys[i].time + part * h;
        CHECK(compiled.value(x) ==
              Approx(keys[i].value + (x - keys[i].time) / h * rise).epsilon(0).margin(1e-13));
        if (part > 1e-6 && part < 1 - 1e-6)
            CHECK(compiled.value.curve.derivative(x) == Approx(rise / h).epsilon(0).margin(1e-12));
    }
}

TEST_CASE("kinds that are cubics of time need one piece per interval", "[animate][track][kinds][property]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 501);
    const std::array simple{KeyKind::hold, KeyKind::linear, KeyKind::hermite, KeyKind::tcb,
                            KeyKind::automatic};
    const auto keys = random_keys(random, simple);
    const auto compiled = compile<double>(keys);
    REQUIRE(compiled.status() == Status::ok);
    CHECK(compiled.report.sup_error <= 1e-13);
    CHECK(compiled.value.curve.pieces().size() == keys.size() - 1);
}

TEST_CASE("hermite: slopes in and out", "[animate][track][kinds][property]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 601);
    const std::array hermite{KeyKind::hermite};
    const auto keys = random_keys(random, hermite);
    const auto compiled = compile<double>(keys);
    REQUIRE(compiled.status() == Status::ok);
    const auto pieces = compiled.value.curve.pieces();
    REQUIRE(pieces.size() == keys.size() - 1);
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
        CHECK(pieces[i].derivative(keys[i].time) == Approx(keys[i].out_slope).epsilon(0).margin(1e-10));
        CHECK(pieces[i].derivative(keys[i + 1].time) ==
              Approx(keys[i + 1].in_slope).epsilon(0).margin(1e-10));
    }
}

TEST_CASE("tcb: Kochanek and Bartels' slopes where keys are equally far apart",
          "[animate][track][kinds][property]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 701);
    const double step = random.uniform(0.1, 3);
    const bool plain = seed % 2 == 0; // Catmull and Rom's
    std::vector<Key> keys;
    for (int i = 0; i < 6; ++i) {
        Key k = key(-1 + i * step, random.uniform(-2, 2), KeyKind::tcb);
        if (!plain) {
            k.tension = random.uniform(-1, 1);
            k.continuity = random.uniform(-1, 1);
            k.bias = random.uniform(-1, 1);
        }
        keys.push_back(k);
    }
    const auto compiled = compile<double>(keys);
    REQUIRE(compiled.status() == Status::ok);
    const auto pieces = compiled.value.curve.pieces();
    REQUIRE(pieces.size() == 5);
    for (std::size_t i = 1; i < 5; ++i) {
        const double time = keys[i].time, value = keys[i].value;
        const double t = keys[i].tension, c = keys[i].continuity, b = keys[i].bias;
        const double before = value - keys[i - 1].value, after = keys[i + 1].value - value;
        const double leaves =
            ((1 - t) * (1 + b) * (1 + c) * before + (1 - t) * (1 - b) * (1 - c) * after) / 2;
        const double comes = ((1 - t) * (1 + b) * (1 - c) * before + (1 - t) * (1 - b) * (1 + c) * after) / 2;
        CHECK(pieces[i].derivative(time) == Approx(leaves / step).epsilon(0).margin(1e-11));
        CHECK(pieces[i - 1].derivative(time) == Approx(comes / step).epsilon(0).margin(1e-11));
        if (!plain || i == 4) continue;
        const double p0 = keys[i - 1].value, p1 = value, p2 = keys[i + 1].value, p3 = keys[i + 2].value;
        for (const double u : {0.1, 0.5, 0.8}) {
            const double catmull_rom =
                0.5 * (2 * p1 + (p2 - p0) * u + (2 * p0 - 5 * p1 + 4 * p2 - p3) * u * u +
                       (3 * p1 - p0 - 3 * p2 + p3) * u * u * u);
            CHECK(compiled.value(time + u * step) == Approx(catmull_rom).epsilon(0).margin(1e-11));
        }
    }
}

TEST_CASE("automatic keys are smooth and monotone between keys", "[animate][track][kinds][property]") {
    const auto seed = GENERATE(seeds(200));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 801);
    const std::array automatic{KeyKind::automatic};
    auto keys = random_keys(random, automatic);
    if (seed % 4 == 0)
        std::sort(keys.begin(), keys.end(), [](auto& a, auto& b) { return a.value < b.value; });
    double time = 0;
    for (Key& k : keys) k.time = time += std::pow(10.0, random.uniform(-3, 1)); // at very different distances
    const auto compiled = compile<double>(keys);
    REQUIRE(compiled.status() == Status::ok);
    const auto& track = compiled.value;
    const auto pieces = track.curve.pieces();
    REQUIRE(pieces.size() == keys.size() - 1);
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
        const double rise = keys[i + 1].value - keys[i].value, length = keys[i + 1].time - keys[i].time;
        double last = keys[i].value;
        bool monotone = true;
        for (int n = 1; n <= 200; ++n) {
            const double value = pieces[i](keys[i].time + length * n / 200);
            monotone = monotone && (rise >= 0 ? value >= last - 1e-13 : value <= last + 1e-13);
            last = value;
        }
        CHECK(monotone);
        CHECK(last == Approx(keys[i + 1].value).epsilon(0).margin(1e-12));
        if (i == 0) continue;
        const double slope = pieces[i].derivative(keys[i].time);
        const double steep =
            1 + std::fabs(rise / length) +
            std::fabs((keys[i].value - keys[i - 1].value) / (keys[i].time - keys[i - 1].time));
        CHECK(pieces[i - 1].derivative(keys[i].time) == Approx(slope).epsilon(0).margin(1e-12 * steep));
    }
}

TEST_CASE("automatic: Fritsch and Butland's slopes, before a hold the chord's", "[animate][track][kinds]") {
    const std::array keys{key(0, 0), key(1, 2), key(4, 3, KeyKind::automatic), key(6, 7, KeyKind::hold),
                          key(7, 0)};
    const auto compiled = compile<double>(keys);
    REQUIRE(compiled.status() == Status::ok);
    const auto pieces = compiled.value.curve.pieces();
    // Chords 2, 1/3 and 2; the mean of their inverses leans to the longer interval's, which is the flatter.
    CHECK(pieces[0].derivative(0) == Approx(2));
    CHECK(pieces[1].derivative(1) == Approx(1 / ((1 + 2 * 3) / 12.0 / 2 + (2 * 1 + 3) / 12.0 * 3)));
    CHECK(pieces[2].derivative(4) == Approx(1 / ((3 + 2 * 2) / 15.0 * 3 + (2 * 3 + 2) / 15.0 / 2)));
    CHECK(pieces[2].derivative(6) == Approx(2));
}

TEST_CASE("automatic keys on a line give the line", "[animate][track][kinds]") {
    const std::array keys{key(0, 1), key(1, 3), key(1.5, 4), key(4, 9)};
    const auto compiled = compile<double>(keys);
    for (const double x : {0.0, 0.3, 1.2, 2.0, 4.0})
        CHECK(compiled.value(x) == Approx(1 + 2 * x).epsilon(1e-14));
}

TEST_CASE("bezier keys use their handles, other keys thirds", "[animate][track][kinds]") {
    std::array keys{key(0, 0, KeyKind::bezier), key(3, 1, KeyKind::linear), key(4, 2, KeyKind::automatic)};
    keys[0].out_handle = {2, 0};
    auto curve = key_interval(keys, 0);
    CHECK(curve.points[1] == Vec<double, 2>{2, 0});
    CHECK(curve.points[2] == Vec<double, 2>{2, 1 - 1.0 / 3}); // linear: arrives with the chord's slope
    keys[1].kind = KeyKind::bezier;
    keys[1].in_handle = {1.5, 1};
    keys[1].out_handle = {3.5, 7};
    curve = key_interval(keys, 0);
    CHECK(curve.points[2] == Vec<double, 2>{1.5, 1});
    curve = key_interval(keys, 1);
    CHECK(curve.points[1] == Vec<double, 2>{3.5, 7});
    CHECK(curve.points[2][0] == Approx(4 - 1.0 / 3));
    CHECK(curve.points[2][1] == Approx(2 - 1.0 / 3)); // automatic, the last: the chord's slope
    // Handles at thirds: a cubic of time, one piece.
    std::array cubic{key(1, 2, KeyKind::bezier), key(4, 0, KeyKind::bezier)};
    cubic[0].out_handle = {2, 9};
    cubic[1].in_handle = {3, -5};
    const auto compiled = compile<double>(cubic);
    REQUIRE(compiled.status() == Status::ok);
    CHECK(compiled.value.curve.pieces().size() == 1);
    CHECK(compiled.report.sup_error <= 1e-13);
    CHECK(compiled.value(2.5) == Approx((2 + 3 * 9 + 3 * -5 + 0) / 8.0));
}

TEST_CASE("vertical tangents meet the tolerance", "[animate][track][kinds]") {
    for (const double tolerance : {0.1, 0.01, 1e-3}) {
        std::array keys{key(0, 0, KeyKind::bezier), key(1, 1, KeyKind::bezier)};
        keys[0].out_handle = {0, 1};
        keys[1].in_handle = {1, 0};
        TrackOptions options;
        options.tolerance = tolerance;
        const auto compiled = compile<double>(keys, options);
        REQUIRE(compiled.status() == Status::ok);
        const BezierFunction function(key_interval(keys, 0));
        for (int n = 0; n <= 1000; ++n)
            REQUIRE(std::fabs(compiled.value(n / 1000.0) - function(n / 1000.0)) <= tolerance * (1 + 1e-9));
    }
}

TEST_CASE("late keys keep their precision", "[animate][track][property]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 901);
    auto keys = random_keys(random, kinds);
    for (Key& k : keys) { // to what a double holds after the shift as well
        for (double* x : {&k.time, &k.in_handle[0], &k.out_handle[0]}) *x = std::round(*x * 4096) / 4096;
    }
    auto later = keys;
    for (Key& k : later) {
        for (double* x : {&k.time, &k.in_handle[0], &k.out_handle[0]}) *x += 1e6;
    }
    const auto here = compile<double>(keys), there = compile<double>(later);
    REQUIRE(here.status() == Status::ok);
    REQUIRE(there.status() == Status::ok);
    const double begin = keys.front().time, end = keys.back().time;
    for (int n = 0; n <= 100; ++n) {
        const double x = std::floor((begin + (end - begin) * n / 100) * 4096) / 4096;
        CHECK(there.value(x + 1e6) == Approx(here.value(x)).epsilon(0).margin(1e-7));
    }
}

TEST_CASE("a single key is a constant", "[animate][track]") {
    for (const auto kind : kinds) {
        for (const double time : {-3.5, 0.0, 2.0, 1e6}) {
            const std::array keys{key(time, 1.5, kind)};
            TrackOptions options;
            for (const auto mode : {Extrapolation::constant, Extrapolation::linear, Extrapolation::cycle,
                                    Extrapolation::cycle_with_offset, Extrapolation::ping_pong}) {
                options.before = options.after = mode;
                const auto compiled = compile<float>(keys, options);
                REQUIRE(compiled.status() == Status::ok);
                CHECK(compiled.report.sup_error == 0);
                CHECK(compiled.value.before == mode);
                CHECK(compiled.value.after == mode);
                for (const float x : {-1e9f, -1.0f, float(time), 2.5f, 1e9f})
                    CHECK(compiled.value(x) == 1.5f);
            }
        }
    }
}

TEST_CASE("invalid keys are rejected with their index", "[animate][track][refused]") {
    const auto good = [] {
        std::vector<Key> keys{key(0, 0, KeyKind::bezier), key(1, 2, KeyKind::bezier),
                              key(2, 1, KeyKind::bezier), key(3, 5)};
        for (Key& k : keys) {
            k.in_handle = {k.time - 0.4, k.value};
            k.out_handle = {k.time + 0.4, k.value};
        }
        return keys;
    };
    const auto refused = [](const std::vector<Key>& keys, Status status, std::size_t culprit,
                            const TrackOptions& options = {}) {
        const auto compiled = compile<double>(keys, options);
        CHECK(compiled.status() == status);
        CHECK(compiled.report.culprit == culprit);
        CHECK(compiled.value.curve.empty());
    };
    REQUIRE(compile<double>(good()).status() == Status::ok);
    refused({}, Status::keys_missing, 0);
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
          -std::numeric_limits<double>::infinity()}) {
        for (std::size_t i = 0; i < 4; ++i) {
            auto keys = good();
            keys[i].time = bad;
            refused(keys, Status::value_not_finite, i);
            keys = good();
            keys[i].value = bad;
            refused(keys, Status::value_not_finite, i);
            keys = good();
            keys[i].in_handle[1] = bad;
            refused(keys, Status::value_not_finite, i);
            keys = good();
            keys[i].out_handle[0] = bad;
            refused(keys, Status::value_not_finite, i);
            for (double Key::* member :
                 {&Key::in_slope, &Key::out_slope, &Key::tension, &Key::continuity, &Key::bias}) {
                keys = good();
                keys[i].*member = bad;
                refused(keys, Status::value_not_finite, i);
            }
        }
    }
    auto keys = good();
    keys[2].time = keys[1].time;
    refused(keys, Status::keys_not_ascending, 2);
    keys = good();
    std::swap(keys[1].time, keys[2].time);
    refused(keys, Status::keys_not_ascending, 2);
    keys = good();
    keys[1].out_handle = {2.2, 2}; // after the next key, and not compensated by the handle there
    keys[2].in_handle = {0.9, 1};
    refused(keys, Status::time_not_monotone, 1);
    keys = good();
    keys[2].in_handle = {3.5, 0};
    refused(keys, Status::time_not_monotone, 1);
    keys = good();
    keys[0].out_handle = {-0.1, 0};
    refused(keys, Status::time_not_monotone, 0);
    for (const double tolerance : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
        TrackOptions options;
        options.tolerance = tolerance;
        refused(good(), Status::tolerance_not_positive, 0, options);
    }
    TrackOptions options;
    options.tolerance = 1e-15;
    CHECK(compile<double>(good(), options).status() == Status::tolerance_not_met);
    // The outer handles of the first and last key are ignored.
    keys = good();
    keys[0].in_handle = {7, 7};
    keys[3].out_handle = {-7, 7};
    CHECK(compile<double>(keys).status() == Status::ok);
}

TEMPLATE_TEST_CASE("numbers too large for the scalar are rejected with their key",
                   "[animate][track][refused]", CAGEFORM_SCALARS) {
    using T = TestType;
    constexpr double largest = std::numeric_limits<T>::max();
    const auto refused = [](const std::vector<Key>& keys, std::size_t culprit,
                            Status why = Status::value_not_finite) {
        const auto compiled = compile<T>(keys);
        CAPTURE(keys[0].time, keys[0].value, keys[1].time, keys[1].value, int(keys[0].kind));
        CHECK(compiled.status() == why);
        CHECK(compiled.report.culprit == culprit);
        CHECK(compiled.value.curve.empty());
    };
    constexpr bool is_float = std::is_same_v<T, float>;
    // Differences of the largest floats are finite in double, but the tolerance cannot be met.
    constexpr auto differs = is_float ? Status::tolerance_not_met : Status::value_not_finite;
    for (const auto kind : {KeyKind::linear, KeyKind::automatic, KeyKind::tcb, KeyKind::hermite})
        refused({key(0, 0.9 * largest, kind), key(1, 1, kind), key(2, 0.9 * largest, kind)}, 0, differs);
    refused({key(0, 0, KeyKind::linear), key(1, 1, KeyKind::linear), key(1 + 1e-6, 0.9 * largest)}, 1,
            differs);
    refused({key(-0.9 * largest, 0), key(0, 0), key(0.9 * largest, 0)}, 2); // the track's length
    // A constant value is valid.
    for (const double value : {largest, -largest}) {
        const std::array keys{key(0, value, KeyKind::hold), key(1, 0, KeyKind::hold)};
        const auto compiled = compile<T>(keys);
        REQUIRE(compiled.status() == Status::ok);
        CHECK(compiled.value(T(0.5)) == T(value));
    }
    if (is_float) {
        for (const auto kind : {KeyKind::hold, KeyKind::linear}) {
            refused({key(0, 0, kind), key(1, 1e308, kind), key(2, 0, kind)}, 1);
            refused({key(0, 0, kind), key(1e308, 0, kind)}, 1);
        }
        refused({key(0, 0), key(1e-30, 1), key(1, 2)}, 0); // its cubic coefficient
    }
}

TEMPLATE_TEST_CASE("values that the scalar can represent stay finite between keys, or are rejected",
                   "[animate][track][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(100));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 101);
    auto keys = random_keys(random, kinds);
    const double scale = std::exp2(random.uniform(-1, 1) * std::numeric_limits<T>::max_exponent);
    const double pace = std::exp2(random.uniform(-0.4, 0.4) * std::numeric_limits<T>::max_exponent);
    for (Key& k : keys) {
        for (double* x : {&k.value, &k.in_handle[1], &k.out_handle[1]}) *x *= scale;
        for (double* x : {&k.time, &k.in_handle[0], &k.out_handle[0]}) *x *= pace;
        for (double* x : {&k.in_slope, &k.out_slope}) *x *= scale / pace;
    }
    TrackOptions options;
    options.tolerance = 1e-3 * scale;
    const auto compiled = compile<T>(keys, options);
    if (compiled.status() != Status::ok) {
        CHECK(compiled.status() == Status::value_not_finite);
        CHECK(std::fabs(std::log2(scale)) + 3 * std::fabs(std::log2(pace)) >
              0.9 * std::numeric_limits<T>::max_exponent);
        return;
    }
    const auto& curve = compiled.value.curve;
    for (int n = 0; n <= 200; ++n) {
        const T x = T(keys.front().time + (keys.back().time - keys.front().time) * n / 200);
        CHECK(std::isfinite(curve(x)));
        CHECK(std::isfinite(curve.derivative(x)));
    }
}

TEST_CASE("times that are equal in the scalar are rejected", "[animate][track][refused]") {
    const std::array keys{key(1e6, 0), key(1e6 + 1e-3, 1), key(1e6 + 2, 3)};
    CHECK(compile<double>(keys).status() == Status::ok);
    const auto compiled = compile<float>(keys);
    CHECK(compiled.status() == Status::keys_not_ascending);
    CHECK(compiled.report.culprit == 1);
}

TEST_CASE("knots that coincide in the scalar are omitted, and keys are still met", "[animate][track]") {
    std::array near{key(4096, 0, KeyKind::bezier), key(4096 + 4 * 0x1p-11, 1, KeyKind::bezier)};
    near[0].out_handle = {near[1].time, 3};
    near[1].in_handle = {near[0].time, -2};
    TrackOptions options;
    options.tolerance = 1e-3;
    const auto short_track = compile<float>(near, options);
    REQUIRE(short_track.status() == Status::ok);
    CHECK(short_track.value(float(near[0].time)) == Approx(0).epsilon(0).margin(1e-6));
    CHECK(short_track.value(float(near[1].time)) == Approx(1).epsilon(0).margin(1e-5));
    for (int n = 0; n <= 4; ++n) CHECK(std::isfinite(short_track.value(float(near[0].time + n * 0x1p-11))));
}

TEST_CASE("progress is reported every thousand keys and can cancel", "[animate][track]") {
    std::vector<Key> keys;
    for (int i = 0; i <= 2500; ++i) keys.push_back(key(i, i % 7));
    std::vector<double> told;
    std::size_t most = 100;
    cageform::Running running;
    running.progress = [&](double done) {
        told.push_back(done);
        return told.size() < most;
    };
    const auto compiled = compile<double>(keys, {}, running);
    REQUIRE(compiled.status() == Status::ok);
    CHECK(told == std::vector<double>{0, 0.4, 0.8, 1});
    CHECK(compiled.report.seconds >= 0);
    for (most = 1; most <= 4; ++most) {
        told.clear();
        const auto cancelled = compile<double>(keys, {}, running);
        CHECK(cancelled.status() == Status::cancelled);
        CHECK(cancelled.value.curve.empty());
        CHECK(told.size() == most);
    }
}

TEST_CASE("coupled pieces report progress within an interval and can be cancelled there",
          "[animate][track]") {
    std::array keys{key(0, 0, KeyKind::bezier), key(1, 1, KeyKind::bezier), key(2, 0)};
    for (Key& k : keys) {
        k.out_handle = {k.time + 0.9, k.value};
        k.in_handle = {k.time - 0.05, k.value};
    }
    TrackOptions options;
    options.tolerance = 1e-14; // unreachable: tries the maximum number of pieces
    options.fit.conditions = cageform::FitCondition::end_value | cageform::FitCondition::knot_c0;
    std::vector<double> told;
    cageform::Running running;
    running.progress = [&](double done) {
        told.push_back(done);
        return told.size() < 5;
    };
    const auto cancelled = compile<double>(keys, options, running);
    CHECK(cancelled.status() == Status::cancelled);
    CHECK(cancelled.report.culprit == 0);
    CHECK(cancelled.value.curve.empty());
    CHECK(told.size() == 5);
    CHECK(std::is_sorted(told.begin(), told.end()));
    CHECK(told.back() < 0.1); // of the first of two intervals
}

TEST_CASE("a track with a hold at its end cycles with the period of its keys", "[animate][track]") {
    const std::array keys{key(0, 1, KeyKind::hold), key(1, 2, KeyKind::hold), key(2, 3, KeyKind::hold)};
    TrackOptions options;
    options.before = options.after = Extrapolation::cycle;
    const auto compiled = compile<float>(keys, options);
    REQUIRE(compiled.status() == Status::ok);
    for (int turn = -1000; turn <= 1000; ++turn) {
        CHECK(compiled.value(float(2 * turn) + 0.5f) == 1);
        CHECK(compiled.value(float(2 * turn) + 1.0f) == 2);
        CHECK(compiled.value(float(2 * turn) + 1.5f) == 2);
        if (turn != 0 && turn != 1) CHECK(compiled.value(float(2 * turn)) == 1);
    }
}

} // namespace compile_track_tests

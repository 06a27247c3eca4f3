// Imported keys: the curves between them are those of the single-interval importers.
#include "catch.hpp"
#include "support/cages.hpp"
#include "support/effort.hpp"

#include <cageform/animate/compile.hpp>
#include <cageform/exchange/blender.hpp>
#include <cageform/exchange/css.hpp>
#include <cageform/exchange/gltf.hpp>
#include <cageform/exchange/lottie.hpp>
#include <cageform/exchange/unity.hpp>
#include <cageform/exchange/unreal.hpp>

namespace import_keys_tests {

using namespace cageform;
using cageform_tests::Random;

namespace {

constexpr std::size_t count = 9;

bool same_bits(const BezierCurve& a, const BezierCurve& b) {
    return std::memcmp(&a, &b, sizeof(a)) == 0;
}

/// interval(n) is the curve from key n to the next, imported separately.
template <class Interval>
void check_intervals(const cageform::Result<std::vector<Key>, cageform::ExchangeReport>& imported,
                     const Interval& interval, const std::vector<double>& values) {
    REQUIRE(imported.status() == Status::ok);
    REQUIRE(imported.value.size() == values.size());
    std::size_t held = 0, straight = 0, curved = 0;
    for (std::size_t n = 0; n < values.size(); ++n) {
        CAPTURE(n);
        CHECK(imported.value[n].value == values[n]);
        if (n + 1 == values.size()) continue;
        const auto curve = interval(n);
        REQUIRE(curve.status() == Status::ok);
        CHECK(imported.value[n].kind == curve.value.kind);
        held += curve.value.kind == KeyKind::hold ? 1u : 0u;
        straight += curve.value.kind == KeyKind::linear ? 1u : 0u;
        curved += curve.value.kind == KeyKind::bezier ? 1u : 0u;
        CHECK(imported.value[n].time == curve.value.curve.begin());
        if (curve.value.kind == KeyKind::bezier) {
            CHECK(same_bits(key_interval(imported.value, n), curve.value.curve));
        } else if (curve.value.kind == KeyKind::linear) {
            const auto line = key_interval(imported.value, n);
            for (std::size_t i = 0; i < 4; ++i) {
                for (std::size_t axis = 0; axis < 2; ++axis)
                    CHECK(line.points[i][axis] ==
                          Approx(curve.value.curve.points[i][axis]).epsilon(1e-15).margin(1e-15));
            }
        }
    }
    CHECK(held + straight + curved == values.size() - 1);
    // The second call compiles: the pieces follow the curves.
    TrackOptions options;
    options.tolerance = 1e-4;
    const auto track = compile<double>(imported.value, options);
    REQUIRE(track.status() == Status::ok);
    for (std::size_t n = 0; n + 1 < values.size(); ++n) {
        const auto curve = interval(n);
        const BezierFunction function(curve.value.curve);
        for (int k = 1; k < 20; ++k) {
            const double time = std::lerp(curve.value.curve.begin(), curve.value.curve.end(), k / 20.0);
            CHECK(std::fabs(track.value(time) - function(time)) <= 1.001e-4);
        }
    }
}

KeyKind random_kind(Random& random) {
    return std::array{KeyKind::hold, KeyKind::linear, KeyKind::bezier, KeyKind::bezier}[random.below(4)];
}

} // namespace

TEST_CASE("keys of Blender, Unity, Unreal, Lottie and CSS have the imported curves between them",
          "[animate][import][keys][property]") {
    const auto seed = GENERATE(seeds(cageform_tests::effort(60, 10)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    std::vector<double> times, values;
    double time = random.uniform(-3, 3);
    for (std::size_t n = 0; n < count; ++n, time += random.uniform(0.2, 2)) {
        times.push_back(time);
        values.push_back(random.uniform(-2, 2));
    }
    std::vector<BlenderKey> blender(count);
    std::vector<UnityKey> unity(count);
    std::vector<UnrealKey> unreal(count);
    std::vector<LottieKey> lottie(count);
    std::vector<CssKey> css(count);
    const std::array<std::string_view, 5> easings{
        "linear", "ease", "ease-in", "cubic-bezier(0.2, 1.5, 0.9, -1)", "cubic-bezier(1, 0, 0, 1)"};
    for (std::size_t n = 0; n < count; ++n) {
        blender[n].co = {times[n], values[n]};
        blender[n].handle_left = {times[n] - random.uniform(0, 2), random.uniform(-2, 2)};
        blender[n].handle_right = {times[n] + random.uniform(0, 2), random.uniform(-2, 2)};
        blender[n].interpolation = random_kind(random);
        unity[n] = {times[n],
                    values[n],
                    random.uniform(-3, 3),
                    random.uniform(-3, 3),
                    random.uniform(0, 1),
                    random.uniform(0, 1),
                    WeightedHandles(random.below(4))};
        if (random.below(4) == 0) unity[n].out_tangent = detail::infinite();
        unreal[n].time = times[n];
        unreal[n].value = values[n];
        unreal[n].arrive_tangent = random.uniform(-3, 3);
        unreal[n].leave_tangent = random.uniform(-3, 3);
        unreal[n].interpolation = random_kind(random);
        lottie[n] = {times[n],
                     values[n],
                     {{random.uniform(0, 1), random.uniform(-1, 2)},
                      {random.uniform(0, 1), random.uniform(-1, 2)},
                      random.below(3) == 0}};
        css[n] = {times[n], values[n], easings[random.below(5)]};
    }
    const auto place = [&](std::size_t n) { return Vec<double, 2>{times[n], values[n]}; };
    check_intervals(
        keys_from_blender(blender), [&](std::size_t n) { return from_blender(blender[n], blender[n + 1]); },
        values);
    check_intervals(
        keys_from_unity(unity), [&](std::size_t n) { return from_unity(unity[n], unity[n + 1]); }, values);
    check_intervals(
        keys_from_unreal(unreal), [&](std::size_t n) { return from_unreal(unreal[n], unreal[n + 1]); },
        values);
    check_intervals(
        keys_from_lottie(lottie),
        [&](std::size_t n) { return from_lottie(lottie[n].easing, place(n), place(n + 1)); }, values);
    check_intervals(
        keys_from_css(css),
        [&](std::size_t n) {
            const auto unit = parse_css_easing(css[n].easing).value.points;
            BezierCurve curve{{place(n), {}, {}, place(n + 1)}};
            for (const std::size_t i : {1u, 2u}) {
                for (std::size_t axis = 0; axis < 2; ++axis)
                    curve.points[i][axis] =
                        std::lerp(curve.points[0][axis], curve.points[3][axis], unit[i][axis]);
            }
            return cageform::Result<cageform::KeyInterval>{{KeyKind::bezier, curve}, Status::ok};
        },
        values);
}

TEST_CASE(
    "keys of glTF: the curves of CUBICSPLINE to the bit, straight lines, held values, compiled in one call",
    "[animate][import][keys][gltf][property]") {
    const auto seed = GENERATE(seeds(30));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 101);
    constexpr std::size_t components = 3;
    std::vector<float> times, cubic, plain;
    float time = float(random.uniform(0, 2));
    for (std::size_t k = 0; k < count; ++k, time += float(random.uniform(0.1, 1))) {
        times.push_back(time);
        for (std::size_t n = 0; n < 3 * components; ++n) cubic.push_back(float(random.uniform(-2, 2)));
        for (std::size_t n = 0; n < components; ++n) plain.push_back(float(random.uniform(-2, 2)));
    }
    const auto curves = from_gltf_cubicspline(times, cubic, components);
    const auto keys = keys_from_gltf(times, cubic, components, GltfInterpolation::cubicspline);
    REQUIRE(curves.status() == Status::ok);
    REQUIRE(keys.status() == Status::ok);
    REQUIRE(keys.value.size() == components);
    for (std::size_t k = 0; k + 1 < count; ++k) {
        for (std::size_t c = 0; c < components; ++c)
            CHECK(same_bits(key_interval(keys.value[c], k), curves.value[k * components + c]));
    }
    const auto clip = compile<double, 3>(keys.value);
    REQUIRE(clip.status() == Status::ok);
    auto cursor = clip.value.make_cursor();
    std::vector<Vec<double, 3>> pose(1);
    for (std::size_t k = 0; k + 1 < count; ++k) {
        const double at = std::lerp(double(times[k]), double(times[k + 1]), random.uniform(0.01, 0.99));
        clip.value.sample(at, cursor, pose);
        for (std::size_t c = 0; c < components; ++c)
            CHECK(pose[0][c] == Approx(BezierFunction(curves.value[k * components + c])(at)).margin(1e-12));
    }
    const auto lines = keys_from_gltf(times, plain, components, GltfInterpolation::linear),
               steps = keys_from_gltf(times, plain, components, GltfInterpolation::step);
    const auto by_lines = compile<double, 3>(lines.value), by_steps = compile<double, 3>(steps.value);
    REQUIRE(by_lines.status() == Status::ok);
    REQUIRE(by_steps.status() == Status::ok);
    auto first = by_lines.value.make_cursor(), second = by_steps.value.make_cursor();
    std::vector<Vec<double, 3>> other(1);
    for (std::size_t k = 0; k + 1 < count; ++k) {
        const double part = random.uniform(0.01, 0.99),
                     at = std::lerp(double(times[k]), double(times[k + 1]), part);
        by_lines.value.sample(at, first, pose);
        by_steps.value.sample(at, second, other);
        for (std::size_t c = 0; c < components; ++c) {
            const double begin = plain[k * components + c], end = plain[(k + 1) * components + c];
            CHECK(pose[0][c] == Approx(std::lerp(begin, end, part)).margin(1e-12));
            CHECK(other[0][c] == begin);
        }
    }
    // A single key is a constant.
    const auto one =
        keys_from_gltf(std::span(times).first(1), std::span(plain).first(3), 3, GltfInterpolation::linear);
    REQUIRE(one.status() == Status::ok);
    CHECK(compile<float, 3>(one.value).status() == Status::ok);

    const auto status = [&](std::span<const float> t, std::span<const float> v, std::size_t c, auto mode) {
        const auto result = keys_from_gltf(t, v, c, mode);
        CHECK(result.value.empty());
        return result.status();
    };
    CHECK(status({}, {}, 3, GltfInterpolation::linear) == Status::input_malformed);
    CHECK(status(times, plain, 3, GltfInterpolation::cubicspline) == Status::input_malformed);
    CHECK(status(times, plain, 0, GltfInterpolation::linear) == Status::input_malformed);
    plain[5] = std::numeric_limits<float>::infinity();
    CHECK(keys_from_gltf(times, plain, 3, GltfInterpolation::step).report.culprit == 1);
    CHECK(status(times, plain, 3, GltfInterpolation::step) == Status::value_not_finite);
    std::swap(times[3], times[4]);
    CHECK(status(times, cubic, 3, GltfInterpolation::cubicspline) == Status::keys_not_ascending);
}

TEST_CASE("keys without a curve are refused with the first key of the interval",
          "[animate][import][keys][refused]") {
    std::vector<UnityKey> unity(4);
    for (std::size_t n = 0; n < 4; ++n) unity[n].time = double(n);
    REQUIRE(keys_from_unity(unity).status() == Status::ok);
    unity[2].time = 1;
    const auto refused = keys_from_unity(unity);
    CHECK(refused.status() == Status::interval_empty);
    CHECK(refused.report.culprit == 1);
    CHECK(refused.value.empty());
    CHECK(keys_from_unity({}).status() == Status::keys_missing);
    CHECK(keys_from_unity(std::span(unity).first(1)).value.size() == 1);
    unity[0].value = std::numeric_limits<double>::infinity();
    CHECK(keys_from_unity(std::span(unity).first(1)).status() == Status::value_not_finite);

    const CssKey css[] = {{0, 1, "ease"}, {1, 2, "steps(3)"}, {2, 3, "not read"}};
    CHECK(keys_from_css(css).status() == Status::input_malformed);
    CHECK(keys_from_css(css).report.culprit == 1);
    CHECK(keys_from_css(std::span(css).first(2)).status() == Status::ok);
    std::vector<LottieKey> lottie{{0, 0, {{0, 0}, {1, 1}, true}},
                                  {1, std::numeric_limits<double>::infinity(), {}}};
    CHECK(keys_from_lottie(lottie).status() == Status::value_not_finite);
    CHECK(keys_from_lottie(lottie).report.culprit == 1);
}

} // namespace import_keys_tests

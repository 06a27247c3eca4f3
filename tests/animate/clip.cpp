// Poses of a clip: tracks and rigid motion.
#include "catch.hpp"
#include "support/allocations.hpp"
#include "support/cages.hpp"
#include "support/keys.hpp"
#include "support/larger.hpp"

#include <cageform/animate/compile.hpp>

namespace clip_tests {

using namespace cageform_tests;
using cageform::CageClip;
using cageform::compile;
using cageform::CubicPiece;
using cageform::epsilon;
using cageform::Extrapolation;
using cageform::Key;
using cageform::KeyKind;
using cageform::PiecewiseCubic;
using cageform::Quaternion;
using cageform::RigidMotion;
using cageform::slerp;
using cageform::Status;
using cageform::Track;

namespace {

template <class T>
Track<T> track_of(const std::vector<Key>& keys, Extrapolation mode = Extrapolation::constant) {
    cageform::TrackOptions options;
    options.before = options.after = mode;
    const auto compiled = compile<T>(keys, options);
    REQUIRE(compiled.status() == Status::ok);
    return compiled.value;
}

/// Automatic keys from 0 to 3 if `common`, else at random times in between.
template <class T>
std::vector<PiecewiseCubic<T>> random_curves(Random& random, std::size_t count, bool common) {
    std::vector<PiecewiseCubic<T>> curves;
    for (std::size_t k = 0; k < count; ++k) {
        std::vector<Key> keys;
        double time = common || k == 0 ? 0 : random.uniform(0, 0.8);
        while (time < 2.5) {
            keys.push_back(key(time, random.uniform(-2, 2)));
            time += random.uniform(0.1, 0.8);
        }
        keys.push_back(key(common || k == 0 ? 3 : random.uniform(2.6, 3), random.uniform(-2, 2)));
        curves.push_back(track_of<T>(keys).curve);
    }
    return curves;
}

template <std::size_t D>
using Pose = std::vector<Vec<double, D>>;

template <std::size_t D>
double distance(const Vec<double, D>& a, const Vec<double, D>& b) {
    return std::sqrt(dot(a - b, a - b));
}

template <std::size_t D>
double largest_difference(const Pose<D>& a, const Pose<D>& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = cageform_tests::larger(most, distance(a[i], b[i]));
    return most;
}

template <std::size_t D>
Pose<D> pose_of(const CageClip<double, D>& clip, double time) {
    auto cursor = clip.make_cursor();
    Pose<D> pose(clip.vertex_count());
    clip.sample(time, cursor, pose);
    return pose;
}

Quaternion<double> turn_about(Vec<double, 3> axis, double angle) {
    axis = (std::sin(angle / 2) / std::sqrt(dot(axis, axis))) * axis;
    return {axis[0], axis[1], axis[2], std::cos(angle / 2)};
}

/// v rotated about a unit axis (Rodrigues 1840).
Vec<double, 3> turned(const Vec<double, 3>& v, const Vec<double, 3>& axis, double angle) {
    return std::cos(angle) * v + std::sin(angle) * cross(axis, v) +
           ((1 - std::cos(angle)) * dot(axis, v)) * axis;
}

Vec<double, 3> random_axis(Random& random) {
    for (;;) {
        const Vec<double, 3> v{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        const double square = dot(v, v);
        if (square > 0.01 && square < 1) return (1 / std::sqrt(square)) * v;
    }
}

double length_of(const Quaternion<double>& q) {
    return std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

/// The angle between two rotations.
double angle_between(const Quaternion<double>& a, const Quaternion<double>& b) {
    // From the chord, which is accurate for small angles.
    double same = 0, opposite = 0;
    for (std::size_t k = 0; k < 4; ++k) {
        same += (a[k] - b[k]) * (a[k] - b[k]);
        opposite += (a[k] + b[k]) * (a[k] + b[k]);
    }
    return 4 * std::asin(std::min(1.0, std::sqrt(std::min(same, opposite)) / 2));
}

} // namespace

TEMPLATE_TEST_CASE("a pose has the values of the tracks", "[animate][clip][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(40));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    const auto test = [&](auto dimension, std::size_t vertices) {
        constexpr std::size_t D = dimension();
        const auto curves = random_curves<T>(random, D * vertices, seed % 2 == 0);
        const CageClip<T, D> clip(curves);
        REQUIRE(clip.vertex_count() == vertices);
        CHECK(clip.begin() == 0);
        CHECK(clip.end() == 3);
        auto cursor = clip.make_cursor();
        std::vector<Vec<T, D>> pose(vertices + 1);
        for (int n = 0; n < 100; ++n) {
            const T time = n % 10 == 0 ? curves[random.below(curves.size())].pieces().back().begin
                                       : T(random.uniform(-1, 4));
            pose.back() = Vec<T, D>{};
            clip.sample(time, cursor, pose);
            bool same = pose.back() == Vec<T, D>{};
            for (std::size_t i = 0; i < vertices; ++i) {
                for (std::size_t k = 0; k < D; ++k)
                    same = same && std::fabs(pose[i][k] - curves[i * D + k](time)) <= 100 * epsilon<T>;
            }
            CAPTURE(time);
            REQUIRE(same);
        }
    };
    for (const std::size_t vertices : std::array<std::size_t, 3>{1, 4, 25}) {
        test(std::integral_constant<std::size_t, 2>{}, vertices);
        test(std::integral_constant<std::size_t, 3>{}, vertices);
    }
}

TEMPLATE_TEST_CASE("the curves of a compiled clip are those of the tracks, for any parallel loop",
                   "[animate][clip][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    Random random(17);
    std::vector<std::vector<Key>> keys(3 * 7);
    for (auto& of_curve : keys) {
        for (int n = 0; n < 5; ++n)
            of_curve.push_back(key(n + random.uniform(0, 0.5), random.uniform(-2, 2)));
    }
    cageform::TrackOptions options;
    options.before = Extrapolation::linear;
    options.after = Extrapolation::ping_pong;
    double told = 0, sup_error = 0;
    cageform::Running running;
    running.parallel = [](std::size_t count, std::size_t, const auto& body) { // in reverse order
        for (std::size_t k = count; k > 0; --k) body(k - 1, k);
    };
    running.progress = [&](double done) { return (told = done) <= 1; };
    const auto compiled = cageform::compile<T, 3>(keys, options, running);
    REQUIRE(compiled.status() == Status::ok);
    CHECK(told == 1);
    std::vector<PiecewiseCubic<T>> curves;
    for (const auto& of_curve : keys) {
        const auto track = compile<T>(of_curve, options);
        sup_error = cageform_tests::larger(sup_error, track.report.sup_error);
        curves.push_back(track.value.curve);
    }
    CHECK(compiled.report.sup_error == sup_error);
    const CageClip<T, 3> expected(curves, options.before, options.after);
    REQUIRE(compiled.value.vertex_count() == 7);
    auto cursor = compiled.value.make_cursor(), other = expected.make_cursor();
    std::vector<Vec<T, 3>> pose(7), same(7);
    for (int n = 0; n < 100; ++n) {
        const T time = T(random.uniform(-3, 12));
        compiled.value.sample(time, cursor, pose);
        expected.sample(time, other, same);
        REQUIRE(pose == same);
    }
}

TEST_CASE("the default tolerance of a clip scales with its size, a given one does not",
          "[animate][clip][property]") {
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    std::vector<std::vector<Key>> keys(2 * 3);
    Vec<double, 2> lower{1e9, 1e9}, upper{-1e9, -1e9};
    for (std::size_t k = 0; k < keys.size(); ++k) {
        for (int n = 0; n < 4; ++n) {
            Key at = key(n, random.uniform(-1, 1), KeyKind::bezier);
            at.in_handle = {n - 0.3 * random.uniform(0.2, 1), random.uniform(-1, 1)};
            at.out_handle = {n + 0.3 * random.uniform(0.2, 1), random.uniform(-1, 1)};
            lower[k % 2] = std::min(lower[k % 2], at.value);
            upper[k % 2] = std::max(upper[k % 2], at.value);
            keys[k].push_back(at);
        }
    }
    const double diagonal = distance(lower, upper);
    const auto compiled = cageform::compile<double, 2>(keys);
    REQUIRE(compiled.status() == Status::ok);
    CHECK(compiled.report.sup_error <= cageform::screen_tolerance * diagonal * (1 + 1e-12));
    CHECK(compiled.report.sup_error > 0);
    for (const double unit : {0x1p-20, 0x1p20}) { // in another unit
        CAPTURE(unit);
        auto scaled = keys;
        for (auto& of_curve : scaled) {
            for (Key& at : of_curve) {
                for (double* x : {&at.value, &at.in_handle[1], &at.out_handle[1]}) *x *= unit;
            }
        }
        const auto again = cageform::compile<double, 2>(scaled);
        REQUIRE(again.status() == Status::ok);
        CHECK(again.report.sup_error == Approx(unit * compiled.report.sup_error).epsilon(1e-9));
        for (int n = 0; n <= 30; ++n) {
            const auto pose = pose_of(compiled.value, 0.1 * n);
            auto other = pose_of(again.value, 0.1 * n);
            for (auto& p : other) p = (1 / unit) * p;
            CHECK(largest_difference(pose, other) <= 1e-9);
        }
        const auto given = cageform::compile<double, 2>(scaled, {.tolerance = 1e-2 * unit});
        REQUIRE(given.status() == Status::ok);
        CHECK(given.report.sup_error <= 1e-2 * unit);
    }
    // A point at rest has size 0.
    CHECK(cageform::compile<double, 2>(std::vector<std::vector<Key>>(2, {key(0, 3), key(1, 3)})).status() ==
          Status::ok);
}

TEST_CASE("invalid key frames are rejected with the curve and the key", "[animate][clip][refused]") {
    std::vector<std::vector<Key>> keys(6, {key(0, 1), key(1, 2), key(2, 0)});
    REQUIRE(cageform::compile<double, 3>(keys).status() == Status::ok);
    REQUIRE(cageform::compile<double, 2>(keys).value.vertex_count() == 3);
    CHECK(cageform::compile<float, 2>(std::vector<std::vector<Key>>{}).status() == Status::ok);
    CHECK(cageform::compile<float, 2>(std::span(keys).first(5)).status() == Status::input_malformed);
    keys[5].clear();
    keys[3][2].time = 0.5;
    const auto refused = cageform::compile<double, 3>(keys);
    CHECK(refused.status() == Status::keys_not_ascending);
    CHECK(refused.report.curve == 3);
    CHECK(refused.report.culprit == 2);
    CHECK(refused.value.vertex_count() == 0);
    cageform::Running running;
    running.progress = [](double) { return false; };
    CHECK(cageform::compile<double, 3>(keys, {}, running).status() == Status::cancelled);
}

TEST_CASE("a clip is extrapolated as a whole", "[animate][clip][property]") {
    using enum Extrapolation;
    const auto seed = GENERATE(seeds(40));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 101);
    const auto curves = random_curves<double>(random, 24, seed % 2 == 0);
    const auto with = [&](Extrapolation mode) { return CageClip<double, 3>(curves, mode, mode); };
    const auto held = with(constant);
    const auto first = pose_of(held, 0), last = pose_of(held, 3);
    for (int n = 0; n < 20; ++n) {
        const double part = random.uniform(0.001, 2.999), turn = double(random.below(11)) - 5;
        const auto inside = pose_of(held, part);
        for (const auto mode : {linear, cycle, cycle_with_offset, ping_pong})
            CHECK(largest_difference(pose_of(with(mode), part), inside) <= 1e-13);
        CHECK(largest_difference(pose_of(held, -part), first) <= 1e-13);
        CHECK(largest_difference(pose_of(held, 3 + part), last) <= 1e-13);
        CHECK(largest_difference(pose_of(with(cycle), part + 3 * turn), inside) <= 1e-11);
        auto raised = inside;
        for (std::size_t i = 0; i < raised.size(); ++i) raised[i] = raised[i] + turn * (last[i] - first[i]);
        CHECK(largest_difference(pose_of(with(cycle_with_offset), part + 3 * turn), raised) <= 1e-11);
        CHECK(largest_difference(pose_of(with(ping_pong), part + 6 * turn), inside) <= 1e-11);
        CHECK(largest_difference(pose_of(with(ping_pong), -part - 6 * turn), inside) <= 1e-11);
        // Linear for curves that end with the clip.
        const auto before = pose_of(with(linear), -part), after = pose_of(with(linear), 3 + part);
        for (std::size_t k = 0; k < 24; ++k) {
            const auto& curve = curves[k];
            const double falls = curve.begin() == 0 ? curve.derivative(0) : 0;
            const double rises = curve.end() == 3 ? curve.derivative(3) : 0;
            CHECK(before[k / 3][k % 3] ==
                  Approx(first[k / 3][k % 3] - part * falls).epsilon(0).margin(1e-10));
            CHECK(after[k / 3][k % 3] == Approx(last[k / 3][k % 3] + part * rises).epsilon(0).margin(1e-10));
        }
    }
    // Different extrapolations at the ends.
    const CageClip<double, 3> mixed(curves, ping_pong, constant);
    CHECK(largest_difference(pose_of(mixed, -1.25), pose_of(held, 1.25)) <= 1e-11);
    CHECK(largest_difference(pose_of(mixed, 4), last) <= 1e-13);
}

TEST_CASE("a curve that ends with a hold does not affect the others", "[animate][clip]") {
    // x continues linearly; y jumps at its last key.
    const std::vector<Key> line{key(0, 0, KeyKind::linear), key(2, 4, KeyKind::linear)};
    const std::vector<Key> jump{key(0, 1, KeyKind::hold), key(2, 5)};
    const std::array curves{track_of<double>(line).curve, track_of<double>(jump).curve};
    const CageClip<double, 2> clip(curves, Extrapolation::linear, Extrapolation::linear);
    CHECK(distance(pose_of(clip, 1)[0], {2, 1}) <= 1e-14);
    CHECK(pose_of(clip, 3)[0][0] == Approx(6));
    CHECK(pose_of(clip, 3)[0][1] == 5);
    CHECK(distance(pose_of(clip, -1)[0], {-2, 1}) <= 1e-14);
}

TEST_CASE("cursors are independent of each other and of their history", "[animate][clip][property]") {
    Random random(7);
    const auto curves = random_curves<double>(random, 50, false);
    const CageClip<double, 2> clip(curves, Extrapolation::cycle, Extrapolation::cycle);
    auto first = clip.make_cursor(), second = clip.make_cursor();
    Pose<2> a(25), b(25);
    for (int n = 0; n < 300; ++n) {
        const double x = n / 60.0, y = random.uniform(-10, 10);
        clip.sample(x, first, a);
        clip.sample(y, second, b);
        CHECK(largest_difference(a, pose_of(clip, x)) <= 1e-13);
        CHECK(largest_difference(b, pose_of(clip, y)) <= 1e-13);
    }
}

TEST_CASE("a clip without curves has no vertices", "[animate][clip]") {
    const CageClip<float, 3> clip;
    auto cursor = clip.make_cursor();
    clip.sample(1, cursor, {});
    CHECK(clip.vertex_count() == 0);
    const CageClip<float, 2> none(std::span<const PiecewiseCubic<float>>{});
    CHECK(none.vertex_count() == 0);
}

TEST_CASE("a 2D rotation preserves distances and rotates about the pivot by the angle",
          "[animate][clip][rigid][property]") {
    const auto seed = GENERATE(seeds(40));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 201);
    const auto curves = random_curves<double>(random, 12, true);
    const CageClip<double, 2> still(curves);
    CageClip<double, 2> clip(curves);
    RigidMotion<double, 2> motion;
    motion.pivot = {random.uniform(-3, 3), random.uniform(-3, 3)};
    const double rate = random.uniform(-9, 9);
    motion.angle =
        track_of<double>({key(0, 0.5, KeyKind::linear), key(3, 0.5 + 3 * rate)}, Extrapolation::linear);
    if (seed % 2 == 0) {
        motion.translation[0] = track_of<double>({key(0, 1), key(1, -2), key(2, 4)}, Extrapolation::cycle);
        motion.translation[1] = track_of<double>({key(0, -1), key(3, 7)});
    }
    clip.set_rigid_motion(motion);
    for (int n = 0; n < 50; ++n) {
        const double time = random.uniform(-1, 5);
        const auto rest = pose_of(still, time), pose = pose_of(clip, time);
        Vec<double, 2> to = motion.pivot;
        if (seed % 2 == 0) to = to + Vec<double, 2>{motion.translation[0](time), motion.translation[1](time)};
        const double angle = 0.5 + rate * time;
        for (std::size_t i = 0; i < 6; ++i) {
            const auto from = rest[i] - motion.pivot;
            // Counter-clockwise with y up.
            const Vec<double, 2> expected{to[0] + std::cos(angle) * from[0] - std::sin(angle) * from[1],
                                          to[1] + std::sin(angle) * from[0] + std::cos(angle) * from[1]};
            CHECK(distance(pose[i], expected) <= 1e-12);
            for (std::size_t j = 0; j < i; ++j)
                CHECK(distance(pose[i], pose[j]) ==
                      Approx(distance(rest[i], rest[j])).epsilon(0).margin(1e-14 * 10));
        }
    }
}

TEST_CASE("a cage keeps its size halfway between rotated poses", "[animate][clip][rigid]") {
    // Interpolating the vertices would shrink it.
    std::vector<PiecewiseCubic<double>> curves;
    for (const double x : {-1.0, 0.0, 1.0, 0.0})
        curves.push_back(track_of<double>({key(0, x), key(1, x)}).curve);
    CageClip<double, 2> clip(curves);
    RigidMotion<double, 2> motion;
    motion.angle = track_of<double>({key(0, 0), key(1, std::numbers::pi)});
    clip.set_rigid_motion(motion);
    const auto middle = pose_of(clip, 0.5);
    CHECK(distance(middle[0], {0, -1}) <= 1e-15);
    CHECK(distance(middle[1], {0, 1}) <= 1e-15);
}

TEST_CASE("3D rotations at keys, between and outside them", "[animate][clip][rigid][property]") {
    const auto seed = GENERATE(seeds(60));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 301);
    const auto curves = random_curves<double>(random, 18, true);
    const CageClip<double, 3> still(curves);
    CageClip<double, 3> clip(curves);
    RigidMotion<double, 3> motion;
    motion.pivot = {random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)};
    // All about one axis, less than half a turn per key, so that values in between are known.
    const auto axis = random_axis(random);
    std::vector<double> angles{random.uniform(-3, 3)};
    const std::size_t keys = 1 + random.below(5);
    while (angles.size() < keys) angles.push_back(angles.back() + random.uniform(-3.1, 3.1));
    for (const double angle : angles) {
        auto q = turn_about(axis, angle);
        if (random.below(2) == 0) { // the same rotation
            for (double& x : q) x = -x;
        }
        motion.rotations.push_back(q);
    }
    const double last = double(keys - 1);
    motion.phase = track_of<double>({key(0, 0, KeyKind::linear), key(3, last)}, Extrapolation::linear);
    if (seed % 2 == 0)
        motion.translation[2] = track_of<double>({key(0, 0), key(3, 5)}, Extrapolation::cycle_with_offset);
    clip.set_rigid_motion(motion);
    for (int n = 0; n < 40; ++n) {
        const double time = n < 6 ? 3 * double(n % 5) / std::max(1.0, last) : random.uniform(-1, 4);
        const double phase = std::clamp(motion.phase(time), 0.0, last);
        const std::size_t from = std::min(std::size_t(phase), keys - 1), to = std::min(from + 1, keys - 1);
        const double angle = angles[from] + (phase - double(from)) * (angles[to] - angles[from]);
        const auto rest = pose_of(still, time), pose = pose_of(clip, time);
        const Vec<double, 3> shift{0, 0, seed % 2 == 0 ? motion.translation[2](time) : 0};
        for (std::size_t i = 0; i < 6; ++i) {
            const auto expected = motion.pivot + shift + turned(rest[i] - motion.pivot, axis, angle);
            // Where the arc is interpolated linearly, the speed is only nearly constant.
            CHECK(distance(pose[i], expected) <= 1e-5);
            for (std::size_t j = 0; j < i; ++j)
                CHECK(distance(pose[i], pose[j]) ==
                      Approx(distance(rest[i], rest[j])).epsilon(0).margin(1e-13));
        }
    }
}

TEST_CASE("a 3D motion without rotations, or without a phase", "[animate][clip][rigid]") {
    Random random(11);
    const auto curves = random_curves<double>(random, 9, true);
    const CageClip<double, 3> still(curves);
    CageClip<double, 3> clip(curves);
    RigidMotion<double, 3> motion;
    motion.translation[1] = track_of<double>({key(0, 2)});
    clip.set_rigid_motion(motion);
    auto expected = pose_of(still, 1.5);
    for (auto& p : expected) p[1] += 2;
    CHECK(largest_difference(pose_of(clip, 1.5), expected) <= 1e-14);
    motion.rotations = {turn_about({0, 0, 1}, std::numbers::pi / 2), turn_about({0, 0, 1}, 3)};
    clip.set_rigid_motion(motion); // at the first rotation
    expected = pose_of(still, 1.5);
    for (auto& p : expected) p = {-p[1], p[0] + 2, p[2]};
    CHECK(largest_difference(pose_of(clip, 1.5), expected) <= 1e-14);
}

TEST_CASE("slerp has unit length and constant speed, along the shorter arc", "[animate][slerp][property]") {
    const auto seed = GENERATE(seeds(200));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 401);
    // Angles from nearly 0 to half a turn.
    const double angle = seed % 2 == 0 ? random.uniform(0.01, 3.14) : std::pow(10.0, random.uniform(-6, 0));
    const auto a = turn_about(random_axis(random), random.uniform(-3, 3));
    const auto step = turn_about(random_axis(random), angle);
    // a · step
    Quaternion<double> b{a[3] * step[0] + a[0] * step[3] + a[1] * step[2] - a[2] * step[1],
                         a[3] * step[1] - a[0] * step[2] + a[1] * step[3] + a[2] * step[0],
                         a[3] * step[2] + a[0] * step[1] - a[1] * step[0] + a[2] * step[3],
                         a[3] * step[3] - a[0] * step[0] - a[1] * step[1] - a[2] * step[2]};
    REQUIRE(angle_between(a, b) == Approx(angle).epsilon(1e-6));
    if (random.below(2) == 0) {
        for (double& x : b) x = -x;
    }
    CHECK(angle_between(slerp(a, b, 0.0), a) <= 1e-7);
    CHECK(angle_between(slerp(a, b, 1.0), b) <= 1e-7);
    auto before = slerp(a, b, 0.0);
    constexpr int steps = 16;
    for (int n = 1; n <= steps; ++n) {
        const auto q = slerp(a, b, double(n) / steps);
        CHECK(length_of(q) == Approx(1).epsilon(1e-15));
        CHECK(angle_between(a, q) == Approx(angle * n / steps).epsilon(0).margin(2e-6));
        CHECK(angle_between(before, q) == Approx(angle / steps).epsilon(2e-4).margin(1e-9));
        before = q;
    }
    // In float too.
    const auto narrow = [](const Quaternion<double>& q) {
        return Quaternion<float>{float(q[0]), float(q[1]), float(q[2]), float(q[3])};
    };
    const auto half = slerp(narrow(a), narrow(b), 0.5f);
    const auto exact = slerp(a, b, 0.5);
    for (std::size_t k = 0; k < 4; ++k) CHECK(double(half[k]) == Approx(exact[k]).epsilon(0).margin(1e-6));
}

TEST_CASE("slerp of opposite and equal rotations", "[animate][slerp]") {
    const Quaternion<double> none{0, 0, 0, 1}, same{0, 0, 0, -1}, half_turn{1, 0, 0, 0};
    CHECK(slerp(none, none, 0.3) == none);
    CHECK(slerp(none, same, 0.3) == none);
    const auto quarter = slerp(none, half_turn, 0.5);
    CHECK(quarter[0] == Approx(std::sqrt(0.5)));
    CHECK(quarter[3] == Approx(std::sqrt(0.5)));
}

TEST_CASE("playing a clip does not allocate", "[animate][clip][allocations]") {
    Random random(5);
    const auto curves = random_curves<float>(random, 72, false);
    const auto test = [&](auto dimension) {
        constexpr std::size_t D = dimension();
        CageClip<float, D> clip(curves, Extrapolation::cycle, Extrapolation::linear);
        RigidMotion<float, D> motion;
        motion.angle = track_of<float>({key(0, 0), key(1, 2)}, Extrapolation::cycle_with_offset);
        motion.rotations = {{0, 0, 0, 1}, {1, 0, 0, 0}};
        motion.phase = motion.angle;
        motion.translation[0] = motion.angle;
        clip.set_rigid_motion(motion);
        auto cursor = clip.make_cursor();
        std::vector<Vec<float, D>> pose(clip.vertex_count());
        const std::size_t before = allocations;
        for (int n = -300; n < 600; ++n) clip.sample(float(n) / 60, cursor, pose);
        for (const float time : {7.0f, -5.0f, 1.0f, 2.9f, 0.1f}) clip.sample(time, cursor, pose);
        const std::size_t after = allocations;
        CHECK(after == before);
        CHECK(noexcept(clip.sample(1.0f, cursor, pose)));
    };
    test(std::integral_constant<std::size_t, 2>{});
    test(std::integral_constant<std::size_t, 3>{});
    // The counter works: a new-expression might be optimised away.
    const std::size_t before = allocations;
    void* const something = ::operator new(8);
    const std::size_t after = allocations;
    ::operator delete(something);
    CHECK(after == before + 1);
}

} // namespace clip_tests

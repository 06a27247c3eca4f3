// Laws of fitted skeletons: rigid motions, planted skeletons, weights, threads, hierarchy, keys, invalid input,
// and degenerate figures.
#include "../support/effort.hpp"
#include "../support/progress.hpp"
#include "../support/weights.hpp"

#include <cageform/skeleton/detail/skeleton_search.hpp>
#include <cageform/skeleton/fit_skeleton.hpp>

namespace fit_skeleton_tests {

using namespace cageform_tests;
using cageform::BoneKind;
using cageform::FittedSkeleton;
using cageform::SkeletonOptions;
using cageform::Vec;

namespace {

using V = Vec<double, 3>;
using Map = FittedSkeleton<double>::Map;
using Face = std::array<std::uint32_t, 3>;

struct Sequence {
    std::vector<V> rest;
    std::vector<std::vector<V>> frames;
    std::vector<Face> faces;

    auto fit(const SkeletonOptions& options, const Running& running = {}) const {
        return cageform::fit_skeleton(rest, frames, faces, options, running);
    }
    double size() const { return cageform::bounds_of(std::span<const V>(rest)).diagonal(); }
};

/// An open tube along x.
Sequence tube(std::size_t rings, std::size_t around) {
    Sequence result;
    for (std::size_t r = 0; r < rings; ++r) {
        for (std::size_t a = 0; a < around; ++a) {
            const double angle = 6.283185307179586 * double(a) / double(around);
            result.rest.push_back(
                {6.0 * double(r) / double(rings - 1), std::cos(angle), 0.7 * std::sin(angle)});
            const auto at = [&](std::size_t ring, std::size_t n) {
                return std::uint32_t(ring * around + n % around);
            };
            if (r + 1 == rings) continue;
            result.faces.push_back({at(r, a), at(r + 1, a), at(r + 1, a + 1)});
            result.faces.push_back({at(r, a), at(r + 1, a + 1), at(r, a + 1)});
        }
    }
    return result;
}

Map rotation(V axis, double angle) {
    axis = (1 / std::sqrt(dot(axis, axis))) * axis;
    Map map;
    for (std::size_t c = 0; c < 3; ++c) {
        V unit{};
        unit[c] = 1;
        map.axes[c] = std::cos(angle) * unit + std::sin(angle) * cross(axis, unit) +
                      (1 - std::cos(angle)) * axis[c] * axis;
    }
    return map;
}
V random_vector(Random& random, double reach) {
    return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
}
Map random_motion(Random& random, double angle, double shift) {
    Map map = rotation(random_vector(random, 1), random.uniform(-angle, angle));
    map.shift = random_vector(random, shift);
    return map;
}

/// Bones along the tube with random rotations and shifts, and two smooth weights per vertex.
Sequence planted(std::size_t bones, std::size_t frames, std::uint64_t seed) {
    Random random(seed);
    Sequence result = tube(24, 12);
    for (std::size_t t = 0; t < frames; ++t) {
        std::vector<Map> maps;
        for (std::size_t j = 0; j < bones; ++j) maps.push_back(random_motion(random, 0.6, 0.2));
        std::vector<V> frame;
        for (const V& v : result.rest) {
            const double along = v[0] / 6 * double(bones - 1);
            const auto j = (std::min)(std::size_t(along), bones - 2);
            const double share = along - double(j), w = share * share * (3 - 2 * share);
            frame.push_back((1 - w) * maps[j](v) + w * maps[j + 1](v));
        }
        result.frames.push_back(frame);
    }
    return result;
}

void check_skin(const FittedSkeleton<double>& skeleton, std::size_t vertices, std::size_t influences) {
    REQUIRE(skeleton.skin.influences == influences);
    REQUIRE(skeleton.skin.weights.size() == vertices * influences);
    REQUIRE(skeleton.maps.size() == skeleton.frames * skeleton.bones);
    for (std::size_t i = 0; i < vertices; ++i) {
        double sum = 0;
        for (std::size_t k = i * influences; k < (i + 1) * influences; ++k) {
            sum += double(skeleton.skin.weights[k]);
            REQUIRE(skeleton.skin.weights[k] >= 0);
            REQUIRE(skeleton.skin.joints[k] < skeleton.bones);
            REQUIRE((k == i * influences || skeleton.skin.weights[k] <= skeleton.skin.weights[k - 1]));
        }
        REQUIRE(std::fabs(sum - 1) <= 1e-7);
    }
}
void check_finite(const FittedSkeleton<double>& skeleton) {
    for (const Map& map : skeleton.maps) {
        for (const V& v : {map.axes[0], map.axes[1], map.axes[2], map.shift})
            REQUIRE(std::isfinite(dot(v, v)));
    }
    for (const V& v : skeleton.joints) REQUIRE(std::isfinite(dot(v, v)));
}
std::vector<double> times_of(std::size_t frames) {
    std::vector<double> times;
    for (std::size_t t = 0; t < frames; ++t) times.push_back(double(t) / 30);
    return times;
}
double distance(const V& a, const V& b) {
    return std::sqrt(dot(a - b, a - b));
}

} // namespace

TEST_CASE("one bone reproduces a rigid motion, for any angle and far away", "[skeleton]") {
    const int seed = GENERATE(seeds(6));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    Sequence given = tube(12, 9);
    std::vector<Map> maps;
    for (std::size_t t = 0; t < 11; ++t) {
        maps.push_back(random_motion(random, 3.14, 50));
        given.frames.emplace_back();
        for (const V& v : given.rest) given.frames.back().push_back(maps[t](v));
    }
    for (const BoneKind kind : {BoneKind::rigid, BoneKind::similar, BoneKind::stretched}) {
        const auto [skeleton, report] = given.fit({.bones = 1, .kind = kind});
        REQUIRE(report.status == Status::ok);
        CHECK(report.bones == 1);
        CHECK(report.max_distance <= 1e-8);
        CHECK(report.turn <= 1e-5);
        for (std::size_t t = 0; t < maps.size(); ++t) {
            for (std::size_t c = 0; c < 3; ++c)
                CHECK(distance(skeleton.map(t, 0).axes[c], maps[t].axes[c]) <= 1e-7);
        }
    }
}

TEST_CASE("each kind of bone reproduces its motions: rigid, similar, affine", "[skeleton]") {
    const int seed = GENERATE(seeds(4));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 10);
    const double factor = random.uniform(0.5, 2);
    const auto moved = [&](bool affine) {
        Sequence given = tube(12, 9);
        for (std::size_t t = 0; t < 9; ++t) {
            Map map = random_motion(random, 1, 3);
            for (V& axis : map.axes) axis = factor * axis + random_vector(random, affine ? 0.3 : 0);
            given.frames.emplace_back();
            for (const V& v : given.rest) given.frames.back().push_back(map(v));
        }
        return given;
    };
    const auto largest = [](const Sequence& given, BoneKind kind) {
        const auto [skeleton, report] = given.fit({.bones = 1, .kind = kind});
        REQUIRE(report.status == Status::ok);
        for (const Map& map : skeleton.maps) {
            const double square = dot(map.axes[0], map.axes[0]);
            for (std::size_t c = 0; c < 3 && kind != BoneKind::stretched; ++c) {
                CHECK(std::fabs(dot(map.axes[c], map.axes[c]) - square) <= 1e-9);
                CHECK(std::fabs(dot(map.axes[c], map.axes[(c + 1) % 3])) <= 1e-9);
            }
            if (kind == BoneKind::rigid) CHECK(std::fabs(square - 1) <= 1e-9);
            CHECK(dot(cross(map.axes[0], map.axes[1]), map.axes[2]) > 0);
        }
        return report.max_distance;
    };
    const Sequence scaled = moved(false), affine = moved(true);
    CHECK(largest(scaled, BoneKind::similar) <= 2e-4); // regularisation slightly reduces the scale
    CHECK(largest(affine, BoneKind::stretched) <= 2e-3);
    CHECK(largest(affine, BoneKind::rigid) > 1e-2);
}

TEST_CASE("planted skeletons are recovered, and more rounds, weights and bones lower the error",
          "[skeleton]") {
    const int seed = GENERATE(seeds(effort(6, 1)));
    CAPTURE(seed);
    const Sequence given = planted(4, 20, std::uint64_t(seed) + 100);
    const auto rms = [&](const SkeletonOptions& options) {
        const auto [skeleton, report] = given.fit(options);
        REQUIRE(report.status == Status::ok);
        check_skin(skeleton, given.rest.size(), options.influences);
        CHECK(report.mean_influences <= double(options.influences));
        CHECK(report.mean_influences >= 1);
        CHECK(report.max_distance >= report.rms);
        return report.rms;
    };
    const double found = rms({.bones = 4, .rounds = 20, .moves = 8});
    CHECK(found <= 2e-3);
    CHECK(rms({.bones = 4, .rounds = 1, .moves = 0}) >= found);
    CHECK(rms({.bones = 4, .rounds = 40, .moves = 8}) <= found);
    const double one = rms({.bones = 6, .influences = 1}), two = rms({.bones = 6, .influences = 2});
    CHECK(two <= one);
    CHECK(rms({.bones = 6, .influences = 8}) <= one);
    CHECK(rms({.bones = 2}) >= found);
    CHECK(rms({.bones = 6, .kind = BoneKind::stretched}) <= 2e-3);
}

TEST_CASE("the report matches the skeleton", "[skeleton]") {
    const Sequence given = planted(4, 12, 7);
    const auto [skeleton, report] = given.fit({.bones = 3, .max_distance = 0.02});
    REQUIRE(report.status == Status::ok);
    double largest = 0, sum = 0;
    std::size_t beyond = 0;
    for (std::size_t i = 0; i < given.rest.size(); ++i) {
        double own = 0;
        for (std::size_t t = 0; t < given.frames.size(); ++t) {
            const double d = distance(skeleton.place(t, i, given.rest[i]), given.frames[t][i]) / given.size();
            own = (std::max)(own, d);
            sum += d * d;
        }
        largest = (std::max)(largest, own);
        beyond += own > 0.02 ? 1 : 0;
    }
    CHECK(std::fabs(report.max_distance - largest) <= 1e-12);
    CHECK(std::fabs(report.rms - std::sqrt(sum / double(given.rest.size() * given.frames.size()))) <= 1e-12);
    CHECK(report.beyond == beyond);
    CHECK(std::fabs(distance(skeleton.place(report.frame, report.vertex, given.rest[report.vertex]),
                             given.frames[report.frame][report.vertex]) /
                        given.size() -
                    largest) <= 1e-12);
    CHECK(report.seconds > 0);
}

TEST_CASE("by distance, the number of bones is sufficient", "[skeleton]") {
    const Sequence given = planted(5, 10, 3);
    const SkeletonOptions strict{.max_distance = 0.01, .rounds = 6, .moves = 4};
    const auto [skeleton, report] = given.fit(strict);
    REQUIRE(report.status == Status::ok);
    CHECK(report.max_distance <= 0.01);
    CHECK(report.beyond == 0);
    CHECK(report.bones > 2);
    const auto loose = given.fit({.max_distance = 0.08, .rounds = 6, .moves = 4});
    CHECK(loose.report.bones < report.bones);
    // An unreachable distance: the closest fit is returned, and the report counts the vertices beyond.
    Sequence torn = tube(4, 6);
    Random random(5);
    for (int t = 0; t < 9; ++t) {
        torn.frames.push_back(torn.rest);
        for (V& v : torn.frames.back()) v = random_vector(random, 3);
    }
    const auto never = torn.fit({.max_distance = 1e-6});
    REQUIRE(never.report.status == Status::ok);
    CHECK(never.report.beyond > 0);
    CHECK(never.report.bones >= 1);
    check_finite(never.value);
}

TEST_CASE("the smallest number of bones tried within the distance is returned", "[skeleton]") {
    const int seed = GENERATE(seeds(effort(6, 2)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 700);
    const Sequence given =
        planted(3 + std::size_t(random.uniform(0, 4)), 9, std::uint64_t(seed) + std::uint64_t(800));
    const double most = std::exp(random.uniform(std::log(0.002), std::log(0.08)));
    CAPTURE(most);
    const SkeletonOptions options{.max_distance = most, .rounds = 6, .moves = 4};
    const auto [skeleton, report] = given.fit(options);
    REQUIRE(report.status == Status::ok);
    check_skin(skeleton, given.rest.size(), options.influences);
    check_finite(skeleton);
    REQUIRE(report.max_distance <= most);
    CHECK(report.beyond == 0);

    cageform::detail::Motion motion;
    cageform::SkeletonReport read;
    REQUIRE(cageform::detail::read_motion(given.rest, given.frames, given.faces, motion, read) == Status::ok);
    motion.prepare();
    const Running alone;
    cageform::detail::SkeletonSearch search(motion, options, alone);
    const auto largest = [&](const cageform::detail::BoneFit& fit) {
        double square = 0;
        for (const double x : fit.largest_squares(alone)) square = (std::max)(square, x);
        return std::sqrt(square);
    };
    REQUIRE(search.run(given.rest.size() / 6, [&](const auto& fit) { return largest(fit) <= most; }) ==
            Status::ok);
    CHECK(largest(search.best()) <= most);
    CHECK(search.best().bones() == report.bones);
    std::size_t least = given.rest.size();
    for (const auto& [bones, holds] : search.trials()) least = holds ? (std::min)(least, bones) : least;
    CHECK(search.best().bones() == least);

    const auto many = given.fit(options, {cageform::ThreadedFor{3}, {}});
    CHECK((many.value.maps == skeleton.maps));
    CHECK((many.value.skin.weights == skeleton.skin.weights));
    CHECK((many.value.skin.joints == skeleton.skin.joints));
}

TEST_CASE("results have the same bits for any number of threads, and in float", "[skeleton]") {
    const Sequence given = planted(5, 13, 11);
    const SkeletonOptions options{.bones = 6, .rounds = 14, .moves = 3}; // the last ones are accelerated
    const auto alone = given.fit(options);
    for (const unsigned threads : {2u, 3u, 7u}) {
        const auto many = given.fit(options, {cageform::ThreadedFor{threads}, {}});
        CHECK((many.value.maps == alone.value.maps));
        CHECK((many.value.skin.weights == alone.value.skin.weights));
        CHECK((many.value.skin.joints == alone.value.skin.joints));
        CHECK((many.value.joints == alone.value.joints));
        CHECK(many.report.rms == alone.report.rms);
        CHECK(many.report.turn == alone.report.turn);
    }
    // Strided float views, as in an engine.
    std::vector<float> numbers;
    for (const auto& frame : given.frames) {
        for (const V& v : frame) numbers.insert(numbers.end(), {float(v[0]), float(v[1]), float(v[2]), 9.f});
    }
    std::vector<cageform::StridedPoints<const float, 3>> views;
    const std::size_t n = given.rest.size();
    for (std::size_t t = 0; t < given.frames.size(); ++t)
        views.emplace_back(numbers.data() + t * n * 4, n, std::ptrdiff_t(4 * sizeof(float)));
    std::vector<Vec<float, 3>> rest;
    for (const V& v : given.rest) rest.push_back(cageform::vec_cast<float>(v));
    const auto single = cageform::fit_skeleton(rest, views, given.faces, options);
    REQUIRE(single.report.status == Status::ok);
    CHECK(std::fabs(single.report.rms - alone.report.rms) <= 0.5 * alone.report.rms + 1e-6);
}

TEST_CASE("fit_skeleton reports progress and can be cancelled", "[skeleton]") {
    const Sequence given = planted(4, 9, 21);
    check_progress("by number",
                   [&](const Running& r) { return given.fit({.bones = 4, .rounds = 2, .moves = 1}, r); });
    check_progress("by distance", [&](const Running& r) {
        return given.fit({.max_distance = 0.05, .rounds = 2, .moves = 1}, r);
    });
}

TEST_CASE("joints form a tree, and products of local transforms equal the maps", "[skeleton]") {
    const BoneKind kind = GENERATE(BoneKind::rigid, BoneKind::similar, BoneKind::stretched);
    Sequence given = planted(5, 12, 33);
    const auto [skeleton, report] = given.fit({.bones = 6, .kind = kind, .rounds = 3, .moves = 2});
    REQUIRE(report.status == Status::ok);
    REQUIRE(skeleton.parents.size() == skeleton.bones);
    REQUIRE(skeleton.joints.size() == skeleton.bones);
    CHECK(skeleton.parents[0] == FittedSkeleton<double>::no_parent);
    for (std::size_t j = 1; j < skeleton.bones; ++j) CHECK(skeleton.parents[j] < j);
    for (std::size_t t = 0; t < skeleton.frames; ++t) {
        std::vector<Map> nodes;
        for (std::size_t j = 0; j < skeleton.bones; ++j) {
            const Map local = skeleton.local(t, j);
            nodes.push_back(j == 0 ? local : nodes[skeleton.parents[j]].after(local));
            for (const V& v : {given.rest[0], given.rest[100]})
                CHECK(distance(nodes[j](v - skeleton.joints[j]), skeleton.map(t, j)(v)) <=
                      1e-11 * given.size());
        }
    }
}

TEST_CASE("a hinge's joint lies on its axis", "[skeleton]") {
    const int seed = GENERATE(seeds(4));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 40);
    Sequence given = tube(24, 12);
    const V hinge{3, 0, 0};
    for (int t = 0; t < 16; ++t) {
        const Map turn = rotation(random_vector(random, 1), random.uniform(-1, 1));
        given.frames.emplace_back();
        for (const V& v : given.rest) {
            const double w = (std::min)((std::max)((v[0] - 2.5), 0.0), 1.0);
            given.frames.back().push_back((1 - w) * v + w * (turn(v - hinge) + hinge));
        }
    }
    const auto [skeleton, report] = given.fit({.bones = 2, .rounds = 20});
    REQUIRE(report.status == Status::ok);
    REQUIRE(skeleton.bones == 2);
    CHECK(report.rms <= 1e-4);
    CHECK(distance(skeleton.joints[1], hinge) <= 0.05);
}

TEST_CASE("vertices that coincide in all frames share their weights", "[skeleton]") {
    Sequence given = planted(4, 9, 51);
    const std::size_t n = given.rest.size();
    for (std::size_t i = 0; i < 40; ++i) {
        given.rest.push_back(given.rest[3 * i]);
        for (auto& frame : given.frames) frame.push_back(frame[3 * i]);
        if (i > 1) given.faces.push_back({std::uint32_t(n + i), std::uint32_t(n + i - 1), std::uint32_t(i)});
    }
    const auto [skeleton, report] = given.fit({.bones = 4, .rounds = 3, .moves = 1});
    REQUIRE(report.status == Status::ok);
    for (std::size_t i = 0; i < 40; ++i) {
        for (std::size_t k = 0; k < 4; ++k) {
            CHECK(skeleton.skin.weights[4 * (n + i) + k] == skeleton.skin.weights[4 * 3 * i + k]);
            CHECK(skeleton.skin.joints[4 * (n + i) + k] == skeleton.skin.joints[4 * 3 * i + k]);
        }
    }
}

TEST_CASE("degenerate figures can be fitted", "[skeleton]") {
    const BoneKind kind = GENERATE(BoneKind::rigid, BoneKind::similar, BoneKind::stretched);
    Random random(61);
    const auto check = [&](const char* name, const Sequence& given, double nearness) {
        CAPTURE(name);
        for (const SkeletonOptions& options :
             {SkeletonOptions{.bones = 1, .kind = kind},
              SkeletonOptions{.bones = 50, .kind = kind, .moves = 2},
              SkeletonOptions{.kind = kind, .max_distance = 0.01, .rounds = 2, .moves = 1}}) {
            const auto [skeleton, report] = given.fit(options);
            REQUIRE(report.status == Status::ok);
            check_skin(skeleton, given.rest.size(), 4);
            check_finite(skeleton);
            CHECK(skeleton.bones >= 1);
            CHECK(report.bones <= (std::max)(given.rest.size() / 6, std::size_t{1}));
            CHECK(report.max_distance <= nearness);
        }
    };
    const auto moved = [&](std::vector<V> rest, std::vector<Face> faces, bool rigid) {
        Sequence given{rest, {}, faces};
        for (int t = 0; t < 5; ++t) {
            const Map map = rigid ? random_motion(random, 3, 2) : Map{};
            given.frames.emplace_back();
            for (const V& v : rest) given.frames.back().push_back(map(v));
        }
        return given;
    };
    const double exact = 1e-3;
    std::vector<V> plane, line, point(20, V{1, 2, 3});
    for (int i = 0; i < 36; ++i) {
        plane.push_back({double(i % 6), double(i / 6), 1});
        line.push_back({double(i), 2.0 * double(i), -double(i)});
    }
    check("in a plane", moved(plane, {}, true), exact);
    check("on a line", moved(line, {}, true), exact);
    check("in a point", moved(point, {{0, 1, 2}}, true), exact);
    check("one triangle", moved({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, true), exact);
    check("one vertex", moved({{4, 5, 6}}, {}, true), exact);
    check("at rest", moved(tube(6, 6).rest, tube(6, 6).faces, false),
          1e-7); // single-precision weights
    check("faces of one vertex", moved(plane, {{3, 3, 3}, {0, 1, 1}}, true), exact);
    Sequence torn = tube(6, 6);
    for (int t = 0; t < 4; ++t) {
        torn.frames.push_back(torn.rest);
        for (V& v : torn.frames.back()) v = random_vector(random, 2);
    }
    check("torn", torn, 10);
    Sequence collapsed = moved(tube(6, 6).rest, tube(6, 6).faces, false);
    for (V& v : collapsed.frames[2]) v = {1, 1, 1};
    check("collapsed", collapsed, 2);
    // Without motion one bone suffices and does not move.
    const auto still = moved(tube(8, 8).rest, {}, false).fit({.max_distance = 0.001});
    CHECK(still.report.bones == 1);
    for (const Map& map : still.value.maps) {
        for (std::size_t c = 0; c < 3; ++c) CHECK(distance(map.axes[c], Map{}.axes[c]) <= 1e-12);
        CHECK(distance(map.shift, {}) <= 1e-12);
    }
}

TEST_CASE("disconnected parts are children of the root", "[skeleton]") {
    Sequence given = tube(8, 8);
    const std::size_t n = given.rest.size(), faces = given.faces.size();
    for (std::size_t i = 0; i < n; ++i) given.rest.push_back(given.rest[i] + V{0, 20, 0});
    for (std::size_t f = 0; f < faces; ++f) {
        const Face face = given.faces[f];
        given.faces.push_back({face[0] + unsigned(n), face[1] + unsigned(n), face[2] + unsigned(n)});
    }
    Random random(71);
    for (int t = 0; t < 8; ++t) {
        const Map a = random_motion(random, 2, 5), b = random_motion(random, 2, 5);
        given.frames.emplace_back();
        for (std::size_t i = 0; i < 2 * n; ++i) given.frames.back().push_back((i < n ? a : b)(given.rest[i]));
    }
    const auto [skeleton, report] = given.fit({.bones = 2});
    REQUIRE(report.status == Status::ok);
    REQUIRE(skeleton.bones == 2);
    CHECK(report.max_distance <= 1e-6);
    CHECK(skeleton.parents[1] == 0);
}

TEST_CASE("invalid input of fit_skeleton is reported", "[skeleton]") {
    const Sequence good = planted(3, 4, 81);
    const auto refused = [](const Sequence& given, const SkeletonOptions& options) {
        const auto result = given.fit(options);
        CHECK(result.value.bones == 0);
        CHECK(result.value.maps.empty());
        return result.report;
    };
    const SkeletonOptions three{.bones = 3};
    CHECK(refused(good, {}).status == Status::bones_not_supported);
    CHECK(refused(good, {.bones = 3, .influences = 0}).status == Status::influences_not_supported);
    CHECK(refused(good, {.bones = 3, .influences = 9}).status == Status::influences_not_supported);
    CHECK(refused(good, {.max_distance = -1}).status == Status::value_not_finite);
    CHECK(refused(good, {.max_distance = std::nan("")}).status == Status::value_not_finite);
    Sequence bad = good;
    bad.frames.resize(1);
    CHECK(refused(bad, three).status == Status::motion_empty);
    CHECK(refused(Sequence{{}, {{}, {}}, {}}, three).status == Status::motion_empty);
    bad = good;
    bad.frames[2].pop_back();
    const auto differs = refused(bad, three);
    CHECK(differs.status == Status::frames_do_not_match);
    CHECK(differs.frame == 2);
    for (const double value : {std::nan(""), HUGE_VAL, -1e101}) {
        bad = good;
        bad.frames[1][17][2] = value;
        const auto report = refused(bad, three);
        CHECK(report.status == Status::frame_not_finite);
        CHECK(report.frame == 1);
        CHECK(report.vertex == 17);
        bad = good;
        bad.rest[5][0] = value;
        CHECK(refused(bad, three).frame == bad.frames.size());
    }
    bad = good;
    bad.faces[4][1] = std::uint32_t(bad.rest.size());
    CHECK(refused(bad, three).status == Status::face_without_vertex);
}

TEST_CASE("random valid and invalid sequences are fitted or rejected", "[skeleton]") {
    const int seed = GENERATE(seeds(effort(300, 60)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1000);
    const auto below = [&](std::size_t n) { return std::size_t(random.uniform(0, double(n) - 1e-9)); };
    const std::size_t vertices = below(40), frames = below(12);
    const double scale = std::pow(10.0, random.uniform(-30, 30));
    Sequence given;
    for (std::size_t i = 0; i < vertices; ++i) {
        V v = scale * random_vector(random, 1);
        if (seed % 3 == 0) v[2] = 0;
        if (seed % 5 == 0 && i > 0 && below(2) == 0) v = given.rest[below(i)];
        given.rest.push_back(v);
    }
    for (std::size_t t = 0; t < frames; ++t) {
        given.frames.push_back(given.rest);
        const Map map = random_motion(random, 3, scale);
        for (V& v : given.frames[t]) {
            v = map(v);
            if (seed % 4 == 0) v = v + scale * random_vector(random, 0.3);
        }
        if (seed % 7 == 0 && t > 0) given.frames[t] = given.frames[0];
    }
    for (std::size_t f = 0; vertices > 0 && f < below(60); ++f)
        given.faces.push_back(
            {std::uint32_t(below(vertices)), std::uint32_t(below(vertices)), std::uint32_t(below(vertices))});
    if (seed % 11 == 0 && vertices > 0 && frames > 0)
        given.frames[below(frames)][below(vertices)][below(3)] = std::nan("");
    const SkeletonOptions options{.bones = below(9),
                                  .influences = 1 + below(8),
                                  .kind = BoneKind(below(3)),
                                  .max_distance = seed % 2 == 0 ? random.uniform(0, 0.3) : 0,
                                  .rounds = below(3),
                                  .moves = below(3)};
    const auto [skeleton, report] = given.fit(options);
    if (report.status != Status::ok) {
        CHECK((report.status == Status::motion_empty || report.status == Status::frame_not_finite ||
               report.status == Status::bones_not_supported));
        return;
    }
    check_skin(skeleton, vertices, options.influences);
    check_finite(skeleton);
    CHECK(std::isfinite(report.rms));
    CHECK(std::isfinite(report.turn));
    CHECK(report.max_distance >= 0);
    const auto times = times_of(skeleton.frames);
    const double allowed = random.uniform(0, 0.05);
    const auto [keys, made] = cageform::fit_skeleton_keys(skeleton, given.rest, times, {allowed});
    if (made.status == Status::value_not_finite) return; // bones of scale 0
    REQUIRE(made.status == Status::ok);
    CHECK(made.max_distance <= allowed + 1e-6);
}

namespace {

/// Random bones on a tube with random weights and smooth motions.
FittedSkeleton<double> random_skeleton(Random& random, const std::vector<V>& rest, std::size_t bones,
                                       std::size_t frames, BoneKind kind) {
    FittedSkeleton<double> result;
    result.bones = bones;
    result.frames = frames;
    struct Way {
        V axis, shift, stretch;
        double angle, phase;
    };
    std::vector<Way> ways;
    for (std::uint32_t b = 0; b < bones; ++b) {
        result.parents.push_back(b == 0 ? FittedSkeleton<double>::no_parent
                                        : std::uint32_t(random.uniform(0, b - 1e-9)));
        result.joints.push_back(random_vector(random, 3));
        V stretch = random_vector(random, kind == BoneKind::rigid ? 0 : 0.3);
        if (kind == BoneKind::similar) stretch = {stretch[0], stretch[0], stretch[0]};
        ways.push_back({random_vector(random, 1), random_vector(random, 0.5), stretch, random.uniform(-2, 2),
                        random.uniform(0, 6)});
    }
    for (std::size_t t = 0; t < frames; ++t) {
        for (std::size_t b = 0; b < bones; ++b) {
            const Way& way = ways[b];
            const double wave = std::sin(way.phase + 6 * double(t) / double(frames));
            Map own = rotation(way.axis, way.angle * wave);
            for (std::size_t c = 0; c < 3; ++c) own.axes[c] = (1 + way.stretch[c] * wave) * own.axes[c];
            own.shift = result.joints[b] - own(result.joints[b]) + wave * way.shift;
            if (b > 0) own = result.map(t, result.parents[b]).after(own);
            result.maps.push_back(own);
        }
    }
    result.skin.influences = 4;
    for (std::size_t i = 0; i < rest.size(); ++i) {
        double left = 1;
        for (std::size_t k = 0; k < 4; ++k) {
            const double w = k == 3 ? left : random.uniform(0, left);
            result.skin.joints.push_back(std::uint16_t(random.uniform(0, double(bones) - 1e-9)));
            result.skin.weights.push_back(float(w));
            left -= double(result.skin.weights.back());
        }
        result.skin.weights.back() = float((std::max)(left, 0.0));
    }
    return result;
}

/// Maximum distance between a figure by maps and by keys, relative to its size.
double lost(const FittedSkeleton<double>& skeleton, const std::vector<V>& rest,
            const std::vector<double>& times, const cageform::SkeletonKeys<double>& keys) {
    FittedSkeleton<double> played = skeleton;
    double largest = 0;
    for (std::size_t t = 0; t < skeleton.frames; ++t) {
        played.maps = keys.maps(skeleton, times[t]);
        for (std::size_t i = 0; i < rest.size(); ++i) {
            largest =
                std::fmax(largest, distance(played.place(0, i, rest[i]), skeleton.place(t, i, rest[i])));
        }
    }
    return largest / cageform::bounds_of(std::span<const V>(rest)).diagonal();
}
template <class Body>
void for_each_channel(const cageform::SkeletonKeys<double>& keys, const Body& body) {
    for (const auto& bone : keys.bones) {
        body(bone.translation);
        body(bone.rotation);
        body(bone.scale);
        body(bone.axes);
    }
}

/// Keys at all times with nlerp rotations, as in players without slerp.
cageform::SkeletonKeys<double> by_components(const cageform::SkeletonKeys<double>& keys,
                                             const std::vector<double>& times) {
    cageform::SkeletonKeys<double> dense = keys;
    const auto resample = [&](auto& channel) {
        const auto sparse = channel;
        if (sparse.times.size() < 2) return;
        channel.times = times;
        channel.values.clear();
        for (const double time : times) {
            const auto after = std::upper_bound(sparse.times.begin(), sparse.times.end(), time);
            const std::size_t k = std::size_t(std::clamp<std::ptrdiff_t>(
                after - sparse.times.begin(), 1, std::ptrdiff_t(sparse.times.size()) - 1));
            const double u =
                std::clamp((time - sparse.times[k - 1]) / (sparse.times[k] - sparse.times[k - 1]), 0.0, 1.0);
            auto& q = channel.values.emplace_back();
            double square = 0;
            for (std::size_t c = 0; c < 4; ++c) {
                q[c] = (1 - u) * sparse.values[k - 1][c] + u * sparse.values[k][c];
                square += q[c] * q[c];
            }
            for (std::size_t c = 0; c < 4; ++c) q[c] /= std::sqrt(square);
        }
    };
    for (auto& bone : dense.bones) {
        resample(bone.rotation);
        resample(bone.axes);
    }
    return dense;
}

} // namespace

TEST_CASE("keys keep the distance for any hierarchy and kind of bones", "[skeleton]") {
    const int seed = GENERATE(seeds(effort(24, 6)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 3000);
    const auto rest = tube(8, 6).rest;
    const auto kind = BoneKind(seed % 3);
    auto skeleton = random_skeleton(random, rest, 1 + std::size_t(random.uniform(0, 5)), 30, kind);
    if (seed % 4 == 3) skeleton.parents.assign(skeleton.bones, FittedSkeleton<double>::no_parent);
    const auto times = times_of(skeleton.frames);
    const bool tangents = random.below(2) == 0;
    std::size_t most = 0;
    for (const double allowed : {0.0, 1e-5, 1e-3, 0.02}) {
        CAPTURE(allowed);
        const auto [keys, report] = cageform::fit_skeleton_keys(skeleton, rest, times, {allowed, tangents});
        REQUIRE(report.status == Status::ok);
        const double off = lost(skeleton, rest, times, keys);
        CHECK(off <= allowed + 1e-9);
        CHECK(std::fabs(off - report.max_distance) <= 1e-12);
        if (!tangents) CHECK(lost(skeleton, rest, times, by_components(keys, times)) <= allowed + 1e-9);
        if (allowed == 0.0) most = report.numbers;
        CHECK(report.numbers <= most);
        if (allowed == 0.02) CHECK(report.numbers < most);
        std::size_t count = 0;
        for_each_channel(keys, [&](const auto& channel) {
            count += channel.times.size();
            REQUIRE(!channel.times.empty());
            REQUIRE(channel.values.size() == channel.times.size());
            REQUIRE(channel.in_tangents.size() == channel.out_tangents.size());
            CHECK((tangents || channel.in_tangents.empty()));
            CHECK((channel.in_tangents.empty() || channel.in_tangents.size() == channel.times.size()));
            for (std::size_t k = 0; k < channel.times.size(); ++k) {
                if (k > 0) CHECK(channel.times[k - 1] < channel.times[k]);
            }
            if (channel.times.size() > 1) CHECK(channel.times.back() == times.back());
            CHECK(channel.times[0] == times[0]);
            if constexpr (std::is_same_v<std::decay_t<decltype(channel.values[0])>,
                                         cageform::Quaternion<double>>) {
                for (std::size_t k = 0; k < channel.values.size(); ++k) {
                    const auto& q = channel.values[k];
                    double square = 0, along = 0;
                    for (std::size_t c = 0; c < 4; ++c) {
                        square += q[c] * q[c];
                        along += q[c] * channel.values[k == 0 ? 0 : k - 1][c];
                    }
                    CHECK(std::fabs(square - 1) <= 1e-12);
                    // Neighbours differ by at most 90°, quaternions by half of that.
                    CHECK((along >= std::sqrt(0.5) - 1e-12 || !channel.in_tangents.empty()));
                }
            }
        });
        CHECK(count == report.keys);
        if (kind != BoneKind::rigid) continue;
        for (const auto& bone : keys.bones) {
            CHECK(bone.scale.times.size() == 1);
            CHECK(bone.scale.values[0] == V{1, 1, 1});
            CHECK(bone.axes.times.size() == 1);
        }
    }
}

TEST_CASE("slerp and nlerp agree between keys for rotations of any angle", "[skeleton]") {
    const int seed = GENERATE(seeds(effort(24, 6)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 4000);
    const auto rest = tube(8, 6).rest;
    auto skeleton = random_skeleton(random, rest, 1, 6, BoneKind::rigid);
    const double pi = std::acos(-1.0), step = seed % 2 == 0 ? pi : random.uniform(-4 * pi, 4 * pi);
    const V axis = random_vector(random, 1), stretch = random_vector(random, seed % 3 == 2 ? 0.3 : 0);
    for (std::size_t t = 0; t < skeleton.frames; ++t) {
        Map& map = skeleton.maps[t] = rotation(axis, step * double(t));
        for (std::size_t c = 0; c < 3; ++c) map.axes[c] = (1 + stretch[c] * double(t % 2)) * map.axes[c];
        map.shift = skeleton.joints[0] - map(skeleton.joints[0]);
    }
    const double allowed = random.uniform(1e-4, 1e-2);
    const auto times = times_of(skeleton.frames);
    const auto [keys, report] = cageform::fit_skeleton_keys(skeleton, rest, times, {allowed});
    REQUIRE(report.status == Status::ok);
    CHECK(lost(skeleton, rest, times, keys) <= allowed + 1e-9);
    std::vector<double> dense;
    for (std::size_t n = 0; n <= 500; ++n) dense.push_back(times.back() * double(n) / 500);
    FittedSkeleton<double> played = skeleton;
    played.maps.clear();
    for (const double time : dense) played.maps.push_back(keys.maps(skeleton, time)[0]);
    played.frames = dense.size();
    CHECK(lost(played, rest, dense, by_components(keys, dense)) <= allowed);
    double turned = 0; // about the axis, summed between keys
    const auto& values = keys.bones[0].rotation.values;
    for (std::size_t k = 1; k < values.size(); ++k) {
        const auto &a = values[k - 1], &b = values[k];
        const double along = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
        CHECK(along >= std::sqrt(0.5) - 1e-12); // 90°
        turned += 2 * std::acos(std::fmin(along, 1.0)) *
                  (a[3] * dot(V{b[0], b[1], b[2]}, axis) > b[3] * dot(V{a[0], a[1], a[2]}, axis) ? 1 : -1);
    }
    if (seed % 2 == 0) CHECK(std::fabs(std::fabs(turned) - pi * double(skeleton.frames - 1)) <= 1e-5);
}

TEST_CASE("constant channels have one key, linear ones two", "[skeleton]") {
    Random random(5);
    const auto rest = tube(8, 6).rest;
    auto skeleton = random_skeleton(random, rest, 3, 20, BoneKind::rigid);
    const V axis = random_vector(random, 1), shift = random_vector(random, 1);
    for (std::size_t t = 0; t < skeleton.frames; ++t) {
        for (std::size_t b = 0; b < 3; ++b) {
            Map& map = skeleton.maps[3 * t + b];
            // For such a small angle nlerp is also nearly linear.
            map = b == 0 ? Map{} : rotation(axis, 0.005 * double(t));
            map.shift = skeleton.joints[b] - map(skeleton.joints[b]);
            if (b > 0) map.shift = map.shift + double(t) * shift;
        }
    }
    skeleton.parents = {FittedSkeleton<double>::no_parent, 0, 1};
    const auto [keys, report] =
        cageform::fit_skeleton_keys(skeleton, rest, times_of(skeleton.frames), {1e-4});
    REQUIRE(report.status == Status::ok);
    const auto& [root, turned, child] = std::tie(keys.bones[0], keys.bones[1], keys.bones[2]);
    CHECK(root.translation.times.size() + root.rotation.times.size() == 2);
    CHECK(turned.translation.times.size() == 2);
    CHECK(turned.rotation.times.size() == 2);
    CHECK(turned.rotation.in_tangents.empty());
    // The child moves with its parent, except for the shift of its joint.
    CHECK(child.rotation.times.size() == 1);
}

TEST_CASE("keys in float, at any scale, with progress and invalid input", "[skeleton]") {
    Random random(6);
    const auto rest = tube(6, 6).rest;
    const auto skeleton = random_skeleton(random, rest, 4, 12, BoneKind::similar);
    const auto times = times_of(skeleton.frames);
    const auto made = [&](const FittedSkeleton<double>& of, const std::vector<double>& at, double allowed) {
        const auto result = cageform::fit_skeleton_keys(of, rest, at, {allowed});
        if (!result) CHECK(result.value.bones.empty());
        return result.report;
    };
    const auto report = made(skeleton, times, 1e-3);
    auto large = skeleton;
    auto large_rest = rest;
    for (V& v : large_rest) v = 1024.0 * v;
    for (V& v : large.joints) v = 1024.0 * v;
    for (Map& map : large.maps) map.shift = 1024.0 * map.shift;
    const auto scaled = cageform::fit_skeleton_keys(large, large_rest, times, {1e-3});
    CHECK(scaled.report.keys == report.keys);
    CHECK(scaled.report.max_distance == report.max_distance);

    FittedSkeleton<float> single;
    single.bones = skeleton.bones;
    single.frames = skeleton.frames;
    single.skin = skeleton.skin;
    single.parents = skeleton.parents;
    for (const V& v : skeleton.joints) single.joints.push_back(cageform::vec_cast<float>(v));
    for (const Map& map : skeleton.maps) {
        auto& to = single.maps.emplace_back();
        for (std::size_t c = 0; c < 3; ++c) to.axes[c] = cageform::vec_cast<float>(map.axes[c]);
        to.shift = cageform::vec_cast<float>(map.shift);
    }
    const auto of_floats =
        cageform::fit_skeleton_keys(single, rest, std::vector<float>(times.begin(), times.end()), {1e-3});
    REQUIRE(of_floats.report.status == Status::ok);
    CHECK(of_floats.report.max_distance <= 1e-3 + 1e-5);

    check_progress("keys", [&](const Running& running) {
        return cageform::fit_skeleton_keys(skeleton, rest, times, {1e-3}, running);
    });
    CHECK(made(skeleton, times, -1).status == Status::value_not_finite);
    CHECK(made(skeleton, times, std::nan("")).status == Status::value_not_finite);
    CHECK(made({}, {}, 0.1).status == Status::input_malformed);
    auto bad_times = times;
    bad_times[3] = bad_times[2];
    CHECK(made(skeleton, bad_times, 0.1).status == Status::keys_not_ascending);
    bad_times.pop_back();
    CHECK(made(skeleton, bad_times, 0.1).status == Status::frames_do_not_match);
    auto bad = skeleton;
    bad.parents[1] = 2;
    CHECK(made(bad, times, 0.1).status == Status::input_malformed);
    bad = skeleton;
    bad.skin.joints[5] = 4;
    CHECK(made(bad, times, 0.1).status == Status::input_malformed);
    bad = skeleton;
    bad.maps[7].shift[1] = std::nan("");
    CHECK(made(bad, times, 0.1).status == Status::value_not_finite);
    auto bad_rest = rest;
    bad_rest[2][0] = std::nan("");
    const auto refused = cageform::fit_skeleton_keys(skeleton, bad_rest, times, {0.1});
    CHECK(refused.report.status == Status::value_not_finite);
}

} // namespace fit_skeleton_tests

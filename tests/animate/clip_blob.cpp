// Packed clips: played in place with the same bits, rejected with a status if invalid,
// quantised within a distance.
#include "catch.hpp"
#include "support/aligned.hpp"
#include "support/allocation_count.hpp"
#include "support/cages.hpp"
#include "support/keys.hpp"
#include "support/larger.hpp"

#include <cageform/animate/compile.hpp>
#include <cageform/animate/pack_clip.hpp>

namespace clip_blob_tests {

using namespace cageform_tests;
using cageform::BlobCheck;
using cageform::CageClip;
using cageform::CageClipView;
using cageform::ClipHeader;
using cageform::epsilon;
using cageform::Extrapolation;
using cageform::Key;
using cageform::KeyKind;
using cageform::open_clip;
using cageform::pack_clip;
using cageform::PackedClip;
using cageform::Status;

namespace {

constexpr std::array<Extrapolation, 5> modes{Extrapolation::constant, Extrapolation::linear,
                                             Extrapolation::cycle, Extrapolation::cycle_with_offset,
                                             Extrapolation::ping_pong};

/// Keys of all kinds, from about 0 to about 4.
std::vector<Key> random_keys(Random& random) {
    std::vector<Key> keys;
    for (double time = random.uniform(0, 0.5); time < 4; time += random.uniform(0.1, 1)) {
        Key made = key(time, random.uniform(-2, 2), KeyKind(random.below(6)));
        made.in_handle = {time - random.uniform(0, 0.05), random.uniform(-2, 2)};
        made.out_handle = {time + random.uniform(0, 0.05), random.uniform(-2, 2)};
        made.in_slope = random.uniform(-2, 2);
        made.out_slope = random.uniform(-2, 2);
        keys.push_back(made);
        if (random.below(20) == 0) break; // a constant, or a short one
    }
    return keys;
}

template <class T>
cageform::Track<T> random_track(Random& random) {
    cageform::TrackOptions options;
    options.before = modes[random.below(5)];
    options.after = modes[random.below(5)];
    const auto compiled = cageform::compile<T>(random_keys(random), options);
    REQUIRE(compiled.status() == Status::ok);
    return compiled.value;
}

template <class T, std::size_t D>
CageClip<T, D> random_clip(Random& random, std::size_t vertices, bool moves = false) {
    std::vector<std::vector<Key>> keys;
    for (std::size_t k = 0; k < vertices * D; ++k) keys.push_back(random_keys(random));
    cageform::TrackOptions options;
    options.before = modes[random.below(5)];
    options.after = modes[random.below(5)];
    auto compiled = cageform::compile<T, D>(keys, options);
    REQUIRE(compiled.status() == Status::ok);
    if (!moves) return std::move(compiled.value);
    cageform::RigidMotion<T, D> motion;
    for (std::size_t k = 0; k < D; ++k) {
        motion.pivot[k] = T(random.uniform(-1, 1));
        if (random.below(3) != 0) motion.translation[k] = random_track<T>(random);
    }
    if (random.below(3) != 0) (D == 2 ? motion.angle : motion.phase) = random_track<T>(random);
    for (std::size_t n = random.below(4); D == 3 && n > 0; --n) {
        const T half = T(random.uniform(-3, 3));
        motion.rotations.push_back({std::sin(half), 0, 0, std::cos(half)});
    }
    compiled.value.set_rigid_motion(motion);
    return std::move(compiled.value);
}

/// Times forwards, backwards and random, also far outside.
template <class T>
std::vector<T> times_of_play(Random& random) {
    std::vector<T> times;
    for (int n = -120; n < 400; ++n) times.push_back(T(n) / 60);
    for (int n = 400; n > -100; n -= 3) times.push_back(T(n) / 60);
    for (int n = 0; n < 100; ++n) times.push_back(T(random.uniform(-20, 20)));
    return times;
}

Status status_of(std::span<const std::byte> bytes, BlobCheck check = BlobCheck::all) {
    const auto opened = open_clip<float, 3>(bytes, check);
    if (opened.status() != Status::ok) {
        CHECK(opened.value.vertex_count() == 0);
        CHECK(opened.value.bank.knots.empty());
        CHECK(opened.report.bytes == 0);
    }
    return opened.status();
}

ClipHeader header_of(std::span<const std::byte> bytes) {
    ClipHeader header;
    std::memcpy(&header, bytes.data(), sizeof(header));
    return header;
}

} // namespace

TEMPLATE_TEST_CASE("an opened clip gives the bits of the original, without allocation",
                   "[animate][clip_blob][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(25));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    const auto test = [&](auto dimension, std::size_t vertices) {
        constexpr std::size_t D = dimension();
        const auto clip = random_clip<T, D>(random, vertices, seed % 3 == 0);
        const auto packed = pack_clip(clip);
        REQUIRE(packed.report.status == Status::ok);
        CHECK(packed.report.bytes == packed.value.bytes().size());
        CHECK(packed.report.unquantised_bytes == packed.report.bytes);
        CHECK(packed.report.quantised == 0);
        CHECK(packed.report.distance == 0);
        Aligned file(packed.value.bytes()); // other memory of the exact size
        const auto times = times_of_play<T>(random);
        std::vector<cageform::Lanes<T>> memory(clip.view().cursor_rows());
        std::vector<Vec<T, D>> expected(vertices), pose(vertices);
        auto cursor = clip.make_cursor();
        bool same = true;
        const std::size_t before = allocations;
        const auto opened = open_clip<T, D>(file.bytes());
        auto player = opened.value.make_cursor(memory);
        for (const T time : times) {
            opened.value.sample(time, player, pose);
            clip.sample(time, cursor, expected);
            same = same && std::memcmp(pose.data(), expected.data(), vertices * sizeof(pose[0])) == 0;
        }
        const std::size_t after = allocations;
        CHECK(after == before);
        REQUIRE(opened.status() == Status::ok);
        CHECK(same);
        CHECK(opened.report.bytes == packed.value.bytes().size());
        CHECK(opened.value.vertex_count() == vertices);
        CHECK(opened.value.begin() == clip.begin());
        CHECK(opened.value.end() == clip.end());
        CHECK(opened.value.cursor_rows() == memory.size());
    };
    for (const std::size_t vertices : std::array<std::size_t, 3>{1, 5, 24}) {
        test(std::integral_constant<std::size_t, 2>{}, vertices);
        test(std::integral_constant<std::size_t, 3>{}, vertices);
    }
}

TEMPLATE_TEST_CASE("a clip far from time zero gives the poses of one near it, also packed",
                   "[animate][clip_blob][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(25));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    cageform::TrackOptions options;
    options.before = modes[random.below(5)];
    options.after = modes[random.below(5)];
    const auto time_of = [](int steps) { return steps / 256.0; }; // so that sums of times are exact
    const double shift = double(random.below(1 << 20)) - (1 << 19);
    std::vector<std::vector<Key>> keys(6);
    for (std::size_t k = 0; k < keys.size(); ++k) {
        int steps = k == 0 ? 0 : int(random.below(9));
        for (int n = 0; n < 8; ++n, steps += 1 + int(random.below(3))) {
            Key key;
            key.time = time_of(steps);
            key.value = random.uniform(-2, 2);
            key.kind = n % 3 == 0 ? cageform::KeyKind::bezier : cageform::KeyKind::automatic;
            key.in_handle = {key.time - time_of(1) / 2, random.uniform(-2, 2)};
            key.out_handle = {key.time + time_of(1) / 2, random.uniform(-2, 2)};
            keys[k].push_back(key);
        }
    }
    const auto near = cageform::compile<T, 2>(keys, options);
    for (auto& of_curve : keys) {
        for (Key& key : of_curve) {
            for (double* time : {&key.time, &key.in_handle[0], &key.out_handle[0]}) *time += shift;
        }
    }
    const auto far = cageform::compile<T, 2>(keys, options);
    REQUIRE(near.status() == Status::ok);
    REQUIRE(far.status() == Status::ok);
    const auto packed = pack_clip(far.value);
    const auto opened = open_clip<T, 2>(packed.value.bytes());
    REQUIRE(opened.status() == Status::ok);
    CHECK(header_of(packed.value.bytes()).version == (shift == 0 ? 1 : 2));
    CHECK(opened.value.begin() == near.value.begin() + shift);
    CHECK(opened.value.end() == near.value.end() + shift);
    auto at_near = near.value.make_cursor(), at_far = opened.value.make_cursor();
    std::vector<Vec<T, 2>> expected(3), pose(3);
    bool same = true;
    for (int steps = -40; steps < 80; ++steps) {
        near.value.sample(time_of(steps), at_near, expected);
        opened.value.sample(time_of(steps) + shift, at_far, pose);
        same = same && pose == expected;
    }
    CHECK(same);
}

TEST_CASE("a copied cursor copies its own memory and shares the caller's", "[animate][clip_blob]") {
    Random random(4);
    const auto clip = random_clip<double, 2>(random, 9);
    auto first = clip.make_cursor();
    std::vector<Vec<double, 2>> a(9), b(9), expected(9);
    clip.sample(1.0, first, a);
    auto second = first;
    clip.sample(3.0, second, b);
    clip.sample(1.0, first, expected);
    CHECK(a == expected);
    CHECK(first.memory().data() != second.memory().data());
    std::vector<cageform::Lanes<double>> memory(clip.view().cursor_rows());
    auto given = clip.view().make_cursor(memory);
    clip.sample(3.0, given, expected);
    CHECK(b == expected);
    CHECK(given.memory().data() == memory.data());
    // A cursor can be reset to another clip.
    const auto other = random_clip<double, 2>(random, 5);
    auto of_other = other.make_cursor();
    std::vector<Vec<double, 2>> few(5), few_expected(5);
    for (const double time : {-1.0, 2.0, 1.0}) {
        if (time == -1) other.view().start(given);
        other.sample(time, given, few);
        other.sample(time, of_other, few_expected);
        CHECK(few == few_expected);
    }
}

TEST_CASE("the bytes have the documented layout", "[animate][clip_blob][format]") {
    // One 2D vertex: x unquantised, y in 16 bits.
    std::vector<cageform::CubicPiece<float>> rising;
    for (int n = 0; n < 16; ++n) rising.push_back({float(n) / 8, 3 * float(n) / 8, 3, 0, 0});
    const std::vector<cageform::PiecewiseCubic<float>> curves{
        {{{0.5f, 1, 2, 3, 4}, {1.5f, -1, 0, 0.25f, 0}}, 2.0f}, {rising, 2.0f}};
    const CageClip<float, 2> clip(curves, Extrapolation::linear, Extrapolation::cycle);
    const auto [exact, exact_report] = pack_clip(clip);
    const auto [packed, report] = pack_clip(clip, {.tolerance = 6.1f / 131070});
    REQUIRE(exact_report.status == Status::ok);
    REQUIRE(report.status == Status::ok);
    CHECK(report.quantised == 1); // x exceeds the tolerance
    for (const bool quantised : {false, true}) {
        Aligned file((quantised ? packed : exact).bytes());
        const ClipHeader header = header_of(file.bytes());
        CHECK(std::memcmp(file.data(), "cageclip", 8) == 0);
        CHECK(header.version == 1);
        CHECK(header.scalar_bytes == 4);
        CHECK(header.dimension == 2);
        CHECK(header.before == 1);
        CHECK(header.after == 2);
        CHECK(header.curves == 2);
        CHECK(header.pieces == (quantised ? 3u : 20u));
        CHECK(header.steps == (quantised ? 17u : 0u));
        CHECK(header.begin == 0);
        CHECK(header.end == 2);
        CHECK(header.motion == 0);
        const auto read = [&]<class X>(std::uint64_t offset, X x) {
            std::memcpy(&x, file.data() + offset, sizeof(x));
            return x;
        };
        for (const std::uint64_t offset :
             {header.curve_table, header.knot_table, header.piece_table, header.entry_table, header.ends}) {
            CHECK(offset % 64 == 0);
            CHECK(offset >= 192);
        }
        CHECK((header.step_table != 0) == quantised);
        CHECK(read(header.curve_table, std::array<std::uint32_t, 2>{}) == std::array<std::uint32_t, 2>{0, 3});
        CHECK(read(header.curve_table + 20, std::array<std::uint32_t, 2>{}) ==
              std::array<std::uint32_t, 2>{3, 17}); // the first knot of y, and their number
        CHECK(read(header.curve_table + 16, float{}) == -0.9375f);
        CHECK(read(header.curve_table + 20 + 16, float{}) == 6);
        const float after = std::nextafter(2.0f, 3.0f);
        const auto knots = read(header.knot_table, std::array<float, 20>{});
        CHECK(knots[1] == 1.5f);
        CHECK(knots[2] == after);
        CHECK(knots[4] == 0.125f);
        CHECK(knots[19] == after);
        CHECK(read(header.piece_table + 16, std::array<float, 8>{}) ==
              std::array<float, 8>{-1, 0, 0.25f, 0, -0.9375f, 0, 0, 0});
        const auto entries = read(header.entry_table, std::array<std::array<std::uint32_t, 2>, 20>{});
        auto in_order = entries;
        std::sort(in_order.begin(), in_order.end(), [&](const auto& one, const auto& other) {
            return std::pair(knots[one[0]], one[0]) < std::pair(knots[other[0]], other[0]);
        });
        CHECK(entries == in_order);
        for (const auto& [knot, curve] : entries) CHECK(curve == (knot < 3 ? 0u : 1u));
        CHECK(read(header.ends, std::array<float, 6>{}) ==
              std::array<float, 6>{0, 3, 0.25f, 3, -0.9375f - 1, 6});
        if (!quantised) continue;
        const auto steps = read(header.step_table, std::array<std::uint16_t, 64>{});
        for (int n = 0; n < 64; ++n)
            CHECK(std::fabs(steps[std::size_t(n)] - 65535.0 * (3 * (n / 4) + n % 4) / 48) <= 0.51);
        CHECK(read(header.curve_table + 20 + 8, float{}) == 0);
        CHECK(read(header.curve_table + 20 + 12, float{}) == Approx(6.0 / 65535).epsilon(1e-6));
    }
}

TEMPLATE_TEST_CASE("quantised clips meet the reported distance at every time",
                   "[animate][clip_blob][quantised][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    constexpr std::size_t D = 3, vertices = 12;
    const auto seed = GENERATE(seeds(25));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 301);
    const auto clip = random_clip<T, D>(random, vertices, seed % 4 == 0);
    std::size_t last = 0;
    const auto [exact, exact_report] = pack_clip(clip);
    CHECK(exact_report.size > 3);
    CHECK(exact_report.size < 15);
    for (const double tolerance : {1e-7, 2e-5, 4e-5, 1e-3}) {
        CAPTURE(tolerance);
        const bool by_share = seed % 2 == 0;
        const auto [packed, report] = by_share ? pack_clip(clip, {.share = tolerance / exact_report.size})
                                               : pack_clip(clip, {.tolerance = tolerance});
        REQUIRE(report.status == Status::ok);
        CHECK(report.distance <= tolerance * (1 + 1e-12));
        CHECK(report.quantised >= last);
        CHECK(report.unquantised_bytes == exact.bytes().size());
        CHECK(report.bytes <= report.unquantised_bytes);
        last = report.quantised;
        Aligned file(packed.bytes());
        const auto opened = open_clip<T, D>(file.bytes());
        REQUIRE(opened.status() == Status::ok);
        auto cursor = clip.make_cursor(), player = opened.value.make_cursor();
        std::vector<Vec<T, D>> pose(vertices), other(vertices);
        double farthest = 0, farthest_vertex = 0;
        for (const T time : times_of_play<T>(random)) {
            clip.sample(time, cursor, pose);
            opened.value.sample(time, player, other);
            for (std::size_t i = 0; i < vertices; ++i) {
                const auto off = cageform::vec_cast<double>(pose[i]) - cageform::vec_cast<double>(other[i]);
                const double distance = std::sqrt(dot(off, off));
                double size =
                    30; // of a coordinate of the clip and its motion; it goes on by slopes and rises
                for (std::size_t k = 0; k < D; ++k)
                    size = cageform_tests::larger(size, std::fabs(double(pose[i][k])));
                REQUIRE(distance <= report.distance + 64 * double(epsilon<T>) * size);
                farthest = cageform_tests::larger(farthest, distance);
                if (i == report.distance_vertex)
                    farthest_vertex = cageform_tests::larger(farthest_vertex, distance);
            }
        }
        if (tolerance == 1e-3) { // all but what is too steep between two near keys, and no idle promise
            CHECK(report.quantised > vertices * D / 2);
            CHECK(farthest > 0.2 * report.distance);
            CHECK(farthest_vertex > 0.1 * report.distance);
            // Four numbers a piece in 2 bytes each, not in sizeof(T).
            const ClipHeader header = header_of(packed.bytes());
            CHECK(report.bytes + header.steps * 4 * (sizeof(T) - 2) <= report.unquantised_bytes + 128);
        }
    }
    CHECK(last > 0);
}

TEST_CASE("an invalid tolerance is rejected", "[animate][clip_blob][refused]") {
    Random random(6);
    const auto clip = random_clip<float, 3>(random, 2);
    for (const double none :
         {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        for (const auto& options : {cageform::ClipPackOptions{.tolerance = none}, {.share = none}}) {
            const auto [packed, report] = pack_clip(clip, options);
            CHECK(report.status == Status::value_not_finite);
            CHECK(packed.bytes().empty());
        }
    }
}

TEST_CASE("a clip that would not open is not packed", "[animate][clip_blob][refused]") {
    Random random(7);
    for (const bool turns : {false, true}) {
        auto clip = random_clip<float, 3>(random, 2);
        cageform::RigidMotion<float, 3> motion;
        if (turns)
            motion.rotations = {{0, 0, 0, 0}};
        else
            motion.pivot[1] = std::numeric_limits<float>::quiet_NaN();
        clip.set_rigid_motion(motion);
        const auto [packed, report] = pack_clip(clip);
        CHECK(report.status == Status::value_not_finite);
        CHECK(packed.bytes().empty());
        CHECK(status_of(PackedClip<float, 3>(clip.view()).bytes()) == Status::blob_malformed);
    }
}

TEST_CASE("clips without vertices and of a single key can be packed", "[animate][clip_blob]") {
    const auto none = pack_clip(CageClip<float, 3>{}, {.tolerance = 1});
    REQUIRE(none.report.status == Status::ok);
    const auto opened = open_clip<float, 3>(none.value.bytes());
    REQUIRE(opened.status() == Status::ok);
    CHECK(opened.value.vertex_count() == 0);
    auto cursor = opened.value.make_cursor(std::span<cageform::Lanes<float>>{});
    opened.value.sample(1, cursor, {});
    CHECK(open_clip<float, 3>(PackedClip<float, 3>{}.bytes()).status() == Status::not_a_clip);
    const std::vector<std::vector<Key>> keys(3, {key(0, 0.7)});
    const auto still = cageform::compile<float, 3>(keys);
    for (const double tolerance : {0.0, 1e-6}) {
        const auto packed = pack_clip(still.value, {.tolerance = tolerance});
        const auto player = open_clip<float, 3>(packed.value.bytes());
        REQUIRE(player.status() == Status::ok);
        auto at = player.value.make_cursor();
        std::vector<Vec<float, 3>> pose(1);
        for (const float time : {-1.0f, 0.0f, 1.0f}) {
            player.value.sample(time, at, pose);
            CHECK(pose[0] == Vec<float, 3>{0.7f, 0.7f, 0.7f});
        }
    }
}

TEST_CASE("a clip of another kind is rejected with its status", "[animate][clip_blob][refused]") {
    Random random(7);
    const auto packed = pack_clip(random_clip<float, 3>(random, 4, true), {.tolerance = 1e-4}).value;
    const auto bytes = packed.bytes();
    CHECK(status_of(bytes) == Status::ok);
    CHECK(open_clip<double, 3>(bytes).status() == Status::blob_kind_differs);
    CHECK(open_clip<float, 2>(bytes).status() == Status::blob_kind_differs);
    CHECK(status_of({}) == Status::not_a_clip);
    CHECK(status_of(bytes.subspan(8)) == Status::not_a_clip);
    CHECK(cageform::open_blob<float, 3>(bytes).status() == Status::not_a_blob);
    const auto changed = [&]<class X>(std::size_t offset, X x) {
        Aligned memory(bytes);
        memory.set(offset, x);
        return status_of(memory.bytes());
    };
    CHECK(changed(0, std::uint64_t(1)) == Status::not_a_clip);
    CHECK(changed(0, std::uint64_t(0x6361676563 << 24 | 0x6C6970)) != Status::ok);
    CHECK(changed(0, cageform::detail::byte_swapped(ClipHeader::magic_number)) ==
          Status::blob_version_differs);
    CHECK(changed(offsetof(ClipHeader, version), ClipHeader::current_version + 1) ==
          Status::blob_version_differs);
    CHECK(changed(offsetof(ClipHeader, version), std::uint32_t(0)) == Status::blob_version_differs);
    CHECK(changed(offsetof(ClipHeader, endian), std::uint32_t(0x04030201)) == Status::blob_version_differs);
    for (std::size_t size = 0; size < bytes.size(); size += size < 256 ? 1 : 37) {
        Aligned memory(bytes.first(size));
        CAPTURE(size);
        CHECK(status_of(memory.bytes()) == (size < 16 ? Status::not_a_clip : Status::blob_truncated));
    }
    Aligned memory(bytes);
    std::size_t accepted = 0;
    for (std::size_t byte = 0; byte < bytes.size(); byte += byte < 256 ? 1 : 23) {
        for (int bit = int(byte % 3); bit < 8; bit += 3) {
            memory.data()[byte] ^= std::byte(1 << bit);
            if (open_clip<float, 3>(memory.bytes()).status() == Status::ok) ++accepted;
            memory.data()[byte] ^= std::byte(1 << bit);
        }
    }
    CHECK(accepted == 0);
    CHECK(status_of(memory.bytes()) == Status::ok);
}

TEST_CASE("every inconsistent number of a clip is rejected", "[animate][clip_blob][refused]") {
    Random random(8);
    auto clip = random_clip<float, 3>(random, 4, true);
    cageform::RigidMotion<float, 3> motion;
    motion.phase = random_track<float>(random);
    motion.translation[1] = random_track<float>(random);
    motion.rotations = {{0, 0, 0, 1}, {1, 0, 0, 0}};
    clip.set_rigid_motion(motion);
    const auto packed = PackedClip<float, 3>([&] {
        auto view = clip.view();
        view.before = Extrapolation::linear;
        return view;
    }());
    const auto quantised = pack_clip(packed.view(), {.tolerance = 3e-5});
    REQUIRE(quantised.report.quantised > 0);
    REQUIRE(quantised.report.quantised < quantised.report.curves);
    const Aligned sound(quantised.value.bytes());
    const ClipHeader header = header_of(quantised.value.bytes());
    const auto refused = [&]<class X>(std::size_t offset, X x) {
        Aligned memory = sound;
        memory.set(offset, x);
        memory.seal();
        const Status status = status_of(memory.bytes());
        CAPTURE(offset, double(x), status);
        CHECK(status == Status::blob_malformed);
    };
    {
        Aligned memory = sound;
        memory.seal();
        REQUIRE(status_of(memory.bytes()) == Status::ok);
    }
    for (const std::size_t mode : {offsetof(ClipHeader, before), offsetof(ClipHeader, after)})
        refused(mode, std::uint32_t(5));
    refused(offsetof(ClipHeader, before), std::uint32_t(Extrapolation::constant) | 0x100u);
    for (std::size_t at = offsetof(ClipHeader, curves); at < offsetof(ClipHeader, begin); at += 8) {
        for (const std::uint64_t count : {std::uint64_t(0), std::uint64_t(1), std::uint64_t(1) << 32,
                                          ~std::uint64_t(0), std::uint64_t(0xFFFFFFFFu)})
            refused(at, count);
    }
    for (const double time : {std::numeric_limits<double>::infinity(), 1e300, 0.1, -1.0, 77.0}) {
        refused(offsetof(ClipHeader, begin), time);
        refused(offsetof(ClipHeader, end), time);
    }
    refused(offsetof(ClipHeader, origin), std::numeric_limits<double>::infinity());
    for (std::size_t at = offsetof(ClipHeader, curve_table); at < offsetof(ClipHeader, origin); at += 8) {
        if (at == offsetof(ClipHeader, tracks) || at == offsetof(ClipHeader, turns)) {
            for (const std::uint64_t count : {0u, 777u, ~0u}) refused(at, count);
            continue;
        }
        for (const std::uint64_t offset : {std::uint64_t(0), std::uint64_t(64), header.bytes,
                                           header.bytes + 64, ~std::uint64_t(63), header.curve_table + 4})
            refused(at, offset);
    }
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                infinite = std::numeric_limits<float>::infinity();
    std::size_t exact = 0, stepped = 0; // a curve of each format
    for (std::size_t k = 0; k < header.curves; ++k)
        (quantised.value.view().bank.is_quantised(k) ? stepped : exact) = k;
    for (const std::size_t k : {exact, stepped}) {
        const std::size_t curve = std::size_t(header.curve_table) + k * 20;
        for (const std::uint32_t x : {1u, 1u << 20, ~0u}) {
            refused(curve, x);
            refused(curve + 4, x);
        }
        for (const float x : {nan, infinite}) {
            refused(curve + 8, x);
            refused(curve + 12, x);
            refused(curve + 16, x);
        }
    }
    const std::size_t knots = std::size_t(header.pieces + header.steps);
    for (std::size_t n = 0; n < knots; ++n) {
        refused(std::size_t(header.knot_table) + 4 * n, nan);
        refused(std::size_t(header.knot_table) + 4 * n, -1e6f);
        refused(std::size_t(header.entry_table) + 8 * n, std::uint32_t(knots));
        refused(std::size_t(header.entry_table) + 8 * n, std::uint32_t(n == 0 ? knots : 0xFFFFFFFFu));
        refused(std::size_t(header.entry_table) + 8 * n + 4, std::uint32_t(header.curves));
    }
    for (std::size_t n = 0; n < 4 * header.pieces; n += 3)
        refused(std::size_t(header.piece_table) + 4 * n, n % 2 == 0 ? nan : infinite);
    for (std::size_t n = 0; n < 3 * header.curves; ++n) refused(std::size_t(header.ends) + 4 * n, nan);
    for (std::size_t n = 0; n < 4; ++n) { // tracks of the motion
        const std::size_t track = std::size_t(header.motion) + 24 * n;
        for (const std::uint32_t x : {777u, 1u << 20, ~0u}) {
            refused(track, x);
            refused(track + 4, x);
            refused(track + 8, x);
            refused(track + 12, x | 0x100u);
        }
        refused(track + 16, nan);
        refused(track + 20, infinite);
    }
    for (std::size_t k = 0; k < 3; ++k) refused(std::size_t(header.motion) + 96 + 4 * k, nan);
    for (std::size_t n = 0; n < header.tracks; ++n) {
        refused(std::size_t(header.track_begins) + 4 * n, 1e6f);
        refused(std::size_t(header.track_pieces) + 20 * n, -1e6f);
        refused(std::size_t(header.track_pieces) + 20 * n + 4 * (1 + n % 4), nan);
    }
    for (std::size_t n = 0; n < 8; ++n) refused(std::size_t(header.rotations) + 4 * n, infinite);
}

TEST_CASE("hostile clips never cause access out of bounds", "[animate][clip_blob][hostile]") {
    Random random{std::uint64_t(GENERATE(range(0, 3))) + 501};
    const std::array sound{
        Aligned(pack_clip(random_clip<float, 3>(random, 5, true)).value.bytes()),
        Aligned(pack_clip(random_clip<float, 3>(random, 3), {.tolerance = 1e-3}).value.bytes())};
    std::size_t opened_count = 0;
    for (int round = 0; round < 3000; ++round) {
        Aligned memory = sound[random.below(2)];
        for (std::size_t n = 1 + random.below(2); n > 0; --n) {
            const std::size_t reach = random.below(4) == 0 ? 192 : memory.bytes().size();
            const std::uint32_t values[] = {0,
                                            1,
                                            64,
                                            0xFFFFFFFFu,
                                            0x7F800000u,
                                            std::uint32_t(random.bits()),
                                            std::uint32_t(random.below(memory.bytes().size()))};
            memory.set(random.below(reach / 4) * 4, values[random.below(std::size(values))]);
        }
        const auto opened = open_clip<float, 3>(memory.bytes(), BlobCheck::structure);
        if (opened.status() != Status::ok) continue;
        ++opened_count;
        auto cursor = opened.value.make_cursor();
        std::vector<Vec<float, 3>> pose(opened.value.vertex_count());
        for (const float time : {-1e30f, -3.0f, 0.0f, 0.1f, 1.0f, 2.0f, 1.5f, 77.0f, 1e30f, 0.5f})
            opened.value.sample(time, cursor, pose);
    }
    CHECK(opened_count > 100);
    CHECK(opened_count < 2900);
}

} // namespace clip_blob_tests

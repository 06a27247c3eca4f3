// Packed samples: bitwise reading, named refusals, and safety for any bytes.
#include "../support/aligned.hpp"
#include "../support/allocation_count.hpp"
#include "../support/pins.hpp"

#include <cageform/binding/pack.hpp>

namespace pose_blob_tests {

using namespace cageform_tests;
using cageform::BlobCheck;
using cageform::GreenCoordinates;
using cageform::MeanValueCoordinates;
using cageform::open_pose_samples;
using cageform::PoseBlobHeader;

namespace {

constexpr PoseSampleOptions few{.samples = 400, .rotations = 37};

template <class X>
bool same_bits(const std::vector<X>& a, const std::vector<X>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(X)) == 0);
}
template <class T, std::size_t D>
void check_same(const PoseSamples<T, D>& a, const PoseSamples<T, D>& b, bool with_points) {
    CHECK(same_bits(a.rest_handles, b.rest_handles));
    CHECK(same_bits(a.handle_kinds, b.handle_kinds));
    CHECK(a.centre == b.centre);
    CHECK(a.size == b.size);
    CHECK(a.cluster_count == b.cluster_count);
    CHECK(same_bits(a.gradients, b.gradients));
    CHECK(same_bits(a.moments, b.moments));
    CHECK(same_bits(a.stiffness, b.stiffness));
    CHECK(same_bits(a.weak_handles, b.weak_handles));
    CHECK(same_bits(b.points, with_points ? a.points : decltype(a.points){}));
    CHECK(same_bits(b.clusters, with_points ? a.clusters : decltype(a.clusters){}));
    CHECK(same_bits(b.centres, with_points ? a.centres : decltype(a.centres){}));
}

/// Calls f with coordinates of both scalars and dimensions, with point handles and vector handles.
template <class F>
void for_each_kind(const F& f) {
    std::vector<Vec<float, 2>> cat;
    for (const auto& p : cat_cage()) cat.push_back(cageform::vec_cast<float>(p));
    f(MeanValueCoordinates(cat_cage()), cat_pins(), cat_targets());
    f(GreenCoordinates(cat), cat_pins(), cat_targets());
    f(GreenCoordinates(bar().mesh<double>()), bar_pins(), bar_targets());
    f(MeanValueCoordinates(bar().mesh<float>()), bar_pins(), bar_targets());
}

template <class T, std::size_t D>
cageform::PackedPoseSamples packed(const PoseSamples<T, D>& samples,
                                   const cageform::PosePackOptions& options = {}) {
    auto [blob, status] = pack(samples, options);
    CAPTURE(to_string(status));
    REQUIRE(status == Status::ok);
    return std::move(blob);
}
/// Samples with all parts, and two weak handles.
PoseSamples<float, 2> small_samples() {
    std::vector<Vec<float, 2>> cage;
    for (const auto& p : cat_cage()) cage.push_back(cageform::vec_cast<float>(p));
    auto samples = sampled(GreenCoordinates(cage), {.samples = 60, .rotations = 9});
    samples.weak_handles = {3, 7};
    return samples;
}
Status status_of(std::span<const std::byte> bytes, const cageform::BlobExpectation& expected = {}) {
    return open_pose_samples<float, 2>(bytes, expected).status();
}

} // namespace

TEST_CASE("packed samples are read bitwise, and give bitwise equal poses", "[pose][blob]") {
    for_each_kind([](const auto& coordinates, const auto& pins, const auto& targets) {
        using C = std::remove_cvref_t<decltype(coordinates)>;
        using T = typename C::scalar;
        constexpr std::size_t D = C::dimension;
        Pinned figure(coordinates, pins, few);
        const auto& samples = figure.solver.samples();
        for (const bool keep_points : {false, true}) {
            CAPTURE(D, sizeof(T), keep_points);
            const auto blob = packed(samples, {.keep_points = keep_points});
            CHECK(blob.bytes().size() % 64 == 0);
            Aligned elsewhere(blob.bytes());
            auto opened = open_pose_samples<T, D>(elsewhere.bytes());
            REQUIRE(opened.status() == Status::ok);
            CHECK(opened.report.bytes == blob.bytes().size());
            check_same(samples, opened.value, keep_points);
            figure.solver.reset();
            PoseSolver<T, D> read(std::move(opened.value));
            REQUIRE(read.set_pins({.binding = figure.binding.view()}) == Status::ok);
            std::vector<Vec<T, D>> pose(figure.rest);
            for (std::size_t frame = 0; frame < 5; ++frame) {
                const auto report = figure.solve(targets);
                REQUIRE(read.solve(targets, pose).status == Status::ok);
                CHECK(same_bits(pose, figure.pose));
                CHECK(report.step > 0);
            }
        }
        // Without the parts by sample there is little beside what `bytes` counts: a header and padding.
        const std::size_t size = packed(samples).bytes().size();
        CHECK(size >= samples.bytes() + sizeof(PoseBlobHeader));
        CHECK(size <= samples.bytes() + sizeof(PoseBlobHeader) + 6 * 64);
    });
}

TEST_CASE("samples are a part of a packed figure", "[pose][blob]") {
    const MeanValueCoordinates coordinates(cat_cage());
    cageform::FigureBinding<double, 2> figure;
    figure.points = bound(coordinates, cat_pins());
    const auto blob = packed(sampled(coordinates, few));
    const cageform::FigurePartData parts[] = {{"POSE", blob.bytes()}};
    const auto shipped = pack(figure, {.parts = parts});
    REQUIRE(shipped.status() == Status::ok);
    const auto game = cageform::open<double, 2>(shipped.value.bytes());
    REQUIRE(game);
    // The figure and the samples have the same cage.
    const auto opened =
        open_pose_samples<double, 2>(game.value.part("POSE"), {.cage_hash = game.report.cage_hash});
    REQUIRE(opened.status() == Status::ok);
    PoseSolver<double, 2> solver(opened.value);
    CHECK(solver.set_pins({.binding = game.value.points}) == Status::ok);
    std::vector<Vec<double, 2>> pose(solver.samples().handle_count());
    CHECK(solver.solve(cat_targets(), pose).status == Status::ok);
}

TEST_CASE("samples of another kind or cage are refused with their own status", "[pose][blob][status]") {
    const auto samples = small_samples();
    const auto blob = packed(samples);
    const auto bytes = blob.bytes();
    CHECK(status_of(bytes) == Status::ok);
    CHECK(open_pose_samples<double, 2>(bytes).status() == Status::blob_kind_differs);
    CHECK(open_pose_samples<float, 3>(bytes).status() == Status::blob_kind_differs);
    CHECK(cageform::open_blob<float, 2>(bytes).status() == Status::not_a_blob);
    CHECK(status_of({}) == Status::not_pose_samples);
    Aligned memory(bytes);
    CHECK(status_of(memory.bytes().subspan(8)) == Status::not_pose_samples);
    const auto changed = [&]<class X>(std::size_t offset, X x) {
        Aligned copy(bytes);
        copy.set(offset, x);
        return status_of(copy.bytes());
    };
    CHECK(changed(0, std::uint64_t(1)) == Status::not_pose_samples);
    CHECK(changed(0, cageform::detail::byte_swapped(PoseBlobHeader::magic_number)) ==
          Status::blob_version_differs);
    for (const std::uint32_t version : {0u, PoseBlobHeader::current_version + 1})
        CHECK(changed(offsetof(PoseBlobHeader, version), version) == Status::blob_version_differs);
    CHECK(changed(offsetof(PoseBlobHeader, endian), std::uint32_t(0x04030201)) ==
          Status::blob_version_differs);

    const std::uint64_t hash = cageform::hash_memory(std::span<const Vec<float, 2>>(samples.rest_handles));
    CHECK(open_pose_samples<float, 2>(bytes).report.cage_hash == hash);
    CHECK(status_of(bytes, {.cage_hash = hash}) == Status::ok);
    CHECK(status_of(bytes, {.cage_hash = hash + 1}) == Status::blob_of_another_cage);
    CHECK(status_of(packed(samples, {.cage_hash = 11}).bytes(), {.cage_hash = 11}) == Status::ok);
}

TEST_CASE("truncated samples, or with a flipped bit, are refused", "[pose][blob][status]") {
    const auto blob = packed(small_samples(), {.keep_points = true});
    const auto bytes = blob.bytes();
    for (std::size_t size = 0; size < bytes.size(); size += size < 256 ? 1 : 37) {
        Aligned memory(bytes.first(size));
        CAPTURE(size);
        const auto opened = open_pose_samples<float, 2>(memory.bytes());
        CHECK(opened.status() == (size < 16 ? Status::not_pose_samples : Status::blob_truncated));
        CHECK(opened.value.handle_count() == 0);
    }
    Aligned memory(bytes);
    std::size_t accepted = 0;
    for (std::size_t byte = 0; byte < bytes.size(); byte += byte < 256 ? 1 : 23) {
        for (int bit = int(byte % 3); bit < 8; bit += 3) {
            memory.data()[byte] ^= std::byte(1 << bit);
            if (status_of(memory.bytes()) == Status::ok) ++accepted;
            memory.data()[byte] ^= std::byte(1 << bit);
        }
    }
    CHECK(accepted == 0);
    CHECK(status_of(memory.bytes()) == Status::ok);
}

TEST_CASE("every inconsistency in packed samples is found, with a valid checksum", "[pose][blob][status]") {
    const auto blob = packed(small_samples(), {.keep_points = true});
    PoseBlobHeader header;
    std::memcpy(&header, blob.bytes().data(), sizeof(header));
    const auto refused = [&]<class X>(std::size_t offset, X x) {
        Aligned memory(blob.bytes());
        memory.set(offset, x);
        memory.seal();
        const auto opened = open_pose_samples<float, 2>(memory.bytes());
        CAPTURE(offset, double(x), to_string(opened.status()));
        CHECK(opened.status() == Status::blob_malformed);
        CHECK(opened.value.handle_count() == 0);
        CHECK(opened.value.gradients.empty());
        CHECK(status_of(memory.bytes(), {.check = BlobCheck::structure}) == Status::blob_malformed);
    };
    Aligned sound(blob.bytes());
    sound.seal();
    REQUIRE(status_of(sound.bytes()) == Status::ok);
    const std::uint64_t end = blob.bytes().size();
    for (std::size_t at = offsetof(PoseBlobHeader, handles); at <= offsetof(PoseBlobHeader, samples);
         at += 8) {
        for (const std::uint64_t count :
             {std::uint64_t(0), std::uint64_t(1), std::uint64_t(1) << 20, std::uint64_t(1) << 32,
              std::uint64_t(1) << 60, ~std::uint64_t(0)}) {
            if (at != offsetof(PoseBlobHeader, weak_handle_count) || count != 1) // one less is valid
                refused(at, count);
        }
    }
    for (std::size_t at = offsetof(PoseBlobHeader, rest_handles); at <= offsetof(PoseBlobHeader, centres);
         at += 8) {
        for (const std::uint64_t offset :
             {std::uint64_t(0), std::uint64_t(64), end, end + 64, ~std::uint64_t(63), end - 4})
            refused(at, offset);
    }
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 infinite = std::numeric_limits<double>::infinity();
    for (const double x : {nan, infinite}) {
        refused(offsetof(PoseBlobHeader, centre), x);
        refused(offsetof(PoseBlobHeader, centre) + 8, x);
        refused(offsetof(PoseBlobHeader, size), x);
        refused(std::size_t(header.stiffness), x);
        refused(std::size_t(header.stiffness) + 8 * (25 + 17), x);
        for (const std::uint64_t part :
             {header.rest_handles, header.gradients, header.moments, header.points}) {
            refused(std::size_t(part), float(x));
            refused(std::size_t(part) + 60, float(x));
        }
    }
    for (const double x : {0.0, -1.0}) refused(offsetof(PoseBlobHeader, size), x);
    for (const std::uint8_t kind : {std::uint8_t(2), std::uint8_t(255)})
        refused(std::size_t(header.handle_kinds) + 1, kind);
    const auto indices = [&](std::uint64_t part, std::uint32_t most) {
        for (const std::uint32_t x : {most, most + 1, 0xFFFFFFFFu}) {
            refused(std::size_t(part), x);
            refused(std::size_t(part) + 4, x);
        }
    };
    indices(header.weak_handles, std::uint32_t(header.handles));
    indices(header.sample_clusters, std::uint32_t(header.clusters));
    indices(header.centres, std::uint32_t(header.samples));
    refused(std::size_t(header.weak_handles), std::uint32_t(7)); // not ascending
}

TEST_CASE("invalid samples are not packed", "[pose][blob][status]") {
    const auto refused = [](const auto& change, bool keep_points = false) {
        auto samples = small_samples();
        change(samples);
        const auto [blob, status] = pack(samples, {.keep_points = keep_points});
        CHECK(blob.bytes().empty() == (status != Status::ok));
        return status;
    };
    CHECK(pack(PoseSamples<double, 3>{}).status() == Status::samples_missing);
    CHECK(refused([](auto& s) { s.cluster_count = 0; }) == Status::samples_missing);
    CHECK(refused([](auto& s) { s.rest_handles.resize(4097); }) == Status::too_many_handles);
    CHECK(refused([](auto& s) { s.gradients.pop_back(); }) == Status::input_malformed);
    CHECK(refused([](auto& s) { s.cluster_count += 16; }) == Status::input_malformed);
    CHECK(refused([](auto& s) { s.handle_kinds.pop_back(); }) == Status::input_malformed);
    CHECK(refused([](auto& s) { s.stiffness.push_back(0); }) == Status::input_malformed);
    CHECK(refused([](auto& s) { s.weak_handles = {7, 3}; }) == Status::input_malformed);
    CHECK(refused([](auto& s) { s.stiffness[3] = std::nan(""); }) == Status::input_malformed);
    CHECK(refused([](auto& s) { s.centres.pop_back(); }) == Status::ok);
    CHECK(refused([](auto& s) { s.centres.pop_back(); }, true) == Status::input_malformed);
}

TEST_CASE("failed allocations of packing and reading are reported", "[pose][blob]") {
    const auto samples = small_samples();
    const auto blob = packed(samples, {.keep_points = true});
    for (const bool reads : {false, true}) {
        std::size_t failures = 0;
        for (;; ++failures) {
            failing_allocation = allocations + 1 + failures;
            const Status status = reads ? status_of(blob.bytes()) : pack(samples).status();
            failing_allocation = 0;
            if (status == Status::ok) break;
            REQUIRE(status == Status::out_of_memory);
        }
        CHECK(failures == (reads ? 9 : 1));
    }
}

TEST_CASE("hostile samples neither crash nor lead a solver out of bounds", "[pose][blob][hostile]") {
    const std::uint64_t seed = std::uint64_t(GENERATE(range(1, 4)));
    CAPTURE(seed);
    Random random(seed);
    const Aligned sound[] = {Aligned(packed(small_samples()).bytes()),
                             Aligned(packed(small_samples(), {.keep_points = true}).bytes())};
    const std::vector<Vec<float, 2>> targets{{1, 2}, {3, 1}};
    const std::size_t rounds = effort<std::size_t>(2000, 300);
    std::size_t opened_count = 0;
    for (std::size_t round = 0; round < rounds; ++round) {
        Aligned memory = sound[random.below(2)];
        for (std::size_t n = 1 + random.below(2); n > 0; --n) {
            const std::size_t reach = random.below(3) == 0 ? sizeof(PoseBlobHeader) : memory.bytes().size();
            const std::uint32_t values[] = {0,
                                            1,
                                            64,
                                            192,
                                            0xFFFFFFFFu,
                                            0x7F7FFFFFu,
                                            0xFF7FFFFFu,
                                            0x00000001u,
                                            std::uint32_t(random.bits()),
                                            std::uint32_t(random.below(memory.bytes().size()))};
            memory.set(random.below(reach / 4) * 4, values[random.below(std::size(values))]);
        }
        memory.seal();
        auto opened = open_pose_samples<float, 2>(memory.bytes(), {.check = BlobCheck::structure});
        if (opened.status() != Status::ok) continue;
        ++opened_count;
        PoseSolver<float, 2> solver(std::move(opened.value), {.hard_pins = random.below(2) == 0});
        if (solver.status() != Status::ok) continue;
        const std::size_t handles = solver.samples().handle_count();
        const cageform::Binding<float, 2> pins(
            std::vector<cageform::Lanes<float>>(handles,
                                                [] {
                                                    cageform::Lanes<float> row;
                                                    for (float& w : row.v) w = 0.04f;
                                                    return row;
                                                }()),
            std::vector<cageform::Lanes<float>>(2,
                                                [] {
                                                    cageform::Lanes<float> row;
                                                    for (float& x : row.v) x = 1;
                                                    return row;
                                                }()),
            solver.samples().rest_handles, 2);
        std::vector<Vec<float, 2>> pose(handles);
        if (solver.set_pins({.binding = pins.view()}) != Status::ok) continue;
        for (std::size_t frame = 0; frame < 2; ++frame) {
            const auto report = solver.solve(targets, pose);
            REQUIRE((report.status == Status::ok || report.status == Status::pose_not_finite));
            bool finite = true;
            for (const auto& h : pose) finite = finite && is_finite(h);
            REQUIRE(finite);
        }
    }
    CHECK(opened_count > rounds / 20);
    CHECK(opened_count < rounds);
}

} // namespace pose_blob_tests

// Blobs: opened in place, rejected with a status if invalid, safe for any bytes.
#include "../support/packed.hpp"

#include <cageform/clone/pose_handles.hpp>

#include <algorithm>
#include <cstddef>
#include <set>

namespace blob_tests {

using namespace cageform_tests;
using cageform::BlobCheck;
using cageform::BlobHeader;
using cageform::open_blob;

namespace {

cageform::PackedBinding<float, 3> small_blob(WeightFormat format = WeightFormat::int16,
                                             std::size_t largest = 4) {
    auto result = cageform::pack(random_binding<float, 3>(37, 9, 1), {.format = format, .largest = largest});
    REQUIRE(result.report.status == Status::ok);
    return std::move(result.value);
}

Status status_of(std::span<const std::byte> bytes, const cageform::BlobExpectation& expected = {}) {
    return open_blob<float, 3>(bytes, expected).status();
}

} // namespace

TEST_CASE("a blob is used in place and is relocatable", "[blob]") {
    for (const auto format :
         {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8}) {
        for (const std::size_t largest : {0u, 4u}) {
            const auto packed = small_blob(format, largest);
            Aligned elsewhere(packed.bytes());
            const auto opened = open_blob<float, 3>(elsewhere.bytes());
            REQUIRE(opened.status() == Status::ok);
            CHECK(opened.report.bytes == packed.bytes().size());
            CHECK(static_cast<const void*>(opened.value.weights) >= elsewhere.data());
            const auto pose = random_points<float, 3>(9, 10, 2);
            std::vector<Vec<float, 3>> a(37), b(37);
            CHECK(cageform::clone(packed.view(), pose, a) == Status::ok);
            CHECK(cageform::clone(opened.value, pose, b) == Status::ok);
            CHECK(a == b);
        }
    }
}

TEST_CASE("consecutive blobs in a file can be opened", "[blob]") {
    const auto first = small_blob(), second = small_blob(WeightFormat::half, 0);
    std::vector<std::byte> file(first.bytes().begin(), first.bytes().end());
    file.insert(file.end(), second.bytes().begin(), second.bytes().end());
    Aligned memory(file);
    const auto one = open_blob<float, 3>(memory.bytes());
    REQUIRE(one.status() == Status::ok);
    const auto two = open_blob<float, 3>(memory.bytes().subspan(one.report.bytes));
    REQUIRE(two.status() == Status::ok);
    CHECK(two.value.format == WeightFormat::half);
    CHECK(one.report.bytes + two.report.bytes == file.size());
}

TEST_CASE("an empty blob can be opened", "[blob]") {
    const auto packed = cageform::pack(cageform::Binding<float, 3>());
    REQUIRE(packed.report.status == Status::ok);
    CHECK(packed.value.bytes().size() == sizeof(BlobHeader));
    const auto opened = open_blob<float, 3>(packed.value.bytes());
    CHECK(opened.status() == Status::ok);
    CHECK(opened.value.points == 0);
}

TEST_CASE("a blob of another cage or figure is rejected with its status", "[blob][status]") {
    auto result = cageform::pack(random_binding<float, 3>(5, 9, 1), {.cage_hash = 11, .figure_hash = 12});
    const auto bytes = result.value.bytes();
    CHECK(status_of(bytes, {.cage_hash = 11, .figure_hash = 12}) == Status::ok);
    CHECK(status_of(bytes, {.cage_hash = 13}) == Status::blob_of_another_cage);
    CHECK(status_of(bytes, {.cage_hash = 11, .figure_hash = 13}) == Status::blob_of_another_figure);

    // The default hashes are those of the binding.
    const auto binding = random_binding<float, 3>(5, 9, 1);
    std::vector<Vec<float, 3>> handles, points;
    for (std::size_t h = 0; h < 9; ++h) handles.push_back(binding.rest_handle(h));
    for (std::size_t i = 0; i < 5; ++i) points.push_back(binding.rest_point(i));
    const auto hash = [](const auto& values) {
        return cageform::hash_memory(std::span(values.data(), values.size()));
    };
    const auto opened = open_blob<float, 3>(cageform::pack(binding).value.bytes());
    CHECK(opened.report.cage_hash == hash(handles));
    CHECK(opened.report.figure_hash == hash(points));
    points[3][1] += 1;
    CHECK(opened.report.figure_hash != hash(points));
}

TEST_CASE("a blob of another kind is rejected with its status", "[blob][status]") {
    const auto packed = small_blob();
    CHECK(open_blob<double, 3>(packed.bytes()).status() == Status::blob_kind_differs);
    CHECK(open_blob<float, 2>(packed.bytes()).status() == Status::blob_kind_differs);

    const std::vector<std::byte> text(1000, std::byte{'x'});
    CHECK(status_of(Aligned(text).bytes()) == Status::not_a_blob);
    CHECK(status_of({}) == Status::not_a_blob);
    Aligned shifted(packed.bytes());
    CHECK(status_of(shifted.bytes().subspan(8)) == Status::not_a_blob);

    Aligned newer(packed.bytes());
    newer.set(offsetof(BlobHeader, version), BlobHeader::current_version + 1);
    CHECK(status_of(newer.bytes()) == Status::blob_version_differs);
    Aligned turned(packed.bytes()); // in the other byte order
    std::reverse(turned.data(), turned.data() + 8);
    CHECK(status_of(turned.bytes()) == Status::blob_version_differs);
    Aligned tag(packed.bytes());
    tag.set(offsetof(BlobHeader, endian), std::uint32_t(0x04030201));
    CHECK(status_of(tag.bytes()) == Status::blob_version_differs);
}

TEST_CASE("a truncated blob is rejected", "[blob][status]") {
    const auto packed = small_blob();
    for (std::size_t size = 0; size < packed.bytes().size(); ++size) {
        Aligned memory(
            packed.bytes().first(size)); // of the exact size, so that sanitizers detect reads past the end
        const Status status = status_of(memory.bytes());
        CAPTURE(size);
        CHECK(status == (size < 16 ? Status::not_a_blob : Status::blob_truncated));
    }
}

TEST_CASE("a blob with any bit flipped is rejected", "[blob][status]") {
    const auto packed = small_blob();
    Aligned memory(packed.bytes());
    std::size_t accepted = 0;
    for (std::size_t byte = 0; byte < packed.bytes().size(); ++byte) {
        for (int bit = 0; bit < 8; ++bit) {
            memory.data()[byte] ^= std::byte(1 << bit);
            if (status_of(memory.bytes()) == Status::ok) ++accepted;
            memory.data()[byte] ^= std::byte(1 << bit);
        }
    }
    CHECK(accepted == 0);
    CHECK(status_of(memory.bytes()) == Status::ok);
}

TEST_CASE("every inconsistency in a blob with a valid checksum is found", "[blob][status]") {
    const auto packed = small_blob();
    const Aligned sound(packed.bytes());
    const auto refused = [&](auto change) {
        Aligned memory = sound;
        change(memory, memory.header());
        memory.seal();
        return status_of(memory.bytes()) == Status::blob_malformed &&
               status_of(memory.bytes(), {.check = BlobCheck::structure}) == Status::blob_malformed;
    };
    // Each offset of the header: past the end, misaligned, in the header, missing.
    for (std::size_t field = offsetof(BlobHeader, weights); field <= offsetof(BlobHeader, rest_handles);
         field += 8) {
        CAPTURE(field);
        const auto set = [field](std::uint64_t x) {
            return [field, x](Aligned& m, const BlobHeader&) { m.set(field, x); };
        };
        CHECK(refused(set(packed.bytes().size() + 64)));
        CHECK(refused(set(~std::uint64_t{63})));
        CHECK(refused(set(packed.bytes().size() / 64 * 64 - 4)));
        CHECK(refused(set(64)));
        if (field != offsetof(BlobHeader, order)) CHECK(refused(set(0)));
    }
    for (const std::size_t field :
         {offsetof(BlobHeader, handles), offsetof(BlobHeader, points), offsetof(BlobHeader, rows)}) {
        CAPTURE(field);
        for (const std::uint64_t x :
             {std::uint64_t(1) << 20, ~std::uint64_t{0}, std::uint64_t(1) << 32, std::uint64_t(1) << 60})
            CHECK(refused([field, x](Aligned& m, const BlobHeader&) { m.set(field, x); }));
    }
    CHECK(refused(
        [](Aligned& m, const BlobHeader&) { m.set(offsetof(BlobHeader, format), std::uint32_t(4)); }));
    CHECK(
        refused([](Aligned& m, const BlobHeader& h) { m.set(std::size_t(h.row_begin), std::uint32_t(1)); }));
    CHECK(refused(
        [](Aligned& m, const BlobHeader& h) { m.set(std::size_t(h.row_begin) + 4, std::uint32_t(9999)); }));
    CHECK(refused(
        [](Aligned& m, const BlobHeader& h) { m.set(std::size_t(h.row_handle) + 2, std::uint16_t(9)); }));
    CHECK(
        refused([](Aligned& m, const BlobHeader& h) { m.set(std::size_t(h.order) + 8, std::uint32_t(37)); }));
    Aligned untouched = sound;
    untouched.seal();
    CHECK(status_of(untouched.bytes()) == Status::ok);
}

namespace {

/// A blob with three point handles and two vectors, optionally with faces of the vectors.
cageform::PackedBinding<float, 3> blob_with_vectors(bool faces) {
    using cageform::HandleKind;
    const auto points = random_binding<float, 3>(20, 5, 2);
    const HandleKind kinds[] = {HandleKind::point, HandleKind::vector, HandleKind::point, HandleKind::point,
                                HandleKind::vector};
    const cageform::HandleFace<3> corners[] = {{0, 2, 3}, {3, 2, 0}};
    auto view = points.view();
    view.handle_kinds = kinds;
    view.handle_faces = faces ? corners : nullptr;
    auto result = cageform::pack(view, {.format = WeightFormat::half, .largest = 4});
    REQUIRE(result.report.status == Status::ok);
    return std::move(result.value);
}

/// As above, with two loops whose means are corners of the faces.
cageform::PackedBinding<float, 3> blob_with_loops() {
    using cageform::HandleKind;
    const auto points = random_binding<float, 3>(20, 5, 2);
    const HandleKind kinds[] = {HandleKind::point, HandleKind::vector, HandleKind::point, HandleKind::point,
                                HandleKind::vector};
    const cageform::HandleFace<3> corners[] = {{0, 2, 5}, {6, 2, 0}};
    const std::uint32_t loops[] = {3, 6, 8, 0, 2, 3, 3, 0};
    auto view = points.view();
    view.handle_kinds = kinds;
    view.handle_faces = corners;
    view.handle_loops = loops;
    auto result = cageform::pack(view, {.format = WeightFormat::half, .largest = 4});
    REQUIRE(result.report.status == Status::ok);
    return std::move(result.value);
}

} // namespace

TEST_CASE("a blob keeps the kinds of handles and their faces", "[blob][handle_kinds]") {
    const auto packed = blob_with_vectors(true), bare = blob_with_vectors(false);
    const auto opened = open_blob<float, 3>(packed.bytes());
    REQUIRE(opened.status() == Status::ok);
    const auto handles = opened.value.handle_view();
    CHECK(handles.vector_count() == 2);
    CHECK_FALSE(handles.is_point(1));
    CHECK(handles.faces[1] == cageform::HandleFace<3>{3, 2, 0});
    CHECK(open_blob<float, 3>(bare.bytes()).value.handle_faces == nullptr);
    CHECK(open_blob<float, 3>(small_blob().bytes()).value.handle_kinds == nullptr);

    const auto refused = [&](auto change) {
        Aligned memory(packed.bytes());
        change(memory, memory.header());
        memory.seal();
        return status_of(memory.bytes()) == Status::blob_malformed;
    };
    const auto corner = [](std::size_t place, std::uint32_t handle) {
        return [place, handle](Aligned& m, const BlobHeader& h) {
            m.set(std::size_t(h.handle_faces) + 4 * place, handle);
        };
    };
    CHECK_FALSE(refused(corner(0, 2)));
    for (const std::size_t place : {0u, 3u, 5u}) {
        CHECK(refused(corner(place, 5)));           // no handle
        CHECK(refused(corner(place, 0xFFFFFFFFu))); // far out of range
        CHECK(refused(corner(place, 1)));           // a vector
    }
    for (const auto kind : {std::uint8_t(0), std::uint8_t(2), std::uint8_t(255)})
        CHECK(refused(
            [kind](Aligned& m, const BlobHeader& h) { m.set(std::size_t(h.handle_kinds) + 1, kind); }));
    for (const std::uint64_t x : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{3}, ~std::uint64_t{0}})
        CHECK(refused([x](Aligned& m, const BlobHeader&) { m.set(offsetof(BlobHeader, vectors), x); }));
    for (const std::size_t field : {offsetof(BlobHeader, handle_kinds), offsetof(BlobHeader, handle_faces)}) {
        for (const std::uint64_t x :
             {packed.bytes().size() + 64, packed.bytes().size() - 4, ~std::size_t{63}, std::size_t{64}})
            CHECK(refused([field, x](Aligned& m, const BlobHeader&) { m.set(field, std::uint64_t(x)); }));
    }
    CHECK(refused([](Aligned& m, const BlobHeader&) { // vectors without handle_kinds
        m.set(offsetof(BlobHeader, handle_kinds), std::uint64_t{0});
    }));
}

TEST_CASE("a blob keeps the loops whose means are corners of faces", "[blob][handle_kinds]") {
    const auto packed = blob_with_loops();
    BlobHeader header;
    std::memcpy(&header, packed.bytes().data(), sizeof(header));
    CHECK(header.loop_numbers == 8);
    const auto bare = blob_with_vectors(true);
    std::memcpy(&header, bare.bytes().data(), sizeof(header));
    CHECK(header.handle_loops == 0); // blobs without loops have no table
    CHECK(header.loop_numbers == 0);
    const auto opened = open_blob<float, 3>(packed.bytes());
    REQUIRE(opened.status() == Status::ok);
    const auto handles = opened.value.handle_view();
    const std::uint32_t table[] = {3, 6, 8, 0, 2, 3, 3, 0};
    REQUIRE(handles.loop_numbers() == std::size(table));
    CHECK(std::equal(std::begin(table), std::end(table), handles.loops));

    const auto refused = [&](auto change) {
        Aligned memory(packed.bytes());
        change(memory, memory.header());
        memory.seal();
        return status_of(memory.bytes()) == Status::blob_malformed;
    };
    const auto number = [](std::size_t place, std::uint32_t x) {
        return [place, x](Aligned& m, const BlobHeader& h) {
            m.set(std::size_t(h.handle_loops) + 4 * place, x);
        };
    };
    CHECK_FALSE(refused(number(3, 2)));
    for (const std::uint32_t x : {0u, 1u, 2u, 4u, 8u, 9u, 0xFFFFFFFFu}) CHECK(refused(number(0, x)));
    for (const std::uint32_t x : {0u, 3u, 8u, 9u, 0xFFFFFFFFu}) CHECK(refused(number(1, x)));
    for (const std::uint32_t x : {0u, 6u, 7u, 9u, 0xFFFFFFFFu}) CHECK(refused(number(2, x)));
    for (const std::size_t place : {3u, 5u, 6u, 7u}) {
        CHECK(refused(number(place, 1))); // a vector
        CHECK(refused(number(place, 5))); // no handle
        CHECK(refused(number(place, 0xFFFFFFFFu)));
    }
    const auto corner = [](std::uint32_t handle) {
        return [handle](Aligned& m, const BlobHeader& h) { m.set(std::size_t(h.handle_faces) + 8, handle); };
    };
    CHECK_FALSE(refused(corner(6)));
    CHECK(refused(corner(7))); // there are two loops
    CHECK(refused(corner(0xFFFFFFFFu)));
    for (const std::uint32_t x : {0u, 1u, 7u, 9u, 0xFFFFFFFFu})
        CHECK(refused([x](Aligned& m, const BlobHeader&) { m.set(offsetof(BlobHeader, loop_numbers), x); }));
    // Without the table a corner is out of range, so older readers reject such a blob.
    for (const std::uint64_t x : {std::uint64_t{0}, std::uint64_t(packed.bytes().size()), ~std::uint64_t{63}})
        CHECK(refused([x](Aligned& m, const BlobHeader&) { m.set(offsetof(BlobHeader, handle_loops), x); }));
}

TEST_CASE("blobs of version 1 can be read: all handles are points", "[blob]") {
    const auto packed = small_blob();
    Aligned older(packed.bytes());
    older.set(offsetof(BlobHeader, version), std::uint32_t(1));
    for (std::size_t field = offsetof(BlobHeader, handle_kinds); field < sizeof(BlobHeader); field += 8)
        older.set(field, std::uint64_t(64)); // was padding
    older.set(offsetof(BlobHeader, loop_numbers), std::uint32_t(7));
    older.seal();
    const auto opened = open_blob<float, 3>(older.bytes());
    REQUIRE(opened.status() == Status::ok);
    CHECK(opened.value.handle_kinds == nullptr);
    CHECK(opened.value.handle_faces == nullptr);
    CHECK(opened.value.handle_loops == nullptr);
    const auto pose = random_points<float, 3>(9, 10, 2);
    std::vector<Vec<float, 3>> a(37), b(37);
    CHECK(cageform::clone(packed.view(), pose, a) == Status::ok);
    CHECK(cageform::clone(opened.value, pose, b) == Status::ok);
    CHECK(a == b);
    older.set(offsetof(BlobHeader, version), std::uint32_t(0));
    CHECK(status_of(older.bytes()) == Status::blob_version_differs);
}

TEST_CASE("hostile blobs never cause access out of bounds", "[blob][hostile]") {
    // Sanitizers check the accesses; here, that it terminates and that some variants open.
    std::vector<Aligned> sound;
    for (const auto format :
         {WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8}) {
        sound.emplace_back(small_blob(format, 4).bytes());
        sound.emplace_back(small_blob(format, 0).bytes());
    }
    sound.emplace_back(blob_with_vectors(true).bytes());
    sound.emplace_back(blob_with_loops().bytes());
    Random random{std::uint64_t(GENERATE(range(0, 4)))};
    std::size_t opened_count = 0;
    for (int round = 0; round < 20000; ++round) {
        Aligned memory = sound[random.below(sound.size())];
        const std::size_t changes = 1 + random.below(4);
        for (std::size_t n = 0; n < changes; ++n) {
            // Mostly the header and the tables, with small and huge numbers.
            const std::size_t reach = random.below(2) == 0 ? sizeof(BlobHeader) : memory.bytes().size();
            const std::size_t at = random.below(reach / 4) * 4;
            const std::uint32_t values[] = {0,
                                            1,
                                            64,
                                            192,
                                            0xFFFFFFFFu,
                                            std::uint32_t(random.bits()),
                                            std::uint32_t(random.below(memory.bytes().size()))};
            memory.set(at, values[random.below(std::size(values))]);
        }
        if (random.below(2) == 0) memory.seal();
        const auto opened = open_blob<float, 3>(
            memory.bytes(), {.check = random.below(2) == 0 ? BlobCheck::all : BlobCheck::structure});
        if (opened.status() != Status::ok) continue;
        ++opened_count;
        const std::vector<Vec<float, 3>> pose(opened.value.handle_count(), Vec<float, 3>{1, 2, 3});
        std::vector<Vec<float, 3>> out(opened.value.point_count());
        const Status status = cageform::clone(opened.value, pose, out);
        CHECK((status == Status::ok || status == Status::pose_not_finite));
        const auto handles = opened.value.handle_view();
        if (handles.vector_count() == 0 || handles.faces == nullptr) continue;
        std::vector<Vec<float, 3>> posed(handles.count);
        const std::span vertices(pose.data(), handles.count - handles.vector_count());
        CHECK(cageform::pose_handles(opened.value, vertices, posed).status == Status::ok);
    }
    CHECK(opened_count > 1000);
}

TEST_CASE("hashes differ for different data and do not depend on the platform", "[blob][hash]") {
    std::vector<std::uint8_t> bytes(200);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = std::uint8_t(i * 7);
    const auto hash = [&](std::size_t size, std::uint64_t seed = 0) {
        return cageform::hash_memory(std::span<const std::uint8_t>(bytes.data(), size), seed);
    };
    std::set<std::uint64_t> seen;
    for (std::size_t size = 0; size <= bytes.size(); ++size) CHECK(seen.insert(hash(size)).second);
    for (std::uint64_t seed = 1; seed < 50; ++seed) CHECK(seen.insert(hash(200, seed)).second);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        for (int bit = 0; bit < 8; ++bit) {
            bytes[i] ^= std::uint8_t(1 << bit);
            CHECK(seen.insert(hash(200)).second);
            bytes[i] ^= std::uint8_t(1 << bit);
        }
    }
}

} // namespace blob_tests

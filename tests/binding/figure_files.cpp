// Tests the other contents of a figure file: clips, levels of less detail, and bindings in full
// precision for editors.
#include "../support/allocation_count.hpp"
#include "../support/figures.hpp"
#include "../support/keys.hpp"
#include "../support/packed.hpp"

#include <cageform/animate/compile.hpp>
#include <cageform/animate/pack_clip.hpp>
#include <cageform/binding/rebind_cage.hpp>
#include <cageform/binding/unpack.hpp>
#include <cageform/clone/clone_figure.hpp>
#include <cageform/coordinates/green.hpp>
#include <cageform/coordinates/mean_value.hpp>

namespace figure_file_tests {

using namespace cageform_tests;
using cageform::bind;
using cageform::BlobCheck;
using cageform::FigureBinding;
using cageform::FigureClipData;
using cageform::FigureHeader;
using cageform::FigureOutput;
using cageform::FigurePackOptions;
using cageform::FigurePart;
using cageform::FigurePartData;
using cageform::FigurePoints;
using cageform::FigureTag;
using cageform::FigureTags;
using cageform::open;
using cageform::pack;
using cageform::PackedClip;

namespace {

using Mean3 = cageform::MeanValueCoordinates<float, 3>;

const cageform::TriangleMesh<float>& cage() {
    static const auto mesh = divided_box({1, 1, 1}, 1).mesh<float>();
    return mesh;
}

/// A figure with all parts, well inside the cage.
struct Parts {
    Points3<float> points, normals;
    std::vector<std::array<float, 4>> tangents;

    explicit Parts(std::size_t count, std::uint64_t seed)
        : points(points_in(cage(), count, seed)) {
        Random random(seed);
        const auto number = [&random] { return float(random.uniform(-1, 1)); };
        for (auto& p : points) {
            p = 0.7f * p;
            normals.push_back({number(), number(), number()});
            tangents.push_back({number(), number(), number(), random.below(2) == 0 ? 1.0f : -1.0f});
        }
    }
    template <class C>
    FigureBinding<float, 3> bind(const C& coordinates) const {
        auto result = cageform::bind(coordinates, FigurePoints{points, normals, tangents});
        REQUIRE(result.report.status == Status::ok);
        std::vector<std::string> labels;
        for (std::size_t h = 0; h < result.value.points.handle_count(); ++h)
            labels.push_back(h % 3 == 1 ? "" : "corner " + std::to_string(h));
        REQUIRE(result.value.set_labels(labels) == Status::ok);
        return std::move(result.value);
    }
};

const FigureBinding<float, 3>& small_figure() {
    static const auto figure = Parts(37, 1).bind(Mean3(cage()));
    return figure;
}

cageform::CageClip<float, 3> random_clip(std::size_t vertices, std::uint64_t seed) {
    Random random(seed);
    std::vector<std::vector<cageform::Key>> keys(3 * vertices);
    for (auto& of_curve : keys) {
        for (int n = 0; n < 4; ++n)
            of_curve.push_back(key(n + random.uniform(0, 0.5), random.uniform(-2, 2)));
    }
    return cageform::compile<float, 3>(keys).value;
}

Status status_of(std::span<const std::byte> bytes, BlobCheck check = BlobCheck::all) {
    const auto opened = cageform::open<float, 3>(bytes, {.check = check});
    if (opened.status() != Status::ok) {
        CHECK(opened.value.point_count() == 0);
        CHECK(opened.value.clip_count() == 0);
        CHECK(opened.value.table.empty());
    }
    return opened.status();
}

std::uint32_t version_of(std::span<const std::byte> bytes) {
    FigureHeader header;
    std::memcpy(&header, bytes.data(), sizeof(header));
    return header.version;
}

/// The offset of a part.
std::size_t offset_of(Aligned& memory, FigureTag tag) {
    for (std::size_t at = sizeof(FigureHeader);; at += sizeof(FigurePart)) {
        FigurePart part;
        std::memcpy(&part, memory.data() + at, sizeof(part));
        if (part.tag == tag) return std::size_t(part.offset);
    }
}

bool same_bytes(std::span<const std::byte> a, std::span<const std::byte> b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size()) == 0);
}

/// Packed without loss.
bool same_figure(const FigureBinding<float, 3>& a, const FigureBinding<float, 3>& b) {
    const auto packed_a = cageform::pack(a), packed_b = cageform::pack(b);
    REQUIRE(packed_a.report.status == Status::ok);
    REQUIRE(packed_b.report.status == Status::ok);
    return same_bytes(packed_a.value.bytes(), packed_b.value.bytes());
}

} // namespace

TEST_CASE("a file contains a figure and its clips, found by name and played without allocation",
          "[figure][clips]") {
    const auto& figure = small_figure();
    const std::size_t handles = figure.points.handle_count();
    const std::array clips{random_clip(handles, 1), random_clip(handles, 2)};
    const std::array packed{pack_clip(clips[0]).value, pack_clip(clips[1], {.tolerance = 1e-3}).value};
    const FigureClipData named[] = {{"walk", packed[0].bytes()}, {"run and jump", packed[1].bytes()}};
    const std::array note{std::byte{7}};
    const FigurePartData parts[] = {{"NOTE", note}};
    const auto made = cageform::pack(figure, {.clips = named, .parts = parts});
    REQUIRE(made.report.status == Status::ok);
    CHECK(version_of(made.value.bytes()) == 2);
    Aligned file(made.value.bytes());
    std::vector<Vec<float, 3>> pose(handles), expected(handles), out(37), up(37);
    std::array cursors{clips[0].make_cursor(), clips[0].make_cursor()};
    cursors[1] = packed[1].view().make_cursor();
    std::vector<cageform::Lanes<float>> memory(clips[0].view().cursor_rows());
    const std::size_t before = allocations;
    const auto opened = cageform::open<float, 3>(file.bytes());
    bool same = opened.status() == Status::ok && opened.value.clip_count() == 2;
    for (std::size_t n = 0; n < opened.value.clip_count(); ++n) {
        const auto clip = opened.value.clip(opened.value.find_clip(n == 0 ? "walk" : "run and jump"));
        auto cursor = clip.make_cursor(memory);
        for (int frame = 0; frame < 300; ++frame) {
            clip.sample(float(frame) / 60, cursor, pose);
            packed[n].view().sample(float(frame) / 60, cursors[n], expected);
            same = same && pose == expected && clone(opened.value, pose, FigureOutput{out, up}) == Status::ok;
        }
    }
    const std::size_t after = allocations;
    CHECK(same);
    CHECK(after == before);
    CHECK(opened.value.clip_name(0) == "walk");
    CHECK(opened.value.clip_name(1) == "run and jump");
    CHECK(opened.value.find_clip("walk") == 0);
    CHECK(opened.value.find_clip("run and jump") == 1);
    CHECK(opened.value.find_clip("fly") == 2);
    CHECK(opened.value.part("NOTE").size() == 1);
    CHECK(opened.value.label(0) == "corner 0");
    for (std::size_t size = 0; size < file.bytes().size(); size += size < 256 ? 1 : 997)
        CHECK(status_of(Aligned(made.value.bytes().first(size)).bytes()) != Status::ok);
}

TEST_CASE("clips of another cage or with equal names are rejected by pack and open",
          "[figure][clips][status]") {
    const auto& figure = small_figure();
    const std::size_t handles = figure.points.handle_count();
    const PackedClip<float, 3> sound(random_clip(handles, 1).view()),
        fewer(random_clip(handles - 1, 1).view());
    const cageform::CageClip<float, 2> flat;
    const PackedClip<float, 2> of_the_plane(flat.view());
    const auto refused = [&](std::span<const std::byte> bytes, std::string_view name, Status status) {
        const FigureClipData named[] = {{"sound", sound.bytes()}, {name, bytes}};
        const auto [packed, report] = cageform::pack(figure, {.clips = named});
        CHECK(report.status == status);
        CHECK(report.culprit == FigureTags::clips);
        CHECK(report.culprit_clip == 1);
        CHECK(packed.bytes().empty());
    };
    refused(fewer.bytes(), "fewer", Status::blob_of_another_cage);
    refused(sound.bytes(), "sound", Status::duplicate_name);
    refused(of_the_plane.bytes(), "flat", Status::blob_kind_differs);
    refused({}, "none", Status::not_a_clip);
    refused(sound.bytes().first(128), "short", Status::blob_truncated);

    // In the part of clips in a file: each is valid by itself.
    const FigureClipData named[] = {{"a", sound.bytes()}, {"b", sound.bytes()}};
    const auto made = cageform::pack(figure, {.clips = named});
    REQUIRE(made.report.status == Status::ok);
    const auto part = cageform::open<float, 3>(made.value.bytes()).value.part(FigureTags::clips);
    std::vector<FigurePartData> parts;
    const auto more = Parts(20, 2).bind(Mean3(divided_box({2, 1, 1}, 1).mesh<float>()));
    const auto other = cageform::pack(more.points).value;
    REQUIRE(more.points.handle_count() != handles);
    parts.push_back({FigureTags::points, other.bytes()});
    parts.push_back({FigureTags::clips, part});
    const cageform::PackedFigure<float, 3> astray(parts);
    const auto opened = cageform::open<float, 3>(astray.bytes());
    CHECK(opened.status() == Status::blob_of_another_cage);
    CHECK(opened.report.culprit == FigureTags::clips);

    const auto harmed = [&]<class X>(std::size_t at, X x) {
        Aligned memory(made.value.bytes());
        memory.set(offset_of(memory, FigureTags::clips) + at, x);
        memory.seal();
        return status_of(memory.bytes());
    };
    CHECK(harmed(0, std::uint64_t(2)) == Status::ok);
    for (const std::uint64_t count : {std::uint64_t(1000), ~std::uint64_t(0), std::uint64_t(1) << 60})
        CHECK(harmed(0, count) == Status::blob_malformed);
    for (const std::size_t line : {8u, 32u}) {
        CHECK(harmed(line, std::uint64_t(72)) == (line == 8 ? Status::not_a_clip : Status::blob_malformed));
        CHECK(harmed(line, std::uint64_t(0)) == Status::blob_malformed);
        CHECK(harmed(line, ~std::uint64_t(63)) == Status::blob_malformed);
        CHECK(harmed(line + 8, std::uint64_t(64)) == Status::blob_truncated);
        CHECK(harmed(line + 8, ~std::uint64_t(0)) == Status::blob_malformed);
        CHECK(harmed(line + 16, ~std::uint32_t(0)) == Status::blob_malformed);
        CHECK(harmed(line + 20, ~std::uint32_t(0)) == Status::blob_malformed);
    }
}

TEST_CASE("clips pose only the vertices if some handles are vectors", "[figure][clips][green]") {
    const Parts parts(20, 3);
    const cageform::GreenCoordinates<float, 3> coordinates(cage());
    const auto bound = cageform::bind(coordinates, FigurePoints{parts.points});
    REQUIRE(bound.report.status == Status::ok);
    const std::size_t vertices = cage().size(), handles = bound.value.points.handle_count();
    REQUIRE(handles > vertices);
    for (const std::size_t count : {vertices, handles, vertices + 1}) {
        const PackedClip<float, 3> clip(random_clip(count, 1).view());
        const FigureClipData named[] = {{"a", clip.bytes()}};
        CHECK(cageform::pack(bound.value, {.clips = named}).report.status ==
              (count == vertices + 1 ? Status::blob_of_another_cage : Status::ok));
    }
}

TEST_CASE("figures without clips and levels have version 1, and parts of the user keep their tags",
          "[figure][clips][version]") {
    const auto& figure = small_figure();
    const auto bare = cageform::pack(figure);
    CHECK(version_of(bare.value.bytes()) == 1);
    const std::array note{std::byte{7}, std::byte{8}};
    const FigurePartData taken[] = {{FigureTags::clips, note}};
    CHECK(cageform::pack(figure, {.parts = taken}).report.status == Status::duplicate_tag);
    const FigurePartData level[] = {{FigureTags::level(3), note}};
    CHECK(cageform::pack(figure, {.parts = level}).report.status == Status::duplicate_tag);
    // As written before clips existed.
    const auto points = cageform::pack(figure.points).value;
    const FigurePartData parts[] = {{FigureTags::points, points.bytes()}, {FigureTags::clips, note}};
    Aligned file(cageform::PackedFigure<float, 3>(parts).bytes());
    CHECK(status_of(file.bytes()) == Status::blob_malformed);
    file.set(offsetof(FigureHeader, version), std::uint32_t(1));
    file.seal();
    const auto opened = cageform::open<float, 3>(file.bytes());
    REQUIRE(opened.status() == Status::ok);
    CHECK(opened.value.clip_count() == 0);
    CHECK(opened.value.part(FigureTags::clips).size() == 2);
    const FigurePartData named_as_level[] = {{FigureTags::points, points.bytes()},
                                             {FigureTags::level(1), note}};
    Aligned older(cageform::PackedFigure<float, 3>(named_as_level).bytes());
    older.set(offsetof(FigureHeader, version), std::uint32_t(1));
    older.seal();
    const auto opened_older = cageform::open<float, 3>(older.bytes());
    REQUIRE(opened_older.status() == Status::ok);
    CHECK(opened_older.value.level_count() == 0);
    CHECK(open_level(opened_older.value, 1).status() == Status::not_a_figure);
}

// Otherwise a small file could have the same clip read a thousand times.
TEST_CASE("overlapping clips of a figure are rejected", "[figure][clips][refused]") {
    const auto& figure = small_figure();
    const auto clip = pack_clip(random_clip(figure.points.handle_count(), 1)).value;
    const FigureClipData named[] = {{"walk", clip.bytes()}, {"run", clip.bytes()}};
    const auto made = cageform::pack(figure, {.clips = named});
    REQUIRE(made.report.status == Status::ok);
    Aligned file(made.value.bytes());
    const auto opened = cageform::open<float, 3>(file.bytes());
    REQUIRE(opened.status() == Status::ok);
    CHECK(same_bytes(opened.value.clip_bytes(1), clip.bytes()));
    const auto first = opened.value.clips[0];
    file.set(offset_of(file, FigureTags::clips) + sizeof(std::uint64_t) + sizeof(cageform::FigureClip),
             first);
    file.seal();
    CHECK(status_of(file.bytes()) == Status::blob_malformed);
}

TEST_CASE("rebind_cage rejects a handedness of another size", "[figure][rebind][refused]") {
    auto figure = small_figure();
    figure.handedness.push_back(1);
    CHECK(rebind_cage(figure, Mean3(cage())).report.status == Status::vectors_do_not_match);
}

// The vector of an edge may equal a vertex.
TEST_CASE("match_handles matches points with points and vectors with vectors", "[figure][rebind]") {
    using Point = Vec<double, 2>;
    const std::vector<Point> before{{0, 0}, {1, 0}, {0, 1}, {1, 0}},
        after{{0, 0}, {1, 0}, {0, 1}, {2, 2}, {1, 0}};
    using cageform::HandleKind;
    const std::vector<HandleKind> kinds_before{HandleKind::point, HandleKind::point, HandleKind::point,
                                               HandleKind::vector};
    const std::vector<HandleKind> kinds_after{HandleKind::point, HandleKind::point, HandleKind::point,
                                              HandleKind::point, HandleKind::vector};
    const auto matched = cageform::match_handles<double, 2>({before.data(), 4, kinds_before.data(), nullptr},
                                                            {after.data(), 5, kinds_after.data(), nullptr});
    CHECK(matched == std::vector<std::size_t>{0, 1, 2, cageform::new_handle, 3});
}

TEST_CASE("one pose applies to all levels of detail", "[figure][levels]") {
    const Mean3 coordinates(cage());
    const Parts detailed(60, 4), coarse(15, 5), coarsest(6, 6);
    std::vector<cageform::PackedFigure<float, 3>> made;
    for (const Parts* parts : {&coarse, &coarsest})
        made.push_back(cageform::pack(parts->bind(coordinates), {.weights = {.tolerance = 0.01}}).value);
    const std::span<const std::byte> levels[] = {made[0].bytes(), made[1].bytes()};
    const auto [packed, report] = cageform::pack(detailed.bind(coordinates), {.levels = levels});
    REQUIRE(report.status == Status::ok);
    const auto opened = cageform::open<float, 3>(packed.bytes());
    REQUIRE(opened.status() == Status::ok);
    REQUIRE(opened.value.level_count() == 2);
    const auto pose = shaken(coordinates.handles(), 0.1, 3);
    for (std::size_t n = 0; n <= 2; ++n) {
        const auto level = open_level(opened.value, n);
        REQUIRE(level.status() == Status::ok);
        const Parts& parts = n == 0 ? detailed : n == 1 ? coarse : coarsest;
        REQUIRE(level.value.point_count() == parts.points.size());
        Points3<float> out(parts.points.size());
        REQUIRE(clone(level.value, pose, out) == Status::ok);
        const auto expected = cloned(cageform::bind(coordinates, parts.points).value, pose);
        for (std::size_t i = 0; i < out.size(); ++i) CHECK(distance(out[i], expected[i]) <= 0.0101);
    }
    CHECK(open_level(opened.value, 3).status() == Status::not_a_figure);

    const auto elsewhere = cageform::pack(Parts(9, 7).bind(Mean3(divided_box({2, 1, 1}, 1).mesh<float>())));
    const std::span<const std::byte> of_another_cage[] = {made[0].bytes(), elsewhere.value.bytes()};
    const auto refused = cageform::pack(detailed.bind(coordinates), {.levels = of_another_cage});
    CHECK(refused.report.status == Status::blob_of_another_cage);
    CHECK(refused.report.culprit == FigureTags::level(2));
    const std::span<const std::byte> nested[] = {packed.bytes()};
    CHECK(cageform::pack(detailed.bind(coordinates), {.levels = nested}).report.status ==
          Status::blob_malformed);
    const std::vector<std::span<const std::byte>> many(10, made[0].bytes());
    CHECK(cageform::pack(detailed.bind(coordinates), {.levels = many}).report.status ==
          Status::too_many_parts);
    // In a hand-made file.
    const auto points = cageform::pack(detailed.bind(coordinates).points).value;
    for (const auto& [bytes, status] :
         {std::pair(made[0].bytes(), Status::ok), std::pair(packed.bytes(), Status::blob_malformed),
          std::pair(elsewhere.value.bytes(), Status::blob_of_another_cage)}) {
        const FigurePartData parts[] = {{FigureTags::points, points.bytes()}, {FigureTags::level(1), bytes}};
        const cageform::PackedFigure<float, 3> figure(parts);
        CHECK(status_of(figure.bytes()) == status);
    }
    const FigurePartData gap[] = {{FigureTags::points, points.bytes()},
                                  {FigureTags::level(2), made[0].bytes()}};
    CHECK(status_of(cageform::PackedFigure<float, 3>(gap).bytes()) == Status::blob_malformed);
}

TEST_CASE("a saved, opened and rebound figure has the bits of the original", "[figure][unpack][rebind]") {
    const auto seed = std::uint64_t(GENERATE(seeds(3)));
    CAPTURE(seed);
    const Parts parts(45, seed);
    const auto figure = parts.bind(Mean3(cage()));
    const auto saved = cageform::pack(figure);
    REQUIRE(saved.report.status == Status::ok);
    Aligned file(saved.value.bytes());
    const auto opened = cageform::open<float, 3>(file.bytes());
    REQUIRE(opened.status() == Status::ok);

    const auto unpacked = cageform::unpack(opened.value);
    REQUIRE(unpacked.status() == Status::ok);
    CHECK(same_figure(unpacked.value, figure));
    for (std::size_t i = 0; i < 45; ++i) {
        for (std::size_t h = 0; h < cage().size(); ++h)
            CHECK(unpacked.value.points.weight(i, h) == figure.points.weight(i, h));
    }

    // An edited cage: from the file, from memory, and bound from points.
    const Mean3 edited(shaken(cage().vertices(), 0.05, seed), cage().faces());
    const auto from_file = rebind_cage(opened.value, edited), from_memory = rebind_cage(figure, edited);
    REQUIRE(from_file.report.status == Status::ok);
    CHECK(same_figure(from_file.value, from_memory.value));
    const auto anew = cageform::bind(edited, parts.points);
    CHECK(same_bytes(cageform::pack(anew.value).value.bytes(),
                     cageform::pack(from_file.value.points).value.bytes()));

    // A figure packed with loss keeps its points at rest, so it can be rebound too.
    for (const auto& weights : {cageform::PackOptions{.tolerance = 0.01},
                                {.format = WeightFormat::int8},
                                {.format = WeightFormat::half, .largest = 5}}) {
        const auto shipped = cageform::pack(figure, {.weights = weights});
        REQUIRE(shipped.report.status == Status::ok);
        const auto of_game = cageform::open<float, 3>(shipped.value.bytes());
        REQUIRE(of_game.status() == Status::ok);
        CHECK(same_figure(rebind_cage(of_game.value, edited).value, from_memory.value));
        CHECK_FALSE(of_game.value.points.is_dense());
        const auto refused = cageform::unpack(of_game.value);
        CHECK(refused.status() == Status::binding_not_dense);
        CHECK(refused.value.points.point_count() == 0);
    }
}

TEST_CASE("compose of a figure equals compose of its bindings", "[figure][compose]") {
    const Parts parts(30, 8);
    const Mean3 coordinates(cage());
    const auto fine = parts.bind(coordinates);
    const auto outer = divided_box({1, 1, 1}, 3).mesh<float>();
    const auto coarse = cageform::bind(Mean3(outer), coordinates.handles()).value;
    const auto [figure, report] = compose(fine, coarse);
    REQUIRE(report.status == Status::ok);
    CHECK(report.still.empty());
    CHECK(figure.points.handle_count() == outer.size());
    const auto pose = shaken(outer.vertices(), 0.2, 8), between = cloned(coarse, pose);
    Points3<float> out(30), up(30), out_twice(30), up_twice(30);
    std::vector<std::array<float, 4>> along(30), along_twice(30);
    REQUIRE(clone(figure, pose, FigureOutput{out, up, along}) == Status::ok);
    REQUIRE(clone(fine, between, FigureOutput{out_twice, up_twice, along_twice}) == Status::ok);
    for (std::size_t i = 0; i < 30; ++i) {
        CHECK(distance(out[i], out_twice[i]) <= 1e-5);
        CHECK(distance(up[i], up_twice[i]) <= 1e-4);
        CHECK(along[i][3] == along_twice[i][3]);
    }
    CHECK(cageform::open<float, 3>(cageform::pack(figure).value.bytes()).status() == Status::ok);
    const auto refused = compose(fine, fine.points);
    CHECK(refused.status() == Status::bindings_differ);
    CHECK(refused.value.points.point_count() == 0);
}

} // namespace figure_file_tests

// Figures that are written piece by piece: they open as those of `pack` do and clone as their pieces do; only
// whole ones have a record.
#include "../catch.hpp"
#include "../support/aligned.hpp"
#include "../support/cages.hpp"
#include "../support/meshes.hpp"

#include "files/figure_stream.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/mean_value.hpp>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

namespace figure_stream_tests {

using namespace cageform_support;
using namespace cageform_tests;
using cageform::PackOptions;
using cageform::Status;
using cageform::WeightFormat;

namespace {

/// Tests run beside each other: each has a folder of its own.
const std::filesystem::path folder =
    std::filesystem::temp_directory_path() / ("cageform-stream-" + std::to_string(std::random_device()()));
const std::string path = (folder / "a.figure").string();

std::string bytes_of_file() {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

struct Streamed {
    std::string text;
    TileRecord record;
    Points3<float> cloned; // by the pieces
};

/// Binds points in pieces, packs each, and appends it to a figure.
Streamed stream(const cageform::TriangleMesh<float>& cage, const Points3<float>& points, std::size_t piece,
                const PackOptions& options, const Points3<float>& pose) {
    const cageform::MeanValueCoordinates<float, 3> coordinates(cage);
    std::filesystem::create_directories(folder);
    FigureStream figure(path);
    Streamed streamed;
    std::size_t first = 0;
    do {
        const Points3<float> part(points.begin() + std::ptrdiff_t(first),
                                  points.begin() + std::ptrdiff_t(std::min(first + piece, points.size())));
        const auto bound = cageform::bind(coordinates, part);
        REQUIRE(bound);
        const auto packed = cageform::pack(bound.value, options);
        REQUIRE(packed);
        (void)figure.append(packed.value.bytes(), part);
        REQUIRE(figure.error() == "");
        Points3<float> cloned(part.size());
        REQUIRE(clone(packed.value.view(), pose, cloned) == Status::ok);
        streamed.cloned.insert(streamed.cloned.end(), cloned.begin(), cloned.end());
        first += part.size();
    } while (first < points.size());
    streamed.record.points_hash = 7;
    streamed.record.parameters_hash = 8;
    REQUIRE(figure.finish(streamed.record));
    streamed.text = bytes_of_file();
    CHECK(figure.bytes() == streamed.text.size());
    return streamed;
}

Points3<float> random_points(const MeshData& data, std::size_t count, std::uint64_t seed) {
    Points3<float> points;
    for (const auto& p : points_about(data, count, seed)) points.push_back(cageform::vec_cast<float>(p));
    return points;
}

} // namespace

TEST_CASE("a figure in pieces clones as its pieces do", "[examples][tiles]") {
    const auto data = sphere(1);
    const auto cage = data.mesh<float>();
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const std::size_t count = random.below(3) == 0 ? random.below(20) : random.below(700);
        const auto points = random_points(data, count, seed);
        PackOptions options;
        options.format = WeightFormat(random.below(4));
        if (random.below(3) != 0) options.largest = 4 + random.below(6);
        Points3<float> pose(cage.vertices().begin(), cage.vertices().end());
        for (auto& vertex : pose) vertex[0] += float(random.uniform(-0.3, 0.3));
        const std::size_t piece = 16 * (1 + random.below(20));
        const auto streamed = stream(cage, points, piece, options, pose);

        Aligned memory(std::as_bytes(std::span<const char>(streamed.text)));
        const auto [figure, report] = cageform::open<float, 3>(memory.bytes());
        REQUIRE(report.status == Status::ok);
        CHECK(report.bytes == streamed.text.size());
        CHECK(report.figure_hash == cageform::hash_memory(std::span<const cageform::Vec<float, 3>>(points)));
        CHECK(report.cage_hash == cageform::hash_memory(cage.vertices()));
        CHECK(figure.point_count() == count);
        Points3<float> cloned(count);
        REQUIRE(clone(figure.points, pose, cloned) == Status::ok);
        CHECK(cloned == streamed.cloned);

        const auto record = read_tile_record(path);
        REQUIRE(record);
        CHECK(record->points == count);
        CHECK(record->points_hash == 7);
        CHECK(record->parameters_hash == 8);
        CHECK(record->weights_per_point == streamed.record.weights_per_point);
        CHECK(stream(cage, points, piece, options, pose).text == streamed.text);
        if (count <= piece && count > 0) { // one piece is what `pack` makes
            const cageform::MeanValueCoordinates<float, 3> coordinates(cage);
            const auto packed = cageform::pack(cageform::bind(coordinates, points).value, options);
            const auto blob = figure.part("PNTS");
            CHECK(packed.value.bytes().size() == blob.size());
            CHECK(clone(packed.value.view(), pose, cloned) == Status::ok);
            CHECK(cloned == streamed.cloned);
        }
    }
    std::filesystem::remove_all(folder);
}

TEST_CASE("only a whole figure has a record, and none is left of a broken one", "[examples][tiles]") {
    const auto data = sphere(1);
    const auto cage = data.mesh<float>();
    const auto points = random_points(data, 40, 1);
    const auto streamed = stream(cage, points, 32, {.format = WeightFormat::half, .largest = 6},
                                 {cage.vertices().begin(), cage.vertices().end()});
    REQUIRE(read_tile_record(path));
    const auto spoil = [](const std::string& text) {
        std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
        return read_tile_record(path).has_value();
    };
    std::size_t accepted = 0;
    for (std::size_t byte = 0; byte < streamed.text.size(); byte += byte < 512 ? 1 : 29) {
        auto text = streamed.text;
        text[byte] = char(text[byte] ^ 1 << byte % 8);
        accepted += spoil(text) ? 1 : 0;
    }
    CHECK(accepted == 0);
    for (std::size_t size = 0; size < streamed.text.size(); size += 61)
        CHECK(!spoil(streamed.text.substr(0, size)));
    CHECK(!spoil(streamed.text + std::string(64, '\0')));
    CHECK(spoil(streamed.text));
    {
        FigureStream unfinished(path); // the old figure stays
        const cageform::MeanValueCoordinates<float, 3> coordinates(cage);
        const auto packed = cageform::pack(cageform::bind(coordinates, points).value);
        REQUIRE(unfinished.append(packed.value.bytes(), points));
    }
    CHECK(bytes_of_file() == streamed.text);
    std::remove(path.c_str());
    CHECK(!read_tile_record(path));
    FigureStream nowhere("no_such_folder/a.figure");
    CHECK(nowhere.error().starts_with("cannot write no_such_folder/a.figure: "));
    TileRecord record;
    CHECK(!nowhere.finish(record));
    CHECK(std::filesystem::is_empty(folder));
    std::filesystem::remove_all(folder);
}

TEST_CASE("a hash of pieces is that of the whole", "[examples][tiles]") {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        std::vector<std::byte> bytes(random.below(700));
        for (auto& byte : bytes) byte = std::byte(random.below(256));
        cageform::MemoryHash hash(seed);
        for (std::span<const std::byte> left = bytes; !left.empty();) {
            const auto piece = left.first(std::min<std::size_t>(random.below(150), left.size()));
            hash.add(piece);
            left = left.subspan(piece.size());
        }
        CHECK(hash.value() == cageform::hash_memory(std::span<const std::byte>(bytes), seed));
    }
}

} // namespace figure_stream_tests

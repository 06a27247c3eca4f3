#include "files/figure_parts.hpp"

#include "catch.hpp"

#include <cageform/binding/pack.hpp>
#include <cageform/binding/pose_samples.hpp>
#include <cageform/cage/box_mesh.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/pose/pose_solver.hpp>

#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>
#include <vector>

namespace figure_parts_tests {

using namespace cageform_support;
using cageform::Status;
using Point = cageform::Vec<float, 3>;
using Part = cageform::FigurePartData;

namespace {

using Box = cageform::PolyhedralMesh<float>;
using Coordinates = cageform::MeanValueCoordinates<float, 3, Box>;

Coordinates in_box(std::size_t divisions) {
    return Coordinates(cageform::box_mesh<float>({0, 0, 0}, {4, 1, 1}, {divisions, 1, 1}));
}
const std::vector<Point> points{
    {0.3f, 0.5f, 0.5f}, {1, 0.2f, 0.6f}, {2, 0.5f, 0.5f}, {3, 0.8f, 0.4f}, {3.7f, 0.5f, 0.5f}};

/// A figure with a packed binding, normals, and the parts.
cageform::PackedFigure<float, 3> figure_with(const Coordinates& coordinates, const std::vector<Part>& parts) {
    const std::vector<Point> normals(points.size(), {0, 1, 0});
    const auto bound = cageform::bind(coordinates, cageform::FigurePoints{points, normals});
    REQUIRE(bound);
    cageform::FigurePackOptions options;
    options.parts = parts;
    auto [packed, report] = cageform::pack(bound.value, options);
    REQUIRE(report.status == Status::ok);
    return std::move(packed);
}
cageform::PackedPoseSamples samples_of(const Coordinates& coordinates) {
    const auto samples = pose_samples(coordinates, {.samples = 500, .rotations = 20});
    REQUIRE(samples);
    auto packed = cageform::pack(samples.value);
    REQUIRE(packed);
    return std::move(packed.value);
}

/// The bytes of a file, in lines as `open` needs them.
std::vector<cageform::Lanes<double>> lines_of(const std::string& name) {
    std::ifstream file(std::string(CAGEFORM_TEST_DATA) + "/figures/" + name, std::ios::binary);
    const std::string text(std::istreambuf_iterator<char>(file), {});
    REQUIRE(!text.empty());
    std::vector<cageform::Lanes<double>> lines((text.size() + 63) / 64);
    std::memcpy(lines.data(), text.data(), text.size());
    return lines;
}

} // namespace

// bind_mesh figure.obj --cage tetrahedron.obj --move 3:0,0,0.5 --seconds 0.5 --format half
TEST_CASE("a clip of a figure of version 0.1 plays as the library's clip", "[figure_parts]") {
    const auto play = [](const std::string& name) {
        const auto lines = lines_of(name);
        const auto figure = cageform::open<float, 3>(std::as_bytes(std::span(lines)));
        REQUIRE(figure);
        const FigureParts parts = read_parts(figure.value);
        REQUIRE(parts.fault.empty());
        REQUIRE(parts.clip.vertex_count() == 4);
        CHECK(parts.clip.end() == 1);
        auto cursor = parts.clip.make_cursor();
        std::vector<Point> poses, pose(4);
        for (const double time : {0.0, 0.125, 0.5, 0.75, 1.25}) {
            parts.clip.sample(time, cursor, pose);
            poses.insert(poses.end(), pose.begin(), pose.end());
        }
        CHECK(poses[3] == Point{0, 0, 1});
        CHECK(poses[4 * 2 + 3] == Point{0, 0, 1.5f});
        return poses;
    };
    CHECK(play("clip_of_0_1.figure") == play("clip.figure"));
}

TEST_CASE("a game poses a figure of a file by pins, as the program would", "[figure_parts]") {
    const auto coordinates = in_box(4);
    const auto packed = samples_of(coordinates);
    const auto figure = figure_with(coordinates, {{"PINS", packed.bytes()}});
    const auto opened = cageform::open<float, 3>(figure.bytes());
    REQUIRE(opened);
    FigureParts parts = read_parts(opened.value);
    REQUIRE(parts.fault.empty());
    const auto samples = pose_samples(coordinates, {.samples = 500, .rotations = 20});
    REQUIRE(samples);

    const std::vector<std::uint32_t> pins{0, 2, 4};
    const std::vector<Point> targets{points[0], points[2], {3, 2, 0.5f}};
    const auto posed = [&](cageform::PoseSamples<float, 3> by) {
        cageform::PoseSolver<float, 3> solver(std::move(by));
        REQUIRE(solver.status() == Status::ok);
        REQUIRE(solver.set_pins({.binding = opened.value.points, .points = pins}) == Status::ok);
        auto pose = solver.samples().rest_handles;
        for (int frame = 0; frame < 10; ++frame) REQUIRE(solver.solve(targets, pose).status == Status::ok);
        return pose;
    };
    const auto pose = posed(std::move(parts.samples));
    CHECK(pose == posed(samples.value));
    std::vector<Point> out(points.size());
    REQUIRE(cageform::clone(opened.value.points, pose, out) == Status::ok);
    for (std::size_t n = 0; n < pins.size(); ++n) {
        const Point miss = out[pins[n]] - targets[n];
        CHECK(dot(miss, miss) < 1e-4f);
    }
}

TEST_CASE("samples for pins that do not fit are refused", "[figure_parts]") {
    const auto coordinates = in_box(4);
    const auto fault_of = [&](std::span<const std::byte> bytes) {
        const auto figure = figure_with(coordinates, {{"PINS", bytes}});
        const auto opened = cageform::open<float, 3>(figure.bytes());
        REQUIRE(opened);
        return read_parts(opened.value).fault;
    };
    CHECK(fault_of({}).empty()); // none were asked for
    CHECK(fault_of(samples_of(in_box(5)).bytes()) == "samples for pins: they belong to another cage");
    const auto packed = samples_of(coordinates);
    std::vector<std::byte> bytes(packed.bytes().begin(), packed.bytes().end());
    CHECK(fault_of(bytes).empty());
    CHECK(fault_of(std::span(bytes).first(bytes.size() - 64)).starts_with("samples for pins: "));
    bytes[0] ^= std::byte{1};
    CHECK(fault_of(bytes) == "samples for pins: " + std::string(to_string(Status::not_pose_samples)));
}

} // namespace figure_parts_tests

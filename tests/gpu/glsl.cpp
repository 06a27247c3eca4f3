// The GLSL of clone/glsl.hpp, run on what OpenGL there is (Mesa's software renderer will do), against
// `clone`.
#include "catch.hpp"
#include "support/bindings.hpp"
#include "support/gl_context.hpp"
#include "support/larger.hpp"
#include "support/meshes.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/pack.hpp>
#include <cageform/binding/tangents.hpp>
#include <cageform/cage/detail/primitives.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/glsl.hpp>
#include <cageform/clone/normals.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/coordinates/green.hpp>

#include <cstring>

namespace glsl_tests {

using namespace cageform_tests;
using cageform::PackedBinding;
using cageform::Status;
using cageform::WeightFormat;

namespace {

template <std::size_t D>
using Points = std::vector<Vec<float, D>>;

const GlContext& gl() {
    static const GlContext context;
    return context;
}

/// Points or vectors with random weights; the sixth of every block stays where it is.
template <std::size_t D>
cageform::Binding<float, D> bound(const Points<D>& points, const Points<D>& handles, std::uint64_t seed) {
    auto [weights, rest] = random_binding<float, D>(points.size(), handles.size(), seed).release();
    for (auto& row : weights) row[5] = 0;
    const cageform::BlockView<float> rows{rest.data(), D, points.size()};
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t k = 0; k < D; ++k) rows(i, k) = points[i][k];
    }
    return {std::move(weights), std::move(rest), handles, points.size()};
}

template <std::size_t D>
double size_of(const Points<D>& points) {
    return double(cageform::bounds_of(std::span<const Vec<float, D>>(points)).diagonal());
}

/// Each moved by up to `reach` times the size of them all.
template <std::size_t D>
Points<D> moved(Points<D> points, double reach, std::uint64_t seed) {
    const auto by = random_points<float, D>(points.size(), reach * size_of<D>(points), seed);
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = points[i] + by[i];
    return points;
}

/// A figure of 16 k + 3 points.
template <std::size_t D>
struct Figure {
    Points<D> handles, pose;
    cageform::Binding<float, D> binding;

    explicit Figure(std::uint64_t seed) {
        Random random(seed);
        auto points = random_points<float, D>(16 * (1 + random.below(20)) + 3, 10, seed);
        points[1][D - 1] = -0.0f;
        handles = random_points<float, D>(9 + random.below(20), 10, seed + 1);
        pose = moved<D>(handles, 0.2, seed + 2);
        binding = bound<D>(points, handles, seed + 3);
    }

    /// The largest difference of sums of so many products, in any order.
    double tolerance() const {
        double largest = 0, farthest = 0;
        for (std::size_t i = 0; i < binding.point_count(); ++i) {
            double sum = 0;
            for (std::size_t h = 0; h < binding.handle_count(); ++h)
                sum += std::fabs(double(binding.weight(i, h)));
            largest = cageform_tests::larger(largest, sum);
            for (std::size_t k = 0; k < D; ++k)
                farthest = cageform_tests::larger(farthest, std::fabs(double(binding.rest_point(i)[k])));
        }
        const double moved = (1 + largest) * size_of<D>(handles);
        return 1e-7 * (4 * farthest + double(16 + binding.handle_count()) * moved);
    }
};

template <class X>
std::span<std::byte> bytes_of(std::vector<X>& values) {
    return std::as_writable_bytes(std::span(values));
}

template <std::size_t D>
std::vector<std::array<float, 4>> displacements_of(const cageform::PackedBindingView<float, D>& binding,
                                                   const Points<D>& pose) {
    std::vector<std::array<float, 4>> out(displacement_count(binding));
    REQUIRE(write_displacements(binding, pose, out) == Status::ok);
    return out;
}

std::string buffers = "#define CAGEFORM_BLOB 0\n#define CAGEFORM_DISPLACEMENTS 1\n#define CAGEFORM_OUT 2\n";

/// A shader's description of its blob.
template <std::size_t D>
std::string known(WeightFormat format) {
    return "#define CAGEFORM_FORMAT " + std::to_string(int(format)) + "u\n#define CAGEFORM_DIMENSION " +
           std::to_string(D) + "u\n";
}

const std::string compute_text =
    std::string(cageform::glsl::displacements) + cageform::glsl::blob + cageform::glsl::compute;

template <std::size_t D>
Points<D> clone_by_compute(std::span<const std::byte> blob,
                           const cageform::PackedBindingView<float, D>& binding, const Points<D>& pose,
                           const std::string& defines, const std::string& version = "#version 430\n") {
    auto displacements = displacements_of(binding, pose);
    std::vector<std::byte> uploaded(blob.begin(), blob.end());
    Points<D> out(binding.point_count());
    gl().run_compute(version + buffers + defines + compute_text, GLuint((binding.point_count() + 63) / 64),
                     {{0, uploaded}, {1, bytes_of(displacements)}, {2, bytes_of(out)}});
    return out;
}

template <std::size_t D>
double largest_difference(const Points<D>& a, const Points<D>& b) {
    REQUIRE(a.size() == b.size());
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (std::size_t k = 0; k < D; ++k) {
            const double difference = std::fabs(double(a[i][k]) - double(b[i][k]));
            largest = cageform_tests::larger(largest, difference); // not a number is the largest
        }
    }
    return largest;
}

/// Runs `check(figure, packed, format)` for every format, dense and sparse.
template <std::size_t D, class Check>
void for_each_packing(const Check& check) {
    const std::uint64_t seed = std::uint64_t(GENERATE(seeds(4)));
    const auto format =
        GENERATE(WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8);
    const bool sparse = GENERATE(false, true);
    CAPTURE(seed, int(format), sparse);
    const Figure<D> figure(seed);
    cageform::PackOptions options;
    options.format = format;
    options.largest = sparse ? D + 3 : 0;
    const auto packed = cageform::pack(figure.binding, options);
    REQUIRE(packed.report.status == Status::ok);
    check(figure, packed.value, format);
}

template <std::size_t D>
void check_compute() {
    for_each_packing<D>([](const Figure<D>& figure, const PackedBinding<float, D>& packed,
                           WeightFormat format) {
        const auto binding = packed.view();
        Points<D> expected(binding.point_count());
        REQUIRE(clone(binding, figure.pose, expected) == Status::ok);
        const auto told = clone_by_compute<D>(packed.bytes(), binding, figure.pose, known<D>(format));
        CHECK(largest_difference(told, expected) <= figure.tolerance());
        // Repeats this with a shader that searches itself, and in the language of mobile devices.
        CHECK(largest_difference(clone_by_compute<D>(packed.bytes(), binding, figure.pose, ""), expected) <=
              figure.tolerance());
        CHECK(largest_difference(clone_by_compute<D>(packed.bytes(), binding, figure.pose, known<D>(format),
                                                     "#version 310 es\n"),
                                 expected) <= figure.tolerance());

        REQUIRE(clone(binding, figure.handles, expected) == Status::ok);
        const auto at_rest = clone_by_compute<D>(packed.bytes(), binding, figure.handles, known<D>(format));
        CHECK(std::memcmp(at_rest.data(), expected.data(), at_rest.size() * sizeof(Vec<float, D>)) == 0);
    });
}

} // namespace

TEST_CASE("the compute shader clones as clone does, in the plane", "[gpu]") {
    check_compute<2>();
}
TEST_CASE("the compute shader clones as clone does, in space", "[gpu]") {
    check_compute<3>();
}

TEST_CASE("the compute shader writes into vertices of others' making, from the second of two blobs",
          "[gpu]") {
    const Figure<3> figure(5), other(6);
    const auto first = cageform::pack(other.binding, {.format = WeightFormat::int16});
    const auto second = cageform::pack(figure.binding, {.format = WeightFormat::int8, .largest = 5});
    std::vector<std::byte> both(first.value.bytes().begin(), first.value.bytes().end());
    both.insert(both.end(), second.value.bytes().begin(), second.value.bytes().end());
    const auto binding = second.value.view();
    auto displacements = displacements_of(binding, figure.pose);
    Points<3> expected(binding.point_count());
    REQUIRE(clone(binding, figure.pose, expected) == Status::ok);

    constexpr std::size_t stride = 7, offset = 2;
    std::vector<float> vertices(stride * binding.point_count() + stride, -1.0f);
    gl().run_compute(
        "#version 430\n" + buffers + "#define CAGEFORM_OUT_STRIDE 7\n#define CAGEFORM_OUT_OFFSET 2\n" +
            "#define CAGEFORM_BASE " + std::to_string(first.value.bytes().size() / 4) + "u\n" + compute_text,
        GLuint((binding.point_count() + 63) / 64),
        {{0, both}, {1, bytes_of(displacements)}, {2, bytes_of(vertices)}});
    Points<3> found(binding.point_count());
    std::size_t touched = 0;
    for (std::size_t n = 0; n < vertices.size(); ++n) {
        const std::size_t i = n / stride, k = n % stride - offset;
        if (i < found.size() && k < 3) {
            found[i][k] = vertices[n];
        } else {
            touched += vertices[n] != -1.0f;
        }
    }
    CHECK(largest_difference(found, expected) <= figure.tolerance());
    CHECK(touched == 0);
}

namespace {

struct PointsAndNormals {
    Points<3> points, normals;
};

/// By one dispatch, from three blobs in one buffer.
PointsAndNormals clone_with_normals(const PackedBinding<float, 3>& of_points,
                                    std::array<const PackedBinding<float, 3>*, 2> of_tangents,
                                    const Points<3>& pose) {
    std::vector<std::byte> blobs;
    std::string defines = "#define CAGEFORM_OUT_STRIDE 6\n#define CAGEFORM_NORMAL_OFFSET 3\n";
    for (const auto& [name, packed] :
         {std::pair("BASE", &of_points), {"TANGENTS", of_tangents[0]}, {"BITANGENTS", of_tangents[1]}}) {
        defines += std::string("#define CAGEFORM_") + name + " " + std::to_string(blobs.size() / 4) + "u\n";
        blobs.insert(blobs.end(), packed->bytes().begin(), packed->bytes().end());
    }
    auto displacements = displacements_of(of_points.view(), pose);
    const std::size_t count = of_points.view().point_count();
    Points<3> interleaved(2 * count);
    gl().run_compute("#version 430\n" + buffers + defines + compute_text, GLuint((count + 63) / 64),
                     {{0, blobs}, {1, bytes_of(displacements)}, {2, bytes_of(interleaved)}});
    PointsAndNormals found;
    for (std::size_t i = 0; i < count; ++i) {
        found.points.push_back(interleaved[2 * i]);
        found.normals.push_back(interleaved[2 * i + 1]);
    }
    return found;
}

} // namespace

TEST_CASE("the compute shader makes normals of three blobs in one buffer", "[gpu]") {
    const std::uint64_t seed = std::uint64_t(GENERATE(seeds(4)));
    CAPTURE(seed);
    Random random(seed);
    Points<3> normals;
    for (std::size_t i = 0; i < 101; ++i)
        normals.push_back({float(random.uniform(-1, 1)), float(random.uniform(-1, 1)), i == 7 ? 0.0f : 1.0f});
    normals[5] = {}; // which nothing moves
    const auto frames = cageform::tangents_of(normals);
    const auto points = random_points<float, 3>(normals.size(), 10, seed);
    const auto handles = random_points<float, 3>(12, 10, seed + 1), pose = moved<3>(handles, 0.05, seed + 2);
    const cageform::PackOptions options{.format = WeightFormat::int16};
    const auto of_points = cageform::pack(bound<3>(points, handles, seed), options).value;
    const auto of_tangents = cageform::pack(bound<3>(frames[0], handles, seed + 3), options).value;
    const auto of_bitangents = cageform::pack(bound<3>(frames[1], handles, seed + 4), options).value;
    Points<3> expected(points.size());
    REQUIRE(clone_normals(std::array{of_tangents.view(), of_bitangents.view()}, pose, expected) ==
            Status::ok);
    const auto found = clone_with_normals(of_points, {&of_tangents, &of_bitangents}, pose).normals;
    CHECK(found[5] == Vec<float, 3>{});
    CHECK(largest_difference(found, expected) <= 1e-3);
}

TEST_CASE("the compute shader takes poses of faces: Green coordinates, points and normals", "[gpu]") {
    const auto format =
        GENERATE(WeightFormat::scalar, WeightFormat::half, WeightFormat::int16, WeightFormat::int8);
    CAPTURE(int(format));
    const cageform::GreenCoordinates<float, 3> coordinates(sphere(2).mesh<float>());
    const auto points = random_points<float, 3>(101, 0.5, 1), normals = random_points<float, 3>(101, 1, 2);
    const auto made = cageform::bind(coordinates, cageform::FigurePoints{points, normals});
    REQUIRE(made.report.status == Status::ok);
    const cageform::PackOptions options{.format = format};
    const auto of_points = cageform::pack(made.value.points, options).value;
    const auto of_tangents = cageform::pack(made.value.tangents[0], options).value;
    const auto of_bitangents = cageform::pack(made.value.tangents[1], options).value;
    const auto vertices = coordinates.cage().vertices();
    const auto check_pose = [&](const Points<3>& pose, double tolerance) {
        Points<3> handles(coordinates.handles().size()), placed(points.size()), turned(points.size());
        REQUIRE(pose_handles(of_points.view(), pose, handles).status == Status::ok);
        REQUIRE(clone(of_points.view(), handles, placed) == Status::ok);
        REQUIRE(clone_normals(std::array{of_tangents.view(), of_bitangents.view()}, handles, turned) ==
                Status::ok);
        const auto found = clone_with_normals(of_points, {&of_tangents, &of_bitangents}, handles);
        CHECK(largest_difference(found.points, placed) <= tolerance);
        CHECK(largest_difference(found.normals, turned) <= 1e-3);
    };
    const Points<3> rest(vertices.begin(), vertices.end());
    check_pose(rest, 0);
    check_pose(moved<3>(rest, 0.05, 3), 2e-5); // sums of 194 products
}

TEST_CASE("a vertex shader reads the blob as well", "[gpu]") {
    for_each_packing<3>(
        [](const Figure<3>& figure, const PackedBinding<float, 3>& packed, WeightFormat format) {
            const auto binding = packed.view();
            auto displacements = displacements_of(binding, figure.pose);
            std::vector<std::byte> blob(packed.bytes().begin(), packed.bytes().end());
            Points<3> expected(binding.point_count()), placed(binding.point_count()),
                found(binding.point_count());
            REQUIRE(clone(binding, figure.pose, expected) == Status::ok);
            gl().run_vertex("#version 430\n" + buffers + known<3>(format) + cageform::glsl::displacements +
                                cageform::glsl::blob + R"(
out vec3 moved;
void main() {
    uint place = uint(gl_VertexID);
    moved = cageform_rest(0u, place) + cageform_displacement(0u, place);
})",
                            "moved", GLsizei(binding.point_count()), {},
                            {{0, blob}, {1, bytes_of(displacements)}}, bytes_of(placed));
            for (std::size_t n = 0; n < placed.size(); ++n)
                found[binding.order != nullptr ? binding.order[n] : n] = placed[n];
            CHECK(largest_difference(found, expected) <= figure.tolerance());
        });
}

TEST_CASE("a vertex shader moves a skin of eight joints", "[gpu]") {
    const bool uniform = GENERATE(false, true);
    const Figure<3> figure(9);
    const cageform::PackedBindingView<float, 3> binding(figure.binding.view());
    auto displacements = displacements_of(binding, figure.pose);
    Random random(1);
    constexpr std::size_t influences = 8;
    const std::size_t count = binding.point_count();
    std::vector<std::uint16_t> joints(influences * count);
    std::vector<float> weights(influences * count);
    Points<3> rest(count), expected(count), found(count);
    for (std::size_t i = 0; i < count; ++i) {
        expected[i] = rest[i] = figure.binding.rest_point(i);
        for (std::size_t k = influences * i; k < influences * (i + 1); ++k) {
            joints[k] = std::uint16_t(random.below(figure.handles.size()));
            weights[k] = float(random.uniform(0, 0.25));
            expected[i] = expected[i] + weights[k] * (figure.pose[joints[k]] - figure.handles[joints[k]]);
        }
    }
    const std::string declared =
        uniform ? "#define CAGEFORM_UNIFORM_HANDLES " + std::to_string(displacements.size()) + "\n" : "";
    const auto all_joints = std::as_bytes(std::span(joints)), all_weights = std::as_bytes(std::span(weights));
    using As = GlAttribute::As;
    gl().run_vertex("#version 430\n" + buffers + declared + cageform::glsl::displacements +
                        cageform::glsl::skin + R"(
layout(location = 0) in vec3 rest;
layout(location = 1) in uvec4 joints0;
layout(location = 2) in uvec4 joints1;
layout(location = 3) in vec4 weights0;
layout(location = 4) in vec4 weights1;
out vec3 moved;
void main() {
    moved = rest + cageform_skin(joints0, weights0) + cageform_skin(joints1, weights1);
})",
                    "moved", GLsizei(count),
                    {{0, 3, GL_FLOAT, As::floating, 0, std::as_bytes(std::span(rest))},
                     {1, 4, GL_UNSIGNED_SHORT, As::whole, 2 * influences, all_joints},
                     {2, 4, GL_UNSIGNED_SHORT, As::whole, 2 * influences, all_joints.subspan(8)},
                     {3, 4, GL_FLOAT, As::floating, 4 * influences, all_weights},
                     {4, 4, GL_FLOAT, As::floating, 4 * influences, all_weights.subspan(16)}},
                    {{1, bytes_of(displacements), uniform}}, bytes_of(found));
    CHECK(largest_difference(found, expected) <= figure.tolerance());
}

TEST_CASE("displacements are refused as clone refuses them", "[gpu]") {
    const Figure<2> figure(3);
    const cageform::PackedBindingView<float, 2> binding(figure.binding.view());
    std::vector<std::array<float, 4>> out(displacement_count(binding));
    CHECK(write_displacements(binding, figure.pose, std::span(out).first(out.size() - 1)) ==
          Status::output_too_small);
    auto pose = figure.pose;
    pose.back()[1] = std::numeric_limits<float>::quiet_NaN();
    CHECK(write_displacements(binding, pose, out) == Status::pose_not_finite);
    pose.pop_back();
    CHECK(write_displacements(binding, pose, out) == Status::pose_size_differs);
}

} // namespace glsl_tests

// Index buffers as faces of meshes.
#include "../catch.hpp"
#include "../support/meshes.hpp"

#include <cageform/fields/surface.hpp>

namespace faces_of_tests {

using namespace cageform_tests;
using cageform::faces_of;
using cageform::Status;
using cageform::TriangleMesh;

namespace {

template <class I>
std::vector<I> flat(const Faces& faces) {
    std::vector<I> indices;
    for (const auto& face : faces) {
        for (const auto i : face) indices.push_back(static_cast<I>(i));
    }
    return indices;
}

} // namespace

TEMPLATE_TEST_CASE("faces_of reads an index buffer as triangles", "[cage][faces_of]", std::uint8_t,
                   std::uint16_t, std::uint32_t, std::int32_t) {
    const auto seed = std::uint64_t(GENERATE(seeds(10)));
    CAPTURE(seed);
    const auto data = random_mesh(seed);
    if (data.vertices.size() > 250) return; // too many vertices for 8-bit indices
    const auto indices = flat<TestType>(data.faces);
    const auto view = faces_of(indices);
    STATIC_REQUIRE(cageform::FaceRange<decltype(view)>);
    REQUIRE(view.size() == data.faces.size());
    const TriangleMesh<double> mesh(data.vertices, view), expected(data.vertices, data.faces);
    CHECK(std::ranges::equal(mesh.faces(), expected.faces()));
    CHECK(check(mesh).status == Status::ok);
    const auto of_span = faces_of(std::span(indices).first(3));
    REQUIRE(of_span.size() == 1);
    for (std::size_t k = 0; k < 3; ++k) CHECK(of_span[0][k] == std::uint32_t(data.faces[0][k]));
}

TEST_CASE("faces_of: an incomplete face or an index out of range is reported with its face",
          "[cage][faces_of]") {
    const auto data = random_mesh(1);
    for (const std::size_t missing : {1u, 2u}) {
        CAPTURE(missing);
        auto indices = flat<std::uint16_t>(data.faces);
        indices.resize(indices.size() - missing);
        REQUIRE(faces_of(indices).size() == data.faces.size());
        const auto report = check(TriangleMesh<double>(data.vertices, faces_of(indices)));
        CHECK(report.status == Status::face_without_vertex);
        CHECK(std::any_of(report.faults.begin(), report.faults.end(), [&](const auto& fault) {
            return fault.kind == cageform::CageFaultKind::face_without_vertex &&
                   fault.a == data.faces.size() - 1;
        }));
        const auto weights = cageform::cotangent_weights(data.vertices, faces_of(indices));
        CHECK(weights.report.status != Status::ok);
    }
    auto indices = flat<std::int32_t>(data.faces);
    indices[4] = -1;
    CHECK(check(TriangleMesh<double>(data.vertices, faces_of(indices))).status ==
          Status::face_without_vertex);
    CHECK(faces_of(std::vector<std::uint16_t>{}).size() == 0);
}

} // namespace faces_of_tests

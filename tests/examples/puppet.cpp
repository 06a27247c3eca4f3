#include "catch.hpp"

#include "../../examples/programs/character/puppet.hpp"
#include "support/cages.hpp"

#include <set>

namespace puppet_test {

using namespace cageform_programs;
using cageform_support::length;
using cageform_tests::Random;

PuppetShape random_shape(Random& random) {
    return {random.uniform(PuppetShape::least_girth, PuppetShape::most_girth), random.uniform(0, 1)};
}

/// The number of vertices and faces, less that of edges.
int euler_number(const ImplicitMesh& mesh) {
    std::set<std::array<std::uint32_t, 2>> edges;
    for (const auto& face : mesh.faces) {
        for (std::size_t k = 0; k < 3; ++k)
            edges.insert({std::min(face[k], face[(k + 1) % 3]), std::max(face[k], face[(k + 1) % 3])});
    }
    return int(mesh.vertices.size() + mesh.faces.size()) - int(edges.size());
}

/// The least and the largest value of the default puppet's function at the centres of a mesh's faces.
std::array<double, 2> levels(const ImplicitMesh& mesh, const PuppetShape& shape) {
    std::array<double, 2> range{1, -1};
    for (const auto& [a, b, c] : mesh.faces) {
        const Point3 centre = (1 / 3.0) * (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]);
        const double level = puppet(unshaped(centre, shape));
        range = {std::min(range[0], level), std::max(range[1], level)};
    }
    return range;
}

TEST_CASE("A puppet's shape is a map of the space about it that can be inverted", "[examples][puppet]") {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        Random random(seed);
        const PuppetShape shape = random_shape(random);
        CAPTURE(seed, shape.girth, shape.child);
        for (int k = 0; k < 500; ++k) {
            const Point3 p{random.uniform(-1.05, 1.05), random.uniform(-0.05, 1.95),
                           random.uniform(-0.3, 0.3)};
            CHECK(length(shaped(p, {}) - p) == 0);
            CHECK(length(shaped(unshaped(p, shape), shape) - p) < 1e-9);
            if (puppet(p) < 0.05) CHECK(length(unshaped(shaped(p, shape), shape) - p) < 1e-9);
        }
    }
}

TEST_CASE("Puppets of all shapes are closed, and their clothes lie outside in layers", "[examples][puppet]") {
    constexpr double cell = 0.03;
    Random random(65);
    for (const PuppetShape& shape : {random_shape(random), PuppetShape{PuppetShape::most_girth, 1}}) {
        CAPTURE(shape.girth, shape.child);
        const ImplicitMesh skin = puppet_mesh(shape, cell), tights = puppet_tights(shape, cell),
                           skirt = puppet_skirt(shape, cell);
        CHECK(cageform::check(cageform::TriangleMesh<double>(skin.vertices, skin.faces)).status ==
              cageform::Status::ok);
        CHECK(euler_number(skin) == 2);
        CHECK(euler_number(tights) == -1); // a waist and two ankles
        CHECK(euler_number(skirt) == 0);
        const auto of_skin = levels(skin, shape), of_tights = levels(tights, shape);
        CHECK(of_skin[1] < of_tights[0]);
        CHECK(of_tights[1] < levels(skirt, shape)[0]);
    }
}

TEST_CASE("Landmarks of a puppet lie on its skin, and joints inside", "[examples][puppet]") {
    Random random(7);
    const PuppetShape shape = random_shape(random);
    CAPTURE(shape.girth, shape.child);
    const auto usual = puppet_landmarks(), landmarks = puppet_landmarks(shape);
    REQUIRE(landmarks.size() == 15 + puppet_bones().size());
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
        CAPTURE(landmarks[i].name);
        CHECK(landmarks[i].name == usual[i].name);
        CHECK(length(landmarks[i].place - shaped(usual[i].place, shape)) < 1e-12);
        const double level = puppet(usual[i].place);
        if (i < 15)
            CHECK(std::fabs(level) < 1e-9);
        else
            CHECK(level < -0.03);
    }
}

} // namespace puppet_test

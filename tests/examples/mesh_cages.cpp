// Cages and poses from PLY and STL files, which are found by their contents.
#include "../catch.hpp"
#include "../support/temporary_file.hpp"

#include "cli/mesh_cage.hpp"
#include "files/obj_file.hpp"
#include "io/csv.hpp"

#include <cmath>
#include <functional>

namespace mesh_cages_tests {

using namespace cageform_support;
using cageform_tests::TemporaryFile;

namespace {

constexpr std::array<std::array<int, 4>, 6> cube_faces{
    {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};

Point3 cube_corner(int corner) {
    return {double(corner & 1), double(corner >> 1 & 1), double(corner >> 2 & 1)};
}

/// A cube as PLY, with four vertices of each face. The copies of a vertex differ by up to `apart`.
std::string split_cube(const std::function<Point3(const Point3&)>& place, double apart = 0) {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 24\nproperty double x\nproperty double y\nproperty "
        "double z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n";
    for (std::size_t f = 0; f < 6; ++f) {
        for (const int corner : cube_faces[f]) {
            const Point3 p = place(cube_corner(corner));
            for (const double x : p.v) text += detail::digits_of(x + apart * double(f) / 6) + ' ';
            text += '\n';
        }
    }
    for (int f = 0; f < 6; ++f) {
        text += '4';
        for (int k = 0; k < 4; ++k) text += ' ' + std::to_string(4 * f + k);
        text += '\n';
    }
    return text;
}

std::string stl_cube(const std::function<Point3(const Point3&)>& place) {
    std::string text = "solid\n";
    for (const auto& face : cube_faces) {
        for (const auto& triangle : {std::array{0, 1, 2}, {0, 2, 3}}) {
            text += "facet normal 0 0 0 outer loop\n";
            for (const int k : triangle) {
                text += "vertex";
                const Point3 p = place(cube_corner(face[std::size_t(k)]));
                for (const double x : p.v) text += ' ' + detail::digits_of(x);
                text += '\n';
            }
            text += "endloop endfacet\n";
        }
    }
    return text;
}

} // namespace

TEST_CASE("the contents of a file decide its format, and the extension of outputs",
          "[examples][mesh_formats]") {
    const auto same = [](const Point3& p) { return p; };
    for (const std::string name : {"a.obj", "a.ply", "a.stl"}) {
        const TemporaryFile ply(split_cube(same), name), stl(stl_cube(same), name);
        const auto from_ply = load_mesh(ply.path), from_stl = load_mesh(stl.path);
        REQUIRE(from_ply);
        REQUIRE(from_stl);
        CHECK(from_ply->vertices.size() == 24);
        CHECK(from_stl->vertices.size() == 8);
        CHECK(fault_of_extension(*from_ply, name).empty() == (name == "a.ply"));
        CHECK(fault_of_extension(*from_stl, name).empty() == (name == "a.stl"));
    }
}

TEST_CASE("cages are welded, and their poses may be split as the file or welded",
          "[examples][mesh_formats]") {
    const auto same = [](const Point3& p) { return p; };
    const auto bent = [](const Point3& p) {
        return Point3{p[0] + p[1] * p[2], 2 * p[1], p[2] - 0.25 * p[0]};
    };
    const TemporaryFile ply(split_cube(same), "cage.ply"), rounded(split_cube(same, 1e-8), "rounded.ply"),
        stl(stl_cube(same), "cage.stl"), ply_pose(split_cube(bent), "pose.ply"),
        stl_pose(stl_cube(bent), "pose.stl"), torn(split_cube(bent, 0.1), "torn.ply");
    for (const auto& [cage_path, pose_path] :
         {std::pair{&ply, &ply_pose}, {&rounded, &ply_pose}, {&stl, &stl_pose}}) {
        const auto cage = load_mesh_cage(cage_path->path);
        if (!cage) FAIL(to_string(cage.error()));
        CHECK(cage_dimension(cage_path->path) == 3);
        REQUIRE(cage->vertices.size() == 8);
        CHECK(cage->triangles.size() == 12);
        CHECK(cage->faces.size() == (cage_path == &stl ? 12 : 6));
        CHECK_FALSE(cage->text.empty());
        std::vector<Point3> expected;
        for (const Point3& p : cage->vertices)
            expected.push_back(bent({std::round(p[0]), std::round(p[1]), std::round(p[2])}));
        const auto pose = load_mesh_pose(pose_path->path, *cage);
        if (!pose) FAIL(to_string(pose.error()));
        CHECK(pose->vertices == expected);
        CHECK(pose_difference(*cage, *pose).empty());
        const TemporaryFile welded(to_text(*cage, pose->vertices), "welded.obj");
        const auto again = load_mesh_pose(welded.path, *cage);
        if (!again) FAIL(to_string(again.error()));
        CHECK(again->vertices == expected);
    }
    const auto cage = load_mesh_cage(ply.path);
    CHECK_FALSE(load_mesh_pose(torn.path, *cage));
    CHECK_FALSE(load_mesh_pose(stl.path, *cage)); // of triangles, not of quads
}

} // namespace mesh_cages_tests

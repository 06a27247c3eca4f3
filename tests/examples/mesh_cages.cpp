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

TEST_CASE("whatever the extension, the contents are read or the reason is told", "[examples][mesh_formats]") {
    const auto same = [](const Point3& p) { return p; };
    const std::string mark = "\xef\xbb\xbf";
    const std::string gltf =
        R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"mode": 0, "attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 1, "type": "VEC3",
                           "min": [0, 0, 0], "max": [0, 0, 0]}],
            "bufferViews": [{"buffer": 0, "byteLength": 12}], "buffers": [{"byteLength": 12,
            "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAA"}]})";
    const std::string obj = "# solid\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const std::string medit = "# a\nMeshVersionFormatted 2\nDimension 3\nVertices 1\n0 0 0 0\nEnd\n";
    const std::string binary = std::string(80, 'x') + std::string("\1\0\0\0", 4) + std::string(50, '\0');
    const std::pair<std::string, std::string> formats[] = {{obj, ".obj"},
                                                           {mark + obj, ".obj"},
                                                           {split_cube(same), ".ply"},
                                                           {stl_cube(same), ".stl"},
                                                           {mark + stl_cube(same), ".stl"},
                                                           {binary, ".stl"},
                                                           {binary + "behind", ".stl"},
                                                           {medit, ".mesh"},
                                                           {gltf, ".gltf"},
                                                           {mark + gltf, ".gltf"}};
    const std::string cut = std::string(75, ' ') + std::string("\2\0\0\0", 4) + std::string(70, 'v');
    const std::string junk("[\xff\0v\n", 5);
    const std::pair<std::string, std::string> faults[] = {
        {"[1, 2]", "the JSON is not an object"},
        {" {}", "has no asset with a version"},
        {mark + "{", "is not a valid glTF document"},
        {"<svg/>", "of the format SVG, which deform_svg reads"},
        {"#usda 1.0\n", "of the format USD"},
        {"solid" + cut, "its head declares 2 triangles, which need 184 bytes"},
        {"OFF\n1 0 0\n", "of the format OFF"}};
    for (const std::string& extension : mesh_extensions) {
        CAPTURE(extension);
        for (const auto& [text, own] : formats) {
            INFO(text);
            const TemporaryFile file(text, "a" + extension);
            const auto mesh = load_mesh(file.path);
            if (!mesh) FAIL(to_string(mesh.error()));
            const auto extensions = extensions_of(*mesh);
            CHECK(std::find(extensions.begin(), extensions.end(), own) != extensions.end());
        }
        for (const auto& [text, why] : faults) {
            const TemporaryFile file(text, "a" + extension);
            const auto mesh = load_mesh(file.path);
            REQUIRE_FALSE(mesh);
            CHECK(to_string(mesh.error()).find(why) != std::string::npos);
        }
        for (const std::string& text :
             {"a    " + cut, junk, std::string("plywood"), std::string("f 1 2 3")}) {
            const TemporaryFile file(text, "a" + extension);
            const auto mesh = load_mesh(file.path);
            REQUIRE_FALSE(mesh);
            const std::string why = extension == ".ply"    ? "is no PLY file"
                                    : extension == ".stl"  ? "is no STL file"
                                    : extension == ".mesh" ? "is not a .mesh file"
                                                           : "holds no vertices: it is no glTF, ";
            CHECK(to_string(mesh.error()).find(why) != std::string::npos);
        }
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

#include "files/medit_file.hpp"

#include "catch.hpp"

#include <string>
#include <vector>

namespace medit_file_tests {

using namespace cageform_support;

namespace {

/// A cube of six tetrahedra around a diagonal, three of them inverted, with all other content of files.
const std::string cube = "# by hand\nMeshVersionFormatted 2\r\nDimension\n3\n"
                         "Vertices 8 # corners\n"
                         "0 0 0 1\n1 0 0 1\n0 1.50e0 0 1\n1 1.5 0 1\n"
                         "0 0 1 2\n 1 0 1 2\n0 1.5 1 2 1 1.5 1 2\n"
                         "RequiredVertices\n1\n8\n"
                         "Tetrahedra\n6\n"
                         "1 2 4 8 0\n1 4 3 8 0\n1 3 7 8 0\n1 7 5 8 0\n8 5 6 1 0\n1 6 2 8 0\n"
                         "Triangles\n1\n1 2 3 9\nEdges\n1\n1 2 nan\nEnd\nwhat follows 7\n";

MeshFile mesh_of(const std::string& text) {
    auto file = parse_medit(text, "file.mesh");
    INFO(text);
    if (!file) FAIL(to_string(file.error()));
    return std::move(*file);
}

std::string refusal_of(const std::string& text) {
    const auto file = parse_medit(text, "file.mesh");
    INFO(text);
    REQUIRE_FALSE(file);
    return to_string(file.error());
}

std::string with(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != text.npos);
    return text.replace(at, from.size(), to);
}

/// Six times the volume enclosed by triangles that point outwards.
double volume_inside(const MeshFile& file) {
    double sum = 0;
    for (const auto& [a, b, c] : file.triangles)
        sum += dot(file.vertices[a], cross(file.vertices[b], file.vertices[c]));
    return sum;
}

} // namespace

TEST_CASE("a vertex that is not finite is left out if no cell uses it", "[medit]") {
    const std::string dirty =
        with(with(cube, "Vertices 8", "Vertices 9"), "\nRequired", "\nnan 0 inf 3\nRequired");
    CHECK(refusal_of(dirty) == "file.mesh: the coordinates of a vertex are not finite (line 13)");
    const auto file = parse_medit(dirty, "file.mesh", StrayVertices::leave_out);
    REQUIRE(file);
    CHECK(file->left_out == std::vector<std::size_t>{8});
    CHECK(file->tetrahedra == mesh_of(cube).tetrahedra);
    CHECK(file->vertices[8] == file->vertices[0]);
    CHECK(to_text(*file, std::vector<Point3>(9, Point3{7, 7, 7})).find("nan 0 inf 3") != std::string::npos);
    const auto used = parse_medit(with(dirty, "1 7 5 8", "1 7 5 9"), "file.mesh", StrayVertices::leave_out);
    REQUIRE_FALSE(used);
    CHECK(to_string(used.error()) == refusal_of(dirty));
}

TEST_CASE("a mesh of tetrahedra is read with its surface", "[medit]") {
    const MeshFile file = mesh_of(cube);
    REQUIRE(file.vertices.size() == 8);
    CHECK(file.vertices[3] == Point3{1, 1.5, 0});
    CHECK(file.vertices[7] == Point3{1, 1.5, 1});
    REQUIRE(file.tetrahedra.size() == 6);
    CHECK(file.tetrahedra[4] == std::array<std::uint32_t, 4>{7, 4, 5, 0});
    CHECK(file.triangles.size() == 12); // two per side of the cube, whatever the orientation of its cells
    CHECK(volume_inside(file) == 9);
    CHECK(file.faces.empty());
}

TEST_CASE("writing a mesh of tetrahedra changes only its vertices", "[medit]") {
    const MeshFile file = mesh_of(cube);
    CHECK(to_text(file, file.vertices) == cube);
    auto moved = file.vertices;
    moved[2] = {0.1, 1.5, -0.25};
    moved[7][0] = 3;
    CHECK(to_text(file, moved) ==
          with(with(cube, "0 1.50e0 0 1", "0.1 1.50e0 -0.25 1"), "2 1 1.5 1 2", "2 3 1.5 1 2"));
    // Files written by the program are read without change, to the bit.
    moved[5] = {1.0 / 3, -1e-300, 5e22};
    const MeshFile again = mesh_of(medit_text(moved, file.tetrahedra));
    CHECK(again.vertices == moved);
    CHECK(again.tetrahedra == file.tetrahedra);
}

TEST_CASE("the triangles of a .mesh file of a surface are read", "[medit]") {
    const MeshFile file =
        mesh_of("MeshVersionFormatted 1 Dimension 3 Vertices 4 0 0 0 0 1 0 0 0 1 1 0 0 0 1 0 0 "
                "Triangles 1 1 2 3 0 Quadrilaterals 1 1 2 3 4 0");
    CHECK(file.tetrahedra.empty());
    CHECK(file.triangles == detail::Triangles{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}});
}

TEST_CASE("broken .mesh files are refused with the line", "[medit]") {
    CHECK(refusal_of("") == "file.mesh: is empty");
    CHECK(refusal_of("v 0 0 0\n") ==
          "file.mesh: is not a .mesh file, which begins with MeshVersionFormatted (line 1)");
    CHECK(refusal_of("# nothing\n") ==
          "file.mesh: is not a .mesh file, which begins with MeshVersionFormatted (line 1)");
    CHECK(refusal_of("MeshVersionFormatted 2\nDimension 2\nEnd\n") ==
          "file.mesh: Dimension is \"2\": a mesh in space has 3 (line 2)");
    CHECK(refusal_of("MeshVersionFormatted 2\nDimension") ==
          "file.mesh: Dimension is missing: a mesh in space has 3 (line 2)");
    CHECK(refusal_of("MeshVersionFormatted 2\nDimension 3\nTetrahedra\n0\nEnd\n") ==
          "file.mesh: holds no vertices (a section \"Vertices\")");
    CHECK(refusal_of(with(cube, "Vertices 8", "Vertices 9")) ==
          "file.mesh: Vertices end after 8 of 9 (line 13)");
    CHECK(refusal_of(with(cube, "Vertices 8", "Vertices 1e9")) ==
          "file.mesh: the number of Vertices is missing (line 5)");
    CHECK(refusal_of(with(cube, "Vertices 8", "Vertices 99999999999999999999")) ==
          "file.mesh: the number of Vertices is missing (line 5)");
    CHECK(refusal_of(with(cube, "Vertices 8 ", "Vertices 99999999999999 ")) ==
          "file.mesh: Vertices end after 8 of 99999999999999 (line 13)");
    CHECK(refusal_of(with(cube, "1 0 0 1\n", "1 0 x 1\n")) ==
          "file.mesh: Vertices end after 1 of 8 (line 7)");
    CHECK(refusal_of(with(cube, "1 0 0 1\n", "1 0 0,5 1\n")) == "file.mesh: not a number: \"0,5\" (line 7)");
    CHECK(refusal_of(with(cube, "1 0 0 1\n", "1 nan 0 1\n")) ==
          "file.mesh: the coordinates of a vertex are not finite (line 7)");
    CHECK(refusal_of(with(cube, "1 4 3 8 0", "1 4 0 8 0")) ==
          "file.mesh: a vertex index is 0; indices count from 1 (line 19)");
    CHECK(refusal_of(with(cube, "1 4 3 8 0", "1 4 9 8 0")) ==
          "file.mesh: vertex index 9 is out of range: the file has 8 (line 19)");
    CHECK(refusal_of(with(cube, "1 4 3 8 0", "1 4 -1 8 0")) == "file.mesh: not an index: \"-1\" (line 19)");
    CHECK(refusal_of(with(cube, "1 4 3 8 0", "1 4 4294967297 8 0")) ==
          "file.mesh: vertex index 4294967297 is out of range: the file has 8 (line 19)");
    CHECK(refusal_of(with(cube, "Triangles", "Tetrahedra")) ==
          "file.mesh: a second section \"Tetrahedra\" (line 24)");
    CHECK(refusal_of(cube.substr(0, cube.find("Triangles") - 4)) ==
          "file.mesh: Tetrahedra end after 5 of 6 (line 23)");
}

} // namespace medit_file_tests

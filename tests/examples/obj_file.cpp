#include "files/obj_file.hpp"

#include "files/gltf_figure.hpp"
#include "files/moved_normals.hpp"
#include "files/obj_parts.hpp"
#include "io/csv.hpp"

#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace obj_file_tests {

using namespace cageform_support;

namespace {

MeshFile parsed(const std::string& text) {
    auto file = parse_obj(text, "file.obj");
    INFO(text);
    if (!file) FAIL(to_string(file.error()));
    return std::move(*file);
}

std::string refusal(const std::string& text) {
    const auto file = parse_obj(text, "file.obj");
    INFO(text);
    REQUIRE_FALSE(file);
    return to_string(file.error());
}

double distance(const Point3& a, const Point3& b) {
    const Point3 d = a - b;
    return std::hypot(d[0], d[1], d[2]);
}

/// Twice the sum of the signed areas of a face's triangles, and twice the sum of the absolute areas.
struct Areas {
    double sum = 0, apart = 0;
};
Areas areas(const MeshFile& file, const Point3& normal) {
    Areas both;
    for (const auto& [a, b, c] : file.triangles) {
        const double area =
            dot(normal, cross(file.vertices[b] - file.vertices[a], file.vertices[c] - file.vertices[a]));
        both.sum += area;
        both.apart += std::fabs(area);
    }
    return both;
}

/// A cube with shared corners and one normal per face.
const std::string cube =
    "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n"
    "vn 0 0 -1\nvn 0 0 2\nvn 0 -1 0\nvn 1 0 0\nvn 0 1 0\nvn -1 0 0\n"
    "f 4//1 3//1 2//1 1//1\nf 5//2 6//2 7//2 8//2\nf 1//3 2//3 6//3 5//3\n"
    "f 2//4 3//4 7//4 6//4\nf 3//5 4//5 8//5 7//5\nf 4//6 1//6 5//6 8//6\n";

/// Typical contents of files, and everything that the format allows.
const std::string everything = "\xef\xbb\xbf# a comment that ends with a backslash \\\n"
                               "mtllib a b.mtl\r\n"
                               "v 1.000 2.50 -0.0 0.5 0.25 1 # a colour\r\n"
                               "\tv\t+1e0\t.5 \t 5. 1.0\n"
                               "v 1 \\\r\n  2 \\\n 3\n"
                               "v -7 8 9\r"
                               "vt 0.5 0.5\n"
                               "vn 0 0 1\nvn nan 0 inf\n"
                               "o thing\ng a b c\nusemtl steel\ns off\n"
                               "f 1/1/1 2/1/1 3/1/1\n"
                               "f -4//-2 -3//-1 \\\n -2//1 -1\n"
                               "f 1/ 2/1 3/1/\n"
                               "l 1 2\np 3\ncurv2 1 2\nwhatever \x01\xff\n"
                               "f 1 2 5\nv 0 0 0";

Point3 turned_about_y(const Point3& p, double angle) {
    return {std::cos(angle) * p[0] + std::sin(angle) * p[2], p[1],
            std::cos(angle) * p[2] - std::sin(angle) * p[0]};
}

} // namespace

TEST_CASE("an OBJ file at rest is written byte for byte", "[examples][obj]") {
    for (const std::string& text : {cube, everything}) {
        const MeshFile file = parsed(text);
        CHECK(to_text(file, file.vertices) == text);
    }
}

TEST_CASE("an OBJ file is read", "[examples][obj]") {
    const MeshFile file = parsed(everything);
    CHECK(file.vertices == std::vector<Point3>{{1, 2.5, 0}, {1, 0.5, 5}, {1, 2, 3}, {-7, 8, 9}, {0, 0, 0}});
    CHECK(file.normals.size() == 2);
    REQUIRE(file.faces.size() == 4);
    CHECK(file.faces[0].corners == std::vector<MeshCorner>{{0, 0}, {1, 0}, {2, 0}});
    CHECK(file.faces[1].corners == std::vector<MeshCorner>{{0, 0}, {1, 1}, {2, 0}, {3, MeshCorner::none}});
    CHECK(file.faces[1].line == 17);
    CHECK(file.faces[2].corners ==
          std::vector<MeshCorner>{{0, MeshCorner::none}, {1, MeshCorner::none}, {2, MeshCorner::none}});
    CHECK(file.faces[3].corners[2].vertex == 4); // an index may refer to a later line
    CHECK(file.triangles.size() == 5);
}

TEST_CASE("only the numbers that change are written anew", "[examples][obj]") {
    const MeshFile file = parsed(everything);
    auto moved = file.vertices;
    moved[0][1] = 0.1;
    moved[2] = {-1, 2, 1e-7};
    std::string expected = everything;
    const auto replace = [&](std::string_view from, std::string_view to) {
        expected.replace(expected.find(from), from.size(), to);
    };
    replace("2.50", "0.1");
    replace("v 1 \\\r\n  2 \\\n 3\n", "v -1 \\\r\n  2 \\\n 1e-07\n");
    const std::string text = to_text(file, moved);
    // The normals change too; the next test checks them.
    const auto normals = text.find("vn"), behind = text.find("\no thing");
    CHECK(text.substr(0, normals) == expected.substr(0, normals));
    CHECK(text.substr(behind) == expected.substr(expected.find("\no thing")));
}

TEST_CASE("an OBJ file written and read is unchanged to the bit", "[examples][obj]") {
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    std::mt19937_64 random(static_cast<unsigned>(seed));
    std::normal_distribution<double> normal;
    const MeshFile file = parsed(cube);
    auto moved = file.vertices;
    for (Point3& p : moved) p = {normal(random), 1e-12 * normal(random), 1e15 * normal(random)};
    const MeshFile again = parsed(to_text(file, moved));
    CHECK(again.vertices == moved);
    CHECK(again.normals == MovedNormals(file, {moved}).of_file());
}

TEST_CASE("normals rotate with the mesh and keep their length", "[examples][obj]") {
    const MeshFile file = parsed(cube);
    const double angle = GENERATE(0.0, 0.3, 1.5707963267948966, 3.0, std::numbers::pi, -2.0);
    CAPTURE(angle);
    std::vector<Point3> moved;
    for (const Point3& p : file.vertices) moved.push_back(turned_about_y(3 * p, angle) + Point3{10, -20, 5});
    const auto normals = MovedNormals(file, {moved}).of_file();
    for (std::size_t i = 0; i < normals.size(); ++i)
        CHECK(distance(normals[i], turned_about_y(file.normals[i], angle)) < 1e-13);
}

TEST_CASE("a normal moves by the inverse transpose of the Jacobian", "[examples][obj]") {
    const auto seed = GENERATE(seeds(200));
    CAPTURE(seed);
    std::mt19937_64 random(static_cast<unsigned>(seed));
    std::normal_distribution<double> normal;
    const auto draw = [&] { return Point3{normal(random), normal(random), normal(random)}; };
    Jacobian3 jacobian{draw(), draw(), draw()};
    const Point3 n = draw(), across = cross(n, draw()), other = cross(n, across);
    const auto image = [&](const Point3& p) {
        return p[0] * jacobian[0] + p[1] * jacobian[1] + p[2] * jacobian[2];
    };
    const auto moved = moved_normal(jacobian, n);
    REQUIRE(moved);
    const double length = std::sqrt(dot(n, n)), stretch = 1e-12 * length * length * length;
    CHECK(std::fabs(std::sqrt(dot(*moved, *moved)) - length) < 1e-14 * length);
    for (const Point3& tangent : {across, other}) // tangents stay perpendicular to the normal
        CHECK(std::fabs(dot(*moved, image(tangent))) <
              100 * stretch * std::sqrt(dot(image(tangent), image(tangent))));
    CHECK(dot(*moved, image(n)) > 0); // and keep their sign
    CHECK(moved_normal({Point3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, n) == n);
    jacobian[2] = 2.0 * jacobian[0] - 0.5 * jacobian[1];
    CHECK_FALSE(moved_normal(jacobian, n));
}

TEST_CASE("vertices that are not finite are left out if no face uses them", "[examples][obj]") {
    const std::string text = "v nan 0 0\nv 1 2 3\nv 2 2 3\nv 1 inf 3\nv 1 3 3\nf 2 3 5\n";
    CHECK(refusal(text) == "file.obj: the coordinates of a vertex are not finite (line 1)");
    const auto file = parse_obj(text, "file.obj", StrayVertices::leave_out);
    REQUIRE(file);
    CHECK(file->left_out == std::vector<std::size_t>{0, 3});
    CHECK(file->vertices[0] == file->vertices[1]);
    auto moved = file->vertices;
    for (Point3& p : moved) p = 2.0 * p;
    CHECK(to_text(*file, moved) == "v nan 0 0\nv 2 4 6\nv 4 4 6\nv 1 inf 3\nv 2 6 6\nf 2 3 5\n");
    const auto used = parse_obj(text + "f 1 2 3\n", "file.obj", StrayVertices::leave_out);
    REQUIRE_FALSE(used);
    CHECK(to_string(used.error()) == "file.obj: the coordinates of a vertex are not finite (line 1)");
    CHECK_FALSE(parse_obj("v nan 0 0\n", "file.obj", StrayVertices::leave_out));
}

TEST_CASE("the documented table of statements is that of the code", "[examples][obj]") {
    const auto document = read_file(CAGEFORM_TEST_DATA "/../../examples/programs/README.md");
    REQUIRE(document);
    INFO(statement_table());
    CHECK((*document + "\n").find("\n\n" + statement_table() + '\n') != std::string::npos);
}

TEST_CASE("unusable numbers of materials are reported and replaced by the defaults",
          "[examples][obj][property]") {
    const auto seed = GENERATE(range(0, 40));
    CAPTURE(seed);
    std::mt19937_64 random(static_cast<unsigned>(seed));
    const auto folder =
        std::filesystem::temp_directory_path() / ("cageform-mtl-" + std::to_string(std::random_device()()));
    std::filesystem::create_directory(folder);
    const auto material_of = [&](const std::string& text, std::vector<std::string>& warnings) {
        std::ofstream(folder / "m.mtl") << "newmtl a\n" << text;
        const auto file = parse_obj("mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
                                    (folder / "m.obj").string());
        REQUIRE(file);
        ObjParts parts = read_parts(*file);
        warnings = parts.warnings;
        return parts.materials.at(0);
    };
    std::string dirty, clean;
    std::vector<std::string> expected, warnings, none;
    std::size_t line = 1;
    for (const std::string keyword : {"Kd", "Ks", "Ke", "d", "Ns", "Pr", "Pm"}) {
        const std::size_t count = keyword[0] == 'K' ? 3 : 1;
        std::vector<std::string> words;
        for (std::size_t k = 0; k < count; ++k) words.push_back("0." + std::to_string(1 + random() % 9));
        auto sound = words;
        const std::size_t at = random() % count;
        const int fault = int(random() % 6);
        if (fault == 0) words[at][1] = ',';
        if (fault == 1) words[at] = std::array{"nan", "inf", "red"}[random() % 3];
        if (fault == 2 || (fault == 3 && count == 1)) words.resize(count == 3 ? 2 : 0);
        if (fault == 3 && count == 3) {
            words.resize(1);
            sound.assign(3, words[0]);
        }
        if (fault == 4) {
            words[at] = "-2";
            sound[at] = "0";
        }
        const auto statement = [&](const std::vector<std::string>& numbers) {
            std::string text = keyword;
            for (const std::string& number : numbers) text += ' ' + number;
            return text;
        };
        dirty += statement(words) + '\n';
        if (fault > 3 || (fault == 3 && count == 3)) clean += statement(sound) + '\n';
        ++line;
        if (fault < 5)
            expected.push_back((folder / "m.mtl").string() + ':' + std::to_string(line) + ": \"" +
                               statement(words) + "\": ");
    }
    const ObjMaterial is = material_of(dirty, warnings), should = material_of(clean, none);
    std::filesystem::remove_all(folder);
    INFO(dirty);
    CHECK(none.empty());
    REQUIRE(warnings.size() == expected.size());
    for (std::size_t k = 0; k < warnings.size(); ++k) CHECK(warnings[k].find(expected[k]) == 0);
    CHECK(is.colour == should.colour);
    CHECK(is.emission == should.emission);
    CHECK(is.opacity == should.opacity);
    CHECK(is.metallic == should.metallic);
    CHECK(is.roughness == should.roughness);
}

TEST_CASE("tangents point along u, and their sign is that of v", "[examples][obj][gltf]") {
    const auto seed = GENERATE(seeds(50));
    CAPTURE(seed);
    std::mt19937_64 random(static_cast<unsigned>(seed));
    std::normal_distribution<double> normal;
    const auto draw = [&] { return Point3{normal(random), normal(random), normal(random)}; };
    const Point3 origin = draw(), u = draw(),
                 v = draw(); // the position of a texture point: origin + u U + v V
    GltfSurface surface;
    surface.maps = {identity_map};
    surface.triangles = {{0, 1, 2}, {0, 1, 3}};
    std::vector<Point3> places;
    for (std::uint32_t n = 0; n < 4; ++n) {
        const double at_u = normal(random), at_v = normal(random);
        places.push_back(origin + at_u * u + at_v * v);
        surface.corners.push_back({n, MeshCorner::none});
        surface.texture.push_back({float(at_u), 1 - float(at_v)});
    }
    const Point3 across = cross(u, v), n = (1 / std::sqrt(dot(across, across))) * across;
    const std::vector<std::array<float, 3>> normals(4, {float(n[0]), float(n[1]), float(n[2])});
    const auto tangents = gltf_tangents(surface, places, normals);
    REQUIRE(tangents.size() == 4);
    for (const auto& [x, y, z, side] : tangents) {
        const Point3 tangent{double(x), double(y), double(z)};
        CHECK(distance(tangent, (1 / std::sqrt(dot(u, u))) * u) < 1e-2); // single precision
        CHECK(dot(double(side) * cross(n, tangent), v) > 0);
    }
}

TEST_CASE("reversing faces changes only the order of their corners in the text", "[examples][obj]") {
    for (const std::string& text : {cube, everything}) {
        const MeshFile file = parsed(text), turned = with_faces_reversed(file), read = parsed(turned.text);
        CHECK(with_faces_reversed(turned).text == text);
        CHECK(to_text(turned, file.vertices) == turned.text);
        REQUIRE(turned.faces.size() == file.faces.size());
        for (std::size_t f = 0; f < file.faces.size(); ++f) {
            auto corners = turned.faces[f].corners;
            CHECK(corners == read.faces[f].corners);
            std::reverse(corners.begin() + 1, corners.end());
            CHECK(corners == file.faces[f].corners);
        }
        for (std::size_t k = 0; k < file.numbers.size(); ++k) {
            CHECK(turned.numbers[k].begin == read.numbers[k].begin);
            CHECK(turned.numbers[k].end == read.numbers[k].end);
        }
        for (std::size_t t = 0; t < file.triangles.size(); ++t) {
            const auto& [a, b, c] = file.triangles[t];
            CHECK(turned.triangles[t] == std::array{a, c, b});
        }
    }
}

TEST_CASE("a normal of several faces follows their mean, weighted by area", "[examples][obj]") {
    // A roof: two squares that share an edge and its normal; one is folded down.
    const MeshFile file =
        parsed("v -1 0 0\nv 0 0 0\nv 0 1 0\nv -1 1 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nvn 1 0 0\n"
               "f 1//1 2//1 3//1 4//1\nf 2//1 5//1 6//1 3//1\n");
    auto moved = file.vertices;
    moved[4] = {0, 0, -1};
    moved[5] = {0, 1, -1};
    const auto normals = MovedNormals(file, {moved}).of_file();
    CHECK(distance(normals[0], {std::sqrt(0.5), 0, std::sqrt(0.5)}) < 1e-15);
    CHECK(normals[1] == file.normals[1]); // no face uses it

    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] = 1.7 * file.vertices[i] + Point3{0.1, 0.2, 0.3};
    CHECK(MovedNormals(file, {moved}).of_file() == file.normals); // moved and scaled, but not turned

    for (Point3& p : moved) p = {0, 0, 0};
    CHECK(MovedNormals(file, {moved}).of_file() == file.normals); // no direction remains
}

TEST_CASE("faces are triangulated with one orientation", "[examples][obj]") {
    const int corners = GENERATE(4, 5, 6, 9);
    const double offset = GENERATE(0.0, 5.0, -3.0);
    const bool dented = GENERATE(false, true);
    CAPTURE(corners, offset, dented);
    std::string text, face = "f";
    for (int i = 0; i < corners; ++i) {
        const double angle = 2 * std::numbers::pi * i / corners, radius = dented && i == 1 ? 0.2 : 1;
        text += "v " + std::to_string(offset + radius * std::cos(angle)) + ' ' +
                std::to_string(0.7 * offset + radius * std::sin(angle)) + " 0.5\n";
        face += ' ' + std::to_string(i + 1);
    }
    const MeshFile file = parsed(text + face + '\n');
    CHECK(file.folded.empty());
    CHECK(file.triangles.size() == static_cast<std::size_t>(corners) - 2);
    const Areas both = areas(file, {0, 0, 1});
    CHECK(both.sum == Approx(both.apart));
    CHECK(both.sum == Approx(detail::area_vector(file.faces[0], file.vertices)[2]));
}

TEST_CASE("a self-intersecting face is reported as folded", "[examples][obj]") {
    for (const char* last : {"v 0 4 0\n", "v 0 1 0\n"}) { // with no area in sum, and with some
        const MeshFile file =
            parsed("v 0 0 0\nv 4 4 0\nv 4 0 0\n" + (last + std::string("f 1 2 3\nf 1 2 3 4\n")));
        CHECK(file.folded == std::vector<std::size_t>{1});
    }
}

TEST_CASE("a file of another format is recognized by its first bytes", "[examples][obj]") {
    std::string binary_stl(84, ' ');
    binary_stl[80] = 2;
    std::fill(binary_stl.begin() + 81, binary_stl.end(), '\0');
    binary_stl.resize(84 + 2 * 50);
    const std::pair<std::string, std::string_view> files[] = {
        {binary_stl, "STL"},
        {"solid cube\nfacet normal 0 0 1\n", "STL"},
        {"SOLID CUBE\nFACET NORMAL 0 0 1\n", "STL"},
        {std::string("glTF\2\0\0\0", 8), "glTF"},
        {R"({"scenes": [], "asset": {"version": "2.0"}})", "glTF"},
        {"ply\r\nformat ascii 1.0\r\n", "PLY"},
        {"Kaydara FBX Binary  ", "FBX"},
        {"; FBX 7.4.0 project file\n", "FBX"},
        {"COFF\n8 6 12\n", "OFF"},
        {"#VRML V2.0 utf8\nShape {}\n", "VRML"},
        {std::string("MM\x20\0\0\0", 6), "3DS"},
        {"# vtk DataFile Version 3.0\ncube\nASCII\n", "VTK"},
        {"MeshVersionFormatted 2\n", "Medit"},
        {"<?xml version=\"1.0\"?>\n<COLLADA/>\n", "XML"},
        {"\x1f\x8b\x08", "gzip"},
        {"<svg xmlns=\"http://www.w3.org/2000/svg\"/>", "SVG, which deform_svg reads"},
        {"\xef\xbb\xbf<?xml version=\"1.0\"?>\n<!-- a -->\n<svg>\nv 1 2", "SVG, which deform_svg reads"},
        {"\xef\xbb\xbfsolid cube\n", "STL"},
        {"#usda 1.0\n", "USD"},
        {" \n[1, 2]", "JSON"},
    };
    for (const auto& [text, format] : files) {
        CAPTURE(format);
        const auto file = parse_obj(text, "mesh.obj");
        REQUIRE_FALSE(file);
        CHECK(to_string(file.error()).find("a file of the format " + std::string(format)) !=
              std::string::npos);
    }
    CHECK(parse_obj("# solid\no MM\nv 0 0 0\n", "mesh.obj")); // begins like none of them
}

TEST_CASE("faults of an OBJ file are reported with their lines", "[examples][obj]") {
    const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    CHECK(refusal("") == "file.obj: is empty");
    for (const std::string& text : {std::string("# nothing\n"), std::string("f 1 2 3\n"),
                                    std::string("\1\nv \0\n", 6)}) // a binary file
        CHECK(refusal(text) ==
              "file.obj: holds no vertices: it is no glTF, PLY, STL or Medit file, and has no "
              "OBJ lines \"v x y z\"");
    CHECK(refusal("v 1 2\n") == "file.obj: three numbers are expected (line 1)");
    CHECK(refusal("\nv 1 2 x\n") == "file.obj: not a number: \"x\" (line 2)");
    CHECK(refusal("v 1 2 3,\n") == "file.obj: not a number: \"3,\" (line 1)");
    CHECK(refusal("v 1 2 3abc") == "file.obj: not a number: \"3abc\" (line 1)");
    CHECK(refusal("v 1 2 +") == "file.obj: not a number: \"+\" (line 1)");
    CHECK(refusal("v 1 2 1e999") == "file.obj: the coordinates of a vertex are not finite (line 1)");
    CHECK(refusal("v 1 2 nan") == "file.obj: the coordinates of a vertex are not finite (line 1)");
    CHECK(refusal("v 1 -inf 0") == "file.obj: the coordinates of a vertex are not finite (line 1)");
    CHECK(refusal(three + "vn 0 z 1") == "file.obj: not a number: \"z\" (line 4)");
    CHECK(refusal(three + "f 1 2") == "file.obj: a face has fewer than three corners (line 4)");
    CHECK(refusal(three + "f 0 1 2") == "file.obj: a vertex index is 0; indices count from 1 (line 4)");
    CHECK(refusal(three + "f 1 2 4") == "file.obj: vertex index 4 is out of range: the file has 3 (line 4)");
    CHECK(refusal("v 0 0 0\nf -1 -2 -1\nv 1 0 0") ==
          "file.obj: vertex index -2 is out of range: the file has 1 before this line (line 2)");
    CHECK(refusal(three + "f 1 2 \\\n 99999999999999999999") ==
          "file.obj: vertex index 99999999999999999999 is out of range: the file has 3 (line 4)");
    CHECK(
        refusal(three + "f 1 2 -9223372036854775808") ==
        "file.obj: vertex index -9223372036854775808 is out of range: the file has 3 before this line (line "
        "4)");
    CHECK(refusal(three + "f 1 2 x") == "file.obj: not an index: \"x\" (line 4)");
    CHECK(refusal(three + "f 1 2 /1") == "file.obj: not an index: \"\" (line 4)");
    CHECK(refusal(three + "f 1//1 2 3") ==
          "file.obj: normal index 1 is out of range: the file has 0 (line 4)");
    CHECK(refusal(three + "vn 0 0 1\r\nf 1//0 2 3") ==
          "file.obj: a normal index is 0; indices count from 1 (line 5)");
}

TEST_CASE("unreadable OBJ files are reported by name", "[examples][obj]") {
    const auto missing = load_mesh("no/such/file.obj");
    REQUIRE_FALSE(missing);
    CHECK(to_string(missing.error()) == "no/such/file.obj: no such file");
    const auto folder = load_mesh(".");
    REQUIRE_FALSE(folder);
    CHECK(to_string(folder.error()) == ".: is a folder");
}

TEST_CASE("copies of a vertex that differ by rounding are joined, other vertices are not",
          "[examples][obj]") {
    const auto seed = GENERATE(seeds(10));
    CAPTURE(seed);
    std::mt19937_64 random(static_cast<unsigned>(seed));
    std::normal_distribution<double> normal;
    const double size = std::exp(5 * normal(random));
    const MeshFile single = parsed(cube);
    MeshFile split = single; // each triangle has its own vertices
    split.vertices.clear();
    split.triangles.clear();
    std::vector<std::uint32_t> source;
    for (const auto& triangle : single.triangles) {
        const auto first = std::uint32_t(source.size());
        split.triangles.push_back({first, first + 1, first + 2});
        for (const std::uint32_t v : triangle) {
            source.push_back(v);
            Point3& p = split.vertices.emplace_back(size * single.vertices[v]);
            for (double& x : p.v) x += 1e-7 * size * std::tanh(normal(random));
        }
    }
    if (seed % 2 == 0) { // a separate sky
        const auto first = std::uint32_t(source.size());
        split.triangles.push_back({first, first + 1, first + 2});
        for (std::uint32_t k = 0; k < 3; ++k) {
            source.push_back(8 + k);
            split.vertices.push_back({1e7 * size, k == 1 ? size : 0, k == 2 ? size : 0});
        }
    }
    const auto joined = joined_places(split);
    for (std::size_t i = 0; i < source.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) CHECK((joined[i] == joined[j]) == (source[i] == source[j]));
    }
}

TEST_CASE("a normal shared by several vertices is exact at each of them", "[examples][obj]") {
    const auto seed = GENERATE(seeds(20));
    CAPTURE(seed);
    std::mt19937_64 random(static_cast<unsigned>(seed));
    std::normal_distribution<double> normal;
    const bool is_affine = seed % 2 == 0;
    std::string text = cube + "vt 0 0\nf -8/1/-6 -7/1/2 -6//-1\nvn 1 1 0 # last\nf 1//-1 2//7 3\n";
    if (seed % 3 == 0) text.insert(text.find("vn 0 -1"), " \\\r\n\tg vn\r\n ");
    const MeshFile file = parsed(text);
    std::array<Point3, 4> linear, square;
    for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t c = 0; c < 3; ++c) {
            linear[k][c] = normal(random) + (k == c ? 3 : 0);
            square[k][c] = is_affine ? 0 : 0.3 * normal(random);
        }
    }
    std::vector<Point3> places;
    std::vector<Jacobian3> jacobians;
    for (const Point3& p : file.vertices) {
        Point3 moved = linear[3];
        for (std::size_t k = 0; k < 3; ++k) moved = moved + p[k] * linear[k] + (p[k] * p[k]) * square[k];
        places.push_back(moved);
        auto& jacobian = jacobians.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) jacobian[k] = linear[k] + 2 * p[k] * square[k];
    }
    const MeshFile again = parsed(to_text(file, {places, jacobians}));
    CHECK(again.vertices == places);
    CHECK((again.normals.size() == file.normals.size()) == is_affine);
    REQUIRE(again.faces.size() == file.faces.size());
    for (std::size_t f = 0; f < file.faces.size(); ++f) {
        REQUIRE(again.faces[f].corners.size() == file.faces[f].corners.size());
        for (std::size_t c = 0; c < file.faces[f].corners.size(); ++c) {
            const MeshCorner &rest = file.faces[f].corners[c], &now = again.faces[f].corners[c];
            CHECK(now.vertex == rest.vertex);
            REQUIRE((now.normal == MeshCorner::none) == (rest.normal == MeshCorner::none));
            if (rest.normal == MeshCorner::none) continue;
            const auto expected = moved_normal(jacobians[rest.vertex], file.normals[rest.normal]);
            REQUIRE(expected);
            CHECK(distance(again.normals[now.normal], *expected) < 1e-12);
        }
    }
}

TEST_CASE("no text crashes the OBJ reader", "[examples][obj][fuzz]") {
    const auto seed = GENERATE(seeds(300));
    CAPTURE(seed);
    std::mt19937_64 random(static_cast<unsigned>(seed));
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
    std::string text;
    if (seed % 3 == 0) { // random bytes
        for (std::size_t n = below(400); n > 0; --n) text += static_cast<char>(below(256));
    } else if (seed % 3 == 1) { // random pieces of the format
        static const std::vector<std::string> pieces{
            "v ", "vn ",    "f ",      "1 ",   "2 ", "-1 ",          "0 ",        "1/1",
            "//", "1e308 ", "-1e308 ", "\\\n", "\n", "\r\n",         "v 1 2 3\n", "#",
            "\t", " ",      "1e-308 ", "nan ", "s ", "99999999999 ", "\\",        std::string(1, '\0')};
        for (std::size_t n = below(200); n > 0; --n) text += pieces[below(pieces.size())];
    } else { // a valid file with a few bytes changed
        text = seed % 2 == 0 ? cube : everything;
        for (std::size_t n = 1 + below(4); n > 0; --n)
            text[below(text.size())] = static_cast<char>(below(256));
    }
    const auto file = parse_obj(text, "file.obj");
    if (!file) {
        CHECK_FALSE(file.error().message.empty());
        return;
    }
    CHECK(to_text(*file, file->vertices) == text);
    auto moved = file->vertices;
    for (Point3& p : moved) p = {p[1], -p[2], 2 * p[0]};
    CHECK(MovedNormals(*file, {moved}).of_file().size() == file->normals.size());
}

} // namespace obj_file_tests

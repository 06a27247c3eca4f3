// PLY and STL files as meshes: random files of every layout are written with only the moved
// numbers replaced; broken files are reported.
#include "../catch.hpp"
#include "../support/cages.hpp"

#include "files/gltf_figure.hpp"
#include "files/obj_parts.hpp"
#include "files/ply_file.hpp"
#include "files/ply_mesh.hpp"
#include "files/posed_file.hpp"
#include "files/stl_file.hpp"

#include <bit>
#include <cstdio>
#include <cstring>
#include <functional>

namespace mesh_formats_tests {

using namespace cageform_support;
using cageform_tests::Random;

namespace {

double length(const Point3& v) {
    return std::sqrt(dot(v, v));
}

Point3 random_point(Random& random, double size) {
    return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

/// A random affine map that is not nearly singular; half of them mirror.
struct Affine {
    Jacobian3 axes;
    Point3 shift;

    explicit Affine(Random& random)
        : shift(random_point(random, 3)) {
        do {
            for (Point3& axis : axes) axis = random_point(random, 2);
        } while (std::fabs(dot(axes[0], cross(axes[1], axes[2]))) < 0.5);
    }
    Point3 vector(const Point3& v) const { return v[0] * axes[0] + v[1] * axes[1] + v[2] * axes[2]; }
    Point3 operator()(const Point3& p) const { return vector(p) + shift; }
};

/// A part of a file: bytes that never change, or a coordinate of a moved vector.
struct Piece {
    std::string bytes;
    std::optional<std::size_t> vector; // index in RandomFile::vectors
    std::size_t axis = 0;
    PlyType type = PlyType::float32;
};

struct Vector {
    enum Kind { place, normal, facet_normal } kind = place;
    Point3 value;
    std::array<Point3, 3> corners; // of a facet
};

/// A random file, with the vectors that move.
struct RandomFile {
    PlyEncoding encoding = PlyEncoding::ascii;
    std::vector<Piece> pieces;
    std::vector<Vector> vectors;
    std::vector<std::vector<std::uint32_t>> faces;
    std::vector<Point3> colours;

    std::string text() const {
        std::string all;
        for (const Piece& piece : pieces) all += piece.bytes;
        return all;
    }
    void add(const std::string& bytes) { pieces.push_back({bytes, {}, 0, PlyType::float32}); }
    /// Adds a number and, in ASCII, a blank; returns the number as stored.
    double add_number(Random& random, PlyType type, double number, std::optional<std::size_t> vector = {},
                      std::size_t axis = 0) {
        std::string bytes;
        if (encoding == PlyEncoding::ascii) {
            constexpr std::array formats{"%.9g", "%.12f", "%+.10e"};
            const char* const format = formats[random.below(type < PlyType::float32 ? 1 : 3)];
            std::array<char, 64> digits{};
            (void)std::snprintf(digits.data(), digits.size(), format, number);
            bytes = digits.data();
            number = std::strtod(bytes.c_str(), nullptr);
        } else {
            if (type == PlyType::float32) number = double(float(number));
            append_number(bytes, type, number);
            if (encoding == PlyEncoding::big_endian) std::reverse(bytes.begin(), bytes.end());
        }
        pieces.push_back({bytes, vector, axis, type});
        if (encoding == PlyEncoding::ascii) add(random.below(4) == 0 ? " \t " : " ");
        return number;
    }
};

/// The number of digits of a decimal number, without zeros at its ends.
std::size_t digit_count(std::string_view word) {
    std::string digits;
    for (const char c : word.substr(0, word.find('e'))) {
        if (c >= '0' && c <= '9') digits += c;
    }
    digits.erase(0, digits.find_first_not_of('0'));
    return digits.find_last_not_of('0') + 1;
}

/// The fewest digits with which printf() restores a number in single or double precision.
std::size_t digits_needed(double number, bool is_single) {
    for (int digits = 1;; ++digits) {
        std::array<char, 64> text{};
        (void)std::snprintf(text.data(), text.size(), "%.*e", digits - 1, number);
        if (is_single ? std::strtof(text.data(), nullptr) == float(number)
                      : std::strtod(text.data(), nullptr) == number)
            return std::size_t(digits);
    }
}

/// Removes the number at the beginning of a text, and returns it. In ASCII, a changed number has no needless
/// digits.
///
///   is_exact   whether the text is written in double precision, whatever the type
double taken_number(const RandomFile& file, const Piece& piece, std::string_view& text, bool is_exact) {
    if (file.encoding == PlyEncoding::ascii) {
        const std::size_t end = std::min(text.find_first_of(" \t\r\n"), text.size());
        const std::string word(text.substr(0, end));
        text.remove_prefix(end);
        char* stop = nullptr;
        const double number = std::strtod(word.c_str(), &stop);
        REQUIRE((!word.empty() && *stop == '\0'));
        const bool is_single = piece.type == PlyType::float32 && !is_exact;
        if (word != piece.bytes)
            REQUIRE(digit_count(word) <=
                    digits_needed(is_single ? double(float(number)) : number, is_single));
        return number;
    }
    const std::size_t size = bytes_of(piece.type);
    REQUIRE(text.size() >= size);
    std::string bytes(text.substr(0, size));
    text.remove_prefix(size);
    if (file.encoding == PlyEncoding::big_endian) std::reverse(bytes.begin(), bytes.end());
    float single = 0;
    double number = 0;
    std::memcpy(piece.type == PlyType::float32 ? static_cast<void*>(&single) : &number, bytes.data(), size);
    return piece.type == PlyType::float32 ? double(single) : number;
}

/// Checks that a text is the file with its vectors moved, and everything else equal.
void check_moved(const RandomFile& file, std::string_view text, const Affine& map, bool is_exact) {
    std::vector<Point3> moved(file.vectors.size());
    for (const Piece& piece : file.pieces) {
        if (piece.vector) {
            moved[*piece.vector][piece.axis] = taken_number(file, piece, text, is_exact);
            continue;
        }
        REQUIRE(text.substr(0, piece.bytes.size()) == piece.bytes);
        text.remove_prefix(piece.bytes.size());
    }
    REQUIRE(text.empty());
    for (std::size_t n = 0; n < moved.size(); ++n) {
        const auto& [kind, value, corners] = file.vectors[n];
        if (kind == Vector::place) {
            REQUIRE(length(moved[n] - map(value)) < 1e-6 * 20); // of the size
            continue;
        }
        // A normal is perpendicular to the images of what it was perpendicular to, on the same side.
        const Point3 across =
            kind == Vector::normal
                ? cross(value, std::fabs(value[0]) < 0.5 * length(value) ? Point3{1, 0, 0} : Point3{0, 1, 0})
                : corners[1] - corners[0];
        const Point3 other = kind == Vector::normal ? cross(value, across) : corners[2] - corners[0];
        const double own = kind == Vector::normal ? length(value) : 1;
        for (const Point3& tangent : {map.vector(across), map.vector(other)})
            REQUIRE(std::fabs(dot(moved[n], tangent)) < 1e-4 * own * length(tangent));
        REQUIRE(std::fabs(length(moved[n]) - own) < 1e-4 * own);
        const Point3 side =
            kind == Vector::normal ? map.vector(value) : cross(map.vector(across), map.vector(other));
        REQUIRE(dot(moved[n], side) > 0);
    }
}

std::string moved_bytes(const MeshFile& mesh, const MovedVertices& moved) {
    const auto written = mesh.document->moved(mesh, moved, "out");
    if (!written) FAIL(to_string(written.error()));
    REQUIRE(written->files.size() == 1);
    return written->files.front().bytes;
}

/// The laws of writing a file: at rest every byte is kept; an affine pose moves exactly the vectors.
void check_writing(const RandomFile& file, const MeshFile& mesh, Random& random) {
    REQUIRE(moved_bytes(mesh, {mesh.vertices}) == file.text());
    const std::vector<Jacobian3> none(mesh.vertices.size(), {Point3{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    REQUIRE(moved_bytes(mesh, {mesh.vertices, none}) == file.text());
    const Affine map(random);
    std::vector<Point3> places;
    for (const Point3& p : mesh.vertices) places.push_back(map(p));
    const std::vector<Jacobian3> jacobians(places.size(), map.axes);
    const bool is_exact =
        mesh.document->extensions()[0] == ".stl" && !rounding_fault(mesh.name, places).empty();
    check_moved(file, moved_bytes(mesh, {places, jacobians}), map, is_exact);
}

/// A random property that is neither moved nor read.
void add_other(RandomFile& file, Random& random, const PlyProperty& property) {
    std::size_t count = 1;
    if (property.count) {
        count = random.below(4);
        file.add_number(random, *property.count, double(count));
    }
    for (; count > 0; --count)
        file.add_number(random, property.type,
                        double(random.below(100)) / (property.type < PlyType::float32 ? 1 : 7));
}

PlyProperty other_property(Random& random, const std::string& name) {
    PlyProperty property{name, PlyType(random.below(8)), {}};
    if (random.below(4) == 0) property.count = PlyType(random.below(6));
    return property;
}

std::string declared(const PlyProperty& property) {
    return "property " +
           (property.count ? "list " + std::string(name_of(*property.count)) + ' ' : std::string()) +
           std::string(name_of(property.type)) + ' ' + property.name + '\n';
}

/// The elements of a random PLY file. Properties that are moved or read have their usual names; all others begin
/// with q.
std::vector<PlyElement> random_elements(Random& random) {
    const std::size_t vertices = 1 + random.below(30), faces = vertices < 6 ? 0 : random.below(20);
    const bool has_normals = random.below(2) == 0, has_colours = random.below(2) == 0;
    std::vector<PlyElement> elements;
    const auto add_others = [&](PlyElement& element) {
        while (random.below(2) == 0)
            element.properties.push_back(
                other_property(random, "q" + std::to_string(element.properties.size())));
    };
    const auto add_element = [&](const std::string& name) {
        if (random.below(3) != 0) return;
        PlyElement element{name, random.below(5), {other_property(random, "q")}};
        add_others(element);
        elements.push_back(std::move(element));
    };
    add_element("before");
    PlyElement vertex{"vertex", vertices, {}};
    const auto add_numbers = [&](std::initializer_list<const char*> names, bool is_colour) {
        for (const char* const name : names) {
            const PlyType real = random.below(2) == 0 ? PlyType::float32 : PlyType::float64;
            vertex.properties.push_back(
                {name, is_colour && random.below(2) == 0 ? PlyType::uint8 : real, {}});
        }
    };
    add_numbers({"x", "y", "z"}, false);
    if (has_normals) add_numbers({"nx", "ny", "nz"}, false);
    if (has_colours) add_numbers({"red", "green", "blue"}, true);
    add_others(vertex);
    for (std::size_t n = vertex.properties.size(); n > 1; --n)
        std::swap(vertex.properties[n - 1], vertex.properties[random.below(n)]);
    elements.push_back(std::move(vertex));
    add_element("between");
    if (faces > 0) {
        PlyElement face{"face", faces, {}};
        add_others(face);
        const char* const name = random.below(2) == 0 ? "vertex_indices" : "vertex_index";
        face.properties.push_back({name, PlyType(random.below(6)), PlyType(random.below(6))});
        add_others(face);
        elements.push_back(std::move(face));
        if (random.below(4) == 0) std::swap(elements.back(), elements.front());
    }
    add_element("after");
    return elements;
}

/// Adds a face with random neighbouring vertices.
void add_face(RandomFile& file, Random& random, const PlyProperty& property, std::size_t vertices) {
    auto& face = file.faces.emplace_back();
    const std::size_t corners = 3 + random.below(3), first = random.below(vertices);
    for (std::size_t k = 0; k < corners; ++k) face.push_back(std::uint32_t((first + k) % vertices));
    file.add_number(random, *property.count, double(corners));
    for (const std::uint32_t corner : face) file.add_number(random, property.type, double(corner));
}

/// Adds a number of the last vertex, which has a random value.
void add_of_vertex(RandomFile& file, Random& random, const PlyProperty& property) {
    const std::string& name = property.name;
    const std::size_t axis = name.ends_with("y") || name == "green"  ? 1
                             : name.ends_with("z") || name == "blue" ? 2
                                                                     : 0;
    if (name.size() > 2) {
        const bool is_byte = property.type == PlyType::uint8;
        const double colour = double(random.below(256)) / (is_byte ? 1 : 255);
        file.colours.back()[axis] = file.add_number(random, property.type, colour) / (is_byte ? 255 : 1);
        return;
    }
    std::size_t vector = file.vectors.size() - 1; // the normal, if any, follows the place
    if (name.size() == 1 && file.vectors[vector].kind == Vector::normal) --vector;
    double& number = file.vectors[vector].value[axis];
    number = file.add_number(random, property.type, number, vector, axis);
}

RandomFile random_ply(Random& random) {
    RandomFile file;
    file.encoding = PlyEncoding(random.below(3));
    constexpr std::array encodings{"ascii", "binary_little_endian", "binary_big_endian"};
    const auto elements = random_elements(random);
    std::string header =
        std::string("ply\nformat ") + encodings[std::size_t(file.encoding)] + " 1.0\ncomment of a test\n";
    std::size_t vertices = 0;
    for (const PlyElement& element : elements) {
        header += "element " + element.name + ' ' + std::to_string(element.count) + '\n';
        for (const PlyProperty& property : element.properties) header += declared(property);
        if (element.name == "vertex") vertices = std::size_t(element.count);
    }
    file.add(header + "end_header\n");
    for (const PlyElement& element : elements) {
        const bool is_vertex = element.name == "vertex";
        for (std::uint64_t n = 0; n < element.count; ++n) {
            if (is_vertex) file.vectors.push_back({Vector::place, random_point(random, 2), {}});
            if (is_vertex && element.find("nx"))
                file.vectors.push_back({Vector::normal, random_point(random, 1), {}});
            if (is_vertex && element.find("red")) file.colours.emplace_back();
            for (const PlyProperty& property : element.properties) {
                if (property.name[0] == 'q')
                    add_other(file, random, property);
                else if (is_vertex)
                    add_of_vertex(file, random, property);
                else
                    add_face(file, random, property, vertices);
            }
            if (file.encoding == PlyEncoding::ascii) file.add(random.below(3) == 0 ? "\r\n" : "\n");
        }
    }
    return file;
}

/// Adds a triangle between points of a grid, with attributes or line breaks.
void add_triangle(RandomFile& file, Random& random) {
    const bool is_text = file.encoding == PlyEncoding::ascii;
    const auto add_text = [&](const std::string& text) {
        if (is_text) file.add(text + (random.below(3) == 0 ? "\r\n\t" : " "));
    };
    std::array<Point3, 3> corners;
    for (Point3& p : corners) {
        for (std::size_t k = 0; k < 3; ++k) p[k] = (double(random.below(4)) - 1) * (0.37 + 0.11 * double(k));
        if (!is_text) p = cageform::vec_cast<double>(cageform::vec_cast<float>(p));
    }
    const Point3 area = cross(corners[1] - corners[0], corners[2] - corners[0]);
    const bool is_zero = length(area) < 1e-3 || random.below(4) == 0;
    std::optional<std::size_t> vector;
    if (!is_zero) {
        vector = file.vectors.size();
        file.vectors.push_back({Vector::facet_normal, {}, corners});
    }
    add_text("facet");
    add_text("normal");
    for (std::size_t k = 0; k < 3; ++k)
        file.add_number(random, PlyType::float32, is_zero ? 0 : area[k] / length(area), vector, k);
    add_text("outer loop");
    for (const Point3& p : corners) {
        add_text("Vertex");
        vector = file.vectors.size();
        file.vectors.push_back({Vector::place, p, {}});
        for (std::size_t k = 0; k < 3; ++k) {
            double& number = file.vectors.back().value[k];
            number = file.add_number(random, PlyType::float32, p[k], vector, k);
        }
    }
    add_text("endloop");
    add_text("ENDFACET");
    if (is_text && random.below(5) == 0) file.add("endsolid a\nsolid b\n");
    if (!is_text) file.add({char(random.below(256)), char(random.below(256))});
}

RandomFile random_stl(Random& random) {
    RandomFile file;
    const std::size_t triangles = 1 + random.below(30);
    if (random.below(2) == 0) {
        if (random.below(4) == 0) file.add("\xef\xbb\xbf");
        file.add(random.below(2) == 0 ? "solid a facet of b\n" : "SOLID\n");
    } else {
        file.encoding = PlyEncoding::little_endian;
        std::string head(80, random.below(2) == 0 ? '\0' : 'x');
        if (random.below(2) == 0) head.replace(0, 6, "solid ");
        for (int k = 0; k < 32; k += 8) head += char(triangles >> k & 255);
        file.add(head);
    }
    for (std::size_t t = 0; t < triangles; ++t) add_triangle(file, random);
    if (file.encoding != PlyEncoding::ascii && random.below(3) == 0)
        file.add(std::string(1 + random.below(120), char(random.below(256)))); // trailing bytes
    return file;
}

template <class F>
void with_random_files(std::uint64_t seeds, const F& check) {
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        check(random);
    }
}

const auto ply_of = [](std::string bytes) { return parse_ply(std::move(bytes), "in.ply"); };
const auto stl_of = [](std::string bytes) { return parse_stl(std::move(bytes), "in.stl"); };

/// Broken files are refused, or written at rest as they are.
void check_hostile(const std::string& bytes, const std::function<Expected<MeshFile>(std::string)>& parse) {
    const auto file = parse(bytes);
    if (!file) {
        REQUIRE(file.error().message.starts_with("in."));
        return;
    }
    REQUIRE(moved_bytes(*file, {file->vertices}) == bytes);
    for (const auto& triangle : file->triangles) {
        for (const std::uint32_t vertex : triangle) REQUIRE(vertex < file->vertices.size());
    }
}

void check_hostile_changes(const std::string& bytes, Random& random,
                           const std::function<Expected<MeshFile>(std::string)>& parse) {
    for (std::size_t size = 0; size < bytes.size(); ++size) check_hostile(bytes.substr(0, size), parse);
    for (int n = 0; n < 200; ++n) {
        std::string changed = bytes;
        for (std::size_t k = 1 + random.below(3); k > 0; --k)
            changed[random.below(changed.size())] = char(random.below(256));
        check_hostile(changed, parse);
    }
}

} // namespace

TEST_CASE("PLY files of any layout are read as meshes", "[examples][mesh_formats]") {
    with_random_files(300, [](Random& random) {
        const RandomFile file = random_ply(random);
        const auto mesh = ply_of(file.text());
        if (!mesh) FAIL(to_string(mesh.error()));
        std::vector<Point3> places, normals;
        for (const Vector& vector : file.vectors)
            (vector.kind == Vector::place ? places : normals).push_back(vector.value);
        CHECK(mesh->vertices == places);
        CHECK(mesh->normals == normals);
        CHECK(face_loops(*mesh) == file.faces);
        REQUIRE(mesh->colours.size() == file.colours.size());
        for (std::size_t i = 0; i < file.colours.size(); ++i)
            REQUIRE(length(mesh->colours[i] - file.colours[i]) < 1e-12);
    });
}

TEST_CASE("a posed PLY file has moved vertices and normals, and its other bytes",
          "[examples][mesh_formats]") {
    with_random_files(300, [](Random& random) {
        const RandomFile file = random_ply(random);
        check_writing(file, *ply_of(file.text()), random);
    });
}

TEST_CASE("STL files of both kinds are read with welded corners", "[examples][mesh_formats]") {
    with_random_files(300, [](Random& random) {
        const RandomFile file = random_stl(random);
        const auto mesh = stl_of(file.text());
        if (!mesh) FAIL(to_string(mesh.error()));
        std::vector<Point3> corners, read;
        for (const Vector& vector : file.vectors) {
            if (vector.kind == Vector::place) corners.push_back(vector.value);
        }
        for (const auto& loop : face_loops(*mesh)) {
            REQUIRE(loop.size() == 3);
            for (const std::uint32_t vertex : loop) read.push_back(mesh->vertices[vertex]);
        }
        CHECK(read == corners);
        for (std::size_t i = 0; i < mesh->vertices.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) REQUIRE(mesh->vertices[i] != mesh->vertices[j]);
        }
    });
}

TEST_CASE("a posed STL file has moved corners and normals of facets, and its other bytes",
          "[examples][mesh_formats]") {
    with_random_files(300, [](Random& random) {
        const RandomFile file = random_stl(random);
        check_writing(file, *stl_of(file.text()), random);
    });
}

TEST_CASE("broken PLY and STL files are refused or kept", "[examples][mesh_formats]") {
    with_random_files(40, [](Random& random) {
        check_hostile_changes(random_ply(random).text(), random, ply_of);
        check_hostile_changes(random_stl(random).text(), random, stl_of);
    });
    const auto refused = [](const std::string& text, const std::string& why) {
        const auto file = ply_of(text);
        INFO(text);
        REQUIRE_FALSE(file);
        CHECK(to_string(file.error()).find(why) != std::string::npos);
    };
    const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
    for (const char* const encoding : {"ascii", "binary_little_endian", "binary_big_endian"}) {
        const std::string head = std::string("ply\nformat ") + encoding + " 1.0\n";
        for (const char* const count : {"4294967294", "4294967295", "140737488355328"})
            refused(head + "element vertex " + count + '\n' + xyz + "end_header\n0 0 0\n", "cut off");
        refused(head + "element a 140737488355328\nelement vertex 1\n" + xyz + "end_header\n", "cut off");
        refused(head + "element vertex 0\n" + xyz + "end_header\n", "holds no vertices");
        refused(head + "element vertex 1\nproperty float x\nend_header\n0\n", "has no numbers x, y, z");
    }
    const std::string points = "ply\nformat ascii 1.0\nelement vertex 3\n" + xyz;
    const std::string face =
        "element face 1\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
    refused(points + face + "3 0 1 3\n", "face 0: vertex index 3 is out of range: the file has 3");
    refused(points + face + "3 0 1 -1\n", "face 0: -1 is no index of a vertex");
    refused(points + face + "3 0 1 0.5\n", "face 0: 0.5 is no index of a vertex");
    refused(points + face + "2 0 1\n", "face 0: it has fewer than three corners");
    refused(points + face + "4294967295 0 1\n", "is longer than its line");
    refused(points + "end_header\n0 0 0\n0 nan 0\n0 0 0\n",
            "vertex 1: the coordinates of a vertex are not finite");
    refused(points + "element face 1\nproperty int a\nend_header\n0 0 0\n0 0 0\n0 0 0\n1\n",
            "no list vertex_indices");
    std::string binary(84, '\0');
    for (std::size_t k = 80; k < 84; ++k) binary[k] = '\xff';
    CHECK_FALSE(stl_of(binary));
    CHECK_FALSE(stl_of(binary + std::string(50, '\0')));
    CHECK(to_string(stl_of("solid\n facet normal 0 0 1 outer loop\nvertex 0 0 x").error()) ==
          "in.stl: not a number: \"x\" (line 3)");
}

TEST_CASE("a binary STL file that is cut off tells its triangles and bytes", "[examples][mesh_formats]") {
    for (const std::string title : {"solid ", "solid\n", "", "\xef\xbb\xbfsolid a "}) {
        for (const char fill : {' ', '\0'}) {
            std::string head = title + std::string(80 - title.size(), fill);
            const std::string none = head + std::string(4, '\0');
            CHECK(to_string(stl_of(none).error()) ==
                  "in.stl: holds no triangles: its head declares 0, and it has 84 bytes");
            head += std::string("\3\0\0\0", 4);
            for (const std::size_t triangles : {0U, 49U, 50U, 149U})
                CHECK(to_string(stl_of(head + std::string(triangles, '\n')).error()) ==
                      "in.stl: is no STL file, or cut off: its head declares 3 triangles, which need 234 "
                      "bytes, "
                      "but it has " +
                          std::to_string(84 + triangles));
            CHECK(stl_of(head + std::string(150, '\n')));
        }
    }
    CHECK(to_string(stl_of(std::string("solid a\0\0", 9)).error()) ==
          "in.stl: is cut off: it has 9 bytes, but the head of a binary STL file has 84");
}

TEST_CASE("far from the origin, ASCII STL files keep double precision", "[examples][mesh_formats]") {
    const auto file =
        *stl_of("solid\nfacet normal 0 0 0 outer loop\nvertex 4500000.1 0 0 vertex 4500001.2 1 0 vertex "
                "4500000.3 0 1 endloop endfacet\n");
    std::vector<Point3> places = file.vertices;
    for (Point3& p : places) p[0] += 0.5;
    const std::string text = moved_bytes(file, {places});
    for (const char* const number : {"vertex 4500000.6 0 0", "vertex 4500001.7 1 0", "vertex 4500000.8 0 1"})
        CHECK(text.find(number) != std::string::npos);
}

TEST_CASE("numbers that a type cannot store are refused", "[examples][mesh_formats]") {
    const auto file =
        *ply_of("ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty float y\nproperty "
                "double z\nend_header\n1 2 3\n");
    const auto fault = [&](const MeshFile& mesh, const Point3& place) {
        const auto written = mesh.document->moved(mesh, {std::span(&place, 1)}, "out.ply");
        return written ? std::string() : to_string(written.error());
    };
    CHECK(fault(file, {1, 5, 5}).empty());
    CHECK(fault(file, {1, 1e39, 1e39}) == "in.ply: vertex 0: y exceeds the range of its type after the move");
    CHECK(fault(file, {2, 2, 3}) ==
          "in.ply: vertex 0: x has the type int, which cannot store its moved value");
    const auto binary =
        *ply_of("ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty float x\nproperty float "
                "y\nproperty float z\nend_header\n" +
                std::string(12, '\0'));
    CHECK(fault(binary, {0, 1e39, 0}) == "in.ply: vertex 0: y exceeds the range of its type after the move");
}

TEST_CASE("faces of PLY and STL files are reversed in place", "[examples][mesh_formats]") {
    std::size_t reversed = 0;
    with_random_files(200, [&](Random& random) {
        const bool is_ply = random.below(2) == 0;
        const RandomFile file = is_ply ? random_ply(random) : random_stl(random);
        const auto parse = is_ply ? std::function<Expected<MeshFile>(std::string)>(ply_of) : stl_of;
        const MeshFile mesh = *parse(file.text());
        if (!fault_of_reversing(mesh).empty()) return;
        ++reversed;
        const MeshFile turned = with_faces_reversed(mesh);
        const MeshFile again = *parse(moved_bytes(turned, {turned.vertices}));
        REQUIRE(again.faces.size() == mesh.faces.size());
        for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
            const auto &one = mesh.faces[f].corners, &other = again.faces[f].corners;
            for (std::size_t k = 0; k < one.size(); ++k)
                REQUIRE(again.vertices[other[(one.size() - k) % one.size()].vertex] ==
                        mesh.vertices[one[k].vertex]);
        }
    });
    CHECK(reversed > 50);
}

TEST_CASE("triangle strips are read with alternating sides", "[examples][mesh_formats]") {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float "
        "z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    for (int i = 0; i < 6; ++i) text += std::to_string(i / 2) + ' ' + std::to_string(i % 2) + " 0\n";
    const auto file = *ply_of(text + "9 0 1 2 3 -1 2 3 4 5\n");
    CHECK(face_loops(file) ==
          std::vector<std::vector<std::uint32_t>>{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {4, 3, 5}});
}

TEST_CASE("a PLY file becomes one object in glTF", "[examples][mesh_formats]") {
    with_random_files(100, [](Random& random) {
        const MeshFile mesh = *ply_of(random_ply(random).text());
        const ObjParts parts = read_parts(mesh);
        CHECK(parts.objects == std::vector<std::string>{"in"});
        CHECK(parts.face_materials.size() == mesh.faces.size());
        const auto gltf = gltf_figure(mesh, "test", GltfMotion::keep);
        REQUIRE(bool(gltf) == !mesh.faces.empty());
        if (!gltf) return;
        std::size_t corners = 0;
        const GltfDocument& document = gltf->document;
        for (const GltfJson& primitive : document.json["meshes"][0]["primitives"]) {
            corners += document.count(primitive["indices"].get<GltfIndex>(), "a primitive");
            CHECK(primitive["attributes"].contains("COLOR_0") == !mesh.colours.empty());
        }
        CHECK(corners == 3 * mesh.triangles.size());
    });
}

TEST_CASE("a figure's file is written as itself", "[examples][mesh_formats]") {
    with_random_files(50, [](Random& random) {
        const bool is_ply = random.below(2) == 0;
        const std::string text = (is_ply ? random_ply(random) : random_stl(random)).text();
        const MeshFile mesh = is_ply ? *ply_of(text) : *stl_of(text);
        const std::span<const Point3> rest(mesh.vertices);
        CHECK(*PosedFile(PosedFormat::mesh, 8, mesh).contents(rest) == text);
    });
}

} // namespace mesh_formats_tests

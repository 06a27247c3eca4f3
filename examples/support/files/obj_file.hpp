#pragma once

// Wavefront OBJ files: reading vertices, normals and faces, writing the same file with its vertices moved.
//
// tinyobjloader cuts the faces into triangles. It does not check its input, so this code reads and
// checks everything first and passes on only sound vertices and faces. All other lines are written as
// they were read, to the byte: groups, materials, texture coordinates, comments, colours after a vertex.

#include "files/lattice_file.hpp"
#include "svg/path.hpp"

#include <cageform/core/vec.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

using Point3 = cageform::Vec<double, 3>;

/// The text for --help.
inline constexpr const char* obj_format =
    "OBJ files can have faces of any number of corners, and negative indices. v, vn and\n"
    "f are read, and all other lines are copied as they are. If a pose turns a shared\n"
    "normal differently at its vertices, each vertex gets a normal of its own. glTF files\n"
    "get objects, materials, textures and the colours of vertices (v x y z r g b, from 0\n"
    "to 1, sRGB). Numbers have to be finite, except at vertices that no face has. Curves,\n"
    "binary files and more than 4,294,967,294 vertices are not supported.\n"
    "Messages name vertices as the file counts them: v 1, v 2. Options and lists of\n"
    "faults count from 0.\n"
    "A cage is a closed mesh of any genus, with faces counter-clockwise seen from\n"
    "outside; it can have several shells. A pose is the same mesh with its vertices\n"
    "moved.\n";

struct ObjCorner {
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    std::uint32_t vertex = 0; // counted from zero
    std::uint32_t normal = none;
    friend bool operator==(const ObjCorner&, const ObjCorner&) = default;
};

/// A face of the file, with three corners or more.
struct ObjFace {
    std::vector<ObjCorner> corners;
    std::size_t line = 0;
};

/// A `v` or `vn` statement: where in the text its three numbers stand.
struct ObjNumbers {
    bool is_normal = false;
    std::array<std::size_t, 3> begin{};
    std::array<std::size_t, 3> end{};
};

/// The file as text, and what was found in it.
struct ObjFile {
    std::string name; // for messages
    std::string text;
    std::vector<Point3> vertices;
    std::vector<Point3> colours;       // #vertices, white where one has none; empty where none has
    bool has_bytes_as_colours = false; // whether some colour was above 1, so that all were taken as 0 to 255
    std::vector<std::size_t> left_out; // stray vertices; they stand at the first other vertex
    std::vector<Point3> normals;
    std::vector<ObjNumbers> numbers; // in the order of the file
    std::vector<ObjFace> faces;
    std::vector<std::array<std::uint32_t, 3>> triangles; // of all faces, in their order
    std::vector<std::uint32_t> triangle_faces;           // #triangles: of which face each is a part
    std::vector<std::size_t> folded; // faces whose triangles do not all look one way: not to be had without
    std::optional<LatticeBox<3>> lattice; // its control points are the vertices, then the still handles
    std::vector<std::array<std::uint32_t, 4>> tetrahedra; // of a .mesh file (files/medit_file.hpp)
    std::vector<int> face_parts; // #faces: N of a group part_N, 0 of none; empty where there is no such group
};

/// The choice for vertices that no face has, and that are not finite or far from the others.
enum class StrayVertices { refuse, leave_out };
inline StrayVertices strays_of(bool is_strict) {
    return is_strict ? StrayVertices::refuse : StrayVertices::leave_out;
}

namespace detail {

/// Cuts a text into statements of words. Lines end with \n, \r\n or \r; a backslash at the end of a line
/// joins it with the next. A comment begins with a word's # and ends with its line, backslash or not.
class ObjScanner {
public:
    explicit ObjScanner(std::string_view text)
        : text_(text) {
        if (text_.starts_with("\xef\xbb\xbf")) at_ = 3; // a byte order mark
    }

    /// The words of the next statement that has any, and the line it begins on; false at the end of the
    /// text.
    bool next(std::vector<std::string_view>& words, std::size_t& line) {
        words.clear();
        while (at_ < text_.size() && words.empty()) {
            line = line_;
            read_statement(words);
        }
        return !words.empty();
    }

private:
    /// The length of a line's end at a position, or zero.
    std::size_t line_end(std::size_t at) const {
        if (at >= text_.size()) return 0;
        if (text_[at] == '\r') return at + 1 < text_.size() && text_[at + 1] == '\n' ? 2 : 1;
        return text_[at] == '\n' ? 1 : 0;
    }
    bool is_join(std::size_t at) const { return text_[at] == '\\' && line_end(at + 1) != 0; }

    void read_statement(std::vector<std::string_view>& words) {
        while (at_ < text_.size()) {
            if (const std::size_t end = line_end(at_); end != 0) {
                at_ += end;
                ++line_;
                return;
            }
            if (is_join(at_)) {
                at_ += 1 + line_end(at_ + 1);
                ++line_;
            } else if (text_[at_] == ' ' || text_[at_] == '\t') {
                ++at_;
            } else if (text_[at_] == '#') {
                while (at_ < text_.size() && line_end(at_) == 0) ++at_;
            } else {
                const std::size_t begin = at_;
                while (at_ < text_.size() && text_[at_] != ' ' && text_[at_] != '\t' && line_end(at_) == 0 &&
                       !is_join(at_)) {
                    ++at_;
                }
                words.push_back(text_.substr(begin, at_ - begin));
            }
        }
    }

    std::string_view text_;
    std::size_t at_ = 0;
    std::size_t line_ = 1;
};

/// An index of a face, counted from zero; an empty reason is success.
///
///   word   counts from one, or backwards from -1, the last one read `so_far`
///   count  of all there are in the file
std::string parse_index(std::string_view word, std::size_t so_far, std::size_t count, const char* what,
                        std::uint32_t& index);

/// Reads the three numbers after the first word, and where in the text they stand; an empty reason is
/// success.
std::string parse_three_numbers(std::span<const std::string_view> words, std::string_view text, Point3& point,
                                ObjNumbers& numbers);

/// The format of a text or of bytes that are no OBJ file; empty if none is recognised.
std::string_view other_format(std::string_view text);

/// Twice the area of a face times its normal, of any number of corners.
Point3 area_vector(const ObjFace& face, std::span<const Point3> vertices);

/// Leaves out distant unused vertices too, which would inflate the figure's size. Distant means farther than
/// a million times the diagonal of the used vertices' box. Vertices that are left out move to the first
/// vertex that is kept. Returns why this is impossible; empty if it is possible.
///
///   used  #vertices: whether a face or a cell has the vertex
std::string place_left_out(ObjFile& file, const std::vector<bool>& used, StrayVertices strays);

inline constexpr const char* vertex_not_finite = "the coordinates of a vertex are not finite";

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

} // namespace detail

/// The vertices of each face.
std::vector<std::vector<std::uint32_t>> face_loops(const ObjFile& file);

/// The name of the group of faces of a part of a cage.
inline std::string part_group(int number) {
    return "part_" + std::to_string(number);
}

/// A file from its text.
///
///   name    stands before every message
///   fails   where there is no vertex, a coordinate is no finite number (a normal need only be numbers), or a
///           face has less than three corners or an index that there is not
Expected<ObjFile> parse_obj(std::string text, std::string name, StrayVertices strays = StrayVertices::refuse);

/// Works as parse_obj(), from a file; fails also where it cannot be read.
Expected<ObjFile> load_obj(const std::filesystem::path& path, StrayVertices strays = StrayVertices::refuse);

/// The first vertex that is beyond single precision, with its line and number; nothing where there is none.
std::optional<FileError> single_precision_fault(const ObjFile& file);

/// Returns the sign of the determinant of the affine map that is nearest to the motion of the vertices: -1 if
/// a pose mirrors a figure, 0 if the figure or the pose is flat, else 1.
int side_of(std::span<const Point3> rest, std::span<const Point3> moved);
inline bool is_mirrored(std::span<const Point3> rest, std::span<const Point3> moved) {
    return side_of(rest, moved) < 0;
}

/// The places of the vertices that faces have, or of all where there is no face. Stray vertices say nothing
/// about the size of a figure.
std::vector<Point3> shown_places(std::span<const Point3> places,
                                 std::span<const std::array<std::uint32_t, 3>> triangles);

/// The diagonal of the bounds of shown_places().
double size_of(const ObjFile& figure);

/// The place that files in single precision count positions from. If the figure is far from the origin, it is
/// the middle of the bounds of shown_places(), rounded to single precision; else the origin. So the rounding
/// of positions is below 1e-6 of the figure's size.
Point3 far_origin(const ObjFile& figure);

/// Why single precision does not hold places far from the origin: it rounds them by more than 1e-6 of their
/// size. Empty where it does.
std::string rounding_fault(const std::string& name, std::span<const Point3> places);

/// Places counted from another.
std::vector<Point3> counted_from(const Point3& origin, std::span<const Point3> places);

/// The Jacobian of a deformation at a vertex: the images of the three axes.
using Jacobian3 = std::array<Point3, 3>;

/// A deformation of a file's vertices.
struct MovedVertices {
    std::span<const Point3> places;         ///< #vertices
    std::span<const Jacobian3> jacobians{}; ///< #vertices, or none: they are not known
};

/// The file's text with its vertices and normals moved. A number that has not changed keeps its digits; a new
/// one has the fewest that give it back. If the Jacobians turn a shared normal
/// differently at its vertices, each vertex gets a normal of its own.
std::string to_text(const ObjFile& file, const MovedVertices& moved);
inline std::string to_text(const ObjFile& file, std::span<const Point3> places) {
    return to_text(file, MovedVertices{places});
}

/// Names and counts what a file has besides the statements of some keywords: "800 of "vt", 2 of "usemtl",
/// 8066 colours"; empty if it has nothing else.
std::string describe_others(const ObjFile& file, std::initializer_list<std::string_view> keywords);

/// The file with the corners of each face in the opposite order, in its text too.
ObjFile with_faces_turned_over(ObjFile file);

} // namespace cageform_support

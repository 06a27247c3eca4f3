#pragma once

// Wavefront OBJ files: reading vertices, normals and faces, writing the file with moved vertices.
//
// tinyobjloader triangulates the faces. It does not check its input, so this code parses and checks
// everything first, and passes only valid vertices and faces. All other lines are copied byte by byte:
// groups, materials, texture coordinates, comments, colours after a vertex.

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

/// Help text on OBJ files.
inline constexpr const char* obj_format =
    "OBJ files can have faces of any number of corners, and negative indices. v, vn and\n"
    "f are read, and all other lines are copied as they are. If a pose turns a shared\n"
    "normal differently at its vertices, each vertex gets a normal of its own. glTF files\n"
    "get objects, materials, textures and the colours of vertices (v x y z r g b, from 0\n"
    "to 1, sRGB). Numbers have to be finite, except at vertices that no face uses. Curves,\n"
    "binary files and more than 4,294,967,294 vertices are not supported.\n"
    "Messages name vertices as the file counts them: v 1, v 2. Options and lists of\n"
    "faults count from 0.\n"
    "A cage is a closed mesh of any genus, with faces counter-clockwise seen from\n"
    "outside; it can have several shells. A pose is the same mesh with its vertices\n"
    "moved.\n";

struct ObjCorner {
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    std::uint32_t vertex = 0; // from 0
    std::uint32_t normal = none;
    friend bool operator==(const ObjCorner&, const ObjCorner&) = default;
};

/// A face with three or more corners.
struct ObjFace {
    std::vector<ObjCorner> corners;
    std::size_t line = 0;
};

/// The positions of the three numbers of a `v` or `vn` statement in the text.
struct ObjNumbers {
    bool is_normal = false;
    std::array<std::size_t, 3> begin{};
    std::array<std::size_t, 3> end{};
};

/// The text of a file and its parsed contents.
struct ObjFile {
    std::string name; // for messages
    std::string text;
    std::vector<Point3> vertices;
    std::vector<Point3> colours;       // #vertices, white by default; empty if no vertex has a colour
    bool has_bytes_as_colours = false; // whether a colour was above 1, so that the range is 0 to 255
    std::vector<std::size_t> left_out; // stray vertices, moved to the first other vertex
    std::vector<Point3> normals;
    std::vector<ObjNumbers> numbers; // in file order
    std::vector<ObjFace> faces;
    std::vector<std::array<std::uint32_t, 3>> triangles; // of all faces, in file order
    std::vector<std::uint32_t> triangle_faces;           // #triangles: index of the face
    std::vector<std::size_t> folded;      // faces without a triangulation of consistent orientation
    std::optional<LatticeBox<3>> lattice; // vertices: control points, then frame handles
    std::vector<std::array<std::uint32_t, 4>> tetrahedra; // of a .mesh file (files/medit_file.hpp)
    std::vector<int> face_parts; // #faces: N of the group part_N, else 0; empty if there is no such group
};

/// Handling of unused vertices that are not finite or far away.
enum class StrayVertices : std::uint8_t { refuse, leave_out };
inline StrayVertices strays_of(bool is_strict) {
    return is_strict ? StrayVertices::refuse : StrayVertices::leave_out;
}

namespace detail {

/// Splits a text into statements of words. Lines end with \n, \r\n or \r; a backslash at the end of a line
/// joins it with the next. A comment begins with # at the start of a word and ends with its line, even after
/// a backslash.
class ObjScanner {
public:
    explicit ObjScanner(std::string_view text)
        : text_(text) {
        if (text_.starts_with("\xef\xbb\xbf")) at_ = 3; // a byte order mark
    }

    /// The next nonempty statement and its first line; false at the end of the text.
    bool next(std::vector<std::string_view>& words, std::size_t& line) {
        words.clear();
        while (at_ < text_.size() && words.empty()) {
            line = line_;
            read_statement(words);
        }
        return !words.empty();
    }

private:
    /// The length of the line break at a position, or 0.
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

/// Parses an index of a face. Returns the error; empty on success.
///
///   word     from 1, or negative: -1 is the last element before this line
///   so_far   number of elements before this line
///   count    number of elements in the file
///   index    out: from 0
std::string parse_index(std::string_view word, std::size_t so_far, std::size_t count, const char* what,
                        std::uint32_t& index);

/// Parses the three numbers after the first word, with their positions in the text. Returns the error; empty
/// on success.
std::string parse_three_numbers(std::span<const std::string_view> words, std::string_view text, Point3& point,
                                ObjNumbers& numbers);

/// The format of a file that is not OBJ, by its first bytes; empty if unknown.
std::string_view other_format(std::string_view text);

/// Twice the area of a face times its normal.
Point3 area_vector(const ObjFace& face, std::span<const Point3> vertices);

/// Leaves out unused vertices that would inflate the figure's size: those that are not finite, or farther
/// from the box of the used vertices than a million times its diagonal. They are moved to the first other
/// vertex. Returns the error if no vertex remains; else empty.
///
///   used   #vertices: whether a face or a cell uses the vertex
std::string place_left_out(ObjFile& file, const std::vector<bool>& used, StrayVertices strays);

inline constexpr const char* vertex_not_finite = "the coordinates of a vertex are not finite";

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

} // namespace detail

/// The vertices of each face.
std::vector<std::vector<std::uint32_t>> face_loops(const ObjFile& file);

/// Name of the face group of a part of a cage.
inline std::string part_group(int number) {
    return "part_" + std::to_string(number);
}

/// Parses an OBJ file.
///
///   name    prefix of every message
///   fails   if there are no vertices, on coordinates that are not finite (normals may be), and on faces with
///           fewer than three corners or an invalid index
Expected<ObjFile> parse_obj(std::string text, std::string name, StrayVertices strays = StrayVertices::refuse);

/// As parse_obj(), from a file; fails also if it cannot be read.
Expected<ObjFile> load_obj(const std::filesystem::path& path, StrayVertices strays = StrayVertices::refuse);

/// The first vertex out of the range of single precision, with its line; nothing if there is none.
std::optional<FileError> single_precision_fault(const ObjFile& file);

/// The sign of the determinant of the affine map nearest to a motion: -1 if a pose mirrors a figure, 0 if one
/// of them is flat, else 1.
int side_of(std::span<const Point3> rest, std::span<const Point3> moved);
inline bool is_mirrored(std::span<const Point3> rest, std::span<const Point3> moved) {
    return side_of(rest, moved) < 0;
}

/// The positions of the vertices of all triangles, or of all vertices if there are none. Unused vertices do
/// not affect the size of a figure.
std::vector<Point3> used_positions(std::span<const Point3> places,
                                   std::span<const std::array<std::uint32_t, 3>> triangles);

/// The diagonal of the bounds of used_positions().
double size_of(const ObjFile& figure);

/// Origin for positions in single precision. If the figure is far from the origin, the middle of the bounds
/// of used_positions(), rounded to single precision; else the origin. Rounding errors of positions are then
/// below 1e-6 of the figure's size.
Point3 far_origin(const ObjFile& figure);

/// Returns the error if single precision rounds positions by more than 1e-6 of their size; else empty.
std::string rounding_fault(const std::string& name, std::span<const Point3> places);

/// Positions relative to an origin.
std::vector<Point3> relative_to(const Point3& origin, std::span<const Point3> places);

/// The Jacobian of a deformation at a vertex: images of the three axes.
using Jacobian3 = std::array<Point3, 3>;

/// A deformation of a file's vertices.
struct MovedVertices {
    std::span<const Point3> places;         ///< #vertices
    std::span<const Jacobian3> jacobians{}; ///< #vertices, or empty if unknown
};

/// The file's text with moved vertices and normals. Unchanged numbers keep their digits; others have the
/// fewest digits that restore them. If the Jacobians rotate a shared normal differently at its vertices, each
/// vertex gets its own normal.
std::string to_text(const ObjFile& file, const MovedVertices& moved);
inline std::string to_text(const ObjFile& file, std::span<const Point3> places) {
    return to_text(file, MovedVertices{places});
}

/// Counts statements other than `keywords`: "800 of "vt", 2 of "usemtl", 8066 colours"; empty if there are
/// none.
std::string describe_others(const ObjFile& file, std::initializer_list<std::string_view> keywords);

/// Reverses the corners of each face, also in the text.
ObjFile with_faces_reversed(ObjFile file);

} // namespace cageform_support

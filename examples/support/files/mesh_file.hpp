#pragma once

// Figures, cages and poses in space, from files of any format.

#include "files/lattice_file.hpp"
#include "io/atomic_file.hpp"
#include "io/expected.hpp"

#include <cageform/core/vec.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

using Point3 = cageform::Vec<double, 3>;

/// A number rounded to single precision. `volatile`: GCC 12 with -O2 omits this rounding for pairs of
/// numbers.
inline double rounded_to_single(double x) {
    const volatile float rounded = float(x);
    return double(rounded);
}
inline Point3 rounded_to_single(const Point3& p) {
    return {rounded_to_single(p[0]), rounded_to_single(p[1]), rounded_to_single(p[2])};
}

/// Help text on meshes.
inline constexpr const char* mesh_formats =
    "Meshes are glTF, OBJ, PLY or STL files with faces of any number of corners, or Medit\n"
    ".mesh files. The contents of a file decide its format. The output is the input with\n"
    "moved points and normals; nothing else changes.\n"
    "glTF: the triangles, lines and points of the default scene, in world space. Nodes,\n"
    "materials, images, extensions and animations stay. A mesh that two nodes use is\n"
    "divided only if its copies differ in the pose. Skins are kept: joints move with the\n"
    "cage, and animations play; --drop-skin writes the pose without skins. Morph targets\n"
    "move by the Jacobian of the deformation. Moved numbers are written as floats, even if\n"
    "the input has quantised or sparse numbers. Draco and meshopt data are written\n"
    "uncompressed. Images are copied into the output's folder.\n"
    "OBJ: if a pose turns a shared normal differently at its vertices, each vertex gets a\n"
    "copy of the normal. glTF files get objects, materials, textures and the colours of\n"
    "vertices (v x y z r g b, from 0 to 1, sRGB).\n"
    "PLY: binary or ASCII; moved numbers keep their types. A file without faces is a cloud\n"
    "of points. STL: binary or ASCII; equal corners are one vertex, numbered in the order of\n"
    "the file, and normals are those of the moved triangles.\n"
    "Numbers have to be finite. In OBJ, PLY and Medit files, vertices that no face uses may\n"
    "have other numbers. Files have at most 2 GB; bind_tiles reads points of any size.\n"
    "In messages, v 1 is the first vertex of the file. Options, lists of faults and elements\n"
    "such as \"vertex 0\" count from 0.\n"
    "A cage is a closed mesh of any genus, with faces counter-clockwise seen from\n"
    "outside; it can have several shells. A pose is the same mesh with its vertices\n"
    "moved. In a cage that is no OBJ file, vertices at one place become one; it is numbered\n"
    "in the order of the file, and its poses are written as OBJ.\n";

struct MeshCorner {
    static constexpr std::uint32_t none = ~std::uint32_t{0};

    std::uint32_t vertex = 0; // from 0
    std::uint32_t normal = none;
    friend bool operator==(const MeshCorner&, const MeshCorner&) = default;
};

/// A face with three or more corners.
struct MeshFace {
    std::vector<MeshCorner> corners;
    std::size_t line = 0;
};

/// The positions of the three numbers of a `v` or `vn` statement in the text.
struct ObjNumbers {
    bool is_normal = false;
    std::array<std::size_t, 3> begin{};
    std::array<std::size_t, 3> end{};
};

/// The vertices of a cage that were welded from those of its file.
struct WeldedVertices {
    std::vector<std::uint32_t> of_vertices; // #vertices of the file: vertex of the cage
    std::vector<std::uint32_t> of_corners;  // likewise for all corners of faces, in the order of the file
};

struct MeshFile;
struct MovedVertices;

struct WrittenFile {
    std::filesystem::path path;
    std::string bytes;
};

/// The files of an output: the file with moved vertices, then those that it refers to.
struct MovedFile {
    std::vector<WrittenFile> files;
    std::vector<std::string> notes; // for the user, such as errors of morph targets
};

/// The contents of a glTF, PLY or STL file, which writes them with moved vertices.
class MeshDocument {
public:
    MeshDocument() = default;
    MeshDocument& operator=(const MeshDocument&) = delete;
    virtual ~MeshDocument() = default;

    /// Extensions of its files, in lower case; the first is the usual one.
    virtual std::vector<std::string> extensions() const = 0;
    /// The file with moved vertices and normals, and files that it refers to. Everything else is unchanged.
    ///
    ///   mesh    the mesh of this document
    ///   path    of the output; its extension is one of the format
    virtual Expected<MovedFile> moved(const MeshFile& mesh, const MovedVertices& moved,
                                      const std::filesystem::path& path) const = 0;
    /// The document with the corners of each face reversed; null if the format does not support it.
    virtual std::shared_ptr<const MeshDocument> with_faces_reversed() const { return nullptr; }
    /// Counts what an OBJ file of vertices, normals, colours and faces would not keep; empty if it keeps all.
    virtual std::string others() const { return {}; }

protected:
    MeshDocument(const MeshDocument&) = default;
};

/// A mesh in world space, and the contents of its file.
struct MeshFile {
    std::string name;                             // for messages
    std::string text;                             // of an OBJ or .mesh file
    std::shared_ptr<const MeshDocument> document; // of any other file; null if there is none
    std::vector<Point3> vertices;
    std::vector<Point3> colours;       // #vertices, white by default; empty if no vertex has a colour
    bool has_bytes_as_colours = false; // whether a colour was above 1, so that the range is 0 to 255
    std::vector<std::size_t> left_out; // stray vertices, moved to the first other vertex
    std::vector<Point3> normals;
    std::vector<Point3> guides;      // points that only the writer of the document needs, such as joints
    std::vector<ObjNumbers> numbers; // in file order
    std::vector<MeshFace> faces;
    std::vector<std::array<std::uint32_t, 3>> triangles; // of all faces, in file order
    std::vector<std::uint32_t> triangle_faces;           // #triangles: index of the face
    std::vector<std::size_t> folded;      // faces without a triangulation of consistent orientation
    std::optional<LatticeBox<3>> lattice; // vertices: control points, then frame handles
    std::vector<std::array<std::uint32_t, 4>> tetrahedra; // of a .mesh file (files/medit_file.hpp)
    std::optional<WeldedVertices> welded;                 // of a cage whose file is not OBJ
    std::vector<int> face_parts; // #faces: N of the group part_N, else 0; empty if there is no such group
};

/// Handling of unused vertices that are not finite or far away.
enum class StrayVertices : std::uint8_t { refuse, leave_out };
inline StrayVertices strays_of(bool is_strict) {
    return is_strict ? StrayVertices::refuse : StrayVertices::leave_out;
}

namespace detail {

/// Twice the area of a face times its normal.
Point3 area_vector(const MeshFace& face, std::span<const Point3> vertices);

/// Leaves out unused vertices that would inflate the figure's size: those that are not finite, or farther
/// from the box of the used vertices than a million times its diagonal. They are moved to the first other
/// vertex. Returns the error if no vertex remains; else empty.
///
///   used   #vertices: whether a face or a cell uses the vertex
std::string place_left_out(MeshFile& file, const std::vector<bool>& used, StrayVertices strays);

inline constexpr const char* vertex_not_finite = "the coordinates of a vertex are not finite";

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// Sets the triangles of the faces, by tinyobjloader. The faces must be valid, since tinyobjloader does not
/// check them. Returns the error; empty on success.
std::string triangulate(MeshFile& file);

/// The format of a file that is not OBJ, by its first bytes; empty if unknown.
std::string_view other_format(std::string_view text);

} // namespace detail

/// The vertices of each face.
std::vector<std::vector<std::uint32_t>> face_loops(const MeshFile& file);

/// Name of the face group of a part of a cage.
inline std::string part_group(int number) {
    return "part_" + std::to_string(number);
}

/// The extensions of files that load_mesh() reads and save_mesh() writes.
inline const std::vector<std::string> mesh_extensions{".obj", ".mesh", ".glb", ".gltf", ".ply", ".stl"};

/// Whether the extension of a file is that of a mesh in space.
inline bool is_mesh_path(const std::filesystem::path& path) {
    const std::string extension = lowercase_extension(path);
    return std::find(mesh_extensions.begin(), mesh_extensions.end(), extension) != mesh_extensions.end();
}

/// Reads a file; its contents decide the format.
///
///   fails   if the file cannot be read, or as the parser of its format
Expected<MeshFile> load_mesh(const std::filesystem::path& path, StrayVertices strays = StrayVertices::refuse);

/// The extensions of the mesh's format, such as ".ply"; the first is the usual one.
std::vector<std::string> extensions_of(const MeshFile& mesh);

/// The error if the extension of an output is not one of the mesh's format; else empty.
///
///   option  that names the output
std::string fault_of_extension(const MeshFile& mesh, const std::string& out,
                               const std::string& option = "-o");

/// The error if with_faces_reversed() does not support the mesh's format; else empty.
std::string fault_of_reversing(const MeshFile& mesh);

/// The error if a mesh is not a figure with its vertices moved: another number of vertices, or equally many
/// faces and one with other vertices. Else empty.
std::string fault_of_frame(const MeshFile& figure, const MeshFile& frame);

/// Writes the mesh's file with moved vertices and normals. Returns notes for the user; fails if the format
/// cannot store the result.
Expected<std::vector<std::string>> save_mesh(const MeshFile& mesh, const MovedVertices& moved,
                                             const std::string& out, OutputFiles& outputs);

/// The first vertex out of the range of single precision, with its line; nothing if there is none.
std::optional<FileError> single_precision_fault(const MeshFile& file);

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
double size_of(const MeshFile& figure);

/// Origin for positions in single precision. If the figure is far from the origin, the middle of the bounds
/// of used_positions(), rounded to single precision; else the origin. Rounding errors of positions are then
/// below 1e-6 of the figure's size.
Point3 far_origin(const MeshFile& figure);

/// Returns the error if single precision rounds positions by more than 1e-6 of their size; else empty.
std::string rounding_fault(const std::string& name, std::span<const Point3> places);

/// Positions relative to an origin.
std::vector<Point3> relative_to(const Point3& origin, std::span<const Point3> places);

/// Vertex positions for computing weights. Files split vertices where normals or texture coordinates differ,
/// and some files round the copies differently. A vertex near an earlier position gets that position. Near:
/// within 1e-6 of the figure's size, and within 1 % of the 5th percentile of edge lengths.
std::vector<Point3> joined_places(const MeshFile& figure);

/// The Jacobian of a deformation at a vertex: images of the three axes.
using Jacobian3 = std::array<Point3, 3>;

/// A deformation of a file's vertices.
struct MovedVertices {
    std::span<const Point3> places;         ///< #vertices
    std::span<const Jacobian3> jacobians{}; ///< #vertices, or empty if unknown
    std::span<const Point3> guides{};       ///< #guides, or empty if unknown
    bool drops_skins = false;               ///< whether skinned meshes are written without their skins
};

/// Counts statements other than `keywords`: "800 of "vt", 2 of "usemtl", 8066 colours"; empty if there are
/// none.
std::string describe_others(const MeshFile& file, std::initializer_list<std::string_view> keywords);

/// Reverses the corners of each face, also in the file's contents.
MeshFile with_faces_reversed(MeshFile file);

} // namespace cageform_support

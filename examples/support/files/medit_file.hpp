#pragma once

// Medit's .mesh files: meshes of tetrahedra, as mesh generators and simulations exchange them. Reading a
// mesh, and (to_text() of files/obj_file.hpp) writing the same file with its vertices moved.

#include "files/obj_file.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// The text for --help.
inline constexpr const char* medit_format =
    "A .mesh file is Medit's text format: MeshVersionFormatted, Dimension 3, Vertices\n"
    "with three coordinates and a reference each, Tetrahedra with four indices and a\n"
    "reference each. Triangles and Quadrilaterals are drawn where there are no\n"
    "tetrahedra. Everything else is copied as it is; # begins a comment.\n";

/// Reads a mesh from the text of a .mesh file.
///
///   name      stands before every message
///   returns   its text, vertices and tetrahedra. Its triangles are the faces of one tetrahedron alone,
///             from outside, or where there are no tetrahedra those of the file; it has no faces, as only OBJ
///             files have them
///   fails     where a section is missing, ends too soon or is there twice, where a coordinate is no finite
///             number or an index there is not, and in two dimensions; with the line
Expected<ObjFile> parse_medit(std::string text, std::string name,
                              StrayVertices strays = StrayVertices::refuse);

/// Reads a figure from a .mesh file or, by any other name, from an OBJ file.
Expected<ObjFile> load_mesh_or_obj(const std::filesystem::path& path, StrayVertices strays);

/// Returns the faces that one cell alone has, counter-clockwise seen from outside.
detail::Triangles surface_of(std::span<const Point3> vertices,
                             std::span<const std::array<std::uint32_t, 4>> tetrahedra);

/// Writes a .mesh file of tetrahedra.
std::string medit_text(std::span<const Point3> vertices,
                       std::span<const std::array<std::uint32_t, 4>> tetrahedra);

} // namespace cageform_support

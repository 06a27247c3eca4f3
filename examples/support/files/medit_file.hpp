#pragma once

// Medit .mesh files: tetrahedral meshes, as exchanged by mesh generators and simulations. Moved meshes are
// written by to_text() (files/obj_file.hpp).

#include "files/obj_file.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace cageform_support {

/// Help text on .mesh files.
inline constexpr const char* medit_format =
    "A .mesh file is Medit's text format: MeshVersionFormatted, Dimension 3, Vertices\n"
    "with three coordinates and a reference each, Tetrahedra with four indices and a\n"
    "reference each. Triangles and Quadrilaterals are used only in files without\n"
    "tetrahedra. Everything else is copied as it is; # begins a comment.\n";

/// The first word of a .mesh file.
inline constexpr const char* medit_keyword = "MeshVersionFormatted";

/// Parses a .mesh file.
///
///   name      prefix of every message
///   returns   text, vertices and tetrahedra. The triangles are the boundary faces of the tetrahedra,
///             oriented outwards, or without tetrahedra the faces of the file. `faces` is empty
///   fails     if a section is missing, incomplete or duplicate, a coordinate is not finite, an index is
///             invalid, or the dimension is not 3; the error has the line
Expected<MeshFile> parse_medit(std::string text, std::string name,
                               StrayVertices strays = StrayVertices::refuse);

/// The faces that belong to exactly one tetrahedron, counter-clockwise seen from outside.
detail::Triangles surface_of(std::span<const Point3> vertices,
                             std::span<const std::array<std::uint32_t, 4>> tetrahedra);

/// The text of a .mesh file of tetrahedra.
std::string medit_text(std::span<const Point3> vertices,
                       std::span<const std::array<std::uint32_t, 4>> tetrahedra);

} // namespace cageform_support

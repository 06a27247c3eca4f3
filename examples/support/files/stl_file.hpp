#pragma once

// STL files as meshes: triangles whose equal corners are one vertex; the same file with moved corners out.
//
// Everything else is copied byte by byte: the head of binary files, attributes, names of solids, blanks.

#include "files/mesh_file.hpp"

#include <string>
#include <string_view>

namespace cageform_support {

/// Whether bytes have control characters other than blanks, which text does not have.
bool has_control_characters(std::string_view bytes);

/// Whether a file is binary STL: it declares triangles and has bytes for all. Others may follow.
bool is_binary_stl(std::string_view bytes);

/// Parses an STL file, binary (little-endian) or ASCII. A binary file may begin with "solid", and an ASCII
/// file with a byte order mark.
///
///   name      prefix of every message
///   returns   vertices in the order of their first corners, a face for each triangle (also without area),
///             and the document. The mesh has no normals, since an STL file has normals of faces. The
///             document writes the normals of moved triangles, and keeps normals of zero.
///   fails     if there are no triangles, the file is cut off, a coordinate is not finite, or a facet of an
///             ASCII file does not have three corners; the error has the line
Expected<MeshFile> parse_stl(std::string bytes, std::string name);

} // namespace cageform_support

#pragma once

// PLY files as meshes: points, normals, colours and faces in; the same file with moved points out.
//
// Everything else is copied byte by byte: comments, other properties, other elements.

#include "files/mesh_file.hpp"

#include <string>

namespace cageform_support {

/// Parses a PLY file in any encoding: ASCII, or binary of both byte orders.
///
///   name      prefix of every message
///   returns   vertices (x y z), normals (nx ny nz; vertex i has normal i), colours (red green blue;
///             integers are scaled to [0, 1]), faces (lists vertex_indices or vertex_index, then triangle
///             strips) and the document. `faces` is empty for a point cloud
///   fails     if the header is invalid, the file is cut off in vertices or faces, there are no vertices, a
///             coordinate is not finite, a face has fewer than three corners, or an index is invalid
Expected<MeshFile> parse_ply(std::string bytes, std::string name,
                             StrayVertices strays = StrayVertices::refuse);

} // namespace cageform_support

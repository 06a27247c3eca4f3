// Declares the function behind `find_parts`.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/enclose/types/cage_parts.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Finds the parts of a sound cage; defined in enclose/space/part_finder.hpp.
template <class T>
CageParts parts_of_cage(std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces);

} // namespace cageform::inline CAGEFORM_ABI::detail

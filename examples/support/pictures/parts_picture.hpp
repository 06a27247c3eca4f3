#pragma once

// Pictures of cages in space with their parts in colours and their numbers.

#include "pictures/mesh_picture.hpp"

namespace cageform_support {

/// A figure in its cage, and beside it the cage alone: each part in a colour of its own, with its number.
/// Images of each other have one colour, the one with the minus darker. A lattice is of clay.
Picture draw_cage_parts(const ObjFile& figure, const ObjFile& cage, std::size_t width, std::size_t height,
                        const MeshSight& sight);

} // namespace cageform_support

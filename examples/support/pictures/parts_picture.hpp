#pragma once

// Pictures of cages in space with coloured and numbered parts.

#include "pictures/mesh_picture.hpp"

namespace cageform_support {

/// Draws a figure in its cage, and beside it the cage with a colour and a number per part. Mirror images have
/// the same colour, darker for negative numbers. A lattice has the colour of clay.
Picture draw_cage_parts(const ObjFile& figure, const ObjFile& cage, std::size_t width, std::size_t height,
                        const ViewAngles& sight);

} // namespace cageform_support

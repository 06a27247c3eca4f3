#pragma once

// Pictures of cages in space with numbered parts or vertices.

#include "pictures/mesh_picture.hpp"

namespace cageform_support {

/// Draws a figure in its cage, and beside it the cage with a colour and a number per part. Mirror images have
/// the same colour, darker for negative numbers. A lattice has the colour of clay.
Picture draw_cage_parts(const MeshFile& figure, const MeshFile& cage, std::size_t width, std::size_t height,
                        const ViewAngles& sight);

/// Draws a cage in space from the front and the back: faces, edges at rest in grey, and numbers of the
/// vertices of visible faces.
Picture draw_pose(const MeshFile& cage, const std::vector<Point3>& pose);

} // namespace cageform_support

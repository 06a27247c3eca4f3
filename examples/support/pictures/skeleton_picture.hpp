#pragma once

// Pictures of a skeleton that was fitted to a motion.

#include "cli/skeleton_choice.hpp"
#include "pictures/mesh_picture.hpp"

namespace cageform_support {

/// Five frames at most: above as they are given, in the middle as they are played, coloured by their
/// distances from those above, below the bones in them. The bar counts in shares of the figure's size.
Picture draw_skeleton(const FigureFrames& frames, const FittedMotion& motion, const MeshSight& sight);

} // namespace cageform_support

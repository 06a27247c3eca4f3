#pragma once

// Pictures of fitted skeletons.

#include "cli/skeleton_choice.hpp"
#include "pictures/mesh_picture.hpp"

namespace cageform_support {

/// Draws up to five frames: the input (top), the skinned figure coloured by its distance from the input
/// (middle), and the bones (bottom). The colour bar is relative to the figure's size.
Picture draw_skeleton(const FigureFrames& frames, const FittedMotion& motion, const ViewAngles& sight);

} // namespace cageform_support

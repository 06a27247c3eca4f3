#pragma once

// Pictures of the hand: its layers, its control points, its poses and builds, and how its skin follows.

#include "bound_hand.hpp"
#include "hand_builds.hpp"
#include "io/atomic_file.hpp"

#include <filesystem>

namespace cageform_sources {

using namespace cageform_support;

/// Adds the pictures to the outputs:
///
///   hand_layers.png     bones, control points and skin, at rest and posed
///   hand_points.png     control points by kind, and lines of the skin
///   hand_poses.png      hand_poses() from both sides
///   hand_bend.png       a finger bent by 90 degrees in four ways, and its volume
///   hand_inflation.png  without inflation and with it
///   hand_builds.png     other hands of the same binding
///   hand_influence.png  how the skin follows two control points
///   hand_locality.png   motion of the fingers next to a bent finger: by control points, and by
///                       harmonic coordinates in a cage
void draw_hand(const BoundHand& bound, const HandBuilder& builder, const std::filesystem::path& folder,
               OutputFiles& outputs);

} // namespace cageform_sources

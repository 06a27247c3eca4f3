#pragma once

// The motions of the puppet: a walk and a greeting.

#include "character/puppet.hpp"
#include "character/rotation.hpp"

namespace cageform_programs {

/// A pose of the puppet's bones and morph targets.
struct PuppetPose {
    std::vector<Rotation> turns; ///< #bones, relative to the parent; axes as at rest
    Point3 shift{};              ///< of the hips
    double smile = 0, surprise = 0, breath = 0;
};

inline constexpr double walk_length = 1.25, greeting_length = 3; // seconds

/// Speed of the ground in the walk, in m/s. A foot is on the ground for `walk_contact` of the cycle, and
/// moves by 2 · `walk_reach`.
inline constexpr double walk_contact = 0.6, walk_reach = 0.26;
inline constexpr double walk_speed = 2 * walk_reach / (walk_contact * walk_length);

/// A walk in place, on a ground that moves backwards at a constant speed. Each foot is at rest relative to
/// this ground from heel strike to toe-off.
///
///   part   of the cycle, in [0, 1]; the poses at 0 and 1 are equal
PuppetPose walk_pose(const std::vector<PuppetBone>& bones, double part);

/// The puppet stands, breathes, smiles, and waves its right hand.
///
///   part   of the motion, in [0, 1]; the poses at 0 and 1 are equal
PuppetPose greeting_pose(const std::vector<PuppetBone>& bones, double part);

} // namespace cageform_programs

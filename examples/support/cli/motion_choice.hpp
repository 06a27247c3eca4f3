#pragma once

// Options of the motion of a cage in space.

#include "cli/pose_choice.hpp"
#include "files/clip_file.hpp"
#include "files/mesh_file.hpp"

#include <string>
#include <vector>

namespace cageform_support {

/// The motion of a cage in space: a clip, or from rest through poses or operations and back (--clip, --pose,
/// --seconds and operations).
struct MotionChoice {
    std::string clip;
    std::vector<std::string> poses;
    PoseChoice operations;
    double seconds = 1;

    void add_options(CommandLine& line);
    /// Sorts `poses` by number (order_by_numbers()), with notes. Call after parsing.
    void order_poses();

    bool is_given() const { return !clip.empty() || !poses.empty() || !operations.operations.empty(); }
    /// The motion; without keys if none is given. Vertices that no pose moves are reset to rest. Fails if a
    /// file cannot be read or does not match, an operation is invalid, or numbers exceed single precision.
    /// Fails also if more than one kind of motion is given.
    PoseClip motion(const MeshFile& cage) const;
};

} // namespace cageform_support

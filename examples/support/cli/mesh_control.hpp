#pragma once

// The control of a figure in space, shared by programs: coordinates of a cage, a lattice or points, and a
// pose from a file, operations or pins.

#include "cli/coordinates.hpp"
#include "cli/pinned_cage.hpp"
#include "cli/pose_choice.hpp"
#include "files/mesh_file.hpp"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// Coordinates, and the pose of their handles.
struct MeshControl {
    ChosenCoordinates<double, 3> coordinates;
    MeshFile cage, pose;         // for sites, only vertices
    std::vector<double> weights; // of sites, or empty
    std::function<std::string(const cageform::BindReport&)> describe_faults;
    std::vector<Point3> handles = {}; // pose of all handles if pins pose vectors of faces; else empty
    std::string on_pins = {};         // text of --report on pins
    std::size_t saved = 0;            // number of vertices in --save-pose: without the corners of --surround

    std::string saved_pose() const; ///< contents of a file for --pose
};

/// The options --cage, --pose, --save-pose, pose operations and pins, and the options of its members.
struct MeshControlChoice {
    std::string cage, pose, save_pose;
    OutsideChoice outside;
    CoordinatesChoice choice;
    SiteChoice of_sites;
    PoseChoice operations;
    PinChoice pins;

    /// Adds all options except those of `outside`, `choice` and `of_sites`, which it configures.
    void add_options(CommandLine& line);
    bool has_pose() const { return !pose.empty() || !operations.operations.empty(); }
    std::string fault() const; ///< error if options contradict each other; else empty
    /// Error if --save-pose cannot write the pose; else empty.
    std::string save_fault(const MeshControl& control) const;
};

/// Reads or makes the control of the options.
///
///   figure   mesh that a generated cage encloses
///   places   points of the figure, for pins by vertex number and for --surround
///   fails    if a file cannot be read or does not match, no cage can be made, or pins cannot be solved
MeshControl read_mesh_control(const MeshControlChoice& given, const MeshFile& figure,
                              std::span<const Point3> places);

} // namespace cageform_support

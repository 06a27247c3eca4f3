#pragma once

// The control of a figure in space, which programs that move one have in common: coordinates by a cage, a
// lattice or points, and their pose by a file, operations and pins.

#include "cli/coordinates.hpp"
#include "cli/pinned_cage.hpp"
#include "cli/pose_choice.hpp"
#include "files/obj_file.hpp"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// The control of a figure: coordinates, and the pose of their handles.
struct MeshControl {
    ChosenCoordinates<double, 3> coordinates;
    ObjFile cage, pose;          // of sites with points alone
    std::vector<double> weights; // of sites, or none
    std::function<std::string(const cageform::BindReport&)> describe_faults;
    std::vector<Point3> handles = {}; // the pose of all, where pins pose vectors of faces too; else none
    std::string on_pins = {};         // what --report says of them
    std::size_t saved = 0; // the vertices that --save-pose writes: all but the corners of --surround

    std::string saved_pose() const; ///< the text of a file that --pose reads
};

/// The options --cage, --pose, operations such as --turn, pins and --save-pose, and with those of its
/// members all that control a figure.
struct MeshControlChoice {
    std::string cage, pose, save_pose;
    OutsideChoice outside;
    CoordinatesChoice choice;
    SiteChoice of_sites;
    PoseChoice operations;
    PinChoice pins;

    /// Adds all options but those of `outside`, `choice` and `of_sites`, which it prepares.
    void add_options(CommandLine& line);
    bool has_pose() const { return !pose.empty() || !operations.operations.empty(); }
    std::string fault() const; ///< why the options do not go together; empty: they do
    /// Returns why --save-pose cannot write the pose; empty if it can.
    std::string save_fault(const MeshControl& control) const;
};

/// Reads or makes the control that the options name.
///
///   figure   a mesh that a made cage goes around
///   places   points of the figure: pins may name them by number, and --surround takes them in
///   fails    where a file cannot be read or fits not, no cage can be made, or pins cannot be reached
Expected<MeshControl> read_mesh_control(const MeshControlChoice& given, const ObjFile& figure,
                                        std::span<const Point3> places);

} // namespace cageform_support

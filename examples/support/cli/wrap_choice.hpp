#pragma once

// The options of a map that wraps a source onto a target, and the map.

#include "cli/coordinates.hpp"
#include "cli/landmarks.hpp"
#include "files/mesh_file.hpp"
#include "files/welded_mesh.hpp"

#include <cageform/fit/types/wrap.hpp>

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace cageform_support {

/// Splits two names of files, "dress.obj:dress_on_target.obj". Returns the error; empty on success.
std::string parse_file_pair(std::string_view word, std::string& first, std::string& second);

/// The options --landmark and --landmarks.
struct LandmarkChoice {
    std::vector<std::pair<std::string, bool>> given; ///< words; files if true, in the order of the options

    void add_options(CommandLine& line);
    /// Parses all; fails as parse_landmark() and parse_landmarks(), or if a file cannot be read.
    Expected<Landmarks> read(const LandmarkVertices& vertices) const;
};

/// The meshes of a wrap, and all points that will follow the source.
struct WrapFigures {
    const MeshFile &source, &target;
    WeldedMesh source_surface, target_surface;
    Landmarks landmarks;
    std::vector<Point3> follow;
    MeshFile enclosed; ///< vertices and triangles that a generated cage must enclose
};

/// The map of a wrap, and the report of its search.
struct WrapMap {
    cageform::Wrap<double> wrap;
    cageform::WrapReport report;
    MeshFile cage;                                           ///< without a cage: empty
    std::optional<ChosenCoordinates<double, 3>> coordinates; ///< of the cage
    bool keeps_place = false;                                ///< --no-align

    /// Moves points of the source. Fails with the name of their file.
    ///
    ///   jacobians   out: #points, or empty
    void move(std::span<const Point3> points, std::span<Point3> moved, std::span<Jacobian3> jacobians,
              const std::string& name) const;
    /// Contents of a file that other programs read by --pose: the pose of the cage.
    std::string saved_pose() const;
};

/// The options --cage, --coordinates, --lattice, --landmark, --push-out and those of the search.
struct WrapChoice {
    std::string cage, save_pose;
    CoordinatesChoice coordinates;
    LandmarkChoice landmarks;
    std::size_t finest = 24;
    bool names_finest = false; ///< whether --lattice is given
    bool is_stiff = false, keeps_place = false, other_pose = false, refines_contacts = false;
    double residual = 0;
    std::optional<double> push_out; ///< distance of followers from the target, relative to its height

    void add_options(CommandLine& line);
    std::string fault() const; ///< error if options contradict each other; else empty
    /// Finds the map, with a progress bar. Fails with the culprit; warns about a bad fit.
    WrapMap solve(const WrapFigures& figures) const;
};

} // namespace cageform_support

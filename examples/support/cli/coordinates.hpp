#pragma once

// Coordinates chosen by name on the command line. The library consists of templates; the instances that
// the programs need are compiled once, in coordinates_2d.cpp, coordinates_2d_float.cpp and
// coordinates_3d.cpp.

#include "cli/command_line.hpp"
#include "files/cage_file.hpp"
#include "files/obj_file.hpp"
#include "files/site_file.hpp"

#include <cageform/binding/any_coordinates.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/coordinates/types.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace cageform_support {

/// The word of the command line for a name of the library: "mean-value" for mean_value.
std::string word_of(std::string name);

/// The choice of --coordinates, --resolution, --tolerance and --solver, which is common to all programs.
struct CoordinatesChoice {
    std::string name = "mean-value";  // one of names()
    bool is_named = false;            // whether it is given
    bool in_plane = false;            // whether the program takes polygons as cages
    bool in_space = false;            // whether it takes meshes
    std::string faces = "planar";     // of meshes: planar, fan or triangles
    std::size_t divisions = 1;        // of their quads, each way
    bool with_sites = false;          // whether the program takes control points without a cage
    bool with_normals = false;        // whether the program poses edges or faces too
    std::string gradients = "facets"; // of sibson-c1
    std::size_t resolution = 0;       // 0: the adaptive grid
    bool is_uniform = false;          // --tolerance is given, which the adaptive grid does not look at
    cageform::HarmonicOptions harmonic;
    bool limits_memory = true; // whether the program takes --memory for a solver
    std::size_t memory = 0;    // of a solver, in bytes; 0: half of what is free
    bool in_disk = false;      // curved-green: by the function of a disk about the cage
    double disk_radius = 0;    // 0: as small as it can be

    /// The types that the program takes, in the order of coordinates/types.hpp.
    std::vector<cageform::CoordinateType> types() const;
    std::vector<std::string> names() const;

    cageform::CoordinateType type() const;
    const cageform::CoordinateFacts& facts() const { return cageform::facts_of(type()); }

    void add_options(CommandLine& line);

    /// Whether the type takes sites instead of a cage.
    bool takes_sites() const { return (facts().cages & cageform::cage_kinds::sites) != 0; }

    /// Whether edges or faces are handles too. Values at vertices are then not those on the cage.
    bool takes_normals() const { return facts().with_normals; }

    /// Returns how a cage in the plane is read.
    CageEdges edges() const {
        return (facts().cages & cageform::cage_kinds::curves) != 0 ? CageEdges::curves : CageEdges::lines;
    }

    /// Whether faces of more than three corners are fans, never planar polygons.
    bool takes_fans_alone() const {
        using namespace cageform::cage_kinds;
        return (facts().cages & (fans | planar_faces)) == fans;
    }

    /// Whether the type is for cages in the plane alone.
    bool is_planar() const {
        using namespace cageform::cage_kinds;
        return (facts().cages & ~(polygon | curves)) == 0;
    }

    /// Returns the options of harmonic coordinates in the plane (2) or in space (3).
    cageform::HarmonicOptions harmonic_options(std::size_t dimension) const;
};

/// The choice of --weights and --surround for sites.
struct SiteChoice {
    std::string weights;      // a file; empty: none
    double surround = 0;      // the margin of points around all that stand still; 0: none
    bool with_weights = true; // whether the program takes --weights

    void add_options(CommandLine& line);
    std::string fault(const CoordinatesChoice& choice) const; ///< why they do not go with it; empty: they do
};

/// Sites with their pose, as the options have them.
template <std::size_t D>
struct PosedSites {
    SiteFile<D> sites, pose;
    std::vector<double> weights; // of all sites, or none
};

/// Reads sites and a pose of them; fails also where the weights do, or no box can be had.
///
///   figure   returns the points that a requested box has to hold
template <std::size_t D>
Expected<PosedSites<D>>
load_posed_sites(const std::string& path, const std::string& pose_path, const SiteChoice& choice,
                 const std::function<Expected<std::vector<typename SiteFile<D>::Point>>()>& figure) {
    auto sites = load_sites<D>(path);
    if (!sites) return sites.error();
    auto pose = load_site_pose(pose_path, *sites);
    if (!pose) return pose.error();
    PosedSites<D> posed{std::move(*sites), std::move(*pose), {}};
    if (!choice.weights.empty()) {
        auto read = load_site_weights(choice.weights, posed.sites.points.size());
        if (!read) return read.error();
        posed.weights = std::move(*read);
    }
    if (choice.surround > 0) {
        const auto inside = figure();
        if (!inside) return inside.error();
        const std::string why = surround_sites(choice.surround, *inside, posed.sites, posed.pose);
        if (!why.empty()) return FileError{why};
        if (!posed.weights.empty()) posed.weights.resize(posed.sites.points.size(), 1);
    }
    return posed;
}

/// Returns the bounds of the handles that are points; vectors of faces are not.
template <cageform::Scalar T, std::size_t D>
auto point_bounds(const cageform::HandleView<T, D>& handles) {
    std::vector<cageform::Vec<T, D>> points;
    for (std::size_t i = 0; i < handles.count; ++i) {
        if (handles.is_point(i)) points.push_back(handles.rest[i]);
    }
    return cageform::bounds_of(std::span<const cageform::Vec<T, D>>(points));
}

/// Coordinates of the type that the options name.
template <cageform::Scalar T, std::size_t D>
class ChosenCoordinates : public cageform::AnyCoordinates<T, D> {
public:
    using cageform::AnyCoordinates<T, D>::AnyCoordinates;
    ChosenCoordinates(cageform::AnyCoordinates<T, D> made) // NOLINT(google-explicit-constructor)
        : cageform::AnyCoordinates<T, D>(std::move(made)) {}

    /// Returns the distance within which a place outside counts as on the boundary.
    double boundary_tolerance() const {
        constexpr double rounding = std::max(1e-12, 4 * double(std::numeric_limits<T>::epsilon()));
        return rounding * point_bounds(this->handles()).diagonal();
    }

    bool takes_sites = false; // control points without a cage
    std::string note;         // on the cage's faces and a grid of much memory; empty where there is none
};

template <class T>
ChosenCoordinates<T, 2> make_coordinates(const CoordinatesChoice& choice, const CageFile& cage);
template <class T>
ChosenCoordinates<T, 3> make_coordinates(const CoordinatesChoice& choice, const ObjFile& cage);
template <class T, std::size_t D>
ChosenCoordinates<T, D> make_coordinates(const CoordinatesChoice& choice, const SiteFile<D>& sites);

/// Names the edge or face whose vector is a handle, by its vertices: "from vertex 1 to 2"; in space as
/// an OBJ file counts them, "v 1, v 3, v 2".
template <cageform::Scalar T, std::size_t D>
std::string name_of_face(const cageform::HandleView<T, D>& handles, std::size_t handle) {
    std::size_t vectors_before = 0;
    for (std::size_t i = 0; i < handle; ++i) vectors_before += handles.is_point(i) ? 0 : 1;
    const auto& face = handles.faces[vectors_before];
    if constexpr (D == 2) {
        return "from vertex " + std::to_string(face[0]) + " to " + std::to_string(face[1]);
    } else {
        std::string text;
        for (const auto vertex : face) {
            const bool is_mean = vertex >= handles.count;
            text += (text.empty() ? "" : ", ") +
                    (is_mean ? "the mean of its face" : "v " + std::to_string(vertex + 1));
        }
        return text;
    }
}

/// Puts vertices of a pose in the plane that are within rounding of their places at rest there: the control
/// points of a line or quadratic as a cubic are sums, which the library may round in another way.
template <cageform::Scalar T>
void settle(const cageform::HandleView<T, 2>& handles, std::vector<Point2>& pose) {
    const std::size_t count = std::min(pose.size(), handles.count);
    double largest = 0;
    for (std::size_t i = 0; i < count; ++i)
        largest = std::max(largest, double(std::hypot(handles.rest[i][0], handles.rest[i][1])));
    const double rounding = 2 * double(cageform::epsilon<T>) * largest;
    for (std::size_t i = 0; i < count; ++i) {
        const Point2 rest{double(handles.rest[i][0]), double(handles.rest[i][1])};
        if (std::hypot(pose[i].x - rest.x, pose[i].y - rest.y) <= rounding) pose[i] = rest;
    }
}

/// The pose of all handles, from one of the vertices.
///
///   pose, name   of the vertices, and their file
///   warning      out: of edges or faces that have no area in the pose; as it was where there are none
template <cageform::Scalar T, std::size_t D, class P>
Expected<std::vector<P>> pose_of_handles(const cageform::Binding<T, D>& binding, std::vector<P> pose,
                                         const std::string& name, std::string& warning) {
    if constexpr (std::is_same_v<P, Point2>) settle(binding.handle_view(), pose);
    std::vector<P> handles(binding.handle_count());
    const auto report = cageform::pose_handles(binding, pose, handles);
    if (report.status != cageform::Status::ok)
        return FileError{name + ": " + cageform::to_string(report.status)};
    if (report.collapsed_faces > 0) {
        const bool one = report.collapsed_faces == 1;
        warning = name + ": " + std::to_string(report.collapsed_faces) + (D == 2 ? " edge" : " face") +
                  (one ? " has" : "s have") + (D == 2 ? " no length" : " no area") +
                  (one ? ", " : ", first ") + name_of_face(binding.handle_view(), report.first_collapsed) +
                  ": which way " + (one ? "it faces" : "they face") + " is unknown";
    }
    return handles;
}

/// The words of --outside that name an OutsidePoints.
std::vector<std::string> outside_words();

/// The choice of --outside and --falloff, which is common to all programs that move a figure.
struct OutsideChoice {
    std::string word =
        "auto"; // extend where the coordinates are defined outside, keep with sites, else nearest
    bool with_sites = false;   // whether the program takes control points without a cage
    bool can_extend = true;    // whether the program can do with weights of points outside
    bool cage_is_made = false; // for the figure: what is outside is not seen
    bool of_part = false;      // whether the points are a part of a figure: most of them may lie outside
    bool can_fade = true;      // whether the program can do with weights that do not sum to 1
    bool has_splats = false;   // whether the points are splats, which messages count from 0
    double falloff = 0;        // the distance at which displacements outside have faded; 0: they do not fade
    Point3 origin{};           // in space: where the coordinates' origin lies in the figure's file

    void add_options(CommandLine& line);
    /// Adds --falloff alone, for a program with its own --outside.
    static void add_falloff(CommandLine& line, double& falloff);
    std::string fault() const; ///< why the options do not go together; empty: they do

    /// Returns how points outside are bound.
    template <cageform::Scalar T, std::size_t D>
    cageform::BindOptions bind_options(const ChosenCoordinates<T, D>& coordinates) const;

    /// The messages after a bind.
    struct Verdict {
        /// The reason to stop; empty if there is none. The program stops if most points are outside and
        /// --outside is not given, since the cage may be of another figure.
        std::string fault;
        std::string warning; ///< of points outside that nothing was said about; empty where there are none
    };
    ///   figure, cage   names of their files
    template <cageform::Scalar T, std::size_t D>
    Verdict judge(const ChosenCoordinates<T, D>& coordinates, const cageform::BindReport& report,
                  std::span<const std::conditional_t<D == 2, Point2, Point3>> points,
                  const std::string& figure, const std::string& cage) const;
};

} // namespace cageform_support

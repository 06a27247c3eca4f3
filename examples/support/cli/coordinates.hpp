#pragma once

// Coordinates selected by name on the command line. The library consists of templates; the instances of the
// programs are compiled once, in coordinates_2d.cpp, coordinates_2d_float.cpp and coordinates_3d.cpp.

#include "cli/command_line.hpp"
#include "files/cage_file.hpp"
#include "files/mesh_file.hpp"
#include "files/site_file.hpp"
#include "io/messages.hpp"

#include <cageform/binding/any_coordinates.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/coordinates/types.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace cageform_support {

/// Converts a name of the library to a word of the command line: mean_value to "mean-value".
std::string word_of(std::string name);

/// The options --coordinates, --resolution, --tolerance, --accuracy, --memory and those of single types.
struct CoordinatesChoice {
    std::string name = "mean-value";  // one of names()
    bool is_named = false;            // whether --coordinates is given
    bool in_plane = false;            // whether the program takes polygons as cages
    bool in_space = false;            // whether the program takes meshes as cages
    std::string faces = "planar";     // of meshes: planar, fan or triangles
    std::size_t divisions = 1;        // cells per side of a quad
    bool with_sites = false;          // whether the program takes control points without a cage
    bool with_normals = false;        // whether edges or faces can be handles
    std::string gradients = "facets"; // of sibson-c1
    std::size_t resolution = 0;       // 0: the adaptive grid
    bool is_uniform = false;          // whether --tolerance is given, which the adaptive grid does not use
    cageform::HarmonicOptions harmonic;
    bool limits_memory = true; // whether the program has --memory for a solver
    std::size_t memory = 0;    // of a solver, in bytes; 0: half of the available memory
    bool in_disk = false;      // curved-green: use Green's function of a disk around the cage
    double disk_radius = 0;    // 0: the smallest possible

    /// The types that the program takes, in the order of coordinates/types.hpp.
    std::vector<cageform::CoordinateType> types() const;
    std::vector<std::string> names() const;

    cageform::CoordinateType type() const;
    const cageform::CoordinateFacts& facts() const { return cageform::facts_of(type()); }

    void add_options(CommandLine& line);

    /// Whether the type takes sites instead of a cage.
    bool takes_sites() const { return (facts().cages & cageform::cage_kinds::sites) != 0; }

    /// Whether edges or faces are handles, so that values at vertices are not those on the cage.
    bool takes_normals() const { return facts().with_normals; }

    /// Returns how a cage in the plane is read.
    CageEdges edges() const {
        return (facts().cages & cageform::cage_kinds::curves) != 0 ? CageEdges::curves : CageEdges::lines;
    }

    /// Whether faces of more than three corners become fans instead of planar polygons.
    bool takes_fans_alone() const {
        using namespace cageform::cage_kinds;
        return (facts().cages & (fans | planar_faces)) == fans;
    }

    /// Whether the type supports only cages in the plane.
    bool is_planar() const {
        using namespace cageform::cage_kinds;
        return (facts().cages & ~(polygon | curves)) == 0;
    }

    /// Returns the options of harmonic coordinates in the plane (2) or in space (3).
    cageform::HarmonicOptions harmonic_options(std::size_t dimension) const;
};

/// The options --weights and --surround for sites.
struct SiteChoice {
    std::string weights;      // a file; empty: none
    double surround = 0;      // margin of the added box of fixed points; 0: none
    bool with_weights = true; // whether the program has --weights

    void add_options(CommandLine& line);
    std::string fault(const CoordinatesChoice& choice) const; ///< error if `choice` does not fit; else empty
};

/// Sites and their pose, after applying the options.
template <std::size_t D>
struct PosedSites {
    SiteFile<D> sites, pose;
    std::vector<double> weights; // of all sites, or none
};

/// Reads sites and a pose of them. Fails also if the weights cannot be read, or the box cannot be computed.
///
///   figure   returns the points that a requested box must contain
template <std::size_t D>
PosedSites<D>
load_posed_sites(const std::string& path, const std::string& pose_path, const SiteChoice& choice,
                 const std::function<Expected<std::vector<typename SiteFile<D>::Point>>()>& figure) {
    auto sites = value_or_fail(load_sites<D>(path));
    auto pose = value_or_fail(load_site_pose(pose_path, sites));
    PosedSites<D> posed{std::move(sites), std::move(pose), {}};
    if (!choice.weights.empty()) {
        posed.weights = value_or_fail(load_site_weights(choice.weights, posed.sites.points.size()));
    }
    if (choice.surround > 0) {
        const auto inside = value_or_fail(figure());
        const std::string why = surround_sites(choice.surround, inside, posed.sites, posed.pose);
        if (!why.empty()) throw Failure(why);
        if (!posed.weights.empty()) posed.weights.resize(posed.sites.points.size(), 1);
    }
    return posed;
}

/// Bounding box of the handles that are points; vectors of faces are excluded.
template <cageform::Scalar T, std::size_t D>
auto point_bounds(const cageform::HandleView<T, D>& handles) {
    std::vector<cageform::Vec<T, D>> points;
    for (std::size_t i = 0; i < handles.count; ++i) {
        if (handles.is_point(i)) points.push_back(handles.rest[i]);
    }
    return cageform::bounds_of(std::span<const cageform::Vec<T, D>>(points));
}

/// Coordinates of the type selected by the options.
template <cageform::Scalar T, std::size_t D>
class ChosenCoordinates : public cageform::AnyCoordinates<T, D> {
public:
    using cageform::AnyCoordinates<T, D>::AnyCoordinates;
    ChosenCoordinates(cageform::AnyCoordinates<T, D> made) // NOLINT(google-explicit-constructor)
        : cageform::AnyCoordinates<T, D>(std::move(made)) {}

    /// Distance from the boundary within which a point outside counts as on it.
    double boundary_tolerance() const {
        constexpr double rounding = std::max(1e-12, 4 * double(std::numeric_limits<T>::epsilon()));
        return rounding * point_bounds(this->handles()).diagonal();
    }

    bool takes_sites = false; // control points without a cage
    std::string note; // on faces of the cage and the memory of a grid; empty if there is nothing to report
};

template <class T>
ChosenCoordinates<T, 2> make_coordinates(const CoordinatesChoice& choice, const CageFile& cage);
template <class T>
ChosenCoordinates<T, 3> make_coordinates(const CoordinatesChoice& choice, const MeshFile& cage);
template <class T, std::size_t D>
ChosenCoordinates<T, D> make_coordinates(const CoordinatesChoice& choice, const SiteFile<D>& sites);

/// Names the vertices of the edge or face whose vector is a handle: "from vertex 1 to 2"; in space as
/// numbered in an OBJ file: "v 1, v 3, v 2".
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

/// Resets vertices of a planar pose to rest if they differ only by rounding. When a line or quadratic is
/// converted to a cubic, the control points are sums, which the library may round differently.
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

/// The pose of all handles from a pose of the vertices.
///
///   pose, name   positions of the vertices, and the name of their file
///   warning      set if edges or faces have no length or area in the pose; else unchanged
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
                  ": " + (one ? "its normal is" : "their normals are") + " undefined";
    }
    return handles;
}

/// The values of --outside that name a value of cageform::OutsidePoints.
std::vector<std::string> outside_words();

/// The options --outside and --falloff.
struct OutsideChoice {
    std::string word = "auto"; // extend if possible, keep-in-place with sites, else nearest-boundary
    bool with_sites = false;   // whether the program takes control points without a cage
    bool can_extend = true;    // whether the program supports weights of points outside
    bool cage_is_made = false; // whether the cage is made for the figure: then points outside are invisible
    bool of_part = false;    // whether the points are a part of a figure, so that most of them may be outside
    bool can_fade = true;    // whether the program supports weights that do not sum to 1
    bool has_splats = false; // whether the points are splats, which messages count from 0
    double falloff = 0;      // distance at which displacements outside have faded to 0; 0: no fading
    Point3 origin{};         // in space: the origin of the coordinates, in units of the figure's file

    void add_options(CommandLine& line);
    /// Adds only --falloff, for a program with its own --outside.
    static void add_falloff(CommandLine& line, double& falloff);
    std::string fault() const; ///< error if the options exclude each other; else empty

    /// How points outside are bound.
    template <cageform::Scalar T, std::size_t D>
    cageform::BindOptions bind_options(const ChosenCoordinates<T, D>& coordinates) const;

    /// The messages after a bind.
    struct Verdict {
        /// The error; empty if there is none. Without --outside, most points outside are an error, since the
        /// cage may belong to another figure.
        std::string fault;
        std::string warning; ///< on points outside without a requested treatment; empty if there are none
    };
    ///   figure, cage   names of their files
    template <cageform::Scalar T, std::size_t D>
    Verdict judge(const ChosenCoordinates<T, D>& coordinates, const cageform::BindReport& report,
                  std::span<const std::conditional_t<D == 2, Point2, Point3>> points,
                  const std::string& figure, const std::string& cage) const;
    /// Prints the warning of judge(), and throws its error as a Failure.
    template <cageform::Scalar T>
    void check(const ChosenCoordinates<T, 3>& coordinates, const cageform::BindReport& report,
               std::span<const Point3> points, const std::string& figure, const std::string& cage) const {
        const auto [fault, warning] = judge(coordinates, report, points, figure, cage);
        fail_if(fault);
        warn(warning);
    }
};

} // namespace cageform_support

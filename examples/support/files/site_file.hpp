#pragma once

// Files of sites (control points without a cage) and their poses.

#include "files/cage_file.hpp"
#include "files/mesh_file.hpp"

#include <cageform/binding/bind.hpp>

#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

namespace cageform_support {

/// Sites in the plane (D = 2) or in space (D = 3).
template <std::size_t D>
struct SiteFile {
    using Point = std::conditional_t<D == 2, Point2, Point3>;

    std::string name;
    std::vector<Point> points;
    std::vector<std::string> places; // #points: "line 7", "circle \"nose\" (line 4)", for messages
};

/// Help text on sites.
inline constexpr const char* site_formats =
    "The types sibson and sibson-c1 use control points anywhere on, in or around the\n"
    "figure instead of a cage. In the plane these are the centres of the circles drawn\n"
    "in an SVG file (radius above 0), in their order; in space they are the vertices of\n"
    "an OBJ file, with or without faces. In both they can be the lines x,y or x,y,z of a\n"
    "CSV file (.csv); empty lines and lines that begin with # are skipped. A pose has as\n"
    "many points, in the same order. Only points inside the convex hull can move.\n";

namespace detail {

template <std::size_t D>
Expected<SiteFile<D>> read_site_csv(const std::string& path);
Expected<SiteFile<2>> read_site_circles(const std::string& path);
Expected<SiteFile<3>> read_site_vertices(const std::string& path); // in the library of programs in space

} // namespace detail

/// The dimension of the sites of a file: 2 for SVG, 3 for OBJ; for CSV by its first point, without other
/// checks.
Expected<std::size_t> site_dimension(const std::string& path);

/// Reads sites from a CSV file, an SVG (D = 2) or a mesh (D = 3).
///
///   fails   if the file cannot be read or has no points; the library checks whether they are usable
template <std::size_t D>
Expected<SiteFile<D>> load_sites(const std::string& path) {
    const auto read = [&] {
        if (path.ends_with(".csv")) return detail::read_site_csv<D>(path);
        if constexpr (D == 2)
            return detail::read_site_circles(path);
        else
            return detail::read_site_vertices(path);
    };
    auto sites = read();
    if (sites && sites->points.empty()) return FileError{path + ": holds no points"};
    return sites;
}

/// Reads a pose of sites; fails also if the number of points differs, or one is not finite.
template <std::size_t D>
Expected<SiteFile<D>> load_site_pose(const std::string& path, const SiteFile<D>& sites) {
    auto pose = load_sites<D>(path);
    if (!pose) return pose;
    if (pose->points.size() != sites.points.size()) {
        return FileError{path + ": the pose has " + std::to_string(pose->points.size()) + " points, " +
                         sites.name + " " + std::to_string(sites.points.size())};
    }
    for (std::size_t i = 0; i < pose->points.size(); ++i) {
        if (!cageform::is_finite(cageform::to_vec<double>(pose->points[i])))
            return FileError{path + ": " + pose->places[i] + ": a number is not finite"};
    }
    return pose;
}

/// Help text on weights of sites.
inline constexpr const char* site_weights_format =
    "Weights of points are a text file with a number above 0 for each point, one per\n"
    "line, in their order; empty lines and lines that begin with # are skipped. A\n"
    "heavier point attracts the figure, even when no point has moved.\n";

/// Reads weights of sites; fails also if their number is not `count`, or one is not finite and positive.
Expected<std::vector<double>> load_site_weights(const std::string& path, std::size_t count);

/// Adds the corners of a box around the sites and a figure; the corners stay at rest. See surround() of
/// cageform/cage/control_points.hpp.
///
///   margin    of the box, relative to the diagonal of its content; positive
///   returns   the error if there is no such box; else empty
template <std::size_t D>
std::string surround_sites(double margin, const std::vector<typename SiteFile<D>::Point>& figure,
                           SiteFile<D>& sites, SiteFile<D>& pose);

/// Error for the first finite site out of the range of single precision; else empty.
template <std::size_t D>
std::string single_precision_fault(const SiteFile<D>& sites);

/// describe_faults() for sites, with their lines or elements.
template <std::size_t D>
std::string describe_site_faults(const SiteFile<D>& sites, const cageform::BindReport& report);

} // namespace cageform_support

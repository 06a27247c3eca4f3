#pragma once

// Control points without a cage (sites) and poses of them, as files.

#include "files/cage_file.hpp"
#include "files/obj_file.hpp"

#include <cageform/binding/bind.hpp>

#include <cstddef>
#include <string>
#include <type_traits>
#include <vector>

namespace cageform_support {

/// Sites in the plane (D = 2) or in space (D = 3), as read.
template <std::size_t D>
struct SiteFile {
    using Point = std::conditional_t<D == 2, Point2, Point3>;

    std::string name;
    std::vector<Point> points;
    std::vector<std::string> places; // #points: "line 7", "circle \"nose\" (line 4)", for messages
};

/// The text for --help on sites.
inline constexpr const char* site_formats =
    "The types sibson and sibson-c1 use control points anywhere on, in or about the\n"
    "figure instead of a cage. In the plane these are the centres of the circles drawn\n"
    "in an SVG file (radius above 0), in their order; in space they are the vertices of\n"
    "an OBJ file, with or without faces. In both they can be the lines x,y or x,y,z of a\n"
    "CSV file (.csv); empty lines and lines that begin with # are skipped. A pose has as\n"
    "many points, in the same order. Only points inside the convex hull can move.\n";

/// 2 or 3: what sites a file holds. An SVG has those of the plane, an OBJ those of space, a CSV file tells
/// by its first point; load_sites() refuses what is not a point.
Expected<std::size_t> site_dimension(const std::string& path);

/// Reads sites, of a CSV file, an SVG (D = 2) or an OBJ (D = 3).
///
///   fails   where the file cannot be read or holds none; whether they can serve is for the library to say
template <std::size_t D>
Expected<SiteFile<D>> load_sites(const std::string& path);

/// Reads a pose of sites; fails also where it has not as many points, or one that is not finite.
template <std::size_t D>
Expected<SiteFile<D>> load_site_pose(const std::string& path, const SiteFile<D>& sites);

/// The text for --help on weights of sites.
inline constexpr const char* site_weights_format =
    "Weights of points are a text file with a number above 0 for each point, one per\n"
    "line, in their order; empty lines and lines that begin with # are skipped. A\n"
    "heavier point attracts the figure, even when no point has moved.\n";

/// Reads weights of sites; fails also where there are not `count`, or one is not finite and above 0.
Expected<std::vector<double>> load_site_weights(const std::string& path, std::size_t count);

/// Adds the corners of a box around the sites and a figure, which stand still in the pose. See
/// surround() of cageform/cage/control_points.hpp.
///
///   margin   of the box, in diagonals of what is inside; above 0
///   returns  why there is no such box; empty if there is one
template <std::size_t D>
std::string surround_sites(double margin, const std::vector<typename SiteFile<D>::Point>& figure,
                           SiteFile<D>& sites, SiteFile<D>& pose);

/// The first site that is finite and beyond single precision; empty where there is none.
template <std::size_t D>
std::string single_precision_fault(const SiteFile<D>& sites);

/// describe_faults() of sites, which are named by their places.
template <std::size_t D>
std::string describe_site_faults(const SiteFile<D>& sites, const cageform::BindReport& report);

} // namespace cageform_support

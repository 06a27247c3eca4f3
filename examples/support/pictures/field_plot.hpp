#pragma once

// Pictures of a field over a planar domain: a colour map with level lines, and a surface in 3D views.

#include "cli/command_line.hpp"
#include "pictures/mesh_picture.hpp"
#include "pictures/picture.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// Black at 0, yellow for positive and green for negative values; the brightness is the square root of the
/// absolute value.
Colour sign_root(double value);

/// Drawing options of fields.
struct FieldStyle {
    std::size_t size = 900; ///< pixels along the longer side
    std::size_t levels = 10;
    bool colour_bar = true;
    std::string signs = "heat";
    double zero = 0, one = 1; ///< values with the colours of 0 and 1
    double step = 0;          ///< between level lines; 0: no lines

    /// Call after parsing: sets zero, one and step.
    void set_range(double from, double to);
    double share(double value) const { return (value - zero) / (one - zero); }
    /// Colour of lines on the colour map.
    Colour ink() const { return signs == "root" ? Colour{0.8f, 0.8f, 0.8f} : Colour{0.2f, 0.13f, 0.12f}; }
    Colour colour(double value) const {
        return signs == "root" ? sign_root(share(value)) : heat(share(value));
    }
    void add_options(CommandLine& line);
    Colour outside() const { return signs == "root" ? Colour{0.75f, 0.1f, 0.1f} : Colour{1, 1, 1}; }
};

/// An axis-aligned rectangle; initially empty.
struct PlaneBox {
    static constexpr double most = std::numeric_limits<double>::max();
    Point2 low{most, most}, high{-most, -most};

    /// Grows to contain a point.
    void add(const Point2& p) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    double width() const { return high.x - low.x; }
    double height() const { return high.y - low.y; }
    double extent() const { return std::max(width(), height()); }
};

/// Parses "x,y,width,height"; nothing if invalid or without area.
std::optional<PlaneBox> parse_box(const std::string& text);

/// The error of parse_box(), for CommandOption::check(); empty if the text is valid.
std::string box_fault(const std::string& text);

/// The part of a segment in a box, as two fractions of its length; nothing if it does not cross the box.
std::optional<std::array<double, 2>> clip_segment(const Point2& a, const Point2& b, const PlaneBox& box);

/// Minimum and maximum of all values that are not NaN; 0 and 0 if there are none.
std::array<double, 2> least_and_largest(std::span<const double> values);

/// Draws a colour map, one pixel per value, with level lines between neighbours on different sides of a
/// level.
///
///   values   width · height; NaN is outside
Picture draw_field(std::span<const double> values, std::size_t width, const FieldStyle& style);

/// Adds a colour bar for a range of values on the right of a picture.
Picture with_colour_bar(const Picture& picture, double from, double to, const FieldStyle& style);

/// A triangulated domain.
struct PlaneMesh {
    std::vector<Point2> places;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Triangulates the part of a box inside loops (even-odd rule). Triangles are cut by a lattice and by the
/// loops, so the boundary is exact.
///
///   cells   of the lattice along the longer side of the box
///   cost    O(#edges · #rows + #cells)
PlaneMesh cut_by_lattice(std::span<const std::vector<Point2>> loops, const PlaneBox& box, std::size_t cells);

/// The dual mesh of a grid: squares between cell centres, which are at half-integers.
PlaneMesh mesh_of_grid(std::size_t width, std::size_t height);

/// A polyline in the plane with values.
struct PlaneLine {
    std::vector<Point2> points;
    std::vector<double> values;
};

/// Boundary edges of a mesh, without triangles that have a NaN corner.
std::vector<PlaneLine> rim_of(const PlaneMesh& mesh, std::span<const double> values);

/// A field on a mesh. Triangles with a NaN corner are not drawn.
struct FieldSurface {
    PlaneMesh mesh;
    std::vector<double> values;      ///< #places
    std::vector<PlaneLine> boundary; ///< drawn on the surface and on the floor
    bool y_up = false;
};

/// View of a surface, and its output file.
struct SurfaceView {
    std::string path;
    std::vector<double> turns{35, -126}; ///< in degrees, one view each
    double rise = 30;
    double height = 0.6; ///< height of the range of values, relative to the domain's longer side

    void add_options(CommandLine& line, const std::string& name = "--surface");
};

/// Draws the surface over its domain with level lines, boundary values and a box with axes: one view per
/// turn.
Picture draw_surface(const FieldSurface& surface, const SurfaceView& view, const FieldStyle& style);

// Inline, so that users without options do not link CLI11.

inline void FieldStyle::add_options(CommandLine& line) {
    line.add("--size", size, "pixels along the longer side").range(16, 8192).show_default();
    line.add("--levels", levels, "the number of steps between level lines from 0 to 1; 0 draws no lines")
        .range(0, 1000)
        .show_default();
    line.add("--signs", signs,
             "the colours: heat, or root, which shows the root of the absolute value: yellow where it is "
             "positive, green where it is negative, red outside")
        .one_of({"heat", "root"})
        .show_default();
    line.add_flag("--colour-bar,!--no-colour-bar", colour_bar, "draw the colour bar (default)");
}

inline void SurfaceView::add_options(CommandLine& line, const std::string& name) {
    line.add(name, path, "a PNG file to draw the field to as a surface over its domain").ends_with({".png"});
    line.add("--turn", turns,
             "the turn of the surface about the vertical, in degrees; several values give one view each")
        .count(1, 8)
        .show_default("35 -126");
    line.add("--rise", rise, "the elevation of the view above the floor, in degrees")
        .range(-90.0, 90.0)
        .show_default();
    line.add("--height", height, "the surface's height, as a share of the domain's longer side")
        .range(0.0, 10.0)
        .show_default();
}

} // namespace cageform_support

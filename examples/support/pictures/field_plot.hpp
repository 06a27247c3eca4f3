#pragma once

// Pictures of a field over a domain in the plane: a map of colours with level lines, and a surface seen
// from any side.

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

/// Black at 0; the root of the distance from it is how bright positive values are in yellow, negative ones
/// in green.
Colour sign_root(double value);

/// How a field is drawn: the options of every program that draws one.
struct FieldStyle {
    std::size_t size = 900; ///< pixels along the longer side
    std::size_t levels = 10;
    bool colour_bar = true;
    std::string signs = "heat";
    double zero = 0, one = 1; ///< the values that have the colours of 0 and of 1
    double step = 0;          ///< from one level line to the next; 0: no lines

    /// After parsing: sets zero and one, and the step by the number of levels.
    void set_range(double from, double to);
    double share(double value) const { return (value - zero) / (one - zero); }
    /// Returns the colour of lines over the colours.
    Colour ink() const { return signs == "root" ? Colour{0.8f, 0.8f, 0.8f} : Colour{0.2f, 0.13f, 0.12f}; }
    Colour colour(double value) const {
        return signs == "root" ? sign_root(share(value)) : heat(share(value));
    }
    void add_options(CommandLine& line);
    Colour outside() const { return signs == "root" ? Colour{0.75f, 0.1f, 0.1f} : Colour{1, 1, 1}; }
};

/// A part of the plane: a rectangle along the axes.
struct PlaneBox {
    static constexpr double most = std::numeric_limits<double>::max();
    Point2 low{most, most}, high{-most, -most};

    /// Grows by a point; without any it is empty.
    void add(const Point2& p) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    double width() const { return high.x - low.x; }
    double height() const { return high.y - low.y; }
    double extent() const { return std::max(width(), height()); }
};

/// "x,y,width,height", as an option has it; empty where it is none, or has no area.
std::optional<PlaneBox> parse_box(const std::string& text);

/// Returns why a text is not such a box, for CommandOption::check(); empty if it is one.
std::string box_fault(const std::string& text);

/// The part of a segment in a box: from which share of it to which; empty where it passes by.
std::optional<std::array<double, 2>> clip_segment(const Point2& a, const Point2& b, const PlaneBox& box);

/// Returns the extremes of all values that are numbers; 0 and 0 if there are none.
std::array<double, 2> least_and_largest(std::span<const double> values);

/// A map of colours, a pixel a value, with a level line wherever two neighbours lie on two sides of a
/// level.
///
///   values   width · height; what is not a number lies outside
Picture draw_field(std::span<const double> values, std::size_t width, const FieldStyle& style);

/// Adds a colour bar on the right of a picture, from one value to another.
Picture with_colour_bar(const Picture& picture, double from, double to, const FieldStyle& style);

/// A domain in triangles.
struct PlaneMesh {
    std::vector<Point2> places;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Triangulates the part of a box inside loops (even-odd rule), cut along a lattice and along the loops,
/// so that its boundary is exactly that of the loops.
///
///   cells   of the lattice along the longer side of the box
///   cost    O(#edges · #rows + #cells)
PlaneMesh cut_by_lattice(std::span<const std::vector<Point2>> loops, const PlaneBox& box, std::size_t cells);

/// The squares between the centres of a grid's cells, which are half a unit from whole numbers.
PlaneMesh mesh_of_grid(std::size_t width, std::size_t height);

/// A line over the plane, with the values that stand on it.
struct PlaneLine {
    std::vector<Point2> points;
    std::vector<double> values;
};

/// The rim of a mesh: the edges of one triangle alone, of those without a corner whose value is not a
/// number.
std::vector<PlaneLine> rim_of(const PlaneMesh& mesh, std::span<const double> values);

/// A field over a mesh. Triangles with a corner whose value is not a number are left out.
struct FieldSurface {
    PlaneMesh mesh;
    std::vector<double> values;      ///< one a place
    std::vector<PlaneLine> boundary; ///< a line on the surface, and an outline on the floor
    bool y_up = false;
};

/// How a surface is seen, and the file to draw it to.
struct SurfaceView {
    std::string path;
    std::vector<double> turns{35, -126}; ///< in degrees, a view each
    double rise = 30;
    double height = 0.6; ///< of the range of values, as a share of the domain's longer side

    void add_options(CommandLine& line, const std::string& name = "--surface");
};

/// The surface over its domain with level lines, the boundary's values, and a box with marks: a view for
/// every turn.
Picture draw_surface(const FieldSurface& surface, const SurfaceView& view, const FieldStyle& style);

// Defined here, so that who draws without options needs no command line.

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

#pragma once

// The basic shapes of SVG: from an element to its path, and from a path to its element.

#include "svg/document.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace cageform_support::detail {

/// The attributes that give each shape its geometry; they are replaced by `d`.
const std::map<std::string, std::vector<const char*>>& shape_attributes();

bool is_shape(const std::string& kind);
bool is_group(const std::string& kind);
bool is_fixed(const std::string& kind); ///< drawn, but no shape

/// The sizes that percentages refer to, and those of the font.
struct Viewport {
    double width = 0;
    double height = 0;
    double em = 16;
    double root_em = 16;
    double diagonal() const { return std::sqrt((width * width + height * height) / 2); }
};

/// An attribute as a length in user units, `otherwise` where there is none.
Expected<double> length_of(const SvgDocument& document, pugi::xml_node node, const char* name,
                           const Viewport& viewport, double whole, double otherwise);

/// Empty where x0 > x1.
struct Box {
    double x0 = std::numeric_limits<double>::infinity();
    double y0 = x0;
    double x1 = -x0;
    double y1 = -x0;

    bool empty() const { return !(x0 <= x1 && y0 <= y1); }
    double width() const { return x1 - x0; }
    double height() const { return y1 - y0; }
    void add(const Point2& p);
    void add(const Box& other);
    Box grown(double by) const { return {x0 - by, y0 - by, x1 + by, y1 + by}; } ///< of one not empty
    Box within(const Box& other) const;
    bool contains(const Box& other) const;
    Point2 centre() const { return {(x0 + x1) / 2, (y0 + y1) / 2}; }
    std::array<Point2, 4> corners() const { return {{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}}; }
    Box mapped(const Affine2& map) const; ///< the least box about the mapped corners; not of an empty box
};

Box box_of(const ViewBox& view);

/// Writes x, y, width and height; or the viewBox.
void set_box(pugi::xml_node node, const Box& box, int digits);
void set_view_box(pugi::xml_node node, const Box& box, int digits);

/// The least box of a path after a map: the curves', not their control points'.
Box bounds(const Path& path, const Affine2& map = {});

/// How far a map lengthens at most.
double largest_scale(const Affine2& map);

/// matrix(…), to `digits` significant digits of its largest entries.
std::string write_transform(const Affine2& map, int digits = 10);

void add_ellipse(PathBuilder& builder, const Point2& centre, double rx, double ry);

/// A shape's path in its own user space, drawn from SVG's starting points in its direction; empty where
/// the shape is not drawn because a size is zero.
///
///   faults      gets those of its attributes: what cannot be read is left out, as browsers do
///   most_turn   of an arc for one cubic
Path shape_path(const SvgDocument& document, pugi::xml_node node, const Viewport& viewport,
                std::vector<FileError>& faults, double most_turn = arc_of_figure);

/// The decimals of a path in a shape's own user space that make rounding a twentieth of a tolerance in root
/// user space.
int decimals_for(const Affine2& to_root, double tolerance);

} // namespace cageform_support::detail

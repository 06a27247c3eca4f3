#pragma once

// SVG shapes: conversion between elements and paths.

#include "svg/document.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace cageform_support::detail {

/// The geometry attributes of each shape, which `d` replaces.
const std::map<std::string, std::vector<const char*>>& shape_attributes();

bool is_shape(const std::string& kind);
bool is_group(const std::string& kind);
bool is_fixed(const std::string& kind); ///< drawn, but no shape

/// Reference sizes of percentages and of font units.
struct Viewport {
    double width = 0;
    double height = 0;
    double em = 16;
    double root_em = 16;
    double diagonal() const { return std::sqrt((width * width + height * height) / 2); }
};

/// Parses an attribute as a length in user units; `otherwise` if it is missing.
Expected<double> length_of(const SvgDocument& document, pugi::xml_node node, const char* name,
                           const Viewport& viewport, double whole, double otherwise);

/// An axis-aligned box; empty if x0 > x1.
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
    Box grown(double by) const {
        return {x0 - by, y0 - by, x1 + by, y1 + by};
    } ///< of a box that is not empty
    Box within(const Box& other) const;
    bool contains(const Box& other) const;
    Point2 centre() const { return {(x0 + x1) / 2, (y0 + y1) / 2}; }
    std::array<Point2, 4> corners() const { return {{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}}; }
    Box mapped(const Affine2& map) const; ///< bounding box of the mapped corners; of a box that is not empty
};

Box box_of(const ViewBox& view);

/// Sets x, y, width and height, or the viewBox.
void set_box(pugi::xml_node node, const Box& box, int digits);
void set_view_box(pugi::xml_node node, const Box& box, int digits);

/// Exact bounding box of a mapped path (of the curves, not of the control points).
Box bounds(const Path& path, const Affine2& map = {});

/// The larger singular value of a map.
double largest_scale(const Affine2& map);

/// Formats matrix(…) with `digits` significant digits of its largest entries.
std::string write_transform(const Affine2& map, int digits = 10);

void add_ellipse(PathBuilder& builder, const Point2& centre, double rx, double ry);

/// A shape's path in its own user space, with start point and direction as in SVG; empty if the shape is not
/// drawn because a size is zero.
///
///   faults      out: errors of attributes; invalid parts are ignored, as in browsers
///   most_turn   largest angle per cubic of an arc
Path shape_path(const SvgDocument& document, pugi::xml_node node, const Viewport& viewport,
                std::vector<FileError>& faults, double most_turn = arc_of_figure);

/// Number of decimals of a path in its own user space, for rounding errors of at most 1/20 of a tolerance in
/// root user space.
int decimals_for(const Affine2& to_root, double tolerance);

} // namespace cageform_support::detail

#pragma once

// The basic shapes of SVG: from an element to its path, and from a path to its element.

#include "svg_document.hpp"

#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace cageform_examples {

namespace detail {

/// The attributes that give each shape its geometry; they are replaced by `d`.
const std::map<std::string, std::vector<const char*>>& shape_attributes();

bool is_shape(const std::string& kind);
bool is_group(const std::string& kind);
bool is_fixed(const std::string& kind); ///< drawn, but no shape

/// What percentages are of.
struct Viewport {
    double width = 0;
    double height = 0;
    double diagonal() const { return std::sqrt((width * width + height * height) / 2); }
};

/// An attribute as a length in user units, `otherwise` where there is none.
SvgResult<double> length_of(const SvgDocument& document, pugi::xml_node node, const char* name, double whole,
                            double otherwise);

/// A shape's path in its own user space, drawn from SVG's starting points in its direction; empty where
/// the shape is not drawn because a size is zero.
SvgResult<Path> shape_path(const SvgDocument& document, pugi::xml_node node, const Viewport& viewport);

} // namespace detail

} // namespace cageform_examples

#pragma once

// Strokes of SVG drawings, for diffused fields.

#include "svg/css_colour.hpp"
#include "svg/document.hpp"

#include <cageform/core/vec.hpp>

#include <functional>
#include <string>
#include <vector>

namespace cageform_support {

/// A flattened subpath of a drawn shape.
struct DrawnLine {
    std::string label;                            // of its element, such as: path "ridge" (line 12)
    std::vector<cageform::Vec<double, 2>> points; // in root user space
    std::vector<double>
        along; // #points: index of the preceding vertex, plus the fraction of the way to the next one
    std::vector<double> part; // #points: fraction of the arc length before the point, 0 to 1
    std::size_t vertices = 0; // of the original subpath; the start of a closed one counts once
    bool closed = false;
    std::function<std::string(const char*)> attribute; // of its element, by name; empty if missing
    std::string stroke;                                // computed value
};

struct StrokeFile {
    std::string name;
    ViewBox canvas;
    std::vector<DrawnLine> lines; // in document order
};

/// Reads all shapes that have a stroke or one of the attributes.
///
///   fails   if the file cannot be read or is malformed, there is no such shape, or one extends beyond the
///           viewBox; with its name
Expected<StrokeFile> load_strokes(const std::string& path, const std::vector<const char*>& attributes);

/// Interpolates the values of an attribute at the points of a line: one value for the whole line; two for its
/// ends, linear in arc length; or one per vertex, linear between.
///
///   read    parses one value of `count` numbers from a word
///   text    words separated by white space outside brackets
///   fails   on another number of words
Expected<std::vector<double>>
values_along(const DrawnLine& line, const std::string& text, std::size_t count,
             const std::function<Expected<std::vector<double>>(const std::string&)>& read);

} // namespace cageform_support

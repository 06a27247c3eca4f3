#pragma once

// Strokes of an SVG drawing, for fields that are diffused from them.

#include "svg/css_colour.hpp"
#include "svg/document.hpp"

#include <cageform/core/vec.hpp>

#include <functional>
#include <string>
#include <vector>

namespace cageform_support {

/// A subpath of a drawn shape, its curves as lines.
struct DrawnLine {
    std::string label;                            // of its element, such as: path "ridge" (line 12)
    std::vector<cageform::Vec<double, 2>> points; // in root user space
    std::vector<double>
        along; // of each point: the number of the vertex before it and the part of the way to the next
    std::vector<double> part; // of each point: the part of the length before it, 0 to 1
    std::size_t vertices = 0; // of the subpath as it is written; the start of a closed one counts once
    bool closed = false;
    std::function<std::string(const char*)> attribute; // of its element, empty where there is none
    std::string stroke;                                // as CSS has it
};

struct StrokeFile {
    std::string name;
    ViewBox canvas;
    std::vector<DrawnLine> lines; // in document order
};

/// Reads what has a stroke, or one of these attributes.
///
///   fails   where the file cannot be read or is malformed, where nothing is such a stroke, and where one
///           reaches beyond
///           the viewBox: the message names it
Expected<StrokeFile> load_strokes(const std::string& path, const std::vector<const char*>& attributes);

/// The values of an attribute at the points of a line: one for all of it, two for its ends and linear in
/// its length between, or one for each of its vertices and linear between these.
///
///   read    one value of `count` numbers from a word; an error where it is none
///   text    words parted by white space, outside brackets
///   fails   with another number of words
Expected<std::vector<double>>
values_along(const DrawnLine& line, const std::string& text, std::size_t count,
             const std::function<Expected<std::vector<double>>(const std::string&)>& read);

} // namespace cageform_support

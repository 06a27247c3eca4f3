#pragma once

// Geometry and transforms in CSS. They are converted to attributes, which the walk reads.

#include "svg/shapes.hpp"
#include "svg/style.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace cageform_support::detail {

/// The value of a property; empty if it is not given, or is a CSS-wide keyword other than `initial`.
std::string text_of(const StyleSheets::Values& values, std::string_view property);

/// Parses a CSS angle; returns degrees.
std::optional<double> angle_of(std::string_view word);

/// The font size of an element in user units.
///
///   parent   viewport of the parent element, with its font size
double font_size(const StyleSheets::Values& values, const Viewport& parent);

/// Moves geometry and transforms from style attributes and sheets to attributes, for all elements but the
/// root. The resulting `transform` combines transform, translate, rotate, scale, transform-origin and
/// transform-box. Elements with unsupported values are left unmoved, with a warning.
void place_by_attributes(SvgDocument& document, StyleSheets& styles);

/// A CSS basic shape: circle(), ellipse(), inset(), rect(), xywh(), polygon() or path().
struct BasicShape {
    std::string data; // path data
    bool even_odd = false;
};

/// Parses a basic shape; nothing if the text is not a supported one.
///
///   fill, stroke   reference boxes of the element, without and with its stroke
std::optional<BasicShape> parse_basic_shape(std::string_view text, const Box& fill, const Box& stroke,
                                            const Viewport& viewport);

} // namespace cageform_support::detail

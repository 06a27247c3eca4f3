#pragma once

// Geometry and transforms that CSS gives: they become attributes, which the rest of the reader knows.

#include "svg/shapes.hpp"
#include "svg/style.hpp"

#include <optional>
#include <string>
#include <string_view>

namespace cageform_support::detail {

/// A value that is given and not "inherit"; else empty.
std::string text_of(const StyleSheets::Values& values, std::string_view property);

/// An angle in degrees.
std::optional<double> angle_of(std::string_view word);

/// The size of an element's font.
///
///   parent   has that of the element it stands in
double font_size(const StyleSheets::Values& values, const Viewport& parent);

/// Moves geometry and transforms from style attributes and sheets to attributes, for all elements but the
/// root. A `transform` then has all of transform, translate, rotate, scale, transform-origin and
/// transform-box. An element whose values are not read stays unmoved, with a warning.
void place_by_attributes(SvgDocument& document, StyleSheets& styles);

/// A basic shape, as clip-path has them: circle(), ellipse(), inset(), rect(), xywh(), polygon(), path().
struct BasicShape {
    std::string data; // of a path
    bool even_odd = false;
};

/// Returns nothing if the text is no basic shape, or an unsupported one.
///
///   box    that its lengths refer to: of the geometry, or with the stroke around it
std::optional<BasicShape> parse_basic_shape(std::string_view text, const Box& fill, const Box& stroke,
                                            const Viewport& viewport);

} // namespace cageform_support::detail

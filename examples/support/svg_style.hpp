#pragma once

// CSS in SVG documents: the style attribute, and style sheets.

#include "svg_document.hpp"

#include <string>
#include <string_view>

namespace cageform_examples {

namespace detail {

/// The value of a property in a style attribute; empty if it is not set there.
std::string style_property(pugi::xml_node node, std::string_view property);

/// The id that a `clip-path` or `mask` names as url(#id), with or without quotes; empty if none.
std::string referenced_id(pugi::xml_node node, const char* property);

void set_referenced_id(pugi::xml_node node, const char* property, const std::string& old,
                       const std::string& fresh);

} // namespace detail

} // namespace cageform_examples

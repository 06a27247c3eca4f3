#pragma once

// Texts as outlines, so that their letters can be deformed and measured.

#include "svg/document.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace cageform_support {

/// Replaces texts by the outlines of their letters, as rsvg-convert draws them with the fonts of this
/// machine: a <text> or <tspan> becomes a group that holds a path, and keeps its other attributes.
///
///   returns   how many texts became outlines, copies by <use> included; those in clip paths, not displayed,
///             or of which nothing was drawn stay, the last with a warning
///   places    the lists x, y, dx and dy hold for every letter; rotate, textLength and the properties of CSS
///             that rsvg-convert does not draw are left out, with a warning
///   lines     that text-decoration draws have the paint of the letters
///   fails     where rsvg-convert is not installed or cannot read the document, which is then unchanged
Expected<std::size_t> text_to_paths(SvgDocument& document, std::vector<std::string>& warnings);

/// Finds how far the letters of texts reach, as rsvg-convert draws them: SvgDocument::text_boxes. Texts
/// that are not measured (copies by <use>, where rsvg-convert is not installed or draws no letters) keep
/// the estimate of walk().
void measure_texts(SvgDocument& document);

/// A figure for a program that asks where its texts are: load_svg(), and either text_to_paths(), whose
/// warnings go to stderr, or measure_texts().
Expected<SvgDocument> load_figure(const std::string& path, bool text_as_paths = false);

} // namespace cageform_support

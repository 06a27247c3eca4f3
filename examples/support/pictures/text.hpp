#pragma once

// Converts texts to outlines, so that letters can be deformed and measured.

#include "svg/document.hpp"

#include <cstddef>
#include <string>
#include <vector>

namespace cageform_support {

/// Replaces texts by outlines, as rendered by rsvg-convert with the fonts of this machine. A <text> or
/// <tspan> becomes a group with a path and keeps its other attributes.
///
///   returns   number of converted texts, including copies by <use>. Texts that are in clip paths or not
///             displayed stay texts; so do texts without rendered letters, with a warning
///   places    per-letter lists x, y, dx and dy are supported; rotate, textLength and CSS properties that
///             rsvg-convert does not support are ignored, with a warning
///   lines     of text-decoration have the paint of the letters
///   fails     if rsvg-convert is not installed or cannot read the document, which is then unchanged
Expected<std::size_t> text_to_paths(SvgDocument& document, std::vector<std::string>& warnings);

/// Measures the boxes of texts with rsvg-convert: SvgDocument::text_boxes. Texts that cannot be measured
/// (copies by <use>; no rsvg-convert; no rendered letters) keep the estimate of walk().
void measure_texts(SvgDocument& document);

/// Loads a figure by load_svg(), then applies text_to_paths(), with warnings on stderr, or measure_texts().
Expected<SvgDocument> load_figure(const std::string& path, bool text_as_paths = false);

} // namespace cageform_support

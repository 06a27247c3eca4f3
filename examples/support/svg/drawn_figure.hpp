#pragma once

// Converts the painted parts of an SVG document to the segments that make_cage takes.

#include "svg/document.hpp"

#include <cageform/enclose/types/make_cage_options.hpp>

#include <vector>

namespace cageform_support {

/// Strokes as segments with half their width, tips of mitred corners and square caps included; outlines of
/// what is filled. In root user space.
struct DrawnFigure {
    std::vector<cageform::DrawnSegment<double>> segments;
    std::vector<cageform::PaintedArea> areas; // one for each filled shape
};

/// All that shows. Not what is not displayed, hidden, wholly transparent, or has neither fill nor stroke;
/// nor what lies beside the page, unless all does; nor clip paths and masks: a shape that they cut off
/// counts whole, as it is deformed whole. Text and images count as their boxes.
///
///   curves   become lines no farther off than 5e-4 of the document's diagonal, and as thick as that
///   fails    as shapes() does, and where nothing shows
Expected<DrawnFigure> drawn_figure(const SvgDocument& document);

} // namespace cageform_support

#pragma once

// Converts the visible parts of an SVG document to the input of make_cage.

#include "svg/document.hpp"

#include <cageform/enclose/types/make_cage_options.hpp>

#include <vector>

namespace cageform_support {

/// Strokes as segments with half the stroke width as radius, including tips of mitred corners and square
/// caps; outlines of fills. In root user space.
struct DrawnFigure {
    std::vector<cageform::DrawnSegment<double>> segments;
    std::vector<cageform::PaintedArea> areas; // one per filled shape
};

/// All visible shapes. Excluded: shapes that are not displayed, hidden, transparent, without fill and stroke,
/// or in clip paths and masks; shapes off the page, unless all are. A shape that is clipped counts whole,
/// since it is deformed whole. Texts and images count as their boxes.
///
///   curves   flattened with a tolerance of 5e-4 of the diagonal of the shapes' box; radii grow by it
///   fails    as shapes() does, and if nothing is visible
Expected<DrawnFigure> drawn_figure(const SvgDocument& document);

} // namespace cageform_support

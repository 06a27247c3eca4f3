#pragma once

// Collects the drawn shapes of a document.

#include "svg/shapes.hpp"
#include "svg/style.hpp"
#include "svg/xml.hpp"

#include <array>
#include <string>
#include <vector>

namespace cageform_support::detail {

/// An element with a filter, mask or clip path; it draws the shapes [first, end) of its level.
struct Reference {
    pugi::xml_node node;   // referring element
    pugi::xml_node target; // filter, mask or clipPath; none for CSS filter functions
    Affine2 to_root;
    Affine2 from_root;
    Viewport viewport;
    int level = 0;
    std::size_t first = 0, end = 0;
    std::size_t first_inside = 0, end_inside = 0; // the shapes of the clip path or mask
    bool hides_rest = false;                      // hides everything outside these shapes
};

bool is_filter(const Reference& reference);

/// An element that contains the shapes [first, end).
struct Group {
    pugi::xml_node node;
    Affine2 to_root;
    std::size_t first = 0, end = 0;
};

/// The drawn shapes of a document.
struct Drawing {
    std::vector<DrawnShape> shapes; // in document order; clip paths and masks after the shapes they apply to
    std::vector<Reference> references;
    std::vector<Group> groups;                // inner groups first
    std::vector<pugi::xml_node> flat_circles; // circles with radius 0, which are not drawn
};

struct WalkOptions {
    bool follow_references = true; // include clip paths and masks, skip what is not displayed
    bool boxes = false;            // include texts and images as boxes
    bool as_cage = false;          // arcs with the accuracy of cages; keep degenerate curves
    bool is_strict = false;        // fail on invalid attributes; else ignore them with a warning
};

/// Collects the drawn shapes. Changes the document without changing its appearance: every `use` becomes a
/// group with a copy, geometry and transforms in CSS become attributes. With follow_references, clip paths
/// and masks in use under several transforms or boxes are copied.
Expected<Drawing> walk(SvgDocument& document, StyleSheets& styles, IdTable& ids, const WalkOptions& options,
                       std::vector<std::string>& warnings);

/// Bounding box of the shapes [first, end) of a level, after a map.
Box bounds(const std::vector<DrawnShape>& shapes, std::size_t first, std::size_t end, int level,
           const Affine2& map);

/// The properties of DrawnShape::markers, in this order.
inline constexpr std::array marker_properties{"marker-start", "marker-mid", "marker-end"};

bool has_markers(const DrawnShape& shape);

/// #shapes: box of the visible part, after all clipping; empty if nothing is visible.
std::vector<Box> seen_boxes(const Drawing& drawing);

/// Bounding box of the painted parts of the shapes [first, end) of a level, after a map.
Box painted_bounds(const std::vector<DrawnShape>& shapes, std::size_t first, std::size_t end, int level,
                   const Affine2& map);

/// Bounding box of the painted part, with strokes (without tips of mitred corners), after a map.
Box painted_box(const DrawnShape& shape, const Affine2& map);

} // namespace cageform_support::detail

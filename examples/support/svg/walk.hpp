#pragma once

// The walk over what a document draws.

#include "svg/shapes.hpp"
#include "svg/style.hpp"
#include "svg/xml.hpp"

#include <array>
#include <string>
#include <vector>

namespace cageform_support::detail {

/// An element whose filter, mask or clip path lies about what it draws: shapes [first, end) of its level.
struct Reference {
    pugi::xml_node node;   // that refers
    pugi::xml_node target; // filter, mask or clipPath; nothing for a filter by functions of CSS
    Affine2 to_root;
    Affine2 from_root;
    Viewport viewport;
    int level = 0;
    std::size_t first = 0, end = 0;
    std::size_t first_inside = 0, end_inside = 0; // the shapes of the clip path or mask
    bool hides_rest = false;                      // hides what lies beyond these shapes
};

bool is_filter(const Reference& reference);

/// An element that holds shapes [first, end).
struct Group {
    pugi::xml_node node;
    Affine2 to_root;
    std::size_t first = 0, end = 0;
};

/// The drawn shapes of a document.
struct Drawing {
    std::vector<DrawnShape> shapes; // in document order, clip paths and masks after what they belong to
    std::vector<Reference> references;
    std::vector<Group> groups;                // each after those in it
    std::vector<pugi::xml_node> flat_circles; // without a radius, which draw nothing
};

struct WalkOptions {
    bool follow_references = true; // list what clip paths and masks hold, leave out what is not displayed
    bool boxes = false;            // list text and images too, with their boxes
    bool as_cage = false;          // divide arcs as a cage's, and leave all curves as they are drawn
    bool is_strict = false;        // fail where an attribute cannot be read; else leave it out and warn
};

/// Walks a document, which is changed on the way, without changing what it shows: every `use` becomes a
/// group with a copy, geometry and transforms that CSS gives become attributes. Where references are
/// followed, clip paths and masks needed under several transforms, or in units of several boxes, are copied.
Expected<Drawing> walk(SvgDocument& document, StyleSheets& styles, IdTable& ids, const WalkOptions& options,
                       std::vector<std::string>& warnings);

/// The box of shapes [first, end) that are of this level, after a map.
Box bounds(const std::vector<DrawnShape>& shapes, std::size_t first, std::size_t end, int level,
           const Affine2& map);

/// The properties of DrawnShape::markers, in this order.
inline constexpr std::array marker_properties{"marker-start", "marker-mid", "marker-end"};

bool has_markers(const DrawnShape& shape);

/// For each shape the box of the part that is seen, after all clipping. Empty where nothing is seen.
std::vector<Box> seen_boxes(const Drawing& drawing);

/// The box of what is painted of shapes [first, end) of this level, after a map.
Box painted_bounds(const std::vector<DrawnShape>& shapes, std::size_t first, std::size_t end, int level,
                   const Affine2& map);

/// The box of what is painted of it, strokes included (but for the tips of mitred corners), after a map.
Box painted_box(const DrawnShape& shape, const Affine2& map);

} // namespace cageform_support::detail

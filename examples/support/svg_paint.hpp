#pragma once

// What a deformed shape takes from elsewhere: gradients, patterns, and the regions of masks and filters.

#include "svg_motion.hpp"
#include "svg_walk.hpp"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cageform_examples {

namespace detail {

/// A gradient or pattern, and those it takes attributes from.
struct PaintServer {
    std::vector<pugi::xml_node> chain; // itself first
    bool is_pattern = false;
    bool of_box = true; // its place is in units of the shape's box
    Affine2 transform;  // its own
};

/// The gradientTransform by which a gradient goes where a map takes its shape.
///   local         the map in the shape's own user space
///   rest, moved   the shape's box in that space, before and after; nothing where it needs an area and has none
std::optional<Affine2> moved_gradient(const PaintServer& gradient, const Affine2& local, const Box& rest,
                                      const Box& moved);

/// Makes paint follow the shapes. Where a gradient or pattern, as it is written, would not go where the best
/// affine map of its shape takes it, the shape gets a copy of it with that map, and an id of its own. A copy
/// of a gradient refers to the original, so stops are not repeated.
class PaintFollower {
public:
    PaintFollower(SvgDocument& document, const StyleSheets& styles, IdTable& ids, double tolerance)
        : document_(document)
        , styles_(styles)
        , ids_(ids)
        , tolerance_(tolerance) {}

    /// The shape's fill and stroke.
    ///   rest, moved   the shape's box in its own user space, before and after
    void follow(const DrawnShape& shape, const Affine2& best, const Box& rest, const Box& moved);

    /// A gradient with an id of its own for an animation of a shape's fill or stroke, which then refers to it;
    /// nothing where the property has no gradient. Of a pattern there is a warning.
    std::optional<PaintServer> own_gradient(const DrawnShape& shape, const char* property);

    std::vector<std::string> warnings;

private:
    using Server = PaintServer;

    std::optional<PaintServer> find(const std::string& value);
    void follow(const DrawnShape& shape, const char* property, const std::string& value, const Affine2& local,
                const Box& rest, const Box& moved);
    std::string copy_of_pattern(const Server& pattern, const Affine2& transform, const Box& rest);
    pugi::xml_node add_copy(pugi::xml_node original);
    std::string copy_of_gradient(const Server& gradient, const Affine2& transform);
    std::string chain_text(const Server& server, const char* name) const;

    SvgDocument& document_;
    const StyleSheets& styles_;
    IdTable& ids_;
    double tolerance_;                          // in root user space
    std::map<std::string, std::string> copies_; // by what they are of, and how they were moved
    std::size_t copied_ = 0;                    // nodes
};

/// Makes the regions of masks and filters large enough for what they are about, moved; so the regions of primitives
/// in user space. Lights of a filter go where the best map of its only user takes them.
///   motions   of the shapes before, in their order
void follow_regions(SvgDocument& document, const Drawing& rest, const std::vector<Path>& moved,
                    const std::vector<Motion>& motions, std::vector<std::string>& warnings);

} // namespace detail

} // namespace cageform_examples

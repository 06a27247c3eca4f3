#pragma once

// What a deformed shape takes from elsewhere: gradients, patterns, and the regions of masks and filters.

#include "svg_motion.hpp"
#include "svg_walk.hpp"

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace cageform_examples {

namespace detail {

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

    std::vector<std::string> warnings;

private:
    struct Server;

    void follow(const DrawnShape& shape, const char* property, const std::string& value, const Affine2& local,
                const Box& rest, const Box& moved);
    std::string copy_of_pattern(const Server& pattern, const Affine2& transform, const Box& rest);
    std::string copy_of_gradient(const Server& gradient, const Affine2& transform);
    std::string chain_text(const Server& server, const char* name) const;

    SvgDocument& document_;
    const StyleSheets& styles_;
    IdTable& ids_;
    double tolerance_;                          // in root user space
    std::map<std::string, std::string> copies_; // by what they are of, and how they were moved
    std::size_t copied_ = 0;                    // nodes
};

/// Makes the regions of masks and filters large enough for what they are about, moved.
///   motions   of the shapes before, in their order
void follow_regions(SvgDocument& document, const Drawing& rest, const std::vector<Path>& moved,
                    const std::vector<Motion>& motions, std::vector<std::string>& warnings);

} // namespace detail

} // namespace cageform_examples

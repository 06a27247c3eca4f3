#pragma once

// Updates a deformed shape's references: gradients, patterns, and the regions of masks and filters.

#include "svg/motion.hpp"
#include "svg/walk.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace cageform_support::detail {

/// The gradient or pattern with this id and those it inherits from; empty if there is none.
std::vector<pugi::xml_node> server_chain(const IdTable& ids, const std::string& id);

/// The first element of a chain with stops or tile content; nothing if there is none.
pugi::xml_node content_owner(const std::vector<pugi::xml_node>& chain);

/// A gradient or pattern, and those it inherits from.
struct PaintServer {
    std::vector<pugi::xml_node> chain; // itself first
    bool is_pattern = false;
    bool of_box = true; // objectBoundingBox units
    Affine2 transform;  // its own
};

/// Makes gradients and patterns follow the shapes. If the unchanged paint server would not follow its shape's
/// best affine map, the shape gets a copy with that map. Shapes for which the same map fits share a copy. A
/// copy has all attributes resolved, and refers to another element only for stops or tile content.
class PaintFollower {
public:
    using Tracks = std::vector<AnimatedSvg::Track>;

    ///   tracks   out: transforms of the copies
    PaintFollower(SvgDocument& document, const StyleSheets& styles, IdTable& ids, double tolerance,
                  Tracks& tracks)
        : document_(document)
        , styles_(styles)
        , ids_(ids)
        , tolerance_(tolerance)
        , tracks_(tracks) {}

    /// Updates the fill and stroke of a shape.
    ///
    ///   best    its best map, #frames
    ///   rest    its box in its own user space
    ///   moved   that box, #frames
    void follow(const DrawnShape& shape, const std::vector<Affine2>& best, const Box& rest,
                const std::vector<Box>& moved);

    std::vector<std::string> warnings;

private:
    using Server = PaintServer;

    struct Copy {
        std::string id;
        std::vector<Affine2> maps; // #frames, precede the original transform
        Box tile;                  // box at rest, for patterns in objectBoundingBox units
        std::size_t track = 0;
    };

    std::optional<PaintServer> find(const std::string& value);
    void follow(const DrawnShape& shape, const char* property, const std::string& value,
                const std::vector<Affine2>& local, const Box& rest, const std::vector<Box>& moved);
    /// A copy with all own and inherited attributes, without transform and content.
    pugi::xml_node add_copy(const Server& server);
    pugi::xml_node copy_of_gradient(const Server& gradient);
    pugi::xml_node copy_of_pattern(const Server& pattern, const Box& rest);
    /// The id of a gradient that has the same stops and no other attributes.
    std::string stops_of(pugi::xml_node gradient);
    void refer(pugi::xml_node node, const std::string& id);
    bool content_is_of_box(const Server& pattern) const;
    std::string chain_text(const Server& server, const char* name) const;

    SvgDocument& document_;
    const StyleSheets& styles_;
    IdTable& ids_;
    double tolerance_; // in root user space
    Tracks& tracks_;
    std::map<std::string, std::vector<Copy>> copies_; // by the id of the original
    std::map<std::string, std::string> stops_;        // by the id of the original
};

/// The region of a mask or filter for content with this box, in user space.
Box region_in_user_space(pugi::xml_node node, const Viewport& viewport, const Box& box);

/// The box of the content of a mask or filter, in the user space of the element that refers to it.
struct MovedRegion {
    Box before;
    std::vector<Box> after; // in every frame
    /// #frames: the best map of the shapes, in root user space, without the map of an enclosing element that
    /// moves as a whole.
    std::vector<std::optional<Affine2>> maps;
    bool moved = false;
};

/// Enlarges the regions of masks, filters and filter primitives in user space to their content in all frames.
/// Light sources of a filter move by the best map of the element that uses it, if there is only one.
///
///   regions   #references of the drawing
void follow_regions(SvgDocument& document, const Drawing& rest, const std::vector<MovedRegion>& regions,
                    std::vector<AnimatedSvg::Track>& tracks, std::vector<std::string>& warnings);

} // namespace cageform_support::detail

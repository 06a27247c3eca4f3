#pragma once

// Updates a deformed shape's references: gradients, patterns, and the regions of masks and filters.

#include "svg/motion.hpp"
#include "svg/walk.hpp"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cageform_support::detail {

/// The gradient or pattern of this id, then those it takes attributes from; empty where there is none.
std::vector<pugi::xml_node> server_chain(const IdTable& ids, const std::string& id);

/// The first of a chain that has stops or a tile; nothing where none has.
pugi::xml_node content_owner(const std::vector<pugi::xml_node>& chain);

/// A gradient or pattern, and those it takes attributes from.
struct PaintServer {
    std::vector<pugi::xml_node> chain; // itself first
    bool is_pattern = false;
    bool of_box = true; // its place is in units of the shape's box
    Affine2 transform;  // its own
};

/// Makes paint follow the shapes. If an unchanged gradient or pattern would not follow its shape's best
/// affine map, the shape gets a copy of it with that map and an id of its own. Shapes for which the same
/// map is right share a copy. A copy has all attributes resolved. It refers to another element only for
/// stops or for the content of tiles.
class PaintFollower {
public:
    using Tracks = std::vector<AnimatedSvg::Track>;

    ///   tracks   gets the transforms of the copies in all frames
    PaintFollower(SvgDocument& document, const StyleSheets& styles, IdTable& ids, double tolerance,
                  Tracks& tracks)
        : document_(document)
        , styles_(styles)
        , ids_(ids)
        , tolerance_(tolerance)
        , tracks_(tracks) {}

    /// The shape's fill and stroke.
    ///   best    its best map in every frame
    ///   rest    the shape's box in its own user space
    ///   moved   that box in every frame
    void follow(const DrawnShape& shape, const std::vector<Affine2>& best, const Box& rest,
                const std::vector<Box>& moved);

    std::vector<std::string> warnings;

private:
    using Server = PaintServer;

    struct Copy {
        std::string id;
        std::vector<Affine2> maps; // in every frame, before the original's transform
        Box tile;                  // at rest, of a pattern that is in units of it
        std::size_t track = 0;
    };

    std::optional<PaintServer> find(const std::string& value);
    void follow(const DrawnShape& shape, const char* property, const std::string& value,
                const std::vector<Affine2>& local, const Box& rest, const std::vector<Box>& moved);
    /// A copy that has all that the original has or takes from others, but neither transform nor content.
    pugi::xml_node add_copy(const Server& server);
    pugi::xml_node copy_of_gradient(const Server& gradient);
    pugi::xml_node copy_of_pattern(const Server& pattern, const Box& rest);
    /// The id of a gradient that has the stops of this one and nothing else.
    std::string stops_of(pugi::xml_node gradient);
    void refer(pugi::xml_node node, const std::string& id);
    bool content_is_of_box(const Server& pattern) const;
    std::string chain_text(const Server& server, const char* name) const;

    SvgDocument& document_;
    const StyleSheets& styles_;
    IdTable& ids_;
    double tolerance_; // in root user space
    Tracks& tracks_;
    std::map<std::string, std::vector<Copy>> copies_; // by the id of what they are of
    std::map<std::string, std::string> stops_;        // by the id of the gradient that has them
};

/// The region of a mask or filter that lies about what this box holds.
Box region_in_user_space(pugi::xml_node node, const Viewport& viewport, const Box& box);

/// The box of the content that a mask or filter covers, in the user space of the element that refers to it.
struct MovedRegion {
    Box before;
    std::vector<Box> after; // in every frame
    /// In every frame: the best map of the shapes, in root user space, without the map of an element that
    /// moves as a whole.
    std::vector<std::optional<Affine2>> maps;
    bool moved = false;
};

/// Makes the regions of masks and filters large enough for what they cover in all frames. The function also
/// enlarges regions of filter primitives that are given in user space. Lights of a filter go where the best
/// map of its only user takes them.
///   regions   of the drawing's references
void follow_regions(SvgDocument& document, const Drawing& rest, const std::vector<MovedRegion>& regions,
                    std::vector<AnimatedSvg::Track>& tracks, std::vector<std::string>& warnings);

} // namespace cageform_support::detail

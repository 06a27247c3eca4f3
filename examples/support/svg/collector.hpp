#pragma once

// The state of the walk, whose functions stand in walk.cpp and references.cpp.

#include "svg/walk.hpp"

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace cageform_support::detail {

/// See walk().
class ShapeCollector {
public:
    ShapeCollector(SvgDocument& document, StyleSheets& styles, IdTable& ids, const WalkOptions& options)
        : document_(document)
        , styles_(styles)
        , ids_(ids)
        , options_(options) {}

    std::optional<FileError> collect();

    Drawing drawing;
    std::vector<std::string> warnings;

private:
    using Values = StyleSheets::Values;

    /// The properties that an element inherits from its ancestors.
    struct Place {
        Affine2 to_root;
        Viewport viewport;
        int depth = 0;
        DrawnShape style; // all but its geometry
        std::string text_anchor = "start";
        std::string colour = "black";      // that currentColor stands for
        std::string context_fill = "none"; // of the `use` that it is a copy for
        std::string context_stroke = "none";
    };

    struct Claim { // a clip path or mask whose content is deformed under this transform
        Affine2 to_root;
        std::string id;
        std::size_t first = 0, end = 0; // its shapes
        bool has_window = false;        // a clip path inside the mask replaces its region
    };

    bool fail(pugi::xml_node node, const std::string& why);
    /// Warns of what is left out, or fails where the walk is strict.
    bool leave_out(const FileError& fault);
    void warn(pugi::xml_node node, const std::string& why);
    static void inherit(const Values& values, Place& place);
    static void inherit_outline(const Values& values, DrawnShape& style);
    bool visit(pugi::xml_node node, const Place& parent);
    bool visit_children(pugi::xml_node node, const Place& place);
    /// Visits what a <switch> chooses from. Each child goes into a group, so that the paths and clip paths
    /// that it needs can stand beside it.
    bool visit_choices(pugi::xml_node node, Place place);
    /// The transform of an element. One that cannot be read is removed, since browsers take none. Returns
    /// nothing where the walk has failed.
    std::optional<Affine2> own_transform(pugi::xml_node node);

    // ---- nested svg ----
    /// A nested svg clips what it holds. One that cuts nothing no longer does; one that does becomes a
    /// group with a clip path, which is deformed. So does a symbol, whose copy `visit_use` made an svg.
    bool visit_svg(pugi::xml_node node, const Values& values, Place& place);
    /// Writes a nested svg as a group with the same map.
    static void to_group(pugi::xml_node node, const Affine2& inside);
    /// Puts what a group holds into a group inside it, that a box clips.
    bool clip(pugi::xml_node group, const Box& box, const Place& place, std::size_t first);
    /// Removes a viewBox that is not four numbers: browsers take none.
    bool drop_bad_view_box(pugi::xml_node node);
    /// Maps the element's viewBox into `viewport`, which then becomes the viewBox's size.
    bool enter_view_box(pugi::xml_node node, Affine2& to_root, Viewport& viewport);

    // ---- use (references.cpp) ----
    bool visit_use(pugi::xml_node use, const Place& parent);
    /// Returns the target of a `use`; if it cannot be used, returns nothing, with a warning or an error.
    pugi::xml_node used_element(pugi::xml_node use);
    /// In a clip path, which must not hold a group, the copy replaces the `use`.
    bool replace_use(pugi::xml_node use, pugi::xml_node target, std::string transform, const Place& parent);
    /// Makes a group of `use`, with the copy inside.
    bool use_to_group(pugi::xml_node use, pugi::xml_node target, const std::string& transform,
                      const Place& parent);
    /// Writes the paints of the `use` where a copy asks for them; returns the element's values.
    Values take_context_paint(pugi::xml_node node, const Place& place);
    /// Images in a copy become uses of one definition each, so that their bytes are not repeated.
    void share_images(pugi::xml_node copy);
    bool count_copies(pugi::xml_node top);
    /// The nodes of an element after all uses in it have become copies, or more than the limit.
    std::size_t expanded_size(pugi::xml_node top, int depth = 0);

    // ---- clip paths, masks and filters (references.cpp) ----
    bool visit_references(pugi::xml_node node, const Values& values, const Place& place, std::size_t first);
    /// Makes a clip path of a basic shape of CSS that an element is clipped by, if it is.
    bool make_clip_path(pugi::xml_node node, const Values& values, const Place& place, std::size_t first);
    bool visit_reference(const char* property, const std::string& id, const Place& place,
                         Reference& reference);
    /// Turns units of the box into user space.
    static void to_user_space(pugi::xml_node content, const char* units, const Affine2& unit_square);
    /// Visits a clip path or mask of shapes from `first` on. One that clips it in turn has their user space
    /// and box, as in browsers.
    ///   window   clips the content, if not empty
    bool visit_content(pugi::xml_node content, pugi::xml_node target, const Place& place, std::size_t first,
                       const Box& window);

    // ---- shapes ----
    double length(pugi::xml_node node, const char* name, const Viewport& viewport, double whole,
                  double otherwise);
    /// Whether a paint is not transparent.
    ///   colour   that currentColor stands for
    bool shows(std::string_view paint, const std::string& colour);
    bool has_colour(pugi::xml_node stop) const;
    /// The element's path, with warnings of what is left out of it; nothing where the walk has failed.
    std::optional<Path> path_of(pugi::xml_node node, const Place& place);
    bool add_shape(pugi::xml_node node, const Place& place);
    /// Curves whose control points lie on their ends are lines, run through at another speed.
    static void straighten(Path& path);
    bool add(pugi::xml_node node, Path path, const Place& place, bool is_box = false);
    bool add_fixed(pugi::xml_node node, const std::string& kind, Place place);
    /// The paths that a text's letters stand on, which are shapes: where one is not drawn in the text's own
    /// user space, the text gets a copy.
    bool add_text_paths(pugi::xml_node text, const Place& place);
    bool add_text_path(pugi::xml_node text_path, const Place& place);
    /// How far the letters on a path reach: they are taken to be 0.6 em wide and to stand within 0.8 em of
    /// it.
    bool add_reach(pugi::xml_node text_path, const Path& path, Place place);
    /// Whether an element is drawn where it stands, under this transform.
    bool is_drawn_under(pugi::xml_node node, const Affine2& to_root) const;
    Box image_box(pugi::xml_node node, const Place& place);
    /// Where a text is about: letters are taken to be 0.6 em wide.
    Box text_box(pugi::xml_node text, const Place& place);

    SvgDocument& document_;
    StyleSheets& styles_;
    IdTable& ids_;
    WalkOptions options_;
    std::set<std::size_t> symbols_;                              // copies of symbols, by their hash
    std::unordered_map<std::size_t, std::vector<Claim>> claims_; // by the node they were first found on
    std::vector<pugi::xml_node> active_; // used elements, clip paths and masks that we are inside of
    std::unordered_map<std::string, pugi::xml_node> images_;         // definitions, by what they show
    std::unordered_map<std::size_t, pugi::xml_node> uses_of_images_; // definitions, by the hash of their use
    double most_ = 0; // coordinate: beyond it rounding shows in the picture
    std::size_t copies_ = 0;
    std::unordered_map<std::size_t, std::size_t> expanded_sizes_; // by the element's hash
    std::unordered_map<std::size_t, bool> paints_; // whether gradients are visible, by the hash of the node
    std::unordered_set<std::string> left_out_;     // the warnings of leave_out()
    std::optional<FileError> error_;
};

} // namespace cageform_support::detail

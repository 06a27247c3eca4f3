#pragma once

// State of walk(), implemented in walk.cpp and references.cpp.

#include "svg/walk.hpp"

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

    /// Properties that an element inherits.
    struct Place {
        Affine2 to_root;
        Viewport viewport;
        int depth = 0;
        DrawnShape style; // without geometry
        std::string text_anchor = "start";
        std::string colour = "black";      // currentColor
        std::string context_fill = "none"; // of the enclosing `use`
        std::string context_stroke = "none";
    };

    struct ContentInUse { // a clip path or mask in use under a transform
        Affine2 to_root;
        std::string id;
        std::size_t first = 0, end = 0; // its shapes
        bool region_clips = false;      // the mask's region was replaced by a clip path
    };

    bool fail(pugi::xml_node node, const std::string& why);
    /// Adds a warning; in a strict walk, fails.
    bool leave_out(const FileError& fault);
    void warn(pugi::xml_node node, const std::string& why);
    static void inherit(const Values& values, Place& place);
    static void inherit_outline(const Values& values, DrawnShape& style);
    bool visit(pugi::xml_node node, const Place& parent);
    bool visit_children(pugi::xml_node node, const Place& place);
    /// Visits the alternatives of a <switch>. Each child gets its own group, so that paths and clip paths can
    /// be added beside it.
    bool visit_choices(pugi::xml_node node, Place place);
    /// The transform of an element. An invalid transform is removed, as browsers ignore it. Returns nothing
    /// if the walk failed.
    std::optional<Affine2> own_transform(pugi::xml_node node);

    // A nested svg clips its content. If it clips nothing visible, clipping is switched off. Otherwise it
    // becomes a group with a clip path, which is deformed. Symbols, which visit_use() turns into svg
    // elements, are treated alike.
    bool visit_svg(pugi::xml_node node, const Values& values, Place& place);
    /// Converts a nested svg to a group with the same map.
    static void to_group(pugi::xml_node node, const Affine2& inside);
    /// Moves the content of a group into an inner group that is clipped by a box.
    bool clip(pugi::xml_node group, const Box& box, const Place& place, std::size_t first);
    /// Removes an invalid viewBox, which browsers ignore.
    bool drop_bad_view_box(pugi::xml_node node);
    /// Maps the element's viewBox to `viewport`, and sets `viewport` to the size of the viewBox.
    bool enter_view_box(pugi::xml_node node, Affine2& to_root, Viewport& viewport);

    // ---- use (references.cpp) ----
    bool visit_use(pugi::xml_node use, const Place& parent);
    /// Returns the target of a `use`; nothing, with a warning or an error, if the target cannot be used.
    pugi::xml_node used_element(pugi::xml_node use);
    /// Replaces a `use` in a clip path by a copy of the target, since a clip path may not contain groups.
    bool replace_use(pugi::xml_node use, pugi::xml_node target, std::string transform, const Place& parent);
    /// Turns a `use` into a group that contains a copy of the target.
    bool use_to_group(pugi::xml_node use, pugi::xml_node target, const std::string& transform,
                      const Place& parent);
    /// Resolves context-fill and context-stroke; returns the element's values.
    Values resolve_context_paint(pugi::xml_node node, const Place& place);
    /// Replaces images in a copy by uses of a shared definition, so that their data is not repeated.
    void share_images(pugi::xml_node copy);
    bool count_copies(pugi::xml_node top);
    /// Number of nodes of an element with all uses expanded; counting stops above max_svg_copies.
    std::size_t expanded_size(pugi::xml_node top, int depth = 0);

    // ---- clip paths, masks and filters (references.cpp) ----
    bool visit_references(pugi::xml_node node, const Values& values, const Place& place, std::size_t first);
    /// Converts a CSS basic shape in clip-path to a clipPath element; false if there is none.
    bool make_clip_path(pugi::xml_node node, const Values& values, const Place& place, std::size_t first);
    bool visit_reference(const char* property, const std::string& id, const Place& place,
                         Reference& reference);
    /// Converts objectBoundingBox units to user space.
    static void to_user_space(pugi::xml_node content, const char* units, const Affine2& unit_square);
    /// Visits the clip path or mask of the shapes from `first` on. A clip path of the clip path uses the same
    /// user space and box, as in browsers.
    ///
    ///   window   clips the content, if not empty
    bool visit_content(pugi::xml_node content, pugi::xml_node target, const Place& place, std::size_t first,
                       const Box& window);

    // ---- shapes ----
    double length(pugi::xml_node node, const char* name, const Viewport& viewport, double whole,
                  double otherwise);
    /// Whether a paint is visible.
    ///
    ///   colour   currentColor
    bool shows(std::string_view paint, const std::string& colour);
    bool has_colour(pugi::xml_node stop) const;
    /// The element's path, with warnings for invalid parts; nothing if the walk failed.
    std::optional<Path> path_of(pugi::xml_node node, const Place& place);
    bool add_shape(pugi::xml_node node, const Place& place);
    /// Converts curves whose control points coincide with their ends to lines.
    static void straighten(Path& path);
    bool add(pugi::xml_node node, Path path, const Place& place, bool is_box = false);
    bool add_fixed(pugi::xml_node node, const std::string& kind, Place place);
    /// Adds the paths that the letters of a text follow. A path in another user space than the text is
    /// copied.
    bool add_text_paths(pugi::xml_node text, const Place& place);
    bool add_text_path(pugi::xml_node text_path, const Place& place);
    /// Adds the extent of letters on a path: 0.6 em per letter along the path, 0.8 em on both sides.
    bool add_reach(pugi::xml_node text_path, const Path& path, Place place);
    /// Whether an element is drawn where it stands, not by a `use`, with this transform and without filter.
    bool is_drawn_under(pugi::xml_node node, const Affine2& to_root) const;
    Box image_box(pugi::xml_node node, const Place& place);
    /// Estimated box of a text: 0.6 em per letter.
    Box text_box(pugi::xml_node text, const Place& place);

    SvgDocument& document_;
    StyleSheets& styles_;
    IdTable& ids_;
    WalkOptions options_;
    std::set<std::size_t> symbols_; // copies of symbols, by their hash
    std::unordered_map<std::size_t, std::vector<ContentInUse>>
        contents_in_use_;                                    // by the hash of the original node
    std::vector<pugi::xml_node> active_;                     // enclosing use targets, clip paths and masks
    std::unordered_map<std::string, pugi::xml_node> images_; // definitions, by position and data
    std::unordered_map<std::size_t, pugi::xml_node> uses_of_images_; // definitions, by the hash of their use
    double most_ = 0; // largest coordinate without visible rounding errors
    std::size_t copies_ = 0;
    std::unordered_map<std::size_t, std::size_t> expanded_sizes_; // by the element's hash
    std::unordered_map<std::size_t, bool> paints_; // visibility of gradients, by the hash of the node
    std::unordered_set<std::string> left_out_;     // the warnings of leave_out()
    std::optional<FileError> error_;
};

} // namespace cageform_support::detail

#include "svg_walk.hpp"

#include "svg_curves.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace cageform_examples {

namespace detail {

constexpr std::size_t max_svg_copies = 1'000'000; // nodes copied for `use` and shared clip paths

/// See walk().
class ShapeCollector {
public:
    ShapeCollector(SvgDocument& document, const StyleSheets& styles, IdTable& ids, const WalkOptions& options)
        : document_(document)
        , styles_(styles)
        , ids_(ids)
        , options_(options) {}

    std::optional<SvgError> collect() {
        const pugi::xml_node root = root_element(document_.xml);
        const auto view = view_box(document_);
        if (!view) return view.error();
        Place place;
        place.viewport = {view->width, view->height};
        const Values values = styles_.values(root);
        inherit(values, place);
        if (visit_children(root, place)) visit_references(root, values, place, 0);
        return error_;
    }

    Drawing drawing;
    std::vector<std::string> warnings;

private:
    using Values = std::map<std::string, StyleValue, std::less<>>;

    /// What an element takes from those it stands in.
    struct Place {
        Affine2 to_root;
        Viewport viewport;
        int depth = 0;
        DrawnShape style; // all but its geometry
        double font_size = 16;
        std::string text_anchor = "start";
    };

    struct Claim { // a clip path or mask whose content is deformed under this transform
        Affine2 to_root;
        std::string id;
        std::size_t first = 0, end = 0; // its shapes
    };

    bool fail(pugi::xml_node node, const std::string& why) {
        if (!error_) error_ = error_at(document_, node, why);
        return false;
    }

    bool fail_in(pugi::xml_node node, const std::string& attribute, const SvgError& error) {
        if (!error_) error_ = error_in(document_, node, attribute, error);
        return false;
    }

    void warn(pugi::xml_node node, const std::string& why) {
        warnings.push_back(label(document_, node) + ": " + why);
    }

    static std::string text_of(const Values& values, std::string_view property) {
        const auto found = values.find(property);
        return found == values.end() || found->second.text == "inherit" ? std::string() : found->second.text;
    }

    static void inherit(const Values& values, Place& place) {
        const auto take = [&](std::string_view property, std::string& to) {
            const std::string text = text_of(values, property);
            if (!text.empty()) to = text.size() < 1000 ? text : "black"; // every shape has a copy
        };
        take("fill", place.style.fill);
        take("stroke", place.style.stroke);
        take("text-anchor", place.text_anchor);
        const auto take_marker = [&](std::string_view property, bool& set) {
            const std::string text = text_of(values, property);
            if (!text.empty()) set = !referenced_id(text).empty();
        };
        take_marker("marker", place.style.marks_vertices);
        take_marker("marker", place.style.marks_ends);
        take_marker("marker-mid", place.style.marks_vertices);
        take_marker("marker-start", place.style.marks_ends);
        take_marker("marker-end", place.style.marks_ends);
        const double diagonal = place.viewport.diagonal();
        const auto stroke = parse_length(text_of(values, "stroke-width"), diagonal);
        if (stroke && *stroke >= 0) place.style.stroke_width = *stroke;
        const auto font = parse_length(text_of(values, "font-size"), place.font_size);
        if (font && *font > 0) place.font_size = *font;
    }

    bool visit(pugi::xml_node node, const Place& parent) {
        const std::string kind = local_name(node);
        if (parent.depth >= max_svg_depth) return fail(node, "elements are nested too deeply");
        if (kind == "use") return visit_use(node, parent);
        if (!is_group(kind) && !is_shape(kind) && !is_fixed(kind)) return true;

        // Pages and hidden layers need not lie in the cage. To be read (a cage, say) a shape may be hidden.
        const Values values = styles_.values(node);
        if (options_.follow_references && text_of(values, "display") == "none") {
            warn(node, "is not displayed and stays as it is");
            return true;
        }
        Place place = parent;
        ++place.depth;
        inherit(values, place);
        if (!apply_transform(node, values, place.to_root)) return false;
        const std::size_t first = drawing.shapes.size();
        const bool good = is_shape(kind)   ? add_shape(node, place)
                          : is_fixed(kind) ? add_fixed(node, kind, place)
                          : kind == "svg"  ? visit_svg(node, values, place)
                                           : visit_children(node, place);
        return good && visit_references(node, values, place, first);
    }

    bool visit_children(pugi::xml_node node, const Place& place) {
        for (pugi::xml_node child = node.first_child(); child;) {
            const pugi::xml_node next = child.next_sibling();
            if (!visit(child, place)) return false;
            child = next;
        }
        return true;
    }

    bool apply_transform(pugi::xml_node node, const Values& values, Affine2& to_root) {
        const auto map = parse_transform(attribute_text(node, "transform"));
        if (!map) return fail_in(node, "transform", map.error());
        to_root = compose(to_root, *map);
        if (!text_of(values, "transform").empty()) warn(node, "a transform in a style is not read");
        return true;
    }

    // ---- nested svg ----

    /// A nested svg clips what it holds. One that cuts nothing no longer does; one that does becomes a group
    /// with a clip path, which is deformed. So does a symbol, whose copy `visit_use` made an svg.
    bool visit_svg(pugi::xml_node node, const Values& values, Place& place) {
        const Viewport outer = place.viewport;
        const double x = length(node, "x", outer.width, 0);
        const double y = length(node, "y", outer.height, 0);
        const Viewport size{length(node, "width", outer.width, outer.width),
                            length(node, "height", outer.height, outer.height)};
        Affine2 inside{1, 0, 0, 1, x, y};
        place.viewport = size;
        if (!enter_view_box(node, inside, place.viewport)) return false;
        place.to_root = compose(place.to_root, inside);
        const std::size_t first = drawing.shapes.size();
        if (error_ || !visit_children(node, place)) return false;
        if (!options_.follow_references && symbols_.count(node.hash_value()) == 0) return true;

        const std::string overflow = text_of(values, "overflow");
        const bool clips = overflow != "visible" && overflow != "auto";
        const auto to_inside = inverse(inside);
        const auto from_root = inverse(place.to_root);
        bool cuts = false;
        Box window;
        if (options_.follow_references && clips && to_inside && from_root) {
            for (const Point2& p : Box{x, y, x + size.width, y + size.height}.corners()) {
                window.add(apply(*to_inside, p));
            }
            Box content;
            for (std::size_t i = first; i < drawing.shapes.size(); ++i) {
                const DrawnShape& shape = drawing.shapes[i];
                if (shape.level == place.style.level) content.add(painted_box(shape, *from_root));
            }
            cuts = !window.grown(1e-9 * (window.width() + window.height())).contains(content);
        }
        if (!cuts && symbols_.count(node.hash_value()) == 0) {
            if (clips) styles_.set(node, "overflow", "visible");
            return true;
        }
        to_group(node, inside);
        return !cuts || clip(node, window, place, first);
    }

    /// Writes a nested svg as a group with the same map.
    static void to_group(pugi::xml_node node, const Affine2& inside) {
        std::string transform = node.attribute("transform").value();
        if (!(inside == Affine2())) {
            transform += (transform.empty() ? "" : " ") + write_transform(inside, 17);
            set_attribute(node, "transform", transform);
        }
        for (const char* name :
             {"viewBox", "preserveAspectRatio", "x", "y", "width", "height", "refX", "refY", "overflow"}) {
            node.remove_attribute(name);
        }
        node.set_name((name_prefix(node) + 'g').c_str());
    }

    /// Puts what a group holds into a group inside it, that a box clips.
    bool clip(pugi::xml_node group, const Box& box, const Place& place, std::size_t first) {
        const std::string prefix = name_prefix(group);
        pugi::xml_node inner = group.append_child((prefix + 'g').c_str());
        while (group.first_child() != inner) inner.append_move(group.first_child());
        pugi::xml_node clip_path = group.prepend_child((prefix + "clipPath").c_str());
        const std::string id = ids_.name(clip_path, "cageform-clip");
        pugi::xml_node rect = clip_path.append_child((prefix + "rect").c_str());
        set_attribute(rect, "x", format_number(box.x0, 17));
        set_attribute(rect, "y", format_number(box.y0, 17));
        set_attribute(rect, "width", format_number(box.width(), 17));
        set_attribute(rect, "height", format_number(box.height(), 17));
        set_attribute(inner, "clip-path", "url(#" + escaped(id) + ')');
        return visit_references(inner, styles_.values(inner), place, first);
    }

    /// Maps the element's viewBox into `viewport`, which then becomes the viewBox's size.
    bool enter_view_box(pugi::xml_node node, Affine2& to_root, Viewport& viewport) {
        if (!node.attribute("viewBox")) return true;
        const auto v = parse_numbers(attribute_text(node, "viewBox"));
        if (!v || v->size() != 4) return fail(node, "viewBox is not four numbers");
        const Viewport box{(*v)[2], (*v)[3]};
        if (!(box.width > 0 && box.height > 0)) return true; // nothing is drawn, so nothing matters
        double sx = viewport.width / box.width;
        double sy = viewport.height / box.height;
        const std::string fit = attribute_text(node, "preserveAspectRatio");
        const auto says = [&](std::string_view word) { return fit.find(word) != std::string::npos; };
        if (!says("none")) sx = sy = says("slice") ? std::max(sx, sy) : std::min(sx, sy);
        const double along_x = says("xMin") ? 0 : says("xMax") ? 1 : 0.5;
        const double along_y = says("YMin") ? 0 : says("YMax") ? 1 : 0.5;
        const double x = (viewport.width - sx * box.width) * along_x - sx * (*v)[0];
        const double y = (viewport.height - sy * box.height) * along_y - sy * (*v)[1];
        to_root = compose(to_root, {sx, 0, 0, sy, x, y});
        viewport = box;
        return true;
    }

    // ---- use ----

    bool visit_use(pugi::xml_node use, const Place& parent) {
        const std::string reference = reference_of(use);
        const pugi::xml_node target =
            reference.starts_with('#') ? ids_.find(reference.substr(1)) : pugi::xml_node();
        if (!target) {
            warn(use, "refers to nothing in this file (\"" + reference + "\") and stays as it is");
            return true;
        }
        const std::string kind = local_name(target);
        bool cyclic = std::find(active_.begin(), active_.end(), target) != active_.end();
        for (pugi::xml_node node = use; node; node = node.parent()) cyclic = cyclic || node == target;
        if (cyclic) return fail(use, "uses itself through \"" + reference + '"');

        const bool flat = local_name(use.parent()) == "clipPath"; // which may hold no group
        const bool usable = is_shape(kind) || is_fixed(kind) ||
                            (!flat && (is_group(kind) || kind == "use" || kind == "symbol"));
        const bool has_content = std::any_of(use.begin(), use.end(), [](pugi::xml_node child) {
            const std::string name = local_name(child);
            return is_shape(name) || is_fixed(name) || is_group(name) || name == "use";
        });
        if (!usable || has_content) {
            warn(use, "cannot be expanded and stays as it is");
            return true;
        }
        if (!count_copies(target)) return fail(use, "the uses of this file expand to too much");

        const double x = length(use, "x", parent.viewport.width, 0);
        const double y = length(use, "y", parent.viewport.height, 0);
        std::string transform = use.attribute("transform").value();
        if (x != 0 || y != 0) {
            transform += transform.empty() ? "" : " ";
            transform += "translate(" + format_number(x, 17) + ' ' + format_number(y, 17) + ')';
        }
        const std::string width = use.attribute("width").value();
        const std::string height = use.attribute("height").value();
        std::vector<std::string> dropped = {"x", "y", "width", "height", "href"};
        for (const pugi::xml_attribute attribute : use.attributes()) {
            if (std::string_view(attribute.name()).ends_with(":href")) dropped.emplace_back(attribute.name());
        }
        for (const std::string& name : dropped) use.remove_attribute(name.c_str());

        if (flat) {
            pugi::xml_node copy = use.parent().insert_copy_after(target, use);
            drop_ids(copy);
            transform += std::string(transform.empty() ? "" : " ") + copy.attribute("transform").value();
            for (const pugi::xml_attribute attribute : use.attributes()) {
                if (!copy.attribute(attribute.name())) copy.append_copy(attribute);
            }
            if (!transform.empty()) set_attribute(copy, "transform", transform);
            if (use.attribute("id")) ids_.move(attribute_text(use, "id"), copy);
            use.parent().remove_child(use);
            return visit(copy, parent);
        }

        if (!transform.empty()) set_attribute(use, "transform", transform);
        use.set_name((name_prefix(use) + 'g').c_str());
        pugi::xml_node copy = use.append_copy(target);
        drop_ids(copy);
        if (kind == "svg" || kind == "symbol") {
            if (!width.empty()) set_attribute(copy, "width", width);
            if (!height.empty()) set_attribute(copy, "height", height);
        }
        if (kind == "symbol") {
            for (const char* name : {"x", "y", "refX", "refY"}) copy.remove_attribute(name);
            copy.set_name((name_prefix(copy) + "svg").c_str());
            symbols_.insert(copy.hash_value());
        }
        active_.push_back(target);
        const bool good = visit(use, parent);
        active_.pop_back();
        return good;
    }

    bool count_copies(pugi::xml_node top) {
        for (pugi::xml_node node = top; node; node = next_node(node, top)) ++copies_;
        return copies_ <= max_svg_copies;
    }

    static void drop_ids(pugi::xml_node top) {
        for (pugi::xml_node node = top; node; node = next_node(node, top)) node.remove_attribute("id");
    }

    // ---- clip paths, masks and filters ----

    bool visit_references(pugi::xml_node node, const Values& values, const Place& place, std::size_t first) {
        if (!options_.follow_references) return true;
        const std::size_t end = drawing.shapes.size();
        const auto good = [&](const char* property, const char* kind) {
            const std::string id = referenced_id(text_of(values, property));
            const pugi::xml_node target = id.empty() ? pugi::xml_node() : ids_.find(id);
            if (!target || local_name(target) != kind) return true;
            const auto from_root = inverse(place.to_root);
            if (!from_root) return true; // nothing of it is drawn
            Reference reference{node,  target, place.to_root, *from_root, place.viewport, place.style.level,
                                first, end};
            if (kind != std::string_view("filter") && !visit_reference(property, id, place, reference)) {
                return false;
            }
            drawing.references.push_back(reference);
            return true;
        };
        return good("clip-path", "clipPath") && good("mask", "mask") && good("filter", "filter");
    }

    bool visit_reference(const char* property, const std::string& id, const Place& place,
                         Reference& reference) {
        pugi::xml_node target = reference.target;
        if (std::find(active_.begin(), active_.end(), target) != active_.end()) {
            return fail(reference.node, "refers to itself through \"#" + id + '"');
        }
        const bool clip = local_name(target) == "clipPath";
        const char* const units = clip ? "clipPathUnits" : "maskContentUnits";
        const bool of_box = attribute_text(target, units) == "objectBoundingBox";
        Affine2 to_root = place.to_root;
        Affine2 unit_square;
        if (of_box) {
            const Box box =
                bounds(drawing.shapes, reference.first, reference.end, reference.level, reference.from_root);
            if (box.empty() || !(box.width() > 0 && box.height() > 0)) return true; // nothing is drawn
            unit_square = {box.width(), 0, 0, box.height(), box.x0, box.y0};
            to_root = compose(to_root, unit_square);
        }
        std::vector<Claim>& claims = claims_[target.hash_value()];
        auto claim =
            std::find_if(claims.begin(), claims.end(), [&](const Claim& c) { return c.to_root == to_root; });
        if (claim == claims.end()) {
            pugi::xml_node content = target;
            std::string content_id = id;
            if (!claims.empty() || of_box) {
                if (!count_copies(target)) {
                    return fail(reference.node, "the clip paths of this file expand to too much");
                }
                content = target.parent().insert_copy_after(target, target);
                drop_ids(content);
                content_id = ids_.name(content, id);
            }
            if (of_box) to_user_space(content, units, unit_square);
            claims.push_back({to_root, content_id, drawing.shapes.size(), 0});
            const std::size_t index = claims.size() - 1;
            if (!visit_content(content, target, place)) return false;
            std::vector<Claim>& grown = claims_[target.hash_value()];
            grown[index].end = drawing.shapes.size();
            claim = grown.begin() + static_cast<std::ptrdiff_t>(index);
        }
        reference.first_inside = claim->first;
        reference.end_inside = claim->end;
        reference.target = ids_.find(claim->id);
        if (claim->id != id) {
            const std::string value = styles_.value(reference.node, property).text;
            styles_.set(reference.node, property, with_referenced_id(value, claim->id));
        }
        return true;
    }

    /// Turns units of the box into user space.
    static void to_user_space(pugi::xml_node content, const char* units, const Affine2& unit_square) {
        set_attribute(content, units, "userSpaceOnUse");
        const std::string map = write_transform(unit_square, 17);
        if (local_name(content) == "clipPath") {
            const std::string own = content.attribute("transform").value();
            return set_attribute(content, "transform", own.empty() ? map : map + ' ' + own);
        }
        pugi::xml_node group = content.append_child((name_prefix(content) + 'g').c_str());
        while (content.first_child() != group) group.append_move(content.first_child());
        set_attribute(group, "transform", map);
    }

    bool visit_content(pugi::xml_node content, pugi::xml_node target, const Place& place) {
        Place inner;
        inner.to_root = place.to_root;
        inner.viewport = place.viewport;
        inner.depth = place.depth + 1;
        if (inner.depth >= max_svg_depth) return fail(content, "elements are nested too deeply");
        std::vector<pugi::xml_node> line;
        for (pugi::xml_node up = content; up.type() == pugi::node_element; up = up.parent())
            line.push_back(up);
        for (auto up = line.rbegin(); up != line.rend(); ++up) inherit(styles_.values(*up), inner);
        inner.style.level = place.style.level + 1;
        const bool clip = local_name(content) == "clipPath";
        inner.style.clips = place.style.clips || clip;
        const Values values = styles_.values(content);
        if (clip && !apply_transform(content, values, inner.to_root)) return false;
        active_.push_back(target);
        const std::size_t first = drawing.shapes.size();
        const bool good = visit_children(content, inner) && visit_references(content, values, inner, first);
        active_.pop_back();
        return good;
    }

    // ---- shapes ----

    double length(pugi::xml_node node, const char* name, double whole, double otherwise) {
        const auto value = length_of(document_, node, name, whole, otherwise);
        if (value) return *value;
        if (!error_) error_ = value.error();
        return otherwise;
    }

    bool add_shape(pugi::xml_node node, const Place& place) {
        auto path = shape_path(document_, node, place.viewport);
        if (!path) {
            error_ = path.error();
            return false;
        }
        return path->empty() || add(node, std::move(*path), place);
    }

    /// Curves whose control points lie on their ends are lines, run through at another speed.
    static void straighten(Path& path) {
        for (Subpath& subpath : path) {
            Point2 from = subpath.start;
            for (Segment& s : subpath.segments) {
                const Point2 to = s.p3;
                const double near = 1e-6 * std::hypot(to.x - from.x, to.y - from.y);
                const bool stops = std::hypot(s.p1.x - from.x, s.p1.y - from.y) <= near &&
                                   std::hypot(s.p2.x - to.x, s.p2.y - to.y) <= near;
                if (!s.is_line && stops && near > 0) {
                    PathBuilder line;
                    line.move_to(from);
                    line.line_to(to);
                    s = line.take().front().segments.front();
                }
                from = to;
            }
        }
    }

    bool add(pugi::xml_node node, Path path, const Place& place, bool is_box = false) {
        straighten(path);
        const std::optional<Affine2> from_root = inverse(place.to_root);
        if (!from_root) {
            warn(node, "has a transform without inverse and stays as it is");
            return true;
        }
        DrawnShape shape = place.style;
        shape.node = node;
        shape.to_root = place.to_root;
        shape.from_root = *from_root;
        shape.is_box = is_box;
        shape.path = transformed(std::move(path), place.to_root);
        if (!in_range(shape.path)) return fail(node, "coordinates out of range");
        drawing.shapes.push_back(std::move(shape));
        return true;
    }

    bool add_fixed(pugi::xml_node node, const std::string& kind, const Place& place) {
        const Box box = options_.boxes && !place.style.clips
                            ? (kind == "text" ? text_box(node, place) : image_box(node, place))
                            : Box();
        if (error_) return false;
        if (box.empty() && kind == "text" && is_blank(node.text().get()) && !node.child("tspan")) return true;
        if (box.empty()) {
            warn(node, "cannot be deformed and stays as it is");
            return true;
        }
        warn(node, kind == "text" ? "keeps its letters, and moves and turns as a whole"
                                  : "is not bent, and moves and turns as a whole");
        PathBuilder outline;
        outline.move_to({box.x0, box.y0});
        for (const Point2& p : box.corners()) {
            if (!(p == outline.current())) outline.line_to(p);
        }
        outline.close();
        return add(node, outline.take(), place, true);
    }

    Box image_box(pugi::xml_node node, const Place& place) {
        const double x = length(node, "x", place.viewport.width, 0);
        const double y = length(node, "y", place.viewport.height, 0);
        const double width = length(node, "width", place.viewport.width, 0);
        const double height = length(node, "height", place.viewport.height, 0);
        return width > 0 && height > 0 ? Box{x, y, x + width, y + height} : Box();
    }

    /// Where a text is about: letters are taken to be 0.6 em wide.
    Box text_box(pugi::xml_node text, const Place& place) {
        Box box;
        Point2 at;
        double size = place.font_size;
        for (pugi::xml_node node = text; node; node = next_node(node, text)) {
            if (node.type() == pugi::node_element) {
                const auto x = parse_numbers(attribute_text(node, "x"));
                const auto y = parse_numbers(attribute_text(node, "y"));
                const auto font = parse_length(styles_.value(node, "font-size").text, place.font_size);
                if (x && !x->empty()) at.x = x->front();
                if (y && !y->empty()) at.y = y->front();
                if (font && *font > 0) size = *font;
                continue;
            }
            const std::string letters = unescaped(trimmed(node.value()));
            if (letters.empty()) continue;
            const double width = 0.6 * size * static_cast<double>(letters.size());
            const double left = place.text_anchor == "end"      ? at.x - width
                                : place.text_anchor == "middle" ? at.x - width / 2
                                                                : at.x;
            box.add(Box{left, at.y - 0.8 * size, left + width, at.y + 0.2 * size});
            at.x += width;
        }
        return box;
    }

    SvgDocument& document_;
    const StyleSheets& styles_;
    IdTable& ids_;
    WalkOptions options_;
    std::set<std::size_t> symbols_;                              // copies of symbols, by their hash
    std::unordered_map<std::size_t, std::vector<Claim>> claims_; // by the node they were first found on
    std::vector<pugi::xml_node> active_; // used elements, clip paths and masks that we are inside of
    std::size_t copies_ = 0;
    std::optional<SvgError> error_;
};

SvgResult<Drawing> walk(SvgDocument& document, const StyleSheets& styles, IdTable& ids,
                        const WalkOptions& options, std::vector<std::string>& warnings) {
    ShapeCollector collector(document, styles, ids, options);
    if (std::optional<SvgError> error = collector.collect()) return *error;
    warnings.insert(warnings.end(), collector.warnings.begin(), collector.warnings.end());
    return std::move(collector.drawing);
}

SvgResult<std::vector<DrawnShape>> drawn_shapes(SvgDocument& document, std::vector<std::string>& warnings) {
    const StyleSheets styles(root_element(document.xml));
    IdTable ids(root_element(document.xml));
    auto drawing = walk(document, styles, ids, {}, warnings);
    if (!drawing) return drawing.error();
    return std::move(drawing->shapes);
}

Box bounds(const std::vector<DrawnShape>& shapes, std::size_t first, std::size_t end, int level,
           const Affine2& map) {
    Box box;
    for (std::size_t i = first; i < end; ++i) {
        if (shapes[i].level == level) box.add(bounds(shapes[i].path, map));
    }
    return box;
}

bool is_painted(const DrawnShape& shape) {
    return shape.is_box || shape.fill != "none" || shape.stroke != "none";
}

Box painted_box(const DrawnShape& shape, const Affine2& map) {
    if (!is_painted(shape)) return {};
    const Box box = bounds(shape.path, map);
    const double width = shape.stroke == "none" ? 0 : shape.stroke_width;
    return box.empty() ? box : box.grown(width / 2 * largest_scale(compose(map, shape.to_root)));
}

} // namespace detail

} // namespace cageform_examples

#include "svg/collector.hpp"
#include "svg/css_colour.hpp"
#include "svg/css_geometry.hpp"
#include "svg/curves.hpp"
#include "svg/paint.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cageform_support::detail {

std::optional<FileError> ShapeCollector::collect() {
    const pugi::xml_node root = root_element(document_.xml);
    if (!drop_bad_view_box(root)) return error_;
    const auto view = view_box(document_);
    most_ = 0x1p35 * std::hypot(view.width, view.height);
    Place place;
    place.viewport.width = view.width;
    place.viewport.height = view.height;
    const Values values = styles_.values(root);
    inherit(values, place);
    place.viewport.root_em = place.viewport.em;
    if (visit_children(root, place)) visit_references(root, values, place, 0);
    return error_;
}

bool ShapeCollector::fail(pugi::xml_node node, const std::string& why) {
    if (!error_) error_ = error_at(document_, node, why);
    return false;
}

bool ShapeCollector::leave_out(const FileError& fault) {
    if (options_.is_strict) {
        if (!error_) error_ = fault;
        return false;
    }
    const std::string text = to_string(fault) + "; the faulty part is ignored, as in browsers";
    if (left_out_.insert(text).second) warnings.push_back(text);
    return true;
}

void ShapeCollector::warn(pugi::xml_node node, const std::string& why) {
    warnings.push_back(label(document_, node) + ": " + why);
}

void ShapeCollector::inherit(const Values& values, Place& place) {
    const auto take = [&](std::string_view property, std::string& to) {
        const std::string text = text_of(values, property);
        if (text.empty()) return;
        to = lowered(text) == "none" ? "none"
             : text.size() < 1000    ? text
                                     : "black"; // long values are not copied to each shape
    };
    take("fill", place.style.fill);
    take("stroke", place.style.stroke);
    if (lowered(text_of(values, "color")) != "currentcolor") take("color", place.colour);
    take("text-anchor", place.text_anchor);
    for (std::size_t k = 0; k < marker_properties.size(); ++k) {
        for (const char* property : {"marker", marker_properties[k]}) {
            const std::string text = text_of(values, property);
            if (!text.empty()) place.style.markers[k] = referenced_id(text);
        }
    }
    Viewport& view = place.viewport;
    view.em = font_size(values, view);
    const auto stroke = parse_length(text_of(values, "stroke-width"), view.diagonal(), view.em, view.root_em);
    if (stroke && *stroke >= 0) place.style.stroke_width = *stroke;
    inherit_outline(values, place.style);
}

void ShapeCollector::inherit_outline(const Values& values, DrawnShape& style) {
    const auto take = [&](std::string_view property, std::string_view word, bool& is) {
        const std::string text = text_of(values, property);
        if (!text.empty()) is = lowered(text) == word;
    };
    take("fill-rule", "evenodd", style.even_odd);
    take("stroke-linecap", "square", style.has_square_caps);
    take("visibility", "visible", style.is_visible);
    const std::string dashes = text_of(values, "stroke-dasharray");
    if (!dashes.empty()) style.has_dashes = dashes != "none";
    const std::string join = text_of(values, "stroke-linejoin");
    if (!join.empty()) style.has_miters = join != "round" && join != "bevel";
    const auto limit = parse_length(text_of(values, "stroke-miterlimit"), 1);
    if (limit && *limit >= 1) style.miter_limit = *limit;
    const auto opacity = [&](std::string_view property) {
        return parse_length(text_of(values, property), 1);
    };
    if (const auto value = opacity("fill-opacity")) style.fill_opacity = *value;
    if (const auto value = opacity("stroke-opacity")) style.stroke_opacity = *value;
    if (const auto value = opacity("opacity"); value && *value <= 0)
        style.is_transparent = true; // descendants too
}

bool ShapeCollector::visit(pugi::xml_node node, const Place& parent) {
    const bool is_shared_image = uses_of_images_.count(node.hash_value()) != 0;
    const std::string kind = is_shared_image ? "image" : local_name(node);
    if (parent.depth >= max_svg_depth) return fail(node, "elements are nested too deeply");
    if (StyleSheets::is_marked_unmoved(node))
        return !options_.is_strict || fail(node, "its geometry or transform is not read");
    if (kind == "use") return visit_use(node, parent);
    if (!is_group(kind) && !is_shape(kind) && !is_fixed(kind)) return true;
    const std::string_view extensions = trimmed(node.attribute("requiredExtensions").value());
    const bool known = extensions.empty() || extensions == "http://www.w3.org/1999/xhtml" ||
                       extensions == "http://www.w3.org/1998/Math/MathML";
    if (!known) return true; // not drawn by any renderer

    // Hidden layers and pages may lie outside the cage. Without follow_references, hidden shapes count.
    const Values values = resolve_context_paint(node, parent);
    if (options_.follow_references && text_of(values, "display") == "none") {
        warn(node, "is not displayed and stays unchanged");
        return true;
    }
    Place place = parent;
    ++place.depth;
    inherit(values, place);
    const auto own = own_transform(node);
    if (!own) return false;
    place.to_root = compose(place.to_root, *own);
    const std::size_t first = drawing.shapes.size();
    const bool good = is_shape(kind)   ? add_shape(node, place)
                      : is_fixed(kind) ? add_fixed(node, kind, place)
                      : kind == "svg"  ? visit_svg(node, values, place)
                                       : visit_children(node, place);
    if (is_group(kind) && kind != "svg")
        drawing.groups.push_back({node, place.to_root, first, drawing.shapes.size()});
    return good && visit_references(node, values, place, first);
}

bool ShapeCollector::visit_children(pugi::xml_node node, const Place& place) {
    if (options_.follow_references && local_name(node) == "switch") return visit_choices(node, place);
    for (pugi::xml_node child = node.first_child(); child;) {
        const pugi::xml_node next = child.next_sibling();
        if (!visit(child, place)) return false;
        child = next;
    }
    return true;
}

bool ShapeCollector::visit_choices(pugi::xml_node node, Place place) {
    constexpr std::array conditions{"systemLanguage", "requiredExtensions", "requiredFeatures"};
    for (pugi::xml_node child = node.first_child(); child;) {
        const pugi::xml_node next = child.next_sibling();
        const std::string kind = local_name(child);
        if (is_group(kind) || is_shape(kind) || is_fixed(kind) || kind == "use") {
            pugi::xml_node group = node.insert_child_before((name_prefix(node) + 'g').c_str(), child);
            for (const char* name : conditions) {
                if (const auto condition = child.attribute(name)) group.append_copy(condition);
                child.remove_attribute(name);
            }
            const bool is_chosen = !group.first_attribute();
            group.append_move(child);
            if (!visit(group, place)) return false;
            if (is_chosen) place.style.is_transparent = true; // the following alternatives are not drawn
        }
        child = next;
    }
    return true;
}

std::optional<Affine2> ShapeCollector::own_transform(pugi::xml_node node) {
    const auto map = parse_transform(attribute_text(node, "transform"));
    if (map) return *map;
    const FileError fault = error_in(document_, node, "transform", map.error());
    node.remove_attribute("transform");
    return leave_out(fault) ? std::optional(Affine2()) : std::nullopt;
}

// ---- nested svg ----

bool ShapeCollector::visit_svg(pugi::xml_node node, const Values& values, Place& place) {
    const Viewport outer = place.viewport;
    const double x = length(node, "x", outer, outer.width, 0);
    const double y = length(node, "y", outer, outer.height, 0);
    Viewport size = outer;
    size.width = length(node, "width", outer, outer.width, outer.width);
    size.height = length(node, "height", outer, outer.height, outer.height);
    Affine2 inside{1, 0, 0, 1, x, y};
    place.viewport = size;
    if (!enter_view_box(node, inside, place.viewport)) return false;
    place.to_root = compose(place.to_root, inside);
    const auto is_flat = [](const Viewport& each) { return !(each.width > 0 && each.height > 0); };
    const bool draws_nothing = is_flat(size) || is_flat(place.viewport);
    place.style.is_transparent = place.style.is_transparent || draws_nothing;
    const std::size_t first = drawing.shapes.size();
    if (error_ || !visit_children(node, place)) return false;
    if (draws_nothing || (!options_.follow_references && symbols_.count(node.hash_value()) == 0)) return true;

    const std::string overflow = text_of(values, "overflow");
    const bool clips = overflow != "visible" && overflow != "auto";
    const auto to_inside = inverse(inside);
    const auto from_root = inverse(place.to_root);
    bool cuts = false;
    Box window;
    if (options_.follow_references && clips && to_inside && from_root) {
        window = Box{x, y, x + size.width, y + size.height}.mapped(*to_inside);
        const Box content =
            painted_bounds(drawing.shapes, first, drawing.shapes.size(), place.style.level, *from_root);
        cuts = !window.grown(1e-9 * (window.width() + window.height())).contains(content);
    }
    if (!cuts && symbols_.count(node.hash_value()) == 0) {
        if (clips) styles_.set(node, "overflow", "visible");
        return true;
    }
    to_group(node, inside);
    return !cuts || clip(node, window, place, first);
}

void ShapeCollector::to_group(pugi::xml_node node, const Affine2& inside) {
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

bool ShapeCollector::clip(pugi::xml_node group, const Box& box, const Place& place, std::size_t first) {
    const std::string prefix = name_prefix(group);
    pugi::xml_node inner = group.append_child((prefix + 'g').c_str());
    while (group.first_child() != inner) inner.append_move(group.first_child());
    pugi::xml_node clip_path = group.prepend_child((prefix + "clipPath").c_str());
    const std::string id = ids_.name(clip_path, "cageform-clip");
    pugi::xml_node rect = clip_path.append_child((prefix + "rect").c_str());
    set_box(rect, box, 17);
    set_attribute(inner, "clip-path", "url(#" + escaped(id) + ')');
    return visit_references(inner, styles_.values(inner), place, first);
}

bool ShapeCollector::drop_bad_view_box(pugi::xml_node node) {
    if (view_box_of(node) || !node.remove_attribute("viewBox")) return true;
    return leave_out(error_at(document_, node, "viewBox is not four numbers"));
}

bool ShapeCollector::enter_view_box(pugi::xml_node node, Affine2& to_root, Viewport& viewport) {
    if (!drop_bad_view_box(node)) return false;
    const auto view = view_box_of(node);
    if (!view) return true;
    Viewport box = viewport;
    box.width = view->width;
    box.height = view->height;
    if (!(box.width > 0 && box.height > 0)) {
        if (box.width >= 0 && box.height >= 0) viewport = box; // not drawn
        return true;
    }
    double sx = viewport.width / box.width;
    double sy = viewport.height / box.height;
    const std::string fit = attribute_text(node, "preserveAspectRatio");
    const auto says = [&](std::string_view word) { return fit.find(word) != std::string::npos; };
    if (!says("none")) sx = sy = says("slice") ? std::max(sx, sy) : std::min(sx, sy);
    const double along_x = says("xMin") ? 0 : says("xMax") ? 1 : 0.5;
    const double along_y = says("YMin") ? 0 : says("YMax") ? 1 : 0.5;
    const double x = (viewport.width - sx * box.width) * along_x - sx * view->x;
    const double y = (viewport.height - sy * box.height) * along_y - sy * view->y;
    to_root = compose(to_root, {sx, 0, 0, sy, x, y});
    viewport = box;
    return true;
}

// ---- shapes ----

double ShapeCollector::length(pugi::xml_node node, const char* name, const Viewport& viewport, double whole,
                              double otherwise) {
    const auto value = length_of(document_, node, name, viewport, whole, otherwise);
    if (value) return *value;
    leave_out(value.error());
    return otherwise;
}

std::optional<Path> ShapeCollector::path_of(pugi::xml_node node, const Place& place) {
    std::vector<FileError> faults;
    Path path =
        shape_path(document_, node, place.viewport, faults, options_.as_cage ? arc_of_cage : arc_of_figure);
    for (const FileError& fault : faults) {
        if (!leave_out(fault)) return std::nullopt;
    }
    return path;
}

bool ShapeCollector::add_shape(pugi::xml_node node, const Place& place) {
    auto path = path_of(node, place);
    if (!path) return false;
    if (!path->empty()) return add(node, std::move(*path), place);
    if (local_name(node) == "circle") drawing.flat_circles.push_back(node);
    return true;
}

void ShapeCollector::straighten(Path& path) {
    for (Subpath& subpath : path) {
        Point2 from = subpath.start;
        for (Segment& s : subpath.segments) {
            const Point2 to = s.p3;
            const double near = 1e-6 * std::hypot(to.x - from.x, to.y - from.y);
            const bool stops = std::hypot(s.p1.x - from.x, s.p1.y - from.y) <= near &&
                               std::hypot(s.p2.x - to.x, s.p2.y - to.y) <= near;
            if (!s.is_line() && stops && near > 0) {
                PathBuilder line;
                line.move_to(from);
                line.line_to(to);
                s = line.take().front().segments.front();
            }
            from = to;
        }
    }
}

bool ShapeCollector::add(pugi::xml_node node, Path path, const Place& place, bool is_box) {
    if (!options_.as_cage) straighten(path);
    const std::optional<Affine2> from_root = inverse(place.to_root);
    if (!from_root) {
        warn(node, "has a transform without inverse and stays unchanged");
        return true;
    }
    DrawnShape shape = place.style;
    shape.node = node;
    shape.to_root = place.to_root;
    shape.from_root = *from_root;
    shape.is_box = is_box;
    shape.path = transformed(std::move(path), place.to_root);
    if (!in_range(shape.path, options_.is_strict ? most_coordinate : most_)) {
        if (options_.is_strict) return fail(node, "coordinates out of range");
        warn(node, "has coordinates out of range and stays unchanged");
        return true;
    }
    shape.has_fill = shape.fill_opacity > 0 && shows(shape.fill, place.colour);
    shape.has_stroke =
        shape.stroke_width > 0 && shape.stroke_opacity > 0 && shows(shape.stroke, place.colour);
    drawing.shapes.push_back(std::move(shape));
    return true;
}

bool ShapeCollector::shows(std::string_view paint, const std::string& colour) {
    const std::string word = lowered(trimmed(paint));
    if (word.empty() || word == "none") return false;
    if (word == "currentcolor") return alpha_of(colour) > 0;
    if (!word.starts_with("url(")) return alpha_of(word) > 0;
    const std::string id = referenced_id(paint);
    const auto chain = server_chain(ids_, id);
    if (id.empty()) return true; // in another file
    if (chain.empty()) return shows(paint.substr(std::min(paint.find(')'), paint.size() - 1) + 1), colour);
    const auto [found, is_new] = paints_.try_emplace(chain.front().hash_value(), false);
    if (is_new) {
        const bool is_pattern = local_name(chain.front()) == "pattern";
        const auto content = content_owner(chain).children();
        found->second = std::any_of(content.begin(), content.end(),
                                    [&](pugi::xml_node child) { return is_pattern || has_colour(child); });
    }
    return found->second;
}

bool ShapeCollector::has_colour(pugi::xml_node stop) const {
    if (local_name(stop) != "stop") return false;
    const Values values = styles_.values(stop);
    std::string colour = text_of(values, "stop-color");
    for (pugi::xml_node up = stop; up && lowered(colour) == "currentcolor"; up = up.parent()) {
        const std::string given = text_of(styles_.values(up), "color");
        if (!given.empty()) colour = given;
    }
    return alpha_of(colour) > 0 && parse_length(text_of(values, "stop-opacity"), 1).value_or(1) > 0;
}

bool ShapeCollector::add_fixed(pugi::xml_node node, const std::string& kind, Place place) {
    const auto is_path = [](pugi::xml_node part) { return local_name(part) == "textPath"; };
    const bool has_path = kind == "text" && node.find_node(is_path);
    // A clip path may contain a text, but not a copy of its path.
    const bool boxes = options_.boxes && !(place.style.clips && (kind != "text" || has_path));
    const bool on_paths = boxes && has_path;
    const bool beside = std::any_of(node.begin(), node.end(), [&](pugi::xml_node part) {
        return !is_path(part) && !(is_blank(part.value()) && is_blank(part.text().get()));
    });
    if (on_paths && !beside) return add_text_paths(node, place);
    const Box box = boxes ? (kind == "text" ? text_box(node, place) : image_box(node, place)) : Box();
    if (error_) return false;
    if (box.empty() && kind == "text" && is_blank(node.text().get()) && !node.child("tspan")) return true;
    if (box.empty()) {
        warn(node, "cannot be deformed and stays unchanged");
        return true;
    }
    warn(node, kind == "text" ? "keeps its letters, and moves and turns as a whole"
                              : "is not deformed; it moves and turns as a whole");
    PathBuilder outline;
    outline.move_to({box.x0, box.y0});
    for (const Point2& p : box.corners()) {
        if (!(p == outline.current())) outline.line_to(p);
    }
    outline.close();
    const std::size_t text_on_path = drawing.shapes.size();
    if (!add(node, outline.take(), place, true)) return false;
    if (drawing.shapes.size() > text_on_path) place.style.text_on_path = text_on_path;
    return !on_paths || add_text_paths(node, place);
}

// ---- text on paths ----

bool ShapeCollector::is_drawn_under(pugi::xml_node node, const Affine2& to_root) const {
    Affine2 map;
    for (pugi::xml_node up = node; up.type() == pugi::node_element; up = up.parent()) {
        const std::string kind = local_name(up);
        if (up == root_element(document_.xml)) {
            const auto undone = inverse(to_root); // compare up to rounding errors
            const Affine2 m = undone ? compose(*undone, map) : Affine2{0, 0, 0, 0, 0, 0};
            return std::abs(m.a - 1) + std::abs(m.b) + std::abs(m.c) + std::abs(m.d - 1) < 1e-9 &&
                   std::hypot(m.e, m.f) < 1e-9 * (std::abs(to_root.e) + std::abs(to_root.f) + 1);
        }
        const bool draws = up == node ? is_shape(kind) : is_group(kind) && kind != "svg";
        const auto own = parse_transform(attribute_text(up, "transform"));
        const Values values = styles_.values(up);
        const bool may_be_carried = !text_of(values, "filter").empty();
        if (!draws || !own || may_be_carried || text_of(values, "display") == "none") return false;
        map = compose(*own, map);
    }
    return false;
}

bool ShapeCollector::add_text_paths(pugi::xml_node text, const Place& place) {
    std::vector<pugi::xml_node> text_paths;
    for (pugi::xml_node node = text; node; node = next_node(node, text)) {
        if (local_name(node) == "textPath") text_paths.push_back(node);
    }
    return std::all_of(text_paths.begin(), text_paths.end(),
                       [&](pugi::xml_node each) { return add_text_path(each, place); });
}

namespace {

struct PlaceAlong {
    Point2 at;
    double length = 0; // along the path
};

/// Samples of a path with their arc lengths. Steps to a new subpath have length 0.
std::vector<PlaceAlong> places_along(const Path& path) {
    constexpr std::size_t steps = 32; // of a segment
    std::vector<PlaceAlong> places;
    double length = 0;
    for (const Subpath& subpath : path) {
        Point2 start = subpath.start;
        places.push_back({start, length});
        for (const Segment& s : subpath.segments) {
            for (std::size_t k = 1; k <= steps; ++k) {
                const Point2 p = place_on(start, s, static_cast<double>(k) / steps);
                length += std::hypot(p.x - places.back().at.x, p.y - places.back().at.y);
                places.push_back({p, length});
            }
            start = s.p3;
        }
    }
    return places;
}

/// The part of a path between two arc lengths, as lines.
Path part_of(const std::vector<PlaceAlong>& places, double from, double to) {
    PathBuilder part;
    bool begun = false;
    for (std::size_t i = 1; i < places.size(); ++i) {
        const PlaceAlong &before = places[i - 1], &p = places[i];
        if (p.length < from || (p.length == before.length && !begun)) continue;
        if (!begun) part.move_to(before.at);
        begun = true;
        part.line_to(p.at);
        if (p.length >= to) break;
    }
    return part.take();
}

/// Inserts a <defs> before the text that contains an element.
pugi::xml_node add_defs_before_text(pugi::xml_node text) {
    while (local_name(text) != "text") text = text.parent();
    return text.parent().insert_child_before((name_prefix(text) + "defs").c_str(), text);
}

} // namespace

bool ShapeCollector::add_text_path(pugi::xml_node text_path, const Place& place) {
    if (const std::string data = attribute_text(text_path, "path");
        !data.empty()) { // takes precedence over href
        pugi::xml_node path =
            add_defs_before_text(text_path).append_child((name_prefix(text_path) + "path").c_str());
        set_attribute(path, "d", escaped(data));
        const std::string id = ids_.name(path, "text-path");
        set_attribute(text_path, reference_name(root_element(document_.xml)).c_str(), '#' + id);
        set_reference(text_path, id);
        text_path.remove_attribute("path");
    }
    const std::string reference = reference_of(text_path);
    const pugi::xml_node target = ids_.referred(reference);
    if (!target || !is_shape(local_name(target))) return true; // not drawn
    const auto path = path_of(target, place);
    const auto own = own_transform(target);
    if (!path || !own) return false;
    if (path->empty()) return true;
    Place there = place;
    there.to_root = compose(place.to_root, *own);
    there.style.fill = there.style.stroke = "none";
    there.style.markers = {};
    if (place.style.text_on_path || !is_drawn_under(target, there.to_root)) {
        if (!count_copies(target))
            return fail(text_path, "the texts of this file expand to too many elements");
        pugi::xml_node copy = add_defs_before_text(text_path).append_copy(target);
        const std::string id = ids_.name(copy, reference.substr(1));
        set_reference(text_path, id);
        if (!add(copy, *path, there)) return false;
    }

    return add_reach(text_path, *path, there);
}

bool ShapeCollector::add_reach(pugi::xml_node text_path, const Path& path, Place place) {
    const std::vector<PlaceAlong> places = places_along(path);
    const std::string letters = unescaped(trimmed(text_path.text().get()));
    const double whole = places.back().length;
    const double width = 0.6 * place.viewport.em * static_cast<double>(letters.size());
    const double at = parse_length(attribute_text(text_path, "startOffset"), whole).value_or(0);
    const double from = place.text_anchor == "end"      ? at - width
                        : place.text_anchor == "middle" ? at - width / 2
                                                        : at;
    Path reach = letters.empty() ? part_of(places, 0, whole)
                                 : part_of(places, std::max(from, 0.0), std::min(from + width, whole));
    if (reach.empty()) return true;
    place.style.stroke = "black";
    place.style.stroke_width = 1.6 * place.viewport.em;
    place.style.is_extent = true;
    return add(text_path, std::move(reach), place);
}

Box ShapeCollector::image_box(pugi::xml_node node, const Place& place) {
    const auto shared = uses_of_images_.find(node.hash_value());
    if (shared != uses_of_images_.end()) node = shared->second;
    const double x = length(node, "x", place.viewport, place.viewport.width, 0);
    const double y = length(node, "y", place.viewport, place.viewport.height, 0);
    const double width = length(node, "width", place.viewport, place.viewport.width, 0);
    const double height = length(node, "height", place.viewport, place.viewport.height, 0);
    return width > 0 && height > 0 ? Box{x, y, x + width, y + height} : Box();
}

Box ShapeCollector::text_box(pugi::xml_node text, const Place& place) {
    const auto measured = document_.text_boxes.find(text.hash_value());
    if (measured != document_.text_boxes.end()) {
        const auto& [x0, y0, x1, y1] = measured->second;
        return {x0, y0, x1, y1};
    }
    Box box;
    Point2 at;
    double size = place.viewport.em;
    for (pugi::xml_node node = text; node; node = next_node(node, text)) {
        if (node.type() == pugi::node_element) {
            const auto x = parse_numbers(attribute_text(node, "x"));
            const auto y = parse_numbers(attribute_text(node, "y"));
            const auto font = parse_length(styles_.value(node, "font-size").text, place.viewport.em);
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

Expected<Drawing> walk(SvgDocument& document, StyleSheets& styles, IdTable& ids, const WalkOptions& options,
                       std::vector<std::string>& warnings) {
    place_by_attributes(document, styles);
    ShapeCollector collector(document, styles, ids, options);
    if (std::optional<FileError> error = collector.collect()) return *error;
    warnings.insert(warnings.end(), collector.warnings.begin(), collector.warnings.end());
    return std::move(collector.drawing);
}

Expected<std::vector<DrawnShape>> drawn_shapes(SvgDocument& document, std::vector<std::string>& warnings) {
    StyleSheets styles(document);
    IdTable ids(root_element(document.xml));
    auto drawing = walk(document, styles, ids, {}, warnings);
    if (!drawing) return drawing.error();
    styles.settle(warnings);
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

bool is_filter(const Reference& reference) {
    return !reference.target || local_name(reference.target) == "filter";
}

bool has_markers(const DrawnShape& shape) {
    return std::any_of(shape.markers.begin(), shape.markers.end(),
                       [](const auto& id) { return !id.empty(); });
}

std::vector<Box> seen_boxes(const Drawing& drawing) {
    const std::vector<DrawnShape>& shapes = drawing.shapes;
    std::vector<Box> boxes;
    boxes.reserve(shapes.size());
    for (const DrawnShape& shape : shapes) {
        boxes.push_back(!shape.is_visible      ? Box()
                        : shape.clips          ? bounds(shape.path)
                        : shape.is_transparent ? Box()
                                               : painted_box(shape, {}));
    }
    for (const Reference& r : drawing.references) { // nested ones first
        if (!r.hides_rest) continue;
        Box inside;
        for (std::size_t i = r.first_inside; i < r.end_inside; ++i) {
            if (shapes[i].level == r.level + 1) inside.add(boxes[i]);
        }
        for (std::size_t i = r.first; i < r.end; ++i) {
            if (shapes[i].level == r.level) boxes[i] = boxes[i].within(inside);
        }
    }
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        if (shapes[i].level > 0) boxes[i] = {};
    }
    return boxes;
}

Box painted_bounds(const std::vector<DrawnShape>& shapes, std::size_t first, std::size_t end, int level,
                   const Affine2& map) {
    Box box;
    for (std::size_t i = first; i < end; ++i) {
        if (shapes[i].level == level) box.add(painted_box(shapes[i], map));
    }
    return box;
}

Box painted_box(const DrawnShape& shape, const Affine2& map) {
    if (!(shape.is_box || shape.has_fill || shape.has_stroke)) return {};
    const Box box = bounds(shape.path, map);
    const double width = shape.has_stroke ? shape.stroke_width : 0;
    return box.empty() ? box : box.grown(width / 2 * largest_scale(compose(map, shape.to_root)));
}

} // namespace cageform_support::detail

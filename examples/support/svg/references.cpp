// Expands references: copies the targets of uses; lists clip paths, masks and filters.

#include "svg/collector.hpp"
#include "svg/css_geometry.hpp"
#include "svg/paint.hpp"

#include <algorithm>
#include <array>
#include <tuple>

namespace cageform_support::detail {

constexpr std::size_t max_svg_copies = 1'000'000; // nodes copied for `use` and shared clip paths

// ---- use ----

namespace {

void drop_use_attributes(pugi::xml_node use) {
    std::vector<std::string> dropped = {"x", "y", "width", "height"};
    for (const pugi::xml_attribute attribute : use.attributes()) {
        if (is_reference(attribute.name())) dropped.emplace_back(attribute.name());
    }
    for (const std::string& name : dropped) use.remove_attribute(name.c_str());
}

void use_becomes_group(pugi::xml_node use) {
    drop_use_attributes(use);
    use.set_name((name_prefix(use) + 'g').c_str());
}

} // namespace

pugi::xml_node ShapeCollector::used_element(pugi::xml_node use) {
    const std::string reference = reference_of(use);
    const pugi::xml_node target = ids_.referred(reference);
    if (!target) {
        warn(use, "refers to nothing in this file (\"" + reference + "\") and stays unchanged");
        return {};
    }
    bool cyclic = std::find(active_.begin(), active_.end(), target) != active_.end();
    for (pugi::xml_node node = use; node; node = node.parent()) cyclic = cyclic || node == target;
    if (cyclic) {
        warn(use, "uses itself through \"" + reference + "\" and is not drawn");
        use_becomes_group(use); // empty, which breaks the cycle
        return {};
    }
    const std::string kind = local_name(target);
    const bool flat = local_name(use.parent()) == "clipPath";
    const bool usable =
        is_shape(kind) || is_fixed(kind) || (!flat && (is_group(kind) || kind == "use" || kind == "symbol"));
    const bool has_content = std::any_of(use.begin(), use.end(), [](pugi::xml_node child) {
        const std::string name = local_name(child);
        return is_shape(name) || is_fixed(name) || is_group(name) || name == "use";
    });
    if (!usable || has_content) {
        warn(use, flat && !usable
                      ? "shows nothing, as in browsers: in a clip path a use cannot refer to " + kind
                      : "cannot be expanded and stays unchanged");
        return {};
    }
    if (!count_copies(target) || copies_ + expanded_size(target) > max_svg_copies) {
        fail(use, "the uses of this file expand to too many elements");
        return {};
    }
    return target;
}

std::size_t ShapeCollector::expanded_size(pugi::xml_node top, int depth) {
    const auto known = expanded_sizes_.find(top.hash_value());
    if (known != expanded_sizes_.end()) return known->second;
    if (depth >= max_svg_depth) return 0;  // an error elsewhere
    expanded_sizes_[top.hash_value()] = 0; // cycles are an error elsewhere
    std::size_t size = 0;
    for (pugi::xml_node node = top; node && size <= max_svg_copies; node = next_node(node, top)) {
        ++size;
        const std::string reference = local_name(node) == "use" ? reference_of(node) : std::string();
        if (!reference.starts_with('#')) continue;
        if (const auto used = ids_.find(reference.substr(1))) size += expanded_size(used, depth + 1);
    }
    return expanded_sizes_[top.hash_value()] = size;
}

bool ShapeCollector::visit_use(pugi::xml_node use, const Place& parent) {
    const pugi::xml_node target = used_element(use);
    if (!target) return !error_;
    if (!own_transform(use)) return false;
    const double x = length(use, "x", parent.viewport, parent.viewport.width, 0);
    const double y = length(use, "y", parent.viewport, parent.viewport.height, 0);
    std::string transform = use.attribute("transform").value();
    if (x != 0 || y != 0) {
        transform += transform.empty() ? "" : " ";
        transform += "translate(" + format_number(x, 17) + ' ' + format_number(y, 17) + ')';
    }
    return local_name(use.parent()) == "clipPath" ? replace_use(use, target, transform, parent)
                                                  : use_to_group(use, target, transform, parent);
}

bool ShapeCollector::replace_use(pugi::xml_node use, pugi::xml_node target, std::string transform,
                                 const Place& parent) {
    drop_use_attributes(use);
    pugi::xml_node copy = use.parent().insert_copy_after(target, use);
    keep_places(document_, target, document_, copy);
    styles_.match_in_isolation(copy);
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

bool ShapeCollector::use_to_group(pugi::xml_node use, pugi::xml_node target, const std::string& transform,
                                  const Place& parent) {
    const std::string kind = local_name(target);
    const std::string width = use.attribute("width").value();
    const std::string height = use.attribute("height").value();
    use_becomes_group(use);
    if (!transform.empty()) set_attribute(use, "transform", transform);
    pugi::xml_node copy = use.append_copy(target);
    keep_places(document_, target, document_, copy);
    styles_.match_in_isolation(copy);
    drop_ids(copy);
    share_images(copy);
    if (kind == "svg" || kind == "symbol") {
        if (!width.empty()) set_attribute(copy, "width", width);
        if (!height.empty()) set_attribute(copy, "height", height);
    }
    if (kind == "symbol") {
        for (const char* name : {"refX", "refY"}) copy.remove_attribute(name);
        copy.set_name((name_prefix(copy) + "svg").c_str());
        symbols_.insert(copy.hash_value());
    }
    Place place = parent;
    Place own = parent;
    const Values values = resolve_context_paint(use, own);
    inherit(values, own);
    place.context_fill = own.style.fill;
    place.context_stroke = own.style.stroke;
    active_.push_back(target);
    const bool good = visit(use, place);
    active_.pop_back();
    return good;
}

StyleSheets::Values ShapeCollector::resolve_context_paint(pugi::xml_node node, const Place& place) {
    Values values = styles_.values(node);
    for (const char* property : {"fill", "stroke"}) {
        const std::string paint = text_of(values, property);
        if (paint != "context-fill" && paint != "context-stroke") continue;
        const std::string& context = paint == "context-fill" ? place.context_fill : place.context_stroke;
        styles_.set(node, property, context);
        values[property].text = context;
        if (!referenced_id(context).empty()) warn(node, paint + " uses the bounding box of each shape");
    }
    return values;
}

void ShapeCollector::share_images(pugi::xml_node copy) {
    constexpr std::array place{"x", "y", "width", "height", "preserveAspectRatio"};
    std::vector<pugi::xml_node> images;
    for (pugi::xml_node node = copy; node; node = next_node(node, copy)) {
        if (local_name(node) == "image" && reference_of(node).size() > 1000) images.push_back(node);
    }
    for (pugi::xml_node image : images) {
        std::string key;
        for (const char* name : place) key += std::string(image.attribute(name).value()) + ' ';
        key += reference_of(image);
        pugi::xml_node& shared = images_[key];
        const std::string prefix = name_prefix(image);
        if (!shared) {
            pugi::xml_node root = root_element(document_.xml);
            shared = root.prepend_child((prefix + "defs").c_str()).append_child((prefix + "image").c_str());
            ids_.name(shared, "cageform-image");
            for (const pugi::xml_attribute attribute : image.attributes()) {
                const std::string_view name = attribute.name();
                const bool is_place = std::find(place.begin(), place.end(), name) != place.end();
                if (is_place || is_reference(name)) shared.append_copy(attribute);
            }
        }
        image.set_name((prefix + "use").c_str());
        for (const char* name : place) image.remove_attribute(name);
        set_reference(image, attribute_text(shared, "id"));
        uses_of_images_[image.hash_value()] = shared;
    }
}

bool ShapeCollector::count_copies(pugi::xml_node top) {
    for (pugi::xml_node node = top; node; node = next_node(node, top)) ++copies_;
    return copies_ <= max_svg_copies;
}

// ---- clip paths, masks and filters ----

bool ShapeCollector::visit_references(pugi::xml_node node, const Values& values, const Place& place,
                                      std::size_t first) {
    if (!options_.follow_references) return true;
    const std::size_t end = drawing.shapes.size();
    const std::string mask = text_of(values, "mask");
    if (!mask.empty() && mask != "none" && referenced_id(mask).empty())
        warn(node, "the property \"mask\" is not deformed: " + mask.substr(0, 60));
    if (make_clip_path(node, values, place, first))
        return visit_references(node, styles_.values(node), place, first);
    const auto good = [&](const char* property, const char* kind) {
        const std::string value = text_of(values, property), id = referenced_id(value);
        const pugi::xml_node target = id.empty() ? pugi::xml_node() : ids_.find(id);
        const bool is_function = kind == std::string_view("filter") && id.empty() && value.ends_with(')');
        if (!is_function && (!target || local_name(target) != kind)) return true;
        const auto from_root = inverse(place.to_root);
        if (!from_root) return true; // not drawn
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

bool ShapeCollector::make_clip_path(pugi::xml_node node, const Values& values, const Place& place,
                                    std::size_t first) {
    const std::string value = text_of(values, "clip-path");
    if (value.empty() || value == "none" || value.starts_with("url(")) return false;
    Box fill, stroke;
    bool has_text = false, has_tips = false;
    const auto from_root = inverse(place.to_root);
    for (std::size_t i = first; from_root && i < drawing.shapes.size(); ++i) {
        const DrawnShape& shape = drawing.shapes[i];
        if (shape.level != place.style.level) continue;
        const Box box = bounds(shape.path, *from_root), painted = painted_box(shape, *from_root);
        fill.add(box);
        stroke.add(box);
        stroke.add(painted);
        has_text = has_text || local_name(shape.node) == "text"; // whose box depends on the viewer's fonts
        has_tips = has_tips ||
                   (shape.has_miters && local_name(shape.node).starts_with('p') && !box.contains(painted));
    }
    if (fill.empty()) return false; // not drawn
    const auto shape = has_text ? std::nullopt : parse_basic_shape(value, fill, stroke, place.viewport);
    if (shape && has_tips && value.find("fill-box") == std::string::npos) {
        warn(node, "clip-path: the stroke box excludes the tips of mitred corners");
    }
    if (!shape) {
        warn(node, "the property \"clip-path\" is not deformed: " + value.substr(0, 60));
        return false;
    }
    const std::string prefix = name_prefix(node);
    const std::string kind = prefix + "clipPath";
    pugi::xml_node clip_path = node == root_element(node)
                                   ? node.prepend_child(kind.c_str())
                                   : node.parent().insert_child_before(kind.c_str(), node);
    const std::string id = ids_.name(clip_path, "cageform-clip");
    pugi::xml_node path = clip_path.append_child((prefix + "path").c_str());
    set_attribute(path, "d", shape->data);
    if (shape->even_odd) set_attribute(path, "clip-rule", "evenodd");
    styles_.set(node, "clip-path", "url(#" + id + ')');
    return true;
}

namespace {

/// The region of a mask if it clips the painted content; else empty.
///
///   box   of the content
Box clipping_region(const std::vector<DrawnShape>& shapes, const Reference& reference,
                    const Viewport& viewport, const Box& box) {
    const Box region = region_in_user_space(reference.target, viewport, box);
    const Box painted =
        painted_bounds(shapes, reference.first, reference.end, reference.level, reference.from_root);
    const bool holds = region.grown(1e-9 * (region.width() + region.height())).contains(painted);
    return holds ? Box() : region;
}

/// Extends the region of a mask by a box, so that it does not clip.
void widen_region(pugi::xml_node mask, const Viewport& viewport, const Box& box) {
    Box region = region_in_user_space(mask, viewport, box);
    region.add(box);
    set_attribute(mask, "maskUnits", "userSpaceOnUse");
    set_box(mask, region, 17);
}

} // namespace

bool ShapeCollector::visit_reference(const char* property, const std::string& id, const Place& place,
                                     Reference& reference) {
    pugi::xml_node target = reference.target;
    if (std::find(active_.begin(), active_.end(), target) != active_.end()) {
        warn(reference.node, "refers to itself through \"#" + id + "\", which is left out");
        return true;
    }
    const bool clip = local_name(target) == "clipPath";
    const char* const units = clip ? "clipPathUnits" : "maskContentUnits";
    const bool has_content_of_box = attribute_text(target, units) == "objectBoundingBox";
    const Box box =
        bounds(drawing.shapes, reference.first, reference.end, reference.level, reference.from_root);
    const Box window =
        clip || box.empty() ? Box() : clipping_region(drawing.shapes, reference, place.viewport, box);
    const bool of_box =
        has_content_of_box || (!window.empty() && attribute_text(target, "maskUnits") != "userSpaceOnUse");
    Affine2 to_root = place.to_root, unit_square;
    if (of_box) {
        if (box.empty() || !(box.width() > 0 && box.height() > 0)) {          // not drawn
            if (!box.empty()) styles_.set(reference.node, "display", "none"); // not in any pose
            return true;
        }
        unit_square = {box.width(), 0, 0, box.height(), box.x0, box.y0};
        to_root = compose(to_root, unit_square);
    }
    std::vector<ContentInUse>& in_use = contents_in_use_[target.hash_value()];
    auto used = std::ranges::find(in_use, to_root, &ContentInUse::to_root);
    if (used == in_use.end()) {
        pugi::xml_node content = target;
        std::string content_id = id;
        if (!in_use.empty() || of_box) {
            if (!count_copies(target))
                return fail(reference.node, "the clip paths of this file expand to too many elements");
            content = target.parent().insert_copy_after(target, target);
            keep_places(document_, target, document_, content);
            drop_ids(content);
            content_id = ids_.name(content, id);
        }
        if (!own_transform(content)) return false;
        if (has_content_of_box) to_user_space(content, units, unit_square);
        in_use.push_back({to_root, content_id, drawing.shapes.size(), 0, !window.empty()});
        const std::size_t index = in_use.size() - 1;
        if (!visit_content(content, target, place, reference.first, window)) return false;
        std::vector<ContentInUse>& grown = contents_in_use_[target.hash_value()];
        grown[index].end = drawing.shapes.size();
        used = grown.begin() + static_cast<std::ptrdiff_t>(index);
    }
    reference.first_inside = used->first;
    reference.end_inside = used->end;
    const auto is_text = [](pugi::xml_node part) { return local_name(part) == "text"; };
    reference.hides_rest = used->first < used->end || !target.find_node(is_text);
    reference.target = ids_.find(used->id);
    if (used->region_clips) widen_region(reference.target, place.viewport, box);
    if (used->id != id) {
        const std::string value = styles_.value(reference.node, property).text;
        styles_.set(reference.node, property, with_referenced_id(value, used->id));
    }
    return true;
}

void ShapeCollector::to_user_space(pugi::xml_node content, const char* units, const Affine2& unit_square) {
    set_attribute(content, units, "userSpaceOnUse");
    const std::string map = write_transform(unit_square, 17);
    if (local_name(content) == "clipPath") {
        const std::string own = content.attribute("transform").value(); // outside the box's map
        return set_attribute(content, "transform", own.empty() ? map : own + ' ' + map);
    }
    pugi::xml_node group = content.append_child((name_prefix(content) + 'g').c_str());
    while (content.first_child() != group) group.append_move(content.first_child());
    set_attribute(group, "transform", map);
}

bool ShapeCollector::visit_content(pugi::xml_node content, pugi::xml_node target, const Place& place,
                                   std::size_t first, const Box& window) {
    Place inner;
    inner.to_root = place.to_root;
    inner.viewport = place.viewport;
    inner.depth = place.depth + 1;
    if (inner.depth >= max_svg_depth) return fail(content, "elements are nested too deeply");
    std::vector<pugi::xml_node> line;
    for (pugi::xml_node up = content; up.type() == pugi::node_element; up = up.parent()) line.push_back(up);
    for (auto up = line.rbegin(); up != line.rend(); ++up) inherit(styles_.values(*up), inner);
    inner.style.level = place.style.level + 1;
    const bool clip = local_name(content) == "clipPath";
    inner.style.clips = place.style.clips || clip;
    const Values values = styles_.values(content);
    const auto own = clip ? own_transform(content) : Affine2();
    if (!own) return false;
    inner.to_root = compose(inner.to_root, *own);
    active_.push_back(target);
    const std::size_t begin = drawing.shapes.size();
    const bool good = visit_children(content, inner) &&
                      (window.empty() || this->clip(content, window, inner, begin)) &&
                      visit_references(content, values, place, first);
    active_.pop_back();
    return good;
}

} // namespace cageform_support::detail

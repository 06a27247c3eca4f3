#include "svg/paint.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace cageform_support::detail {

namespace {

bool is_gradient(const std::string& kind) {
    return kind == "linearGradient" || kind == "radialGradient";
}

Affine2 from_unit_square(const Box& box) {
    return {box.width(), 0, 0, box.height(), box.x0, box.y0};
}

struct InheritedAttribute {
    const char* name;
    const char* otherwise; // default; empty: none
};

/// The inherited attributes of a gradient or pattern, except its transform.
std::vector<InheritedAttribute> inherited_attributes(const std::string& kind) {
    if (kind == "pattern") {
        return {{"patternUnits", ""},
                {"patternContentUnits", ""},
                {"x", ""},
                {"y", ""},
                {"width", ""},
                {"height", ""},
                {"viewBox", ""},
                {"preserveAspectRatio", ""}};
    }
    std::vector<InheritedAttribute> all{{"gradientUnits", "objectBoundingBox"}, {"spreadMethod", ""}};
    if (kind == "linearGradient")
        all.insert(all.end(), {{"x1", "0%"}, {"y1", "0%"}, {"x2", "100%"}, {"y2", "0%"}});
    else
        all.insert(all.end(),
                   {{"cx", "50%"}, {"cy", "50%"}, {"r", "50%"}, {"fx", ""}, {"fy", ""}, {"fr", ""}});
    return all;
}

/// Whether an attribute positions a gradient.
bool places_colours(const std::string& kind, std::string_view name) {
    const auto all = inherited_attributes(kind);
    return is_reference(name) || name == "gradientTransform" ||
           std::any_of(all.begin(), all.end(), [&](const auto& each) { return each.name == name; });
}

/// Whether a paint server has its own stops or tile.
bool has_content(pugi::xml_node server) {
    const bool is_pattern = local_name(server) == "pattern";
    return bool(server.find_child([&](pugi::xml_node child) {
        return is_pattern ? child.type() == pugi::node_element : local_name(child) == "stop";
    }));
}

} // namespace

std::vector<pugi::xml_node> server_chain(const IdTable& ids, const std::string& id) {
    std::vector<pugi::xml_node> chain;
    for (pugi::xml_node node = id.empty() ? pugi::xml_node() : ids.find(id); node;) {
        const bool is_pattern = local_name(chain.empty() ? node : chain.front()) == "pattern";
        if (is_pattern ? local_name(node) != "pattern" : !is_gradient(local_name(node))) break;
        if (std::find(chain.begin(), chain.end(), node) != chain.end() || chain.size() > 30) break;
        chain.push_back(node);
        node = ids.referred(reference_of(node));
    }
    return chain;
}

pugi::xml_node content_owner(const std::vector<pugi::xml_node>& chain) {
    const auto owner = std::find_if(chain.begin(), chain.end(), has_content);
    return owner == chain.end() ? pugi::xml_node() : *owner;
}

namespace {

const char* transform_name(const PaintServer& server) {
    return server.is_pattern ? "patternTransform" : "gradientTransform";
}

} // namespace

std::string PaintFollower::chain_text(const Server& server, const char* name) const {
    for (const pugi::xml_node node : server.chain) {
        if (node.attribute(name)) return attribute_text(node, name);
    }
    return {};
}

void PaintFollower::follow(const DrawnShape& shape, const std::vector<Affine2>& best, const Box& rest,
                           const std::vector<Box>& moved) {
    std::vector<Affine2> local;
    local.reserve(best.size());
    for (const Affine2& map : best) local.push_back(compose(compose(shape.from_root, map), shape.to_root));
    follow(shape, "fill", shape.fill, local, rest, moved);
    follow(shape, "stroke", shape.stroke, local, rest, moved);
}

std::optional<PaintServer> PaintFollower::find(const std::string& value) {
    Server server;
    server.chain = server_chain(ids_, referenced_id(value));
    if (server.chain.empty()) return std::nullopt;
    server.is_pattern = local_name(server.chain.front()) == "pattern";
    const char* const name = transform_name(server);
    auto transform = parse_transform(chain_text(server, name));
    for (; !transform; transform = parse_transform(chain_text(server, name))) { // browsers use the next one
        const auto has_it = [&](pugi::xml_node node) { return bool(node.attribute(name)); };
        pugi::xml_node owner = *std::find_if(server.chain.begin(), server.chain.end(), has_it);
        warnings.push_back(to_string(error_in(document_, owner, name, transform.error())) +
                           "; the transform is ignored, as in browsers");
        owner.remove_attribute(name);
    }
    server.transform = *transform;
    server.of_box =
        chain_text(server, server.is_pattern ? "patternUnits" : "gradientUnits") != "userSpaceOnUse";
    return server;
}

namespace {

/// Extends the box of a track.
void add_places(AnimatedSvg::Track& track, Box box) {
    for (const Point2& p : track.places) box.add(p);
    const auto corners = box.corners();
    track.places.assign(corners.begin(), corners.end());
}

bool has_area(const Box& box) {
    return inverse(from_unit_square(box)).has_value();
}

} // namespace

void PaintFollower::follow(const DrawnShape& shape, const char* property, const std::string& value,
                           const std::vector<Affine2>& local, const Box& rest,
                           const std::vector<Box>& moved) {
    const auto server = find(value);
    if (!server || rest.empty() || moved.front().empty()) return;
    const auto from_rest = inverse(from_unit_square(rest));
    if (server->of_box && !from_rest) { // browsers use the fallback for a box without area
        const std::string otherwise(trimmed(std::string_view(value).substr(value.find(')') + 1)));
        if (std::any_of(moved.begin(), moved.end(), has_area))
            styles_.set(shape.node, property, otherwise.empty() ? "none" : otherwise);
        return;
    }
    // Whether maps, in user space or box units, move the paint with the shape.
    const auto goes_right = [&](bool of_box, const auto& map_of) {
        for (std::size_t n = 0; n < local.size(); ++n) {
            const std::size_t f = (n + local.size() / 2) % local.size(); // often at rest at the start
            const Affine2 placed =
                of_box ? compose(from_unit_square(moved[f]), compose(map_of(f), *from_rest)) : map_of(f);
            for (const Point2& p : rest.corners()) {
                const Point2 a = apply(shape.to_root, apply(local[f], p));
                const Point2 b = apply(shape.to_root, apply(placed, p));
                if (!(std::hypot(a.x - b.x, a.y - b.y) <= tolerance_)) return false;
            }
        }
        return true;
    };
    const bool fills_box = server->of_box && !server->is_pattern; // patterns map in user space
    if (goes_right(fills_box, [](std::size_t) { return Affine2(); })) return;

    std::vector<Affine2> maps;
    for (std::size_t f = 0; f < local.size(); ++f) {
        const auto from_moved = inverse(from_unit_square(moved[f])); // nothing if the area is 0
        if (fills_box && !from_moved && maps.empty()) return;
        maps.push_back(!fills_box   ? local[f]
                       : from_moved ? compose(*from_moved, compose(local[f], from_unit_square(rest)))
                                    : maps.back());
    }
    std::vector<Copy>& copies = copies_[attribute_text(server->chain.front(), "id")];
    const Box tile = server->is_pattern && (server->of_box || content_is_of_box(*server)) ? rest : Box();
    auto copy = std::find_if(copies.begin(), copies.end(), [&](const Copy& each) {
        return each.tile.corners() == tile.corners() &&
               goes_right(fills_box, [&](std::size_t f) { return each.maps[f]; });
    });
    if (copy == copies.end()) {
        const pugi::xml_node node =
            server->is_pattern ? copy_of_pattern(*server, rest) : copy_of_gradient(*server);
        AnimatedSvg::Track track{.node = node, .attribute = transform_name(*server), .scale = 0};
        for (const Affine2& map : maps) track.maps.push_back(compose(map, server->transform));
        copy = copies.insert(copy, {attribute_text(node, "id"), std::move(maps), tile, tracks_.size()});
        tracks_.push_back(std::move(track));
    }
    AnimatedSvg::Track& track = tracks_[copy->track];
    const Affine2 back = inverse(server->transform).value_or(Affine2());
    add_places(track, (fills_box ? Box{0, 0, 1, 1} : rest).mapped(back)); // before the transform
    for (const Box& box : moved) {
        const double size = fills_box ? std::max(box.width(), box.height()) : 1;
        track.scale = std::max(track.scale, largest_scale(shape.to_root) * size);
    }
    styles_.set(shape.node, property, with_referenced_id(value, copy->id));
}

pugi::xml_node PaintFollower::add_copy(const Server& server) {
    const pugi::xml_node original = server.chain.front();
    pugi::xml_node copy = original.parent().insert_child_after(original.name(), original);
    ids_.name(copy, attribute_text(original, "id"));
    for (const pugi::xml_attribute attribute : original.attributes()) {
        if (!is_reference(attribute.name()) && !copy.attribute(attribute.name())) copy.append_copy(attribute);
    }
    for (const auto& [name, otherwise] : inherited_attributes(local_name(original))) {
        const std::string text = chain_text(server, name);
        const std::string& value = text.empty() ? otherwise : text;
        if (!value.empty()) set_attribute(copy, name, escaped(value));
    }
    return copy;
}

pugi::xml_node PaintFollower::copy_of_gradient(const Server& gradient) {
    pugi::xml_node copy = add_copy(gradient);
    if (const pugi::xml_node owner = content_owner(gradient.chain)) refer(copy, stops_of(owner));
    return copy;
}

/// Some programs inherit only stops from a gradient, and require that it has no position.
std::string PaintFollower::stops_of(pugi::xml_node gradient) {
    const std::string kind = local_name(gradient), id = attribute_text(gradient, "id");
    const auto places = [&](pugi::xml_attribute each) { return places_colours(kind, each.name()); };
    if (!gradient.find_attribute(places)) return id;
    std::string& stops = stops_[id];
    if (!stops.empty()) return stops;
    pugi::xml_node holder = gradient.parent().insert_copy_after(gradient, gradient);
    while (const pugi::xml_attribute each = holder.find_attribute(places)) holder.remove_attribute(each);
    drop_ids(holder);
    return stops = ids_.name(holder, id + "-stops");
}

void PaintFollower::refer(pugi::xml_node node, const std::string& id) {
    set_attribute(node, reference_name(root_element(document_.xml)).c_str(), '#' + escaped(id));
}

bool PaintFollower::content_is_of_box(const Server& pattern) const {
    return chain_text(pattern, "viewBox").empty() &&
           chain_text(pattern, "patternContentUnits") == "objectBoundingBox";
}

/// Converts a pattern's tile in box units to user space, where the transform applies. The content stays that
/// of the original: a pattern without elements inherits it.
pugi::xml_node PaintFollower::copy_of_pattern(const Server& pattern, const Box& rest) {
    pugi::xml_node copy = add_copy(pattern);
    if (const pugi::xml_node owner = content_owner(pattern.chain)) refer(copy, attribute_text(owner, "id"));

    const auto number = [&](const char* name) {
        return parse_length(chain_text(pattern, name), 1).value_or(0);
    };
    const double width = number("width");
    const double height = number("height");
    if (pattern.of_box) {
        const double across = rest.width(), down = rest.height(); // user units of the tile
        set_attribute(copy, "x", format_number(rest.x0 + across * number("x"), 12));
        set_attribute(copy, "y", format_number(rest.y0 + down * number("y"), 12));
        set_attribute(copy, "width", format_number(across * width, 12));
        set_attribute(copy, "height", format_number(down * height, 12));
        set_attribute(copy, "patternUnits", "userSpaceOnUse");
    }
    if (content_is_of_box(pattern)) { // a viewBox has the same effect
        const double w = pattern.of_box ? width : width / rest.width();
        const double h = pattern.of_box ? height : height / rest.height();
        set_attribute(copy, "viewBox", "0 0 " + format_number(w, 15) + ' ' + format_number(h, 15));
        set_attribute(copy, "preserveAspectRatio", "none");
        set_attribute(copy, "patternContentUnits", "userSpaceOnUse");
    }
    return copy;
}

namespace {

/// A region in user units, or in fractions of the box.
struct Region {
    pugi::xml_node node;
    bool of_box = true;
    Box written; // in the file
    Box wanted;  // by all references
    bool changed = false;
};

using Regions = std::map<std::size_t, Region>; // by the hash of their element

/// A reference to a mask or filter, in the user space of the referring element.
struct Subject {
    const Reference& reference;
    const Box& before;
    const std::vector<Box>& after;            // in every frame
    std::vector<std::optional<Affine2>> maps; // best maps of its shapes, #frames
};

Box in_user_units(const Region& region, const Box& box) {
    const Box& r = region.written;
    if (!region.of_box) return r;
    return {box.x0 + r.x0 * box.width(), box.y0 + r.y0 * box.height(), box.x0 + r.x1 * box.width(),
            box.y0 + r.y1 * box.height()};
}

Box in_units_of(const Region& region, const Box& r, const Box& box) {
    if (!region.of_box) return r;
    return {(r.x0 - box.x0) / box.width(), (r.y0 - box.y0) / box.height(), (r.x1 - box.x0) / box.width(),
            (r.y1 - box.y0) / box.height()};
}

/// Reads a region. Missing attributes have the values of `otherwise`.
Region read_region(pugi::xml_node node, bool of_box, const Viewport& viewport, const Box& otherwise) {
    Region region;
    region.node = node;
    region.of_box = of_box;
    const auto value = [&](const char* name, double whole, double missing) {
        return parse_length(attribute_text(node, name), of_box ? 1 : whole).value_or(missing);
    };
    const double x = value("x", viewport.width, otherwise.x0);
    const double y = value("y", viewport.height, otherwise.y0);
    region.written = {x, y, x + value("width", viewport.width, otherwise.width()),
                      y + value("height", viewport.height, otherwise.height())};
    region.wanted = region.written;
    return region;
}

Region region_of(pugi::xml_node node, const Viewport& viewport) {
    const char* const units = local_name(node) == "mask" ? "maskUnits" : "filterUnits";
    const bool of_box = attribute_text(node, units) != "userSpaceOnUse";
    const double w = of_box ? 1 : viewport.width, h = of_box ? 1 : viewport.height;
    return read_region(node, of_box, viewport, {-0.1 * w, -0.1 * h, 1.1 * w, 1.1 * h});
}

/// Enlarges a region for a subject, keeping its margins. A region that cuts the content moves with the best
/// map.
void grow(const SvgDocument& document, Region& region, const Subject& subject,
          std::vector<std::string>& warnings) {
    const Box& before = subject.before;
    const Box old = in_user_units(region, before);
    const double rounding = 1e-6 * (before.width() + before.height());
    const bool cuts = !old.grown(rounding).contains(before);
    const double small = 1e-3 * (region.written.width() + region.written.height());
    bool warned = false;
    for (std::size_t f = 0; f < subject.after.size(); ++f) {
        const Box& after = subject.after[f];
        Box now{after.x0 - std::max(0.0, before.x0 - old.x0), after.y0 - std::max(0.0, before.y0 - old.y0),
                after.x1 + std::max(0.0, old.x1 - before.x1), after.y1 + std::max(0.0, old.y1 - before.y1)};
        if (cuts) {
            if (!subject.maps[f]) continue;
            const Affine2& map = *subject.maps[f];
            now = old.mapped(map);
            const bool turns = std::abs(map.b) + std::abs(map.c) > 1e-6 * (std::abs(map.a) + std::abs(map.d));
            if (turns && !warned)
                warnings.push_back(label(document, region.node) +
                                   ": clips at a rectangle, which is not deformed");
            warned = warned || turns;
            region.wanted = region.changed ? region.wanted : Box();
            region.changed = true;
        }
        const Box wanted = in_units_of(region, now, after);
        if (!region.wanted.empty() && region.wanted.grown(small).contains(wanted)) continue;
        region.wanted.add(wanted);
        region.changed = true;
    }
}

void write(const Region& region) {
    const Box& box = region.wanted;
    if (!region.changed || box.empty() || !std::isfinite(box.width() + box.height())) return;
    set_box(region.node, box, 6);
}

/// Moves a light source in user space, and the point it points at.
///
///   maps    #frames; without a map, a frame has the position of the frame before
///   scale   to root user space
void move_light(pugi::xml_node light, const std::vector<std::optional<Affine2>>& maps, double scale,
                std::vector<AnimatedSvg::Track>& tracks) {
    for (const auto& [x, y] : {std::pair("x", "y"), std::pair("pointsAtX", "pointsAtY")}) {
        if (!light.attribute(x) && !light.attribute(y)) continue;
        const auto to_number = [&](const char* name) {
            return parse_length(attribute_text(light, name), 0).value_or(0);
        };
        const Point2 rest{to_number(x), to_number(y)};
        Point2 moved = rest;
        AnimatedSvg::Track along{.node = light, .attribute = x, .scale = scale}, down = along;
        down.attribute = y;
        for (const auto& map : maps) {
            const Point2 there = map ? apply(*map, rest) : moved;
            if (std::isfinite(there.x + there.y)) moved = there;
            along.numbers.push_back(moved.x);
            down.numbers.push_back(moved.y);
        }
        tracks.push_back(std::move(along));
        tracks.push_back(std::move(down));
    }
}

/// Updates filter primitives in user space: their regions, and light sources.
///
///   whole    the filter's region in user units, at rest
///   shared   whether other elements refer to the filter
void follow_primitives(const SvgDocument& document, const Subject& subject, const Box& whole, bool shared,
                       Regions& regions, std::vector<AnimatedSvg::Track>& tracks,
                       std::vector<std::string>& warnings) {
    const pugi::xml_node filter = subject.reference.target;
    if (attribute_text(filter, "primitiveUnits") == "objectBoundingBox") return; // relative to the box
    for (const pugi::xml_node primitive : filter.children()) {
        if (!local_name(primitive).starts_with("fe")) continue;
        const auto has = [&](const char* name) { return static_cast<bool>(primitive.attribute(name)); };
        if (has("x") || has("y") || has("width") || has("height")) {
            const Region rest = read_region(primitive, false, subject.reference.viewport, whole);
            grow(document, regions.try_emplace(primitive.hash_value(), rest).first->second, subject,
                 warnings);
        }
        for (const pugi::xml_node light : primitive.children()) {
            const std::string kind = local_name(light);
            if (kind != "fePointLight" && kind != "feSpotLight") continue;
            const auto stays = [](const std::optional<Affine2>& map) {
                const auto& [a, b, c, d, e, f] = map.value_or(Affine2{0, 0, 0, 0, 0, 0});
                const std::array off{a - 1, b, c, d - 1, e, f};
                return std::all_of(off.begin(), off.end(), [](double x) { return std::abs(x) < 1e-6; });
            };
            if (std::all_of(subject.maps.begin(), subject.maps.end(), stays)) continue;
            if (shared || !subject.maps.front()) {
                warnings.push_back(label(document, light) + ": does not move with the shapes");
            } else {
                move_light(light, subject.maps, largest_scale(subject.reference.to_root), tracks);
            }
        }
    }
}

} // namespace

Box region_in_user_space(pugi::xml_node node, const Viewport& viewport, const Box& box) {
    return in_user_units(region_of(node, viewport), box);
}

void follow_regions(SvgDocument& document, const Drawing& rest, const std::vector<MovedRegion>& moved,
                    std::vector<AnimatedSvg::Track>& tracks, std::vector<std::string>& warnings) {
    std::map<std::size_t, int> users; // by the hash of the target
    for (const Reference& r : rest.references) ++users[r.target.hash_value()];
    Regions regions;
    for (std::size_t i = 0; i < rest.references.size(); ++i) {
        const Reference& r = rest.references[i];
        const std::string kind = local_name(r.target);
        if (kind == "clipPath" || !r.target) continue;
        Subject subject{r, moved[i].before, moved[i].after, {}};
        const Box& before = subject.before;
        const auto all = [&](const auto& holds) {
            return holds(before) && std::all_of(subject.after.begin(), subject.after.end(), holds);
        };
        if (!all([](const Box& box) { return !box.empty(); }) || !moved[i].moved) continue;
        for (const auto& best : moved[i].maps) {
            subject.maps.push_back(best ? std::optional(compose(compose(r.from_root, *best), r.to_root))
                                        : std::nullopt);
        }
        Region& region =
            regions.try_emplace(r.target.hash_value(), region_of(r.target, r.viewport)).first->second;
        const bool has_area = all([](const Box& box) { return box.width() > 0 && box.height() > 0; });
        if (region.of_box && !has_area) continue;
        const Box whole = in_user_units(region, before);
        grow(document, region, subject, warnings);
        if (kind == "filter") {
            follow_primitives(document, subject, whole, users[r.target.hash_value()] > 1, regions, tracks,
                              warnings);
        }
    }
    for (const auto& [hash, region] : regions) write(region);
}

} // namespace cageform_support::detail

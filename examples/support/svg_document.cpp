#include "svg_document.hpp"

#include "atomic_file.hpp"
#include "svg_curves.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <system_error>
#include <utility>

namespace cageform_examples {

namespace detail {

constexpr int max_svg_depth = 1000;               // of nested elements; the walk is recursive
constexpr std::size_t max_svg_copies = 1'000'000; // nodes copied for `use` and shared clip paths

/// The node after `node` in document order within `top`, or none.
pugi::xml_node next_node(pugi::xml_node node, pugi::xml_node top) {
    if (node.first_child()) return node.first_child();
    while (node != top && !node.next_sibling()) node = node.parent();
    return node == top ? pugi::xml_node() : node.next_sibling();
}

pugi::xml_node root_element(pugi::xml_node node) {
    return node.root().find_child([](pugi::xml_node n) { return n.type() == pugi::node_element; });
}

std::string name_prefix(pugi::xml_node node) {
    const std::string_view root = root_element(node).name();
    return std::string(root.substr(0, root.find(':') + 1)); // npos + 1 is zero
}

/// The element's name without the prefix; empty for what is not SVG's, or no element.
std::string local_name(pugi::xml_node node) {
    if (node.type() != pugi::node_element) return {};
    const std::string prefix = name_prefix(node);
    const std::string_view name = node.name();
    if (!name.starts_with(prefix)) return {};
    return std::string(name.substr(prefix.size()));
}

bool is_blank(std::string_view text) {
    return std::all_of(text.begin(), text.end(), is_space);
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
    return text;
}

/// Replaces character references and the five entities of XML; others, from a doctype, are left.
std::string unescaped(std::string_view raw) {
    static const std::map<std::string_view, char> entities = {
        {"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"quot", '"'}, {"apos", '\''}};
    std::string text;
    while (!raw.empty()) {
        const std::size_t plain = std::min(raw.find('&'), raw.size());
        text += raw.substr(0, plain);
        raw.remove_prefix(plain);
        const std::size_t end = raw.find(';');
        if (end == std::string_view::npos) return text += raw;
        const std::string_view name = raw.substr(1, end - 1);
        const bool hexadecimal = name.starts_with("#x");
        const std::string_view digits = name.substr(std::min<std::size_t>(hexadecimal ? 2 : 1, name.size()));
        std::uint32_t code = 0;
        const auto [stop, failed] =
            std::from_chars(digits.data(), digits.data() + digits.size(), code, hexadecimal ? 16 : 10);
        const bool whole = failed == std::errc() && stop == digits.data() + digits.size();
        if (const auto entity = entities.find(name); entity != entities.end()) {
            text += entity->second;
        } else if (name.starts_with('#') && whole && code < 0x80) {
            text += static_cast<char>(code);
        } else {
            text += raw.substr(0, end + 1); // nothing of the grammars here is beyond ASCII
        }
        raw.remove_prefix(end + 1);
    }
    return text;
}

std::string attribute_text(pugi::xml_node node, const char* name) {
    return unescaped(node.attribute(name).value());
}

void set_attribute(pugi::xml_node node, const char* name, const std::string& raw) {
    if (!node.attribute(name)) node.append_attribute(name);
    node.attribute(name).set_value(raw.c_str());
}

void add_class(pugi::xml_node node, const std::string& name) {
    const std::string old = node.attribute("class").value();
    if ((' ' + old + ' ').find(' ' + name + ' ') != std::string::npos) return;
    set_attribute(node, "class", old.empty() ? name : old + ' ' + name);
}

/// The line of the nearest enclosing element that stood in the file; zero if none is known.
std::size_t line_of(const SvgDocument& document, pugi::xml_node node) {
    for (; node; node = node.parent()) {
        const auto found = document.lines.find(node.hash_value());
        if (found != document.lines.end()) return found->second;
    }
    return 0;
}

std::string name_and_id(pugi::xml_node node) {
    const std::string name = node.name();
    return node.attribute("id") ? name + " \"" + attribute_text(node, "id") + '"' : name;
}

std::string label(const SvgDocument& document, pugi::xml_node node) {
    return to_string(SvgError{name_and_id(node), line_of(document, node), 0});
}

SvgError error_at(const SvgDocument& document, pugi::xml_node node, const std::string& why) {
    return {document.name + ": " + name_and_id(node) + ": " + why, line_of(document, node), 0};
}

/// The value of a property in a style attribute; empty if it is not set there.
std::string style_property(pugi::xml_node node, std::string_view property) {
    const std::string style = attribute_text(node, "style");
    std::string value;
    for (std::string_view rest = style; !rest.empty();) {
        const std::string_view declaration = rest.substr(0, rest.find(';'));
        rest.remove_prefix(std::min(rest.size(), declaration.size() + 1));
        const std::size_t colon = declaration.find(':');
        if (colon == std::string_view::npos || trimmed(declaration.substr(0, colon)) != property) continue;
        value = trimmed(declaration.substr(colon + 1));
    }
    return value;
}

/// The id that a `clip-path` or `mask` names as url(#id), with or without quotes; empty if none.
std::string referenced_id(pugi::xml_node node, const char* property) {
    std::string value = style_property(node, property);
    if (value.empty()) value = attribute_text(node, property);
    const std::size_t url = value.find("url(");
    if (url == std::string::npos) return {};
    const std::size_t begin = value.find_first_not_of(" \"'", url + 4);
    if (begin == std::string::npos || value[begin] != '#') return {};
    const std::size_t end = value.find_first_of(" \"')", begin);
    return end == std::string::npos ? std::string() : value.substr(begin + 1, end - begin - 1);
}

void set_referenced_id(pugi::xml_node node, const char* property, const std::string& old,
                       const std::string& fresh) {
    if (style_property(node, property).empty()) return set_attribute(node, property, "url(#" + fresh + ')');
    std::string style = node.attribute("style").value();
    const std::size_t at = style.find('#' + old, std::min(style.find(property), style.size()));
    if (at != std::string::npos) style.replace(at + 1, old.size(), fresh);
    set_attribute(node, "style", style);
}

SvgDocument copy_of(const SvgDocument& document) {
    SvgDocument copy;
    copy.name = document.name;
    copy.xml.reset(document.xml);
    pugi::xml_node to = copy.xml;
    for (pugi::xml_node from = document.xml; from && to; from = next_node(from, document.xml)) {
        const auto line = document.lines.find(from.hash_value());
        if (line != document.lines.end()) copy.lines[to.hash_value()] = line->second;
        to = next_node(to, copy.xml);
    }
    return copy;
}

} // namespace detail

SvgResult<SvgDocument> parse_svg(std::string_view text, std::string name) {
    SvgDocument document;
    document.name = std::move(name);
    const auto refuse = [&](const std::string& why) { return SvgError{document.name + ": " + why}; };
    if (detail::is_blank(text)) return refuse("the file is empty");

    // no parse_escapes, parse_eol or parse_wconv_attribute: text stays as it is, entities of a doctype too
    const unsigned flags = pugi::parse_pi | pugi::parse_comments | pugi::parse_cdata |
                           pugi::parse_declaration | pugi::parse_doctype | pugi::parse_ws_pcdata |
                           pugi::parse_fragment;
    const pugi::xml_parse_result parsed = document.xml.load_buffer(text.data(), text.size(), flags);
    const bool utf8 = parsed.encoding == pugi::encoding_utf8;
    const std::string broken = document.name + ": not XML: ";
    if (utf8 && text.find('\0') != std::string_view::npos) {
        return error_in_text(broken + "null character", text, text.find('\0'));
    }
    if (!parsed) {
        const auto at = static_cast<std::size_t>(std::max<std::ptrdiff_t>(parsed.offset, 0));
        return utf8 ? error_in_text(broken + parsed.description(), text, std::min(at, text.size()))
                    : SvgError{broken + parsed.description()};
    }

    const pugi::xml_node root = detail::root_element(document.xml);
    if (!root) return refuse("not XML: there is no element");
    for (const pugi::xml_node node : document.xml.children()) {
        const bool stray = node.type() == pugi::node_pcdata && !detail::is_blank(node.value());
        if (stray || node.type() == pugi::node_cdata) return refuse("not XML: text outside the root element");
        if (node.type() == pugi::node_element && node != root) return refuse("not XML: two root elements");
    }
    if (detail::local_name(root) != "svg") {
        return refuse("not SVG: the root element is <" + std::string(root.name()) + '>');
    }

    int depth = 0;
    std::size_t line = 1;
    std::size_t counted = 0;
    for (pugi::xml_node node = root; node;) {
        const std::ptrdiff_t offset = node.offset_debug();
        if (utf8 && node.type() == pugi::node_element && offset >= 0) {
            const std::size_t at = std::min(static_cast<std::size_t>(offset), text.size());
            line +=
                static_cast<std::size_t>(std::count(text.begin() + static_cast<std::ptrdiff_t>(counted),
                                                    text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
            counted = at;
            document.lines[node.hash_value()] = line;
        }
        for (pugi::xml_attribute attribute : node.attributes()) { // they were between single quotes
            std::string value = attribute.value();
            if (value.find('"') == std::string::npos) continue;
            for (std::size_t at = value.find('"'); at != std::string::npos; at = value.find('"', at)) {
                value.replace(at, 1, "&quot;");
            }
            attribute.set_value(value.c_str());
        }
        const pugi::xml_node next = detail::next_node(node, root);
        if (next && next.parent() == node) {
            if (++depth > detail::max_svg_depth) {
                return detail::error_at(document, node, "elements are nested too deeply");
            }
        } else if (next) {
            for (pugi::xml_node up = node; up.parent() != next.parent(); up = up.parent()) --depth;
        }
        node = next;
    }
    for (const pugi::xml_node node : document.xml.children()) {
        const bool states = node.type() == pugi::node_declaration && node.attribute("encoding");
        if (states && !utf8) node.attribute("encoding").set_value("UTF-8");
    }
    return document;
}

SvgResult<SvgDocument> load_svg(const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    std::error_code error;
    if (!std::filesystem::exists(path, error)) return SvgError{name + ": no such file: " + path.string()};
    if (std::filesystem::is_directory(path, error)) return SvgError{name + ": is a folder: " + path.string()};
    std::ifstream file(path, std::ios::binary);
    if (!file) return SvgError{name + ": cannot be opened: " + path.string()};
    const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (file.bad()) return SvgError{name + ": cannot be read: " + path.string()};
    return parse_svg(text, name);
}

std::string to_text(const SvgDocument& document) {
    std::ostringstream stream;
    document.xml.save(stream, "", pugi::format_raw | pugi::format_no_escapes | pugi::format_no_declaration,
                      pugi::encoding_utf8);
    return std::move(stream).str();
}

std::optional<SvgError> save_svg(const SvgDocument& document, const std::filesystem::path& path) {
    const std::optional<std::string> failure = write_file_atomically(path, to_text(document));
    return failure ? std::optional(SvgError{*failure}) : std::nullopt;
}

SvgResult<ViewBox> view_box(const SvgDocument& document) {
    const pugi::xml_node root = detail::root_element(document.xml);
    if (root.attribute("viewBox")) {
        const auto v = parse_numbers(detail::attribute_text(root, "viewBox"));
        if (!v || v->size() != 4) return detail::error_at(document, root, "viewBox is not four numbers");
        if ((*v)[2] > 0 && (*v)[3] > 0) return ViewBox{(*v)[0], (*v)[1], (*v)[2], (*v)[3]};
    }
    const auto width = parse_length(detail::attribute_text(root, "width"), 0);
    const auto height = parse_length(detail::attribute_text(root, "height"), 0);
    if (width && height && *width > 0 && *height > 0) return ViewBox{0, 0, *width, *height};
    return ViewBox{0, 0, 300, 150};
}

namespace detail {

/// The attributes that give each shape its geometry; they are replaced by `d`.
const std::map<std::string, std::vector<const char*>>& shape_attributes() {
    static const std::map<std::string, std::vector<const char*>> table = {
        {"path", {"d"}},
        {"rect", {"x", "y", "width", "height", "rx", "ry"}},
        {"circle", {"cx", "cy", "r"}},
        {"ellipse", {"cx", "cy", "rx", "ry"}},
        {"line", {"x1", "y1", "x2", "y2"}},
        {"polyline", {"points"}},
        {"polygon", {"points"}}};
    return table;
}

bool is_shape(const std::string& kind) {
    return shape_attributes().count(kind) != 0;
}

bool is_group(const std::string& kind) {
    return kind == "g" || kind == "a" || kind == "switch" || kind == "svg";
}

bool is_fixed(const std::string& kind) {
    return kind == "text" || kind == "image" || kind == "foreignObject";
}

/// Walks what is drawn, in document order. The document is changed on the way, without changing what it
/// shows: every `use` becomes a group with a copy, and, where references are followed, clip paths and
/// masks needed under several transforms are copied. Give it a copy of the user's document.
class ShapeCollector {
public:
    ShapeCollector(SvgDocument& document, bool follow_references)
        : document_(document)
        , follow_references_(follow_references) {}

    std::optional<SvgError> collect() {
        const pugi::xml_node root = root_element(document_.xml);
        for (pugi::xml_node node = root; node; node = next_node(node, root)) {
            if (node.attribute("id")) ids_.try_emplace(attribute_text(node, "id"), node);
        }
        const auto view = view_box(document_);
        if (!view) return view.error();
        const Viewport viewport{view->width, view->height};
        if (visit_references(root, {}, viewport, 0)) visit_children(root, {}, viewport, 0);
        return error_;
    }

    std::vector<DrawnShape> shapes;
    std::vector<std::string> warnings;

private:
    struct Viewport { // what percentages are of
        double width = 0;
        double height = 0;
        double diagonal() const { return std::sqrt((width * width + height * height) / 2); }
    };

    struct Claim { // a clip path or mask whose content is deformed under this transform
        Affine2 to_root;
        std::string id;
    };

    bool fail(pugi::xml_node node, const std::string& why) {
        if (!error_) error_ = error_at(document_, node, why);
        return false;
    }

    /// An error inside an attribute: its line and column are counted in the attribute.
    bool fail_in(pugi::xml_node node, const std::string& attribute, const SvgError& error) {
        const std::string place = std::to_string(error.line) + ':' + std::to_string(error.column);
        return fail(node, attribute + " at " + place + ": " + error.message);
    }

    void warn(pugi::xml_node node, const std::string& why) {
        warnings.push_back(label(document_, node) + ": " + why);
    }

    bool visit(pugi::xml_node node, const Affine2& parent, const Viewport& viewport, int depth) {
        const std::string kind = local_name(node);
        if (depth > max_svg_depth) return fail(node, "elements are nested too deeply");
        if (kind == "use") return visit_use(node, parent, viewport, depth);
        if (!is_group(kind) && !is_shape(kind) && !is_fixed(kind)) return true;

        // Pages and hidden layers need not lie in the cage. To be read (a cage, say) a shape may be hidden.
        if (follow_references_ &&
            (attribute_text(node, "display") == "none" || style_property(node, "display") == "none")) {
            warn(node, "is not displayed and stays as it is");
            return true;
        }
        Affine2 to_root = parent;
        if (!apply_transform(node, to_root)) return false;
        if (!visit_references(node, to_root, viewport, depth)) return false;
        if (is_shape(kind)) return add_shape(node, kind, to_root, viewport);
        if (is_fixed(kind)) {
            warn(node, "cannot be deformed and stays as it is");
            return true;
        }
        if (kind != "svg") return visit_children(node, to_root, viewport, depth);

        const double x = length(node, "x", viewport.width, 0);
        const double y = length(node, "y", viewport.height, 0);
        Viewport inner{length(node, "width", viewport.width, viewport.width),
                       length(node, "height", viewport.height, viewport.height)};
        to_root = compose(to_root, {1, 0, 0, 1, x, y});
        if (!enter_view_box(node, to_root, inner)) return false;
        return visit_children(node, to_root, inner, depth);
    }

    bool visit_children(pugi::xml_node node, const Affine2& to_root, const Viewport& viewport, int depth) {
        for (pugi::xml_node child = node.first_child(); child;) {
            const pugi::xml_node next = child.next_sibling();
            if (!visit(child, to_root, viewport, depth + 1)) return false;
            child = next;
        }
        return true;
    }

    bool apply_transform(pugi::xml_node node, Affine2& to_root) {
        const auto map = parse_transform(attribute_text(node, "transform"));
        if (!map) return fail_in(node, "transform", map.error());
        to_root = compose(to_root, *map);
        if (!style_property(node, "transform").empty()) warn(node, "a transform in a style is not read");
        return true;
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

    bool visit_use(pugi::xml_node use, const Affine2& parent, const Viewport& viewport, int depth) {
        std::string reference = attribute_text(use, "href");
        for (const pugi::xml_attribute attribute : use.attributes()) {
            const std::string_view name = attribute.name();
            if (!use.attribute("href") && name.ends_with(":href")) reference = unescaped(attribute.value());
        }
        const auto found = reference.starts_with('#') ? ids_.find(reference.substr(1)) : ids_.end();
        if (found == ids_.end()) {
            warn(use, "refers to nothing in this file (\"" + reference + "\") and stays as it is");
            return true;
        }
        const pugi::xml_node target = found->second;
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

        const double x = length(use, "x", viewport.width, 0);
        const double y = length(use, "y", viewport.height, 0);
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
            if (use.attribute("id")) ids_[attribute_text(use, "id")] = copy;
            use.parent().remove_child(use);
            return visit(copy, parent, viewport, depth);
        }

        if (!transform.empty()) set_attribute(use, "transform", transform);
        use.set_name((name_prefix(use) + 'g').c_str());
        const pugi::xml_node copy = use.append_copy(target);
        drop_ids(copy);
        if (kind == "svg") {
            if (!width.empty()) set_attribute(copy, "width", width);
            if (!height.empty()) set_attribute(copy, "height", height);
        }
        if (kind == "symbol" && !symbol_to_group(copy, width, height, viewport)) return false;
        active_.push_back(target);
        const bool good = visit(use, parent, viewport, depth);
        active_.pop_back();
        return good;
    }

    bool symbol_to_group(pugi::xml_node copy, const std::string& width, const std::string& height,
                         const Viewport& viewport) {
        if (!width.empty()) set_attribute(copy, "width", width);
        if (!height.empty()) set_attribute(copy, "height", height);
        Viewport inner{length(copy, "width", viewport.width, viewport.width),
                       length(copy, "height", viewport.height, viewport.height)};
        Affine2 m;
        if (!enter_view_box(copy, m, inner)) return false;
        std::string transform = copy.attribute("transform").value();
        if (!(m == Affine2())) {
            transform += transform.empty() ? "matrix(" : " matrix(";
            for (const double value : {m.a, m.b, m.c, m.d, m.e, m.f}) {
                transform += format_number(value, 17) + ' ';
            }
            transform.back() = ')';
            set_attribute(copy, "transform", transform);
        }
        const auto unused = {"viewBox", "preserveAspectRatio", "x", "y", "width", "height", "refX", "refY"};
        for (const char* name : unused) copy.remove_attribute(name);
        copy.set_name((name_prefix(copy) + 'g').c_str());
        return true;
    }

    bool count_copies(pugi::xml_node top) {
        for (pugi::xml_node node = top; node; node = next_node(node, top)) ++copies_;
        return copies_ <= max_svg_copies;
    }

    static void drop_ids(pugi::xml_node top) {
        for (pugi::xml_node node = top; node; node = next_node(node, top)) node.remove_attribute("id");
    }

    // ---- clip paths and masks ----

    bool visit_references(pugi::xml_node node, const Affine2& to_root, const Viewport& viewport, int depth) {
        if (!follow_references_) return true;
        const auto good = [&](const char* property, const std::string& kind, const char* units) {
            const std::string id = referenced_id(node, property);
            const auto found = ids_.find(id);
            if (id.empty() || found == ids_.end() || local_name(found->second) != kind) return true;
            return visit_reference(node, property, id, units, found->second, to_root, viewport, depth);
        };
        return good("clip-path", "clipPath", "clipPathUnits") && good("mask", "mask", "maskContentUnits");
    }

    bool visit_reference(pugi::xml_node node, const char* property, const std::string& id, const char* units,
                         pugi::xml_node target, const Affine2& to_root, const Viewport& viewport, int depth) {
        if (attribute_text(target, units) == "objectBoundingBox") {
            warn(target, "is in units of the bounding box and stays as it is");
            return true;
        }
        if (std::find(active_.begin(), active_.end(), target) != active_.end()) {
            return fail(node, "refers to itself through \"#" + id + '"');
        }
        std::vector<Claim>& claims = claims_[target.hash_value()];
        const auto same = std::find_if(claims.begin(), claims.end(),
                                       [&](const Claim& claim) { return claim.to_root == to_root; });
        if (same != claims.end()) {
            if (same->id != id) set_referenced_id(node, property, id, same->id);
            return true;
        }

        pugi::xml_node content = target;
        std::string content_id = id;
        if (!claims.empty()) {
            if (!count_copies(target)) return fail(node, "the clip paths of this file expand to too much");
            content = target.parent().insert_copy_after(target, target);
            drop_ids(content);
            for (std::size_t i = claims.size() + 1; ids_.count(content_id) != 0; ++i) {
                content_id = id + '-' + std::to_string(i);
            }
            ids_[content_id] = content;
            set_attribute(content, "id", content_id);
            set_referenced_id(node, property, id, content_id);
        }
        claims.push_back({to_root, content_id});
        if (attribute_text(content, "maskUnits") == "userSpaceOnUse") {
            warn(content, "is deformed inside, but the rectangle that limits it stays");
        }

        Affine2 inner = to_root;
        if (local_name(content) == "clipPath" && !apply_transform(content, inner)) return false;
        active_.push_back(target);
        const bool good = visit_references(content, inner, viewport, depth + 1) &&
                          visit_children(content, inner, viewport, depth + 1);
        active_.pop_back();
        return good;
    }

    // ---- shapes ----

    double length(pugi::xml_node node, const char* name, double whole, double otherwise) {
        const std::string text = attribute_text(node, name);
        if (is_blank(text) || trimmed(text) == "auto") return otherwise;
        const auto value = parse_length(text, whole);
        if (value) return *value;
        fail_in(node, name, value.error());
        return otherwise;
    }

    bool add_shape(pugi::xml_node node, const std::string& kind, const Affine2& to_root,
                   const Viewport& viewport) {
        Path path;
        if (kind == "path") {
            const std::string data = attribute_text(node, "d");
            auto parsed = parse_path_data(trimmed(data) == "none" ? std::string_view() : data);
            if (!parsed) return fail_in(node, "d", parsed.error());
            path = std::move(*parsed);
        } else if (kind == "polygon" || kind == "polyline") {
            if (!points_path(node, kind == "polygon", path)) return false;
        } else {
            path = basic_path(node, kind, viewport);
        }
        if (error_) return false;
        if (path.empty()) return true;
        const std::optional<Affine2> from_root = inverse(to_root);
        if (!from_root) {
            warn(node, "has a transform without inverse and stays as it is");
            return true;
        }
        path = transformed(std::move(path), to_root);
        if (!in_range(path)) return fail(node, "coordinates out of range");
        shapes.push_back({node, to_root, *from_root, std::move(path)});
        return true;
    }

    bool points_path(pugi::xml_node node, bool closed, Path& path) {
        const auto numbers = parse_numbers(attribute_text(node, "points"));
        if (!numbers) return fail_in(node, "points", numbers.error());
        if (numbers->size() % 2 != 0) return fail(node, "points: an odd number of coordinates");
        PathBuilder builder;
        for (std::size_t i = 0; i < numbers->size(); i += 2) {
            const Point2 p{(*numbers)[i], (*numbers)[i + 1]};
            i == 0 ? builder.move_to(p) : builder.line_to(p);
        }
        if (closed) builder.close();
        path = builder.take();
        return true;
    }

    /// rect, circle, ellipse and line, drawn from SVG's starting points in its direction; empty where the
    /// shape is not drawn because a size is zero.
    Path basic_path(pugi::xml_node node, const std::string& kind, const Viewport& viewport) {
        const auto across = [&](const char* name, double otherwise) {
            return length(node, name, viewport.width, otherwise);
        };
        const auto down = [&](const char* name, double otherwise) {
            return length(node, name, viewport.height, otherwise);
        };
        PathBuilder builder;
        if (kind == "line") {
            builder.move_to({across("x1", 0), down("y1", 0)});
            builder.line_to({across("x2", 0), down("y2", 0)});
            return builder.take();
        }
        if (kind == "rect") {
            const double x = across("x", 0);
            const double y = down("y", 0);
            const double width = across("width", 0);
            const double height = down("height", 0);
            if (!(width > 0 && height > 0)) return {};
            double rx = across("rx", -1); // negative: as the other one
            double ry = down("ry", -1);
            if (rx < 0) rx = std::max(ry, 0.0);
            if (ry < 0) ry = rx;
            rx = std::min(rx, width / 2);
            ry = std::min(ry, height / 2);
            const bool round = rx > 0 && ry > 0;
            if (!round) rx = ry = 0;
            const auto line = [&](const Point2& p) {
                if (!(p == builder.current())) builder.line_to(p);
            };
            const auto corner = [&](const Point2& p) {
                if (round) builder.arc_to(rx, ry, 0, false, true, p);
            };
            builder.move_to({x + rx, y});
            line({x + width - rx, y});
            corner({x + width, y + ry});
            line({x + width, y + height - ry});
            corner({x + width - rx, y + height});
            line({x + rx, y + height});
            corner({x, y + height - ry});
            line({x, y + ry});
            corner({x + rx, y});
            builder.close();
            return builder.take();
        }
        const Point2 centre{across("cx", 0), down("cy", 0)};
        double rx = kind == "circle" ? length(node, "r", viewport.diagonal(), 0) : across("rx", -1);
        double ry = kind == "circle" ? rx : down("ry", -1);
        if (rx < 0) rx = ry;
        if (ry < 0) ry = rx;
        if (!(rx > 0 && ry > 0)) return {};
        builder.move_to({centre.x + rx, centre.y});
        builder.arc_to(rx, ry, 0, false, true, {centre.x, centre.y + ry});
        builder.arc_to(rx, ry, 0, false, true, {centre.x - rx, centre.y});
        builder.arc_to(rx, ry, 0, false, true, {centre.x, centre.y - ry});
        builder.arc_to(rx, ry, 0, false, true, {centre.x + rx, centre.y});
        builder.close();
        return builder.take();
    }

    SvgDocument& document_;
    bool follow_references_;
    std::map<std::string, pugi::xml_node> ids_;
    std::unordered_map<std::size_t, std::vector<Claim>> claims_; // by the node they were first found on
    std::vector<pugi::xml_node> active_; // used elements, clip paths and masks that we are inside of
    std::size_t copies_ = 0;
    std::optional<SvgError> error_;
};

SvgResult<std::vector<DrawnShape>> drawn_shapes(SvgDocument& document, std::vector<std::string>& warnings) {
    ShapeCollector collector(document, true);
    if (std::optional<SvgError> error = collector.collect()) return *error;
    warnings.insert(warnings.end(), collector.warnings.begin(), collector.warnings.end());
    return std::move(collector.shapes);
}

// ---- style sheets ----

/// Replaces type selectors "rect" by ".cageform-rect" for the given types, in the selectors of a style
/// sheet only; `met` receives the types found, and "." or "#" where classes or ids are selected too.
std::string replace_type_selectors(std::string_view css, const std::set<std::string>& types,
                                   std::set<std::string>& met) {
    const auto is_name = [](char c) {
        return is_letter(c) || is_digit(c) || c == '-' || c == '_' || (c & 0x80) != 0;
    };
    std::string result;
    bool in_declarations = false;
    bool at_rule = false;     // between @ and its block
    std::string_view at_name; // of the last one
    char before = ' ';        // the last character that was not in a comment
    for (std::size_t i = 0; i < css.size();) {
        std::size_t end = i + 1;
        if (css.substr(i).starts_with("/*")) {
            end = std::min(css.find("*/", i + 2), css.size() - 2) + 2;
            result += css.substr(i, end - i);
            i = end;
            continue;
        }
        while (is_name(css[i]) && end < css.size() && is_name(css[end])) ++end;
        const std::string word(css.substr(i, end - i));
        const bool selector = !in_declarations && !at_rule;
        const bool type =
            is_space(before) || std::string_view(">+~,;({}").find(before) != std::string_view::npos;
        if (selector && type && types.count(word) != 0) {
            met.insert(word);
            result += ".cageform-";
        } else if (word == "@") {
            at_rule = selector;
            std::size_t stop = end;
            while (stop < css.size() && is_name(css[stop])) ++stop;
            at_name = css.substr(end, stop - end);
        } else if (word == "{") {
            in_declarations = !at_rule || at_name == "font-face" || at_name == "page";
            at_rule = false;
        } else if (word == "}") {
            in_declarations = false;
        } else if (word == ";") {
            at_rule = false;
        }
        if (selector && (word == "." || word == "#")) met.insert(word);
        result += word;
        before = css[end - 1];
        i = end;
    }
    return result;
}

void adapt_style_sheets(SvgDocument& document, std::vector<std::string>& warnings) {
    std::set<std::string> types = {"use"};
    for (const auto& [name, attributes] : shape_attributes()) types.insert(name);
    const pugi::xml_node root = root_element(document.xml);
    bool changes = false;
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        const std::string kind = local_name(node);
        changes = changes || (kind != "path" && types.count(kind) != 0);
    }
    if (!changes) return; // all shapes are paths already

    std::set<std::string> met;
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        if (local_name(node) != "style") continue;
        for (pugi::xml_node text : node.children()) {
            if (text.type() != pugi::node_pcdata && text.type() != pugi::node_cdata) continue;
            const std::string css = replace_type_selectors(text.value(), types, met);
            text.set_value(css.c_str());
            if (css.find("of-type") != std::string::npos) {
                warnings.push_back(label(document, node) + ": \"of-type\" counts the types after the change");
            }
        }
    }
    const bool uses = root.find_node([](pugi::xml_node node) { return local_name(node) == "use"; });
    if (met.erase("#") != 0 && uses) {
        warnings.emplace_back("style sheet: rules by id do not reach the copies of used elements");
    }
    if (met.erase(".") != 0 && !met.empty()) {
        warnings.emplace_back(
            "style sheet: rules by type became rules by class, of equal weight with the others");
    }
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        const std::string kind = local_name(node);
        if (met.count(kind) != 0) add_class(node, "cageform-" + kind);
    }
}

void warn_of_fixed_paint(const SvgDocument& document, std::vector<std::string>& warnings) {
    const pugi::xml_node root = root_element(document.xml);
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        const std::string kind = local_name(node);
        const bool gradient = kind == "linearGradient" || kind == "radialGradient";
        const char* const units = gradient ? "gradientUnits" : "patternUnits";
        if (!gradient && kind != "pattern") continue;
        if (attribute_text(node, units) != "userSpaceOnUse") continue;
        warnings.push_back(label(document, node) + ": is in user space and stays where it is");
    }
}

void write_shape(pugi::xml_node node, const std::string& data) {
    const std::string kind = local_name(node);
    if (kind == "path") {
        set_attribute(node, "d", data);
    } else {
        const std::vector<const char*>& geometry = shape_attributes().at(kind);
        node.remove_attribute("d"); // one without meaning here
        pugi::xml_attribute d;
        for (const pugi::xml_attribute attribute : node.attributes()) {
            const bool replaced = std::find(geometry.begin(), geometry.end(),
                                            std::string_view(attribute.name())) != geometry.end();
            if (replaced && !d) d = node.insert_attribute_before("d", attribute);
        }
        if (!d) d = node.append_attribute("d");
        d.set_value(data.c_str());
        for (const char* name : geometry) node.remove_attribute(name);
        node.set_name((name_prefix(node) + "path").c_str());
    }
    // by these an editor would rebuild the shape as it was
    for (const char* name :
         {"sodipodi:type", "sodipodi:nodetypes", "inkscape:path-effect", "inkscape:original-d"}) {
        node.remove_attribute(name);
    }
}

/// The shapes of a document that stays as it is.
SvgResult<std::vector<SvgShape>> read_shapes(const SvgDocument& document) {
    SvgDocument work = copy_of(document);
    ShapeCollector collector(work, false);
    if (std::optional<SvgError> error = collector.collect()) return *error;
    std::vector<SvgShape> shapes;
    shapes.reserve(collector.shapes.size());
    for (DrawnShape& shape : collector.shapes) {
        shapes.push_back({label(work, shape.node), std::move(shape.path)});
    }
    return shapes;
}

/// Empty if all subpaths are loops of lines with three corners or more, else what the path is instead.
///   loops   the corners of each subpath, the first not repeated at the end, in the order drawn
std::string polygon_loops(const Path& path, std::vector<std::vector<Point2>>& loops) {
    loops.clear();
    for (const Subpath& subpath : path) {
        if (subpath.segments.empty()) continue;
        std::vector<Point2> loop = {subpath.start};
        for (const Segment& s : subpath.segments) {
            if (!s.is_line) return "a path with curves";
            loop.push_back(s.p3);
        }
        if (!(loop.back() == loop.front())) return "an open path";
        loop.pop_back();
        if (loop.size() < 3) return "a path of fewer than three corners";
        loops.push_back(std::move(loop));
    }
    return loops.empty() ? "an empty path" : "";
}

} // namespace detail

SvgResult<std::vector<SvgShape>> shapes(const SvgDocument& document) {
    return detail::read_shapes(document);
}

SvgResult<std::vector<std::vector<Point2>>> first_polygon(const SvgDocument& document) {
    const auto all = shapes(document);
    if (!all) return all.error();
    std::string first;
    for (const SvgShape& shape : *all) {
        std::vector<std::vector<Point2>> loops;
        const std::string found = detail::polygon_loops(shape.path, loops);
        if (found.empty()) return loops;
        if (first.empty()) first = "the first shape is " + found + ": " + shape.label;
    }
    if (first.empty()) first = "there is no shape";
    return SvgError{document.name + ": no closed polygon: " + first};
}

SvgResult<std::vector<Point2>> figure_vertices(const SvgDocument& document) {
    const auto all = shapes(document);
    if (!all) return all.error();
    std::vector<Point2> vertices;
    for (const SvgShape& shape : *all) {
        for (const Subpath& subpath : shape.path) {
            if (subpath.segments.empty()) continue;
            vertices.push_back(subpath.start);
            for (const Segment& s : subpath.segments) vertices.push_back(s.p3);
            if (vertices.back() == subpath.start) vertices.pop_back();
        }
    }
    return vertices;
}

SvgResult<DeformReport> deform(SvgDocument& document, const Deformer& deformer,
                               const DeformOptions& options) {
    DeformReport report;
    SvgDocument work = detail::copy_of(document);
    const auto view = view_box(work);
    if (!view) return view.error();
    detail::adapt_style_sheets(work, report.warnings);
    auto drawn = detail::drawn_shapes(work, report.warnings);
    if (!drawn) return drawn.error();
    detail::warn_of_fixed_paint(work, report.warnings);

    const double diagonal = std::hypot(view->width, view->height);
    const bool given = options.tolerance > 0 && std::isfinite(options.tolerance);
    const double tolerance = given ? options.tolerance : 2e-5 * diagonal;
    std::vector<Path> paths;
    paths.reserve(drawn->size());
    for (detail::DrawnShape& shape : *drawn) paths.push_back(std::move(shape.path));
    detail::CurveDeformer curves(deformer, tolerance, diagonal, options.max_halvings, report);
    if (!curves.run(paths)) return SvgError{work.name + ": " + curves.failure()};

    for (std::size_t i = 0; i < paths.size(); ++i) {
        const Affine2& m = (*drawn)[i].to_root;
        const double scale = std::hypot(std::hypot(m.a, m.b), std::hypot(m.c, m.d));
        int decimals = 0;
        while (decimals < 15 && 20 * scale > tolerance * std::pow(10.0, decimals)) ++decimals;
        if (options.decimals >= 0) decimals = options.decimals;
        const Path local = transformed(std::move(paths[i]), (*drawn)[i].from_root);
        const bool good = detail::in_range(local);
        if (!good) return detail::error_at(work, (*drawn)[i].node, "coordinates out of range");
        detail::write_shape((*drawn)[i].node, write_path_data(local, decimals));
    }
    report.shapes = paths.size();
    document = std::move(work);
    return report;
}

} // namespace cageform_examples

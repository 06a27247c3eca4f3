#include "svg/document.hpp"

#include "io/input_file.hpp"
#include "svg/shapes.hpp"
#include "svg/walk.hpp"
#include "svg/xml.hpp"

#include <cageform/cage/polygon.hpp>

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>
#include <vector>

namespace cageform_support {

namespace detail {

constexpr std::size_t most_of_entity = 256; // bytes of a name, so that parsing is linear

/// The entities that the document type declares in the file, as raw text.
std::map<std::string, std::string, std::less<>> entities_of(const pugi::xml_document& xml) {
    std::map<std::string, std::string, std::less<>> entities;
    for (const pugi::xml_node node : xml.children()) {
        if (node.type() != pugi::node_doctype) continue;
        const std::string_view text = node.value();
        constexpr std::string_view begin = "<!ENTITY";
        for (std::size_t at = text.find(begin); at != std::string_view::npos; at = text.find(begin, at)) {
            at += begin.size();
            const std::string_view head = text.substr(at, most_of_entity);
            const auto words = words_of(head); // "%": a parameter entity
            const std::size_t length = head.find_first_of("\"'>");
            if (length == std::string_view::npos || words.size() < 2 || head[length] == '>') continue;
            const std::size_t open = at + length;
            const std::size_t close = text.find(text[open], open + 1);
            if (close == std::string_view::npos) break;
            const bool is_here = trimmed(head.substr(0, length)) == words.front(); // not external
            if (is_here)
                entities.try_emplace(std::string(words.front()), text.substr(open + 1, close - open - 1));
            at = close;
        }
    }
    for (const char* name : {"lt", "gt", "amp", "quot", "apos"}) entities.erase(name); // XML defines them
    return entities;
}

/// Splits a declaration of a document type into names, quoted texts and groups in brackets.
///
///   at   in: start; out: position of ">", or the end of the text
std::vector<std::string_view> doctype_words(std::string_view text, std::size_t& at) {
    std::vector<std::string_view> words;
    while ((at = text.find_first_not_of(" \t\r\n", at)) < text.size() && text[at] != '>') {
        const bool is_quoted = text[at] == '"' || text[at] == '\'', is_group = text[at] == '(';
        std::size_t end = is_quoted  ? text.find(text[at], at + 1)
                          : is_group ? text.find(')', at)
                                     : text.find_first_of(" \t\r\n\"'(>", at);
        end = end == std::string_view::npos ? text.size() : end + (is_quoted || is_group ? 1 : 0);
        words.push_back(text.substr(at, end - at));
        at = end;
    }
    at = std::min(at, text.size());
    return words;
}

/// Adds the default attributes that the document type declares.
///
///   returns   the error, if any
std::optional<std::string> add_default_attributes(const pugi::xml_document& xml) {
    std::map<std::string, std::map<std::string, std::string>> defaults; // by element, by attribute
    for (const pugi::xml_node node : xml.children()) {
        if (node.type() != pugi::node_doctype) continue;
        const std::string_view text = node.value();
        for (std::size_t at = 0; (at = text.find("<!", at)) != std::string_view::npos; ++at) {
            constexpr std::string_view comment = "<!--", list = "<!ATTLIST";
            if (text.substr(at).starts_with(comment)) at = std::min(text.find("-->", at), text.size());
            if (!text.substr(at).starts_with(list)) continue;
            at += list.size();
            const auto words = doctype_words(text, at);
            for (std::size_t i = 1; i + 2 < words.size(); ++i) { // a name, a type, a value
                const std::string_view name = words[i++];
                if (words[i] == "NOTATION") ++i;
                if (++i < words.size() && words[i] == "#FIXED") ++i;
                if (i >= words.size() || words[i].size() < 2 || words[i].starts_with('#')) continue;
                defaults[std::string(words[0])].try_emplace(std::string(name),
                                                            words[i].substr(1, words[i].size() - 2));
            }
        }
    }
    if (defaults.empty()) return std::nullopt;
    std::size_t size = 0; // of all added attributes
    const pugi::xml_node root = root_element(xml);
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        const auto found = defaults.find(node.name());
        if (node.type() != pugi::node_element || found == defaults.end()) continue;
        for (const auto& [name, value] : found->second) {
            if (node.attribute(name.c_str())) continue;
            size += name.size() + value.size();
            if (size > std::size_t{1} << 24)
                return "the default attributes of the document type take more than 16 MiB";
            node.append_attribute(name.c_str()).set_value(value.c_str());
        }
    }
    return std::nullopt;
}

/// Replaces references to entities of the document type by their text.
class EntityExpander {
public:
    explicit EntityExpander(const pugi::xml_document& xml)
        : entities_(entities_of(xml)) {}

    /// Returns the error, if any.
    std::optional<std::string> expand(pugi::xml_node root) {
        if (entities_.empty()) return std::nullopt;
        for (pugi::xml_node node = root; node && !fault_;) {
            for (pugi::xml_attribute attribute : node.attributes()) {
                const std::string text = expanded(attribute.value(), true);
                if (text != attribute.value()) attribute.set_value(text.c_str());
            }
            const std::string text =
                node.type() == pugi::node_pcdata ? expanded(node.value(), false) : node.value();
            if (text == node.value()) {
                node = next_node(node, root);
                continue;
            }
            pugi::xml_document part; // elements of an entity, and text
            const std::string whole = "<part>" + text + "</part>";
            const unsigned flags = pugi::parse_cdata | pugi::parse_comments | pugi::parse_ws_pcdata;
            if (!part.load_buffer(whole.data(), whole.size(), flags))
                return "an entity is not XML: " + text.substr(0, 60);
            pugi::xml_node last = node;
            for (const pugi::xml_node child : part.first_child().children())
                last = node.parent().insert_copy_after(child, last);
            const pugi::xml_node next = node_after(last, root);
            node.parent().remove_child(node);
            node = next;
        }
        return fault_;
    }

private:
    std::string expanded(std::string_view text, bool is_attribute, int depth = 0) {
        std::string result;
        while (!text.empty()) {
            const std::size_t plain = std::min(text.find('&'), text.size());
            result += text.substr(0, plain);
            text.remove_prefix(plain);
            const std::size_t end = text.substr(0, most_of_entity).find(';');
            const auto found =
                end == std::string_view::npos ? entities_.end() : entities_.find(text.substr(1, end - 1));
            if (found == entities_.end()) {
                result += text.substr(0, 1);
                text.remove_prefix(std::min<std::size_t>(1, text.size()));
                continue;
            }
            const auto& [name, value] = *found;
            size_ += value.size();
            if (is_attribute && value.find('<') != std::string::npos) { // not well-formed XML
                fault_ = "the entity \"" + name + "\" in an attribute has a <";
                return {};
            }
            if (depth > 20 || size_ > std::size_t{1} << 24) {
                fault_ = "the entity \"" + name + "\" expands to more than 16 MiB, or is nested too deeply";
                return {};
            }
            result += expanded(value, is_attribute, depth + 1);
            if (fault_) return {};
            text.remove_prefix(end + 1);
        }
        return result;
    }

    std::map<std::string, std::string, std::less<>> entities_;
    std::size_t size_ = 0; // of all replacements
    std::optional<std::string> fault_;
};

/// Replaces other prefixes of the SVG namespace by the prefix of the root.
void unify_prefixes(pugi::xml_node root) {
    constexpr std::string_view space = "http://www.w3.org/2000/svg";
    const std::string prefix = name_prefix(root);
    const auto means_svg = [&](pugi::xml_node node, const std::string& its) {
        const std::string name = its.empty() ? "xmlns" : "xmlns:" + its.substr(0, its.size() - 1);
        while (node && !node.attribute(name.c_str())) node = node.parent();
        return node && attribute_text(node, name.c_str()) == space;
    };
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        if (node.type() != pugi::node_element) continue;
        const std::string name = node.name();
        const std::string its = name.substr(0, name.find(':') + 1); // npos + 1 is zero
        if (its == prefix || !means_svg(node, its) || !means_svg(node, prefix)) continue;
        node.set_name((prefix + name.substr(its.size())).c_str());
    }
}

/// Records the line numbers of elements, escapes quotes in attribute values, and limits the depth.
///
///   text      of the file; empty if its encoding is not UTF-8, then lines are unknown
///   returns   the error, if any
std::optional<FileError> record_lines(SvgDocument& document, pugi::xml_node root, std::string_view text) {
    int depth = 0;
    std::size_t line = 1;
    std::size_t counted = 0;
    for (pugi::xml_node node = root; node;) {
        const std::ptrdiff_t offset = node.offset_debug();
        if (!text.empty() && node.type() == pugi::node_element && offset >= 0) {
            const std::size_t at = std::min(static_cast<std::size_t>(offset), text.size());
            line +=
                static_cast<std::size_t>(std::count(text.begin() + static_cast<std::ptrdiff_t>(counted),
                                                    text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
            counted = at;
            document.lines[node.hash_value()] = line;
        }
        for (pugi::xml_attribute attribute : node.attributes()) { // values that were in single quotes
            std::string value = attribute.value();
            if (value.find('"') == std::string::npos) continue;
            for (std::size_t at = value.find('"'); at != std::string::npos; at = value.find('"', at)) {
                value.replace(at, 1, "&quot;");
            }
            attribute.set_value(value.c_str());
        }
        const pugi::xml_node next = next_node(node, root);
        if (next && next.parent() == node) {
            if (++depth > max_svg_depth) {
                return error_at(document, node, "elements are nested too deeply");
            }
        } else if (next) {
            for (pugi::xml_node up = node; up.parent() != next.parent(); up = up.parent()) --depth;
        }
        node = next;
    }
    return std::nullopt;
}

} // namespace detail

Expected<SvgDocument> parse_svg(std::string_view text, std::string name) {
    SvgDocument document;
    document.name = std::move(name);
    const auto refuse = [&](const std::string& why) { return FileError{document.name + ": " + why}; };
    if (detail::is_blank(text)) return refuse("the file is empty");

    // without parse_escapes, parse_eol and parse_wconv_attribute, so that text and entities stay as in the
    // file
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
                    : FileError{broken + parsed.description()};
    }

    const pugi::xml_node root = detail::root_element(document.xml);
    if (!root) return refuse("not XML: there is no element");
    if (const auto fault = detail::add_default_attributes(document.xml)) return refuse(*fault);
    if (const auto fault = detail::EntityExpander(document.xml).expand(root)) return refuse(*fault);
    for (const pugi::xml_node node : document.xml.children()) {
        const bool stray = node.type() == pugi::node_pcdata && !detail::is_blank(node.value());
        if (stray || node.type() == pugi::node_cdata) return refuse("not XML: text outside the root element");
        if (node.type() == pugi::node_element && node != root) return refuse("not XML: two root elements");
    }
    if (detail::local_name(root) != "svg") {
        return refuse("not SVG: the root element is <" + std::string(root.name()) + '>');
    }

    if (const auto error = detail::record_lines(document, root, utf8 ? text : std::string_view()))
        return *error;
    detail::unify_prefixes(root); // searches ancestors: after the check of the depth
    for (const pugi::xml_node node : document.xml.children()) {
        const bool states = node.type() == pugi::node_declaration && node.attribute("encoding");
        if (states && !utf8) node.attribute("encoding").set_value("UTF-8");
    }
    return document;
}

namespace {

/// Decompresses a gzip file (.svgz). Fails if it is damaged or too large.
Expected<std::string> unpacked(std::string_view packed, const std::string& name) {
    constexpr std::size_t most = std::size_t{1} << 28; // bytes
    z_stream stream{};
    if (inflateInit2(&stream, 16 + MAX_WBITS) != Z_OK) return FileError{name + ": out of memory"};
    std::vector<Bytef> in(packed.begin(), packed.end()), out(std::size_t{1} << 16);
    stream.next_in = in.data();
    stream.avail_in = static_cast<uInt>(in.size());
    std::string text;
    int state = Z_OK;
    while (state == Z_OK && text.size() <= most) {
        stream.next_out = out.data();
        stream.avail_out = static_cast<uInt>(out.size());
        state = inflate(&stream, Z_NO_FLUSH);
        text.append(out.begin(), out.end() - static_cast<std::ptrdiff_t>(stream.avail_out));
    }
    inflateEnd(&stream);
    if (text.size() > most) return FileError{name + ": is larger than 256 MiB when unpacked"};
    if (state != Z_STREAM_END) return FileError{name + ": a damaged gzip file"};
    return text;
}

} // namespace

Expected<SvgDocument> load_svg(const std::filesystem::path& path) {
    const auto text = read_file(path.string());
    if (!text) return text.error();
    const std::string name = path.filename().string();
    if (!text->starts_with("\x1f\x8b")) return parse_svg(*text, name);
    const auto whole = unpacked(*text, name);
    return whole ? parse_svg(*whole, name) : whole.error();
}

std::string to_text(const SvgDocument& document) {
    std::ostringstream stream;
    document.xml.save(stream, "", pugi::format_raw | pugi::format_no_escapes | pugi::format_no_declaration,
                      pugi::encoding_utf8);
    return std::move(stream).str();
}

std::optional<ViewBox> detail::view_box_of(pugi::xml_node node) {
    const auto v = parse_numbers(attribute_text(node, "viewBox"));
    if (!v || v->size() != 4) return std::nullopt;
    return ViewBox{(*v)[0], (*v)[1], (*v)[2], (*v)[3]};
}

ViewBox view_box(const SvgDocument& document) {
    const pugi::xml_node root = detail::root_element(document.xml);
    const auto given = detail::view_box_of(root);
    if (given && given->width > 0 && given->height > 0) return *given;
    const auto width = parse_length(detail::attribute_text(root, "width"), 0);
    const auto height = parse_length(detail::attribute_text(root, "height"), 0);
    if (width && height && *width > 0 && *height > 0) return ViewBox{0, 0, *width, *height};
    return ViewBox{0, 0, 300, 150};
}

namespace detail {

/// Shapes of a document, which stays unchanged.
Expected<std::vector<SvgShape>> read_shapes(const SvgDocument& document, bool as_cage = false) {
    SvgDocument work = copy_of(document);
    std::vector<std::string> ignored;
    StyleSheets styles(work);
    IdTable ids(root_element(work.xml));
    auto drawing =
        walk(work, styles, ids, {.follow_references = false, .as_cage = as_cage, .is_strict = true}, ignored);
    if (!drawing) return drawing.error();
    std::vector<SvgShape> shapes;
    shapes.reserve(drawing->shapes.size());
    for (DrawnShape& shape : drawing->shapes) {
        const bool is_circle = local_name(shape.node) == "circle";
        shapes.push_back({label(work, shape.node), std::move(shape.path), is_circle});
    }
    for (const pugi::xml_node& node : drawing->flat_circles) shapes.push_back({label(work, node), {}, true});
    return shapes;
}

/// Returns empty if all subpaths are closed polygons; else a description of the path.
///
///   loops   out: the corners of each subpath in document order, the first not repeated
std::string polygon_loops(const Path& path, std::vector<std::vector<Point2>>& loops) {
    loops.clear();
    for (const Subpath& subpath : path) {
        if (subpath.segments.empty()) continue;
        std::vector<Point2> loop = {subpath.start};
        for (const Segment& s : subpath.segments) {
            if (!s.is_line()) return "a path with curves";
            loop.push_back(s.p3);
        }
        if (!(loop.back() == loop.front())) return "an open path";
        loop.pop_back();
        if (loop.size() < 3) return "a path of fewer than three corners";
        loops.push_back(std::move(loop));
    }
    return loops.empty() ? "an empty path" : "";
}

/// Closes subpaths whose ends are within the coincidence tolerance of their starts; a line that Z has added
/// between them is removed. Subpaths without segments are removed.
///
///   returns   #path: whether it is closed
std::vector<bool> close_loops(std::vector<Subpath>& path) {
    std::erase_if(path, [](const Subpath& subpath) { return subpath.segments.empty(); });
    std::vector<cageform::Vec<double, 2>> points;
    for (const Subpath& subpath : path) {
        points.push_back({subpath.start.x, subpath.start.y});
        for (const Segment& s : subpath.segments)
            points.insert(points.end(), {{s.p1.x, s.p1.y}, {s.p2.x, s.p2.y}, {s.p3.x, s.p3.y}});
    }
    const auto box = cageform::bounds_of(std::span<const cageform::Vec<double, 2>>(points));
    const double tolerance = cageform::coincidence_tolerance(box);
    std::vector<bool> closed;
    for (auto& [start, segments, is_closed, has_closing_line] : path) {
        const auto meets = [&, &begin = start](const Point2& p) {
            return std::hypot(p.x - begin.x, p.y - begin.y) <= tolerance;
        };
        if (has_closing_line && segments.size() > 1 && meets(segments[segments.size() - 2].p3))
            segments.pop_back();
        closed.push_back(meets(segments.back().p3));
        if (closed.back()) segments.back().p3 = start;
    }
    return closed;
}

} // namespace detail

Expected<std::vector<SvgShape>> shapes(const SvgDocument& document) {
    return detail::read_shapes(document);
}

Expected<std::vector<std::vector<Point2>>> first_polygon(const SvgDocument& document) {
    const auto all = shapes(document);
    if (!all) return all.error();
    std::string first;
    for (const SvgShape& shape : *all) {
        if (shape.path.empty()) continue;
        std::vector<std::vector<Point2>> loops;
        const std::string found = detail::polygon_loops(shape.path, loops);
        if (found.empty()) return loops;
        if (first.empty()) first = "the first shape is " + found + ": " + shape.label;
    }
    if (first.empty()) first = "there is no shape";
    return FileError{document.name + ": no closed polygon: " + first};
}

Expected<std::vector<Subpath>> first_outline(const SvgDocument& document) {
    auto all = detail::read_shapes(document, true);
    if (!all) return all.error();
    std::string first = "there is no shape";
    for (SvgShape& shape : *all) {
        const std::vector<bool> closed = detail::close_loops(shape.path);
        const auto open = std::find(closed.begin(), closed.end(), false);
        if (open == closed.end() && !closed.empty()) return std::move(shape.path);
        if (open != closed.end() && first.starts_with("there")) {
            const auto number = open - closed.begin();
            const Subpath& subpath = shape.path[std::size_t(number)];
            const auto place = [](const Point2& p) {
                return '(' + format_number(p.x, 6) + ", " + format_number(p.y, 6) + ')';
            };
            first = cageform::to_string(cageform::Status::loop_not_closed) + std::string(": subpath ") +
                    std::to_string(number) + ", counted from 0, of " + shape.label + " begins at " +
                    place(subpath.start) + " and ends at " + place(subpath.segments.back().p3);
        }
        if (std::find(closed.begin(), closed.end(), true) != closed.end()) break;
    }
    return FileError{document.name + ": no closed outline: " + first};
}

Expected<std::vector<std::vector<Point2>>> straight_lines(const SvgDocument& document) {
    const auto all = shapes(document);
    if (!all) return all.error();
    std::vector<std::vector<Point2>> lines;
    for (const SvgShape& shape : *all) {
        for (const Subpath& subpath : shape.path) {
            if (subpath.segments.empty()) continue;
            auto& line = lines.emplace_back();
            line.push_back(subpath.start);
            for (const Segment& s : subpath.segments) {
                if (!s.is_line())
                    return FileError{document.name + ": curves, where lines are needed: " + shape.label};
                line.push_back(s.p3);
            }
        }
    }
    return lines;
}

Expected<std::vector<Point2>> figure_vertices(const SvgDocument& document) {
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

} // namespace cageform_support

#include "pictures/text.hpp"

#include "io/csv.hpp"
#include "io/messages.hpp"
#include "pictures/render.hpp"
#include "svg/css_geometry.hpp"
#include "svg/walk.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <map>
#include <memory>
#include <utility>

namespace cageform_support {

namespace detail {

namespace {

const char* const number_attribute = "cageform-text";

/// A text that is drawn in place.
struct DrawnText {
    pugi::xml_node node; // in the document
    Affine2 to_root;
    Affine2 from_root;
    std::size_t first_colour = 0; // of its elements, in document order
};

bool is_drawn_in_place(pugi::xml_node text) {
    for (pugi::xml_node up = text.parent(); up.type() == pugi::node_element; up = up.parent()) {
        if (!is_group(local_name(up))) return false;
    }
    return true;
}

/// Expands <use> elements, as the deformation does, so that their texts are drawn in place.
std::optional<FileError> expand_used_texts(SvgDocument& document, std::vector<std::string>& warnings) {
    const pugi::xml_node root = root_element(document.xml);
    const auto has = [&](const char* kind) {
        return static_cast<bool>(
            root.find_node([&](pugi::xml_node node) { return local_name(node) == kind; }));
    };
    if (!has("text") || !has("use")) return std::nullopt;
    StyleSheets styles(document);
    IdTable ids(root);
    std::vector<std::string> given_later; // warnings, which the deformation repeats
    const auto drawing = walk(document, styles, ids, {.boxes = true}, given_later);
    if (!drawing) return drawing.error();
    styles.settle(warnings);
    return std::nullopt;
}

/// Numbers all texts of a document in an attribute; returns them.
std::vector<pugi::xml_node> number_texts(SvgDocument& document) {
    std::vector<pugi::xml_node> texts;
    const pugi::xml_node root = root_element(document.xml);
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        if (local_name(node) != "text" || !is_drawn_in_place(node)) continue;
        set_attribute(node, number_attribute, std::to_string(texts.size()));
        texts.push_back(node);
    }
    return texts;
}

std::string colour_of(std::size_t number) {
    return formatted("#%06x", static_cast<unsigned>(number & 0xffffff));
}

/// Inverse of colour_of(), in cairo's notation rgb(…%,…%,…%); nothing for other colours.
std::optional<std::size_t> number_of(const std::string& fill) {
    std::array<double, 3> rgb{};
    if (std::sscanf(fill.c_str(), "rgb(%lf%%,%lf%%,%lf%%)", &rgb[0], &rgb[1], &rgb[2]) != 3)
        return std::nullopt;
    std::size_t number = 0;
    for (const double percent : rgb) {
        number = 256 * number + static_cast<std::size_t>(std::lround(std::clamp(percent, 0.0, 100.0) * 2.55));
    }
    return number;
}

/// Per-letter position lists of a text element.
struct PlaceLists {
    static constexpr std::array names{"x", "y", "dx", "dy"};
    std::array<std::vector<std::string>, names.size()> values;
    std::size_t passed = 0; // number of letters so far
};

/// Removes the lists from an element.
PlaceLists take_lists(pugi::xml_node node) {
    PlaceLists lists;
    for (std::size_t k = 0; k < lists.names.size(); ++k) {
        std::string text = attribute_text(node, lists.names[k]);
        std::replace(text.begin(), text.end(), ',', ' ');
        for (const std::string_view word : words_of(text)) lists.values[k].emplace_back(word);
        node.remove_attribute(lists.names[k]);
    }
    return lists;
}

/// Length of the first letter in bytes: a character reference, or a UTF-8 character.
std::size_t letter_bytes(std::string_view text) {
    const std::size_t end = text.front() == '&' ? text.substr(0, 12).find(';') : std::string_view::npos;
    if (end != std::string_view::npos) return end + 1;
    std::size_t count = 1;
    while (count < text.size() && (text[count] & 0xc0) == 0x80) ++count;
    return count;
}

/// Wraps letters with a position in a list in their own <tspan>, since the renderer reads only the first
/// entry of a list.
///
///   open         enclosing elements, from the text on
///   last_space   the last letter if it is a collapsible space; else none
void place_letters(pugi::xml_node node, std::vector<PlaceLists>& open, pugi::xml_node& last_space) {
    constexpr const char* kept_space = "&#x200b;&#160;&#x200b;"; // a single space has no width in rsvg
    const std::string prefix = name_prefix(node);
    pugi::xml_node says = node;
    while (says && !says.attribute("xml:space")) says = says.parent();
    const bool preserves = attribute_text(says, "xml:space") == "preserve";
    open.push_back(take_lists(node));
    for (pugi::xml_node child = node.first_child(); child;) {
        const pugi::xml_node next = child.next_sibling();
        const bool is_raw = child.type() == pugi::node_cdata;
        if (child.type() == pugi::node_element) place_letters(child, open, last_space);
        const std::string text = is_raw ? escaped(child.value()) : child.value();
        const bool is_text = is_raw || child.type() == pugi::node_pcdata;
        for (std::string_view rest = is_text ? text : std::string_view(); !rest.empty();) {
            std::string letter(rest.substr(0, letter_bytes(rest)));
            rest.remove_prefix(letter.size());
            const bool is_blank_letter = is_blank(letter);
            const bool is_first = open.front().passed == 0;
            if (is_blank_letter && (last_space || is_first) && !preserves) continue;
            pugi::xml_node part;
            for (std::size_t k = 0; k < PlaceLists::names.size(); ++k) {
                const auto has = [k](const PlaceLists& lists) {
                    return lists.passed < lists.values[k].size();
                };
                const auto inmost = std::find_if(open.rbegin(), open.rend(), has);
                if (inmost == open.rend()) continue;
                if (!part) part = node.insert_child_before((prefix + "tspan").c_str(), child);
                set_attribute(part, PlaceLists::names[k], inmost->values[k][inmost->passed]);
            }
            if (part) append_style(part, "fill:inherit!important;stroke:none!important");
            pugi::xml_node to = part ? part.append_child(pugi::node_pcdata)
                                     : node.insert_child_before(pugi::node_pcdata, child);
            to.set_value(is_blank_letter ? kept_space : letter.c_str());
            last_space = is_blank_letter && !preserves ? to : pugi::xml_node();
            for (PlaceLists& lists : open) ++lists.passed;
        }
        if (is_text) node.remove_child(child);
        child = next;
    }
    open.pop_back();
}

/// Whether a text has position lists. Letters on a path have others.
bool has_lists(pugi::xml_node text) {
    const auto on_path = [](pugi::xml_node node) { return local_name(node) == "textPath"; };
    const auto lists = [](pugi::xml_node node) {
        return std::any_of(PlaceLists::names.begin(), PlaceLists::names.end(), [&](const char* name) {
            return trimmed(attribute_text(node, name)).find_first_of(" ,\t\n\r") != std::string_view::npos;
        });
    };
    return (lists(text) || text.find_node(lists)) && !text.find_node(on_path);
}

/// The decoration lines of an element and its ancestors. The renderer reads only `text-decoration` of the
/// element itself.
std::string decoration_of(const StyleSheets& styles, pugi::xml_node node) {
    std::string given, found;
    for (pugi::xml_node up = node; up.type() == pugi::node_element; up = up.parent()) {
        const auto values = styles.values(up);
        for (const char* name : {"text-decoration", "text-decoration-line"})
            given += ' ' + lowered(text_of(values, name));
    }
    for (const char* line : {"underline", "overline", "line-through"}) {
        if (has_word(given, line)) found += (found.empty() ? "" : " ") + std::string(line);
    }
    return found;
}

/// Removes everything but texts and their ancestors, and gives every text element a unique colour. The
/// picture shows three times the viewBox at about 4096 pixels.
void strip_to_texts(SvgDocument& document, const ViewBox& view, std::vector<DrawnText>& texts) {
    pugi::xml_node root = root_element(document.xml);
    const StyleSheets styles(document);
    std::size_t colour = 1;
    for (pugi::xml_node node = root; node;) {
        const std::string kind = local_name(node);
        const bool text = kind == "text" && node.attribute(number_attribute);
        pugi::xml_node next = next_node(node, root);
        if (text) {
            DrawnText& drawn = texts[node.attribute(number_attribute).as_ullong()];
            drawn.first_colour = colour;
            for (pugi::xml_node part = node; part; part = next_node(part, node)) {
                if (part.type() != pugi::node_element) continue;
                append_style(
                    part,
                    "fill:" + colour_of(colour++) +
                        "!important;fill-opacity:1!important;stroke:none!important;opacity:1!important");
            }
            std::vector<PlaceLists> open;
            pugi::xml_node last_space;
            if (has_lists(node)) place_letters(node, open, last_space);
            if (last_space) last_space.set_value("");
            for (pugi::xml_node part = node; part; part = next_node(part, node)) {
                const std::string lines = decoration_of(styles, part);
                if (!lines.empty()) append_declaration(part, "text-decoration", lines, false);
            }
        }
        const bool keeps = is_group(kind) || kind == "style" || node.type() != pugi::node_element;
        if (is_group(kind)) {
            append_style(node, "opacity:1!important;clip-path:none!important;mask:none!important;"
                               "filter:none!important;overflow:visible!important");
        }
        if (text || !keeps || kind == "style") next = node_after(node, root); // skips descendants
        if (!text && !keeps) node.parent().remove_child(node);
        node = next;
    }
    pugi::xml_node outer = document.xml.insert_child_before("svg", root);
    outer.append_attribute("xmlns") = "http://www.w3.org/2000/svg";
    const double scale = 4096 / (3 * std::max(view.width, view.height));
    const Box window{view.x - view.width, view.y - view.height, view.x + 2 * view.width,
                     view.y + 2 * view.height};
    set_view_box(outer, window, 12);
    set_box(outer, {0, 0, scale * window.width(), scale * window.height()}, 12);
    set_attribute(outer, "preserveAspectRatio", "none");
    root = outer.append_move(root);
    set_box(root, box_of(view), 12);
    set_view_box(root, box_of(view), 12);
}

/// Converts a document to an SVG of outlines by rsvg-convert.
Expected<std::string> outlines(const std::string& text) {
    struct Close {
        void operator()(std::FILE* file) const noexcept { std::fclose(file); }
    };
    using File = std::unique_ptr<std::FILE, Close>;
    const File in(std::tmpfile());
    const File out(std::tmpfile());
    const FileError failure{"texts cannot become paths: a temporary file cannot be written"};
    if (!in || !out) return failure;
    if (std::fwrite(text.data(), 1, text.size(), in.get()) != text.size()) return failure;
    if (std::fflush(in.get()) != 0) return failure;
    std::rewind(in.get());
    const std::string fault =
        run_rsvg({"--unlimited", "--format", "svg"}, fileno(in.get()), fileno(out.get()));
    if (!fault.empty()) return FileError{"texts cannot become paths: " + fault};
    std::rewind(out.get());
    std::string result;
    std::array<char, 65536> buffer{};
    while (const std::size_t size = std::fread(buffer.data(), 1, buffer.size(), out.get())) {
        result.append(buffer.data(), size);
    }
    if (std::ferror(out.get()) != 0) return failure;
    return result;
}

/// Warns of properties of letters that the outlines ignore.
void warn_of_ignored_text_properties(const SvgDocument& document, const StyleSheets& styles,
                                     pugi::xml_node text, std::vector<std::string>& warnings) {
    std::vector<pugi::xml_node> nodes;
    for (pugi::xml_node up = text.parent(); up.type() == pugi::node_element; up = up.parent())
        nodes.push_back(up);
    for (pugi::xml_node part = text; part; part = next_node(part, text)) nodes.push_back(part);
    for (const pugi::xml_node node : nodes) {
        const auto tell = [&](const std::string& name, const std::string& value) {
            const std::string line = label(document, node) + ": the outlines ignore " + name + ": " + value;
            if (std::find(warnings.begin(), warnings.end(), line) == warnings.end()) warnings.push_back(line);
        };
        for (const char* name : {"rotate", "textLength"}) {
            if (node.attribute(name)) tell(name, attribute_text(node, name));
        }
        for (const char* name :
             {"alignment-baseline", "dominant-baseline", "text-transform", "word-spacing"}) {
            const std::string value = lowered(styles.value(node, name).text);
            if (!has_word("auto baseline alphabetic none normal 0 inherit", value.empty() ? "auto" : value))
                tell(name, value);
        }
    }
}

/// Converts text elements to groups, with a path in place of an element's own letters.
void replace_text(const DrawnText& text, const std::map<std::size_t, Path>& letters, double tolerance) {
    const std::string prefix = name_prefix(text.node);
    std::size_t colour = text.first_colour;
    std::vector<pugi::xml_node> parts;
    for (pugi::xml_node node = text.node; node; node = next_node(node, text.node)) {
        if (node.type() == pugi::node_element) parts.push_back(node);
    }
    for (pugi::xml_node part : parts) {
        const auto found = letters.find(colour++);
        pugi::xml_node place;
        for (pugi::xml_node child = part.first_child(); child;) {
            const pugi::xml_node next = child.next_sibling();
            if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata) {
                if (!place) place = part.insert_child_before((prefix + "path").c_str(), child);
                part.remove_child(child);
            }
            child = next;
        }
        if (place && found == letters.end()) part.remove_child(place);
        if (found != letters.end()) {
            if (!place) place = part.append_child((prefix + "path").c_str());
            write_shape(place, write_path_data(transformed(found->second, text.from_root),
                                               decimals_for(text.to_root, tolerance)));
        }
        for (const char* name : {"x", "y", "dx", "dy", "rotate", "textLength", "lengthAdjust", "xml:space"}) {
            part.remove_attribute(name);
        }
        if (local_name(part) != "a") part.set_name((prefix + 'g').c_str());
    }
}

/// The texts of a document and their rendered outlines.
struct DrawnTexts {
    std::vector<DrawnText> texts;         // drawn in place
    std::vector<bool> seen;               // #texts: whether it is drawn
    std::map<std::size_t, Path> outlines; // in root user space, by colour of the element

    /// The range of outlines of a text; empty if it has none.
    auto outlines_of(std::size_t n) const {
        const auto first = outlines.lower_bound(texts[n].first_colour);
        const auto end =
            n + 1 < texts.size() ? outlines.lower_bound(texts[n + 1].first_colour) : outlines.end();
        return std::pair(first, seen[n] ? end : first);
    }
};

/// Numbers the texts of a document in an attribute, which is kept, and renders them.
Expected<DrawnTexts> draw_texts(SvgDocument& document, const ViewBox& view) {
    DrawnTexts drawn;
    for (const pugi::xml_node node : number_texts(document)) drawn.texts.push_back({node, {}, {}, 0});
    if (drawn.texts.empty()) return drawn;
    std::vector<std::string> ignored; // warnings, which the deformation repeats

    SvgDocument probe = copy_of(document); // for transforms; walk() changes it
    StyleSheets styles(probe);
    IdTable ids(root_element(probe.xml));
    const auto drawing = walk(probe, styles, ids, {.boxes = true}, ignored);
    if (!drawing) return drawing.error();
    drawn.seen.resize(drawn.texts.size());
    for (const DrawnShape& shape : drawing->shapes) {
        const pugi::xml_attribute number = shape.node.attribute(number_attribute);
        const std::size_t n = number ? number.as_ullong() : drawn.texts.size();
        if (n >= drawn.texts.size() || drawn.seen[n]) continue;
        drawn.seen[n] = true;
        drawn.texts[n].to_root = shape.to_root;
        drawn.texts[n].from_root = shape.from_root;
    }

    SvgDocument stripped = copy_of(document);
    strip_to_texts(stripped, view, drawn.texts);
    const auto written = outlines(to_text(stripped));
    if (!written) return FileError{document.name + ": " + written.error().message};
    auto picture = parse_svg(*written, "rsvg-convert");
    if (!picture) return picture.error();
    const auto size = view_box(*picture);
    StyleSheets none(*picture);
    IdTable its_ids(root_element(picture->xml));
    const auto outline = walk(*picture, none, its_ids, {.follow_references = false}, ignored);
    if (!outline) return FileError{document.name + ": rsvg-convert wrote no outlines"};
    const Affine2 to_root{
        3 * view.width / size.width, 0, 0, 3 * view.height / size.height, view.x - view.width,
        view.y - view.height};
    for (const DrawnShape& shape : outline->shapes) {
        const auto colour = number_of(shape.fill);
        if (!colour) continue;
        Path path = transformed(shape.path, to_root);
        Path& all = drawn.outlines[*colour];
        std::copy_if(path.begin(), path.end(), std::back_inserter(all),
                     [](const Subpath& subpath) { return !subpath.segments.empty(); });
    }
    return drawn;
}

} // namespace

} // namespace detail

Expected<std::size_t> text_to_paths(SvgDocument& document, std::vector<std::string>& warnings) {
    using namespace detail;
    const auto view = view_box(document);
    SvgDocument work = copy_of(document);
    if (const auto error = expand_used_texts(work, warnings)) return *error;
    const StyleSheets styles(work);
    auto drawn = draw_texts(work, view);
    if (!drawn) return drawn.error();
    const double tolerance = 2e-5 * std::hypot(view.width, view.height);
    std::size_t count = 0;
    for (std::size_t n = 0; n < drawn->texts.size(); ++n) {
        DrawnText& text = drawn->texts[n];
        text.node.remove_attribute(number_attribute);
        const auto [first, end] = drawn->outlines_of(n);
        if (first != end) {
            warn_of_ignored_text_properties(work, styles, text.node, warnings);
            replace_text(text, drawn->outlines, tolerance);
            ++count;
        } else if (drawn->seen[n]) {
            warnings.push_back(label(work, text.node) + ": rsvg-convert draws no letters for it");
        }
    }
    styles.settle(warnings);
    if (count > 0) document = std::move(work);
    return count;
}

void measure_texts(SvgDocument& document) {
    using namespace detail;
    const auto view = view_box(document);
    const auto drawn = draw_texts(document, view);
    for (pugi::xml_node text : number_texts(document)) {
        const std::size_t n = text.attribute(number_attribute).as_ullong();
        text.remove_attribute(number_attribute);
        if (!drawn) continue;
        Box box;
        const auto [first, end] = drawn->outlines_of(n);
        for (auto path = first; path != end; ++path) box.add(bounds(path->second, drawn->texts[n].from_root));
        if (!box.empty()) document.text_boxes[text.hash_value()] = {box.x0, box.y0, box.x1, box.y1};
    }
}

Expected<SvgDocument> load_figure(const std::string& path, bool text_as_paths) {
    auto document = load_svg(path);
    if (!document) return document;
    if (!text_as_paths) {
        measure_texts(*document);
        return document;
    }
    std::vector<std::string> warnings;
    if (const auto count = text_to_paths(*document, warnings); !count) return count.error();
    for (const std::string& text : warnings) warn(text);
    return document;
}

} // namespace cageform_support

#include "svg/css_geometry.hpp"

#include "svg/xml.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

namespace cageform_support::detail {

namespace {

using Values = StyleSheets::Values;

/// A word of a value, or a function with its arguments.
struct CssItem {
    std::string name; // in lower case
    std::vector<std::string> words;
    bool is_function = false;
};

/// Splits a value into items; nothing if a bracket is not closed.
std::optional<std::vector<CssItem>> css_items(std::string_view text) {
    const auto words = css_words(text);
    if (!words) return std::nullopt;
    std::vector<CssItem> items;
    for (const std::string_view word : *words) {
        const std::size_t open = word.find('(');
        CssItem item{lowered(word.substr(0, open)), {}, word.ends_with(')')};
        if (item.is_function) {
            const auto inside = css_words(word.substr(open + 1, word.size() - open - 2));
            if (!inside) return std::nullopt;
            item.words.assign(inside->begin(), inside->end());
        }
        items.push_back(std::move(item));
    }
    return items;
}

std::optional<double> length_in(const std::string& word, double whole, const Viewport& view) {
    return parse_length(word, whole, view.em, view.root_em).if_any();
}

/// A scale factor: a number or a percentage.
std::optional<double> factor_of(std::string_view word) {
    const auto number = read_quantity(word);
    if (!number || (!number->unit.empty() && number->unit != "%")) return std::nullopt;
    return number->unit.empty() ? number->value : number->value / 100;
}

/// A position in a box, from one or two words such as "left", "30%", "2em". A third word (depth) is ignored.
std::optional<Point2> position_in(std::vector<std::string> words, const Box& box, const Viewport& view) {
    if (words.empty() || words.size() > 3) return std::nullopt;
    for (std::string& word : words) word = lowered(word);
    const auto is = [](const std::string& word, const char* first, const char* last) {
        return word == first || word == last;
    };
    if (words.size() == 1) words.emplace_back("center");
    if (is(words[0], "top", "bottom") || is(words[1], "left", "right")) std::swap(words[0], words[1]);
    const auto along = [&](const std::string& word, const char* first, const char* last, double from,
                           double size) {
        const std::string length = word == first      ? "0%"
                                   : word == last     ? "100%"
                                   : word == "center" ? "50%"
                                                      : word;
        auto value = length_in(length, size, view);
        if (value) *value += from;
        return value;
    };
    const auto x = along(words[0], "left", "right", box.x0, box.width());
    const auto y = along(words[1], "top", "bottom", box.y0, box.height());
    return x && y ? std::optional(Point2{*x, *y}) : std::nullopt;
}

/// Converts a CSS transform function to attribute syntax; nothing if it is not planar.
std::optional<std::string> transform_function(const CssItem& item, const Box& box, const Viewport& view) {
    std::string name = item.name;
    const std::vector<std::string>& words = item.words;
    std::vector<double> numbers;
    const bool moves = name.starts_with("translate");
    const bool turns = name.starts_with("rotate") || name.starts_with("skew");
    for (std::size_t i = 0; i < words.size(); ++i) {
        const bool across = name == "translatey" || i == 1;
        const auto value = moves   ? length_in(words[i], across ? box.height() : box.width(), view)
                           : turns ? angle_of(words[i])
                                   : factor_of(words[i]);
        if (!value) return std::nullopt;
        numbers.push_back(*value);
    }
    const auto is_of = [&](const char* form, std::size_t count) {
        return name == form && numbers.size() == count;
    };
    const auto become = [&](const char* form, std::vector<double> with) {
        name = form;
        numbers = std::move(with);
    };
    if (is_of("translatex", 1)) become("translate", {numbers[0], 0});
    if (is_of("translatey", 1)) become("translate", {0, numbers[0]});
    if (is_of("translate3d", 3) || is_of("translate", 3)) become("translate", {numbers[0], numbers[1]});
    if (is_of("scalex", 1)) become("scale", {numbers[0], 1});
    if (is_of("scaley", 1)) become("scale", {1, numbers[0]});
    if (is_of("translatez", 1) || is_of("scalez", 1)) return "";
    if (is_of("scale3d", 3) || is_of("scale", 3)) become("scale", {numbers[0], numbers[1]});
    if (is_of("rotatez", 1)) become("rotate", {numbers[0]});
    if (is_of("rotate3d", 4) && numbers[0] == 0 && numbers[1] == 0)
        become("rotate", {numbers[2] < 0 ? -numbers[3] : numbers[2] > 0 ? numbers[3] : 0});
    if (is_of("matrix3d", 16)) {
        const std::vector<double>& m = numbers; // by columns
        const std::array from_or_to_depth{m[2], m[3], m[6], m[7], m[8], m[9], m[11], m[15] - 1};
        const auto is_zero = [](double x) { return x == 0; };
        if (std::all_of(from_or_to_depth.begin(), from_or_to_depth.end(), is_zero))
            become("matrix", {m[0], m[1], m[4], m[5], m[12], m[13]});
    }
    if (is_of("skewx", 1)) become("skewX", {numbers[0]});
    if (is_of("skewy", 1)) become("skewY", {numbers[0]});
    if (is_of("skew", 1)) become("skewX", {numbers[0]});
    if (is_of("skew", 2)) {
        const auto slope = [](double degrees) { return std::tan(degrees * std::numbers::pi / 180); };
        become("matrix", {1, slope(numbers[1]), slope(numbers[0]), 1, 0, 0});
    }
    std::string text = name + '(';
    for (const double number : numbers) text += format_number(number, 17) + ' ';
    return text + ')';
}

/// Rewrites a value of the property `rotate` as a transform function. The axis is a letter or three numbers,
/// before or after the angle.
CssItem turn_about(std::vector<std::string> words) {
    if (words.size() < 2) return {"rotate", words, true};
    if (words[0].size() > 1 && is_letter(words[0].back())) // the angle, which has a unit
        std::rotate(words.begin(), words.begin() + 1, words.end());
    if (words.size() == 2) return {"rotate" + lowered(words[0]), {words[1]}, true};
    return {"rotate3d", words, true};
}

/// The map of a value of the property `name` (translate, rotate or scale), or of `transform` if null.
std::optional<Affine2> css_transform(std::string_view value, const char* name, const Box& box,
                                     const Viewport& view) {
    if (value.empty() || lowered(value) == "none") return Affine2();
    auto items = css_items(name == nullptr ? std::string(value) : name + ('(' + std::string(value) + ')'));
    if (!items) return std::nullopt;
    if (name != nullptr && name == std::string_view("rotate"))
        items->front() = turn_about(items->front().words);
    std::string text;
    for (const CssItem& item : *items) {
        const auto function = item.is_function ? transform_function(item, box, view) : std::nullopt;
        if (!function) return std::nullopt;
        text += *function;
    }
    return parse_transform(text).if_any();
}

/// See place_by_attributes().
class Placer {
public:
    Placer(SvgDocument& document, StyleSheets& styles)
        : document_(document)
        , styles_(styles)
        , ids_(root_element(document.xml)) {}

    void run() {
        const pugi::xml_node root = root_element(document_.xml);
        if (!styles_.places_elements() && !any_node_places(root)) return;
        const auto view = view_box(document_);
        Viewport viewport{view.width, view.height};
        const Values values = styles_.values(root);
        viewport.em = viewport.root_em = font_size(values, viewport);
        keep_in_style(root, values);
        for (pugi::xml_node node = root; node; node = next_node(node, root)) {
            if (local_name(node) == "use") used_.insert(ids_.referred(reference_of(node)).hash_value());
        }
        for (const pugi::xml_node child : root.children()) visit(child, viewport, {});
        styles_.remove_placing();
    }

private:
    static bool any_node_places(pugi::xml_node root) {
        for (pugi::xml_node node = root; node; node = next_node(node, root)) {
            for (const pugi::xml_attribute attribute : node.attributes()) {
                const std::string_view name = attribute.name(), text = attribute.value();
                if (name == "transform-origin" || name == "transform-box") return true;
                const bool is_length =
                    name != "d" && std::find(geometry.begin(), geometry.end(), name) != geometry.end();
                if (is_length && (text.find('(') != std::string_view::npos || !parse_length(text, 1)))
                    return true;
            }
            for (const Declaration& d : declarations(node.attribute("style").value())) {
                if (use_of(property_name(d.property)) == PropertyUse::placing) return true;
            }
        }
        return false;
    }

    struct Place {
        bool is_foreign = false, is_used = false; // in a foreignObject; in the target of a `use`
        int depth = 0;
    };

    void visit(pugi::xml_node node, const Viewport& parent, Place place) {
        if (node.type() != pugi::node_element || place.depth > max_svg_depth) return;
        Values values = styles_.values(node);
        const std::string kind = place.is_foreign ? std::string() : local_name(node);
        place.is_used = place.is_used || used_.count(node.hash_value()) != 0;
        for (auto& [property, value] : values) {
            if (!place.is_used && value.text.find("var(") != std::string::npos) value.text = "unset";
        }
        Viewport view = parent;
        view.em = font_size(values, parent);
        bool is_read = kind.empty() || (take_geometry(node, kind, values, view, place.is_used) &&
                                        !styles_.is_placed_by_unapplied_rule(node));
        Viewport inside = view;
        if (kind == "svg") {
            inside.width = length_in(attribute_text(node, "width"), view.width, view).value_or(view.width);
            inside.height =
                length_in(attribute_text(node, "height"), view.height, view).value_or(view.height);
        }
        if (const auto box = view_box_of(node)) {
            inside.width = box->width;
            inside.height = box->height;
        }
        place.is_foreign = place.is_foreign || kind == "foreignObject";
        ++place.depth;
        for (const pugi::xml_node child : node.children()) visit(child, inside, place);
        if (is_read && !kind.empty()) is_read = take_transform(node, kind, values, view);
        if (!is_read) StyleSheets::mark_unmoved(node);
        keep_in_style(node, values);
    }

    /// Writes back the values that did not become attributes.
    static void keep_in_style(pugi::xml_node node, const Values& values) {
        drop_from_style(node);
        for (const auto& [property, value] : values) {
            if (use_of(property) != PropertyUse::placing || value.source < StyleValue::Source::sheet)
                continue;
            append_declaration(node, property, value.text, value.important);
        }
    }

    static void drop_from_style(pugi::xml_node node) {
        std::string style = node.attribute("style").value();
        const auto all = declarations(style);
        bool changed = false;
        std::string rest;
        for (const Declaration& d : all) {
            if (use_of(property_name(d.property)) == PropertyUse::placing) {
                changed = true;
                continue;
            }
            rest += (rest.empty() ? "" : ";") + std::string(d.property) + ':' + std::string(d.value) +
                    (d.important ? "!important" : "");
        }
        if (!changed) return;
        if (rest.empty()) {
            node.remove_attribute("style");
        } else {
            set_attribute(node, "style", rest);
        }
    }

    void report(pugi::xml_node node, const std::string& property, const std::string& value) {
        styles_.report.add(label(document_, node), "the property \"" + property + "\" is not deformed",
                           value);
    }

    /// Converts geometry properties to attributes and removes them from `values`. Returns whether all are
    /// valid.
    bool take_geometry(pugi::xml_node node, const std::string& kind, Values& values, const Viewport& view,
                       bool is_used) {
        static const std::vector<const char*> of_box{"x", "y", "width", "height"}, none;
        const auto shape = shape_attributes().find(kind);
        const bool has_box = kind == "use" || kind == "svg" || kind == "image" || kind == "foreignObject";
        const auto& names = shape != shape_attributes().end() ? shape->second : has_box ? of_box : none;
        bool all = true;
        for (const std::string name : geometry) {
            const auto found = values.find(name);
            const bool by_css = found != values.end(), is_size = name == "width" || name == "height";
            const bool has_name = std::find(names.begin(), names.end(), name) != names.end();
            const std::string attribute = attribute_text(node, name.c_str());
            const bool is_given = by_css || (has_name && name != "d" && !is_blank(attribute));
            if (!is_given) continue;
            const std::string text =
                by_css ? found->second.text
                       : styles_.substituted(node, attribute).value_or(is_used ? attribute : "unset");
            const auto written = has_name ? geometry_text(name, text, view, is_used) : std::nullopt;
            const bool is_fault = !by_css && !is_valid(name, text, true); // the walk reports it
            // Browsers ignore these properties on a nested svg, and disagree on the size of a use.
            const bool is_ignored = by_css && (kind == "svg" ? has_name : kind == "use" && is_size);
            if ((has_name && !written && !is_fault) || is_ignored) {
                report(node, name, text);
                all = all && is_ignored;
                continue;
            }
            if (written && *written != attribute) set_attribute(node, name.c_str(), escaped(*written));
            if (by_css) values.erase(found);
        }
        return all;
    }

    /// Returns the attribute text; nothing if the value is invalid. In the target of a `use`, functions are
    /// kept, because each copy may have another font size or viewport.
    static std::optional<std::string> geometry_text(const std::string& name, const std::string& text,
                                                    const Viewport& view, bool is_used) {
        const bool is_across = name == "width" || name.find('x') != std::string::npos;
        const bool has_sign = name[0] == 'x' || name[0] == 'y' || name[0] == 'c',
                   is_auto = lowered(text) == "auto";
        const bool is_initial = has_word(wide_keywords, lowered(text)) && lowered(text) != "inherit";
        if (is_initial) return name == "d" ? "" : has_sign || name == "r" ? "0" : "auto";
        if (name == "d") return path_data(text);
        if (is_auto) return text;
        const auto value = length_in(text,
                                     name == "r" ? view.diagonal()
                                     : is_across ? view.width
                                                 : view.height,
                                     view);
        if (!value) return std::nullopt;
        if (is_used || text.find('(') == std::string::npos) return text;
        return format_number(has_sign ? *value : std::max(*value, 0.0), 17);
    }

    static std::optional<std::string> path_data(const std::string& text) {
        if (lowered(text) == "none") return "";
        const auto items = css_items(text);
        const bool is_path =
            items && items->size() == 1 && items->front().name == "path" && items->front().words.size() == 1;
        if (!is_path) return std::nullopt;
        const std::string& quoted = items->front().words.front();
        if (quoted.size() < 2 || (quoted.front() != '"' && quoted.front() != '\'')) return std::nullopt;
        return quoted.substr(1, quoted.size() - 2);
    }

    /// Converts transform properties to the attribute; returns whether they are valid.
    bool take_transform(pugi::xml_node node, const std::string& kind, Values& values, const Viewport& view) {
        const bool is_drawn =
            is_group(kind) || is_shape(kind) || is_fixed(kind) || kind == "use" || kind == "clipPath";
        constexpr std::array maps{"translate", "rotate", "scale", "transform"};
        constexpr std::array about{"transform-origin", "transform-box"};
        const auto given = [&](const char* name) {
            const std::string text = text_of(values, name);
            return text.empty() && name != maps.back() ? attribute_text(node, name) : text;
        };
        const bool has_map =
            std::any_of(maps.begin(), maps.end(), [&](const char* name) { return values.count(name) != 0; });
        const bool turns_about = !given("transform-origin").empty() && node.attribute("transform");
        if (!has_map && !turns_about) return true;
        std::string fault = is_drawn || has_map ? "" : "transform-origin";
        const auto map = is_drawn ? whole_transform(node, values, given, view, fault) : std::nullopt;
        if (!map) {
            for (const char* name : maps) {
                if (fault.empty() && values.count(name) != 0)
                    report(node, name, values.find(name)->second.text);
            }
            if (!fault.empty()) report(node, fault, given(fault.c_str()));
            return false;
        }
        node.remove_attribute("transform");
        if (!(*map == Affine2())) set_attribute(node, "transform", write_transform(*map, 17));
        for (const char* name : about) node.remove_attribute(name);
        for (const char* name : maps) values.erase(name);
        for (const char* name : about) values.erase(name);
        return true;
    }

    /// Returns the combined map; nothing if a property is invalid.
    ///
    ///   fault   out: the invalid property; empty if the walk reports the error
    template <class Given>
    std::optional<Affine2> whole_transform(pugi::xml_node node, const Values& values, const Given& given,
                                           const Viewport& view, std::string& fault) {
        const std::string kind = given("transform-box");
        const bool of_view = kind.empty() || kind == "view-box";
        const bool of_stroke = kind == "stroke-box" || kind == "border-box";
        Box box;
        if (of_view) box = {0, 0, view.width, view.height};
        if (kind == "fill-box" || kind == "content-box" || of_stroke) box = object_box(node, view, 0);
        const auto width = of_stroke && !box.empty() ? stroke_reach(node, view) : std::optional(0.0);
        fault = "transform-box";
        if (box.empty() || !width) return std::nullopt;
        box = box.grown(*width);
        const Point2 start = of_view ? Point2{0, 0} : Point2{box.x0, box.y0};
        fault = "transform-origin";
        const auto items = css_items("at(" + given(fault.c_str()) + ')'); // so that calc() stays one word
        if (!items || items->size() != 1) return std::nullopt;
        const auto& words = items->front().words;
        const auto about = words.empty() ? std::optional(start) : position_in(words, box, view);
        if (!about) return std::nullopt;
        Affine2 map{1, 0, 0, 1, about->x, about->y};
        for (const char* name : {"translate", "rotate", "scale"}) {
            fault = name;
            const auto part = css_transform(text_of(values, name), name, box, view);
            if (!part) return std::nullopt;
            map = compose(map, *part);
        }
        fault.clear();
        const auto attribute = parse_transform(attribute_text(node, "transform"));
        if (!attribute) return std::nullopt; // the walk reports the error
        const auto own = values.count("transform") != 0
                             ? css_transform(text_of(values, "transform"), nullptr, box, view)
                             : attribute.if_any();
        if (!own) {
            fault = "transform";
            return std::nullopt;
        }
        return compose(compose(map, *own), {1, 0, 0, 1, -about->x, -about->y});
    }

    /// Half the stroke width, 0 without a stroke; nothing if invalid, or joins or caps may extend farther.
    std::optional<double> stroke_reach(pugi::xml_node shape, const Viewport& view) const {
        const auto inherited = [&](const char* property) {
            std::string text;
            for (auto up = shape; text.empty() && up.type() == pugi::node_element; up = up.parent())
                text = text_of(styles_.values(up), property);
            return text;
        };
        const std::string stroke = inherited("stroke"), width = inherited("stroke-width"),
                          kind = local_name(shape);
        if (stroke.empty() || stroke == "none") return 0;
        if (kind != "rect" && kind != "circle" && kind != "ellipse") return std::nullopt;
        const auto read = length_in(width.empty() ? "1" : width, view.diagonal(), view);
        return read ? std::optional(*read / 2) : std::nullopt;
    }

    /// Bounding box of an element in its user space; empty if unknown.
    Box object_box(pugi::xml_node node, const Viewport& view, int depth) {
        const std::string kind = local_name(node);
        Box box;
        if (++visited_nodes_ > 1'000'000) return box; // limit for nested uses
        if (is_shape(kind)) {
            std::vector<FileError> ignored_faults;
            return bounds(shape_path(document_, node, view, ignored_faults));
        }
        if (kind == "image") {
            const auto size = [&](const char* name, double whole) {
                return length_in(attribute_text(node, name), whole, view).value_or(0);
            };
            const double x = size("x", view.width), y = size("y", view.height);
            return {x, y, x + size("width", view.width), y + size("height", view.height)};
        }
        if (kind == "use" && depth < max_svg_depth) {
            const pugi::xml_node target = ids_.referred(reference_of(node));
            const bool shifts = node.attribute("x") || node.attribute("y"); // browsers differ
            const auto own = parse_transform(attribute_text(target, "transform"));
            const Box inner = own && !shifts ? object_box(target, view, depth + 1) : box;
            return inner.empty() ? box : inner.mapped(*own);
        }
        if ((kind != "g" && kind != "a" && kind != "switch") || depth > max_svg_depth) return box;
        for (const pugi::xml_node child : node.children()) {
            const auto own = parse_transform(attribute_text(child, "transform"));
            const Box inner = object_box(child, view, depth + 1);
            if (own && !inner.empty()) box.add(inner.mapped(*own));
        }
        return box;
    }

    static constexpr std::array geometry{"x",  "y",  "width", "height", "cx", "cy", "r",
                                         "rx", "ry", "d",     "x1",     "y1", "x2", "y2"};
    SvgDocument& document_;
    StyleSheets& styles_;
    const IdTable ids_;
    std::set<std::size_t> used_; // by hash: the elements that `use` refers to
    std::size_t visited_nodes_ = 0;
};

} // namespace

std::optional<double> angle_of(std::string_view word) {
    const auto angle = read_quantity(trimmed(word));
    if (!angle) return std::nullopt;
    for (const auto& [unit, degrees] : {std::pair("", 1.0), std::pair("deg", 1.0), std::pair("grad", 0.9),
                                        std::pair("turn", 360.0), std::pair("rad", 180 / std::numbers::pi)}) {
        if (lowered(angle->unit) == unit) return angle->value * degrees;
    }
    return std::nullopt;
}

std::string text_of(const Values& values, std::string_view property) {
    const auto found = values.find(property);
    if (found == values.end()) return {};
    const std::string& text = found->second.text;
    return text != "initial" && has_word(wide_keywords, text) ? std::string() : text;
}

double font_size(const Values& values, const Viewport& parent) {
    constexpr std::pair<std::string_view, double> sizes[] = {
        {"xx-small", 9}, {"x-small", 10}, {"small", 13},    {"medium", 16},
        {"large", 18},   {"x-large", 24}, {"xx-large", 32}, {"xxx-large", 48}};
    const std::string name = lowered(text_of(values, "font-size"));
    for (const auto& [known, size] : sizes) {
        if (name == known) return size;
    }
    if (name == "smaller" || name == "larger") return parent.em * (name == "larger" ? 1.2 : 1 / 1.2);
    const auto size = parse_length(text_of(values, "font-size"), parent.em, parent.em, parent.root_em);
    return size && *size > 0 ? *size : parent.em;
}

void place_by_attributes(SvgDocument& document, StyleSheets& styles) {
    Placer(document, styles).run();
}

// ---- basic shapes ----

namespace {

/// Reads the words of one basic shape, in a box.
class BasicShapeReader {
public:
    BasicShapeReader(const CssItem& item, const Box& box, const Viewport& view)
        : words_(item.words)
        , box_(box)
        , view_(view) {}

    std::optional<BasicShape> read(const std::string& name) {
        if (name == "polygon") return polygon();
        if (name == "path") return path();
        PathBuilder builder;
        const bool is_round = name == "circle" || name == "ellipse";
        const bool good = is_round ? ellipse(builder, name == "circle") : rectangle(builder, name);
        if (!good || at_ < words_.size()) return std::nullopt;
        return BasicShape{write_path_data(builder.take(), 9), false};
    }

private:
    bool next(double whole, double& to) {
        const auto value = at_ < words_.size() ? length_in(words_[at_], whole, view_) : std::nullopt;
        if (value) to = *value;
        at_ += value ? 1 : 0;
        return value.has_value();
    }

    bool take(std::string_view word) {
        if (at_ >= words_.size() || lowered(words_[at_]) != word) return false;
        ++at_;
        return true;
    }

    bool takes_even_odd() { return take("evenodd") || (take("nonzero"), false); }

    std::optional<BasicShape> polygon() {
        BasicShape shape{{}, takes_even_odd()};
        while (at_ < words_.size()) {
            double x = 0, y = 0;
            if (!next(box_.width(), x) || !next(box_.height(), y)) return std::nullopt;
            shape.data += (shape.data.empty() ? "M" : " L") + format_number(box_.x0 + x, 9) + ' ' +
                          format_number(box_.y0 + y, 9);
        }
        shape.data += "Z";
        return shape.data == "Z" ? std::nullopt : std::optional(shape);
    }

    std::optional<BasicShape> path() {
        const bool even_odd = takes_even_odd();
        if (at_ + 1 != words_.size() || words_[at_].size() < 2) return std::nullopt;
        const auto parsed = parse_path_data(std::string_view(words_[at_]).substr(1, words_[at_].size() - 2));
        if (!parsed) return std::nullopt;
        const Affine2 to_box{1, 0, 0, 1, box_.x0, box_.y0};
        return BasicShape{write_path_data(transformed(*parsed, to_box), 9), even_odd};
    }

    /// Reads one to four lengths for four sides or corners, as in `margin`.
    bool four(std::array<double, 4>& to, const std::array<double, 4>& whole) {
        const std::size_t first = at_;
        std::size_t count = 0;
        while (count < 4 && next(whole[count], to[count])) ++count;
        for (std::size_t k = count; count > 0 && k < 4; ++k) { // percentages refer to each side
            at_ = first + (k == 3 && count > 1 ? 1 : 0);
            next(whole[k], to[k]);
        }
        at_ = first + count;
        return count > 0;
    }

    /// The rectangle of inset(), rect() or xywh() in the box; nothing if invalid.
    std::optional<Box> inner_box(const std::string& name) {
        const Box& b = box_;
        const double w = b.width(), h = b.height();
        std::array<double, 4> v{};
        if (name == "inset") {
            if (!four(v, {h, w, h, w})) return std::nullopt;
            return Box{b.x0 + v[3], b.y0 + v[0], b.x1 - v[1], b.y1 - v[2]};
        }
        const bool has_size = name == "xywh";
        if (!has_size && name != "rect") return std::nullopt;
        const std::array whole = has_size ? std::array{w, h, w, h} : std::array{h, w, h, w};
        for (std::size_t k = 0; k < 4; ++k) {
            if (has_size || !take("auto")) {
                if (!next(whole[k], v[k])) return std::nullopt;
            } else {
                v[k] = k == 1 ? w : k == 2 ? h : 0;
            }
        }
        if (has_size) return Box{b.x0 + v[0], b.y0 + v[1], b.x0 + v[0] + v[2], b.y0 + v[1] + v[3]};
        return Box{b.x0 + v[3], b.y0 + v[0], b.x0 + v[1], b.y0 + v[2]};
    }

    bool rectangle(PathBuilder& builder, const std::string& name) {
        const auto read = inner_box(name);
        if (!read) return false;
        const Box inner = *read;
        const double w = box_.width(), h = box_.height();
        std::array<double, 4> rx{}, ry{};
        if (take("round")) {
            const std::size_t first = at_;
            if (!four(rx, {w, w, w, w})) return false;
            if (!take("/")) at_ = first; // reuse the horizontal radii
            if (!four(ry, {h, h, h, h})) return false;
        }
        if (inner.empty()) return true;
        double fit = 1; // overlapping radii are scaled down together
        for (const auto& [size, a, b] :
             {std::tuple(inner.width(), rx[0], rx[1]), std::tuple(inner.width(), rx[2], rx[3]),
              std::tuple(inner.height(), ry[1], ry[2]), std::tuple(inner.height(), ry[3], ry[0])}) {
            if (a + b > size) fit = std::min(fit, size / (a + b));
        }
        const auto corners = std::array<Point2, 4>{
            {{inner.x0, inner.y0}, {inner.x1, inner.y0}, {inner.x1, inner.y1}, {inner.x0, inner.y1}}};
        for (std::size_t k = 0; k < 4; ++k) { // clockwise
            const double x = fit * rx[k], y = fit * ry[k];
            const double sx = k == 0 || k == 3 ? 1 : -1, sy = k < 2 ? 1 : -1;
            const Point2 upright{corners[k].x, corners[k].y + sy * y},
                flat{corners[k].x + sx * x, corners[k].y};
            const Point2 from = k % 2 == 0 ? upright : flat, to = k % 2 == 0 ? flat : upright;
            if (k == 0) builder.move_to(from);
            if (!(builder.current() == from)) builder.line_to(from);
            if (x > 0 && y > 0) builder.arc_to({x, y}, to);
        }
        builder.close();
        return true;
    }

    bool ellipse(PathBuilder& builder, bool circle) {
        std::vector<std::string> radii;
        while (at_ < words_.size() && lowered(words_[at_]) != "at") radii.push_back(lowered(words_[at_++]));
        Point2 centre = box_.centre();
        if (take("at")) {
            const auto place =
                position_in({words_.begin() + static_cast<std::ptrdiff_t>(at_), words_.end()}, box_, view_);
            if (!place) return false;
            centre = *place;
            at_ = words_.size();
        }
        if (radii.empty()) radii.assign(circle ? 1 : 2, "closest-side");
        if (radii.size() != (circle ? 1U : 2U)) return false;
        const std::array<double, 2> x{std::abs(centre.x - box_.x0), std::abs(box_.x1 - centre.x)};
        const std::array<double, 2> y{std::abs(centre.y - box_.y0), std::abs(box_.y1 - centre.y)};
        const auto radius = [&](const std::string& word, std::vector<double> sides, double whole) {
            if (word == "closest-side") return std::optional(*std::min_element(sides.begin(), sides.end()));
            if (word == "farthest-side") return std::optional(*std::max_element(sides.begin(), sides.end()));
            return length_in(word, whole, view_);
        };
        const Viewport size{box_.width(), box_.height()};
        const auto rx = circle ? radius(radii[0], {x[0], x[1], y[0], y[1]}, size.diagonal())
                               : radius(radii[0], {x[0], x[1]}, size.width);
        const auto ry = circle ? rx : radius(radii[1], {y[0], y[1]}, size.height);
        if (!rx || !ry) return false;
        if (!(*rx > 0 && *ry > 0)) return true; // empty
        add_ellipse(builder, centre, *rx, *ry);
        return true;
    }

    const std::vector<std::string>& words_;
    std::size_t at_ = 0;
    const Box& box_;
    const Viewport& view_;
};

} // namespace

std::optional<BasicShape> parse_basic_shape(std::string_view text, const Box& fill, const Box& stroke,
                                            const Viewport& viewport) {
    const auto items = css_items(text);
    if (!items) return std::nullopt;
    Box box = stroke; // default
    const CssItem* shape = nullptr;
    for (const CssItem& item : *items) {
        if (item.is_function && shape == nullptr) {
            shape = &item;
        } else if (item.name == "fill-box" || item.name == "content-box" || item.name == "padding-box") {
            box = fill;
        } else if (item.name == "view-box") {
            box = {0, 0, viewport.width, viewport.height};
        } else if (item.name != "stroke-box" && item.name != "border-box" && item.name != "margin-box") {
            return std::nullopt;
        }
    }
    if (shape == nullptr) return std::nullopt;
    return BasicShapeReader(*shape, box, viewport).read(shape->name);
}

} // namespace cageform_support::detail

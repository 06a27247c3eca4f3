#include "svg_style.hpp"

#include "svg_shapes.hpp"
#include "svg_xml.hpp"

#include <algorithm>
#include <set>

namespace cageform_examples {

namespace detail {

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

} // namespace detail

} // namespace cageform_examples

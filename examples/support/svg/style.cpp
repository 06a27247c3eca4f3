#include "svg/style.hpp"

#include "svg/shapes.hpp"
#include "svg/xml.hpp"

#include <algorithm>
#include <functional>
#include <set>
#include <tuple>

namespace cageform_examples {

namespace detail {

namespace {

/// The place after what begins at `at` and belongs together: a comment, a quoted text, a character
/// reference, or one character.
std::size_t after_token(std::string_view text, std::size_t at) {
    const auto beyond = [&](std::size_t found, std::size_t size) {
        return found == std::string_view::npos ? text.size() : found + size;
    };
    if (text.substr(at).starts_with("/*")) return beyond(text.find("*/", at + 2), 2);
    if (text[at] == '"' || text[at] == '\'') return beyond(text.find(text[at], at + 1), 1);
    if (text[at] != '&') return at + 1;
    std::size_t end = at + 1;
    while (end < text.size() && (is_letter(text[end]) || is_digit(text[end]) || text[end] == '#')) ++end;
    if (end == text.size() || text[end] != ';') return at + 1;
    const std::string_view quote = text.substr(at, end + 1 - at);
    if (quote == "&quot;" || quote == "&apos;") return beyond(text.find(quote, end), quote.size());
    return end + 1;
}

std::string_view without_comments_before(std::string_view text) {
    for (text = trimmed(text); text.starts_with("/*"); text = trimmed(text)) {
        text.remove_prefix(after_token(text, 0));
    }
    return text;
}

/// Tests whether deforming or making a cage reads a property.
bool is_read(std::string_view property) {
    for (const std::string_view known :
         {"fill",      "stroke",           "stroke-width",   "clip-path",         "mask",
          "filter",    "marker",           "marker-start",   "marker-mid",        "marker-end",
          "display",   "overflow",         "font-size",      "text-anchor",       "transform",
          "fill-rule", "stroke-linejoin",  "stroke-linecap", "stroke-miterlimit", "visibility",
          "opacity",   "stroke-dasharray", "fill-opacity",   "stroke-opacity"}) {
        if (property == known) return true;
    }
    return false;
}

bool is_name_character(char c) {
    return is_letter(c) || is_digit(c) || c == '-' || c == '_' || (c & 0x80) != 0;
}

constexpr int max_media_depth = 30; // of blocks of @media inside each other; reading them is recursive

/// Whether it opens a block of @media that every screen takes: of no type, or of "all" or "screen".
bool is_for_screens(std::string_view prelude) {
    constexpr std::string_view media = "@media";
    if (!prelude.starts_with(media)) return false;
    prelude = without_comments_before(prelude.substr(media.size()));
    if (prelude.empty()) return true;
    for (std::size_t from = 0; from <= prelude.size();) {
        const std::size_t comma = std::min(prelude.find(',', from), prelude.size());
        std::string_view query = trimmed(prelude.substr(from, comma - from));
        if (query.starts_with("only ")) query = trimmed(query.substr(5));
        if (query == "all" || query == "screen") return true;
        from = comma + 1;
    }
    return false;
}

} // namespace

std::vector<Declaration> declarations(std::string_view text) {
    std::vector<Declaration> all;
    std::size_t begin = 0;
    std::size_t colon = std::string_view::npos;
    int brackets = 0;
    for (std::size_t at = 0;;) {
        const bool end = at >= text.size();
        if (end || (text[at] == ';' && brackets <= 0)) {
            if (colon != std::string_view::npos) {
                Declaration next{without_comments_before(text.substr(begin, colon - begin)),
                                 trimmed(text.substr(colon + 1, at - colon - 1))};
                const std::size_t mark = next.value.rfind('!');
                if (mark != std::string_view::npos && trimmed(next.value.substr(mark + 1)) == "important") {
                    next.value = trimmed(next.value.substr(0, mark));
                    next.important = true;
                }
                all.push_back(next);
            }
            if (end) return all;
            begin = ++at;
            colon = std::string_view::npos;
            brackets = 0;
            continue;
        }
        if (text[at] == ':' && colon == std::string_view::npos) colon = at;
        if (text[at] == '(') ++brackets;
        if (text[at] == ')') --brackets;
        at = after_token(text, at);
    }
}

std::string referenced_id(std::string_view value) {
    const std::size_t url = value.find("url(");
    if (url == std::string_view::npos) return {};
    const std::size_t begin = value.find_first_not_of(" \"'", url + 4);
    if (begin == std::string_view::npos || value[begin] != '#') return {};
    const std::size_t end = value.find_first_of(" \"')", begin);
    return std::string(end == std::string_view::npos ? std::string_view()
                                                     : value.substr(begin + 1, end - begin - 1));
}

std::string with_referenced_id(std::string_view value, const std::string& id) {
    const std::string old = referenced_id(value);
    std::string result(value);
    const std::size_t at = old.empty() ? std::string::npos : result.find('#' + old);
    return at == std::string::npos ? "url(#" + id + ')' : result.replace(at + 1, old.size(), id);
}

StyleSheets::StyleSheets(pugi::xml_node root) {
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        if (local_name(node) != "style") continue;
        std::string css;
        for (const pugi::xml_node text : node.children()) {
            if (text.type() == pugi::node_pcdata) css += unescaped(text.value());
            if (text.type() == pugi::node_cdata) css += text.value();
        }
        read(css, 0);
    }
    std::sort(rules_.begin(), rules_.end(), [](const Rule& a, const Rule& b) { // later blocks win
        return std::tie(a.specificity, a.declarations) < std::tie(b.specificity, b.declarations);
    });
    for (std::size_t i = 0; i < rules_.size(); ++i) {
        const Compound& last = rules_[i].selector.back();
        const std::string key = !last.id.empty()        ? '#' + last.id
                                : !last.classes.empty() ? '.' + last.classes.front()
                                                        : last.type;
        by_key_[key].push_back(i);
    }
}

void StyleSheets::read(std::string_view css, int depth) {
    const auto to_any_of = [&](std::size_t at, std::string_view ends) {
        while (at < css.size() && ends.find(css[at]) == std::string_view::npos) at = after_token(css, at);
        return std::min(at, css.size());
    };
    for (std::size_t at = 0; at < css.size();) {
        const std::size_t open = to_any_of(at, "{;");
        const std::string_view prelude = without_comments_before(css.substr(at, open - at));
        if (open == css.size() || css[open] == ';') {
            at = open + 1; // such as @import
            continue;
        }
        std::size_t close = to_any_of(open + 1, "{}");
        for (int open_blocks = 1; close < css.size();) { // blocks inside, of @media
            open_blocks += css[close] == '{' ? 1 : -1;
            if (open_blocks == 0) break;
            close = to_any_of(close + 1, "{}");
        }
        const std::string_view body = css.substr(open + 1, close - std::min(open + 1, close));
        at = close + 1;
        if (is_for_screens(prelude) && depth < max_media_depth) {
            read(body, depth + 1);
            continue;
        }
        bool good = !prelude.starts_with('@');
        std::vector<Set> block;
        for (const Declaration& d : good ? declarations(body) : std::vector<Declaration>()) {
            if (is_read(d.property)) {
                block.push_back({std::string(d.property), std::string(d.value), d.important});
            }
        }
        if (good && block.empty()) continue;
        if (good) {
            blocks_.push_back(std::move(block));
            for (std::size_t from = 0; from <= prelude.size();) {
                const std::size_t comma = std::min(prelude.find(',', from), prelude.size());
                good = add_rule(trimmed(prelude.substr(from, comma - from)), blocks_.size() - 1) && good;
                from = comma + 1;
            }
        }
        if (!good && body.find("url(") != std::string_view::npos && !prelude.starts_with("@font-face")) {
            unread.emplace_back(prelude.substr(0, 60));
        }
    }
}

bool StyleSheets::add_rule(std::string_view text, std::size_t block) {
    Rule rule;
    rule.declarations = block;
    bool child = false;
    for (std::size_t at = 0; at < text.size();) {
        if (is_space(text[at]) || text[at] == '>') {
            child = child || text[at] == '>';
            ++at;
            continue;
        }
        Compound compound;
        compound.child = child;
        child = false;
        while (at < text.size() && !is_space(text[at]) && text[at] != '>') {
            const char kind = text[at];
            const bool marked = kind == '.' || kind == '#';
            std::size_t end = at + (marked || kind == '*' ? 1 : 0);
            const std::size_t begin = end;
            while (kind != '*' && end < text.size() && is_name_character(text[end])) ++end;
            const std::string name(text.substr(begin, end - begin));
            if (kind != '*' && name.empty()) return false; // [attribute], :state, + and so on
            if (kind == '.') compound.classes.push_back(name);
            if (kind == '#') compound.id = name;
            if (kind != '*' && !marked) compound.type = name;
            rule.specificity += kind == '#' ? 1'000'000 : kind == '.' ? 1'000 : kind == '*' ? 0 : 1;
            at = end;
        }
        rule.selector.push_back(std::move(compound));
    }
    if (rule.selector.empty() || rule.selector.size() > 64) return false;
    rules_.push_back(std::move(rule));
    return true;
}

bool StyleSheets::matches(const Compound& compound, pugi::xml_node node) {
    if (!compound.type.empty() && compound.type != local_name(node)) return false;
    if (!compound.id.empty() && compound.id != attribute_text(node, "id")) return false;
    if (compound.classes.empty()) return true;
    const std::string classes = ' ' + attribute_text(node, "class") + ' ';
    return std::all_of(compound.classes.begin(), compound.classes.end(), [&](const std::string& name) {
        const std::size_t at = classes.find(name);
        for (std::size_t k = at; k != std::string::npos; k = classes.find(name, k + 1)) {
            if (is_space(classes[k - 1]) && is_space(classes[k + name.size()])) return true;
        }
        return false;
    });
}

bool StyleSheets::matches(const std::vector<Compound>& selector, pugi::xml_node node) {
    if (!matches(selector.back(), node)) return false;
    if (selector.size() == 1) return true;
    std::vector<pugi::xml_node> line; // from the element to the root
    for (; node.type() == pugi::node_element; node = node.parent()) line.push_back(node);
    // from the root on: which compounds match at the parent, and which at any element above
    std::vector<bool> parent(selector.size()), above(selector.size());
    for (std::size_t k = line.size(); k-- > 0;) {
        std::vector<bool> here(selector.size());
        for (std::size_t i = 0; i < selector.size(); ++i) {
            const bool before = i == 0 || (selector[i].child ? parent[i - 1] : above[i - 1]);
            here[i] = before && matches(selector[i], line[k]);
        }
        if (k == 0) return here.back();
        for (std::size_t i = 0; i < selector.size(); ++i) above[i] = above[i] || here[i];
        parent = std::move(here);
    }
    return false;
}

std::map<std::string, StyleValue, std::less<>> StyleSheets::values(pugi::xml_node node) const {
    using Source = StyleValue::Source;
    std::map<std::string, StyleValue, std::less<>> result;
    for (const pugi::xml_attribute attribute : node.attributes()) {
        const std::string_view name = attribute.name();
        if (is_read(name) && name != "transform") {
            result[attribute.name()] = {std::string(trimmed(unescaped(attribute.value()))), Source::attribute,
                                        false};
        }
    }
    const auto set = [&](const std::string& property, std::string value, Source source, bool important) {
        StyleValue& old = result[property];
        if (!old.important || important) old = {std::move(value), source, important};
    };
    if (!rules_.empty()) {
        std::vector<std::size_t> candidates;
        const auto look_up = [&](const std::string& key) {
            const auto found = by_key_.find(key);
            if (found == by_key_.end()) return;
            for (const std::size_t rule : found->second) {
                if (matches(rules_[rule].selector, node)) candidates.push_back(rule);
            }
        };
        look_up("");
        look_up(local_name(node));
        if (node.attribute("id")) look_up('#' + attribute_text(node, "id"));
        const std::string classes = attribute_text(node, "class");
        for (std::string_view rest = trimmed(classes); !rest.empty(); rest = trimmed(rest)) {
            const auto size =
                std::size_t(std::find_if(rest.begin(), rest.end(), is_space) - rest.begin()); // one class
            look_up('.' + std::string(rest.substr(0, size)));
            rest.remove_prefix(size);
        }
        std::sort(candidates.begin(), candidates.end());
        for (const std::size_t rule : candidates) {
            for (const Set& d : blocks_[rules_[rule].declarations]) {
                set(d.property, d.value, Source::sheet, d.important);
            }
        }
    }
    for (const Declaration& d : declarations(node.attribute("style").value())) {
        if (is_read(d.property)) {
            set(std::string(d.property), unescaped(d.value), Source::style, d.important);
        }
    }
    return result;
}

StyleValue StyleSheets::value(pugi::xml_node node, std::string_view property) const {
    const auto all = values(node);
    const auto found = all.find(property);
    return found == all.end() ? StyleValue() : found->second;
}

void StyleSheets::set(pugi::xml_node node, const std::string& property, const std::string& text) const {
    const StyleValue old = value(node, property);
    const bool shorthand = property == "marker"; // which is no attribute
    if (old.source < StyleValue::Source::sheet && !shorthand) {
        return set_attribute(node, property.c_str(), escaped(text));
    }
    const std::string style = node.attribute("style").value();
    if (old.source == StyleValue::Source::style) {
        const auto all = declarations(style);
        for (auto d = all.rbegin(); d != all.rend(); ++d) {
            if (d->property != property || d->important != old.important) continue;
            const auto begin = static_cast<std::size_t>(d->value.data() - style.data());
            return set_attribute(node, "style",
                                 std::string(style).replace(begin, d->value.size(), escaped(text)));
        }
    }
    const std::string_view end = trimmed(style);
    const std::string part = end.empty() || end.ends_with(';') ? "" : ";";
    set_attribute(node, "style",
                  style + part + property + ':' + escaped(text) + (old.important ? "!important" : ""));
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
    adapt_style_sheets(document, types, warnings);
}

void adapt_style_sheets(SvgDocument& document, const std::set<std::string>& types,
                        std::vector<std::string>& warnings) {
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
            "style sheet: rules by type became rules by class, and have the same specificity as these");
    }
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        const std::string kind = local_name(node);
        if (met.count(kind) != 0) add_class(node, "cageform-" + kind);
    }
}

} // namespace detail

} // namespace cageform_examples

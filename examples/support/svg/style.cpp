#include "svg/style.hpp"

#include "svg/xml.hpp"

#include <algorithm>
#include <initializer_list>
#include <set>
#include <tuple>
#include <utility>

namespace cageform_support::detail {

namespace {

/// The position after the token at `at`: a comment, a quoted text, a character reference, or one character.
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

/// Replaces comments by spaces, so that positions stay the same.
std::string without_comments(std::string_view css) {
    std::string text(css);
    for (std::size_t at = 0; at < css.size();) {
        const std::size_t end = std::max(after_token(css, at), at + 1);
        if (css.substr(at).starts_with("/*")) {
            std::replace_if(
                text.begin() + static_cast<std::ptrdiff_t>(at),
                text.begin() + static_cast<std::ptrdiff_t>(end), [](char c) { return c != '\n'; }, ' ');
        }
        at = end;
    }
    return text;
}

constexpr int max_rule_depth = 30; // of nested rules; parsing is recursive

constexpr std::size_t most_of_selectors = 10'000; // bytes of a rule with its enclosing rules

/// The beginning of the text before the block of a rule, for messages.
std::string quoted_prelude(std::string_view prelude) {
    return '"' + std::string(prelude.substr(0, 60)) + '"';
}

/// Selectors of a nested rule. "&" is the outer rule.
std::string nested_selectors(const std::string& outside, std::string_view inside) {
    const std::string parent = ":is(" + outside + ')';
    std::string all, each;
    int brackets = 0;
    bool has_parent = false;
    const auto end_selector = [&] {
        all += (all.empty() ? "" : ",") + (has_parent ? each : parent + ' ' + each);
        each.clear();
        has_parent = false;
    };
    for (std::size_t at = 0, next = 0; at < inside.size(); at = next) {
        if (all.size() + each.size() >= most_of_selectors) break; // too long, not supported
        next = after_token(inside, at);
        const std::string_view token = inside.substr(at, next - at);
        if (token == "(" || token == "[") ++brackets;
        if (token == ")" || token == "]") --brackets;
        if (token == "," && brackets == 0) {
            end_selector();
        } else {
            has_parent = has_parent || token == "&";
            each += token == "&" ? parent : token;
        }
    }
    end_selector();
    return all;
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
                if (mark != std::string_view::npos &&
                    lowered(trimmed(next.value.substr(mark + 1))) == "important") {
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

std::optional<std::vector<std::string_view>> css_words(std::string_view value) {
    std::vector<std::string_view> words;
    std::size_t begin = 0;
    int brackets = 0;
    const auto end_word = [&](std::size_t end, std::size_t next) {
        if (end > begin) words.push_back(value.substr(begin, end - begin));
        begin = next;
    };
    for (std::size_t at = 0, next = 0; at < value.size(); at = next) {
        next = after_token(value, at);
        if (value[at] == '(') ++brackets;
        if (value[at] == ')' && --brackets < 0) return std::nullopt;
        const bool parts = is_space(value[at]) || value[at] == ',' || value.substr(at).starts_with("/*");
        if (brackets == 0 && parts) end_word(at, next);
        if (brackets == 0 && value[at] == '/' && !parts) end_word(at, at);
        if (brackets == 0 && (value[at] == ')' || (value[at] == '/' && !parts))) end_word(next, next);
    }
    if (brackets != 0) return std::nullopt;
    end_word(value.size(), value.size());
    return words;
}

namespace {

/// The id in url(#id) as written, a view into the value; empty if there is none.
std::string_view written_id(std::string_view value) {
    const std::size_t url = lowered(value).find("url(");
    if (url == std::string_view::npos) return {};
    std::size_t begin = value.find_first_not_of(' ', url + 4);
    if (begin == std::string_view::npos) return {};
    const bool is_quoted = value[begin] == '"' || value[begin] == '\'';
    const std::string ends = is_quoted ? std::string(1, value[begin++]) : " )";
    if (begin == value.size() || value[begin] != '#') return {};
    const std::size_t end = value.find_first_of(ends, begin);
    return end == std::string_view::npos ? std::string_view() : value.substr(begin + 1, end - begin - 1);
}

} // namespace

std::string referenced_id(std::string_view value) {
    return without_percents(written_id(value));
}

std::string with_referenced_id(std::string_view value, const std::string& id) {
    const std::string_view old = written_id(value);
    if (old.empty()) return "url(#" + id + ')';
    const auto at = static_cast<std::size_t>(old.data() - value.data());
    return std::string(value).replace(at, old.size(), id);
}

std::string property_name(std::string_view written) {
    return written.starts_with("--") ? std::string(written) : lowered(written);
}

namespace {

/// The font size in a value of `font`, such as: bold 12px/1.5 serif. "inherit" if there is none.
std::string size_in_font(std::string_view font) {
    for (const std::string_view word : words_of(font)) {
        const std::string_view size = word.substr(0, word.find('/'));
        const bool is_weight = size.empty() || is_digit(size.back());
        if (!is_weight && parse_length(size, 1)) return std::string(size);
    }
    return "inherit";
}

const char* const unmoved_mark = "cageform-unmoved"; // attribute of elements that are not deformed
const char* const rules_mark = "cageform-rules";     // attribute: index into StyleSheets::marked_

/// Whether a condition of @supports, brackets replaced by spaces, has no "not" and only known properties,
/// which browsers support.
bool asks_for_known(std::string_view condition) {
    for (std::size_t colon = 0; (colon = condition.find(':', colon)) != std::string_view::npos; ++colon) {
        const std::string_view before = trimmed(condition.substr(0, colon));
        if (use_of(before.substr(before.rfind(' ') + 1)) == PropertyUse::unknown) return false;
    }
    return !has_word(condition, "not");
}

} // namespace

StyleSheets::Applies StyleSheets::media_applies(std::string_view written) {
    const std::string queries = lowered(trimmed(written));
    Applies any = queries.empty() ? Applies::always : Applies::never;
    for (std::size_t from = 0, comma = 0; from < queries.size(); from = comma + 1) {
        comma = std::min(queries.find(',', from), queries.size());
        const auto words = css_words(std::string_view(queries).substr(from, comma - from));
        if (!words || words->empty()) continue;
        Applies all = Applies::always;
        for (const std::string_view word : *words) {
            if (has_word("not only and all screen", word)) continue;
            all = std::min(all, word.starts_with('(') || word == "or" ? Applies::by_window : Applies::never);
        }
        if (words->front() == "not" && all != Applies::by_window)
            all = all == Applies::never ? Applies::always : Applies::never;
        any = std::max(any, all);
    }
    return any;
}

StyleSheets::Layer StyleSheets::layer_of(Layer layer, std::string_view name) {
    while (true) {
        const std::size_t dot = std::min(name.find('.'), name.size());
        const std::string part = name.empty() ? ' ' + std::to_string(layers_.size()) // without a name
                                              : std::string(name.substr(0, dot));
        layer.push_back(layers_.try_emplace({layer, part}, layers_.size()).first->second);
        if (dot == name.size()) return layer;
        name.remove_prefix(dot + 1);
    }
}

StyleSheets::StyleSheets(SvgDocument& document, std::size_t most)
    : document_(document)
    , search_{most} {
    const pugi::xml_node root = root_element(document.xml);
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        const std::string type = attribute_text(node, "type");
        if (local_name(node) != "style" || !(type.empty() || type == "text/css")) continue; // as browsers
        std::string css;
        for (const pugi::xml_node text : node.children()) {
            if (text.type() == pugi::node_pcdata) css += unescaped(text.value());
            if (text.type() == pugi::node_cdata) css += text.value();
        }
        sheets_.push_back({node, css, without_comments(css)});
    }
    for (std::size_t i = 0; i < sheets_.size(); ++i) {
        const std::string media = attribute_text(sheets_[i].node, "media");
        read(i, 0, sheets_[i].text.size(), {"", "", {}, media_applies(media), 0});
    }
    if (rules_.empty()) return;
    std::sort(rules_.begin(), rules_.end(), [&](const Rule& a, const Rule& b) { // later blocks win
        return std::tie(blocks_[a.block].layer, a.selector.specificity, a.block) <
               std::tie(blocks_[b.block].layer, b.selector.specificity, b.block);
    });
    for (std::size_t i = 0; i < rules_.size(); ++i) by_key_[rules_[i].selector.key()].push_back(i);
    read_.reset(document.xml);
    const pugi::xml_node top = root_element(read_);
    for (pugi::xml_node node = top; node; node = next_node(node, top)) {
        if (node.type() != pugi::node_element) continue;
        elements_.push_back(node);
        marked_.push_back(matching(node, {}));
    }
    if (search_.steps == 0) {
        report.add("style", "its rules take too long to match and are not read");
        rules_.clear();
        elements_.clear();
        placing_.clear();
        return;
    }
    search_.steps = 2 * most; // for copies, and for settle()
    std::size_t number = 0;
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        if (node.type() == pugi::node_element) set_attribute(node, rules_mark, std::to_string(number++));
    }
}

void StyleSheets::match_in_isolation(pugi::xml_node copy) {
    const auto mark_of = [&](pugi::xml_node node) {
        const pugi::xml_attribute mark = node.attribute(rules_mark);
        return mark ? mark.as_ullong() : elements_.size();
    };
    const std::size_t top = mark_of(copy);
    if (top >= elements_.size()) return;
    for (pugi::xml_node node = copy; node; node = next_node(node, copy)) {
        const std::size_t element = mark_of(node);
        if (element >= elements_.size()) continue; // new, or already in a copy
        const auto [place, fresh] = isolated_marks_.try_emplace({top, element}, marked_.size());
        if (fresh) marked_.push_back(matching(elements_[element], marked_[element], elements_[top]));
        set_attribute(node, rules_mark, std::to_string(place->second));
    }
}

std::string StyleSheets::place_of(std::size_t sheet, std::string_view part) const {
    const auto& [node, css, text, counted, lines] = sheets_[sheet];
    const char* const from = text.data() + counted; // near, since calls are roughly in order
    lines += std::count(from, std::max(from, part.data()), '\n');
    lines -= std::count(std::min(from, part.data()), from, '\n');
    counted = static_cast<std::size_t>(part.data() - text.data());
    const std::size_t line = line_of(document_, node);
    return to_string(FileError{"style", line == 0 ? 0 : line + static_cast<std::size_t>(lines), 0});
}

void StyleSheets::read(std::size_t sheet, std::size_t from, std::size_t end, const RulePlace& in) {
    const std::string_view css = std::string_view(sheets_[sheet].text).substr(0, end);
    const auto to_any_of = [&](std::size_t at, std::string_view ends) {
        while (at < css.size() && ends.find(css[at]) == std::string_view::npos) at = after_token(css, at);
        return std::min(at, css.size());
    };
    const auto is_any_of = [](std::string_view rule, std::initializer_list<std::string_view> names) {
        return std::any_of(names.begin(), names.end(), [&](auto name) { return rule.starts_with(name); });
    };
    constexpr std::string_view media = "@media", layers = "@layer";
    std::size_t begin = from; // of the enclosing rule's own declarations
    const auto end_declarations = [&](std::size_t at) {
        if (!in.selectors.empty() && begin < at) read_rule(sheet, css.substr(begin, at - begin), in);
    };
    for (std::size_t at = from; at < css.size();) {
        const std::size_t open = to_any_of(at, "{;");
        const std::string_view prelude = trimmed(css.substr(at, open - at));
        std::string rule = lowered(prelude.substr(0, prelude.starts_with('@') ? prelude.size() : 0));
        if (open == css.size() || css[open] == ';') {
            if (rule.starts_with("@import"))
                report.add(place_of(sheet, prelude), quoted_prelude(prelude) + " is not read");
            if (rule.starts_with(layers)) {
                const auto names = css_words(prelude.substr(layers.size()));
                for (const std::string_view name : names.value_or(std::vector<std::string_view>()))
                    layer_of(in.layer, name);
            }
            at = open + 1;
            continue;
        }
        std::size_t close = to_any_of(open + 1, "{}");
        for (int open_blocks = 1; close < css.size();) { // nested blocks
            open_blocks += css[close] == '{' ? 1 : -1;
            if (open_blocks == 0) break;
            close = to_any_of(close + 1, "{}");
        }
        end_declarations(at);
        at = begin = close + 1;
        std::replace_if(rule.begin(), rule.end(), [](char c) { return c == '(' || c == ')'; }, ' ');
        RulePlace inside = in;
        ++inside.depth;
        if (rule.empty()) {
            inside.selectors = in.selectors.empty() ? prelude : nested_selectors(in.selectors, prelude);
            inside.prelude = prelude;
        } else if (rule.starts_with(media)) {
            inside.applies = std::min(in.applies, media_applies(prelude.substr(media.size())));
        } else if (rule.starts_with(layers)) {
            inside.layer = layer_of(in.layer, trimmed(prelude.substr(layers.size())));
        }
        const bool is_supported = rule.starts_with("@supports") && asks_for_known(rule);
        const bool is_read = rule.empty() || is_supported || is_any_of(rule, {media, layers});
        const bool is_small = in.depth < max_rule_depth && inside.selectors.size() < most_of_selectors;
        if (is_read && is_small) {
            read(sheet, open + 1, close, inside);
        } else if (!is_any_of(rule, {"@font-", "@page", "@keyframes", "@-", "@counter-style"})) {
            report.add(place_of(sheet, prelude), quoted_prelude(prelude) + " is not read");
        }
    }
    end_declarations(css.size());
}

void StyleSheets::read_rule(std::size_t sheet, std::string_view body, const RulePlace& in) {
    bool complete = true;
    auto selectors = parse_selectors(in.selectors, complete);
    const bool is_certain = in.applies == Applies::always;
    const auto is_conditional = [&](const Selector& s) { return !is_certain || s.has_state; };
    const bool applies = complete && std::none_of(selectors.begin(), selectors.end(), is_conditional);
    const std::string name = quoted_prelude(in.prelude);
    Block block{name, place_of(sheet, in.prelude), in.layer, {}};
    block.layer.push_back(std::string::npos); // own rules win over those of nested layers
    if (!complete) report.add(block.place, name + " has a selector that is not read");
    for (const Declaration& d : declarations(body)) {
        const std::string property = property_name(d.property);
        const std::string place = place_of(sheet, d.property);
        report.declare(place, property, d.value);
        if (!applies && d.value.find("url(") != std::string_view::npos) {
            report.add(place, name + " refers to an element and is not read");
        }
        if (!is_valid(property, d.value)) continue; // ignored by browsers
        if (use_of(property) == PropertyUse::placing) {
            if (!applies)
                report.add(place, "the property \"" + property + "\" of " + name + " is not deformed");
            block.places = block.places || in.applies != Applies::never;
            block.is_read = applies;
            if (!applies) continue;
            const std::string& text = sheets_[sheet].text;
            const auto begin = static_cast<std::size_t>(d.property.data() - text.data());
            const auto value = static_cast<std::size_t>(d.value.data() - text.data());
            const auto after = static_cast<std::size_t>(body.data() - text.data()) + body.size();
            placing_.push_back(
                {sheet, begin, std::min(text.find(';', value + d.value.size()), after - 1) + 1});
        }
        block.sets.push_back({property, std::string(d.value), d.important});
    }
    if (block.sets.empty() && !block.places) return;
    for (Selector& selector : selectors) {
        const bool state = is_conditional(selector);
        rules_.push_back({std::move(selector), blocks_.size(), state});
    }
    blocks_.push_back(std::move(block));
}

StyleSheets::Rules StyleSheets::matching(pugi::xml_node node, const Rules& otherwise,
                                         pugi::xml_node top) const {
    Rules rules;
    const auto look_up = [&](const std::string& key) {
        const auto found = by_key_.find(key);
        if (found == by_key_.end()) return;
        for (const std::size_t rule : found->second) {
            if (rules_[rule].selector.matches(node, search_, top)) rules.push_back(rule);
        }
    };
    look_up("");
    look_up(local_name(node));
    if (node.attribute("id")) look_up('#' + attribute_text(node, "id"));
    const std::string classes = attribute_text(node, "class");
    for (const std::string_view name : words_of(classes)) look_up('.' + std::string(name));
    if (search_.steps == 0) return otherwise;
    std::sort(rules.begin(), rules.end());
    rules.erase(std::unique(rules.begin(), rules.end()), rules.end());
    return rules;
}

const StyleSheets::Rules& StyleSheets::rules_of(pugi::xml_node node) const {
    static const Rules none;
    const pugi::xml_attribute number = node.attribute(rules_mark);
    return number && number.as_ullong() < marked_.size() ? marked_[number.as_ullong()] : none;
}

template <class Wanted>
StyleSheets::Values StyleSheets::cascade(const Rules& rules, pugi::xml_node node,
                                         const Wanted& wanted) const {
    using Source = StyleValue::Source;
    Values result;
    const auto set = [&](const std::string& property, std::string value, Source source, bool important) {
        if (!wanted(property)) return;
        if (!std::all_of(property.begin(), property.end(), is_name_character)) return; // ignored by browsers
        StyleValue& old = result[property];
        if (!old.important || important) old = {std::move(value), source, important};
    };
    const auto give = [&](const std::string& property, const std::string& value, Source source,
                          bool important) {
        set(property, value, source, important);
        if (property == "font") set("font-size", size_in_font(value), source, important);
    };
    std::map<std::string_view, const Layer*> winners; // first layer with an important value, by property
    for (const std::size_t rule : rules) {
        if (rules_[rule].conditional) continue;
        const Block& block = blocks_[rules_[rule].block];
        for (const Set& d : block.sets) {
            const bool is_beaten =
                d.important && *winners.try_emplace(d.property, &block.layer).first->second != block.layer;
            if (!is_beaten) give(d.property, d.value, Source::sheet, d.important);
        }
    }
    for (const Declaration& d : declarations(node.attribute("style").value())) {
        const std::string property = property_name(d.property), value = unescaped(d.value);
        if (is_valid(property, value)) give(property, value, Source::style, d.important);
    }
    return result;
}

StyleSheets::Values StyleSheets::values(pugi::xml_node node) const {
    Values result = cascade(rules_of(node), node, [](const std::string& property) {
        const PropertyUse use = use_of(property);
        return use == PropertyUse::read || use == PropertyUse::placing;
    });
    for (const pugi::xml_attribute attribute : node.attributes()) {
        if (use_of(attribute.name()) != PropertyUse::read) continue;
        const std::string text(trimmed(unescaped(attribute.value())));
        if (!is_valid(attribute.name(), text, true)) continue;
        result.try_emplace(attribute.name(), StyleValue{text, StyleValue::Source::attribute, false});
    }
    for (auto& [property, value] : result) {
        if (value.text.find("var(") == std::string::npos) continue;
        const auto text = substituted(node, value.text);
        const bool is_computed = text && is_valid(property, *text);
        if (is_computed || use_of(property) == PropertyUse::read)
            value.text = is_computed ? trimmed(*text) : "unset";
    }
    return result;
}

std::optional<std::string> StyleSheets::substituted(pugi::xml_node node, std::string_view text) const {
    int left = 1000;
    return substituted(node, text, left);
}

std::optional<std::string> StyleSheets::substituted(pugi::xml_node node, std::string_view text,
                                                    int& left) const {
    std::string result;
    constexpr std::string_view begin = "var(";
    constexpr std::size_t most_of_value = 1'000'000; // bytes
    for (std::size_t at = 0; (at = text.find(begin)) != std::string_view::npos;) {
        result += text.substr(0, at);
        text.remove_prefix(at + begin.size());
        std::size_t end = 0;
        for (int brackets = 1; end < text.size(); end = after_token(text, end)) {
            if (text[end] == '(') ++brackets;
            if (text[end] == ')' && --brackets == 0) break;
        }
        const std::size_t comma = std::min(text.substr(0, end).find(','), end);
        auto value = custom_property(node, trimmed(text.substr(0, comma)), left);
        if (!value && comma < end) value = substituted(node, text.substr(comma + 1, end - comma - 1), left);
        if (!value) return std::nullopt;
        result += *value;
        if (result.size() > most_of_value) return std::nullopt;
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return result.append(text);
}

std::optional<std::string> StyleSheets::custom_property(pugi::xml_node node, std::string_view name,
                                                        int& left) const {
    for (; node.type() == pugi::node_element && --left > 0; node = node.parent()) {
        const Values own =
            cascade(rules_of(node), node, [&](const std::string& each) { return each == name; });
        if (own.empty()) continue;
        const std::string& text = own.begin()->second.text;
        if (lowered(text) == "initial") return std::nullopt;
        if (!has_word(wide_keywords, lowered(text))) return substituted(node, text, left);
    }
    return std::nullopt;
}

void StyleSheets::mark_unmoved(pugi::xml_node node) {
    set_attribute(node, unmoved_mark, "");
}

bool StyleSheets::is_marked_unmoved(pugi::xml_node node) {
    return node.attribute(unmoved_mark);
}

bool StyleSheets::is_placed_by_unapplied_rule(pugi::xml_node node) const {
    const Rules& rules = rules_of(node);
    return std::any_of(rules.begin(), rules.end(), [&](std::size_t rule) {
        const Block& block = blocks_[rules_[rule].block];
        return block.places && !block.is_read && !rules_[rule].selector.has_state;
    });
}

void append_style(pugi::xml_node node, const std::string& text) {
    const std::string style = node.attribute("style").value();
    const std::string_view end = trimmed(style);
    set_attribute(node, "style", style + (end.empty() || end.ends_with(';') ? "" : ";") + text);
}

void append_declaration(pugi::xml_node node, const std::string& property, const std::string& text,
                        bool important) {
    append_style(node, property + ':' + escaped(text) + (important ? "!important" : ""));
}

StyleValue StyleSheets::value(pugi::xml_node node, std::string_view property) const {
    const auto all = values(node);
    const auto found = all.find(property);
    return found == all.end() ? StyleValue() : found->second;
}

void StyleSheets::set(pugi::xml_node node, const std::string& property, const std::string& text) const {
    const StyleValue old = value(node, property);
    const bool shorthand = property == "marker"; // not an attribute
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
    append_declaration(node, property, text, old.important);
}

void StyleSheets::remove_placing() {
    for (auto part = placing_.begin(); part != placing_.end();) { // sorted by sheet
        const std::size_t changed = part->sheet;
        Sheet& sheet = sheets_[changed];
        std::string rest;
        std::size_t at = 0;
        for (; part != placing_.end() && part->sheet == changed; at = (part++)->end)
            rest += std::string_view(sheet.css).substr(at, part->begin - at);
        sheet.css = rest.append(sheet.css, at);
        const auto is_text = [](pugi::xml_node child) {
            return child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata;
        };
        pugi::xml_node first = sheet.node.find_child(is_text);
        first.set_value((first.type() == pugi::node_cdata ? sheet.css : escaped(sheet.css)).c_str());
        for (pugi::xml_node child = first.next_sibling(); child;) {
            const pugi::xml_node next = child.next_sibling();
            if (is_text(child)) child.parent().remove_child(child);
            child = next;
        }
    }
    for (Block& block : blocks_) {
        std::erase_if(block.sets, [](const Set& d) { return use_of(d.property) == PropertyUse::placing; });
    }
    placing_.clear();
}

void StyleSheets::settle(std::vector<std::string>& warnings) const {
    const pugi::xml_node root = root_element(document_.xml);
    for (pugi::xml_node node = root; node; node = next_node(node, root)) node.remove_attribute(unmoved_mark);
    if (rules_.empty()) return;
    search_.places.clear(); // the document has changed
    std::vector<std::pair<pugi::xml_node, const Rules*>> elements;
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        if (node.type() == pugi::node_element) elements.emplace_back(node, &rules_of(node));
    }
    for (auto& [node, before] : elements) node.remove_attribute(rules_mark);
    std::set<std::size_t> lost;
    const bool asks_for_styles = std::any_of(sheets_.begin(), sheets_.end(), [](const Sheet& sheet) {
        return sheet.text.find("[style") != std::string::npos;
    });
    for (bool is_settled = false; !is_settled;) { // selectors may match style attributes written here
        is_settled = true;
        std::vector<Rules> now;
        now.reserve(elements.size());
        for (const auto& [node, before] : elements) now.push_back(matching(node, *before));
        for (std::size_t i = 0; i < elements.size(); ++i) {
            const auto& [node, before] = elements[i];
            if (*before == now[i]) continue;
            is_settled = !settle(node, *before, now[i]) && is_settled;
            for (const std::size_t rule : *before) {
                const bool gone = !std::binary_search(now[i].begin(), now[i].end(), rule);
                const Block& block = blocks_[rules_[rule].block];
                if (!gone || !rules_[rule].conditional || !lost.insert(rule).second) continue;
                warnings.push_back(block.place + ": " + block.name + " no longer applies to " +
                                   label(document_, node));
            }
        }
        is_settled = is_settled || !asks_for_styles;
    }
    if (search_.steps == 0)
        warnings.push_back(
            "style: matching the rules takes too long; other rules may apply to changed elements");
}

bool StyleSheets::settle(pugi::xml_node node, const Rules& before, const Rules& now) const {
    const auto all = [](const std::string&) { return true; };
    const Values wanted = cascade(before, node, all), given = cascade(now, node, all);
    Values either = wanted;
    either.insert(given.begin(), given.end());
    std::string shorthand;
    bool has_changed = false;
    for (const auto& [property, any] : either) {
        const auto found = wanted.find(property), other = given.find(property);
        const StyleValue was = found == wanted.end() ? StyleValue() : found->second;
        const StyleValue is = other == given.end() ? StyleValue() : other->second;
        const bool same = was.text == is.text && was.important == is.important;
        if (same && (shorthand.empty() || !property.starts_with(shorthand + '-'))) continue;
        std::string text = was.text;
        if (text.empty()) {
            text = attribute_text(node, property.c_str());
            if (!is_valid(property, text)) text += "px"; // attributes need no unit
            if (text.empty() || !is_valid(property, text)) text = neutral_value(property);
        }
        append_declaration(node, property, text, was.important || is.important);
        has_changed = true;
        if (property == "font" || property == "marker" || property == "text-decoration") shorthand = property;
    }
    return has_changed;
}

} // namespace cageform_support::detail

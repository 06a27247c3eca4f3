#include "svg/selector.hpp"

#include "io/csv.hpp"
#include "svg/xml.hpp"

#include <algorithm>
#include <array>
#include <charconv>

namespace cageform_support::detail {

namespace {

constexpr int max_selector_depth = 8; // of nested :not, :is and :where; parsing is recursive
constexpr std::size_t max_compounds = 64;
constexpr std::size_t rank_of_id = 1'000'000, rank_of_class = 1'000, rank_of_type = 1;

bool is_element(pugi::xml_node node) {
    return node.type() == pugi::node_element;
}

/// Decrements the budget. Returns whether it is positive.
bool spend(std::size_t& steps, std::size_t cost = 1) {
    steps -= std::min(steps, cost);
    return steps != 0;
}

pugi::xml_node element_beside(pugi::xml_node node, bool after, std::size_t& steps) {
    do node = after ? node.next_sibling() : node.previous_sibling();
    while (node && !is_element(node) && spend(steps));
    return spend(steps) ? node : pugi::xml_node();
}

class SelectorReader {
public:
    explicit SelectorReader(std::string_view text)
        : text_(text) {}

    /// Parses a list up to its end or, inside brackets, up to ")".
    std::vector<Selector> list(bool& complete, int depth) {
        std::vector<Selector> all;
        for (;;) {
            Selector selector;
            if (complex(selector, depth)) {
                all.push_back(std::move(selector));
            } else {
                complete = false;
                skip_to_end_of_selector();
            }
            if (peek() != ',') return all;
            ++at_;
        }
    }

    bool at_end() const { return at_ >= text_.size(); }

private:
    char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
    bool ends() const { return at_end() || peek() == ',' || peek() == ')'; }

    void skip_space() {
        while (is_space(peek())) ++at_;
    }

    bool take(char c) {
        if (peek() != c) return false;
        ++at_;
        return true;
    }

    void skip_to_end_of_selector() {
        for (int brackets = 0; at_ < text_.size() && (brackets > 0 || !ends()); ++at_) {
            if (peek() == '"' || peek() == '\'')
                at_ = std::min(text_.find(peek(), at_ + 1), text_.size() - 1);
            if (peek() == '(' || peek() == '[') ++brackets;
            if (peek() == ')' || peek() == ']') --brackets;
        }
    }

    /// Parses a name and resolves escapes; empty if there is none.
    std::string name() {
        std::string result;
        while (at_ < text_.size()) {
            const char c = peek();
            if (is_name_character(c)) {
                result += c;
                ++at_;
            } else if (c == '\\' && at_ + 1 < text_.size()) {
                unsigned code = 0;
                const char* const first = text_.data() + at_ + 1;
                const char* const end = first + std::min<std::size_t>(6, text_.size() - at_ - 1);
                const auto [stop, error] = std::from_chars(first, end, code, 16);
                if (error == std::errc()) {
                    result += utf8(code);
                    at_ += static_cast<std::size_t>(stop - first) + 1;
                    if (is_space(peek())) ++at_;
                } else {
                    result += text_[at_ + 1];
                    at_ += 2;
                }
            } else {
                break;
            }
        }
        return result;
    }

    bool complex(Selector& selector, int depth) {
        char combinator = ' ';
        for (skip_space(); !ends(); skip_space()) {
            const char c = peek();
            if (c == '>' || c == '+' || c == '~') {
                if (combinator != ' ' || selector.compounds.empty()) return false;
                combinator = c;
                ++at_;
                continue;
            }
            CompoundSelector compound{combinator, {}};
            combinator = ' ';
            while (!ends() && !is_space(peek()) &&
                   std::string_view(">+~").find(peek()) == std::string_view::npos) {
                SimpleSelector part;
                bool every = false; // "*"
                if (!simple(part, selector, every, depth)) return false;
                if (!every) compound.parts.push_back(std::move(part));
            }
            selector.compounds.push_back(std::move(compound));
            if (selector.compounds.size() > max_compounds) return false;
        }
        return !selector.compounds.empty() && combinator == ' ';
    }

    bool simple(SimpleSelector& part, Selector& selector, bool& every, int depth) {
        using Kind = SimpleSelector::Kind;
        if (take('#')) {
            part.kind = Kind::id;
            selector.specificity += rank_of_id;
            return !(part.name = name()).empty();
        }
        if (take('.')) {
            part.kind = Kind::class_name;
            selector.specificity += rank_of_class;
            return !(part.name = name()).empty();
        }
        if (take('[')) {
            part.kind = Kind::attribute;
            selector.specificity += rank_of_class;
            return attribute(part);
        }
        if (take(':')) return pseudo_class(part, selector, depth);
        every = take('*');
        if (!every) part.name = name();
        if (take('|')) { // after a namespace
            every = take('*');
            part.name = every ? "" : name();
        }
        if (!every) selector.specificity += rank_of_type;
        return every || !part.name.empty();
    }

    bool attribute(SimpleSelector& part) {
        skip_space();
        if (take('*') && !take('|')) return false;
        part.name = name();
        skip_space();
        if (take(']')) return !part.name.empty();
        part.comparison = peek();
        if (std::string_view("=~|^$*").find(part.comparison) == std::string_view::npos) return false;
        ++at_;
        if (part.comparison != '=' && !take('=')) return false;
        skip_space();
        const char quote = peek();
        if (quote == '"' || quote == '\'') {
            const std::size_t end = text_.find(quote, at_ + 1);
            if (end == std::string_view::npos) return false;
            part.value = std::string(text_.substr(at_ + 1, end - at_ - 1));
            at_ = end + 1;
        } else {
            part.value = name();
        }
        skip_space();
        if (is_letter(peek())) part.ignores_case = (text_[at_++] | 0x20) == 'i';
        skip_space();
        return take(']') && !part.name.empty();
    }

    bool pseudo_class(SimpleSelector& part, Selector& selector, int depth) {
        using Kind = SimpleSelector::Kind;
        if (peek() == ':') return false; // a pseudo-element
        const std::string word = lowered(name());
        selector.specificity += word == "where" || word == "is" || word == "not" ? 0 : rank_of_class;
        if (word == "where" || word == "is" || word == "not") {
            part.kind = word == "not" ? Kind::none_of : Kind::any_of;
            bool complete = true;
            if (depth >= max_selector_depth || !take('(')) return false;
            part.list = list(complete, depth + 1);
            std::size_t most = 0;
            for (const Selector& each : part.list) {
                most = std::max(most, each.specificity);
                selector.has_state = selector.has_state || (each.has_state && word != "not");
            }
            if (word != "where") selector.specificity += most;
            return complete && take(')');
        }
        if (word == "root" || word == "empty") {
            part.kind = word == "root" ? Kind::root : Kind::empty;
            return true;
        }
        constexpr std::array states{"hover",        "active", "focus",  "focus-visible",
                                    "focus-within", "target", "visited"};
        if (std::find(states.begin(), states.end(), word) != states.end()) {
            part.kind = Kind::state;
            return selector.has_state = true;
        }
        part.kind = Kind::nth;
        part.of_type = word.ends_with("-of-type");
        part.from_end = word.find("last-") != std::string::npos;
        const std::string_view child = part.of_type ? "of-type" : "child";
        if (word == "only-" + std::string(child)) { // the first, and the last
            SimpleSelector last = part;
            last.from_end = true;
            part.list.resize(1);
            part.list.front().compounds.push_back({' ', {std::move(last)}});
            return true;
        }
        if (word == "first-" + std::string(child) || word == "last-" + std::string(child)) return true;
        const std::string last = part.from_end ? "last-" : "";
        return word == "nth-" + last + std::string(child) && take('(') && nth(part) && take(')');
    }

    /// "odd", "even", "3", "2n", "-n + 3"
    bool nth(SimpleSelector& part) {
        std::string text;
        for (; at_ < text_.size() && peek() != ')'; ++at_) {
            if (!is_space(peek())) text += peek();
        }
        text = lowered(text);
        if (text == "odd") text = "2n+1";
        if (text == "even") text = "2n";
        const auto number = [](std::string_view digits, int& to) {
            if (digits.starts_with('+')) digits.remove_prefix(1);
            return parse_whole(digits, to);
        };
        const std::size_t n = text.find('n');
        if (n == std::string::npos) return number(text, part.offset);
        const std::string step = text.substr(0, n), offset = text.substr(n + 1);
        part.offset = 0;
        part.step = step == "-" ? -1 : 1;
        if (!step.empty() && step != "-" && step != "+" && !number(step, part.step)) return false;
        return offset.empty() || number(offset, part.offset);
    }

    std::string_view text_;
    std::size_t at_ = 0;
};

/// The name without prefix, for types of any namespace.
std::string_view type_of(pugi::xml_node node) {
    const std::string_view name = node.name();
    return name.substr(name.find(':') + 1); // npos + 1 is zero
}

bool meets_comparison(std::string value, const SimpleSelector& part) {
    std::string wanted = part.value;
    if (part.ignores_case) {
        value = lowered(value);
        wanted = lowered(wanted);
    }
    const bool empty = wanted.empty();
    switch (part.comparison) {
    case '=': return value == wanted;
    case '|': return value == wanted || value.starts_with(wanted + '-');
    case '^': return !empty && value.starts_with(wanted);
    case '$': return !empty && value.ends_with(wanted);
    case '*': return !empty && value.find(wanted) != std::string::npos;
    case '~': return has_word(value, wanted);
    default: return true;
    }
}

/// Computes the positions of all children of an element.
void store_sibling_positions(pugi::xml_node parent, SelectorSearch& search) {
    std::unordered_map<std::string_view, long long> of_type;
    std::vector<pugi::xml_node> children;
    for (const pugi::xml_node node : parent.children()) {
        if (!spend(search.steps)) return;
        if (!is_element(node)) continue;
        children.push_back(node);
        const auto place = static_cast<long long>(children.size());
        search.places[node.hash_value()] = {place, -place, ++of_type[node.name()], 0};
    }
    for (const pugi::xml_node node : children) {
        auto& [place, from_end, place_of_type, from_end_of_type] = search.places[node.hash_value()];
        from_end += static_cast<long long>(children.size()) + 1;
        from_end_of_type = of_type[node.name()] - place_of_type + 1;
    }
}

bool is_nth(const SimpleSelector& part, pugi::xml_node node, pugi::xml_node top, SelectorSearch& search) {
    long long place = 1;
    if (node != top) {
        if (search.places.count(node.hash_value()) == 0) store_sibling_positions(node.parent(), search);
        if (search.steps == 0) return false;
        place = search.places[node.hash_value()][(part.of_type ? 2U : 0U) + (part.from_end ? 1U : 0U)];
    }
    const long long beyond = place - part.offset;
    return part.step == 0 ? beyond == 0 : beyond % part.step == 0 && beyond / part.step >= 0;
}

bool meets(const SimpleSelector& part, pugi::xml_node node, pugi::xml_node top, SelectorSearch& search) {
    using Kind = SimpleSelector::Kind;
    std::size_t& steps = search.steps;
    const auto any_of_list = [&] {
        return std::any_of(part.list.begin(), part.list.end(),
                           [&](const Selector& each) { return each.matches(node, search, top); });
    };
    constexpr std::size_t letters_of_step = 16;
    switch (part.kind) {
    case Kind::type: return type_of(node) == part.name;
    case Kind::id: return attribute_text(node, "id") == part.name;
    case Kind::class_name: {
        const std::string names = attribute_text(node, "class");
        return spend(steps, names.size() / letters_of_step) && has_word(names, part.name);
    }
    case Kind::attribute: {
        const pugi::xml_attribute attribute = node.attribute(part.name.c_str());
        if (!attribute) return false;
        const std::string value = unescaped(attribute.value());
        return spend(steps, value.size() / letters_of_step) && meets_comparison(value, part);
    }
    case Kind::any_of: return any_of_list();
    case Kind::none_of: // no element has a state
        return std::none_of(part.list.begin(), part.list.end(), [&](const Selector& each) {
            return !each.has_state && each.matches(node, search, top);
        });
    case Kind::nth: return is_nth(part, node, top, search) && (part.list.empty() || any_of_list());
    case Kind::root: return !is_element(node.parent());
    case Kind::empty:
        return !node.find_child([&](pugi::xml_node child) {
            return !spend(steps) || is_element(child) || child.type() == pugi::node_pcdata ||
                   child.type() == pugi::node_cdata;
        });
    default: return true;
    }
}

/// no_sibling: earlier siblings do not match either; never: nor do ancestors. So no chain of elements is
/// tried twice.
enum class Match { yes, no, no_sibling, never };

Match match(const std::vector<CompoundSelector>& compounds, std::size_t last, pugi::xml_node node,
            pugi::xml_node top, SelectorSearch& search) {
    std::size_t& steps = search.steps;
    if (!spend(steps, 1 + compounds[last].parts.size())) return Match::never;
    const CompoundSelector& compound = compounds[last];
    const bool met = std::all_of(compound.parts.begin(), compound.parts.end(),
                                 [&](const SimpleSelector& part) { return meets(part, node, top, search); });
    if (!met) return Match::no;
    if (last == 0) return Match::yes;
    const bool beside = compound.combinator == '+' || compound.combinator == '~';
    const bool nearest = compound.combinator == '+' || compound.combinator == '>';
    const auto next = [&] {
        if (node == top) return false;
        node = beside ? element_beside(node, false, steps) : node.parent();
        return is_element(node);
    };
    while (next()) {
        const Match result = match(compounds, last - 1, node, top, search);
        if (nearest || result == Match::yes || result == Match::never) return result;
        if (beside && result == Match::no_sibling) return result;
    }
    return beside ? Match::no_sibling : Match::never;
}

} // namespace

bool Selector::matches(pugi::xml_node node, SelectorSearch& search, pugi::xml_node top) const {
    return match(compounds, compounds.size() - 1, node, top, search) == Match::yes;
}

std::string Selector::key() const {
    using Kind = SimpleSelector::Kind;
    std::string key;
    for (const SimpleSelector& part : compounds.back().parts) {
        if (part.kind == Kind::id) return '#' + part.name;
        if (part.kind == Kind::class_name) key = '.' + part.name;
        if (part.kind == Kind::type && key.empty()) key = part.name;
    }
    return key;
}

std::vector<Selector> parse_selectors(std::string_view text, bool& complete) {
    complete = true;
    SelectorReader reader(text);
    std::vector<Selector> all = reader.list(complete, 0);
    complete = complete && reader.at_end();
    return all;
}

} // namespace cageform_support::detail

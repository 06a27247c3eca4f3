#pragma once

// CSS selectors: parsing, matching and specificity.

#include <pugixml.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace cageform_support::detail {

struct SimpleSelector;

/// State shared by all matches. `places` is valid until the document changes.
struct SelectorSearch {
    std::size_t steps = 0; // remaining budget; results are invalid once it is 0
    /// xml_node::hash_value() -> position among siblings, from 1: from the start, from the end, then both
    /// within the type.
    std::unordered_map<std::size_t, std::array<long long, 4>> places = {};
};

/// Simple selectors for one element, such as rect.wall:first-child
struct CompoundSelector {
    char combinator = ' '; // with the compound before: ' ', '>', '+' or '~'
    std::vector<SimpleSelector> parts;
};

/// A selector without commas, such as: g > rect.wall:not([width="6"])
struct Selector {
    std::vector<CompoundSelector> compounds;
    std::size_t specificity = 0;
    bool has_state = false; // requires a state such as :hover

    /// Whether the selector matches the element. States count as met.
    ///
    ///   top   elements outside this one are ignored
    bool matches(pugi::xml_node node, SelectorSearch& search, pugi::xml_node top = {}) const;

    /// An id ("#id"), class (".class") or type that every matching element has; empty if there is none.
    std::string key() const;
};

struct SimpleSelector {
    enum class Kind : std::uint8_t {
        type,
        id,
        class_name,
        attribute,
        any_of,
        none_of,
        nth,
        root,
        empty,
        state
    };
    Kind kind = Kind::type;
    std::string name, value; // value: of attributes only
    char comparison = 0;     // of attributes: '=', '~', '|', '^', '$', '*'; 0: none
    bool ignores_case = false;
    std::vector<Selector> list;             // of any_of and none_of
    bool of_type = false, from_end = false; // of nth: the (step · n + offset)th child
    int step = 0, offset = 1;
};

/// Parses a comma-separated list of selectors: structural pseudo-classes, states, :not, :is and :where.
/// Selectors with anything else are skipped.
///
///   complete   out: whether all were parsed
std::vector<Selector> parse_selectors(std::string_view text, bool& complete);

} // namespace cageform_support::detail

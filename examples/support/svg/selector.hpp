#pragma once

// Selectors of CSS: which elements a rule applies to, and its rank.

#include <pugixml.hpp>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace cageform_support::detail {

struct SimpleSelector;

/// The state that all searches by selectors share. The places of siblings hold until the document changes.
struct SelectorSearch {
    std::size_t steps = 0; // that are left; once none is left, answers mean nothing
    /// xml_node::hash_value() -> the element's position among its siblings, from 1. Order: from the start, from
    /// the end, from the start within its type, from the end within its type.
    std::unordered_map<std::size_t, std::array<long long, 4>> places = {};
};

/// Simple selectors that one element has to meet, such as rect.wall:first-child
struct CompoundSelector {
    char combinator = ' '; // to the compound before: ' ', '>', '+' or '~'
    std::vector<SimpleSelector> parts;
};

/// A selector without commas, such as: g > rect.wall:not([width="6"])
struct Selector {
    std::vector<CompoundSelector> compounds;
    std::size_t specificity = 0;
    bool has_state = false; // asks for a state such as :hover, which no picture at rest has

    /// Whether the selector matches the element. Every state that it asks for counts as met.
    ///
    ///   top   matching ignores every element outside this one
    bool matches(pugi::xml_node node, SelectorSearch& search, pugi::xml_node top = {}) const;

    /// One id ("#id"), class (".class") or type that every matching element has; empty if the selector
    /// requires none.
    std::string key() const;
};

struct SimpleSelector {
    enum class Kind { type, id, class_name, attribute, any_of, none_of, nth, root, empty, state };
    Kind kind = Kind::type;
    std::string name, value; // of an attribute; or the name alone
    char comparison = 0;     // of an attribute's value: '=', '~', '|', '^', '$', '*'; 0: none
    bool ignores_case = false;
    std::vector<Selector> list;             // of any_of and none_of
    bool of_type = false, from_end = false; // of nth: the (step · n + offset)th child
    int step = 0, offset = 1;
};

/// Reads a list of selectors with commas between them.
/// Reads structural pseudo-classes, states, :not, :is and :where. A selector with anything else is left out.
///
///   complete   receives whether all were read
std::vector<Selector> parse_selectors(std::string_view text, bool& complete);

} // namespace cageform_support::detail

#pragma once

// Known CSS properties, attributes and elements, and how the deformation treats each.

#include "svg/document.hpp"

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support::detail {

enum class PropertyUse : std::uint8_t {
    unknown,
    placing,    // geometry or transform of an element, also an attribute
    read,       // used by the deformation
    kept,       // independent of the pose
    not_applied // should change with the pose, but does not
};

PropertyUse use_of(std::string_view property);

/// CSS-wide keywords.
constexpr std::string_view wide_keywords = "inherit initial unset revert revert-layer";

/// Whether browsers accept a value. They ignore declarations with other values.
///
///   is_attribute   whether it is an attribute, where lengths need no unit
///   returns        true for properties without a grammar in properties.cpp, and for values with var(), env()
///                  or an open bracket
bool is_valid(std::string_view property, std::string_view value, bool is_attribute = false);

/// The value of a property that nothing sets: "inherit", the initial value, or "unset" if it is unknown.
std::string neutral_value(const std::string& property);

/// Collects properties, attributes and elements that are not deformed, each with its first location.
class UnappliedReport {
public:
    /// Reports a declaration that the deformation does not apply.
    ///
    ///   where   such as: rect "wall" (line 12)
    void declare(const std::string& where, std::string_view property, std::string_view value);
    void add(const std::string& where, const std::string& what, std::string_view value = {});

    /// Checks the attributes, style attributes and elements of a document.
    void check(const SvgDocument& document);

    std::vector<std::string> lines() const;

private:
    struct Place {
        std::string first, value;
        std::size_t count = 0;
    };
    void check(const SvgDocument& document, pugi::xml_node node, const std::string& kind);

    std::map<std::string, Place> places_; // by message
    std::vector<std::string> order_;
};

} // namespace cageform_support::detail

#pragma once

// The properties of CSS, the attributes and the elements that a drawing may hold, and what becomes of each
// when the drawing is deformed.

#include "svg/document.hpp"

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support::detail {

enum class PropertyUse {
    unknown,
    placing,    // it gives an element its geometry or its transform, which are attributes too
    read,       // the deformation reads it
    kept,       // no pose changes what it says
    not_applied // it would have to change with a pose, and does not
};

PropertyUse use_of(std::string_view property);

/// The values that every property has.
constexpr std::string_view wide_keywords = "inherit initial unset revert revert-layer";

/// Whether browsers accept a value. Browsers drop a declaration with a value that is not accepted.
///
///   is_attribute   the value is that of an attribute, where a length needs no unit
///   returns        true for properties without a grammar in properties.cpp, and for values with var(), env() or
///                  an open bracket
bool is_valid(std::string_view property, std::string_view value, bool is_attribute = false);

/// The value of a property that no rule and no attribute names: "inherit" or the initial value.
std::string neutral_value(const std::string& property);

/// Lists each property, attribute or element that is not deformed, once, with its first location.
class UnappliedReport {
public:
    /// Reports a declaration if the deformation does not apply it.
    ///   where   such as: rect "wall" (line 12)
    void declare(const std::string& where, std::string_view property, std::string_view value);
    void add(const std::string& where, const std::string& what, std::string_view value = {});

    /// The attributes, style attributes and elements of a document.
    void look_at(const SvgDocument& document);

    std::vector<std::string> lines() const;

private:
    struct Place {
        std::string first, value;
        std::size_t count = 0;
    };
    void look_at(const SvgDocument& document, pugi::xml_node node, const std::string& kind);

    std::map<std::string, Place> places_; // by what is said
    std::vector<std::string> order_;
};

} // namespace cageform_support::detail

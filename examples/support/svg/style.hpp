#pragma once

// CSS in SVG documents: style attributes, style sheets and the cascade.

#include "svg/document.hpp"
#include "svg/properties.hpp"
#include "svg/selector.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

namespace cageform_support::detail {

/// A declaration of a style attribute or a rule; views into its text.
struct Declaration {
    std::string_view property;
    std::string_view value; // without "!important"
    bool important = false;
};

/// Splits a style attribute, or the block of a rule, into declarations. Semicolons inside quotes, brackets,
/// comments and character references do not separate them.
std::vector<Declaration> declarations(std::string_view text);

/// Splits a value at white space and commas. A function, a quoted text and a slash are one word each. Nothing
/// if a bracket is not closed.
std::optional<std::vector<std::string_view>> css_words(std::string_view value);

/// The id in url(#id), with or without quotes; empty if there is none.
std::string referenced_id(std::string_view value);

/// Replaces the id in url(#id). Text after it, such as a fallback colour, is kept.
std::string with_referenced_id(std::string_view value, const std::string& id);

/// Appends declarations, already escaped, to a style attribute.
void append_style(pugi::xml_node node, const std::string& text);
void append_declaration(pugi::xml_node node, const std::string& property, const std::string& text,
                        bool important);

/// Normalizes a property name: lower case, except custom properties ("--ink").
std::string property_name(std::string_view written);

/// The value of a property on an element, not inherited, and its origin.
struct StyleValue {
    enum class Source : std::uint8_t { none, attribute, sheet, style };
    std::string text; // unescaped; empty: none
    Source source = Source::none;
    bool important = false;
};

/// Computes the property values of elements from style sheets, style attributes and attributes.
///
/// Each element is marked with the set of rules that matched it at load. Copies keep the mark. settle() then
/// writes style attributes so that other programs compute the same values.
///
/// A @media block applies if its query holds on every screen. Rules under other conditions, and rules for
/// states such as :hover, stay in their sheet; the deformation ignores them. An element is left unmoved if a
/// rule that depends on the window sets its geometry or transform.
class StyleSheets {
public:
    using Values = std::map<std::string, StyleValue, std::less<>>;

    ///   most   budget of matching steps when the document is loaded; the default takes about a second
    explicit StyleSheets(SvgDocument& document, std::size_t most = 30'000'000);

    /// Values of the properties that the deformation uses. Precedence as in CSS: `!important`, the style
    /// attribute, rules by specificity and order, attributes. Invalid values are ignored. var() is
    /// substituted; in geometry and transforms, a var() without a value is kept, because a copy may define
    /// it.
    Values values(pugi::xml_node node) const;

    /// The value of one property.
    StyleValue value(pugi::xml_node node, std::string_view property) const;

    /// Substitutes each var() by its value at an element; nothing if a var() has no value.
    std::optional<std::string> substituted(pugi::xml_node node, std::string_view text) const;

    /// Sets a value such that it wins the cascade.
    void set(pugi::xml_node node, const std::string& property, const std::string& text) const;

    /// Marks the copy for a `use` with the rules that would match its original without ancestors and
    /// siblings, as in SVG 2.
    void match_in_isolation(pugi::xml_node copy);

    /// Whether a sheet sets geometry or transforms.
    bool places_elements() const {
        return std::any_of(blocks_.begin(), blocks_.end(), [](const Block& b) { return b.places; });
    }
    /// Removes geometry and transforms from the sheets, after they became attributes.
    void remove_placing();

    /// Marks an element as not deformed, because its geometry or transform is not supported.
    static void mark_unmoved(pugi::xml_node node);
    static bool is_marked_unmoved(pugi::xml_node node);
    /// Whether a rule that is not applied sets the element's geometry or transform. Rules for states such as
    /// :hover do not count.
    bool is_placed_by_unapplied_rule(pugi::xml_node node) const;

    /// Removes the marks. If the rules that match an element have changed since loading, its style attribute
    /// restores lost declarations and cancels gained ones. New elements had no rules.
    ///
    ///   warnings   out: names conditional rules that no longer match an element
    void settle(std::vector<std::string>& warnings) const;

    UnappliedReport report; // properties that are not applied, rules that are not supported

private:
    enum class Applies : std::uint8_t { never, by_window, always };
    /// The numbers of the enclosing layers, outermost first, then its own. The greater number wins.
    using Layer = std::vector<std::size_t>;
    /// Position of rules or declarations in a sheet.
    struct RulePlace {
        std::string selectors;    // of the enclosing rules
        std::string_view prelude; // text before the block of the innermost rule
        Layer layer;
        Applies applies = Applies::always;
        int depth = 0;
    };
    struct Set {
        std::string property, value;
        bool important = false;
    };
    struct Block {
        std::string name, place; // its selectors, and the line
        Layer layer;
        std::vector<Set> sets;
        bool places = false; // sets geometry or transforms
        bool is_read = true; // `sets` includes geometry and transforms
    };
    struct Rule {
        Selector selector;
        std::size_t block = 0; // which of blocks_
        bool conditional = false;
    };
    struct Sheet {
        pugi::xml_node node;
        std::string css;                  // unescaped
        std::string text;                 // without comments
        mutable std::size_t counted = 0;  // number of bytes before the last place_of()
        mutable std::ptrdiff_t lines = 0; // number of lines in these bytes
    };
    struct Removed { // part of a sheet's text
        std::size_t sheet = 0, begin = 0, end = 0;
    };
    using Rules = std::vector<std::size_t>; // ascending indices of rules_

    /// Whether a list of media queries holds on screens: never, depending on the window, or always.
    static Applies media_applies(std::string_view queries);
    /// The layer with a dotted name inside another layer; a new layer if the name is empty.
    Layer layer_of(Layer layer, std::string_view name);
    void read(std::size_t sheet, std::size_t from, std::size_t end, const RulePlace& in);
    void read_rule(std::size_t sheet, std::string_view body, const RulePlace& in);
    std::string place_of(std::size_t sheet, std::string_view part) const;
    /// The rules that match an element; `otherwise` if the budget is used up.
    Rules matching(pugi::xml_node node, const Rules& otherwise, pugi::xml_node top = {}) const;
    const Rules& rules_of(pugi::xml_node node) const;
    /// Values of some properties from sheets and the style attribute.
    template <class Wanted>
    Values cascade(const Rules& rules, pugi::xml_node node, const Wanted& wanted) const;
    /// As substituted().
    ///
    ///   left   in and out: number of elements that may still be searched for values of var()
    std::optional<std::string> substituted(pugi::xml_node node, std::string_view text, int& left) const;
    std::optional<std::string> custom_property(pugi::xml_node node, std::string_view name, int& left) const;
    /// As above, for one element; returns whether its style attribute has changed.
    bool settle(pugi::xml_node node, const Rules& before, const Rules& now) const;

    SvgDocument& document_;
    std::vector<Sheet> sheets_;
    std::map<std::pair<Layer, std::string>, std::size_t> layers_; // numbers, by enclosing layer and name
    std::vector<Block> blocks_;
    std::vector<Rule> rules_; // by layer, specificity and order
    std::unordered_map<std::string, Rules> by_key_;
    std::vector<Rules> marked_;            // by mark
    pugi::xml_document read_;              // the document at load
    std::vector<pugi::xml_node> elements_; // of `read_`, by mark
    std::map<std::pair<std::size_t, std::size_t>, std::size_t>
        isolated_marks_; // marks, by the marks of top and element
    std::vector<Removed> placing_;
    mutable SelectorSearch search_;
};

} // namespace cageform_support::detail

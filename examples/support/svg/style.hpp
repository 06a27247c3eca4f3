#pragma once

// CSS in SVG documents: the style attribute, style sheets, and which value of a property wins.

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

/// A declaration of a style attribute or a rule; both views are into its text.
struct Declaration {
    std::string_view property;
    std::string_view value; // without "!important"
    bool important = false;
};

/// The declarations of a style attribute as written, or of the block of a rule. Semicolons inside quotes,
/// brackets, comments and character references do not part them.
std::vector<Declaration> declarations(std::string_view text);

/// The words of a value between white space and commas. A function, a quoted text and a slash are one word
/// each. Nothing where a bracket stays open.
std::optional<std::vector<std::string_view>> css_words(std::string_view value);

/// The id that a value names as url(#id), with or without quotes; empty if none.
std::string referenced_id(std::string_view value);

/// Returns a value with another id in its url(#id). Text after it, such as a fallback colour, stays.
std::string with_referenced_id(std::string_view value, const std::string& id);

/// Adds declarations to a style attribute, as they stand in it.
void append_style(pugi::xml_node node, const std::string& text);
void append_declaration(pugi::xml_node node, const std::string& property, const std::string& text,
                        bool important);

/// A property's name as the tables have it: in lower case, but for those of an author ("--ink").
std::string property_name(std::string_view written);

/// The value that an element is given for a property, not inherited, and where it stands.
struct StyleValue {
    enum class Source { none, attribute, sheet, style };
    std::string text; // unescaped; empty: none
    Source source = Source::none;
    bool important = false;
};

/// The values that style sheets, style attributes and attributes give the elements of a document.
///
/// Each element carries a mark that names the rules matching it at load. Copies keep the mark. settle()
/// writes style attributes so that other programs see the same values.
///
/// A block of @media applies if its query holds on every screen. Rules under other conditions, and rules for
/// states such as :hover, stay in their sheet. The deformation ignores both kinds of rules. An element stays
/// unmoved if a rule whose query depends on the window sets its geometry or transform.
class StyleSheets {
public:
    using Values = std::map<std::string, StyleValue, std::less<>>;

    ///   most   steps of matching rules when the document is read; as given they take about a second
    explicit StyleSheets(SvgDocument& document, std::size_t most = 30'000'000);

    /// The values of an element's properties that the deformation reads. Precedence is as in CSS: `!important`,
    /// the style attribute, rules by specificity and order, attributes. Invalid values are left out. Each var()
    /// is replaced by its value. Geometry and transforms keep a var() without a value, because a copy may
    /// define it.
    Values values(pugi::xml_node node) const;

    /// The value of one property.
    StyleValue value(pugi::xml_node node, std::string_view property) const;

    /// A text in which each var() is replaced by its value at an element. Nothing where a var() has no value.
    std::optional<std::string> substituted(pugi::xml_node node, std::string_view text) const;

    /// Writes a value that wins, in place of the one that did.
    void set(pugi::xml_node node, const std::string& property, const std::string& text) const;

    /// Gives the copy for a `use` the rules that match its original without ancestors or siblings, as in
    /// SVG 2.
    void stand_alone(pugi::xml_node copy);

    /// Whether a sheet sets geometry or transforms.
    bool places_elements() const {
        return std::any_of(blocks_.begin(), blocks_.end(), [](const Block& b) { return b.places; });
    }
    /// Removes geometry and transforms from the sheets. Attributes already hold their values.
    void remove_placing();

    /// Marks an element that no pose moves, as its geometry or transform is not read.
    static void leave_unmoved(pugi::xml_node node);
    static bool is_left_unmoved(pugi::xml_node node);
    /// Whether a rule that is not applied sets the element's geometry or transform. Rules for states such as
    /// :hover do not count.
    bool is_placed_by_unapplied_rule(pugi::xml_node node) const;

    /// Removes the marks. If an element's matching rules changed since loading, its style attribute restores
    /// lost declarations and cancels gained ones. New elements have had no rules.
    ///   warnings   name rules under conditions that have lost elements
    void settle(std::vector<std::string>& warnings) const;

    UnappliedReport report; // properties that are not applied, rules that are not read

private:
    enum class Applies { never, by_window, always };
    /// The numbers of the layers around a layer, outermost first, then its own. The greater number wins.
    using Layer = std::vector<std::size_t>;
    /// Where rules or declarations stand in a sheet.
    struct RulePlace {
        std::string selectors;    // of the enclosing rules
        std::string_view prelude; // what the file has before the block of the inmost rule
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
        bool is_read = true; // `sets` has geometry and transforms too
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
        mutable std::size_t counted = 0;  // the bytes whose lines are counted
        mutable std::ptrdiff_t lines = 0; // the lines in these bytes
    };
    struct Removed { // part of a sheet's text
        std::size_t sheet = 0, begin = 0, end = 0;
    };
    using Rules = std::vector<std::size_t>; // ascending indices of rules_

    /// Returns whether a list of media queries holds on a screen: never, depending on the window, or always.
    static Applies media_applies(std::string_view queries);
    /// The layer of a name with dots, inside another layer. Without a name it is a new layer.
    Layer layer_of(Layer layer, std::string_view name);
    void read(std::size_t sheet, std::size_t from, std::size_t end, const RulePlace& in);
    void read_rule(std::size_t sheet, std::string_view body, const RulePlace& in);
    std::string place_of(std::size_t sheet, std::string_view part) const;
    /// The rules that match an element; `otherwise` once no steps are left.
    Rules matching(pugi::xml_node node, const Rules& otherwise, pugi::xml_node top = {}) const;
    const Rules& rules_of(pugi::xml_node node) const;
    /// The values of sheets and of the style attribute, of some properties.
    template <class Wanted>
    Values cascade(const Rules& rules, pugi::xml_node node, const Wanted& wanted) const;
    /// Works as substituted().
    ///   left   the number of elements that may still be searched for the values of var()
    std::optional<std::string> substituted(pugi::xml_node node, std::string_view text, int& left) const;
    std::optional<std::string> custom_property(pugi::xml_node node, std::string_view name, int& left) const;
    /// Returns whether the style attribute has changed.
    bool settle(pugi::xml_node node, const Rules& before, const Rules& now) const;

    SvgDocument& document_;
    std::vector<Sheet> sheets_;
    std::map<std::pair<Layer, std::string>, std::size_t> layers_; // numbers, by enclosing layer and name
    std::vector<Block> blocks_;
    std::vector<Rule> rules_; // by layer, specificity and order
    std::unordered_map<std::string, Rules> by_key_;
    std::vector<Rules> marked_;                                        // by an element's mark
    pugi::xml_document read_;                                          // the document as it was read
    std::vector<pugi::xml_node> elements_;                             // of it, by their marks
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> alone_; // marks, by those of top and element
    std::vector<Removed> placing_;
    mutable SelectorSearch search_;
};

} // namespace cageform_support::detail

#pragma once

// CSS in SVG documents: the style attribute, style sheets, and which value of a property wins.

#include "svg/document.hpp"

#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace cageform_examples {

namespace detail {

/// A declaration of a style attribute or a rule; both views are into its text.
struct Declaration {
    std::string_view property;
    std::string_view value; // without "!important"
    bool important = false;
};

/// The declarations of a style attribute as written, or of the block of a rule. Semicolons inside quotes,
/// brackets, comments and character references do not part them.
std::vector<Declaration> declarations(std::string_view text);

/// The id that a value names as url(#id), with or without quotes; empty if none.
std::string referenced_id(std::string_view value);

/// Returns a value with another id in its url(#id). Text after it, such as a fallback colour, stays.
std::string with_referenced_id(std::string_view value, const std::string& id);

/// The value that an element is given for a property, not inherited, and where it stands.
struct StyleValue {
    enum class Source { none, attribute, sheet, style };
    std::string text; // unescaped; empty: none
    Source source = Source::none;
    bool important = false;
};

/// The values of the properties that matter to a deformation (paints, references, markers, sizes of text).
///
/// Style sheets whose selectors consist of types, classes, ids, "*", " " and ">". Blocks of @media are
/// read if they apply to every screen. Rules with other selectors and other blocks are ignored; `unread`
/// names those that would set a reference to an element.
class StyleSheets {
public:
    explicit StyleSheets(pugi::xml_node root);

    /// All that the element is given: `!important`, then the style attribute, then rules by their
    /// specificity and order, then attributes, as in CSS.
    std::map<std::string, StyleValue, std::less<>> values(pugi::xml_node node) const;

    /// One of these.
    StyleValue value(pugi::xml_node node, std::string_view property) const;

    /// Writes a value that wins, in place of the one that did.
    void set(pugi::xml_node node, const std::string& property, const std::string& text) const;

    std::vector<std::string> unread;

private:
    struct Compound { // such as path.a.b#c
        std::string type, id;
        std::vector<std::string> classes;
        bool child = false; // of what the compound before it matches, not any descendant
    };
    struct Rule {
        std::vector<Compound> selector;
        std::size_t specificity = 0;
        std::size_t declarations = 0; // which of blocks_
    };
    struct Set {
        std::string property, value;
        bool important = false;
    };

    void read(std::string_view css, int depth);
    bool add_rule(std::string_view selector, std::size_t block);
    static bool matches(const Compound& compound, pugi::xml_node node);
    static bool matches(const std::vector<Compound>& selector, pugi::xml_node node);

    std::vector<std::vector<Set>> blocks_;
    std::vector<Rule> rules_; // by specificity and order
    std::unordered_map<std::string, std::vector<std::size_t>>
        by_key_; // rules by what their last compound asks for
};

/// Replaces selectors of these types by classes, see the head of svg_document.hpp. Nothing changes where
/// there is no element of them.
void adapt_style_sheets(SvgDocument& document, const std::set<std::string>& types,
                        std::vector<std::string>& warnings);

} // namespace detail

} // namespace cageform_examples

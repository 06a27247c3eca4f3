#pragma once

// Elements and attributes of an SVG document: names, ids, text, lines, for the files that work on one.

#include "svg/document.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace cageform_support::detail {

constexpr int max_svg_depth = 1000; // of nested elements; the walk is recursive

/// The node after `node` in document order within `top`, or none.
pugi::xml_node next_node(pugi::xml_node node, pugi::xml_node top);

/// The node after `node` and all that it holds.
pugi::xml_node node_after(pugi::xml_node node, pugi::xml_node top);

/// The element's name without the prefix; empty for what is not SVG's, or no element.
std::string local_name(pugi::xml_node node);

bool is_blank(std::string_view text);

std::string_view trimmed(std::string_view text);

/// Whether it may stand in a name of CSS.
bool is_name_character(char c);

/// The words of a text that white space parts.
std::vector<std::string_view> words_of(std::string_view text);

bool has_word(std::string_view text, std::string_view word);

/// A character by its number; the replacement character for a number that is none.
std::string utf8(std::uint32_t code);

/// Replaces character references and the five entities of XML; others, from a doctype, are left.
std::string unescaped(std::string_view raw);

/// Whether an attribute of this name refers to another element or file: href, with a prefix or not.
bool is_reference(std::string_view attribute);

/// The name of the attribute that refers to another element, declared where it has a prefix.
std::string reference_name(pugi::xml_node root);

/// Text as it stands between the quotes of an attribute.
std::string escaped(std::string_view text);

/// The part of a URL after "#" as ids have it: without "%20" and the like.
std::string without_percents(std::string_view fragment);

/// The value of href, or of xlink:href whatever the prefix; empty if there is none. One within the file has
/// the id as the element has it.
std::string reference_of(pugi::xml_node node);
void set_reference(pugi::xml_node node, const std::string& id); ///< of all attributes that refer

/// Gives a copy of an element, or of a document, the lines and the boxes of texts of its original.
void keep_places(const SvgDocument& from, pugi::xml_node original, SvgDocument& to, pugi::xml_node copy);
/// The line of the nearest enclosing element that stood in the file; zero if none is known.
std::size_t line_of(const SvgDocument& document, pugi::xml_node node);

/// Returns a label such as: rect "wall" (line 12).
std::string label(const SvgDocument& document, pugi::xml_node node);

FileError error_at(const SvgDocument& document, pugi::xml_node node, const std::string& why);

/// An error inside an attribute: its line and column are counted in the attribute.
FileError error_in(const SvgDocument& document, pugi::xml_node node, const std::string& attribute,
                   const FileError& error);

/// Whether a node is an element or stands in it.
bool is_in(pugi::xml_node node, pugi::xml_node element);

/// Removes the ids of an element and of all in it.
void drop_ids(pugi::xml_node top);

/// The elements of a document by their ids; of several with the same id the first one counts.
class IdTable {
public:
    explicit IdTable(pugi::xml_node root);

    pugi::xml_node find(const std::string& id) const; ///< nothing if there is none
    /// The element that a reference "#id" names; nothing for other references.
    pugi::xml_node referred(const std::string& reference) const {
        return reference.starts_with('#') ? find(reference.substr(1)) : pugi::xml_node();
    }
    void move(const std::string& id, pugi::xml_node node) { nodes_[id] = node; }

    /// Gives the element an id that is not in use: the stem and a number. A hyphen replaces each character that
    /// url(#id) cannot hold.
    std::string name(pugi::xml_node node, const std::string& stem);

private:
    std::unordered_map<std::string, pugi::xml_node> nodes_;
    std::unordered_map<std::string, std::size_t> next_; // number of a stem
};

} // namespace cageform_support::detail

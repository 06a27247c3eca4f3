#pragma once

// Helpers for XML nodes of SVG documents: names, ids, text, line numbers.

#include "svg/document.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace cageform_support::detail {

constexpr int max_svg_depth = 1000; // of nested elements, as walk() is recursive

/// The next node in document order within `top`, or none.
pugi::xml_node next_node(pugi::xml_node node, pugi::xml_node top);

/// The next node in document order that is not a descendant of `node`.
pugi::xml_node node_after(pugi::xml_node node, pugi::xml_node top);

/// The name of an SVG element without prefix; empty for other nodes.
std::string local_name(pugi::xml_node node);

bool is_blank(std::string_view text);

std::string_view trimmed(std::string_view text);

/// Whether a character may occur in a CSS name.
bool is_name_character(char c);

/// Splits a text at white space.
std::vector<std::string_view> words_of(std::string_view text);

bool has_word(std::string_view text, std::string_view word);

/// Encodes a code point; the replacement character if it is invalid.
std::string utf8(std::uint32_t code);

/// Resolves character references and the five XML entities. Entities of a document type are kept.
std::string unescaped(std::string_view raw);

/// Whether an attribute is a reference: href, with or without prefix.
bool is_reference(std::string_view attribute);

/// The name of the reference attribute, "xlink:href" or "href"; declares the prefix if needed.
std::string reference_name(pugi::xml_node root);

/// Escapes text for attribute values.
std::string escaped(std::string_view text);

/// Decodes percent escapes of a URL fragment.
std::string without_percents(std::string_view fragment);

/// The value of href, or of xlink:href with any prefix; empty if there is none. References within the file
/// are decoded.
std::string reference_of(pugi::xml_node node);
void set_reference(pugi::xml_node node, const std::string& id); ///< sets all reference attributes

/// Copies the line numbers and text boxes of an element or document to its copy.
void keep_places(const SvgDocument& from, pugi::xml_node original, SvgDocument& to, pugi::xml_node copy);
/// The line of the nearest enclosing element of the file; 0 if unknown.
std::size_t line_of(const SvgDocument& document, pugi::xml_node node);

/// Returns a label such as: rect "wall" (line 12).
std::string label(const SvgDocument& document, pugi::xml_node node);

FileError error_at(const SvgDocument& document, pugi::xml_node node, const std::string& why);

/// An error inside an attribute; its line and column are relative to the attribute.
FileError error_in(const SvgDocument& document, pugi::xml_node node, const std::string& attribute,
                   const FileError& error);

/// Whether a node is `element` or its descendant.
bool is_in(pugi::xml_node node, pugi::xml_node element);

/// Removes the ids of an element and its descendants.
void drop_ids(pugi::xml_node top);

/// The elements of a document by id. If several have the same id, the first one counts.
class IdTable {
public:
    explicit IdTable(pugi::xml_node root);

    pugi::xml_node find(const std::string& id) const; ///< none if there is no such id
    /// The target of a reference "#id"; none for other references.
    pugi::xml_node referred(const std::string& reference) const {
        return reference.starts_with('#') ? find(reference.substr(1)) : pugi::xml_node();
    }
    void move(const std::string& id, pugi::xml_node node) { nodes_[id] = node; }

    /// Gives the element a unique id: the stem and a number. Characters that url(#id) cannot contain become
    /// hyphens.
    std::string name(pugi::xml_node node, const std::string& stem);

private:
    std::unordered_map<std::string, pugi::xml_node> nodes_;
    std::unordered_map<std::string, std::size_t> next_; // next number, by stem
};

} // namespace cageform_support::detail

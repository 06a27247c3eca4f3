#include "svg/xml.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>

namespace cageform_support::detail {

pugi::xml_node next_node(pugi::xml_node node, pugi::xml_node top) {
    return node.first_child() ? node.first_child() : node_after(node, top);
}

pugi::xml_node node_after(pugi::xml_node node, pugi::xml_node top) {
    while (node != top && !node.next_sibling()) node = node.parent();
    return node == top ? pugi::xml_node() : node.next_sibling();
}

pugi::xml_node root_element(pugi::xml_node node) {
    return node.root().find_child([](pugi::xml_node n) { return n.type() == pugi::node_element; });
}

std::string name_prefix(pugi::xml_node node) {
    const std::string_view root = root_element(node).name();
    return std::string(root.substr(0, root.find(':') + 1)); // npos + 1 is zero
}

std::string local_name(pugi::xml_node node) {
    if (node.type() != pugi::node_element) return {};
    const std::string prefix = name_prefix(node);
    const std::string_view name = node.name();
    if (!name.starts_with(prefix)) return {};
    return std::string(name.substr(prefix.size()));
}

bool is_blank(std::string_view text) {
    return std::all_of(text.begin(), text.end(), is_space);
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
    return text;
}

bool is_name_character(char c) {
    return is_letter(c) || is_digit(c) || c == '-' || c == '_' || (c & 0x80) != 0;
}

std::vector<std::string_view> words_of(std::string_view text) {
    std::vector<std::string_view> words;
    for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
        const auto size =
            static_cast<std::size_t>(std::find_if(text.begin(), text.end(), is_space) - text.begin());
        words.push_back(text.substr(0, size));
        text.remove_prefix(size);
    }
    return words;
}

bool has_word(std::string_view text, std::string_view word) {
    const auto words = words_of(text);
    return std::find(words.begin(), words.end(), word) != words.end();
}

std::string utf8(std::uint32_t code) {
    if (code < 0x80) return {static_cast<char>(code)};
    if (code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) code = 0xfffd;
    const std::uint32_t more = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3; // bytes after the first
    constexpr std::array<std::uint32_t, 4> first{0, 0xc0, 0xe0, 0xf0};
    std::string text(1, static_cast<char>(first[more] | code >> 6 * more));
    for (std::uint32_t k = more; k-- > 0;) text += static_cast<char>(0x80 | (code >> 6 * k & 0x3f));
    return text;
}

std::string unescaped(std::string_view raw) {
    static const std::map<std::string_view, char> entities = {
        {"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"quot", '"'}, {"apos", '\''}};
    std::string text;
    while (!raw.empty()) {
        const std::size_t plain = std::min(raw.find('&'), raw.size());
        text += raw.substr(0, plain);
        raw.remove_prefix(plain);
        const std::size_t end = raw.find(';');
        if (end == std::string_view::npos) return text += raw;
        const std::string_view name = raw.substr(1, end - 1);
        const bool hexadecimal = name.starts_with("#x");
        const std::string_view digits = name.substr(std::min<std::size_t>(hexadecimal ? 2 : 1, name.size()));
        std::uint32_t code = 0;
        const auto [stop, failed] =
            std::from_chars(digits.data(), digits.data() + digits.size(), code, hexadecimal ? 16 : 10);
        const bool whole = failed == std::errc() && stop == digits.data() + digits.size();
        if (const auto entity = entities.find(name); entity != entities.end()) {
            text += entity->second;
        } else if (name.starts_with('#') && whole) {
            text += utf8(code);
        } else {
            text += raw.substr(0, end + 1);
        }
        raw.remove_prefix(end + 1);
    }
    return text;
}

std::string attribute_text(pugi::xml_node node, const char* name) {
    return unescaped(node.attribute(name).value());
}

void set_attribute(pugi::xml_node node, const char* name, const std::string& raw) {
    if (!node.attribute(name)) node.append_attribute(name);
    node.attribute(name).set_value(raw.c_str());
}

std::string reference_name(pugi::xml_node root) {
    const char* const space = "http://www.w3.org/1999/xlink";
    if (!root.attribute("xmlns:xlink")) set_attribute(root, "xmlns:xlink", space);
    return attribute_text(root, "xmlns:xlink") == space ? "xlink:href" : "href";
}

std::string escaped(std::string_view text) {
    std::string result;
    for (const char c : text) {
        if (c == '&') {
            result += "&amp;";
        } else if (c == '<') {
            result += "&lt;";
        } else if (c == '"') {
            result += "&quot;";
        } else {
            result += c;
        }
    }
    return result;
}

bool is_reference(std::string_view attribute) {
    return attribute == "href" || attribute.ends_with(":href");
}

void set_reference(pugi::xml_node node, const std::string& id) {
    for (pugi::xml_attribute attribute : node.attributes()) {
        if (is_reference(attribute.name())) attribute.set_value(('#' + escaped(id)).c_str());
    }
}

std::string without_percents(std::string_view fragment) {
    std::string text;
    for (std::size_t at = 0; at < fragment.size(); ++at) {
        unsigned byte = 0;
        const char* const digits = fragment.data() + at + 1;
        const bool is_code = fragment[at] == '%' && at + 2 < fragment.size() &&
                             std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2;
        text += is_code ? static_cast<char>(byte) : fragment[at];
        at += is_code ? 2 : 0;
    }
    return text;
}

std::string reference_of(pugi::xml_node node) {
    std::string reference = attribute_text(node, "href");
    for (const pugi::xml_attribute attribute : node.attributes()) {
        const bool counts = !node.attribute("href") && is_reference(attribute.name());
        if (counts) reference = unescaped(attribute.value());
    }
    return reference.starts_with('#') ? without_percents(reference) : reference;
}

std::size_t line_of(const SvgDocument& document, pugi::xml_node node) {
    for (; node; node = node.parent()) {
        const auto found = document.lines.find(node.hash_value());
        if (found != document.lines.end()) return found->second;
    }
    return 0;
}

std::string name_and_id(pugi::xml_node node) {
    const std::string name = node.name();
    return node.attribute("id") ? name + " \"" + attribute_text(node, "id") + '"' : name;
}

std::string label(const SvgDocument& document, pugi::xml_node node) {
    return to_string(FileError{name_and_id(node), line_of(document, node), 0});
}

FileError error_at(const SvgDocument& document, pugi::xml_node node, const std::string& why) {
    return {document.name + ": " + name_and_id(node) + ": " + why, line_of(document, node), 0};
}

FileError error_in(const SvgDocument& document, pugi::xml_node node, const std::string& attribute,
                   const FileError& error) {
    const std::string place = std::to_string(error.line) + ':' + std::to_string(error.column);
    return error_at(document, node, attribute + " at " + place + ": " + error.message);
}

bool is_in(pugi::xml_node node, pugi::xml_node group) {
    while (node && node != group) node = node.parent();
    return bool(node);
}

void drop_ids(pugi::xml_node top) {
    for (pugi::xml_node node = top; node; node = next_node(node, top)) node.remove_attribute("id");
}

IdTable::IdTable(pugi::xml_node root) {
    for (pugi::xml_node node = root; node; node = next_node(node, root)) {
        if (node.attribute("id")) nodes_.try_emplace(attribute_text(node, "id"), node);
    }
}

pugi::xml_node IdTable::find(const std::string& id) const {
    const auto found = nodes_.find(id);
    return found == nodes_.end() ? pugi::xml_node() : found->second;
}

std::string IdTable::name(pugi::xml_node node, const std::string& stem) {
    std::string plain = stem; // valid in url(#id)
    std::replace_if(
        plain.begin(), plain.end(),
        [](char c) { return is_space(c) || std::string_view("%()'\"\\").find(c) != std::string_view::npos; },
        '-');
    std::size_t& number = next_.try_emplace(plain, 2).first->second;
    std::string id = plain + '-' + std::to_string(number++);
    while (nodes_.count(id) != 0) id = plain + '-' + std::to_string(number++);
    nodes_[id] = node;
    if (!node.attribute("id")) node.prepend_attribute("id");
    set_attribute(node, "id", escaped(id));
    return id;
}

void keep_places(const SvgDocument& from, pugi::xml_node original, SvgDocument& to, pugi::xml_node copy) {
    pugi::xml_node node = copy;
    for (pugi::xml_node rest = original; rest && node; rest = next_node(rest, original)) {
        const auto line = from.lines.find(rest.hash_value());
        if (line != from.lines.end()) to.lines[node.hash_value()] = line->second;
        const auto box = from.text_boxes.find(rest.hash_value());
        if (box != from.text_boxes.end()) to.text_boxes[node.hash_value()] = box->second;
        node = next_node(node, copy);
    }
}

SvgDocument copy_of(const SvgDocument& document) {
    SvgDocument copy;
    copy.name = document.name;
    copy.xml.reset(document.xml);
    keep_places(document, document.xml, copy, copy.xml);
    return copy;
}

} // namespace cageform_support::detail

#pragma once

// Wavefront OBJ files: reading vertices, normals and faces, writing the file with moved vertices.
//
// All other lines are copied byte by byte: groups, materials, texture coordinates, comments, colours after a
// vertex.

#include "files/mesh_file.hpp"

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

namespace detail {

/// Splits a text into statements of words. Lines end with \n, \r\n or \r; a backslash at the end of a line
/// joins it with the next. A comment begins with # at the start of a word and ends with its line, even after
/// a backslash.
class ObjScanner {
public:
    explicit ObjScanner(std::string_view text)
        : text_(text) {
        if (text_.starts_with("\xef\xbb\xbf")) at_ = 3; // a byte order mark
    }

    /// The next nonempty statement and its first line; false at the end of the text.
    bool next(std::vector<std::string_view>& words, std::size_t& line) {
        words.clear();
        while (at_ < text_.size() && words.empty()) {
            line = line_;
            read_statement(words);
        }
        return !words.empty();
    }

private:
    /// The length of the line break at a position, or 0.
    std::size_t line_end(std::size_t at) const {
        if (at >= text_.size()) return 0;
        if (text_[at] == '\r') return at + 1 < text_.size() && text_[at + 1] == '\n' ? 2 : 1;
        return text_[at] == '\n' ? 1 : 0;
    }
    bool is_join(std::size_t at) const { return text_[at] == '\\' && line_end(at + 1) != 0; }

    void read_statement(std::vector<std::string_view>& words) {
        while (at_ < text_.size()) {
            if (const std::size_t end = line_end(at_); end != 0) {
                at_ += end;
                ++line_;
                return;
            }
            if (is_join(at_)) {
                at_ += 1 + line_end(at_ + 1);
                ++line_;
            } else if (text_[at_] == ' ' || text_[at_] == '\t') {
                ++at_;
            } else if (text_[at_] == '#') {
                while (at_ < text_.size() && line_end(at_) == 0) ++at_;
            } else {
                const std::size_t begin = at_;
                while (at_ < text_.size() && text_[at_] != ' ' && text_[at_] != '\t' && line_end(at_) == 0 &&
                       !is_join(at_)) {
                    ++at_;
                }
                words.push_back(text_.substr(begin, at_ - begin));
            }
        }
    }

    std::string_view text_;
    std::size_t at_ = 0;
    std::size_t line_ = 1;
};

/// Parses an index of a face. Returns the error; empty on success.
///
///   word     from 1, or negative: -1 is the last element before this line
///   so_far   number of elements before this line
///   count    number of elements in the file
///   index    out: from 0
std::string parse_index(std::string_view word, std::size_t so_far, std::size_t count, const char* what,
                        std::uint32_t& index);

/// Parses the three numbers after the first word, with their positions in the text. Returns the error; empty
/// on success.
std::string parse_three_numbers(std::span<const std::string_view> words, std::string_view text, Point3& point,
                                ObjNumbers& numbers);

/// The line of the `v` statement of a vertex; 0 if the file has no text.
std::size_t line_of_vertex(const MeshFile& file, std::size_t vertex);

/// Reverses the corners of each face, except the first.
std::string with_faces_reversed(const std::string& text);

} // namespace detail

/// Parses an OBJ file.
///
///   name    prefix of every message
///   fails   if there are no vertices, on coordinates that are not finite (normals may be), and on faces with
///           fewer than three corners or an invalid index
Expected<MeshFile> parse_obj(std::string text, std::string name,
                             StrayVertices strays = StrayVertices::refuse);

/// The file's text with moved vertices and normals. Unchanged numbers keep their digits; others have the
/// fewest digits that restore them. If the Jacobians rotate a shared normal differently at its vertices, each
/// vertex gets its own normal.
std::string to_text(const MeshFile& file, const MovedVertices& moved);
inline std::string to_text(const MeshFile& file, std::span<const Point3> places) {
    return to_text(file, MovedVertices{places});
}

} // namespace cageform_support

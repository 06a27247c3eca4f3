#include "files/obj_file.hpp"

#include "files/moved_normals.hpp"
#include "files/stl_file.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

namespace cageform_support {

namespace detail {

std::string parse_index(std::string_view word, std::size_t so_far, std::size_t count, const char* what,
                        std::uint32_t& index) {
    const std::string_view digits = word.starts_with('+') ? word.substr(1) : word;
    long long value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool whole = end == digits.data() + digits.size() && !digits.empty();
    if (error == std::errc::invalid_argument || !whole) return "not an index: " + quoted(word);
    const bool fits = error == std::errc{};
    if (fits && value == 0) return std::string("a ") + what + " index is 0; indices count from 1";
    const bool found = value > 0 ? static_cast<unsigned long long>(value) <= count
                                 : value >= -static_cast<long long>(so_far);
    if (!fits || !found) {
        return std::string(what) + " index " + std::string(word.substr(0, 40)) +
               " is out of range: the file has " + std::to_string(value < 0 ? so_far : count) +
               (value < 0 ? " before this line" : "");
    }
    index = static_cast<std::uint32_t>(value > 0 ? value - 1 : static_cast<long long>(so_far) + value);
    return {};
}

/// The number N of the first group name part_N; 0 if there is none.
int part_of(std::span<const std::string_view> names) {
    constexpr std::string_view prefix = "part_";
    for (const std::string_view name : names) {
        int number = 0;
        constexpr int most = 1'000'000;
        if (name.starts_with(prefix) && parse_whole(name.substr(prefix.size()), number) && number > -most &&
            number < most)
            return number;
    }
    return 0;
}

/// Parses "v", "v/vt", "v//vn" or "v/vt/vn"; texture coordinates are ignored.
std::string parse_corner(std::string_view word, const std::array<std::size_t, 2>& so_far,
                         const std::array<std::size_t, 2>& count, MeshCorner& corner) {
    const std::size_t first = word.find('/');
    std::string why = parse_index(word.substr(0, first), so_far[0], count[0], "vertex", corner.vertex);
    if (!why.empty() || first == std::string_view::npos) return why;
    const std::size_t second = word.find('/', first + 1);
    if (second == std::string_view::npos || second + 1 == word.size()) return {};
    return parse_index(word.substr(second + 1), so_far[1], count[1], "normal", corner.normal);
}

std::string parse_three_numbers(std::span<const std::string_view> words, std::string_view text, Point3& point,
                                ObjNumbers& numbers) {
    if (words.size() < 4) return "three numbers are expected";
    for (std::size_t k = 0; k < 3; ++k) {
        const std::string_view word = words[k + 1];
        numbers.begin[k] = static_cast<std::size_t>(word.data() - text.data());
        numbers.end[k] = numbers.begin[k] + word.size();
        if (const std::string why = parse_number(word, point[k]); !why.empty()) return why;
    }
    return {};
}

std::size_t line_of_vertex(const MeshFile& file, std::size_t vertex) {
    std::vector<std::string_view> words;
    std::size_t line = 0;
    for (ObjScanner scanner(file.text); scanner.next(words, line);) {
        if (words[0] == "v" && vertex-- == 0) return line;
    }
    return 0;
}

std::string with_faces_reversed(const std::string& text) {
    std::string turned;
    turned.reserve(text.size());
    std::size_t copied = 0, line = 0;
    std::vector<std::string_view> words;
    for (ObjScanner scanner(text); scanner.next(words, line);) {
        if (words[0] != "f") continue;
        const auto offset_of = [&](std::string_view word) { return std::size_t(word.data() - text.data()); };
        for (std::size_t n = 2; n < words.size(); ++n) { // the first corner stays the first
            const std::size_t begin = offset_of(words[n]);
            turned.append(text, copied, begin - copied).append(words[words.size() + 1 - n]);
            copied = begin + words[n].size();
        }
    }
    return turned.append(text, copied);
}

/// Parses the statements of an OBJ file.
class ObjReader {
public:
    ObjReader(MeshFile& file, StrayVertices strays)
        : file_(file)
        , strays_(strays) {}

    /// Returns the error, if any.
    std::optional<FileError> read() {
        if (auto error = read_vertices()) return error;
        if (file_.vertices.empty()) return refuse_all();
        complete_colours();
        if (auto error = read_faces()) return error;
        std::string why = place_left_out(file_, used_, strays_);
        if (why.empty()) why = triangulate(file_);
        if (!why.empty()) return FileError{file_.name + ": " + why};
        return std::nullopt;
    }

private:
    FileError refuse(const std::string& why) const {
        const std::string format = likely_format();
        if (!format.empty()) return FileError{file_.name + ": " + format};
        if (has_control_characters(std::string_view(file_.text).substr(0, 512))) return refuse_all();
        return FileError{file_.name + ": " + why, line_};
    }

    /// The error of a file without vertices.
    FileError refuse_all() const {
        const std::string format = likely_format();
        return {file_.name + ": holds no vertices: it " +
                (format.empty() ? "is no glTF, PLY, STL or Medit file, and has no OBJ lines \"v x y z\""
                                : format)};
    }

    /// "looks like a file of the format FBX"; empty if no other format is known.
    std::string likely_format() const {
        const std::string_view format = other_format(file_.text);
        if (format.empty()) return {};
        return "looks like a file of the format " + std::string(format) +
               (format == "SVG" ? ", which deform_svg reads" : "");
    }

    std::optional<FileError> read_vertices() {
        for (ObjScanner scanner(file_.text); scanner.next(words_, line_);) {
            if (words_[0] != "v" && words_[0] != "vn") continue;
            ObjNumbers numbers{words_[0] == "vn"};
            Point3 point{};
            const std::string why = parse_three_numbers(words_, file_.text, point, numbers);
            if (!why.empty()) return refuse(why);
            if (!numbers.is_normal && !cageform::is_finite(point)) {
                if (strays_ == StrayVertices::refuse) return refuse(vertex_not_finite);
                file_.left_out.push_back(file_.vertices.size());
                lines_left_out_.push_back(line_);
            }
            (numbers.is_normal ? file_.normals : file_.vertices).push_back(point);
            file_.numbers.push_back(numbers);
            if (numbers.is_normal || words_.size() != 7) continue;
            Point3 colour{};
            ObjNumbers ignored;
            const auto of_colour = std::span(words_).subspan(3); // parse_three_numbers() skips a word
            if (!parse_three_numbers(of_colour, file_.text, colour, ignored).empty()) continue;
            file_.colours.resize(file_.vertices.size() - 1, Point3{1, 1, 1});
            file_.colours.push_back(colour);
        }
        return std::nullopt;
    }

    void complete_colours() {
        if (!file_.colours.empty()) file_.colours.resize(file_.vertices.size(), Point3{1, 1, 1});
        for (const Point3& colour : file_.colours)
            file_.has_bytes_as_colours |= std::max({colour[0], colour[1], colour[2]}) > 1;
        for (Point3& colour : file_.colours) {
            if (file_.has_bytes_as_colours && colour != Point3{1, 1, 1}) colour = (1.0 / 255) * colour;
        }
    }

    /// Call after read_vertices(), since indices may refer to later lines.
    std::optional<FileError> read_faces() {
        const std::array<std::size_t, 2> count{file_.vertices.size(), file_.normals.size()};
        std::array<std::size_t, 2> so_far{};
        used_.resize(file_.vertices.size());
        int part = 0;
        for (ObjScanner scanner(file_.text); scanner.next(words_, line_);) {
            if (words_[0] == "g") part = part_of(std::span(words_).subspan(1));
            if (words_[0] == "v") ++so_far[0];
            if (words_[0] == "vn") ++so_far[1];
            if (words_[0] != "f") continue;
            if (words_.size() < 4) return refuse("a face has fewer than three corners");
            MeshFace face{{}, line_};
            for (const std::string_view word : std::span(words_).subspan(1)) {
                MeshCorner& corner = face.corners.emplace_back();
                const std::string why = parse_corner(word, so_far, count, corner);
                if (!why.empty()) return refuse(why);
                used_[corner.vertex] = true;
                const auto& strays = file_.left_out;
                const auto found = std::lower_bound(strays.begin(), strays.end(), std::size_t{corner.vertex});
                if (found == strays.end() || *found != corner.vertex) continue;
                line_ = lines_left_out_[std::size_t(found - strays.begin())];
                return refuse(vertex_not_finite);
            }
            file_.faces.push_back(std::move(face));
            file_.face_parts.push_back(part);
        }
        if (std::all_of(file_.face_parts.begin(), file_.face_parts.end(), [](int of) { return of == 0; }))
            file_.face_parts.clear();
        return std::nullopt;
    }

    MeshFile& file_;
    StrayVertices strays_;
    std::vector<std::string_view> words_;     // of the current statement
    std::size_t line_ = 1;                    // of the current statement
    std::vector<std::size_t> lines_left_out_; // as MeshFile::left_out
    std::vector<bool> used_;                  // #vertices: whether a face uses it
};

} // namespace detail

Expected<MeshFile> parse_obj(std::string text, std::string name, StrayVertices strays) {
    MeshFile file;
    file.name = std::move(name);
    file.text = std::move(text);
    if (file.text.empty()) return FileError{file.name + ": is empty"};
    if (auto error = detail::ObjReader(file, strays).read()) return std::move(*error);
    return file;
}

std::string describe_others(const MeshFile& file, std::initializer_list<std::string_view> keywords) {
    std::map<std::string_view, std::size_t> counts;
    std::vector<std::string_view> words;
    std::size_t line = 1;
    for (detail::ObjScanner scanner(file.text); scanner.next(words, line);) {
        if (std::find(keywords.begin(), keywords.end(), words[0]) == keywords.end()) ++counts[words[0]];
    }
    std::string text = file.document == nullptr ? std::string() : file.document->others();
    const bool has_normals = std::find(keywords.begin(), keywords.end(), "vn") != keywords.end();
    if (file.document != nullptr && !file.normals.empty() && !has_normals)
        text += (text.empty() ? "" : ", ") + std::to_string(file.normals.size()) + " normals";
    for (const auto& [word, count] : counts)
        text += (text.empty() ? "" : ", ") + std::to_string(count) + " of " + detail::quoted(word);
    if (!file.colours.empty())
        text += (text.empty() ? "" : ", ") + std::to_string(file.colours.size()) + " colours";
    return text;
}

/// Updates the normal indices of corners after normal n was split into max(1, #split[n]) normals.
static std::string with_normals_split(const std::string& text, const MeshFile& file,
                                      const std::vector<std::vector<std::uint32_t>>& split) {
    std::vector<std::size_t> first(split.size(), 1); // index of each normal's first copy
    for (std::size_t n = 1; n < split.size(); ++n)
        first[n] = first[n - 1] + std::max<std::size_t>(1, split[n - 1].size());
    std::string result;
    result.reserve(text.size());
    std::size_t copied = 0, line = 0;
    auto face = file.faces.begin();
    std::vector<std::string_view> words;
    for (detail::ObjScanner scanner(text); scanner.next(words, line);) {
        if (words[0] != "f") continue;
        for (std::size_t k = 1; k < words.size(); ++k) {
            const auto& [vertex, normal] = face->corners[k - 1];
            if (normal == MeshCorner::none) continue;
            const auto& of_normal = split[normal];
            const auto own = std::lower_bound(of_normal.begin(), of_normal.end(), vertex) - of_normal.begin();
            const auto end = std::size_t(words[k].data() - text.data()) + words[k].size();
            const std::size_t begin = text.rfind('/', end - 1) + 1;
            result.append(text, copied, begin - copied)
                .append(std::to_string(first[normal] + std::size_t(own)));
            copied = end;
        }
        ++face;
    }
    return result.append(text, copied);
}

std::string to_text(const MeshFile& file, const MovedVertices& moved) {
    const MovedNormals normals(file, moved);
    const auto split = normals.split();
    std::string text;
    text.reserve(file.text.size() + 16 * file.numbers.size());
    std::size_t copied = 0, vertex = 0, normal = 0;
    for (const ObjNumbers& numbers : file.numbers) {
        const Point3& rest = numbers.is_normal ? file.normals[normal] : file.vertices[vertex];
        Point3 now = numbers.is_normal ? normals.of_file()[normal] : moved.places[vertex];
        if (numbers.is_normal && !split.empty() && !split[normal].empty()) {
            const std::size_t begin = file.text.rfind("vn", numbers.begin[0]);
            text.append(file.text, copied, begin - copied);
            copied = begin;
            for (const std::uint32_t of : split[normal]) {
                now = normals.of_corner(of, std::uint32_t(normal));
                if (of == split[normal].back()) break; // replaces the original statement
                text += "vn";
                for (const double x : now.v) detail::append_digits(text += ' ', x);
                text += '\n';
            }
        }
        const bool is_left_out =
            !numbers.is_normal && std::binary_search(file.left_out.begin(), file.left_out.end(), vertex);
        ++(numbers.is_normal ? normal : vertex);
        if (is_left_out) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            if (now[k] == rest[k] || !std::isfinite(now[k])) continue;
            text.append(file.text, copied, numbers.begin[k] - copied);
            detail::append_digits(text, now[k]);
            copied = numbers.end[k];
        }
    }
    text.append(file.text, copied);
    return split.empty() ? text : with_normals_split(text, file, split);
}

} // namespace cageform_support

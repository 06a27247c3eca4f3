#include "files/obj_file.hpp"

#include "files/moved_normals.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
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

std::string_view other_format(std::string_view text) {
    const std::string_view begin = text.substr(0, 512);
    const auto begins_with_word = [&](std::string_view word) {
        return begin.starts_with(word) && begin.size() > word.size() &&
               std::strchr(" \t\r\n", begin[word.size()]) != nullptr;
    };
    constexpr std::size_t stl_head = 84, stl_triangle = 50; // bytes
    if (text.size() > stl_head) {
        std::uint32_t triangles = 0;
        for (std::size_t k = 4; k > 0; --k)
            triangles = triangles << 8 | static_cast<unsigned char>(text[stl_head - 5 + k]);
        if (text.size() == stl_head + std::uint64_t{triangles} * stl_triangle) return "STL";
    }
    if (begins_with_word("solid") || begins_with_word("SOLID")) return "STL";
    if (begin.starts_with("glTF") || (begin.starts_with('{') && text.find("\"asset\"") != text.npos))
        return "glTF";
    if (begins_with_word("ply")) return "PLY";
    constexpr std::pair<std::string_view, std::string_view> known[] = {
        {"\xff\xfe", "UTF-16"},
        {"\xfe\xff", "UTF-16"},
        {"\x1f\x8b", "gzip"},
        {"PK\3\4", "ZIP"},
        {"BLENDER", "Blender"},
        {"#usda", "USD"},
        {"PXR-USDC", "USD"},
        {"#VRML", "VRML"},
        {"#X3D", "X3D"},
        {"#Inventor", "Inventor"},
        {"MM", "3DS"},
        {"xof ", "DirectX"},
        {"ISO-10303-21", "STEP"},
        {"# vtk", "VTK"},
        {"MeshVersionFormatted", "Medit"},
        {"$MeshFormat", "Gmsh"},
        {"%PDF", "PDF"},
        {"\x89PNG", "PNG"},
        {"<?xml", "XML"},
        {"<!DOCTYPE", "HTML"},
        {"<html", "HTML"},
        {"version https://git-lfs", "a pointer of Git LFS"}};
    for (const auto& [first, format] : known) {
        if (begin.starts_with(first)) return format;
    }
    if (begin.starts_with("Kaydara FBX Binary") || begin.starts_with("; FBX")) return "FBX";
    for (const std::string_view word : {"OFF", "COFF", "NOFF", "STOFF", "4OFF"}) {
        if (begins_with_word(word)) return "OFF";
    }
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
                         const std::array<std::size_t, 2>& count, ObjCorner& corner) {
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

Point3 area_vector(const ObjFace& face, std::span<const Point3> vertices) {
    Point3 sum{};
    const Point3& tip = vertices[face.corners.front().vertex];
    for (std::size_t k = 1; k + 1 < face.corners.size(); ++k) {
        sum = sum + cross(vertices[face.corners[k].vertex] - tip, vertices[face.corners[k + 1].vertex] - tip);
    }
    return sum;
}

std::string place_left_out(ObjFile& file, const std::vector<bool>& used, StrayVertices strays) {
    std::vector<Point3> places;
    for (std::size_t i = 0; i < used.size(); ++i) {
        if (used[i]) places.push_back(file.vertices[i]);
    }
    if (strays == StrayVertices::leave_out && !places.empty()) {
        const auto box = cageform::bounds_of(std::span<const Point3>(places));
        const auto near_box = box.widened(1e6 * box.diagonal());
        file.left_out.clear();
        for (std::size_t i = 0; i < used.size(); ++i) {
            const Point3& p = file.vertices[i];
            if (!used[i] && !(cageform::is_finite(p) && near_box.covers({p, p}))) file.left_out.push_back(i);
        }
    }
    if (file.left_out.size() == file.vertices.size()) return "no vertex has finite coordinates";
    std::size_t sound = 0; // the first vertex that is kept
    while (sound < file.left_out.size() && file.left_out[sound] == sound) ++sound;
    for (const std::size_t i : file.left_out) file.vertices[i] = file.vertices[sound];
    return {};
}

/// Whether all triangles of a face have the orientation of the face.
bool lies_flat(const Triangles& triangles, const ObjFace& face, std::span<const Point3> vertices) {
    if (triangles.size() + 2 != face.corners.size()) return false;
    const Point3 normal = area_vector(face, vertices);
    for (const auto& [a, b, c] : triangles) {
        const Point3 own = cross(vertices[b] - vertices[a], vertices[c] - vertices[a]);
        if (dot(normal, own) < 0 || (normal == Point3{} && own != Point3{})) return false;
    }
    return true;
}

/// Triangulates the faces by tinyobjloader. Its ear clipping is wrong for some faces of five or more corners
/// that are not convex; the first valid fan is used instead.
std::string triangulate(ObjFile& file) {
    std::string plain;
    for (const Point3& v : file.vertices) {
        plain += 'v';
        for (std::size_t k = 0; k < 3; ++k) append_digits(plain += ' ', v[k]);
        plain += '\n';
    }
    for (std::size_t f = 0; f < file.faces.size(); ++f) { // smoothing groups identify the faces
        plain += "s " + std::to_string(f + 1) + "\nf";
        for (const ObjCorner& corner : file.faces[f].corners)
            plain += ' ' + std::to_string(corner.vertex + 1);
        plain += '\n';
    }
    tinyobj::ObjReader reader;
    tinyobj::ObjReaderConfig config;
    config.triangulate = true;
    config.vertex_color = false;
    if (!reader.ParseFromString(plain, "", config)) return reader.Error();
    std::vector<Triangles> of_face(file.faces.size());
    for (const auto& shape : reader.GetShapes()) {
        const auto& mesh = shape.mesh;
        for (std::size_t t = 0; t < mesh.smoothing_group_ids.size(); ++t) {
            std::array<std::uint32_t, 3> triangle;
            for (std::size_t k = 0; k < 3; ++k)
                triangle[k] = static_cast<std::uint32_t>(mesh.indices[3 * t + k].vertex_index);
            of_face.at(mesh.smoothing_group_ids[t] - 1).push_back(triangle);
        }
    }
    for (std::size_t f = 0; f < file.faces.size(); ++f) {
        const auto& corners = file.faces[f].corners;
        Triangles triangles = std::move(of_face[f]);
        const std::size_t n = corners.size();
        bool flat = n == 3 || lies_flat(triangles, file.faces[f], file.vertices);
        for (std::size_t tip = 0; !flat && tip < n; ++tip) {
            Triangles fan;
            for (std::size_t k = 1; k + 1 < n; ++k) {
                fan.push_back(
                    {corners[tip].vertex, corners[(tip + k) % n].vertex, corners[(tip + k + 1) % n].vertex});
            }
            flat = lies_flat(fan, file.faces[f], file.vertices);
            if (flat) triangles = std::move(fan);
        }
        if (!flat) file.folded.push_back(f);
        file.triangles.insert(file.triangles.end(), triangles.begin(), triangles.end());
        file.triangle_faces.resize(file.triangles.size(), static_cast<std::uint32_t>(f));
    }
    return {};
}

/// Parses the statements of an OBJ file.
class ObjReader {
public:
    ObjReader(ObjFile& file, StrayVertices strays)
        : file_(file)
        , strays_(strays) {}

    /// Returns the error, if any.
    std::optional<FileError> read() {
        if (auto error = read_vertices()) return error;
        if (file_.vertices.empty()) {
            const std::string_view format = other_format(file_.text);
            return FileError{
                file_.name + ": holds no vertices (lines \"v x y z\")" +
                (format.empty() ? "" : ": it looks like a file of the format " + std::string(format))};
        }
        complete_colours();
        if (auto error = read_faces()) return error;
        std::string why = place_left_out(file_, used_, strays_);
        if (why.empty()) why = triangulate(file_);
        if (!why.empty()) return FileError{file_.name + ": " + why};
        return std::nullopt;
    }

private:
    FileError refuse(const std::string& why) const {
        const std::string_view format = other_format(file_.text);
        if (!format.empty())
            return FileError{file_.name + ": looks like a file of the format " + std::string(format)};
        return FileError{file_.name + ": " + why, line_};
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
            ObjFace face{{}, line_};
            for (const std::string_view word : std::span(words_).subspan(1)) {
                ObjCorner& corner = face.corners.emplace_back();
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

    ObjFile& file_;
    StrayVertices strays_;
    std::vector<std::string_view> words_;     // of the current statement
    std::size_t line_ = 1;                    // of the current statement
    std::vector<std::size_t> lines_left_out_; // as ObjFile::left_out
    std::vector<bool> used_;                  // #vertices: whether a face uses it
};

} // namespace detail

Expected<ObjFile> parse_obj(std::string text, std::string name, StrayVertices strays) {
    ObjFile file;
    file.name = std::move(name);
    file.text = std::move(text);
    if (file.text.empty()) return FileError{file.name + ": is empty"};
    if (auto error = detail::ObjReader(file, strays).read()) return std::move(*error);
    return file;
}

Expected<ObjFile> load_obj(const std::filesystem::path& path, StrayVertices strays) {
    auto text = read_text(path.string());
    return text ? parse_obj(std::move(*text), path.string(), strays) : text.error();
}

std::optional<FileError> single_precision_fault(const ObjFile& file) {
    std::vector<std::string_view> words;
    std::size_t line = 1, vertex = 0;
    for (detail::ObjScanner scanner(file.text); scanner.next(words, line);) {
        if (words[0] != "v") continue;
        const Point3& p = file.vertices[vertex++];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::string why = detail::single_precision_fault(p[k]);
            if (!why.empty())
                return FileError{file.name + ": v " + std::to_string(vertex) + ": " + why, line};
        }
    }
    return std::nullopt;
}

int side_of(std::span<const Point3> rest, std::span<const Point3> moved) {
    const auto mean_of = [](std::span<const Point3> places) {
        Point3 sum{};
        for (const Point3& p : places) sum = sum + (1 / double(places.size())) * p;
        return sum;
    };
    const Point3 middle = mean_of(rest), mean = mean_of(moved);
    // Σ (p - middle)(q - mean)ᵀ is the map times the positive semidefinite covariance of the figure.
    std::array<Point3, 3> columns{};
    for (std::size_t i = 0; i < rest.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k)
            columns[k] = columns[k] + (rest[i] - middle)[k] * (moved[i] - mean);
    }
    const auto& [a, b, c] = columns;
    const double volume = dot(a, cross(b, c)), most = std::sqrt(dot(a, a) * dot(b, b) * dot(c, c));
    return std::fabs(volume) > 1e-9 * most ? (volume < 0 ? -1 : 1) : 0;
}

std::vector<Point3> used_positions(std::span<const Point3> places,
                                   std::span<const std::array<std::uint32_t, 3>> triangles) {
    std::vector<Point3> shown;
    for (const auto& triangle : triangles) {
        for (const std::uint32_t vertex : triangle) shown.push_back(places[vertex]);
    }
    return shown.empty() ? std::vector<Point3>(places.begin(), places.end()) : shown;
}

double size_of(const ObjFile& figure) {
    const auto shown = used_positions(figure.vertices, figure.triangles);
    return cageform::bounds_of(std::span<const Point3>(shown)).diagonal();
}

std::string rounding_fault(const std::string& name, std::span<const Point3> places) {
    const auto bounds = cageform::bounds_of(places);
    constexpr double allowed = 1e-6;
    const double rounding = 0.5 * double(std::numeric_limits<float>::epsilon()) * bounds.magnitude();
    if (!(rounding > allowed * bounds.diagonal())) return {};
    return name + ": is far from the origin: single precision rounds positions there by up to " +
           detail::short_number(rounding) + ", " + detail::short_number(100 * rounding / bounds.diagonal()) +
           " % of its size; move it to the origin";
}

Point3 far_origin(const ObjFile& figure) {
    const auto shown = used_positions(figure.vertices, figure.triangles);
    const auto bounds = cageform::bounds_of(std::span<const Point3>(shown));
    constexpr double far_away = 8; // diagonals
    const Point3 middle = 0.5 * (bounds.lower + bounds.upper);
    const bool is_near = !(std::sqrt(dot(middle, middle)) > far_away * bounds.diagonal());
    return is_near ? Point3{} : cageform::vec_cast<double>(cageform::vec_cast<float>(middle));
}

std::vector<Point3> relative_to(const Point3& origin, std::span<const Point3> places) {
    std::vector<Point3> moved(places.begin(), places.end());
    for (Point3& p : moved) p = p - origin;
    return moved;
}

std::string describe_others(const ObjFile& file, std::initializer_list<std::string_view> keywords) {
    std::map<std::string_view, std::size_t> counts;
    std::vector<std::string_view> words;
    std::size_t line = 1;
    for (detail::ObjScanner scanner(file.text); scanner.next(words, line);) {
        if (std::find(keywords.begin(), keywords.end(), words[0]) == keywords.end()) ++counts[words[0]];
    }
    std::string text;
    for (const auto& [word, count] : counts)
        text += (text.empty() ? "" : ", ") + std::to_string(count) + " of " + detail::quoted(word);
    if (!file.colours.empty())
        text += (text.empty() ? "" : ", ") + std::to_string(file.colours.size()) + " colours";
    return text;
}

std::vector<std::vector<std::uint32_t>> face_loops(const ObjFile& file) {
    std::vector<std::vector<std::uint32_t>> loops(file.faces.size());
    for (std::size_t f = 0; f < loops.size(); ++f) {
        for (const ObjCorner& corner : file.faces[f].corners) loops[f].push_back(corner.vertex);
    }
    return loops;
}

ObjFile with_faces_reversed(ObjFile file) {
    const std::string text = std::move(file.text);
    std::string& turned = file.text = {};
    turned.reserve(text.size());
    std::size_t copied = 0, line = 0;
    std::vector<std::string_view> words;
    for (detail::ObjScanner scanner(text); scanner.next(words, line);) {
        if (words[0] != "f") continue;
        const auto offset_of = [&](std::string_view word) { return std::size_t(word.data() - text.data()); };
        for (std::size_t n = 2; n < words.size(); ++n) { // the first corner stays the first
            const std::size_t begin = offset_of(words[n]);
            turned.append(text, copied, begin - copied).append(words[words.size() + 1 - n]);
            copied = begin + words[n].size();
        }
    }
    turned.append(text, copied); // vertex lines do not move, so ObjFile::numbers stay valid
    for (ObjFace& face : file.faces) std::reverse(face.corners.begin() + 1, face.corners.end());
    for (auto& triangle : file.triangles) std::swap(triangle[1], triangle[2]);
    return file;
}

/// Updates the normal indices of corners after normal n was split into max(1, #split[n]) normals.
static std::string with_normals_split(const std::string& text, const ObjFile& file,
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
            if (normal == ObjCorner::none) continue;
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

std::string to_text(const ObjFile& file, const MovedVertices& moved) {
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

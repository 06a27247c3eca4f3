#include "files/medit_file.hpp"

#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"

#include <algorithm>

namespace cageform_support {

namespace {

/// Parser of sections: a keyword, the number of elements, and their numbers.
class MeditReader {
public:
    MeditReader(const std::string& text, MeshFile& file, StrayVertices strays)
        : text_(text)
        , scanner_(text)
        , file_(file)
        , strays_(strays) {}

    /// Returns the error, usually with a line; empty on success.
    FileError read() {
        read_all();
        return {fault_, fault_.empty() ? 0 : line_};
    }

private:
    static bool is_keyword(std::string_view word) {
        const bool has_letter = (word[0] >= 'A' && word[0] <= 'Z') || (word[0] >= 'a' && word[0] <= 'z');
        double number = 0; // nan, inf
        return has_letter && !detail::parse_number(word, number).empty();
    }
    bool next() {
        if (at_ + 1 < words_.size()) {
            ++at_;
            return true;
        }
        at_ = 0;
        return scanner_.next(words_, line_);
    }
    std::string_view word() const { return words_[at_]; }
    void refuse(const std::string& why) {
        if (fault_.empty()) fault_ = why;
    }

    void read_all() {
        if (!next() || word() != medit_keyword)
            return refuse(std::string("is not a .mesh file, which begins with ") + medit_keyword);
        while (fault_.empty() && next()) {
            if (word() == "End") break;
            if (word() == "Dimension") {
                read_dimension();
            } else if (word() == "Vertices") {
                read_vertices();
            } else if (word() == "Tetrahedra") {
                read_cells<4>("Tetrahedra", file_.tetrahedra);
            } else if (word() == "Triangles") {
                read_cells<3>("Triangles", triangles_);
            } else if (word() == "Quadrilaterals") {
                read_cells<4>("Quadrilaterals", quads_);
            }
        }
        if (!fault_.empty()) return;
        if (file_.vertices.empty()) {
            line_ = 0;
            return refuse("holds no vertices (a section \"Vertices\")");
        }
        for (const auto& [index, at] : largest_) {
            if (index < file_.vertices.size()) continue;
            line_ = at;
            return refuse("vertex index " + std::to_string(index + 1) + " is out of range: the file has " +
                          std::to_string(file_.vertices.size()));
        }
        std::vector<bool> used(file_.vertices.size());
        take_vertices_of(file_.tetrahedra, used);
        take_vertices_of(triangles_, used);
        take_vertices_of(quads_, used);
        if (!fault_.empty()) return;
        if (const std::string why = detail::place_left_out(file_, used, strays_); !why.empty()) {
            line_ = 0;
            return refuse(why);
        }
        if (!file_.tetrahedra.empty()) {
            file_.triangles = surface_of(file_.vertices, file_.tetrahedra);
            return;
        }
        file_.triangles = std::move(triangles_);
        for (const auto& [a, b, c, d] : quads_) {
            file_.triangles.push_back({a, b, c});
            file_.triangles.push_back({a, c, d});
        }
    }

    void read_dimension() {
        if (!next() || word() != "3")
            refuse("Dimension is " + (words_.empty() ? "missing" : detail::quoted(word())) +
                   ": a mesh in space has 3");
    }
    /// Parses the number of elements of a section, and calls read(n, count) for each until an error.
    template <class Read>
    void read_section(const char* name, bool is_second, const Read& read) {
        if (is_second) return refuse(std::string("a second section \"") + name + '"');
        std::size_t count = 0;
        const bool found = next();
        if (!found || !detail::parse_whole(word(), count))
            return refuse(std::string("the number of ") + name + " is missing");
        for (std::size_t n = 0; n < count && fault_.empty(); ++n) read(n, count);
    }
    /// Moves to the next number, of element n; false and an error if there is none.
    bool next_number(const char* name, std::size_t n, std::size_t count) {
        if (next() && !is_keyword(word())) return true;
        refuse(std::string(name) + " end after " + std::to_string(n) + " of " + std::to_string(count));
        return false;
    }

    void read_vertices() {
        read_section("Vertices", !file_.vertices.empty(), [&](std::size_t n, std::size_t count) {
            std::array<std::string_view, 4> words; // as a line of an OBJ file
            for (std::size_t k = 1; k < 4; ++k) {
                if (!next_number("Vertices", n, count)) return;
                words[k] = word();
            }
            Point3 point{};
            ObjNumbers numbers;
            const std::string why = detail::parse_three_numbers(words, text_, point, numbers);
            if (!why.empty()) return refuse(why);
            if (!cageform::is_finite(point)) {
                if (strays_ == StrayVertices::refuse) return refuse(detail::vertex_not_finite);
                file_.left_out.push_back(n);
                lines_left_out_.push_back(line_);
            }
            if (!next_number("Vertices", n, count)) return; // the reference
            file_.vertices.push_back(point);
            file_.numbers.push_back(numbers);
        });
    }

    template <std::size_t N>
    void read_cells(const char* name, std::vector<std::array<std::uint32_t, N>>& cells) {
        std::pair<std::size_t, std::size_t> largest; // index and line
        read_section(name, !cells.empty(), [&](std::size_t n, std::size_t count) {
            std::array<std::uint32_t, N> cell{};
            for (std::uint32_t& vertex : cell) {
                if (!next_number(name, n, count)) return;
                std::size_t index = 0;
                if (!detail::parse_whole(word(), index))
                    return refuse("not an index: " + detail::quoted(word()));
                if (index == 0) return refuse("a vertex index is 0; indices count from 1");
                if (index > largest.first) largest = {index, line_};
                vertex = std::uint32_t(index - 1);
            }
            if (!next_number(name, n, count)) return;
            cells.push_back(cell);
        });
        if (largest.first > 0) largest_.push_back({largest.first - 1, largest.second});
    }

    /// Marks the vertices of cells; an error if one is left out.
    template <class Cells>
    void take_vertices_of(const Cells& cells, std::vector<bool>& used) {
        const auto& strays = file_.left_out;
        for (std::size_t n = 0; n < cells.size() && fault_.empty(); ++n) {
            for (const std::size_t vertex : cells[n]) {
                used[vertex] = true;
                const auto found = std::lower_bound(strays.begin(), strays.end(), vertex);
                if (found == strays.end() || *found != vertex) continue;
                line_ = lines_left_out_[std::size_t(found - strays.begin())];
                return refuse(detail::vertex_not_finite);
            }
        }
    }

    const std::string& text_;
    detail::ObjScanner scanner_;
    MeshFile& file_;
    StrayVertices strays_;
    std::vector<std::size_t> lines_left_out_; // as MeshFile::left_out
    std::vector<std::string_view> words_;     // of the current line
    std::size_t at_ = 0, line_ = 1;
    std::string fault_;
    detail::Triangles triangles_;
    std::vector<std::array<std::uint32_t, 4>> quads_;
    std::vector<std::pair<std::size_t, std::size_t>>
        largest_; // largest index of each section, from 0, and its line
};

} // namespace

Expected<MeshFile> parse_medit(std::string text, std::string name, StrayVertices strays) {
    MeshFile file;
    file.name = std::move(name);
    if (text.empty()) return FileError{file.name + ": is empty"};
    const FileError fault = MeditReader(text, file, strays).read();
    if (!fault.message.empty()) return FileError{file.name + ": " + fault.message, fault.line};
    file.text = std::move(text);
    return file;
}

detail::Triangles surface_of(std::span<const Point3> vertices,
                             std::span<const std::array<std::uint32_t, 4>> tetrahedra) {
    struct Side {
        std::array<std::uint32_t, 3> key, corners;
    };
    std::vector<Side> sides;
    sides.reserve(4 * tetrahedra.size());
    for (const auto& [a, b, c, d] : tetrahedra) {
        const Point3& tip = vertices[a];
        const bool turned = dot(vertices[b] - tip, cross(vertices[c] - tip, vertices[d] - tip)) < 0;
        for (auto [p, q, r] :
             {std::array{a, c, b}, std::array{a, b, d}, std::array{b, c, d}, std::array{a, d, c}}) {
            if (turned) std::swap(q, r);
            Side side{{p, q, r}, {p, q, r}};
            std::sort(side.key.begin(), side.key.end());
            sides.push_back(side);
        }
    }
    std::sort(sides.begin(), sides.end(), [](const Side& s, const Side& t) { return s.key < t.key; });
    detail::Triangles surface;
    for (std::size_t i = 0, next = 0; i < sides.size(); i = next) {
        next = i + 1;
        while (next < sides.size() && sides[next].key == sides[i].key) ++next;
        if (next == i + 1) surface.push_back(sides[i].corners);
    }
    return surface;
}

std::string medit_text(std::span<const Point3> vertices,
                       std::span<const std::array<std::uint32_t, 4>> tetrahedra) {
    std::string text =
        "MeshVersionFormatted 2\nDimension 3\nVertices\n" + std::to_string(vertices.size()) + '\n';
    for (const Point3& p : vertices) {
        for (const double x : p.v) {
            detail::append_digits(text, x);
            text += ' ';
        }
        text += "0\n";
    }
    text += "Tetrahedra\n" + std::to_string(tetrahedra.size()) + '\n';
    for (const auto& cell : tetrahedra) {
        for (const std::uint32_t vertex : cell) text += std::to_string(vertex + 1) + ' ';
        text += "0\n";
    }
    return text + "End\n";
}

} // namespace cageform_support

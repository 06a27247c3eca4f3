#include "files/stl_file.hpp"

#include "files/ply_file.hpp"
#include "io/csv.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

namespace cageform_support {

namespace {

constexpr std::size_t stl_title = 80, stl_head = 84, stl_triangle = 50; // bytes
constexpr std::string_view stl_blanks = " \t\r\n\f\v";

/// The number of triangles that a binary file declares.
std::uint64_t declared_triangles(std::string_view bytes) {
    return std::uint64_t(number_at(bytes, stl_title, PlyType::uint32, PlyEncoding::little_endian));
}

/// The position after the triangles that a binary file declares.
std::uint64_t end_of_triangles(std::string_view bytes) {
    return stl_head + declared_triangles(bytes) * stl_triangle;
}

struct StlFacet {
    std::array<PlacedNumber, 3> normal;
    std::array<std::array<PlacedNumber, 3>, 3> corners;
    std::size_t line = 0; // of ASCII

    Point3 place(std::size_t corner) const {
        const auto& [x, y, z] = corners[corner];
        return {x.value, y.value, z.value};
    }
};

/// Sequential reader of the facets of an STL file in memory.
class StlReader {
public:
    /// The bytes must outlive this object.
    StlReader(std::string_view bytes, std::string name)
        : bytes_(bytes)
        , name_(std::move(name))
        , is_binary_(is_binary_stl(bytes)) {
        if (is_binary_) {
            at_ = stl_head;
            bytes_ = bytes.substr(0, std::size_t(end_of_triangles(bytes)));
            return;
        }
        if (bytes.starts_with("\xef\xbb\xbf")) at_ = 3; // a byte order mark
        const bool is_solid = is_word(next_word(), "solid");
        // In binary files of up to 2 GB, the last byte of the triangle count is at most 2: a control
        // character.
        if (is_solid && !has_control_characters(bytes.substr(0, stl_head))) {
            skip_line();
            return;
        }
        refuse_binary(is_solid);
    }

    /// The next facet; false at the end and after an error.
    bool next(StlFacet& facet) {
        if (error_) return false;
        if (is_binary_) return next_binary(facet);
        for (;;) {
            const std::string_view word = next_word();
            if (is_word(word, "facet")) return read_facet(facet);
            if (!is_word(word, "solid") && !is_word(word, "endsolid"))
                return at_ < bytes_.size() || !word.empty()
                           ? refuse("\"facet\" is expected, not " + shown(word))
                           : false;
            skip_line();
        }
    }

    const std::optional<FileError>& error() const { return error_; }
    PlyEncoding encoding() const { return is_binary_ ? PlyEncoding::little_endian : PlyEncoding::ascii; }

private:
    void refuse_binary(bool is_solid) {
        const std::string size = std::to_string(bytes_.size());
        std::string why = "is no STL file: it does not begin with \"solid\", and is too short to be binary";
        if (bytes_.size() < stl_head) {
            if (is_solid)
                why = "is cut off: it has " + size + " bytes, but the head of a binary STL file has 84";
        } else if (const auto triangles = declared_triangles(bytes_); triangles == 0) {
            why = "holds no triangles: its head declares 0, and it has " + size + " bytes";
        } else {
            why = "is no STL file, or cut off: its head declares " + std::to_string(triangles) +
                  " triangles, which need " + std::to_string(end_of_triangles(bytes_)) +
                  " bytes, but it has " + size;
        }
        (void)refuse(why);
        error_->line = 0;
    }

    bool refuse(const std::string& why) {
        error_ = FileError{name_ + ": " + why, line_};
        return false;
    }

    static std::string shown(std::string_view word) {
        return word.empty() ? "the end of the file" : detail::quoted(word);
    }

    /// Keywords may have capitals.
    static bool is_word(std::string_view word, std::string_view lowercase) {
        return std::equal(word.begin(), word.end(), lowercase.begin(), lowercase.end(), [](char a, char b) {
            return (a >= 'A' && a <= 'Z' ? char(a - 'A' + 'a') : a) == b;
        });
    }

    /// The next word; empty at the end.
    std::string_view next_word() {
        const std::size_t begin = std::min(bytes_.find_first_not_of(stl_blanks, at_), bytes_.size());
        line_ += std::size_t(
            std::count(bytes_.begin() + std::ptrdiff_t(at_), bytes_.begin() + std::ptrdiff_t(begin), '\n'));
        at_ = std::min(bytes_.find_first_of(stl_blanks, begin), bytes_.size());
        return bytes_.substr(begin, at_ - begin);
    }

    void skip_line() { at_ = std::min(bytes_.find('\n', at_), bytes_.size()); }

    bool expect(std::string_view lowercase) {
        const std::string_view word = next_word();
        return is_word(word, lowercase) ||
               refuse(detail::quoted(lowercase) + " is expected, not " + shown(word));
    }

    bool read_numbers(std::array<PlacedNumber, 3>& numbers, bool finite) {
        for (PlacedNumber& number : numbers) {
            const std::string_view word = next_word();
            if (word.empty()) return refuse("a number is expected, not " + shown(word));
            number.end = at_;
            number.begin = at_ - word.size();
            const std::string why =
                finite ? detail::parse_finite(word, number.value) : detail::parse_number(word, number.value);
            if (!why.empty()) return refuse(why);
        }
        return true;
    }

    /// Reads a facet after its first word.
    bool read_facet(StlFacet& facet) {
        facet.line = line_;
        if (!expect("normal") || !read_numbers(facet.normal, false) || !expect("outer") || !expect("loop"))
            return false;
        for (auto& corner : facet.corners) {
            if (!expect("vertex") || !read_numbers(corner, true)) return false;
        }
        return expect("endloop") && expect("endfacet");
    }

    bool next_binary(StlFacet& facet) {
        if (at_ == bytes_.size()) return false;
        const auto read = [&](PlacedNumber& number) {
            number = {number_at(bytes_, at_, PlyType::float32, encoding()), at_, at_ + 4};
            at_ += 4;
            return std::isfinite(number.value);
        };
        for (PlacedNumber& number : facet.normal) (void)read(number);
        for (auto& corner : facet.corners) {
            for (PlacedNumber& number : corner) {
                if (!read(number)) {
                    (void)refuse("triangle " + std::to_string((at_ - stl_head) / stl_triangle) +
                                 ": a coordinate is not finite");
                    error_->line = 0;
                    return false;
                }
            }
        }
        at_ += 2; // attributes
        return true;
    }

    std::string_view bytes_;
    std::string name_;
    bool is_binary_;
    std::size_t at_ = 0, line_ = 1;
    std::optional<FileError> error_;
};

/// The contents of an STL file.
class StlDocument : public MeshDocument {
public:
    explicit StlDocument(std::string bytes)
        : bytes_(std::move(bytes)) {}

    std::vector<std::string> extensions() const override { return {".stl"}; }
    Expected<MovedFile> moved(const MeshFile& mesh, const MovedVertices& moved,
                              const std::filesystem::path& path) const override;
    std::shared_ptr<const MeshDocument> with_faces_reversed() const override;
    std::string others() const override;

    const std::string& bytes() const { return bytes_; }

private:
    std::string bytes_;
};

/// The unit normal of a moved face; nothing if it has no area, has not moved, or its normal is zero in the
/// file.
std::optional<Point3> normal_of(const StlFacet& facet, const MeshFace& face, const MeshFile& mesh,
                                std::span<const Point3> places) {
    const auto& [x, y, z] = facet.normal;
    if (x.value == 0 && y.value == 0 && z.value == 0) return std::nullopt;
    const auto is_still = [&](const MeshCorner& corner) {
        return places[corner.vertex] == mesh.vertices[corner.vertex];
    };
    if (std::all_of(face.corners.begin(), face.corners.end(), is_still)) return std::nullopt;
    const Point3 area = detail::area_vector(face, places);
    const double length = std::hypot(area[0], area[1], area[2]);
    if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
    return (1 / length) * area;
}

Expected<MovedFile> StlDocument::moved(const MeshFile& mesh, const MovedVertices& moved,
                                       const std::filesystem::path& path) const {
    StlReader reader(bytes_, mesh.name);
    // ASCII files have no declared precision: double only where single precision is too coarse.
    const bool is_single =
        reader.encoding() != PlyEncoding::ascii || rounding_fault(mesh.name, moved.places).empty();
    ReplacedNumbers result(bytes_, reader.encoding());
    StlFacet facet;
    for (std::size_t f = 0; reader.next(facet); ++f) {
        const MeshFace& face = mesh.faces[f];
        std::string why;
        const auto replace = [&](const std::array<PlacedNumber, 3>& numbers, const Point3& now) {
            for (std::size_t k = 0; k < 3 && why.empty(); ++k)
                why = result.replace(numbers[k], is_single ? PlyType::float32 : PlyType::float64, now[k]);
        };
        if (const auto normal = normal_of(facet, face, mesh, moved.places)) replace(facet.normal, *normal);
        for (std::size_t n = 0; n < 3; ++n) replace(facet.corners[n], moved.places[face.corners[n].vertex]);
        if (!why.empty())
            return FileError{mesh.name + ": triangle " + std::to_string(f) + ": a coordinate " + why};
    }
    return MovedFile{{{path, std::move(result).finish()}}, {}};
}

std::shared_ptr<const MeshDocument> StlDocument::with_faces_reversed() const {
    StlReader reader(bytes_, {});
    ReplacedNumbers result(bytes_, reader.encoding());
    StlFacet facet;
    while (reader.next(facet)) {
        for (const PlacedNumber& number : facet.normal)
            (void)result.replace(number, PlyType::float32, -number.value);
        for (const std::size_t n : {1U, 2U}) {
            for (std::size_t k = 0; k < 3; ++k) result.replace(facet.corners[n][k], facet.corners[3 - n][k]);
        }
    }
    return std::make_shared<StlDocument>(std::move(result).finish());
}

std::string StlDocument::others() const {
    std::size_t attributes = 0;
    for (std::size_t at = stl_head; is_binary_stl(bytes_) && at < end_of_triangles(bytes_);
         at += stl_triangle)
        attributes +=
            number_at(bytes_, at + stl_triangle - 2, PlyType::uint16, PlyEncoding::little_endian) != 0 ? 1
                                                                                                       : 0;
    return attributes == 0 ? std::string() : std::to_string(attributes) + " attributes of triangles";
}

/// Finds vertices by their coordinates.
struct PlaceHash {
    std::size_t operator()(const Point3& p) const {
        std::size_t hash = 0;
        for (const double x : p.v)
            hash = (hash ^ std::hash<double>()(x)) * 0x9e3779b97f4a7c15ULL + (hash >> 29);
        return hash;
    }
};

} // namespace

bool has_control_characters(std::string_view bytes) {
    return std::any_of(bytes.begin(), bytes.end(), [](char c) {
        return c >= 0 && c < ' ' && stl_blanks.find(c) == std::string_view::npos;
    });
}

bool is_binary_stl(std::string_view bytes) {
    return bytes.size() > stl_head && declared_triangles(bytes) > 0 &&
           bytes.size() >= end_of_triangles(bytes);
}

Expected<MeshFile> parse_stl(std::string bytes, std::string name) {
    MeshFile file;
    file.name = std::move(name);
    if (bytes.empty()) return FileError{file.name + ": is empty"};
    auto document = std::make_shared<StlDocument>(std::move(bytes));
    StlReader reader(document->bytes(), file.name);
    std::unordered_map<Point3, std::uint32_t, PlaceHash> known;
    const std::string_view all = document->bytes();
    const std::size_t expected = is_binary_stl(all) ? std::size_t(declared_triangles(all)) : all.size() / 200;
    file.faces.reserve(expected);
    known.reserve(expected / 2); // a closed mesh has half as many vertices as triangles
    for (StlFacet facet; reader.next(facet);) {
        MeshFace& face = file.faces.emplace_back();
        face.line = facet.line;
        face.corners.reserve(3);
        for (std::size_t n = 0; n < 3; ++n) {
            const Point3 place = facet.place(n);
            const auto [vertex, is_new] = known.insert({place, std::uint32_t(file.vertices.size())});
            if (is_new) file.vertices.push_back(place);
            face.corners.push_back({vertex->second, MeshCorner::none});
        }
    }
    if (reader.error()) return *reader.error();
    if (file.faces.empty()) return FileError{file.name + ": holds no triangles"};
    if (const std::string why = detail::triangulate(file); !why.empty())
        return FileError{file.name + ": " + why};
    file.document = std::move(document);
    return file;
}

} // namespace cageform_support

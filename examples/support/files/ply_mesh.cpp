#include "files/ply_mesh.hpp"

#include "files/moved_normals.hpp"
#include "files/ply_file.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

namespace cageform_support {

namespace {

using Names = std::vector<std::string>;

const Names place_names{"x", "y", "z"}, normal_names{"nx", "ny", "nz"}, colour_names{"red", "green", "blue"};

/// Whether an element has all of these properties, as single numbers.
bool has_numbers(const PlyElement& element, const Names& names) {
    return std::all_of(names.begin(), names.end(), [&](const std::string& name) {
        const auto found = element.find(name);
        return found && !element.properties[*found].count;
    });
}

/// The list of vertices of a face or strip; null if there is none.
const PlyProperty* vertex_list(const PlyElement& element) {
    for (const char* name : {"vertex_indices", "vertex_index"}) {
        const auto found = element.find(name);
        if (found && element.properties[*found].count) return &element.properties[*found];
    }
    return nullptr;
}

bool holds_faces(const PlyElement& element) {
    return element.name == "face" || element.name == "tristrips";
}

std::string joined(const Names& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
}

/// The contents of a PLY file.
class PlyDocument : public MeshDocument {
public:
    explicit PlyDocument(std::string bytes)
        : bytes_(std::move(bytes)) {}

    std::vector<std::string> extensions() const override { return {".ply"}; }
    Expected<MovedFile> moved(const MeshFile& mesh, const MovedVertices& moved,
                              const std::filesystem::path& path) const override;
    std::shared_ptr<const MeshDocument> with_faces_reversed() const override;
    std::string others() const override;

    const std::string& bytes() const { return bytes_; }

private:
    std::string bytes_;
};

Expected<MovedFile> PlyDocument::moved(const MeshFile& mesh, const MovedVertices& moved,
                                       const std::filesystem::path& path) const {
    PlyReader reader(bytes_, mesh.name);
    const PlyElement& element = *reader.header().find("vertex");
    Names names = place_names;
    if (!mesh.normals.empty()) names.insert(names.end(), normal_names.begin(), normal_names.end());
    struct Moving {
        std::size_t property = 0, axis = 0; // of a record; from 3: of the normal
    };
    std::vector<Moving> moving; // in the order of the file
    for (std::size_t k = 0; k < names.size(); ++k) moving.push_back({*element.find(names[k]), k});
    std::sort(moving.begin(), moving.end(),
              [](const Moving& a, const Moving& b) { return a.property < b.property; });
    const MovedNormals normals(mesh, moved);
    ReplacedNumbers result(bytes_, *reader.header().encoding);
    (void)reader.begin("vertex", names);
    std::vector<PlacedNumber> numbers;
    for (std::uint32_t i = 0; reader.read(1, numbers) > 0; ++i, numbers.clear()) {
        if (std::binary_search(mesh.left_out.begin(), mesh.left_out.end(), i)) continue;
        const Point3 normal = mesh.normals.empty() ? Point3{} : normals.of_corner(i, i);
        for (const auto& [property, k] : moving) {
            const double now = k < 3 ? moved.places[i][k] : normal[k - 3];
            if (!std::isfinite(now)) continue;
            const PlyProperty& of = element.properties[property];
            if (const std::string why = result.replace(numbers[k], of.type, now); !why.empty())
                return FileError{mesh.name + ": vertex " + std::to_string(i) + ": " + of.name + ' ' + why};
        }
    }
    return MovedFile{{{path, std::move(result).finish()}}, {}};
}

std::shared_ptr<const MeshDocument> PlyDocument::with_faces_reversed() const {
    PlyReader reader(bytes_, {});
    const PlyElement* const faces = reader.header().find("face");
    if (reader.header().find("tristrips") != nullptr) return nullptr;
    if (faces == nullptr || faces->count == 0) return std::make_shared<PlyDocument>(bytes_);
    // Other lists may have numbers for each corner.
    const auto lists = std::count_if(faces->properties.begin(), faces->properties.end(),
                                     [](const PlyProperty& property) { return property.count.has_value(); });
    if (lists > 1) return nullptr;
    ReplacedNumbers result(bytes_, *reader.header().encoding);
    (void)reader.begin("face", {vertex_list(*faces)->name});
    std::vector<PlacedNumber> numbers; // the length, then the corners
    for (; reader.read(1, numbers) > 0; numbers.clear()) {
        for (std::size_t n = 2; n < numbers.size(); ++n) // the first corner stays the first
            result.replace(numbers[n], numbers[numbers.size() + 1 - n]);
    }
    return std::make_shared<PlyDocument>(std::move(result).finish());
}

std::string PlyDocument::others() const {
    const PlyReader reader(bytes_, {});
    std::string text;
    const auto add = [&](const std::string& one) { text += (text.empty() ? "" : ", ") + one; };
    for (const PlyElement& element : reader.header().elements) {
        if (element.name != "vertex" && !holds_faces(element)) {
            add(std::to_string(element.count) + " of " + detail::quoted(element.name));
            continue;
        }
        const bool of_vertices = element.name == "vertex";
        for (const PlyProperty& property : element.properties) {
            const auto is_in = [&](const Names& names) {
                return std::find(names.begin(), names.end(), property.name) != names.end();
            };
            const bool is_known = of_vertices
                                      ? is_in(place_names) || is_in(normal_names) || is_in(colour_names)
                                      : &property == vertex_list(element);
            if (!is_known) add(detail::quoted(property.name) + " of each " + detail::quoted(element.name));
        }
    }
    return text;
}

/// Parses the elements of a PLY file in their order.
class PlyMeshReader {
public:
    PlyMeshReader(MeshFile& file, std::string_view bytes, StrayVertices strays)
        : file_(file)
        , bytes_(bytes)
        , strays_(strays)
        , reader_(bytes, file.name) {}

    /// Returns the error, if any.
    std::optional<FileError> read() {
        if (std::string why = fault_of_header(); !why.empty()) return FileError{std::move(why)};
        for (const PlyElement& element : reader_.header().elements) {
            const bool is_read = element.name == "vertex" ? read_vertices(element)
                                 : holds_faces(element)   ? read_faces(element)
                                                          : true;
            if (!is_read) return FileError{reader_.error().empty() ? fault_ : reader_.error()};
        }
        std::vector<bool> used(file_.vertices.size());
        if (const std::string why = check_faces(used); !why.empty()) return fault(why);
        std::string why = detail::place_left_out(file_, used, strays_);
        if (why.empty()) why = detail::triangulate(file_);
        if (!why.empty()) return fault(why);
        return std::nullopt;
    }

private:
    FileError fault(const std::string& why) const { return {file_.name + ": " + why}; }
    bool refuse(const std::string& why) {
        fault_ = file_.name + ": " + why;
        return false;
    }

    std::string fault_of_header() const {
        if (!reader_.error().empty()) return reader_.error();
        const PlyElement* const vertices = reader_.header().find("vertex");
        if (vertices == nullptr || vertices->count == 0) return file_.name + ": holds no vertices";
        if (!has_numbers(*vertices, place_names))
            return file_.name + ": its element vertex has no numbers " + joined(place_names);
        return {};
    }

    /// The number of records for which to reserve memory: at most as many as the file has bytes for.
    std::size_t expected(const PlyElement& element) const {
        const std::size_t least = 2 * element.properties.size(); // of ASCII: a digit and a blank
        const bool is_text = reader_.header().encoding == PlyEncoding::ascii;
        const std::size_t each = is_text ? least : element.record_bytes().value_or(1);
        return std::size_t(
            std::min<std::uint64_t>(element.count, bytes_.size() / std::max<std::size_t>(each, 1)));
    }

    bool read_vertices(const PlyElement& element) {
        Names names = place_names;
        const bool has_normals = has_numbers(element, normal_names);
        const bool has_colours = has_numbers(element, colour_names);
        if (has_normals) names.insert(names.end(), normal_names.begin(), normal_names.end());
        const std::size_t first_colour = names.size();
        if (has_colours) names.insert(names.end(), colour_names.begin(), colour_names.end());
        std::array<double, 3> scale{1, 1, 1};
        for (std::size_t k = 0; has_colours && k < 3; ++k) {
            const PlyType type = element.properties[*element.find(colour_names[k])].type;
            if (type < PlyType::float32) scale[k] = 1 / (std::ldexp(1.0, int(8 * bytes_of(type))) - 1);
        }
        if (!reader_.begin("vertex", names)) return false;
        file_.vertices.reserve(expected(element));
        if (has_normals) file_.normals.reserve(expected(element));
        if (has_colours) file_.colours.reserve(expected(element));
        std::vector<double> numbers;
        for (; reader_.read(1, numbers) > 0; numbers.clear()) {
            const Point3 place{numbers[0], numbers[1], numbers[2]};
            const std::size_t i = file_.vertices.size();
            if (!cageform::is_finite(place)) {
                if (strays_ == StrayVertices::refuse)
                    return refuse("vertex " + std::to_string(i) + ": " + detail::vertex_not_finite);
                file_.left_out.push_back(i);
            }
            file_.vertices.push_back(place);
            if (has_normals) file_.normals.push_back({numbers[3], numbers[4], numbers[5]});
            if (!has_colours) continue;
            Point3& colour = file_.colours.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) colour[k] = scale[k] * numbers[first_colour + k];
        }
        return reader_.error().empty();
    }

    bool read_faces(const PlyElement& element) {
        if (element.count == 0) return true;
        const PlyProperty* const list = vertex_list(element);
        if (list == nullptr) return refuse("its element " + element.name + " has no list vertex_indices");
        if (!reader_.begin(element.name, {list->name})) return false;
        if (element.name == "face") file_.faces.reserve(expected(element));
        std::vector<double> numbers; // the length, then the corners
        for (std::uint64_t record = 0; reader_.read(1, numbers) > 0; ++record, numbers.clear()) {
            const auto refuse_record = [&](const std::string& why) {
                return refuse(element.name + ' ' + std::to_string(record) + ": " + why);
            };
            std::vector<std::uint32_t> corners;
            for (const double number : std::span(numbers).subspan(1)) {
                const bool ends_strip = element.name != "face" && number == -1;
                if (!ends_strip &&
                    !(number >= 0 && number < MeshCorner::none && number == std::floor(number)))
                    return refuse_record(detail::digits_of(number) + " is no index of a vertex");
                corners.push_back(ends_strip ? MeshCorner::none : std::uint32_t(number));
            }
            if (element.name != "face")
                add_strips(corners);
            else if (corners.size() < 3)
                return refuse_record("it has fewer than three corners");
            else
                add_face(corners);
        }
        return reader_.error().empty();
    }

    void add_face(std::span<const std::uint32_t> vertices) {
        MeshFace& face = file_.faces.emplace_back();
        face.corners.reserve(vertices.size());
        for (const std::uint32_t vertex : vertices) face.corners.push_back({vertex, MeshCorner::none});
    }

    /// Triangle strips, each ended by MeshCorner::none. Every second triangle is reversed; those with two
    /// equal corners only join strips.
    void add_strips(std::span<const std::uint32_t> vertices) {
        std::size_t first = 0; // of the strip
        for (std::size_t n = 0; n < vertices.size(); ++n) {
            const std::uint32_t c = vertices[n];
            if (c == MeshCorner::none) first = n + 1;
            if (n < first + 2) continue;
            const std::uint32_t a = vertices[n - 2], b = vertices[n - 1];
            if (a == b || b == c || c == a) continue;
            const bool is_reversed = (n - first) % 2 == 1;
            add_face(std::array{is_reversed ? b : a, is_reversed ? a : b, c});
        }
    }

    /// Checks indices, sets the normals of corners and the vertices that faces use. Returns the error;
    /// empty on success.
    std::string check_faces(std::vector<bool>& used) {
        const std::size_t count = file_.vertices.size();
        for (std::size_t f = 0; f < file_.faces.size(); ++f) {
            for (MeshCorner& corner : file_.faces[f].corners) {
                if (corner.vertex >= count)
                    return "face " + std::to_string(f) + ": vertex index " + std::to_string(corner.vertex) +
                           " is out of range: the file has " + std::to_string(count);
                if (std::binary_search(file_.left_out.begin(), file_.left_out.end(), corner.vertex))
                    return "vertex " + std::to_string(corner.vertex) + ": " + detail::vertex_not_finite;
                if (!file_.normals.empty()) corner.normal = corner.vertex;
                used[corner.vertex] = true;
            }
        }
        return {};
    }

    MeshFile& file_;
    std::string_view bytes_;
    StrayVertices strays_;
    PlyReader reader_;
    std::string fault_;
};

} // namespace

Expected<MeshFile> parse_ply(std::string bytes, std::string name, StrayVertices strays) {
    MeshFile file;
    file.name = std::move(name);
    if (bytes.empty()) return FileError{file.name + ": is empty"};
    auto document = std::make_shared<PlyDocument>(std::move(bytes));
    if (auto error = PlyMeshReader(file, document->bytes(), strays).read()) return std::move(*error);
    file.document = std::move(document);
    return file;
}

} // namespace cageform_support

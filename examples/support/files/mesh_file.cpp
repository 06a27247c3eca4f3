#include "files/mesh_file.hpp"

#include "files/gltf_scene.hpp"
#include "files/medit_file.hpp"
#include "files/obj_file.hpp"
#include "files/ply_mesh.hpp"
#include "files/site_file.hpp"
#include "files/stl_file.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

namespace cageform_support {

namespace detail {

std::string_view other_format(std::string_view text) {
    if (is_binary_stl(text)) return "STL";
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3); // a byte order mark
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
    const std::string_view begin = text.substr(0, 512);
    const auto begins_with_word = [&](std::string_view word) {
        return begin.starts_with(word) && begin.size() > word.size() &&
               std::strchr(" \t\r\n", begin[word.size()]) != nullptr;
    };
    if (begins_with_word("solid") || begins_with_word("SOLID")) return "STL";
    if (begin.starts_with("glTF") || (begin.starts_with('{') && text.find("\"asset\"") != text.npos))
        return "glTF";
    if ((begin.starts_with('{') || begin.starts_with('[')) && !has_control_characters(begin)) return "JSON";
    if (begins_with_word("ply")) return "PLY";
    for (const std::string_view first : {"<svg", "<?xml", "<!--", "<!DOCTYPE svg"}) {
        if (begin.starts_with(first) && text.find("<svg") != text.npos) return "SVG";
    }
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

Point3 area_vector(const MeshFace& face, std::span<const Point3> vertices) {
    Point3 sum{};
    const Point3& tip = vertices[face.corners.front().vertex];
    for (std::size_t k = 1; k + 1 < face.corners.size(); ++k) {
        sum = sum + cross(vertices[face.corners[k].vertex] - tip, vertices[face.corners[k + 1].vertex] - tip);
    }
    return sum;
}

std::string place_left_out(MeshFile& file, const std::vector<bool>& used, StrayVertices strays) {
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
bool lies_flat(const Triangles& triangles, const MeshFace& face, std::span<const Point3> vertices) {
    if (triangles.size() + 2 != face.corners.size()) return false;
    const Point3 normal = area_vector(face, vertices);
    for (const auto& [a, b, c] : triangles) {
        const Point3 own = cross(vertices[b] - vertices[a], vertices[c] - vertices[a]);
        if (dot(normal, own) < 0 || (normal == Point3{} && own != Point3{})) return false;
    }
    return true;
}

/// Triangulates faces of four or more corners by tinyobjloader. Its ear clipping is wrong for some faces of
/// five or more corners that are not convex; the first valid fan is used instead.
std::string triangulate(MeshFile& file) {
    std::string plain;
    const bool has_polygons = std::any_of(file.faces.begin(), file.faces.end(),
                                          [](const MeshFace& face) { return face.corners.size() > 3; });
    for (std::size_t i = 0; has_polygons && i < file.vertices.size(); ++i) {
        plain += 'v';
        for (std::size_t k = 0; k < 3; ++k) append_digits(plain += ' ', file.vertices[i][k]);
        plain += '\n';
    }
    for (std::size_t f = 0; f < file.faces.size(); ++f) { // smoothing groups identify the faces
        if (file.faces[f].corners.size() == 3) continue;
        plain += "s " + std::to_string(f + 1) + "\nf";
        for (const MeshCorner& corner : file.faces[f].corners)
            plain += ' ' + std::to_string(corner.vertex + 1);
        plain += '\n';
    }
    tinyobj::ObjReader reader;
    tinyobj::ObjReaderConfig config;
    config.triangulate = true;
    config.vertex_color = false;
    if (has_polygons && !reader.ParseFromString(plain, "", config)) return reader.Error();
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
        const std::size_t n = corners.size();
        if (n == 3) of_face[f] = {{corners[0].vertex, corners[1].vertex, corners[2].vertex}};
        Triangles triangles = std::move(of_face[f]);
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

/// Whether the first word of a text is that of a .mesh file.
bool is_medit(std::string_view text) {
    std::vector<std::string_view> words;
    std::size_t line = 0;
    return ObjScanner(text).next(words, line) && words[0] == medit_keyword;
}

/// Whether a file is text with `v` statements.
bool has_obj_vertices(std::string_view text) {
    if (has_control_characters(text.substr(0, 512))) return false;
    std::vector<std::string_view> words;
    std::size_t line = 0;
    for (ObjScanner scanner(text); scanner.next(words, line);) {
        if (words[0] == "v") return true;
    }
    return false;
}

} // namespace detail

Expected<MeshFile> load_mesh(const std::filesystem::path& path, StrayVertices strays) {
    const std::string name = path.string();
    auto bytes = read_file(name, largest_mesh_file);
    if (!bytes) return bytes.error();
    if (bytes->empty()) return FileError{name + ": is empty"};
    std::string_view format = detail::other_format(*bytes);
    if (format == "UTF-16") {
        if (const auto text = read_text(name); !text) return text.error();
    }
    if (format.empty() && detail::is_medit(*bytes)) format = "Medit";
    if (format.empty() && !detail::has_obj_vertices(*bytes)) { // the parser of the extension says why
        const std::string extension = lowercase_extension(path);
        if (extension == ".ply") format = "PLY";
        if (extension == ".stl") format = "STL";
        if (extension == ".mesh") format = "Medit";
    }
    if (format == "glTF" || format == "JSON") return parse_gltf(std::move(*bytes), name);
    if (format == "PLY") return parse_ply(std::move(*bytes), name, strays);
    if (format == "STL") return parse_stl(std::move(*bytes), name);
    if (format == "Medit") return parse_medit(std::move(*bytes), name, strays);
    return parse_obj(std::move(*bytes), name, strays);
}

Expected<SiteFile<3>> detail::read_site_vertices(const std::string& path) {
    auto file = load_mesh(path);
    if (!file) return file.error();
    SiteFile<3> sites{path, std::move(file->vertices), {}};
    for (std::size_t i = 0; i < sites.points.size(); ++i)
        sites.places.push_back("v " + std::to_string(i + 1));
    return sites;
}

std::vector<std::string> extensions_of(const MeshFile& mesh) {
    if (mesh.document != nullptr) return mesh.document->extensions();
    return {detail::is_medit(mesh.text) ? ".mesh" : ".obj"};
}

std::string fault_of_extension(const MeshFile& mesh, const std::string& out, const std::string& option) {
    const auto own = extensions_of(mesh);
    if (std::find(own.begin(), own.end(), lowercase_extension(out)) != own.end()) return {};
    return option + ' ' + out + ": the figure " + mesh.name + " is written as " + own[0] +
           (own.size() > 1 ? " or " + own[1] : "") + ", since the output has the format of the figure";
}

std::string fault_of_reversing(const MeshFile& mesh) {
    const bool is_supported = mesh.document == nullptr ? !detail::is_medit(mesh.text)
                                                       : mesh.document->with_faces_reversed() != nullptr;
    return is_supported ? "" : "--flip-faces: " + mesh.name + ": the format is not supported";
}

std::string fault_of_frame(const MeshFile& figure, const MeshFile& frame) {
    constexpr const char* rule = ": a frame is the figure with its vertices moved";
    if (frame.vertices.size() != figure.vertices.size()) {
        return frame.name + " has " + std::to_string(frame.vertices.size()) + " vertices, " + figure.name +
               " has " + std::to_string(figure.vertices.size()) + rule;
    }
    const auto sorted = [](const MeshFile& mesh, std::size_t f) { // --flip-faces reverses faces
        std::vector<std::uint32_t> vertices;
        for (const MeshCorner& corner : mesh.faces[f].corners) vertices.push_back(corner.vertex);
        std::sort(vertices.begin(), vertices.end());
        return vertices;
    };
    for (std::size_t f = 0; figure.faces.size() == frame.faces.size() && f < figure.faces.size(); ++f) {
        if (sorted(figure, f) != sorted(frame, f))
            return frame.name + ": face " + std::to_string(f + 1) + " has other vertices than that of " +
                   figure.name + rule;
    }
    return {};
}

Expected<std::vector<std::string>> save_mesh(const MeshFile& mesh, const MovedVertices& moved,
                                             const std::string& out, OutputFiles& outputs) {
    if (mesh.document == nullptr) {
        outputs.add(out).write(to_text(mesh, moved));
        return std::vector<std::string>();
    }
    auto written = mesh.document->moved(mesh, moved, out);
    if (!written) return written.error();
    for (const WrittenFile& file : written->files) outputs.add(file.path).write(file.bytes);
    return std::move(written->notes);
}

std::optional<FileError> single_precision_fault(const MeshFile& file) {
    for (std::size_t i = 0; i < file.vertices.size(); ++i) {
        for (const double x : file.vertices[i].v) {
            const std::string why = detail::single_precision_fault(x);
            if (!why.empty())
                return FileError{file.name + ": v " + std::to_string(i + 1) + ": " + why,
                                 detail::line_of_vertex(file, i)};
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

double size_of(const MeshFile& figure) {
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

Point3 far_origin(const MeshFile& figure) {
    const auto shown = used_positions(figure.vertices, figure.triangles);
    const auto bounds = cageform::bounds_of(std::span<const Point3>(shown));
    constexpr double far_away = 8; // diagonals
    const Point3 middle = 0.5 * (bounds.lower + bounds.upper);
    const bool is_near = !(std::sqrt(dot(middle, middle)) > far_away * bounds.diagonal());
    return is_near ? Point3{} : rounded_to_single(middle);
}

std::vector<Point3> joined_places(const MeshFile& figure) {
    std::vector<double> edges; // limits the distance if parts differ much in size
    for (const auto& triangle : figure.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Point3 edge = figure.vertices[triangle[k]] - figure.vertices[triangle[(k + 1) % 3]];
            if (const double squared = dot(edge, edge); squared > 0) edges.push_back(squared);
        }
    }
    const auto shorter = edges.begin() + std::ptrdiff_t(edges.size() / 20);
    std::nth_element(edges.begin(), shorter, edges.end());
    const double most = edges.empty() ? HUGE_VAL : 0.01 * std::sqrt(*shorter);
    const double apart = std::min(1e-6 * size_of(figure), most);
    if (!(apart > 0) || !std::isfinite(apart)) return figure.vertices;
    std::vector<Point3> places;
    std::map<std::array<double, 3>, std::vector<Point3>> known; // by cubes of edge length 2 · apart
    const auto cube = [&](const Point3& p) {
        std::array<double, 3> lower;
        for (std::size_t k = 0; k < 3; ++k)
            lower[k] = std::floor((p[k] - figure.vertices[0][k]) / (2 * apart));
        return lower;
    };
    for (const Point3& p : figure.vertices) {
        const Point3* joined = nullptr;
        for (unsigned corner = 0; corner < 8 && joined == nullptr; ++corner) {
            const auto side = [&](unsigned k) { return (corner >> k & 1u) != 0 ? apart : -apart; };
            const auto found = known.find(cube(p + Point3{side(0), side(1), side(2)}));
            if (found == known.end()) continue;
            for (const Point3& q : found->second) {
                if (!(std::sqrt(dot(p - q, p - q)) <= apart)) continue;
                joined = &q;
                break;
            }
        }
        places.push_back(joined != nullptr ? *joined : p);
        if (joined == nullptr) known[cube(p)].push_back(p);
    }
    return places;
}

std::vector<Point3> relative_to(const Point3& origin, std::span<const Point3> places) {
    std::vector<Point3> moved(places.begin(), places.end());
    for (Point3& p : moved) p = p - origin;
    return moved;
}

std::vector<std::vector<std::uint32_t>> face_loops(const MeshFile& file) {
    std::vector<std::vector<std::uint32_t>> loops(file.faces.size());
    for (std::size_t f = 0; f < loops.size(); ++f) {
        for (const MeshCorner& corner : file.faces[f].corners) loops[f].push_back(corner.vertex);
    }
    return loops;
}

MeshFile with_faces_reversed(MeshFile file) {
    if (file.document != nullptr) file.document = file.document->with_faces_reversed();
    file.text =
        detail::with_faces_reversed(file.text); // vertex lines do not move: MeshFile::numbers stay valid
    for (MeshFace& face : file.faces) std::reverse(face.corners.begin() + 1, face.corners.end());
    for (auto& triangle : file.triangles) std::swap(triangle[1], triangle[2]);
    return file;
}

} // namespace cageform_support

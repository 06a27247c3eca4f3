#include "cli/auto_cage_model.hpp"
#include "io/messages.hpp"

#include "cli/mesh_cage.hpp"
#include "files/medit_file.hpp"

#include <cageform/enclose/find_parts.hpp>
#include <cageform/enclose/make_cage_3d.hpp>
#include <cageform/parallel/threads.hpp>

namespace cageform_support {

namespace {

/// The figure's vertices. Unused vertices, which must not affect its extent, are moved to a used one.
std::vector<Point3> without_strays(const MeshFile& figure) {
    if (figure.triangles.empty()) return figure.vertices;
    std::vector<Point3> places(figure.vertices.size(), figure.vertices[figure.triangles[0][0]]);
    for (const auto& triangle : figure.triangles) {
        for (const std::uint32_t v : triangle) places[v] = figure.vertices[v];
    }
    return places;
}

/// The figure's triangles; of a figure without faces, a triangle without area at each vertex.
detail::Triangles shown_triangles(const MeshFile& figure) {
    if (!figure.triangles.empty()) return figure.triangles;
    detail::Triangles points;
    for (std::uint32_t v = 0; v < figure.vertices.size(); ++v) points.push_back({v, v, v});
    return points;
}

} // namespace

AutoCage<MeshFile> make_cage_for(const MeshFile& figure, const cageform::MakeCageOptions& options,
                                 const cageform::Progress& progress) {
    const auto made = cageform::make_cage(without_strays(figure), shown_triangles(figure), options,
                                          {.parallel = cageform::ThreadedFor{}, .progress = progress});
    const auto& report = made.report;
    if (!made) {
        double farthest = 0;
        for (const auto& p : figure.vertices) farthest = farthest_coordinate(p.v, farthest);
        std::string why = figure.name + ": " + no_cage(report, options, farthest);
        if (report.status == cageform::Status::figure_not_finite)
            why += " (v " + std::to_string(report.culprit + 1) + ")";
        throw Failure(why);
    }
    std::string text;
    for (const auto& p : made.value.vertices()) {
        text += 'v';
        for (const double x : p.v) text += ' ' + detail::digits_of(rounded(x, report.clearance));
        text += '\n';
    }
    const auto parts = options.rings ? report.parts : cageform::find_parts(made.value).value;
    for (const auto& part : parts.parts) {
        text += "g " + part_group(part.number) + '\n';
        for (std::size_t f = 0; f < made.value.faces().size(); ++f) {
            if (parts.of_face[f] != part.number) continue;
            text += 'f';
            for (const auto v : made.value.faces()[f]) text += ' ' + std::to_string(v + 1);
            text += '\n';
        }
    }
    AutoCage<MeshFile> result{value_or_fail(parse_obj(std::move(text), "the cage of " + figure.name)),
                              report};
    if (options.rings) result.report.parts = cage_parts(result.cage); // in the order of the file's faces
    return result;
}

AutoCage<MeshFile> with_quads(const AutoCage<MeshFile>& made, const MeshFile& figure,
                              const cageform::MakeCageOptions& options) {
    const MeshFile& cage = made.cage;
    const cageform::Result<cageform::TriangleMesh<double>, cageform::MakeCageReport> triangles{
        {cage.vertices, cage.triangles}, made.report};
    const auto paired = cageform::pair_faces(triangles, figure.vertices, figure.triangles, options);
    if (!paired) throw Failure(figure.name + ": " + cageform::to_string(paired.report.status));
    // A quad replaces the line of its first triangle; the line of the second is removed.
    std::string text;
    std::size_t begin = 0, line = 1, triangle = 0, face = 0;
    for (; begin < cage.text.size(); ++line) {
        const std::size_t end = cage.text.find('\n', begin) + 1;
        if (triangle == cage.faces.size() || cage.faces[triangle].line != line) {
            text.append(cage.text, begin, end - begin);
        } else {
            const auto corners =
                face < paired.value.face_count() ? paired.value.face(face) : std::span<const std::uint32_t>{};
            const auto is_corner = [&](std::uint32_t v) {
                return std::find(corners.begin(), corners.end(), v) != corners.end();
            };
            const auto& three = cage.triangles[triangle++];
            if (std::all_of(three.begin(), three.end(), is_corner)) {
                text += 'f';
                for (const auto v : corners) text += ' ' + std::to_string(v + 1);
                text += '\n';
                ++face;
            }
        }
        begin = end;
    }
    return {value_or_fail(parse_obj(std::move(text), cage.name)), paired.report};
}

MeshFile make_lattice_for(const MeshFile& figure, const LatticeWord& word, double margin) {
    auto lattice = value_or_fail(lattice_about<3>(word, without_strays(figure), margin, figure.name));
    return lattice_mesh("the lattice about " + figure.name, std::move(lattice));
}

MeshFile load_or_make_cage(const std::string& word, const MeshFile& figure) {
    const CageChoice wanted = CageChoice::of(word);
    if (wanted.is_lattice) return lattice_by_word(word, figure);
    if (!wanted.is_auto) {
        auto cage = load_mesh_cage(word);
        return value_or_fail(cage ? std::move(cage) : with_words(cage.error(), word));
    }
    return made_by_word(wanted, figure).cage;
}

void add_flip_faces(CommandLine& line, bool& flips_faces) {
    line.add_flag("--flip-faces", flips_faces,
                  "write the corners of each face in the opposite order, for a pose that mirrors the figure");
}

void add_strict(CommandLine& line, bool& is_strict) {
    line.add_flag("--strict", is_strict,
                  "refuse a figure with a vertex that is not finite, even if no face uses the vertex");
}

MeshFile load_mesh_figure(const std::string& path, bool is_strict) {
    MeshFile file = value_or_fail(load_mesh(path, strays_of(is_strict)));
    if (!file.left_out.empty()) {
        warn(path + ": " + std::to_string(file.left_out.size()) + " of " +
             std::to_string(file.vertices.size()) + " vertices are left out, first v " +
             std::to_string(file.left_out[0] + 1) +
             ": no face uses them, and they are not finite or very far away; with --strict they are kept or "
             "refused");
    }
    return file;
}

std::string leave_out_also(MeshFile& figure, std::span<const std::size_t> vertices, const std::string& frame,
                           bool is_strict) {
    std::vector<std::size_t> added, all;
    std::set_difference(vertices.begin(), vertices.end(), figure.left_out.begin(), figure.left_out.end(),
                        std::back_inserter(added));
    if (added.empty()) return {};
    std::vector<bool> has_face(figure.vertices.size());
    for (const auto& triangle : figure.triangles) {
        for (const std::uint32_t vertex : triangle) has_face[vertex] = true;
    }
    for (const std::size_t vertex : added) {
        if (is_strict || has_face[vertex])
            return frame + "v " + std::to_string(vertex + 1) + ": a coordinate is not finite";
    }
    warn(frame + std::to_string(added.size()) + " of " + std::to_string(figure.vertices.size()) +
         " vertices are left out, here and in all other files, first v " + std::to_string(added[0] + 1) +
         ": they are not finite, and no face uses them; --strict refuses the file");
    std::set_union(figure.left_out.begin(), figure.left_out.end(), added.begin(), added.end(),
                   std::back_inserter(all));
    figure.left_out = std::move(all);
    return {};
}

} // namespace cageform_support

#include "cli/mesh_cage.hpp"

#include "files/obj_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <cageform/enclose/parts_of_faces.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

namespace cageform_support {

std::size_t cage_dimension(const std::string& path) {
    if (is_lattice_path(path)) return value_or_fail(lattice_dimension(path));
    return is_mesh_path(path) ? 3 : 2;
}

namespace {

/// The vertices of all corners of faces, in the order of the file.
std::vector<std::uint32_t> corners_of(const MeshFile& file) {
    std::vector<std::uint32_t> corners;
    for (const MeshFace& face : file.faces) {
        for (const MeshCorner& corner : face.corners) corners.push_back(corner.vertex);
    }
    return corners;
}

/// The mesh as OBJ, with one vertex at each place.
Expected<MeshFile> welded(const MeshFile& file) {
    WeldedVertices vertices;
    std::string text;
    std::map<std::array<double, 3>, std::uint32_t> known;
    for (Point3 p : joined_places(file)) {
        for (double& x : p.v) x += 0.0; // -0 is 0
        const auto [vertex, is_new] = known.insert({{p[0], p[1], p[2]}, std::uint32_t(known.size())});
        vertices.of_vertices.push_back(vertex->second);
        if (!is_new) continue;
        text += 'v';
        for (const double x : p.v) detail::append_digits(text += ' ', x);
        text += '\n';
    }
    for (const std::uint32_t vertex : corners_of(file))
        vertices.of_corners.push_back(vertices.of_vertices[vertex]);
    std::size_t begin = 0;
    for (const MeshFace& face : file.faces) {
        std::vector<std::uint32_t> loop;
        for (const std::uint32_t vertex :
             std::span(vertices.of_corners).subspan(begin, face.corners.size())) {
            if (loop.empty() || loop.back() != vertex) loop.push_back(vertex);
        }
        begin += face.corners.size();
        while (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
        if (loop.size() < 3) continue;
        text += 'f';
        for (const std::uint32_t vertex : loop) text += ' ' + std::to_string(std::uint64_t{vertex} + 1);
        text += '\n';
    }
    auto cage = parse_obj(std::move(text), file.name);
    if (cage) cage->welded = std::move(vertices);
    return cage;
}

} // namespace

Expected<MeshFile> load_mesh_cage(const std::string& path) {
    if (is_lattice_path(path)) {
        auto lattice = load_lattice<3>(path);
        if (!lattice) return lattice.error();
        return lattice_mesh(path, std::move(*lattice));
    }
    auto file = load_mesh(path);
    if (file && file->document != nullptr && !file->faces.empty()) file = welded(*file);
    if (file && file->faces.empty())
        return FileError{file->name + ": holds no faces (lines \"f a b c\"); a cage is a closed mesh"};
    if (file && !file->folded.empty()) {
        const std::size_t face = file->folded.front();
        const std::string which = file->welded ? ": a face (" + std::to_string(face + 1) + " of " +
                                                     std::to_string(file->faces.size()) + ")"
                                               : ": a face";
        return FileError{file->name + which + " cannot be cut into triangles; please split it",
                         file->welded ? 0 : file->faces[face].line};
    }
    return file;
}

Expected<MeshFile> load_mesh_pose(const std::string& path, const MeshFile& cage) {
    auto file = load_mesh(path);
    if (!file) return file;
    std::string why = pose_difference(cage, *file);
    if (why.empty()) return file;
    const auto corners = corners_of(*file);
    const auto of_cage = cage.welded ? cage.welded->of_corners : corners_of(cage);
    if ((file->document == nullptr && !cage.welded) || corners.size() != of_cage.size())
        return FileError{std::move(why)};
    MeshFile pose = cage;
    pose.name = file->name;
    constexpr std::uint32_t none = ~std::uint32_t{0};
    std::vector<std::uint32_t> source(cage.vertices.size(), none); // vertex of the pose
    const double apart = 1e-5 * size_of(*file);
    for (std::size_t n = 0; n < corners.size(); ++n) {
        std::uint32_t& from = source[of_cage[n]];
        if (from == none) from = corners[n];
        const Point3 step = file->vertices[corners[n]] - file->vertices[from];
        if (std::sqrt(dot(step, step)) > apart)
            return FileError{file->name + ": its vertices " + std::to_string(from) + " and " +
                             std::to_string(corners[n]) +
                             " (from 0) are apart, but are one vertex of the cage " + cage.name};
    }
    if (cage.welded && cage.welded->of_vertices.size() == file->vertices.size()) { // also vertices of no face
        for (std::uint32_t i = 0; i < file->vertices.size(); ++i) {
            std::uint32_t& from = source[cage.welded->of_vertices[i]];
            if (from == none) from = i;
        }
    }
    for (std::size_t i = 0; i < source.size(); ++i) {
        if (source[i] != none) pose.vertices[i] = file->vertices[source[i]];
    }
    return pose;
}

MeshFile lattice_mesh(std::string name, LatticeBox<3> lattice) {
    const auto coordinates = lattice.coordinates<double>();
    std::string text;
    for (const auto& p : coordinates.handles()) {
        text += 'v';
        for (const double x : p.v) detail::append_digits(text += ' ', x);
        text += '\n';
    }
    const std::array counts{coordinates.points(0), coordinates.points(1), coordinates.points(2)};
    const auto number = [&](const std::array<std::size_t, 3>& at) {
        return ' ' + std::to_string(at[0] + counts[0] * (at[1] + counts[1] * at[2]) + 1);
    };
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
        std::array<std::size_t, 3> at{};
        for (at[a] = 0; at[a] + 1 < counts[a]; ++at[a]) {
            for (at[b] = 0; at[b] + 1 < counts[b]; ++at[b]) {
                for (const bool is_far : {false, true}) {
                    at[k] = is_far ? counts[k] - 1 : 0;
                    auto right = at, over = at, up = at;
                    ++right[a];
                    ++over[a];
                    ++over[b];
                    ++up[b];
                    text += 'f' + number(at) + number(is_far ? right : up) + number(over) +
                            number(is_far ? up : right) + '\n';
                }
                if (at[a] == 0 || at[b] == 0) continue;
                text += 'l';
                for (at[k] = 0; at[k] < counts[k]; ++at[k]) text += number(at);
                text += '\n';
            }
        }
    }
    auto file = parse_obj(std::move(text), std::move(name));
    file->lattice = std::move(lattice);
    return std::move(*file);
}

cageform::CageParts cage_parts(const MeshFile& cage) {
    if (cage.face_parts.empty()) return {};
    std::vector<int> numbers = cage.face_parts;
    std::replace(numbers.begin(), numbers.end(), 0, 1);
    return cageform::parts_of_faces(face_loops(cage), cage.vertices.size(), numbers);
}

std::string describe_parts(const cageform::CageParts& parts) {
    std::string text;
    for (const auto& part : parts.parts) {
        const std::string count = std::to_string(part.vertices.size());
        text += (text.empty() ? "parts: " : ", ") + std::to_string(part.number) + " (" + count +
                (text.empty() ? part.vertices.size() == 1 ? " vertex)" : " vertices)" : ")");
    }
    return text + '\n';
}

std::string describe_mesh_faults(const std::string& name, const cageform::BindReport& report) {
    return describe_faults(name, report) +
           (report.cage.faults.empty() ? ""
                                       : "\n  (vertices and faces are counted from 0, faces after cutting)");
}

namespace {

void warn_of_closed_gaps(const std::string& name, const cageform::CageReport& report) {
    std::size_t count = 0;
    const cageform::CageFault* first = nullptr;
    for (const auto& fault : report.faults) {
        if (fault.kind != cageform::CageFaultKind::gap_closed) continue;
        if (count++ == 0) first = &fault;
    }
    if (count == 0 || report.status != cageform::Status::ok) return;
    warn(name + ": " + std::to_string(count) + " open edges were closed, first between vertices " +
         std::to_string(first->a + 1) + " and " + std::to_string(first->b + 1) +
         " (counted from 1, as in the file)");
}

} // namespace

void print_notes(const std::string& name, const cageform::CageReport& report,
                 const std::string& of_coordinates) {
    warn_of_closed_gaps(name, report);
    note(of_coordinates);
}

std::string name_points(std::span<const Point3> points, const std::vector<std::size_t>& indices) {
    std::ostringstream text;
    for (std::size_t n = 0; n < std::min<std::size_t>(indices.size(), 3); ++n) {
        const Point3& p = points[indices[n]];
        text << (n == 0 ? "" : ", ") << "v " << indices[n] + 1 << " (" << p[0] << ", " << p[1] << ", " << p[2]
             << ')';
    }
    if (indices.size() > 3) text << ", …";
    return text.str();
}

PoseClip clip_through_poses(const MeshFile& cage, const std::vector<std::string>& poses, double seconds) {
    PoseClip clip{
        "poses", seconds * double(poses.size() + 1), {{0, PoseInterpolation::smooth, cage.vertices}}};
    for (const std::string& path : poses) {
        const auto pose = value_or_fail(load_mesh_pose(path, cage));
        fail_if(single_precision_fault(pose));
        clip.keys.push_back({seconds * double(clip.keys.size()), PoseInterpolation::smooth, pose.vertices});
    }
    return clip;
}

std::string pose_difference(const MeshFile& cage, const MeshFile& pose) {
    const auto count = [](const MeshFile& file, std::size_t vertices, const char* what) {
        return file.name + " has " + std::to_string(vertices) + what;
    };
    if (cage.vertices.size() != pose.vertices.size()) {
        return "the pose " + count(pose, pose.vertices.size(), " vertices, the cage ") +
               count(cage, cage.vertices.size(), "");
    }
    const auto same = [](const MeshFace& a, const MeshFace& b) {
        return std::equal(a.corners.begin(), a.corners.end(), b.corners.begin(), b.corners.end(),
                          [](const MeshCorner& p, const MeshCorner& q) { return p.vertex == q.vertex; });
    };
    const std::size_t shared = std::min(cage.faces.size(), pose.faces.size());
    for (std::size_t f = 0; f < shared; ++f) {
        if (same(cage.faces[f], pose.faces[f])) continue;
        const auto place = [&](const MeshFile& file, const char* of) {
            const std::size_t line = file.document == nullptr && !file.welded ? file.faces[f].line : 0;
            return (line > 0 ? "line " + std::to_string(line) + " of " : std::string()) + of + file.name;
        };
        return "face " + std::to_string(f + 1) + " differs: " + place(pose, "the pose ") + ", " +
               place(cage, "the cage ");
    }
    if (cage.faces.size() != pose.faces.size()) {
        return "face " + std::to_string(shared + 1) + " differs: the pose " +
               count(pose, pose.faces.size(), " faces, the cage ") + count(cage, cage.faces.size(), "");
    }
    return {};
}

std::string describe_winding(const std::string& pose, const std::string& figure, int side, bool flips_faces) {
    const bool is_mirrored = side < 0;
    if (side == 0 || is_mirrored == flips_faces) return {};
    return pose + ": the pose " +
           (is_mirrored
                ? "mirrors " + figure + ", and its faces point inwards; --flip-faces reverses the faces"
                : "does not mirror " + figure + ", and with --flip-faces its faces point inwards");
}

} // namespace cageform_support

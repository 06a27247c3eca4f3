// Faces of cages with more than three corners: kept as polygons, bound as fans, or triangulated.
#include "cli/mesh_cage.hpp"
#include "io/csv.hpp"

#include <cageform/cage/polyhedral_mesh.hpp>

namespace cageform_support {

CageFaces faces_of(const MeshFile& cage, bool keep_planar, FacesAsFans fans, std::uint32_t divisions) {
    CageFaces faces;
    const auto bounds = cageform::bounds_of(std::span<const Point3>(cage.vertices));
    faces.off_plane = 1e-6 * bounds.diagonal();
    faces.divisions = divisions;
    auto loops = face_loops(cage);
    using cageform::PolyhedralMesh, cageform::PolyhedralOptions;
    const PolyhedralMesh<double> whole(cage.vertices, loops, PolyhedralOptions{.off_plane = faces.off_plane});
    const PolyhedralMesh<double> fanned(cage.vertices, loops,
                                        PolyhedralOptions{.off_plane = faces.off_plane,
                                                          .faces = PolyhedralOptions::Faces::fan,
                                                          .divisions = divisions});
    std::size_t triangle = 0;
    for (std::size_t f = 0; f < loops.size(); ++f) {
        auto& loop = loops[f];
        const std::size_t first = triangle;
        while (triangle < cage.triangles.size() && cage.triangle_faces[triangle] == f) ++triangle;
        if (loop.size() == 3) {
            faces.loops.push_back(std::move(loop));
            continue;
        }
        const bool is_planar = !face_fault(whole, f);
        const bool wants_fan = fans == FacesAsFans::all || (fans == FacesAsFans::not_planar && !is_planar);
        if (wants_fan && !face_fault(fanned, f)) {
            ++faces.fans;
            if (divisions > 1 && loop.size() == 4) ++faces.divided;
            if (!is_planar) faces.warped.push_back(f);
            faces.loops.push_back(std::move(loop));
            continue;
        }
        if (keep_planar && is_planar && !wants_fan) {
            ++faces.polygons;
            faces.loops.push_back(std::move(loop));
            continue;
        }
        if (wants_fan || (keep_planar && !is_planar)) faces.bent.push_back(f);
        faces.cut.push_back(f);
        for (std::size_t t = first; t < triangle; ++t)
            faces.loops.emplace_back(cage.triangles[t].begin(), cage.triangles[t].end());
    }
    return faces;
}

std::string describe_faces(const MeshFile& cage, const CageFaces& faces, const std::string& why) {
    std::string text;
    const auto count = [](std::size_t n) { return detail::counted(n, "face"); };
    if (faces.polygons > 0) {
        const bool one = faces.polygons == 1;
        text = count(faces.polygons) + " with more than three corners " + (one ? "is" : "are") + " kept as " +
               (one ? "a polygon" : "polygons") + ", with the coordinates in " +
               (one ? "its plane" : "their planes") + " (--faces triangles cuts " + (one ? "it)" : "them)");
    }
    if (faces.fans > 0) {
        const bool one = faces.fans == 1;
        text += (text.empty() ? "" : "; ") + count(faces.fans) +
                (one ? " is bound as a fan about the mean of its corners"
                     : " are bound as fans about the means of their corners");
        if (faces.divided > 0) {
            const std::string n = std::to_string(faces.divisions);
            text += "; " + std::to_string(faces.divided) + (faces.divided == 1 ? " is" : " are") +
                    " divided into " + n + " x " + n + " cells";
        }
        if (!faces.warped.empty())
            text += "; " + std::to_string(faces.warped.size()) + (faces.warped.size() == 1 ? " is" : " are") +
                    " not planar, first in line " + std::to_string(cage.faces[faces.warped.front()].line);
    }
    if (!faces.cut.empty()) {
        text += (text.empty() ? "" : "; ") + count(faces.cut.size()) +
                (faces.cut.size() == 1 ? " is" : " are") + " cut into triangles, first in line " +
                std::to_string(cage.faces[faces.cut.front()].line) +
                (!faces.bent.empty() && faces.bent.front() == faces.cut.front()
                     ? std::string(": the mean of the corners does not see all edges") +
                           (faces.divisions > 1 ? ", or a cell of it folds" : "")
                 : why.empty() ? ""
                               : ": " + why);
    }
    return text.empty() ? text : cage.name + ": " + text;
}

} // namespace cageform_support

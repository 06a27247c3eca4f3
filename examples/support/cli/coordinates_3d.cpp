#include "cli/coordinates_model.hpp"
#include "cli/mesh_cage.hpp"

namespace cageform_support {

namespace {

/// Returns the error if coordinates do not support planar polygons as faces; else empty.
std::string polygon_fault(const CoordinatesChoice& choice) {
    return (choice.facts().cages & cageform::cage_kinds::planar_faces) == 0
               ? choice.name + " supports only triangles"
               : "";
}

/// Twice the volume of a closed mesh over its area, which is the thickness of a flat mesh.
double mean_thickness(const MeshFile& mesh) {
    double volume = 0, area = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
        const auto& p = mesh.vertices;
        const Point3 across = cross(p[b] - p[a], p[c] - p[a]); // twice the area
        volume += dot(p[a] - p[mesh.triangles[0][0]], across) / 6;
        area += 0.5 * std::sqrt(dot(across, across));
    }
    return 2 * std::fabs(volume) / area;
}

} // namespace

template <class T>
ChosenCoordinates<T, 3> make_coordinates(const CoordinatesChoice& choice, const MeshFile& file) {
    if (file.lattice) return lattice_coordinates<T>(choice, *file.lattice);
    const auto make = [&](const auto& cage) -> ChosenCoordinates<T, 3> {
        if (choice.type() == cageform::CoordinateType::harmonic)
            return make_harmonic(cage, choice.harmonic_options(3), mean_thickness(file));
        return cageform::make_coordinates(choice.type(), cage);
    };
    const std::string why_cut = polygon_fault(choice);
    const bool takes_fans = why_cut.empty() || choice.takes_fans_alone();
    const bool divides = choice.divisions > 1;
    const FacesAsFans fans = !takes_fans || choice.faces == "triangles" ? FacesAsFans::none
                             : choice.faces == "fan" || divides         ? FacesAsFans::all
                                                                        : FacesAsFans::not_planar;
    const auto divisions = std::uint32_t(fans == FacesAsFans::none ? 1 : choice.divisions);
    const CageFaces faces = faces_of(file, why_cut.empty() && choice.faces == "planar", fans, divisions);
    ChosenCoordinates<T, 3> made;
    if (faces.polygons > 0 || faces.fans > 0 || divisions > 1) {
        using Options = cageform::PolyhedralOptions;
        made = make(cageform::PolyhedralMesh<T>(
            file.vertices, faces.loops,
            Options{.off_plane = faces.off_plane,
                    .non_planar = Options::NonPlanar::fan,
                    .faces = fans == FacesAsFans::all ? Options::Faces::fan : Options::Faces::planar,
                    .divisions = divisions}));
    } else {
        made = make(cageform::TriangleMesh<T>(file.vertices, file.triangles));
    }
    const std::string on_faces = describe_faces(file, faces, why_cut);
    made.note += (made.note.empty() || on_faces.empty() ? "" : "; ") + on_faces;
    return made;
}
template ChosenCoordinates<float, 3> make_coordinates(const CoordinatesChoice&, const MeshFile&);
template ChosenCoordinates<float, 3> make_coordinates(const CoordinatesChoice&, const SiteFile<3>&);
template ChosenCoordinates<double, 3> make_coordinates(const CoordinatesChoice&, const SiteFile<3>&);
template ChosenCoordinates<double, 3> make_coordinates(const CoordinatesChoice&, const MeshFile&);

} // namespace cageform_support

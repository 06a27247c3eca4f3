#pragma once

// Cages in space: files of closed meshes, their poses, and messages about them.

#include "files/bind_report.hpp"
#include "files/clip_file.hpp"
#include "files/mesh_file.hpp"

#include <cageform/clone/clone.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/enclose/types/cage_parts.hpp>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// The dimension of a cage file, 2 or 3. Fails if a lattice cannot be read.
std::size_t cage_dimension(const std::string& path);

/// Reads a cage from a file of a mesh or lattice. A file that is not OBJ becomes an OBJ mesh: vertices at one
/// place, by joined_places(), are welded, and faces without three distinct neighbours in a row are dropped.
/// Fails also if a face cannot be triangulated.
Expected<MeshFile> load_mesh_cage(const std::string& path);

/// Reads a pose of a cage. It is the same mesh with its vertices moved; other formats than OBJ also as before
/// welding.
///
///   returns   a mesh with the vertices and faces of the cage
///   fails     also if the pose is not of the cage, or vertices that are one vertex of the cage are apart
Expected<MeshFile> load_mesh_pose(const std::string& path, const MeshFile& cage);

/// A lattice as an OBJ file: its handles, boundary faces, and interior rows as lines.
MeshFile lattice_mesh(std::string name, LatticeBox<3> lattice);

/// The parts of a cage: the file's face groups part_1, part_2, part_-2 and so on; other faces are in part 1.
/// Empty if there is no such group.
cageform::CageParts cage_parts(const MeshFile& cage);

/// "parts: 1 (39 vertices), 2 (15), -2 (15)".
std::string describe_parts(const cageform::CageParts& parts);

/// The faces of a cage as passed to coordinates.
struct CageFaces {
    std::vector<std::vector<std::uint32_t>> loops;
    std::size_t polygons = 0;        // number of faces kept as planar polygons
    std::size_t fans = 0;            // number of faces bound as fans about the mean of their corners
    std::size_t divided = 0;         // number of these that are divided quads
    std::uint32_t divisions = 1;     // of divided quads, per side
    std::vector<std::size_t> warped; // fans that are not planar
    std::vector<std::size_t> cut;    // triangulated faces
    std::vector<std::size_t> bent;   // of these, neither planar nor valid as fans
    double off_plane = 0;            // tolerance of planar faces
};

/// Which faces with more than three corners become fans.
enum class FacesAsFans : std::uint8_t { none, not_planar, all };

/// Classifies the faces with more than three corners. They are kept as polygons if wanted and planar to a
/// millionth of the cage's diagonal (the precision of six digits). The others become fans if wanted and the
/// mean of their corners sees all edges; else they are triangulated.
///
///   divisions   of quads, per side; above 1, all faces with more than three corners become fans
CageFaces faces_of(const MeshFile& cage, bool keep_planar, FacesAsFans fans, std::uint32_t divisions = 1);

/// Describes the treatment of faces with more than three corners; empty if there are none.
///
///   why   reason why polygons are not supported; empty if they are, or the user chose so
std::string describe_faces(const MeshFile& cage, const CageFaces& faces, const std::string& why);

/// describe_faults() of a mesh, with a note on indices.
std::string describe_mesh_faults(const std::string& name, const cageform::BindReport& report);

/// Warns of open edges of a cage that were closed, if any, and prints the note of its coordinates, if any.
void print_notes(const std::string& name, const cageform::CageReport& report,
                 const std::string& of_coordinates);

/// "v 1 (0.1, 0.2, 0.3), …": the first three points of a list, with vertex numbers of the file.
std::string name_points(std::span<const Point3> points, const std::vector<std::size_t>& indices);

/// A smooth motion from rest through poses (files) and back, `seconds` per step. Fails if a file cannot
/// be read, is not a pose of the cage, or exceeds single precision.
PoseClip clip_through_poses(const MeshFile& cage, const std::vector<std::string>& poses, double seconds);

/// The difference that makes `pose` invalid for `cage`; empty if it is valid.
std::string pose_difference(const MeshFile& cage, const MeshFile& pose);

/// Returns a warning if faces point inwards: the pose mirrors the figure, or --flip-faces was given for a
/// pose that does not. Else empty.
///
///   side   result of side_of(); 0 (flat) gives no warning
std::string describe_winding(const std::string& pose, const std::string& figure, int side, bool flips_faces);

/// The name of the first pose that mirrors a figure; empty if there is none.
template <cageform::Scalar T>
std::string first_mirror(const MeshFile& figure, const cageform::Binding<T, 3>& bound, const PoseClip& clip) {
    using cageform::Status;
    std::vector<cageform::Vec<T, 3>> moved(figure.vertices.size()), handles(bound.handle_count());
    std::vector<Point3> places(moved.size());
    for (const PoseKey& key : clip.keys) {
        if (pose_handles(bound, key.places, handles).status != Status::ok ||
            clone(bound, handles, moved) != Status::ok)
            continue;
        for (std::size_t i = 0; i < moved.size(); ++i) places[i] = cageform::vec_cast<double>(moved[i]);
        if (is_mirrored(figure.vertices, places)) return name_of_pose(clip, key.time);
    }
    return {};
}

} // namespace cageform_support

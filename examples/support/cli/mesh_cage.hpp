#pragma once

// Cages in space: OBJ files of closed meshes, and what to say of them.

#include "files/bind_report.hpp"
#include "files/clip_file.hpp"
#include "files/obj_file.hpp"

#include <cageform/clone/clone.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/enclose/types/cage_parts.hpp>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

/// 2 or 3: the dimension of a cage by its file. Fails where a lattice cannot be read.
Expected<std::size_t> cage_dimension(const std::string& path);

/// A cage from an OBJ file, or a lattice; fails also where a face cannot be cut into triangles.
Expected<ObjFile> load_mesh_cage(const std::string& path);

/// A lattice as an OBJ file: its handles, the faces between the outer ones, and the rows inside as lines.
ObjFile lattice_mesh(std::string name, LatticeBox<3> lattice);

/// The parts that the file's groups of faces part_1, part_2, part_-2 and so on name; faces of no such group
/// are of part 1. None where there is no such group.
cageform::CageParts cage_parts(const ObjFile& cage);

/// "parts: 1 (39 vertices), 2 (15), -2 (15)": a line for people.
std::string describe_parts(const cageform::CageParts& parts);

/// The faces of a cage as coordinates get them.
struct CageFaces {
    std::vector<std::vector<std::uint32_t>> loops;
    std::size_t polygons = 0; // of the file's faces with more than three corners, those that keep their plane
    std::size_t fans = 0;     // those that become fans about the mean of their corners
    std::size_t divided = 0;  // of those, the quads that are divided
    std::uint32_t divisions = 1;     // of these, each way
    std::vector<std::size_t> warped; // of those, the ones that are not planar
    std::vector<std::size_t> cut;    // the others, cut into the file's triangles
    std::vector<std::size_t> bent;   // of those, the ones that are neither planar nor possible as fans
    double off_plane = 0;            // as far as corners of a kept face may lie off its plane
};

/// Which faces of more than three corners become fans.
enum class FacesAsFans { none, not_planar, all };

/// All faces, of which those of more than three corners are kept where that is wanted: as polygons, if they
/// are planar to a millionth of the cage's diagonal (what six digits of a file leave of a plane), or as fans,
/// if the mean of their corners sees all edges.
///
///   divisions   of quads, each way; above 1 all faces that are kept have to be fans
CageFaces faces_of(const ObjFile& cage, bool keep_planar, FacesAsFans fans, std::uint32_t divisions = 1);

/// Describes how faces with more than three corners were treated; empty if there are none.
///
///   why   none of them is kept; empty where the user wants it so
std::string describe_faces(const ObjFile& cage, const CageFaces& faces, const std::string& why);

/// describe_faults() of a mesh, whose file counts otherwise.
std::string describe_mesh_faults(const std::string& name, const cageform::BindReport& report);

/// Says on stderr how many open edges of a sound cage were closed, if any.
void warn_of_closed_gaps(const std::string& name, const cageform::CageReport& report);

/// "(0.1, 0.2, 0.3), …" for the first few of a list of points, named as the file counts them.
std::string name_points(std::span<const Point3> points, const std::vector<std::size_t>& indices);

/// A motion from the cage at rest through poses, OBJ files, and back, smooth, `seconds` from each to the
/// next. Fails where a file cannot be read, is no pose of the cage or is beyond single precision.
Expected<PoseClip> clip_through_poses(const ObjFile& cage, const std::vector<std::string>& poses,
                                      double seconds);

/// Returns why `pose` is not a pose of `cage`; empty if it is one.
std::string pose_difference(const ObjFile& cage, const ObjFile& pose);

/// Returns the warning that faces look inwards: the pose mirrors the figure, or --flip-faces was given for a
/// pose that does not. Empty if the faces look outwards.
///
///   side   the result of side_of(); 0 (flat) gives no warning
std::string describe_winding(const std::string& pose, const std::string& figure, int side, bool flips_faces);

/// The name of the first pose of a motion that mirrors a figure; empty if there is none.
template <cageform::Scalar T>
std::string first_mirror(const ObjFile& figure, const cageform::Binding<T, 3>& bound, const PoseClip& clip) {
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

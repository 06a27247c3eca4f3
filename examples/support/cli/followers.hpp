#pragma once

// Files whose points follow a source that is wrapped onto a target: clothes, hair, joints, morph targets.

#include "cli/wrap_choice.hpp"

#include <cageform/fit/push_out.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// The surfaces of a wrap, for distances of followers.
struct WrapSurfaces {
    cageform::SurfaceMesh target_mesh;
    cageform::ClosestPlaces source, target; ///< the source at rest
    double height = 0;                      ///< of the target

    WrapSurfaces(const WrapFigures& figures, double its_height);
};

/// A mesh, or a CSV file of points.
class Follower {
public:
    /// Reads IN of IN:OUT. Fails with the name of the file.
    ///
    ///   is_strict   for meshes, as load_mesh_figure()
    static Follower read(const std::string& word, bool is_strict);

    const std::string& name() const { return name_; }
    const std::string& out() const { return out_; }
    std::span<const Point3> rest() const { return is_mesh() ? mesh_.vertices : table_.points; }
    std::span<const Point3> moved() const { return moved_; }
    const MeshFile& mesh() const { return mesh_; } ///< empty for a CSV file
    const PointTable& table() const { return table_; }

    void move(const WrapMap& map);
    /// Moves vertices of a mesh that were outside the source and are inside the target to its outside, and
    /// counts them.
    ///
    ///   distance   from the target's surface, relative to its height; none: only counts
    void push_out(const WrapSurfaces& surfaces, std::optional<double> distance);
    /// Adds the file with moved points to the outputs. Returns notes for the user.
    std::vector<std::string> save(OutputFiles& outputs) const;
    /// "dress.obj: 1911 vertices; 2 of 1900 are inside the target, at most 0.1 % of its height deep". Counted
    /// are vertices that are outside the source.
    std::string describe() const;
    /// Warnings about faces that --push-out turned; empty if there are none.
    std::string warning() const;

private:
    bool is_mesh() const { return !mesh_.vertices.empty(); }

    std::string name_, out_;
    MeshFile mesh_;
    PointTable table_;
    std::vector<Point3> moved_, guides_;
    std::vector<Jacobian3> jacobians_;
    std::size_t checked_ = 0, inside_ = 0; ///< vertices outside the source; those inside the target
    double depth_ = 0;                     ///< of the deepest, relative to the target's height
    std::optional<cageform::PushOutReport> pushed_;
    double height_ = 0;
};

/// A copy of the source with its vertices moved, such as a smile. Its displacements follow by the Jacobian of
/// the map at the source's vertices.
class MorphFile {
public:
    /// Reads IN of IN:OUT. Fails also if the mesh is not the source with its vertices moved.
    static MorphFile read(const std::string& word, const MeshFile& source, bool is_strict);

    const std::string& out() const { return out_; }
    /// Adds the file to the outputs. Returns notes for the user.
    ///
    ///   wrapped     the source on the target, with Jacobians
    std::vector<std::string> save(const MeshFile& source, const MovedVertices& wrapped,
                                  OutputFiles& outputs) const;

private:
    std::string out_;
    MeshFile mesh_;
};

} // namespace cageform_support

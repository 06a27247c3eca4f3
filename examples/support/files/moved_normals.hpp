#pragma once

// Normals of deformed OBJ files.

#include "files/mesh_file.hpp"

namespace cageform_support {

/// J⁻ᵀ n, scaled to the length of `n`; nothing if the Jacobian is singular.
std::optional<Point3> moved_normal(const Jacobian3& jacobian, const Point3& n);

/// The file's normals after a deformation, with their lengths.
///
///   - With Jacobians: by inverse transposes. A normal shared by several vertices is the mean over its
///     vertices; of_corner() returns the individual normals.
///   - Without invertible Jacobians: a normal rotates with its faces, by the smallest rotation between the
///     area-weighted sums of their normals before and after. If the deformation mirrors the file, the sum
///     after it is reversed.
///   - Normals without faces, or whose face normals sum to zero, are unchanged.
class MovedNormals {
public:
    MovedNormals(const MeshFile& file, const MovedVertices& moved);

    const std::vector<Point3>& of_file() const { return normals_; } ///< #normals
    Point3 of_corner(std::uint32_t vertex, std::uint32_t normal) const;

    /// #normals: the vertices that use the normal, ascending, if its direction at one of them differs from
    /// of_file() by more than 1e-5 radians; else no vertices. Empty if no direction differs.
    std::vector<std::vector<std::uint32_t>> split() const;

private:
    const MeshFile& file_;
    const MovedVertices moved_;
    std::vector<Point3> normals_;
};

} // namespace cageform_support

#pragma once

// Normals of an OBJ file whose vertices have moved.

#include "files/obj_file.hpp"

namespace cageform_support {

/// J⁻ᵀ n, as long as `n`. Returns nothing where the Jacobian has no inverse.
std::optional<Point3> moved_normal(const Jacobian3& jacobian, const Point3& n);

/// The file's normals after a deformation, as long as before.
///
///   - With Jacobians, by their inverse transposes. A normal of several vertices is the mean of those of its
///     vertices; of_corner() tells them apart.
///   - Without invertible Jacobians, a normal turns with its faces. The normals of its faces are summed,
///     weighted by area, before and after. The smallest rotation between both sums turns the normal. If the
///     deformation mirrors the file, the sum after it is reversed.
///   - A normal that no face has, or whose faces sum up to nothing, stays.
class MovedNormals {
public:
    MovedNormals(const ObjFile& file, const MovedVertices& moved);

    const std::vector<Point3>& of_file() const { return normals_; } ///< #normals
    Point3 of_corner(std::uint32_t vertex, std::uint32_t normal) const;

    /// Returns for each normal the vertices that use it, ascending, if its direction at one of them differs
    /// from of_file() by more than 1e-5 radians; else no vertices. Empty if no normal has vertices.
    std::vector<std::vector<std::uint32_t>> split() const;

private:
    const ObjFile& file_;
    const MovedVertices moved_;
    std::vector<Point3> normals_;
};

} // namespace cageform_support

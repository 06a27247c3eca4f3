// Triangle meshes as surfaces, and distances between them.
#pragma once

#include <cageform/cage/detail/mesh_face.hpp>
#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/view.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A copy of a triangle mesh in double. The mesh may be open, in parts, or cross itself.
class SurfaceMesh {
public:
    using Face = std::array<std::uint32_t, 3>;

    SurfaceMesh() = default;
    ///   faces  `faces[f][k]`, k = 0, 1, 2, is the index of a corner; counter-clockwise seen from outside
    template <PointRange R, FaceRange F>
        requires(range_dimension<R> == 3)
    SurfaceMesh(const R& points, const F& triangles)
        : status_(detail::guard_memory([&] {
            for (std::size_t i = 0; i < std::size(points); ++i)
                vertices_.push_back(to_vec<double>(points[i]));
            for (std::size_t f = 0; f < std::size(triangles); ++f)
                faces_.push_back(detail::checked_face(triangles[f], vertices_.size()));
        })) {}

    /// Returns ok, or out_of_memory.
    Status status() const noexcept { return status_; }
    std::span<const Vec<double, 3>> vertices() const noexcept { return vertices_; }
    /// Returns the faces; indices out of range are replaced by no_vertex.
    std::span<const Face> faces() const noexcept { return faces_; }

private:
    std::vector<Vec<double, 3>> vertices_;
    std::vector<Face> faces_;
    Status status_ = Status::ok; // declared last: its initialiser fills the other members
};

/// Distances of many points from a surface.
struct SurfaceDistance {
    double mean = 0;
    double upper = 0; ///< the 95th percentile
    double largest = 0;
    std::size_t farthest = 0; ///< index of the point with the largest distance
};

} // namespace cageform::inline CAGEFORM_ABI

// Triangle meshes as surfaces, and distances between them.
#pragma once

#include <cageform/cage/detail/mesh_face.hpp>
#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/core/detail/guard_memory.hpp>
#include <cageform/core/view.hpp>

#include <cmath>

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

namespace detail {

/// Checks that all vertices are finite, and that all faces have their vertices.
///
///   culprit  out: the vertex or face that is refused
inline Status check_vertices(const SurfaceMesh& mesh, std::size_t& culprit) noexcept {
    if (mesh.status() != Status::ok) return mesh.status();
    for (std::size_t i = 0; i < mesh.vertices().size(); ++i) {
        culprit = i;
        // Areas are products of four lengths, and must not overflow.
        for (const double x : mesh.vertices()[i].v) {
            if (!(std::fabs(x) < 1e70)) return Status::figure_not_finite;
        }
    }
    for (std::size_t f = 0; f < mesh.faces().size(); ++f) {
        culprit = f;
        if (has_missing_vertex(mesh.faces()[f])) return Status::index_out_of_range;
    }
    culprit = ~std::size_t{0};
    return Status::ok;
}
/// Also checks that a face has an area.
inline Status check_surface(const SurfaceMesh& mesh, std::size_t& culprit) noexcept {
    if (const Status status = check_vertices(mesh, culprit); status != Status::ok) return status;
    const auto v = mesh.vertices();
    if (v.empty() || mesh.faces().empty()) return Status::figure_empty;
    for (const auto& [a, b, c] : mesh.faces()) {
        const auto n = cross(v[b] - v[a], v[c] - v[a]);
        if (dot(n, n) > 0) return Status::ok;
    }
    return Status::figure_has_no_size;
}

} // namespace detail

/// Distances of many points from a surface.
struct SurfaceDistance {
    double mean = 0;
    double upper = 0; ///< the 95th percentile
    double largest = 0;
    std::size_t farthest = 0; ///< index of the point with the largest distance
};

} // namespace cageform::inline CAGEFORM_ABI

// Boundary data of a polyhedral mesh: coordinates in the plane of each face.
#pragma once

#include <cageform/cage/detail/flat_face.hpp>
#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/coordinates/coordinate.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The values of the handles at surface points of a PolyhedralMesh. On a face with more than three
/// corners they are the face's coordinates `Plane`, a 2D type of CageCoordinates in double. On
/// triangles, edges and vertices they are linear. A point is given by the triangle it lies on and
/// its weights there.
template <class Plane>
class FaceCoordinates {
public:
    using Value = BoundaryValue<3>;

    FaceCoordinates() = default;
    /// `mesh` must be sound. make(polygon, size) returns the coordinates of a face in its plane,
    /// where `size` is the longer side of its bounding box there.
    template <Scalar T, class Make>
    FaceCoordinates(const PolyhedralMesh<T>& mesh, const Make& make) {
        for (std::size_t f = 0; f < mesh.face_count(); ++f) {
            const auto loop = mesh.face(f);
            if (loop.size() < 4) continue;
            const auto face = std::uint32_t(faces_.size());
            const FacePlane plane = plane_of(mesh, f);
            const auto polygon = flat_face(mesh, f, plane);
            const auto bounds = bounds_of(polygon.vertices());
            const auto extent = bounds.upper - bounds.lower;
            faces_.push_back(
                {plane, {loop.begin(), loop.end()}, make(polygon, std::fmax(extent[0], extent[1]))});
            const auto [first, last] = mesh.triangles_of(f);
            for (std::size_t t = first; t < last; ++t) add_triangle(mesh.triangles().faces()[t], loop, face);
        }
        std::sort(parts_.begin(), parts_.end());
        for (const auto& v : mesh.vertices()) vertices_.push_back(vec_cast<double>(v));
    }

    /// Calls f(handle, weight) for the handles with a non-zero value at a point. Throws bad_alloc.
    template <class F>
    void for_each_weight(const Value& value, F&& f) const {
        const Face* const face = face_of(value);
        if (face == nullptr) return HatData<3>::for_each_weight(value, f);
        std::vector<double> row(face->corners.size());
        const auto q = face->plane.flat(place_of(value));
        const PointState state = weights_at(face->coordinates, q, std::span(row));
        if (state != PointState::inside && state != PointState::on_boundary)
            (void)face->coordinates.nearest_boundary(q, row); // outside by rounding
        for (std::size_t k = 0; k < row.size(); ++k) {
            if (row[k] != 0) f(face->corners[k], row[k]);
        }
    }

    /// Calls f(handle) for those handles, or for all corners of the point's face.
    template <class F>
    void for_each_handle(const Value& value, F&& f) const {
        const Face* const face = face_of(value);
        if (face == nullptr) return HatData<3>::for_each_handle(value, f);
        for (const std::uint32_t corner : face->corners) f(corner);
    }

private:
    struct Face {
        FacePlane plane;
        std::vector<std::uint32_t> corners;
        Plane coordinates;
    };
    /// A triangle or a diagonal of a face; vertices ascend, and a diagonal has no_vertex last.
    struct Part {
        std::array<std::uint32_t, 3> vertex;
        std::uint32_t face;
        auto operator<=>(const Part&) const = default;
    };

    void add_triangle(const std::array<std::uint32_t, 3>& triangle, std::span<const std::uint32_t> loop,
                      std::uint32_t face) {
        auto vertex = triangle;
        std::sort(vertex.begin(), vertex.end());
        parts_.push_back({vertex, face});
        for (std::size_t k = 0; k < 3; ++k) {
            const auto a = triangle[k], b = triangle[(k + 1) % 3];
            const auto at = std::size_t(std::find(loop.begin(), loop.end(), a) - loop.begin());
            const bool is_edge = loop[(at + 1) % loop.size()] == b;
            if (!is_edge) parts_.push_back({{(std::min)(a, b), (std::max)(a, b), no_vertex}, face});
        }
    }
    /// Returns the face with more than three corners that a point lies in; null on other faces,
    /// edges and vertices.
    const Face* face_of(const Value& value) const noexcept {
        std::array<std::uint32_t, 3> vertex{no_vertex, no_vertex, no_vertex};
        std::size_t count = 0;
        for (std::size_t n = 0; n < Value::most; ++n) {
            if (value.weight[n] == 0) continue;
            if (count == 3) return nullptr;
            vertex[count++] = value.handle[n];
        }
        if (count < 2) return nullptr;
        std::sort(vertex.begin(), vertex.end());
        const auto part = std::lower_bound(parts_.begin(), parts_.end(), Part{vertex, 0});
        return part != parts_.end() && part->vertex == vertex ? &faces_[part->face] : nullptr;
    }
    Vec<double, 3> place_of(const Value& value) const noexcept {
        Vec<double, 3> place{};
        for (std::size_t n = 0; n < Value::most; ++n)
            place = place + value.weight[n] * vertices_[value.handle[n]];
        return place;
    }

    std::vector<Face> faces_;
    std::vector<Part> parts_; ///< sorted
    std::vector<Vec<double, 3>> vertices_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

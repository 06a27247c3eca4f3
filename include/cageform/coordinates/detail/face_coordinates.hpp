// Boundary values on a polyhedral mesh: 2D coordinates on planar faces, hat functions on fans.
#pragma once

#include <cageform/cage/detail/flat_face.hpp>
#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/coordinates/coordinate.hpp>
#include <cageform/coordinates/detail/boundary_data.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Computes the weights of a face's corners at a point of its plane. If rounding puts the point outside, the
/// nearest boundary point is used.
template <class Plane>
void face_weights(const Plane& coordinates, const Vec<double, 2>& p, std::span<double> row) {
    const PointState state = weights_at(coordinates, p, row);
    if (state != PointState::inside && state != PointState::on_boundary)
        (void)coordinates.nearest_boundary(p, row);
}

/// The boundary values on a PolyhedralMesh. On planar faces with more than three corners they are 2D
/// coordinates of type `Plane`: CageCoordinates in double, or a type with its own `face_weights`. They are
/// linear on the triangles of other faces. A point is given by its triangle and its weights there.
template <class Plane>
class FaceCoordinates final : public FaceData {
public:
    using Value = BoundaryValue<3>;

    FaceCoordinates() = default;
    /// `mesh` has no faults. make(polygon) returns the coordinates of a flattened face.
    template <Scalar T, class Make>
    FaceCoordinates(const PolyhedralMesh<T>& mesh, const Make& make)
        : fan_points_(mesh.fan_points()) {
        for (std::size_t f = 0; f < mesh.face_count(); ++f) {
            const auto loop = mesh.face(f);
            if (loop.size() < 4 || mesh.is_fan(f)) continue;
            const auto face = std::uint32_t(faces_.size());
            const FacePlane plane = plane_of(mesh, f);
            faces_.push_back({plane, {loop.begin(), loop.end()}, make(flat_face(mesh, f, plane))});
            const auto [first, last] = mesh.triangles_of(f);
            for (std::size_t t = first; t < last; ++t) add_triangle(mesh.triangles().faces()[t], loop, face);
        }
        std::sort(pieces_.begin(), pieces_.end());
        for (const auto& v : mesh.vertices()) vertices_.push_back(vec_cast<double>(v));
    }

    /// Makes the values linear on the triangles of planar faces too.
    void without_planar_faces() noexcept {
        faces_.clear();
        pieces_.clear();
    }

    /// Calls f(handle, weight) for the handles with a non-zero value at a point. Throws bad_alloc.
    template <class F>
    void for_each_weight(const Value& value, F&& f) const {
        const Face* const face = face_of(value);
        if (face == nullptr) return for_each_hat(value, f);
        std::vector<double> row(face->corners.size());
        face_weights(face->coordinates, face->plane.flat(position_of(value)), std::span(row));
        for (std::size_t k = 0; k < row.size(); ++k) {
            if (row[k] != 0) f(face->corners[k], row[k]);
        }
    }

    void weights(const Value& value, const Visit& visit) const override { for_each_weight(value, visit); }
    void handles(const Value& value, const Visit& visit) const override {
        const Face* const face = face_of(value);
        if (face == nullptr) return for_each_hat(value, visit);
        for (const std::uint32_t corner : face->corners) visit(corner, 1);
    }

private:
    struct Face {
        FacePlane plane;
        std::vector<std::uint32_t> corners;
        Plane coordinates;
    };
    /// A triangle or a diagonal of a face. Vertices ascend; the last of a diagonal is no_vertex.
    struct Piece {
        std::array<std::uint32_t, 3> vertex;
        std::uint32_t face;
        auto operator<=>(const Piece&) const = default;
    };

    /// Calls f(handle, weight) for the corners of a triangle. The corners of a loop replace its mean.
    template <class F>
    void for_each_hat(const Value& value, F&& f) const {
        LinearBoundaryData<3>::for_each_weight(value, [&](std::uint32_t i, double weight) {
            if (i < vertices_.size()) return f(i, weight);
            fan_points_.for_each_corner(
                i - vertices_.size(), [&](std::uint32_t corner, double share) { f(corner, share * weight); });
        });
    }
    void add_triangle(const std::array<std::uint32_t, 3>& triangle, std::span<const std::uint32_t> loop,
                      std::uint32_t face) {
        auto vertex = triangle;
        std::sort(vertex.begin(), vertex.end());
        pieces_.push_back({vertex, face});
        for (std::size_t k = 0; k < 3; ++k) {
            const auto a = triangle[k], b = triangle[(k + 1) % 3];
            const auto at = std::size_t(std::find(loop.begin(), loop.end(), a) - loop.begin());
            const bool is_edge = loop[(at + 1) % loop.size()] == b;
            if (!is_edge) pieces_.push_back({{(std::min)(a, b), (std::max)(a, b), no_vertex}, face});
        }
    }
    /// Returns the face with more than three corners whose interior contains the point, else null.
    const Face* face_of(const Value& value) const noexcept {
        std::array<std::uint32_t, 3> vertex{no_vertex, no_vertex, no_vertex};
        std::size_t count = 0;
        for (std::size_t n = 0; n < Value::most; ++n) {
            if (value.weight[n] == 0) continue;
            vertex[count++] = value.handle[n];
        }
        if (count < 2) return nullptr;
        std::sort(vertex.begin(), vertex.end());
        const auto piece = std::lower_bound(pieces_.begin(), pieces_.end(), Piece{vertex, 0});
        return piece != pieces_.end() && piece->vertex == vertex ? &faces_[piece->face] : nullptr;
    }
    Vec<double, 3> position_of(const Value& value) const noexcept {
        Vec<double, 3> position{};
        for (std::size_t n = 0; n < Value::most; ++n)
            position = position + value.weight[n] * vertices_[value.handle[n]];
        return position;
    }

    std::vector<Face> faces_;
    std::vector<Piece> pieces_; ///< sorted
    std::vector<Vec<double, 3>> vertices_;
    FanPoints fan_points_;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

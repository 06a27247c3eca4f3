// The 3D cage whose faces are polygons, planar or not: its data, point location, and its check.
#pragma once

#include <cageform/cage/detail/face_plane.hpp>
#include <cageform/cage/detail/fan_points.hpp>
#include <cageform/cage/triangle_mesh.hpp>

#include <optional>

namespace cageform::inline CAGEFORM_ABI {

/// A range of vertex loops: `faces[f]` has a size, and `faces[f][k]` is an integer.
template <class F>
concept LoopRange = requires(const F& faces, std::size_t i) {
    { std::size(faces) } -> std::convertible_to<std::size_t>;
    { std::size(faces[i]) } -> std::convertible_to<std::size_t>;
    requires std::integral<std::remove_cvref_t<decltype(faces[i][i])>>;
};

/// How a PolyhedralMesh binds faces of more than three corners.
///
/// A *fan* consists of the triangles between a face's edges and the mean m of its n corners. The function of
/// a corner is 1 at the corner, 1/n at m, and linear on each triangle. So the weight of m is distributed to
/// the corners: w_c = ω_c + Σ ω_m/n over the faces at c. Here ω are the weights on the triangle mesh. This
/// preserves sums, linear precision, signs and the maximum principle, and does not depend on a choice of
/// diagonal or first corner. The distance of a fan from the bilinear patch of the corners is at most |c₀ − c₁
/// + c₂ − c₃|/16. For two triangles it is at most |c₀ − c₁ + c₂ − c₃|/4.
struct PolyhedralOptions {
    enum class NonPlanar : std::uint8_t {
        refuse, ///< face_not_planar
        fan,
    };
    enum class Faces : std::uint8_t {
        planar, ///< planar faces have coordinates in their plane
        fan,    ///< all faces are fans
    };
    /// Maximum distance of a corner from its face's plane, in units of the cage. The minimum is 8 times the
    /// coincidence_tolerance. Weights on such a face reproduce the point's projection onto the plane, so
    /// their error is at most this distance.
    double off_plane = 0;
    NonPlanar non_planar = NonPlanar::refuse;
    Faces faces = Faces::planar;
    /// k, 1 to 64: a face of four corners is divided into k × k cells of its bilinear patch, each a fan. The
    /// functions on the face are then nearly bilinear; their error is k² times smaller. Mean value weights
    /// converge to their integral over the patch at the same rate. Such a face has 4 k² triangles, so a bind
    /// takes 2 k² times as long. With k > 1 all faces of more than three corners are fans. Gaps next to
    /// divided faces may be refused as open edges.
    std::uint32_t divisions = 1;
};

/// A 3D cage with faces of any number of corners. A face is one loop, counter-clockwise seen from outside; a
/// planar face may be non-convex. The surface equals that of `triangles()`. The boundary data on a planar
/// face are 2D coordinates in its plane, so the weights do not depend on its triangulation (Joshi et al.
/// 2007, sec. 4: the equation is solved on each face in 2D). Non-planar faces are refused or bound as fans
/// (PolyhedralOptions).
///
/// Copies the vertices and faces. Construction never fails; `check` reports whether the mesh is a valid
/// cage. Gaps are closed by triangles, as in a TriangleMesh. O(#corners log #corners), and O(m²) for a face
/// of m corners.
template <Scalar T>
class PolyhedralMesh {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 3;
    static constexpr std::uint32_t most_divisions = 64;

    PolyhedralMesh() = default;

    template <PointRange R, LoopRange F>
        requires(range_dimension<R> == 3)
    PolyhedralMesh(const R& vertices, const F& faces, const PolyhedralOptions& options = {})
        : options_(options)
        , off_plane_(options.off_plane)
        , status_(detail::guard_memory([&] { return fill(vertices, faces); })) {
        if (status_ != Status::ok) *this = PolyhedralMesh(status_);
    }

    /// Returns ok, or out_of_memory if the faces did not fit in memory. The mesh is then empty, and `check`
    /// reports this status. Copying may throw.
    Status status() const noexcept { return status_; }
    std::size_t size() const noexcept { return size_; }
    std::span<const Vec<T, 3>> vertices() const noexcept { return triangles_.vertices().first(size_); }
    const Vec<T, 3>& operator[](std::size_t i) const noexcept { return triangles_[i]; }

    std::size_t face_count() const noexcept { return ends_.size(); }
    /// Returns the vertices of a face; no_vertex replaces an index out of range.
    std::span<const std::uint32_t> face(std::size_t f) const noexcept {
        const std::size_t begin = f == 0 ? 0 : ends_[f - 1];
        return {corners_.data() + begin, ends_[f] - begin};
    }
    /// Returns the surface as triangles: those of face 0, of face 1, …, then those that close gaps. The
    /// vertices are those of the mesh, then the points of fans. If no face is divided, these points are in
    /// the order of the faces.
    const TriangleMesh<T>& triangles() const noexcept { return triangles_; }
    /// Returns the range [first, second) of a face's triangles: m − 2 triangles for a planar face of m
    /// corners. The triangles of a fan begin at the face's first corner.
    std::pair<std::size_t, std::size_t> triangles_of(std::size_t f) const noexcept {
        return {f == 0 ? 0 : triangle_ends_[f - 1], triangle_ends_[f]};
    }
    /// Returns the face of a triangle; face_count() if the triangle closes a gap.
    std::size_t face_of(std::size_t triangle) const noexcept {
        return std::size_t(std::upper_bound(triangle_ends_.begin(), triangle_ends_.end(), triangle) -
                           triangle_ends_.begin());
    }
    /// Returns the maximum distance of a corner from its face's plane.
    double off_plane() const noexcept { return off_plane_; }
    const PolyhedralOptions& options() const noexcept { return options_; }
    bool is_fan(std::size_t f) const noexcept { return is_fan_[f]; }
    /// Returns the vertices of `triangles()` that follow those of the mesh.
    const detail::FanPoints& fan_points() const noexcept { return fan_points_; }

private:
    explicit PolyhedralMesh(Status status) noexcept
        : status_(status) {}

    template <class R, class F>
    Status fill(const R& vertices, const F& faces) {
        std::vector<Vec<T, 3>> at;
        for (std::size_t i = 0; i < std::size(vertices); ++i) at.push_back(to_vec<T>(vertices[i]));
        size_ = at.size();
        off_plane_ = std::fmax(off_plane_,
                               8 * double(coincidence_tolerance(bounds_of(std::span<const Vec<T, 3>>(at)))));
        for (std::size_t f = 0; f < std::size(faces); ++f) {
            for (std::size_t k = 0; k < std::size(faces[f]); ++k) {
                const auto i = faces[f][k];
                const bool is_there = i >= 0 && std::uint64_t(i) < at.size();
                corners_.push_back(is_there ? std::uint32_t(i) : no_vertex);
            }
            ends_.push_back(corners_.size());
            is_fan_.push_back(needs_fan(face(f), at));
        }
        detail::FanBuilder<T> fans(at, fan_points_,
                                   options_.divisions <= most_divisions ? options_.divisions : 1);
        for (std::size_t f = 0; f < face_count(); ++f) {
            if (is_fan_[f]) fans.divide_edges(face(f));
        }
        std::vector<std::array<std::uint32_t, 3>> triangles;
        for (std::size_t f = 0; f < face_count(); ++f) {
            if (is_fan_[f])
                fans.add(face(f), triangles);
            else
                cut(fans.with_edge_points(face(f)), at, triangles);
            triangle_ends_.push_back(triangles.size());
        }
        triangles_ = TriangleMesh<T>(at, triangles);
        return triangles_.status();
    }

    bool needs_fan(std::span<const std::uint32_t> loop, std::span<const Vec<T, 3>> at) const {
        if (loop.size() < 4 || std::find(loop.begin(), loop.end(), no_vertex) != loop.end()) return false;
        if (options_.faces == PolyhedralOptions::Faces::fan || options_.divisions > 1) return true;
        if (options_.non_planar == PolyhedralOptions::NonPlanar::refuse) return false;
        Buffer<Vec<double, 3>> positions;
        for (const std::uint32_t i : loop) positions.push_back(vec_cast<double>(at[i]));
        return detail::FarthestCorner(positions, detail::FacePlane(positions)).distance > off_plane_;
    }

    static void cut(std::span<const std::uint32_t> loop, std::span<const Vec<T, 3>> at,
                    std::vector<std::array<std::uint32_t, 3>>& triangles) {
        if (loop.size() == 3) return triangles.push_back({loop[0], loop[1], loop[2]});
        const bool is_incomplete = std::find(loop.begin(), loop.end(), no_vertex) != loop.end();
        Buffer<Vec<double, 3>> positions;
        for (std::size_t k = 0; !is_incomplete && k < loop.size(); ++k)
            positions.push_back(vec_cast<double>(at[loop[k]]));
        const detail::FacePlane plane(positions);
        Buffer<Vec<double, 2>> flat;
        for (const auto& p : positions) flat.push_back(plane.flat(p));
        if (is_incomplete) triangles.push_back({no_vertex, no_vertex, no_vertex});
        const detail::PolygonTriangulation flat_triangles(flat);
        for (const auto& [a, b, c] : flat_triangles.triangles())
            triangles.push_back({loop[a], loop[b], loop[c]});
    }

    std::vector<std::uint32_t> corners_;            ///< of all faces, concatenated
    std::vector<std::size_t> ends_, triangle_ends_; ///< end of each face in corners_ and in the triangles
    std::vector<bool> is_fan_;                      ///< per face
    std::size_t size_ = 0;
    detail::FanPoints fan_points_;
    TriangleMesh<T> triangles_;
    PolyhedralOptions options_;
    double off_plane_ = 0;
    Status status_ = Status::ok; // declared last: its initialiser fills the other members
};

template <PointRange R, LoopRange F>
PolyhedralMesh(const R&, const F&, const PolyhedralOptions& = {}) -> PolyhedralMesh<range_scalar_t<R>>;

template <Scalar T, class F>
void for_each_facet(const PolyhedralMesh<T>& mesh, F&& f) {
    for_each_facet(mesh.triangles(), f);
}

/// Classifies a point; it is on the boundary within `tolerance` of a face. The mesh must be valid. Usually
/// O(log #corners).
template <Scalar T>
PointState locate(const PolyhedralMesh<T>& mesh, const Vec<T, 3>& p, T tolerance) noexcept {
    return locate(mesh.triangles(), p, tolerance);
}

/// Returns the boundary data of the nearest triangle. Coordinate types replace it by the data of the face
/// that contains the triangle (coordinates/detail/face_coordinates.hpp). Usually O(log #corners).
template <Scalar T>
BoundaryValue<3> nearest_boundary_value(const PolyhedralMesh<T>& mesh, const Vec<T, 3>& p,
                                        Vec<T, 3>& position) noexcept {
    return nearest_boundary_value(mesh.triangles(), p, position);
}

/// Checks whether a mesh is a valid cage. Every face must have at least three corners that exist, are finite,
/// lie in one plane (see off_plane) and form a simple polygon. A fan need not be planar; the triangles around
/// its mean must not fold. The other conditions are those of a TriangleMesh. Faults give face indices. Each
/// non-planar fan gives a warning and a distance. For four corners it is the distance from the bilinear
/// patch. For more corners it is the largest distance of a corner from the plane. Costs as much as for a
/// TriangleMesh, plus O(m log m) for a face of m corners, O(m²) at worst.
template <class T>
CageReport check(const PolyhedralMesh<T>& mesh);

/// Returns the first fault of one face, if any. The result does not depend on the other faces. Vertices must
/// be finite. O(m log m) for m corners, O(m²) at worst. Possible faults:
///   any face                too_few_vertices, face_without_vertex
///   a fan                   also face_crosses_itself, face_without_area, face_fan_folds
///   more than 3 corners     if not a fan: also face_without_area, face_not_planar, face_crosses_itself
template <class T>
std::optional<CageFault> face_fault(const PolyhedralMesh<T>& mesh, std::size_t face);

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/cage/detail/check_faces.impl.hpp>
#endif

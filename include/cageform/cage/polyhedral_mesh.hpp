// The 3D cage whose faces are planar polygons: its data, point location, and its check.
#pragma once

#include <cageform/cage/detail/face_plane.hpp>
#include <cageform/cage/triangle_mesh.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A range of vertex loops that can be read by index: `faces[f]` has a size, and `faces[f][k]` is
/// an integer.
template <class F>
concept LoopRange = requires(const F& faces, std::size_t i) {
    { std::size(faces) } -> std::convertible_to<std::size_t>;
    { std::size(faces[i]) } -> std::convertible_to<std::size_t>;
    requires std::integral<std::remove_cvref_t<decltype(faces[i][i])>>;
};

/// A cage in space with planar faces. A face has any number of corners and may be non-convex; it is
/// one loop, counter-clockwise seen from outside. The surface equals that of `triangles()`, but the
/// boundary data on a face differs: it comes from coordinates in the face's plane (Joshi et al.,
/// Harmonic Coordinates for Character Articulation, sec. 4: every face solves the equation of its
/// own dimension). The weights therefore do not depend on how a face is triangulated.
///
/// Copies the vertices and faces. Construction never fails; `check` reports whether the mesh can
/// serve as a cage. Gaps are closed by triangles, as in a TriangleMesh. O(#corners log #corners),
/// and O(m²) for a face of m corners.
template <Scalar T>
class PolyhedralMesh {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 3;

    PolyhedralMesh() = default;

    /// `off_plane` limits how far a corner may lie off its face's plane, in units of the cage; 64
    /// roundings are always allowed. Weights on such a face reproduce the point's projection onto
    /// the plane, so their error is at most that distance.
    template <PointRange R, LoopRange F>
        requires(range_dimension<R> == 3)
    PolyhedralMesh(const R& vertices, const F& faces, T off_plane = 0)
        : off_plane_(double(off_plane))
        , status_(detail::guard_memory([&] { return fill(vertices, faces); })) {
        if (status_ != Status::ok) *this = PolyhedralMesh(status_);
    }

    /// Returns out_of_memory if vertices and faces did not fit in memory; the mesh is then empty.
    /// `check` reports it. (Copying throws, as copying a std::vector does.)
    Status status() const noexcept { return status_; }
    std::size_t size() const noexcept { return triangles_.size(); }
    std::span<const Vec<T, 3>> vertices() const noexcept { return triangles_.vertices(); }
    const Vec<T, 3>& operator[](std::size_t i) const noexcept { return triangles_[i]; }

    std::size_t face_count() const noexcept { return ends_.size(); }
    /// Returns the vertices of a face; no_vertex stands for an index out of range.
    std::span<const std::uint32_t> face(std::size_t f) const noexcept {
        const std::size_t begin = f == 0 ? 0 : ends_[f - 1];
        return {corners_.data() + begin, ends_[f] - begin};
    }
    /// Returns the surface as triangles: those of face 0, of face 1, …, then those that close gaps.
    const TriangleMesh<T>& triangles() const noexcept { return triangles_; }
    /// Returns the range [first, second) of a face's triangles; a face of m corners has m − 2.
    std::pair<std::size_t, std::size_t> triangles_of(std::size_t f) const noexcept {
        return {f == 0 ? 0 : triangle_ends_[f - 1], triangle_ends_[f]};
    }
    /// Returns the face of a triangle; face_count() for one that closes a gap.
    std::size_t face_of(std::size_t triangle) const noexcept {
        return std::size_t(std::upper_bound(triangle_ends_.begin(), triangle_ends_.end(), triangle) -
                           triangle_ends_.begin());
    }
    /// Returns how far a corner may lie off its face's plane.
    double off_plane() const noexcept { return off_plane_; }

private:
    explicit PolyhedralMesh(Status status) noexcept
        : status_(status) {}

    template <class R, class F>
    Status fill(const R& vertices, const F& faces) {
        std::vector<Vec<T, 3>> at;
        for (std::size_t i = 0; i < std::size(vertices); ++i) at.push_back(to_vec<T>(vertices[i]));
        std::vector<std::array<std::uint32_t, 3>> triangles;
        for (std::size_t f = 0; f < std::size(faces); ++f) {
            for (std::size_t k = 0; k < std::size(faces[f]); ++k) {
                const auto i = faces[f][k];
                const bool is_there = i >= 0 && std::uint64_t(i) < at.size();
                corners_.push_back(is_there ? std::uint32_t(i) : no_vertex);
            }
            ends_.push_back(corners_.size());
            cut(face(f), at, triangles);
            triangle_ends_.push_back(triangles.size());
        }
        triangles_ = TriangleMesh<T>(at, triangles);
        off_plane_ = std::fmax(off_plane_,
                               8 * double(coincidence_tolerance(bounds_of(std::span<const Vec<T, 3>>(at)))));
        return triangles_.status();
    }

    /// Triangulates a face and adds its triangles.
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
        const detail::PolygonCutter cutter(flat);
        for (const auto& [a, b, c] : cutter.triangles()) triangles.push_back({loop[a], loop[b], loop[c]});
    }

    std::vector<std::uint32_t> corners_;            ///< of all faces, one after the other
    std::vector<std::size_t> ends_, triangle_ends_; ///< where each face ends in corners_ and triangles
    TriangleMesh<T> triangles_;
    double off_plane_ = 0;
    Status status_ = Status::ok; // declared last: its initialiser fills the other members
};

/// Deduces the scalar from the points.
template <PointRange R, LoopRange F>
PolyhedralMesh(const R&, const F&) -> PolyhedralMesh<range_scalar_t<R>>;

/// Calls f(triangle) with arrays of vertices.
template <Scalar T, class F>
void for_each_facet(const PolyhedralMesh<T>& mesh, F&& f) {
    for_each_facet(mesh.triangles(), f);
}

/// Classifies a point; it is on the boundary if it lies within `tolerance` of a face. The mesh must be
/// sound. Usually O(log #corners).
template <Scalar T>
PointState locate(const PolyhedralMesh<T>& mesh, const Vec<T, 3>& p, T tolerance) noexcept {
    return locate(mesh.triangles(), p, tolerance);
}

/// Finds the nearest boundary point and returns the data of the triangle there. Coordinates replace
/// it by the data of the triangle's face (coordinates/detail/face_coordinates.hpp). Usually
/// O(log #corners).
template <Scalar T>
BoundaryValue<3> nearest_boundary_value(const PolyhedralMesh<T>& mesh, const Vec<T, 3>& p,
                                        Vec<T, 3>& position) noexcept {
    return nearest_boundary_value(mesh.triangles(), p, position);
}

/// Whether a mesh can serve as a cage. Every face must have at least three corners that exist, are
/// finite, lie in one plane (see off_plane) and form a simple polygon; the other conditions are
/// those of a TriangleMesh. Faults name faces by number. Costs as much as for a TriangleMesh, plus
/// O(m log m) for a face of m corners, O(m²) at worst.
template <class T>
CageReport check(const PolyhedralMesh<T>& mesh);

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/cage/detail/check_faces.impl.hpp>
#endif

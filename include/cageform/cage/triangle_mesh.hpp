// The 3D cage, a closed triangle mesh: its data, point location, and its check.
#pragma once

#include <cageform/cage/detail/encloses.hpp>
#include <cageform/cage/detail/mesh_face.hpp>
#include <cageform/cage/faces_of.hpp>
#include <cageform/cage/types/boundary_value.hpp>
#include <cageform/cage/types/report.hpp>
#include <cageform/core/types/buffer.hpp>
#include <cageform/core/view.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// A range of triangles: `faces[f][k]`, k = 0, 1, 2, is an integer.
template <class F>
concept FaceRange = requires(const F& faces, std::size_t i) {
    { std::size(faces) } -> std::convertible_to<std::size_t>;
    requires std::integral<std::remove_cvref_t<decltype(faces[i][i])>>;
};

/// A 3D cage: triangles over shared vertices, counter-clockwise seen from outside. The mesh may have any
/// genus and any number of components and cavities. Shells that are oriented inwards as a whole are
/// supported.
///
/// Copies the vertices and faces. Construction never fails; `check` reports whether the mesh is a valid
/// cage, and every coordinate type calls it.
///
/// Small gaps, at most a quarter of the area in total, are closed by triangles over the vertices around them.
/// `check` reports the edges of these gaps in warnings. Construction takes O(#F log #F) and, for a gap of n
/// edges, O(n min(n, 256)).
template <Scalar T>
class TriangleMesh {
public:
    using scalar = T;
    static constexpr std::size_t dimension = 3;
    using Face = std::array<std::uint32_t, 3>;

    TriangleMesh() = default;

    /// `faces[f][k]`, k = 0, 1, 2, is the index of a corner's vertex. Indices out of range are kept, and
    /// `check` reports them.
    template <PointRange R, FaceRange F>
        requires(range_dimension<R> == 3)
    TriangleMesh(const R& vertices, const F& faces)
        : status_(detail::guard_memory([&] { return fill(vertices, faces); })) {
        if (status_ != Status::ok) *this = TriangleMesh(status_);
    }

    /// Returns ok, or out_of_memory if the faces did not fit in memory. The mesh is then empty, and `check`
    /// reports this status. Copying may throw.
    Status status() const noexcept { return status_; }
    std::size_t size() const noexcept { return vertices_.size(); }
    std::span<const Vec<T, 3>> vertices() const noexcept { return vertices_; }
    const Vec<T, 3>& operator[](std::size_t i) const noexcept { return vertices_[i]; }
    /// Returns the given faces, then those that close gaps.
    std::span<const Face> faces() const noexcept { return faces_; }
    std::size_t given_faces() const noexcept { return given_; }
    /// Returns the bounding volume hierarchy of the faces; empty if a vertex is missing or not finite.
    const detail::BoxTree<3>& boxes() const noexcept { return boxes_; }

private:
    explicit TriangleMesh(Status status) noexcept
        : status_(status) {}

    template <class R, class F>
    Status fill(const R& vertices, const F& faces) {
        vertices_.reserve(std::size(vertices));
        for (std::size_t i = 0; i < std::size(vertices); ++i) vertices_.push_back(to_vec<T>(vertices[i]));
        faces_.reserve(std::size(faces));
        for (std::size_t f = 0; f < std::size(faces); ++f)
            faces_.push_back(detail::checked_face(faces[f], vertices_.size()));
        given_ = faces_.size();
        if (std::any_of(faces_.begin(), faces_.end(), detail::has_missing_vertex<3>)) return Status::ok;
        const auto closing = detail::closing_faces<T>(vertices_, faces_);
        faces_.insert(faces_.end(), closing.begin(), closing.end());
        if (std::all_of(vertices_.begin(), vertices_.end(), [](const auto& p) { return is_finite(p); }))
            boxes_ = detail::BoxTree<3>(faces_.size(), [&](std::uint32_t f) {
                return Facet<3>(faces_[f], this->vertices()).bounds();
            });
        return Status::ok;
    }

    std::vector<Vec<T, 3>> vertices_;
    std::vector<Face> faces_;
    std::size_t given_ = 0;
    detail::BoxTree<3> boxes_;   ///< of the faces
    Status status_ = Status::ok; // declared last: its initialiser fills the other members
};

template <PointRange R, FaceRange F>
TriangleMesh(const R&, const F&) -> TriangleMesh<range_scalar_t<R>>;

/// Calls f(face) with arrays of vertices.
template <Scalar T, class F>
void for_each_facet(const TriangleMesh<T>& mesh, F&& f) {
    for (const auto& face : mesh.faces()) f(face);
}

// ---- inside -------------------------------------------------------------------------------------

/// Returns the boundary data, linear on the faces, at the nearest boundary point, and stores that point in
/// `position`. `p` must be finite and the mesh valid. Usually O(log #F).
template <Scalar T>
BoundaryValue<3> nearest_boundary_value(const TriangleMesh<T>& mesh, const Vec<T, 3>& p,
                                        Vec<T, 3>& position) noexcept {
    const auto q = vec_cast<double>(p);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    double least = infinity;
    // With no_vertex, the first face is accepted even if its squared distance overflows to infinity.
    std::uint32_t nearest = no_vertex;
    BoundaryValue<3> value;
    mesh.boxes().for_each_near(q, infinity, [&](std::uint32_t f) {
        const Facet<3> facet(mesh.faces()[f], mesh.vertices());
        const auto weight = nearest_on_facet(q, facet.corner);
        const auto x = detail::point_on_facet(weight, facet.corner);
        const double distance2 = dot(x - q, x - q);
        if (distance2 < least || (distance2 == least && f < nearest)) {
            least = distance2;
            nearest = f;
            position = vec_cast<T>(x);
            value = value_on_facet(mesh.faces()[f], weight);
        }
        return least;
    });
    return value;
}

/// Classifies a point. It is on the boundary within `tolerance` of a face. Otherwise the point is inside if a
/// ray from it crosses an odd number of faces. So a cavity is outside, whatever its orientation is. The mesh
/// must be valid. Usually O(log #F).
template <Scalar T>
PointState locate(const TriangleMesh<T>& mesh, const Vec<T, 3>& p, T tolerance) noexcept {
    if (!is_finite(p)) return PointState::not_finite;
    if (mesh.boxes().is_empty()) return PointState::outside;
    Vec<T, 3> position;
    (void)nearest_boundary_value(mesh, p, position);
    const auto q = vec_cast<double>(p);
    if (detail::length(vec_cast<double>(position) - q) <= double(tolerance)) return PointState::on_boundary;
    return detail::encloses(mesh.boxes(), mesh.vertices(), mesh.faces(), q) ? PointState::inside
                                                                            : PointState::outside;
}

// ---- check --------------------------------------------------------------------------------------

/// Checks whether a mesh is a valid cage. There must be at least four vertices, all finite, and indices in
/// range. No two vertices may coincide (within coincidence_tolerance), and faces must have an area. Every
/// edge must have two faces, of consistent orientation, including faces that close a small gap. The faces
/// around a vertex must form one fan, no two faces may intersect, and shells must have a volume. Usually O(#F
/// log #F), O(#F²) at worst.
template <class T>
CageReport check(const TriangleMesh<T>& mesh);

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/cage/detail/check_mesh.impl.hpp>
#endif

// Green coordinates: deformations preserve angles. Handles are the vertices of a cage, and the
// normals of its edges or faces.
#pragma once

#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/coordinates/green/evaluation.hpp>
#include <cageform/coordinates/green/plane.hpp>
#include <cageform/coordinates/green/space.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// The cage is a Polygon in 2D, a TriangleMesh or a PolyhedralMesh in 3D.
template <Scalar T, std::size_t D, class Cage = std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>>
class GreenCoordinates;

/// Green coordinates in 2D, for any set of simple loops, holes included. By Green's third identity,
///
///   p = Σ φ_i C_i + Σ ψ_j n_j,   φ_i = ∫ Γ_i ∂G/∂n dσ,   ψ_j = −∫_edge j G dσ,   G = ln r / 2π
///
/// where Γ_i is the hat function of vertex i and n_j the outward unit normals. Lipman, Levin, Cohen-Or:
/// Green Coordinates (ACM Trans. Graph. 27, 2008). The formula in code: `integrate` in green/plane.hpp.
///
///   handles    the vertices, then the edges in the order of their start vertices, as normal vectors of
///              the edge's length (core/detail/face_handles.hpp). The weights are φ, then ψ_j over the
///              length. `pose_handles` makes a pose of all of them from a pose of the vertices; `clone`
///              refuses a pose of the vertices alone
///   range      the weights of the vertices sum to 1; positive inside a convex cage. Those of edges
///              have either sign. They depend on the unit of length in G, here the cage's diagonal:
///              another unit adds the same number to all of them, which moves nothing
///   poses      holomorphic inside, whatever the pose: angles are preserved where the derivative is not
///              zero. Similarities are reproduced, other affine maps and reflections are not
///   boundary   the limits from inside. They do not interpolate: a point on the cage's boundary does
///              not stay on it in a pose. In a corner of angle ω its vertex has the weight 1 − ω/2π
///   outside    continued analytically across the nearest edge; of two equally near edges, across the
///              one whose line the point lies farthest beyond. In a pose there are jumps where the
///              nearest edge changes: on the bisectors of convex corners, and on the medial axis in
///              notches
///   accuracy   double: 1e-14 (of the distance, far away), next to edges and vertices too;
///              float: 1e-5. Farther than 2^24 (2^12) diagonals the integrals are those at that
///              distance, which is below rounding
///   cost       O(#V) a point; a logarithm a vertex and an angle an edge for eight (sixteen) points.
///              Points outside and on the boundary also search all edges
///   gradients  as accurate and as fast as the weights. The first derivatives of weights of a pose
///              fulfil the Cauchy–Riemann equations to rounding
template <Scalar T>
class GreenCoordinates<T, 2> : public detail::GreenEvaluation<Polygon<T>> {
    using Base = detail::GreenEvaluation<Polygon<T>>;

public:
    explicit GreenCoordinates(Polygon<T> cage)
        : Base(std::move(cage)) {}

    template <PointRange R>
        requires(range_dimension<R> == 2)
    explicit GreenCoordinates(const R& vertices)
        : Base(Polygon<T>(vertices)) {}
    template <UnknownPointRange R>
    explicit GreenCoordinates(const R&, detail::PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    /// Uses only the loops of a cell complex: interior_cells_not_supported if there are cells inside.
    explicit GreenCoordinates(const CellComplex<T, 2>& cage)
        : Base(cage) {}
};

/// Green coordinates in 3D, for closed triangle meshes of any genus, cavities included. By Green's
/// third identity,
///
///   p = Σ φ_i C_i + Σ ψ_j n_j,   φ_i = ∫ Γ_i ∂G/∂n dσ,   ψ_j = −∫_face j G dσ,   G = −1/(4πr)
///
/// where Γ_i is the hat function of vertex i and n_j the outward unit normals. Lipman, Levin, Cohen-Or:
/// Green Coordinates (ACM Trans. Graph. 27, 2008). The formula in code: `integrate` in green/space.hpp.
///
///   handles    the vertices, then the faces in their order, as normals of length √area
///              (core/detail/face_handles.hpp). The weights are φ, then ψ_j over that length.
///              `pose_handles` makes a pose of all of them from a pose of the vertices; `clone` refuses
///              a pose of the vertices alone. Vertices so large that a normal overflows are faults of
///              the cage, vertex_not_finite
///   range      the weights of the vertices sum to 1; positive inside a convex cage. Those of faces
///              are positive inside
///   poses      nearly conformal inside. Similarities are reproduced, other affine maps and
///              reflections are not
///   boundary   the limits from inside. They do not interpolate: a point on the cage's boundary does
///              not stay on it in a pose. In a corner of solid angle ω its vertex has the weight
///              1 − ω/4π
///   outside    continued analytically across the nearest face; of several equally near faces, across
///              the one whose plane the point lies farthest beyond. In a pose there are jumps where the
///              nearest face changes: on the bisectors of convex edges, and on the medial axis in
///              notches
///   accuracy   double: 1e-14 (of the distance, far away), next to faces, edges and vertices too;
///              float: 1e-5. The weights of a face of height h at distance d lose a factor d/h of that,
///              as in the rim of a thin plate; `bind` then restores linear precision. Farther than
///              2^24 (2^12) diagonals the integrals are those at that distance, which is below rounding
///   cost       O(#E + #F) a point; a root a vertex, a logarithm an edge and three angles a face for
///              eight (sixteen) points. Points outside and on the boundary also search all faces
///   gradients  as accurate and as fast as the weights
template <Scalar T>
class GreenCoordinates<T, 3> : public detail::GreenEvaluation<TriangleMesh<T>> {
    using Base = detail::GreenEvaluation<TriangleMesh<T>>;

public:
    explicit GreenCoordinates(TriangleMesh<T> cage)
        : Base(std::move(cage)) {}

    /// Makes the mesh from the arguments of a TriangleMesh.
    template <PointRange R, FaceRange F>
        requires(range_dimension<R> == 3)
    GreenCoordinates(const R& vertices, const F& faces)
        : Base(TriangleMesh<T>(vertices, faces)) {}
    template <UnknownPointRange R, FaceRange F>
    GreenCoordinates(const R&, const F&, detail::PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    /// Uses only the shells of a cell complex: interior_cells_not_supported if there are cells inside.
    explicit GreenCoordinates(const CellComplex<T, 3>& cage)
        : Base(cage) {}
};

/// Green coordinates for polyhedral meshes: those of `triangles()`, with the weights of means passed on to
/// the corners. Fans have a vector for each of their triangles; `pose_handles` computes the means of posed
/// faces. One vector for a whole face would restore points on planar faces only. A planar face that is no
/// fan is cut into triangles, and weights depend on the cut.
///
///   handles   the vertices, then the triangles in the order of the faces
///   fails     divisions_not_supported too, if faces are divided
template <Scalar T>
class GreenCoordinates<T, 3, PolyhedralMesh<T>> : public detail::GreenEvaluation<PolyhedralMesh<T>> {
    using Base = detail::GreenEvaluation<PolyhedralMesh<T>>;

public:
    explicit GreenCoordinates(PolyhedralMesh<T> cage)
        : Base(std::move(cage)) {}
};

// `GreenCoordinates coordinates(cage)` deduces the scalar and the dimension.
template <Scalar T>
GreenCoordinates(Polygon<T>) -> GreenCoordinates<T, 2>;
template <Scalar T>
GreenCoordinates(TriangleMesh<T>) -> GreenCoordinates<T, 3>;
template <Scalar T>
GreenCoordinates(PolyhedralMesh<T>) -> GreenCoordinates<T, 3, PolyhedralMesh<T>>;
template <Scalar T, std::size_t D>
GreenCoordinates(CellComplex<T, D>) -> GreenCoordinates<T, D>;
template <PointRangeIn<2> R>
GreenCoordinates(const R&) -> GreenCoordinates<range_scalar_t<R>, 2>;
template <PointRangeIn<3> R, FaceRange F>
GreenCoordinates(const R&, const F&) -> GreenCoordinates<range_scalar_t<R>, 3>;

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/coordinates/green/evaluation.impl.hpp>
#endif

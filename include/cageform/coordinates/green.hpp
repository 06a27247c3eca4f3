// Green coordinates: deformations preserve angles. Handles are the vertices of a cage, and the
// normals of its edges or faces.
#pragma once

#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/coordinates/green/evaluation.hpp>
#include <cageform/coordinates/green/plane.hpp>
#include <cageform/coordinates/green/space.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Green coordinates of a Polygon, with any set of simple loops, holes included; or of a TriangleMesh or
/// PolyhedralMesh, closed, of any genus, cavities included. By Green's third identity,
///
///   p = Σ φ_i C_i + Σ ψ_j n_j,   φ_i = ∫ Γ_i ∂G/∂n dσ,   ψ_j = −∫_facet j G dσ
///   2D: facets are edges, G = ln r / 2π;   3D: facets are triangles, G = −1/(4πr)
///
/// where Γ_i is the hat function of vertex i and n_j the outward unit normals. Lipman, Levin, Cohen-Or:
/// Green Coordinates (ACM Trans. Graph. 27, 2008). The formulas in code: `integrate` in green/plane.hpp and
/// green/space.hpp. Constructors take the cage; what its constructor takes, such as vertices and faces; or a
/// cell complex without cells inside (detail/checked_cage.hpp).
///
///   handles    the vertices, then the facets as normal vectors: edges in the order of their start vertices
///              with the edge's length, faces with the length √area (core/detail/face_handles.hpp). The
///              weights are φ, then ψ_j over that length. `pose_handles` makes a pose of all of them from
///              a pose of the vertices; `clone` refuses a pose of the vertices alone. Vertices so large
///              that a normal overflows are faults of the cage, vertex_not_finite
///   range      the weights of the vertices sum to 1; positive inside a convex cage. Those of faces are
///              positive inside. Those of edges have either sign and depend on the unit of length in G,
///              here the cage's diagonal: another unit adds the same number to all, which moves nothing
///   poses      2D: holomorphic inside, whatever the pose: angles are preserved where the derivative is
///              not zero. 3D: nearly conformal inside. Similarities are reproduced, other affine maps and
///              reflections are not
///   boundary   the limits from inside. They do not interpolate: a point on the cage's boundary does
///              not stay on it in a pose. In a corner of angle ω its vertex has the weight 1 − ω/2π; of
///              solid angle ω, 1 − ω/4π
///   outside    continued analytically across the nearest facet; of several equally near facets, across
///              the one whose line or plane the point lies farthest beyond. In a pose there are jumps where
///              the nearest facet changes: on the bisectors of convex corners and edges, and on the medial
///              axis in notches
///   accuracy   double: 1e-14 (of the distance, far away), next to facets and vertices too; float: 1e-5.
///              3D: the weights of a face of height h at distance d lose a factor d/h of that, as in the
///              rim of a thin plate; `bind` then restores linear precision. Farther than 2^24 (2^12)
///              diagonals the integrals are those at that distance, which is below rounding
///   cost       O(#V) or O(#E + #F) a point. 2D: a logarithm a vertex and an angle an edge for eight
///              (sixteen) points. 3D: a root a vertex, a logarithm an edge and three angles a face. Points
///              outside and on the boundary also search all facets
///   gradients  as accurate and as fast as the weights. In 2D the first derivatives of weights of a pose
///              fulfil the Cauchy–Riemann equations to rounding
///
/// A PolyhedralMesh has the weights of its `triangles()`. Those of means are passed on to the corners. Fans
/// have a vector for each of their triangles; `pose_handles` computes the means of posed faces. One vector
/// for a whole face would restore points on planar faces only. A planar face that is no fan is cut into
/// triangles, and weights depend on the cut.
///
///   handles   the vertices, then the triangles in the order of the faces
///   fails     divisions_not_supported too, if faces are divided
template <Scalar T, std::size_t D, class Cage = std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>>
class GreenCoordinates : public detail::GreenEvaluation<Cage> {
public:
    using detail::GreenEvaluation<Cage>::GreenEvaluation;
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

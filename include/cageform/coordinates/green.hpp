// Green coordinates: deformations preserve angles. Handles are vertices and normals of edges or faces.
#pragma once

#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/coordinates/green/evaluation.hpp>
#include <cageform/coordinates/green/plane.hpp>
#include <cageform/coordinates/green/space.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Green coordinates of a Polygon with any set of simple loops, or of a closed TriangleMesh or PolyhedralMesh
/// of any genus; holes and cavities are supported. By Green's third identity,
///
///   p = Σ φ_i C_i + Σ ψ_j n_j,   φ_i = ∫ Γ_i ∂G/∂n dσ,   ψ_j = −∫_facet j G dσ
///   2D: facets are edges, G = ln r / 2π;   3D: facets are triangles, G = −1/(4πr)
///
/// where Γ_i is the hat function of vertex i and n_j the outward unit normal of facet j. Lipman, Levin,
/// Cohen-Or: Green Coordinates (ACM Trans. Graph. 27, 2008). The formulas are in `integrate` of
/// green/plane.hpp and green/space.hpp. Constructors take the cage, the arguments of its constructor, or a
/// cell complex without interior cells (detail/checked_cage.hpp).
///
///   handles    the vertices, then the facets as normal vectors: edges in the order of their start vertices,
///              with the edge's length; faces with the length √area (core/detail/face_handles.hpp). The
///              weights are φ, then ψ_j divided by that length. `pose_handles` computes the vectors of a
///              pose; `clone` refuses a pose of the vertices alone. A normal that overflows is the fault
///              vertex_not_finite
///   range      the weights of vertices sum to 1, and are positive inside a convex cage. Weights of faces are
///              positive inside. Weights of edges have both signs. They depend on the unit of length in G,
///              here the cage's diagonal: another unit adds a constant to all of them, which does not change
///              the result
///   poses      2D: holomorphic inside for every pose: angles are preserved where the derivative is not zero.
///              3D: nearly conformal inside. Similarities are reproduced; other affine maps and reflections
///              are not
///   boundary   the limits from inside. They do not interpolate: boundary points leave the boundary in a
///              pose. At a corner of angle ω, the vertex has the weight 1 − ω/2π; of solid angle ω, 1 − ω/4π
///   outside    continued analytically across the nearest facet. Of facets at the same distance, across the
///              one whose line or plane the point lies farthest beyond. Posed figures jump where the nearest
///              facet changes: on bisectors of convex corners and edges, and on the medial axis in notches
///   accuracy   double: 1e-14 (relative to the distance, far away), also next to facets and vertices; float:
///              1e-5. 3D: at distance d from a face of height h the errors are d/h times larger, as in the
///              rim of a thin plate; `bind` then restores linear precision. Farther than 2^24 (float: 2^12)
///              diagonals, the integrals at that distance are used; this changes less than rounding
///   cost       2D: O(#V) a point; a logarithm per vertex and an angle per edge for 8 (float: 16) points.
///              3D: O(#E + #F); a root per vertex, a logarithm per edge and three angles per face. Points
///              outside and on the boundary also search all facets
///   gradients  as accurate and as fast as the weights. In 2D the derivatives of a pose satisfy the
///              Cauchy–Riemann equations to rounding
///
/// A PolyhedralMesh has the weights of its `triangles()`. The weight of a fan's mean is distributed to the
/// corners. A fan has one vector handle per triangle: one vector per face would reproduce points only if the
/// face is planar. A planar face without a mean is triangulated, and weights depend on the triangulation.
///
///   handles   the vertices, then the triangles in the order of the faces
///   fails     also divisions_not_supported if faces are divided
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

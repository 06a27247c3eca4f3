// Mean value coordinates: a smooth closed form, defined everywhere, not always positive.
#pragma once

#include <cageform/coordinates/mean_value/evaluation.hpp>
#include <cageform/coordinates/mean_value/plane.hpp>
#include <cageform/coordinates/mean_value/polygons.hpp>
#include <cageform/coordinates/mean_value/space.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Mean value coordinates of a Polygon with any set of simple loops, or of a closed TriangleMesh or
/// PolyhedralMesh of any shape; holes and cavities are supported. Constructors take the cage, the arguments
/// of its constructor, or a cell complex without interior cells (detail/checked_cage.hpp).
///
/// In 2D:
///
///   w_i = (tan(α_{i−1}/2) + tan(α_i/2)) / |C_i − p|,  m_i = w_i / Σ w,
///   α_i the signed angle C_i p C_{i+1}
///
/// Floater, Mean value coordinates (CAGD 20, 2003), eq. (2.1). Several loops and points outside: Hormann &
/// Floater, Mean value coordinates for arbitrary planar polygons (ACM TOG 25, 2006), sec. 3 and 4. Code:
/// `compute_weights` in mean_value/plane.hpp.
///
/// In 3D: Ju, Schaefer, Warren, Mean value coordinates for closed triangular meshes (SIGGRAPH 2005), sec. 3.
/// A face gives its corners weights w_k with Σ w_k (C_k − p) = m, where m is the integral of the unit vectors
/// from p over the face's projection to the unit sphere. m = ½ Σ θ_e N_e over the edges of the face: θ_e is
/// the angle that the edge subtends at p, N_e the unit normal of the plane through p and the edge. We compute
/// m in the face's own frame. H is the height of the face's plane above p, and h_k the altitude of corner k.
/// ν_k is the outward normal, in the plane, of the edge opposite to corner k. ρ_k is the signed distance of
/// p's foot from that edge (positive inside). R_e is the distance of p from the line of edge e. With
/// g_e = θ_e/R_e:
///
///   S = ½ Σ g_k ρ_k / H,   w_k = (S ρ_k + ½ H Σ_l g_l ν_k·ν_l) / h_k
///
/// Each g is computed once per edge. Only S cancels: next to the plane of a face, but not over the face.
/// There `sum_beside_face` computes S. Code: `compute_weights` and `face_weights` in mean_value/space.hpp.
///
///   boundary   the limits: the unit row on vertices, barycentric weights on edges and triangles
///   range      sum to 1; may be negative outside, and where the cage is not convex
///   smooth     C^∞ everywhere, also across edges (2D) and faces (3D); C⁰ at vertices, in 3D also at edges
///   accuracy   2D: a few roundings inside and near the cage. 3D: 1e-13 inside and near the cage (double); at
///              worst 1e-4 (float). Far away the unnormalised weights grow like the distance and cancel.
///              Points farther than 64 to 128 diagonals (3D: 16 to 32) are therefore computed in the next
///              wider scalar: always for float, for double where long double is wider
///   cost       2D: O(#V) a point; a division and a square root per vertex for 8 (float: 16) points.
///              3D: O(#E + #F); a square root and an angle per edge, a division per face
///   gradients  Errors in 2D (double): at most 1e-11 of the largest gradient or of 1/diagonal (measured:
///              3e-12). In 3D (double), in and near the cage: at most 1e-9 of 1/diagonal (measured: 2e-10).
///              Float: the rounding to float. Σ ∇w_i = 0 and Σ C_i ∇w_i = identity hold with the same errors,
///              in 3D with larger ones far away. Within 1e-6 diagonals of a vertex (3D: of an edge),
///              gradients depend on the direction: one of the limits is returned. Cost: 3 to 4 times that of
///              weights in double, in 3D twice (float: five times, because gradients are computed in double).
///              A point on the boundary, within 1e-5 diagonals of the boundary (double), or farther than 2 to
///              4 diagonals costs tens of times as much (3D: hundreds)
///
/// A PolyhedralMesh of triangles has the weights of the TriangleMesh. On a face with more corners, the sum of
/// its triangles' weights is distributed to the corners by mean value coordinates in the face's plane
/// (`distribute` in mean_value/polygons.hpp). The weights do not depend on the triangulation of the face, and
/// on the face they are the 2D weights. On a fan (PolyhedralOptions) the weight of the mean is distributed to
/// the corners.
///
///   accuracy   as above. Around faces that are not convex, the weights have a kink at some points inside or
///              outside, like 2D mean value coordinates on edges
///   cost       that of the triangles, and O(#corners) for all faces of more than three corners
template <Scalar T, std::size_t D, class Cage = std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>>
class MeanValueCoordinates : public detail::MeanValueEvaluation<Cage> {
public:
    using detail::MeanValueEvaluation<Cage>::MeanValueEvaluation;
};

// `MeanValueCoordinates coordinates(cage)` deduces the scalar and the dimension.
template <Scalar T>
MeanValueCoordinates(Polygon<T>) -> MeanValueCoordinates<T, 2>;
template <Scalar T>
MeanValueCoordinates(TriangleMesh<T>) -> MeanValueCoordinates<T, 3>;
template <Scalar T>
MeanValueCoordinates(PolyhedralMesh<T>) -> MeanValueCoordinates<T, 3, PolyhedralMesh<T>>;
template <Scalar T, std::size_t D>
MeanValueCoordinates(CellComplex<T, D>) -> MeanValueCoordinates<T, D>;
template <PointRangeIn<2> R>
MeanValueCoordinates(const R&) -> MeanValueCoordinates<range_scalar_t<R>, 2>;
template <PointRangeIn<3> R, FaceRange F>
MeanValueCoordinates(const R&, const F&) -> MeanValueCoordinates<range_scalar_t<R>, 3>;

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/coordinates/mean_value/evaluation.impl.hpp>
#endif

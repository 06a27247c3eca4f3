// Mean value coordinates: a closed form, smooth, defined in all of 2D or 3D space, negative in places.
#pragma once

#include <cageform/coordinates/mean_value/evaluation.hpp>
#include <cageform/coordinates/mean_value/plane.hpp>
#include <cageform/coordinates/mean_value/polygons.hpp>
#include <cageform/coordinates/mean_value/space.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Mean value coordinates of a Polygon, with any set of simple loops, holes included; or of a TriangleMesh
/// or PolyhedralMesh, closed, of any shape. Constructors take the cage; what its constructor takes, such as
/// vertices and faces; or a cell complex without cells inside (detail/checked_cage.hpp).
///
/// In 2D:
///
///   w_i = (tan(α_{i−1}/2) + tan(α_i/2)) / |C_i − p|,  m_i = w_i / Σ w,
///   α_i the signed angle C_i p C_{i+1}
///
/// Floater, Mean value coordinates (CAGD 20, 2003), eq. (2.1). Several loops and points outside:
/// Hormann & Floater, Mean value coordinates for arbitrary planar polygons (ACM TOG 25, 2006), sec.
/// 3 and 4. The formula in code: `weigh` in mean_value/plane.hpp.
///
/// In 3D: Ju, Schaefer, Warren, Mean value coordinates for closed triangular meshes (SIGGRAPH 2005), sec.
/// 3: a face gives its corners weights w_k with Σ w_k (C_k − p) = m. Here m is the integral of the
/// unit vectors from p over the face's projection to the unit sphere, m = ½ Σ θ_e N_e over its
/// edges, with θ_e the angle that the edge subtends at p and N_e the unit normal of the plane
/// through p and the edge. This implementation computes m in the face's own frame. Let H be the
/// height of the face's plane above p, ρ_k the distance of p's foot point to the edge opposite to
/// corner k (positive inside), R_e the distance of p to the edge's line, g_e = θ_e/R_e, h_k the
/// altitude of corner k, and ν_k the outward normal, in the plane, of the edge opposite to it:
///
///   S = ½ Σ g_k ρ_k / H,   w_k = (S ρ_k + ½ H Σ_l g_l ν_k·ν_l) / h_k
///
/// This needs g once per edge. The only difference of nearly equal numbers is S, next to the plane
/// of a face that p is not over; there S is computed from differences of angles
/// (`sum_beside_face`). The formula in code: `weigh` and `face_weights` in mean_value/space.hpp.
///
///   boundary   the limits: the unit row on vertices, barycentric weights on edges and triangles
///   range      sum to 1; may be negative where the cage is not convex, and outside
///   smooth     C^∞ everywhere, also across edges (2D) and faces (3D); C⁰ at vertices, in 3D at edges too
///   accuracy   2D: a few roundings inside and near the cage. Far away the true weights grow like the
///              distance and cancel, so points farther than some hundred diagonals are computed one
///              precision higher, where the platform has one (float always; double where long
///              double is wider). 3D: 1e-13 inside and near the cage (double), 1e-4 at worst for float;
///              the higher precision begins at some diagonals
///   cost       2D: O(#V) a point; one division and one square root per vertex and eight (sixteen)
///              points. 3D: O(#E + #F); a square root and an angle an edge, a division a face
///   gradients  double: errors of at most 1e-11 of the largest, or of one over the diagonal (2D, 3e-12
///              measured), or 1e-9 of one over the diagonal in and next to the cage (3D, 2e-10 measured);
///              float: the rounding to float. Σ ∇w_i = 0 and Σ C_i ∇w_i = identity hold as exactly, in 3D
///              less so far away. Closer to a vertex, in 3D to an edge, than 1e-6 diagonals they depend on
///              the direction; there those of one direction are returned. They take three to four times as
///              long as double weights, in 3D twice (float: five times, as they are computed in double).
///              A point takes tens of times as long, in 3D hundreds, on the boundary, closer to it than
///              1e-5 diagonals (double), or some diagonals away
///
/// A PolyhedralMesh of triangles has the weights of the TriangleMesh. A face with more corners distributes
/// the sum of its triangles' weights over its corners, by mean value coordinates in its plane (`share_out`
/// in mean_value/polygons.hpp). The weights therefore do not depend on the triangulation of a face, and on
/// the face they are the 2D weights. A face that is a fan (PolyhedralOptions) passes the weight of its mean
/// on to its corners.
///
///   accuracy   as above. Around faces that are not convex there are points, inside or outside, where
///              the weights have a kink (2D mean value coordinates have one on edges)
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

// Mean value coordinates in space, for closed triangle meshes.
#pragma once

#include <cageform/coordinates/detail/mean_value_space.hpp>
#include <cageform/coordinates/mean_value.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Mean value coordinates in space, for closed triangle meshes of any shape.
///
/// Ju, Schaefer, Warren, Mean value coordinates for closed triangular meshes (SIGGRAPH 2005), sec.
/// 3: a face gives its corners the weights w_k with Σ w_k (C_k − p) = m, m the integral of the unit
/// vectors from p over the face's shadow on the unit sphere; m = ½ Σ θ_e N_e over its edges, θ_e
/// the angle an edge is seen under, N_e the unit normal of the plane through p and it. Here m is
/// taken in the face's own frame. With H the height of the face's plane above p, ρ_k the distance
/// of p's foot point to the edge opposite to corner k (positive inside), R_e the distance of p to
/// the edge's line, g_e = θ_e/R_e, h_k the altitude of corner k and ν_k the outward normal of the
/// edge opposite to it, in the plane:
///
///   S = ½ Σ g_k ρ_k / H,   w_k = (S ρ_k + ½ H Σ_l g_l ν_k·ν_l) / h_k
///
/// which needs g only once an edge, and holds no difference of nearly equal numbers but S next to
/// the plane of a face that p is not over; there the sum is taken by the angles' differences
/// (`sum_beside_face`). On vertices, edges and faces the limits are taken: barycentric weights. The
/// formula in code: `weigh` and `face_weights` in detail/mean_value_space.hpp.
///
///   range      sum to 1; may be negative where the cage is not convex, and outside
///   accuracy   1e-13 inside and near the cage (double), 1e-4 at worst for float; points farther
///              than some diagonals are computed one precision higher, where the platform has one
///   cost       O(#E + #F) a point: a square root and an angle an edge, a division a face, eight
///              (sixteen) points together
///   gradients  double: 1e-9 of one over the diagonal in and next to the cage (2e-10 measured);
///              float: that of rounding them. Σ ∇w_i = 0 and Σ C_i ∇w_i = identity likewise; less
///              far away. Nearer to an edge or vertex than 1e-6 diagonals they turn with the
///              direction, on it they are those of one. They take twice as long as weights (float:
///              five times, as they are computed in double); hundreds of times for a point on the
///              boundary, nearer to it than 1e-5 diagonals (double), or some diagonals away
template <Scalar T>
class MeanValueCoordinates<T, 3> : public detail::MeanValueEvaluation<TriangleMesh<T>> {
    using Base = detail::MeanValueEvaluation<TriangleMesh<T>>;

public:
    explicit MeanValueCoordinates(TriangleMesh<T> cage)
        : Base(std::move(cage)) {}

    /// From what a TriangleMesh is made of.
    template <PointRange R, FaceRange F>
        requires(range_dimension<R> == 3)
    MeanValueCoordinates(const R& vertices, const F& faces)
        : Base(TriangleMesh<T>(vertices, faces)) {}
    template <UnknownPointRange R, FaceRange F>
    MeanValueCoordinates(const R&, const F&, detail::PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    /// Shells alone: interior_cells_not_supported where there are cells inside.
    explicit MeanValueCoordinates(const CellComplex<T, 3>& cage)
        : Base(cage) {}
};

using MeanValueCoordinates3f = MeanValueCoordinates<float, 3>;
using MeanValueCoordinates3d = MeanValueCoordinates<double, 3>;

} // namespace cageform::inline CAGEFORM_ABI

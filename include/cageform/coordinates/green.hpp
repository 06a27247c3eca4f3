// Green coordinates: poses keep angles. Handles are the vertices of a cage, and the normals of its
// edges or faces.
#pragma once

#include <cageform/coordinates/detail/green_evaluation.hpp>
#include <cageform/coordinates/detail/green_plane.hpp>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T, std::size_t D>
class GreenCoordinates;

/// Green coordinates in the plane, for any set of simple loops, holes included: by Green's third
/// identity,
///
///   p = Σ φ_i C_i + Σ ψ_j n_j,   φ_i = ∫ Γ_i ∂G/∂n dσ,   ψ_j = −∫_edge j G dσ,   G = ln r / 2π
///
/// with Γ_i the hat function of vertex i and n_j the outward unit normals. Lipman, Levin, Cohen-Or:
/// Green Coordinates (ACM Trans. Graph. 27, 2008). The formula in code: `integrate` in
/// detail/green_plane.hpp.
///
///   handles    the vertices, then the edges in the order of the vertices they begin at, as vectors
///              of their length (core/face_handles.hpp); weights φ, then ψ_j over the length.
///              `pose_handles` makes a pose of all of them from one of the vertices. A pose of
///              the vertices alone is refused by `clone`
///   range      the weights of the vertices sum to 1; positive inside a convex cage. Those of edges
///              have either sign, and go with the unit of length in G, the cage's diagonal: another
///              one changes all of them by one number, which moves nothing
///   poses      holomorphic inside, whatever the pose: angles are kept where the derivative is not
///              zero. Similarities are reproduced, other affine maps and reflections are not
///   boundary   the limits from inside. They do not interpolate: a point bound there leaves the posed
///              cage's boundary. In the corner of angle ω a vertex has the weight 1 − ω/2π
///   outside    continued across the nearest edge, of two equally near the one whose line the point
///              lies farthest beyond: analytic there, with jumps, in a pose, where the nearest edge
///              changes: on the bisectors of convex corners, and on the medial axis in notches
///   accuracy   double: 1e-14 (of the distance, far away), next to edges and vertices too;
///              float: 1e-5. Farther than 2^24 (2^12) diagonals the integrals are those at that
///              distance, which is below rounding
///   cost       O(#V) a point; a logarithm a vertex and an angle an edge for eight (sixteen) points.
///              Points outside and on the boundary a search through the edges more
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

    /// Loops alone: interior_cells_not_supported where there are cells inside.
    explicit GreenCoordinates(const CellComplex<T, 2>& cage)
        : Base(cage) {}
};

using GreenCoordinates2f = GreenCoordinates<float, 2>;
using GreenCoordinates2d = GreenCoordinates<double, 2>;

} // namespace cageform::inline CAGEFORM_ABI

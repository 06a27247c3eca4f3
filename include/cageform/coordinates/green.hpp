// Green coordinates: poses keep angles. Handles are the vertices of a cage, and the normals of its
// edges or faces.
#pragma once

#include <cageform/coordinates/green/evaluation.hpp>
#include <cageform/coordinates/green/plane.hpp>
#include <cageform/coordinates/green/space.hpp>

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
/// green/plane.hpp.
///
///   handles    the vertices, then the edges in the order of the vertices they begin at, as vectors
///              of their length (core/detail/face_handles.hpp); weights φ, then ψ_j over the length.
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

/// Green coordinates in space, for closed triangle meshes of any genus, cavities included: by
/// Green's third identity,
///
///   p = Σ φ_i C_i + Σ ψ_j n_j,   φ_i = ∫ Γ_i ∂G/∂n dσ,   ψ_j = −∫_face j G dσ,   G = −1/(4πr)
///
/// with Γ_i the hat function of vertex i and n_j the outward unit normals. Lipman, Levin, Cohen-Or:
/// Green Coordinates (ACM Trans. Graph. 27, 2008). The formula in code: `integrate` in
/// green/space.hpp.
///
///   handles    the vertices, then the faces in their order, as normals of the length √area
///              (core/detail/face_handles.hpp); weights φ, then ψ_j over that length. `pose_handles` makes
///              a pose of all of them from one of the vertices. A pose of the vertices alone is
///              refused by `clone`. Vertices so large that a normal overflows are faults of the cage,
///              vertex_not_finite
///   range      the weights of the vertices sum to 1; positive inside a convex cage. Those of faces
///              are positive inside
///   poses      nearly conformal inside. Similarities are reproduced, other affine maps and
///              reflections are not
///   boundary   the limits from inside. They do not interpolate: a point bound there leaves the posed
///              cage's boundary. In the corner of solid angle ω a vertex has the weight 1 − ω/4π
///   outside    continued across the nearest face, of those equally near the one whose plane the
///              point lies farthest beyond: analytic there, with jumps, in a pose, where the nearest
///              face changes: on the bisectors of convex edges, and on the medial axis in notches
///   accuracy   double: 1e-14 (of the distance, far away), next to faces, edges and vertices too;
///              float: 1e-5. The weights of a face h high that is d away lose d/h of that, as in
///              the rim of a thin plate; linear precision is what `bind` then restores. Farther
///              than 2^24 (2^12) diagonals the integrals are those at that distance, which is
///              below rounding
///   cost       O(#E + #F) a point; a root a vertex, a logarithm an edge and three angles a face for
///              eight (sixteen) points. Points outside and on the boundary a search through the
///              faces more
///   gradients  as accurate and as fast as the weights
template <Scalar T>
class GreenCoordinates<T, 3> : public detail::GreenEvaluation<TriangleMesh<T>> {
    using Base = detail::GreenEvaluation<TriangleMesh<T>>;

public:
    explicit GreenCoordinates(TriangleMesh<T> cage)
        : Base(std::move(cage)) {}

    /// From what a TriangleMesh is made of.
    template <PointRange R, FaceRange F>
        requires(range_dimension<R> == 3)
    GreenCoordinates(const R& vertices, const F& faces)
        : Base(TriangleMesh<T>(vertices, faces)) {}
    template <UnknownPointRange R, FaceRange F>
    GreenCoordinates(const R&, const F&, detail::PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    /// Shells alone: interior_cells_not_supported where there are cells inside.
    explicit GreenCoordinates(const CellComplex<T, 3>& cage)
        : Base(cage) {}
};

using GreenCoordinates3f = GreenCoordinates<float, 3>;
using GreenCoordinates3d = GreenCoordinates<double, 3>;

} // namespace cageform::inline CAGEFORM_ABI

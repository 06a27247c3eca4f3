// Maximum entropy coordinates: never negative, without a solve on a grid, in the plane and in space.
#pragma once

#include <cageform/coordinates/entropy/evaluation.hpp>
#include <cageform/coordinates/mean_value.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Maximum entropy coordinates of a Polygon with any set of simple loops, or of a closed TriangleMesh or
/// PolyhedralMesh of any shape; holes and cavities are supported. The weights minimise
///
///   Σ w_k ln(w_k/q_k)   with Σ w_k = 1, Σ w_k (C_k − p) = 0, and a positive prior q
///
/// (Sukumar, Construction of polygonal interpolants: a maximum entropy approach, IJNME 61, 2004; Hormann,
/// Sukumar, Maximum entropy coordinates for arbitrary polytopes, SGP 2008). They are
///
///   w_k = q_k e^(−λ·(C_k − p)) / Σ q e^(−λ·(C − p))
///
/// with a multiplier λ of D numbers per point, found by Newton's method with a guaranteed descent. Our prior
/// is a weighted sum of mean value weights over the facets that face the point (entropy/facing.hpp). The
/// published priors are EntropyPrior::mec1 and mec2. Both are for the plane only: in space they depend on
/// the unit of length.
///
///   boundary   hat functions on edges and triangles; the unit row on vertices
///   range      [0, 1], Σ w = 1. A vertex has weight 0 if none of its facets faces the point
///   smooth     C^∞ inside, except in the planes of facets: there slopes change like the root of the
///              distance. With mec1, mec2 C^∞ everywhere inside.
///   outside    undefined, also in holes and cavities
///   accuracy   1e-14 in double, 1e-5 in float, also next to the boundary
///   cost       12 times that of mean value coordinates in the plane, 3.4 times in space (`bench_bind`). In
///              space 4 to 6 passes over the vertices, rarely 20 (`bench_published`)
///   gradients  computed in double, to 1e-11 of the largest; those on the boundary are taken 1e-6 diagonals
///              inside
///   fails      as the cage's check
///
/// A face of a PolyhedralMesh is a fan or is cut into triangles, and the weights depend on the triangles.
template <Scalar T, std::size_t D, class Cage = std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>>
class MaximumEntropyCoordinates : public detail::EntropyEvaluation<Cage> {
public:
    using detail::EntropyEvaluation<Cage>::EntropyEvaluation;
};

// `MaximumEntropyCoordinates coordinates(cage)` deduces the scalar and the dimension.
template <Scalar T>
MaximumEntropyCoordinates(Polygon<T>, EntropyPrior = {}) -> MaximumEntropyCoordinates<T, 2>;
template <Scalar T>
MaximumEntropyCoordinates(TriangleMesh<T>) -> MaximumEntropyCoordinates<T, 3>;
template <Scalar T>
MaximumEntropyCoordinates(PolyhedralMesh<T>) -> MaximumEntropyCoordinates<T, 3, PolyhedralMesh<T>>;
template <Scalar T, std::size_t D>
MaximumEntropyCoordinates(CellComplex<T, D>, EntropyPrior = {}) -> MaximumEntropyCoordinates<T, D>;
template <PointRangeIn<2> R>
MaximumEntropyCoordinates(const R&, EntropyPrior = {}) -> MaximumEntropyCoordinates<range_scalar_t<R>, 2>;
template <PointRangeIn<3> R, FaceRange F>
MaximumEntropyCoordinates(const R&, const F&) -> MaximumEntropyCoordinates<range_scalar_t<R>, 3>;

} // namespace cageform::inline CAGEFORM_ABI

#if !defined(CAGEFORM_COMPILED)
#include <cageform/coordinates/entropy/evaluation.impl.hpp>
#endif

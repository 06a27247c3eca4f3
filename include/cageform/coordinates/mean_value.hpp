// Mean value coordinates: a closed form for the whole plane, smooth, negative in places.
#pragma once

#include <cageform/coordinates/detail/mean_value_evaluation.hpp>
#include <cageform/coordinates/detail/mean_value_plane.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// Of a Polygon in the plane; in space of a TriangleMesh (coordinates/mean_value_3d.hpp) or a
/// PolyhedralMesh (coordinates/mean_value_polyhedral.hpp).
template <Scalar T, std::size_t D, class Cage = std::conditional_t<D == 2, Polygon<T>, TriangleMesh<T>>>
class MeanValueCoordinates;

/// Mean value coordinates in the plane, for any set of simple loops, holes included.
///
///   w_i = (tan(α_{i−1}/2) + tan(α_i/2)) / |C_i − p|,  m_i = w_i / Σ w,
///   α_i the signed angle C_i p C_{i+1}
///
/// Floater, Mean value coordinates (CAGD 20, 2003), eq. (2.1); several loops and the plane outside:
/// Hormann & Floater, Mean value coordinates for arbitrary planar polygons (ACM TOG 25, 2006), sec.
/// 3 and 4. On vertices and edges the limits are taken (the unit row; linear along the edge).
/// The formula in code: `weigh` in detail/mean_value_plane.hpp.
///
///   range      sum to 1; may be negative where the cage is not convex, and outside
///   accuracy   a few roundings inside and near the cage; far away the true weights grow like the
///              distance and cancel, so points farther than some hundred diagonals are computed one
///              precision higher, where the platform has one (float always; double where long
///              double is wider)
///   cost       O(#V) a point; one division and one square root per vertex and eight (sixteen)
///              points
///   gradients  double: 1e-11 of the largest, or of one over the diagonal (3e-12 measured); float:
///              that of rounding them. Σ ∇w_i = 0 and Σ C_i ∇w_i = identity likewise. Nearer to a
///              vertex than 1e-6 diagonals they turn with the direction, on it they are those of
///              one. They take three to four times as long as double weights; tens of times for a point on
///              the boundary, nearer to it than 1e-5 diagonals (double), or some diagonals away
template <Scalar T>
class MeanValueCoordinates<T, 2> : public detail::MeanValueEvaluation<Polygon<T>> {
    using Base = detail::MeanValueEvaluation<Polygon<T>>;

public:
    explicit MeanValueCoordinates(Polygon<T> cage)
        : Base(std::move(cage)) {}

    template <PointRange R>
        requires(range_dimension<R> == 2)
    explicit MeanValueCoordinates(const R& vertices)
        : Base(Polygon<T>(vertices)) {}
    template <UnknownPointRange R>
    explicit MeanValueCoordinates(const R&, detail::PointTraitsNotSpecialisedForThesePoints = {}) =
        CAGEFORM_DETAIL_DELETE_UNKNOWN_POINTS;

    /// Loops alone: interior_cells_not_supported where there are cells inside.
    explicit MeanValueCoordinates(const CellComplex<T, 2>& cage)
        : Base(cage) {}
};

using MeanValueCoordinates2f = MeanValueCoordinates<float, 2>;
using MeanValueCoordinates2d = MeanValueCoordinates<double, 2>;

} // namespace cageform::inline CAGEFORM_ABI

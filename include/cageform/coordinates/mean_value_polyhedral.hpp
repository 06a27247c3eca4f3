// Mean value coordinates in space for cages whose faces are planar polygons.
#pragma once

#include <cageform/coordinates/detail/mean_value_polygons.hpp>
#include <cageform/coordinates/mean_value_3d.hpp>

namespace cageform::inline CAGEFORM_ABI {

/// As MeanValueCoordinates<T, 3>, whose weights it has where all faces are triangles. A face of more
/// corners shares what its triangles have together among them by its mean value coordinates in its
/// plane, so that the weights do not depend on how it is cut, and on the face are those in the plane:
/// `share_out` in detail/mean_value_polygons.hpp.
///
///   accuracy   as there; about faces that are not convex there are places, inside or outside, where
///              the weights have a kink (mean value coordinates in the plane have one on edges)
///   cost       that of the triangles, and O(#corners) for all faces of more than three corners
template <Scalar T>
class MeanValueCoordinates<T, 3, PolyhedralMesh<T>> : public detail::MeanValueEvaluation<PolyhedralMesh<T>> {
    using Base = detail::MeanValueEvaluation<PolyhedralMesh<T>>;

public:
    explicit MeanValueCoordinates(PolyhedralMesh<T> cage)
        : Base(std::move(cage)) {}

    /// From what a PolyhedralMesh is made of.
    template <PointRange R, LoopRange F>
        requires(range_dimension<R> == 3)
    MeanValueCoordinates(const R& vertices, const F& faces, T off_plane = 0)
        : Base(PolyhedralMesh<T>(vertices, faces, off_plane)) {}
};

} // namespace cageform::inline CAGEFORM_ABI

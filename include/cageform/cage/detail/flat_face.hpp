// A face of a polyhedral mesh in its plane, as a polygon.
#pragma once

#include <cageform/cage/detail/face_plane.hpp>
#include <cageform/cage/polygon.hpp>

namespace cageform::inline CAGEFORM_ABI {

template <Scalar T>
class PolyhedralMesh; // in cage/polyhedral_mesh.hpp

namespace detail {

template <Scalar T>
Buffer<Vec<double, 3>> corners_of(const PolyhedralMesh<T>& mesh, std::size_t f) {
    Buffer<Vec<double, 3>> positions;
    for (const std::uint32_t i : mesh.face(f)) positions.push_back(vec_cast<double>(mesh[i]));
    return positions;
}

template <Scalar T>
FacePlane plane_of(const PolyhedralMesh<T>& mesh, std::size_t f) {
    return FacePlane(corners_of(mesh, f));
}

/// Returns a face as a counter-clockwise polygon in its plane.
template <Scalar T>
Polygon<double> flat_face(const PolyhedralMesh<T>& mesh, std::size_t f, const FacePlane& plane) {
    std::vector<Vec<double, 2>> flat;
    for (const std::uint32_t i : mesh.face(f)) flat.push_back(plane.flat(vec_cast<double>(mesh[i])));
    return Polygon<double>(flat);
}

} // namespace detail

} // namespace cageform::inline CAGEFORM_ABI

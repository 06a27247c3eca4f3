// The kinds of cage that the cage classes represent.
#pragma once

#include <cageform/coordinates/types.hpp>

#include <type_traits>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The kinds of cage that a class represents. A lattice is the cage of its own coordinates.
template <class Cage>
inline constexpr std::uint32_t kinds_of = 0;
template <class T>
inline constexpr std::uint32_t kinds_of<Polygon<T>> = cage_kinds::polygon;
template <class T>
inline constexpr std::uint32_t kinds_of<TriangleMesh<T>> = cage_kinds::triangles;
template <class T>
inline constexpr std::uint32_t kinds_of<PolyhedralMesh<T>> = cage_kinds::fans | cage_kinds::planar_faces;
template <class T, std::size_t D> // without cells, a CellComplex stands for its boundary
inline constexpr std::uint32_t kinds_of<CellComplex<T, D>> =
    cage_kinds::cells | (D == 2 ? cage_kinds::polygon : cage_kinds::triangles);
template <class T>
inline constexpr std::uint32_t kinds_of<CurvedPolygon<T>> = cage_kinds::curves;
template <class T, std::size_t D>
inline constexpr std::uint32_t kinds_of<PointSet<T, D>> = cage_kinds::sites;
template <class T, std::size_t D>
inline constexpr std::uint32_t kinds_of<LatticeCoordinates<T, D>> = cage_kinds::lattice;

/// Returns the argument for barycentric coordinates: the cage, or the vertices of a mesh.
template <class Cage>
decltype(auto) corners_of(const Cage& cage) {
    if constexpr (std::is_constructible_v<BarycentricCoordinates<typename Cage::scalar, Cage::dimension>,
                                          const Cage&>)
        return (cage);
    else
        return cage.vertices();
}

} // namespace cageform::inline CAGEFORM_ABI::detail

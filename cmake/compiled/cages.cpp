// Compiles the checks of cages, `make_cage` and `find_parts`.
#include "instantiate.hpp"

#include <cageform/cage/detail/check_cells.impl.hpp>
#include <cageform/cage/detail/check_faces.impl.hpp>
#include <cageform/cage/detail/check_mesh.impl.hpp>
#include <cageform/cage/detail/check_polygon.impl.hpp>
#include <cageform/enclose/plane/cage_maker.hpp>
#include <cageform/enclose/space/pair_faces.hpp>
#include <cageform/enclose/space/part_finder.hpp>

namespace cageform::inline CAGEFORM_ABI {

#define CAGEFORM_CAGES(T)                                                                                    \
    CAGEFORM_COMPILE CageReport check(const Polygon<T>&);                                                    \
    CAGEFORM_COMPILE CageReport check(const TriangleMesh<T>&);                                               \
    CAGEFORM_COMPILE CageReport check(const PolyhedralMesh<T>&);                                             \
    CAGEFORM_COMPILE CageReport check(const CellComplex<T, 2>&);                                             \
    CAGEFORM_COMPILE CageReport check(const CellComplex<T, 3>&);                                             \
    CAGEFORM_COMPILE std::vector<detail::MeshFace> detail::closing_faces(std::span<const Vec<T, 3>>,         \
                                                                         std::span<const detail::MeshFace>); \
    CAGEFORM_COMPILE Status detail::make_cage_into(std::span<const DrawnSegment<T>>,                         \
                                                   std::span<const PaintedArea>, const MakeCageOptions&,     \
                                                   const Running&, Result<Polygon<T>, MakeCageReport>&);     \
    CAGEFORM_COMPILE Status detail::make_cage_into(                                                          \
        std::span<const Vec<T, 3>>, std::span<const detail::MeshFace>, const MakeCageOptions&,               \
        const Running&, Result<TriangleMesh<T>, MakeCageReport>&);                                           \
    CAGEFORM_COMPILE Status detail::pair_faces_into(                                                         \
        const TriangleMesh<T>&, std::span<const Vec<T, 3>>, std::span<const detail::MeshFace>,               \
        const MakeCageOptions&, Result<PolyhedralMesh<T>, MakeCageReport>&);                                 \
    CAGEFORM_COMPILE CageParts detail::parts_of_cage(std::span<const Vec<T, 3>>,                             \
                                                     std::span<const detail::MeshFace>);
CAGEFORM_FOR_SCALARS(CAGEFORM_CAGES)

} // namespace cageform::inline CAGEFORM_ABI

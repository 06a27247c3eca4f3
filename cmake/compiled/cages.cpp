// Compiles the checks of cages, `make_cage`, `pair_faces` and `find_parts`.
#include "instantiate.hpp"

#include <cageform/cage/detail/check_cells.impl.hpp>
#if CAGEFORM_D == 2
#include <cageform/cage/detail/check_polygon.impl.hpp>
#include <cageform/enclose/plane/cage_maker.hpp>
#else
#include <cageform/cage/detail/check_faces.impl.hpp>
#include <cageform/cage/detail/check_mesh.impl.hpp>
#include <cageform/enclose/space/pair_faces.hpp>
#include <cageform/enclose/space/part_finder.hpp>
#endif

namespace cageform::inline CAGEFORM_ABI {

#define CAGEFORM_CHECK(Cage, T, D) CAGEFORM_COMPILE CageReport check(const Cage&);
CAGEFORM_FOR_CAGES(CAGEFORM_CHECK)
#define CAGEFORM_CHECK_CELLS(T, D) CAGEFORM_COMPILE CageReport check(const CellComplex<T, D>&);
CAGEFORM_FOR_SCALARS(CAGEFORM_CHECK_CELLS, CAGEFORM_D)

#if CAGEFORM_D == 2
#define CAGEFORM_ENCLOSE(T, D)                                                                               \
    CAGEFORM_COMPILE Status detail::make_cage_into(std::span<const DrawnSegment<T>>,                         \
                                                   std::span<const PaintedArea>, const MakeCageOptions&,     \
                                                   const Running&, Result<Polygon<T>, MakeCageReport>&);
#else
#define CAGEFORM_ENCLOSE(T, D)                                                                               \
    CAGEFORM_COMPILE std::vector<detail::MeshFace> detail::closing_faces(std::span<const Vec<T, D>>,         \
                                                                         std::span<const detail::MeshFace>); \
    CAGEFORM_COMPILE Status detail::make_cage_into(                                                          \
        std::span<const Vec<T, D>>, std::span<const detail::MeshFace>, const MakeCageOptions&,               \
        const Running&, Result<TriangleMesh<T>, MakeCageReport>&);                                           \
    CAGEFORM_COMPILE Status detail::pair_faces_into(                                                         \
        const TriangleMesh<T>&, std::span<const Vec<T, D>>, std::span<const detail::MeshFace>,               \
        const MakeCageOptions&, Result<PolyhedralMesh<T>, MakeCageReport>&);                                 \
    CAGEFORM_COMPILE CageParts detail::parts_of_cage(std::span<const Vec<T, D>>,                             \
                                                     std::span<const detail::MeshFace>);                     \
    CAGEFORM_COMPILE std::optional<CageFault> face_fault(const PolyhedralMesh<T>&, std::size_t);
#endif
CAGEFORM_FOR_SCALARS(CAGEFORM_ENCLOSE, CAGEFORM_D)

} // namespace cageform::inline CAGEFORM_ABI

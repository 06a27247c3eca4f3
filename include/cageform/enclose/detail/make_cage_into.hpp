// Declares the functions behind `make_cage`.
#pragma once

#include <cageform/cage/polygon.hpp>
#include <cageform/cage/triangle_mesh.hpp>
#include <cageform/core/result.hpp>
#include <cageform/core/running.hpp>
#include <cageform/enclose/types/make_cage_options.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Makes a cage in the plane; defined in enclose/plane/cage_maker.hpp.
template <class T>
Status make_cage_into(std::span<const DrawnSegment<T>> figure, std::span<const PaintedArea> areas,
                      const MakeCageOptions& options, const Running& running,
                      Result<Polygon<T>, MakeCageReport>& made);

/// Makes a cage in space; faces may lack vertices. Defined in enclose/space/cage_maker.hpp.
template <class T>
Status make_cage_into(std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces,
                      const MakeCageOptions& options, const Running& running,
                      Result<TriangleMesh<T>, MakeCageReport>& made);

} // namespace cageform::inline CAGEFORM_ABI::detail

// Declares the implementations of make_cage, pair_faces and find_parts.
#pragma once

#include <cageform/cage/polygon.hpp>
#include <cageform/cage/polyhedral_mesh.hpp>
#include <cageform/core/result.hpp>
#include <cageform/enclose/types/make_cage_options.hpp>
#include <cageform/parallel/running.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Makes a 2D cage; defined in enclose/plane/cage_maker.hpp.
template <class T>
Status make_cage_into(std::span<const DrawnSegment<T>> figure, std::span<const PaintedArea> areas,
                      const MakeCageOptions& options, const Running& running,
                      Result<Polygon<T>, MakeCageReport>& made);

/// A 3D figure as vertices and faces; an index out of range becomes no_vertex.
template <Scalar T>
struct FigureOfFaces {
    std::vector<Vec<T, 3>> vertices;
    std::vector<MeshFace> faces;

    template <class R, class F>
    FigureOfFaces(const R& points, const F& triangles) {
        for (std::size_t i = 0; i < std::size(points); ++i) vertices.push_back(to_vec<T>(points[i]));
        for (std::size_t f = 0; f < std::size(triangles); ++f)
            faces.push_back(checked_face(triangles[f], vertices.size()));
    }
};

/// Makes a 3D cage; defined in enclose/space/cage_maker.hpp.
template <class T>
Status make_cage_into(std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces,
                      const MakeCageOptions& options, const Running& running,
                      Result<TriangleMesh<T>, MakeCageReport>& made);

/// Merges triangles to quads; defined in enclose/space/pair_faces.hpp.
template <class T>
Status pair_faces_into(const TriangleMesh<T>& cage, std::span<const Vec<T, 3>> vertices,
                       std::span<const MeshFace> faces, const MakeCageOptions& options,
                       Result<PolyhedralMesh<T>, MakeCageReport>& made);

/// Finds the parts of a valid cage; defined in enclose/space/part_finder.hpp.
template <class T>
CageParts parts_of_cage(std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces);

} // namespace cageform::inline CAGEFORM_ABI::detail

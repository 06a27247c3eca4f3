// The faces of triangle meshes, with indices that may be out of range.
#pragma once

#include <cageform/cage/faces_of.hpp>
#include <cageform/core/vec.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

using MeshFace = std::array<std::uint32_t, 3>;

/// Returns a face with no_vertex in place of indices below 0 or from `count` on.
template <class F>
MeshFace checked_face(const F& face, std::size_t count) noexcept {
    MeshFace checked;
    for (std::size_t k = 0; k < 3; ++k)
        checked[k] = face[k] >= 0 && std::uint64_t(face[k]) < count ? std::uint32_t(face[k]) : no_vertex;
    return checked;
}

template <std::size_t D>
bool has_missing_vertex(const std::array<std::uint32_t, D>& facet) noexcept {
    return std::find(facet.begin(), facet.end(), no_vertex) != facet.end();
}

/// Makes the faces that close small gaps of a mesh (TriangleMesh). Defined in check_mesh.impl.hpp.
template <class T>
std::vector<MeshFace> closing_faces(std::span<const Vec<T, 3>> vertices, std::span<const MeshFace> faces);

} // namespace cageform::inline CAGEFORM_ABI::detail

// The faces of triangle meshes, with indices that may name no vertex.
#pragma once

#include <cageform/cage/detail/faces_of.hpp>

#include <algorithm>
#include <array>
#include <cstdint>

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

/// Returns whether a corner of a facet is no_vertex.
template <std::size_t D>
bool lacks_vertex(const std::array<std::uint32_t, D>& facet) noexcept {
    return std::find(facet.begin(), facet.end(), no_vertex) != facet.end();
}

} // namespace cageform::inline CAGEFORM_ABI::detail

#pragma once

// Figures with the copies of each vertex merged.

#include "files/mesh_file.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace cageform_support {

/// A figure with vertices of equal joined_places() merged. Files split vertices where normals or texture
/// coordinates differ.
struct WeldedMesh {
    static constexpr std::uint32_t no_place = ~std::uint32_t{0};

    std::vector<Point3> places;
    std::vector<std::uint32_t> first;                    ///< #places: a vertex of the file at each
    std::vector<std::uint32_t> place_of;                 ///< #vertices of the file
    std::vector<std::array<std::uint32_t, 3>> triangles; ///< of places, without degenerate ones
};

WeldedMesh welded_mesh(const MeshFile& figure);

/// As welded_mesh(), without the places that no triangle uses. Their vertices have no_place.
WeldedMesh welded_surface(const MeshFile& figure);

} // namespace cageform_support

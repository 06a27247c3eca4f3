#pragma once

// Pictures of meshes, drawn without any graphics library: figures in their cages, several side by side.

#include "obj_file.hpp"
#include "picture.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace cageform_examples {

struct MeshView {
    std::span<const Point3> vertices;
    std::span<const std::array<std::uint32_t, 3>> triangles;
    std::span<const Colour> colours{}; ///< one a vertex; empty: of clay
};

/// What one part of the picture shows.
struct MeshScene {
    MeshView figure;
    MeshView cage;
};

/// Draws scenes side by side, each in an equal part of the width, all at the same scale from the same place.
Picture draw_meshes(std::span<const MeshScene> scenes, std::size_t width, std::size_t height);

} // namespace cageform_examples

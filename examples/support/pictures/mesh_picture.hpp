#pragma once

// Software renderer of meshes: figures in their cages, several side by side.

#include "files/mesh_file.hpp"
#include "pictures/picture.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace cageform_support {

struct MeshView {
    std::span<const Point3> vertices;
    std::span<const std::array<std::uint32_t, 3>> triangles;
    std::span<const Colour> colours{}; ///< #vertices; empty: clay
    std::span<const Colour> backs{};   ///< colours of back faces; empty: as the front
    /// #triangles: index of the face. Cage lines are not drawn inside faces. Empty: each triangle is a face.
    std::span<const std::uint32_t> triangle_faces{};
};

/// A cage with other vertex positions.
inline MeshView cage_view(const MeshFile& cage, std::span<const Point3> vertices) {
    return {vertices, cage.triangles, {}, {}, cage.triangle_faces};
}

struct SpaceLine {
    std::vector<Point3> points;
    double thickness = 1; ///< in pixels
    Colour colour{};
    bool on_top = false; ///< not hidden by surfaces
};

/// A text centred at a point.
struct SpaceText {
    Point3 at;
    std::string words;
};

struct MeshScene {
    MeshView figure;
    MeshView cage;
    std::span<const SpaceLine> lines{}; ///< hidden by the figure, unless on_top
    std::span<const SpaceText> texts{}; ///< always on top
};

/// View direction of meshes: rotation from the front towards the figure's left, then upwards, in degrees.
struct ViewAngles {
    double turn = 34.4, rise = 11.5;
    bool z_is_up = false; ///< true: z is up, the front faces -y; false: y is up, the front faces z
};

/// Background colour.
inline constexpr Colour mesh_background{0.965f, 0.965f, 0.955f};

/// Draws scenes side by side in equal parts of the width, with the same scale and camera.
Picture draw_meshes(std::span<const MeshScene> scenes, std::size_t width, std::size_t height,
                    const ViewAngles& sight = {});

/// Orthonormal axes of a view: right, up, towards the viewer.
struct ViewDirections {
    Point3 right, up, towards;
};

ViewDirections directions_of(const ViewAngles& sight);

/// View directions with z up: rotated about z, then from above; periodic.
///
///   turn, rise   in degrees; 0, 0 looks along y
ViewDirections view_from(double turn, double rise);

/// A coloured surface with lines and texts.
struct SpacePlot {
    MeshView surface;
    std::vector<SpaceLine> lines;
    std::vector<SpaceText> texts;
    double letter = 2; ///< 1/7 of a letter's height, in pixels
};

/// Draws a plot in parallel projection.
Picture draw_plot(const SpacePlot& plot, const ViewDirections& view, std::size_t width, std::size_t height);

} // namespace cageform_support

#pragma once

// Pictures of meshes, drawn without any graphics library: figures in their cages, several side by side.

#include "files/obj_file.hpp"
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
    std::span<const Colour> colours{}; ///< one a vertex; empty: of clay
    std::span<const Colour> backs{};   ///< where the triangles are seen from behind; empty: as from the front
    /// #triangles: the face that each is a part of; the lines of a cage pass over edges inside a face. Empty:
    /// each is a face.
    std::span<const std::uint32_t> triangle_faces{};
};

/// A cage of a file with its vertices at other places.
inline MeshView cage_view(const ObjFile& cage, std::span<const Point3> vertices) {
    return {vertices, cage.triangles, {}, {}, cage.triangle_faces};
}

struct SpaceLine {
    std::vector<Point3> points;
    double thickness = 1; ///< in pixels
    Colour colour{};
    bool on_top = false; ///< seen through the surfaces
};

/// A word whose middle is at a place.
struct SpaceText {
    Point3 at;
    std::string words;
};

/// The contents of one tile of the picture.
struct MeshScene {
    MeshView figure;
    MeshView cage;
    std::span<const SpaceLine> lines{}; ///< as far as the figure does not hide them, or on top of it
    std::span<const SpaceText> texts{}; ///< on top, on patches of paper
};

/// The view direction of meshes: turned from the front towards the figure's left, then upwards, in degrees.
struct MeshSight {
    double turn = 34.4, rise = 11.5;
    bool z_is_up = false; ///< the figure looks against y then; else y is up, and it looks along z
};

/// The paper of such pictures.
inline constexpr Colour mesh_background{0.965f, 0.965f, 0.955f};

/// Draws scenes side by side, each in an equal part of the width, all at the same scale from the same
/// place.
Picture draw_meshes(std::span<const MeshScene> scenes, std::size_t width, std::size_t height,
                    const MeshSight& sight = {});

/// Where a picture is seen from: what is to its right, up in it, and towards the eye. Unit lengths, at
/// right angles.
struct ViewDirections {
    Point3 right, up, towards;
};

ViewDirections directions_of(const MeshSight& sight);

/// The z axis is up: turned about it, then seen from above. Whole turns change nothing.
///
///   turn, rise   in degrees; 0, 0 looks along y
ViewDirections view_from(double turn, double rise);

/// A surface with its own colours, and lines where no surface hides them.
struct SpacePlot {
    MeshView surface;
    std::vector<SpaceLine> lines;
    std::vector<SpaceText> texts;
    double letter = 2; ///< a seventh of a letter's height, in pixels
};

/// Draws a plot as parallel rays show it.
Picture draw_plot(const SpacePlot& plot, const ViewDirections& view, std::size_t width, std::size_t height);

} // namespace cageform_support

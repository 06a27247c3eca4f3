#pragma once

// Sheets of meshes in space, drawn side by side with captions.

#include "io/csv.hpp"
#include "pictures/mesh_picture.hpp"
#include "pictures/surface_nets.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace cageform_sources {

using namespace cageform_support;

using Face = std::array<std::uint32_t, 3>;

/// A mesh with a colour per vertex.
struct Model {
    std::vector<Point3> vertices;
    std::vector<Face> faces;
    std::vector<Colour> colours;

    void add(const std::vector<Point3>& places, const std::vector<Face>& triangles,
             const std::vector<Colour>& own) {
        const auto first = std::uint32_t(vertices.size());
        vertices.insert(vertices.end(), places.begin(), places.end());
        colours.insert(colours.end(), own.begin(), own.end());
        for (const auto& [i, k, l] : triangles) faces.push_back({first + i, first + k, first + l});
    }
    void add(const std::vector<Point3>& places, const std::vector<Face>& triangles, const Colour& colour) {
        add(places, triangles, std::vector(places.size(), colour));
    }

    /// Adds a rod with round ends; a ball if the ends are equal. `sides` is a multiple of four.
    void add_rod(const Point3& a, const Point3& b, double radius_a, double radius_b, const Colour& colour,
                 std::uint32_t sides = 8);
    void add_ball(const Point3& p, double radius, const Colour& colour) {
        add_rod(p, p, radius, radius, colour);
    }

    template <class Map>
    Model mapped(const Map& map) const {
        Model other = *this;
        for (Point3& p : other.vertices) p = map(p);
        return other;
    }
};

struct Tile {
    Model model;
    std::string caption; ///< two lines at most
    MeshView cage{};     ///< drawn as lines
};

/// Rows of tiles, all seen from the same place at the same size, captions above.
Picture draw_tiles(const std::vector<Tile>& tiles, std::size_t columns, std::size_t width,
                   std::size_t height);

/// Pictures in a column below a title.
Picture with_title(const std::string& title, const std::vector<Picture>& parts);

/// Pictures of equal height, side by side.
Picture beside(const std::vector<Picture>& parts);

/// A picture with a bar of the colours of heat() on its right, marked from 0 to `most`.
Picture with_bar(const Picture& part, double most, const std::string& unit);

/// Words in the size and colour of captions.
void write_caption(Picture& picture, const Point2& at, const std::string& caption);

std::vector<Colour> heat_of(const std::vector<double>& values, double most);

} // namespace cageform_sources

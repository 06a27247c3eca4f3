#pragma once

// Lattices of control points, from command line words and .lattice.json files.

#include "svg/path.hpp"

#include <cageform/coordinates/lattice.hpp>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// A lattice, checked by LatticeCoordinates.
template <std::size_t D>
struct LatticeBox {
    std::array<cageform::LatticeAxis, D> axes{};
    cageform::Transform<double, D> frame{}; // of the box, the image of [0, 1]^D
    double falloff = 0;                     // in units of the figure

    std::size_t points() const { ///< number of control points, without frame handles
        std::size_t count = 1;
        for (const auto& axis : axes) count *= axis.points;
        return count;
    }

    template <class T>
    cageform::LatticeCoordinates<T, D> coordinates() const {
        cageform::Transform<T, D> box;
        for (std::size_t k = 0; k < D; ++k) box.columns[k] = cageform::vec_cast<T>(frame.columns[k]);
        box.translation = cageform::vec_cast<T>(frame.translation);
        return cageform::LatticeCoordinates<T, D>(axes, box, static_cast<T>(falloff));
    }
};

/// The text after "lattice:", such as "4x4", "4x4x4/2" or "6x4/bernstein+0.1@30".
struct LatticeWord {
    std::vector<std::size_t> points; // two or three axes
    std::size_t degree = 3;          // at most points - 1
    bool is_bernstein = false;
    double falloff = 0; // relative to the box's diagonal
    double angle = 0;   // of a planar box, in degrees
};

/// Help text on lattices.
inline constexpr const char* lattice_format =
    "A lattice is a box of control points around the figure: lattice:4x4 for a drawing,\n"
    "lattice:4x4x4 for a mesh, 2 points or more along each axis. Optional suffixes, in\n"
    "this order: /1, /2 or /3, the degree of the splines (default 3), or /bernstein for\n"
    "polynomials over the whole box (at most 64 points along an axis); +R: points farther\n"
    "outside than R diagonals of the box do not move; @ANGLE turns the box of a\n"
    "drawing. Points are numbered along x first, then y, then z. A file .lattice.json,\n"
    "which make_cage --lattice writes, is the lattice with its box. A pose of a lattice in\n"
    "the plane is an SVG file of its rows and columns, each a line of points, or a CSV\n"
    "file of its points; in space it is an OBJ file with the points moved.\n";

/// Parses a word; the error quotes it.
Expected<LatticeWord> parse_lattice_word(std::string_view word);

/// Whether a path is a lattice file.
bool is_lattice_path(std::string_view path);

/// The number of axes of a lattice file, 2 or 3.
Expected<std::size_t> lattice_dimension(const std::string& path);

/// Parses a lattice file; fails also if the library rejects the lattice.
template <std::size_t D>
Expected<LatticeBox<D>> parse_lattice(std::string_view text, const std::string& name);

/// As parse_lattice(), from a file; fails also if it cannot be read.
template <std::size_t D>
Expected<LatticeBox<D>> load_lattice(const std::string& path);

/// The text of a lattice file; parse_lattice() restores every bit.
template <std::size_t D>
std::string to_json(const LatticeBox<D>& lattice);

/// A lattice around points.
///
///   margin   around the points, relative to their diagonal
///   figure   its name, for messages
///   fails    if the word is for another dimension, or there is no box
template <std::size_t D>
Expected<LatticeBox<D>> lattice_about(const LatticeWord& word,
                                      const std::vector<cageform::Vec<double, D>>& points, double margin,
                                      const std::string& figure);

/// "4 x 4 control points of degree 3".
template <std::size_t D>
std::string describe(const LatticeBox<D>& lattice);

} // namespace cageform_support

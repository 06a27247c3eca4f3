#pragma once

// Lattices of control points: as words of a command line, and as .lattice.json files.

#include "svg/path.hpp"

#include <cageform/coordinates/lattice.hpp>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// A lattice that LatticeCoordinates have accepted.
template <std::size_t D>
struct LatticeBox {
    std::array<cageform::LatticeAxis, D> axes{};
    cageform::Transform<double, D> frame{}; // of the box, the image of [0, 1]^D
    double falloff = 0;                     // in the units of the figure

    std::size_t points() const { ///< the control points, before the still handles
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

/// "4x4", "4x4x4/2", "6x4/bernstein+0.1@30": what follows "lattice:".
struct LatticeWord {
    std::vector<std::size_t> points; // two or three axes
    std::size_t degree = 3;          // lowered to points - 1
    bool is_bernstein = false;
    double falloff = 0; // as a part of the box's diagonal
    double angle = 0;   // of the box, in degrees, in the plane
};

/// The text for --help.
inline constexpr const char* lattice_format =
    "A lattice is a box of control points about the figure: lattice:4x4 for a drawing,\n"
    "lattice:4x4x4 for a mesh, 2 points or more along each axis. After it can stand, in\n"
    "this order, /1, /2 or /3, the degree of its splines (3 unless given), or /bernstein,\n"
    "polynomials over the whole box (at most 64 points along an axis); +R, beyond which\n"
    "nothing outside moves, R in diagonals of the box; and @ANGLE, which turns the box of\n"
    "a drawing. Points are numbered along x first, then y, then z. A file .lattice.json,\n"
    "which make_cage --lattice writes, is the lattice with its box. A pose of a lattice in\n"
    "the plane is an SVG file of its rows and columns, each a line of points, or a CSV\n"
    "file of its points; in space it is an OBJ file with the points moved.\n";

/// Reads a word; fails with a sentence that quotes it.
Expected<LatticeWord> parse_lattice_word(std::string_view word);

/// Whether a path names a lattice's file.
bool is_lattice_path(std::string_view path);

/// 2 or 3: the number of axes of a lattice's file.
Expected<std::size_t> lattice_dimension(const std::string& path);

/// A lattice from the text of a file; fails also where the library refuses it.
template <std::size_t D>
Expected<LatticeBox<D>> parse_lattice(std::string_view text, const std::string& name);

/// Works as parse_lattice(), from a file; fails also where it cannot be read.
template <std::size_t D>
Expected<LatticeBox<D>> load_lattice(const std::string& path);

/// The text of a file that parse_lattice() reads back to the bit.
template <std::size_t D>
std::string to_json(const LatticeBox<D>& lattice);

/// A lattice about points.
///
///   margin   about all points, as a part of their diagonal
///   figure   its name, for messages
///   fails    where the word is for another dimension, or there is no box
template <std::size_t D>
Expected<LatticeBox<D>> lattice_about(const LatticeWord& word,
                                      const std::vector<cageform::Vec<double, D>>& points, double margin,
                                      const std::string& figure);

/// "4 x 4 control points of degree 3": for people.
template <std::size_t D>
std::string describe(const LatticeBox<D>& lattice);

} // namespace cageform_support

#pragma once

// Pins (points of a figure with targets), from command line words and CSV files.

#include "svg/path.hpp"

#include <cageform/core/vec.hpp>
#include <cageform/pose/types/pose_solver.hpp>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// Help text on pins.
inline constexpr const char* pins_format =
    "A pin moves a point of the figure to a target, and the rest follows as rigidly as\n"
    "possible: --pin PLACE:TARGET@DEGREES, where :TARGET and @DEGREES are optional.\n"
    "\n"
    "    --pin 915,165             the point (915, 165) stays fixed\n"
    "    --pin 915,165:760,60      it moves to (760, 60)\n"
    "    --pin 915,165:+20,-5      if any number has a sign, it moves by (20, -5)\n"
    "    --pin 915,165:=-20,-5     after =, always a position\n"
    "    --pin 915,165:+0,+0@-40   the figure also turns there, as with --turn\n"
    "\n"
    "In space positions are x,y,z, or the number of a vertex of the figure, from 0, and a\n"
    "turn has an axis: --pin 5021:+0.2,+0.4,0@30,y. A CSV file has one pin per line; its\n"
    "targets are positions, and the angle of a pin that does not turn is empty:\n"
    "\n"
    "    x,y,TX,TY[,ANGLE[,WEIGHT]]              in the plane\n"
    "    x,y,z,TX,TY,TZ[,RX,RY,RZ[,WEIGHT]]      in space; R is an axis whose length is\n"
    "                                            the angle in degrees; x,y,z can be a\n"
    "                                            vertex number\n"
    "\n"
    "An empty line, a line of words at the top and lines that begin with # are skipped.\n";

/// A point of a figure and its target.
template <std::size_t D>
struct Pin {
    std::string name; ///< the option, or file and line, for messages
    cageform::Vec<double, D> place{};
    cageform::Vec<double, D> target{};
    std::optional<cageform::PoseTurn<D>> turn = {}; ///< in radians; none: free to turn
    double weight = 1;
    bool is_relative = false; ///< whether the target was given as a displacement
};

namespace detail {

/// Parses a position, or in space the number of a vertex. Returns the error; empty on success.
///
///   parts   D numbers, or one
template <std::size_t D>
std::string parse_place(std::span<const std::string_view> parts,
                        std::span<const cageform::Vec<double, D>> vertices, cageform::Vec<double, D>& place);

} // namespace detail

/// Parses a pin of the command line, PLACE[:TARGET][@TURN].
///
///   vertices   of the figure, for pins by vertex number in space; else empty
///   fails      on an invalid place, target, turn or vertex number
template <std::size_t D>
Expected<Pin<D>> parse_pin(std::string_view word, std::span<const cageform::Vec<double, D>> vertices = {});

/// Parses a CSV file of pins.
///
///   name    prefix of every message, with the line number
///   fails   on a wrong number of columns, an invalid number or vertex, a weight that is not positive, or if
///           there are no pins
template <std::size_t D>
Expected<std::vector<Pin<D>>> parse_pins(std::string_view text, const std::string& name,
                                         std::span<const cageform::Vec<double, D>> vertices = {});

/// As parse_pins(), from a file; fails also if it cannot be read.
template <std::size_t D>
Expected<std::vector<Pin<D>>> load_pins(const std::string& path,
                                        std::span<const cageform::Vec<double, D>> vertices = {});

/// "pin 3 (pins.csv:4) at (12, 5)", from 1.
template <std::size_t D>
std::string name_of(const std::vector<Pin<D>>& pins, std::size_t n);

/// "moved by (20, -5) to (935, 160)", "moved to (760, 60)" if the target was given as a position, or "stays".
template <std::size_t D>
std::string describe_target(const Pin<D>& pin);

/// Names two pins at one position with different targets; empty if there are none.
template <std::size_t D>
std::string contradiction(const std::vector<Pin<D>>& pins);

} // namespace cageform_support

#pragma once

// Operations that pose a cage, from command line words: a selection of vertices and an action.

#include "svg/path.hpp"

#include <cageform/core/vec.hpp>
#include <cageform/enclose/types/cage_parts.hpp>

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

enum class PoseOperation : std::uint8_t { move, turn, scale, bend, twist, curve };

/// Help text on pose operations.
inline constexpr const char* pose_operations_format =
    "An operation is WHICH:NUMBERS. It acts about the middle of the selected vertices;\n"
    "WHICH:NUMBERS@X,Y (in space @X,Y,Z) acts about a point, WHICH:NUMBERS@vWHICH about\n"
    "the middle of other vertices. WHICH is a list of\n"
    "\n"
    "    7          the vertex with this number, from 0, as --picture draws it\n"
    "    5-9        the vertices 5 to 9\n"
    "    all        all vertices\n"
    "    x>10&y<5   vertices whose position in CAGE meets all these conditions\n"
    "    part 3     in space: a part of a cage that make_cage made, and all parts\n"
    "               attached to it. If WHICH is one part, the operation acts about\n"
    "               the middle of its joint. part 1 is the trunk, without other parts\n"
    "\n"
    "such as 0,5-9. Angles are in degrees, from x towards y (clockwise on the screen\n"
    "in an SVG file); in space counter-clockwise if the axis points at the viewer.\n"
    "\n"
    "    --move 3:10,0            by x,y or x,y,z\n"
    "    --turn 5-9:30@v4,10      in the plane, about the middle of vertices 4 and 10\n"
    "    --turn 5-9:30,y          in space: about x, y, z or a vector, 30,1,1,0\n"
    "    --turn 'part -2:30,z'    an arm about its shoulder\n"
    "    --scale all:1.5          or one factor per axis: 2,1; -1,1 mirrors\n"
    "    --bend all:xy,10,30,90   the part from x = 10 to 30 becomes an arc towards y,\n"
    "                             and the part above 30 turns by 90; with 30,10 the\n"
    "                             part below 10 turns. The line that keeps its length\n"
    "                             passes through the point\n"
    "    --twist all:y,0,5,90     in space: turns about y, by 0 at y = 0 up to 90 at\n"
    "                             y = 5 and beyond\n"
    "    --curve 0:4:10,0         of a cage of curves: moves control point 4 of loop 0\n"
    "                             alone. Other operations that move the end of an\n"
    "                             edge also move the control points beside it\n";

/// The selected vertices, ascending.
///
///   rest    the cage's vertices, for conditions on positions
///   parts   of the cage, or null
///   fails   if a part of the word is invalid, a number is too large, or conditions select nothing
template <std::size_t D>
Expected<std::vector<std::size_t>> parse_selection(std::string_view word,
                                                   std::span<const cageform::Vec<double, D>> rest,
                                                   const cageform::CageParts* parts = nullptr);

/// Parses a turn: DEGREES, in space DEGREES,AXIS, such as 30,y or 30,1,1,0.
///
///   axis      out: of length 1; unchanged in the plane
///   returns   the error; empty on success
template <std::size_t D>
std::string parse_turn(std::string_view text, double& degrees, cageform::Vec<double, D>& axis);

/// Applies an operation, WHICH:NUMBERS[@POINT], to a pose. Means of vertices are taken in the current pose.
///
///   rest        the cage, as long as `pose`
///   pose        in and out; vertices that are not selected do not change
///   followers   #vertices: vertices that move with each vertex, see CageFile::followers(); empty: none
///   parts       of the cage, or null
///   returns     the error, and `pose` is unchanged; empty on success
template <std::size_t D>
std::string apply_operation(PoseOperation operation, std::string_view word,
                            std::span<const cageform::Vec<double, D>> rest,
                            std::span<cageform::Vec<double, D>> pose,
                            std::span<const std::vector<std::size_t>> followers = {},
                            const cageform::CageParts* parts = nullptr);

/// Applies the operation `curve`, LOOP:K:DX,DY, to a pose.
///
///   loops     handles of the loops of a cage of curves
///   returns   the error, and `pose` is unchanged; empty on success
std::string move_control_point(std::string_view word, std::span<const std::vector<std::size_t>> loops,
                               std::span<cageform::Vec<double, 2>> pose);

extern template Expected<std::vector<std::size_t>>
parse_selection(std::string_view, std::span<const cageform::Vec<double, 2>>, const cageform::CageParts*);
extern template Expected<std::vector<std::size_t>>
parse_selection(std::string_view, std::span<const cageform::Vec<double, 3>>, const cageform::CageParts*);
extern template std::string parse_turn(std::string_view, double&, cageform::Vec<double, 2>&);
extern template std::string parse_turn(std::string_view, double&, cageform::Vec<double, 3>&);
extern template std::string apply_operation(PoseOperation, std::string_view,
                                            std::span<const cageform::Vec<double, 2>>,
                                            std::span<cageform::Vec<double, 2>>,
                                            std::span<const std::vector<std::size_t>>,
                                            const cageform::CageParts*);
extern template std::string apply_operation(PoseOperation, std::string_view,
                                            std::span<const cageform::Vec<double, 3>>,
                                            std::span<cageform::Vec<double, 3>>,
                                            std::span<const std::vector<std::size_t>>,
                                            const cageform::CageParts*);

} // namespace cageform_support

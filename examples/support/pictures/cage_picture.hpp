#pragma once

// Pictures of cages that show the numbers of their vertices.

#include "cli/pins.hpp"
#include "files/cage_file.hpp"
#include "files/obj_file.hpp"
#include "pictures/picture.hpp"

#include <string>
#include <vector>

namespace cageform_support {

/// The figure below, the cage at rest in grey where the pose is another, the pose over it with its
/// vertices' numbers.
///
///   figure   may be null
///   name     of the file, for messages
///   fails    where the cage has no size
Expected<SvgDocument> draw_pose(const CageFile& cage, const CageFile& pose, const SvgDocument* figure,
                                const std::string& name);

/// Draws into a document, in root user space, a dot and a number at every vertex of a cage, the number
/// outside its loop. The vertices of curves are control points, and those that draw_cage() marks get no dot.
///
///   letter   the size of the numbers
void draw_numbers(SvgDocument& document, const CageFile& cage, double letter);

/// Draws into a document, in root user space, pins: a dot at every target, and a line from where it was.
void draw_pins(SvgDocument& document, const std::vector<Pin<2>>& pins, double diagonal);

/// A cage in space from the front and from behind: its faces, the edges at rest in grey, and the numbers of
/// the vertices of faces turned here.
Picture draw_pose(const ObjFile& cage, const std::vector<Point3>& pose);

} // namespace cageform_support

#pragma once

// Pictures of cages with vertex numbers.

#include "cli/pins.hpp"
#include "files/cage_file.hpp"

#include <string>
#include <vector>

namespace cageform_support {

/// Draws the figure, the cage at rest in grey if the pose differs, and the pose with vertex numbers.
///
///   figure   may be null
///   name     of the file, for messages
///   fails    if the size of the cage is zero or not finite
Expected<SvgDocument> draw_pose(const CageFile& cage, const CageFile& pose, const SvgDocument* figure,
                                const std::string& name);

/// Draws a dot and a number at every vertex of a cage, in root user space, numbers outside its loop. Control
/// points that draw_cage() marks get no dot.
///
///   letter   size of the numbers
void draw_numbers(SvgDocument& document, const CageFile& cage, double letter);

/// Draws pins in root user space: a dot at every target, and a line from the rest position.
void draw_pins(SvgDocument& document, const std::vector<Pin<2>>& pins, double diagonal);

} // namespace cageform_support

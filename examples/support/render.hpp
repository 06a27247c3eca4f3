#pragma once

// SVG to PNG through librsvg's own program, started without a shell.

#include "atomic_file.hpp"

namespace cageform_examples {

/// Adds a picture to the outputs: `svg`, which is one of them, under its name with the ending .png.
///
///   svg     is finished
///   width   of the picture, in pixels; on white
///   fails   where rsvg-convert is not there or cannot render the file: then commit() says so, and nothing is written
void add_png(OutputFiles& outputs, AtomicFile& svg, int width);

} // namespace cageform_examples

#pragma once

// SVG to PNG through librsvg's own program, started without a shell.

#include "atomic_file.hpp"

#include <string>
#include <vector>

namespace cageform_examples {

/// Adds a picture to the outputs: `svg`, which is one of them, under its name with the ending .png.
///
///   svg     is finished
///   width   of the picture, in pixels; on white
///   fails   where rsvg-convert is not there or cannot render the file: then commit() says so, and nothing is written
void add_png(OutputFiles& outputs, AtomicFile& svg, int width);

/// Runs librsvg's program.
///
///   options   such as --format svg
///   in, out   descriptors that it reads an SVG from, -1 for none, and writes to
///   returns   empty, or why there is nothing: it is not installed, or cannot render what it read
std::string run_rsvg(std::vector<std::string> options, int in, int out);

} // namespace cageform_examples

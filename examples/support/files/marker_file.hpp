#pragma once

// CSV files of markers: points tracked through time, as in motion capture.

#include "files/clip_file.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// Help text on marker files.
inline constexpr const char* markers_format =
    "Markers are points of the figure that were tracked through time, in a CSV file with\n"
    "a row for each time:\n"
    "\n"
    "    time,nose x,nose y,paw x,paw y     names; this row can be left out\n"
    "    rest,130,240,175,744               positions on the figure as drawn\n"
    "    0.00,131,238,93,744                a time in seconds, and positions\n"
    "    0.04,131,237,,                     an empty position: a marker was lost\n"
    "\n"
    "Without a rest row, the first row is rest. Positions of lost markers are\n"
    "interpolated. The motion repeats; if the last row differs from the first, half a\n"
    "second is added to return to the first. The lines late and ground are as in a clip;\n"
    "# begins a comment.\n";

/// Parses markers to a clip of pins.
///
///   name    prefix of every message
///   fails   if a row has not as many columns as the first, a number is invalid, times do not ascend, a
///           marker has no rest position or no position at any time, or there are fewer than two times
Expected<ClipFile> parse_markers(std::string_view text, const std::string& name);

/// As parse_markers(), from a file; fails also if it cannot be read.
Expected<ClipFile> load_markers(const std::string& path);

/// Positions of points during a motion.
struct Tracks {
    std::vector<Point2> rest;
    std::vector<double> times;
    std::vector<std::vector<Point2>> places; // #times · #rest
};

/// The text of a marker file, with two decimals.
///
///   of        the motion whose late elements and ground are written
///   heading   comment on the first line
std::string markers_text(const Tracks& tracks, const ClipFile& of, const std::string& heading);

} // namespace cageform_support

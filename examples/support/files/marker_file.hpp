#pragma once

// Markers: places that are tracked through time, as motion capture has them, in a CSV file.

#include "files/clip_file.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// The text for --help.
inline constexpr const char* markers_format =
    "Markers are points of the figure that were tracked through time, in a CSV file with\n"
    "a row for each time:\n"
    "\n"
    "    time,nose x,nose y,paw x,paw y     names; this row can be left out\n"
    "    rest,130,240,175,744               where they are on the figure as drawn\n"
    "    0.00,131,238,93,744                where they are after so many seconds\n"
    "    0.04,131,237,,                     nothing: a marker was lost\n"
    "\n"
    "Without the row of rest, the first time is rest. A lost marker goes on to where it\n"
    "is seen next. The motion begins again at its end: it goes back to the first row for\n"
    "half a second if the last row differs from that. There can be lines late and ground\n"
    "as in a clip; # begins a comment.\n";

/// Reads markers as a clip of pins.
///
///   name    stands before every message
///   fails   where a row has not as many columns as the first, a number is wrong, times do not ascend, a
///           marker has no place at rest or is never seen, or there are fewer than two times
Expected<ClipFile> parse_markers(std::string_view text, const std::string& name);

/// Works as parse_markers(), from a file; fails also where it cannot be read.
Expected<ClipFile> load_markers(const std::string& path);

/// Where points of a figure are through a motion.
struct Tracks {
    std::vector<Point2> rest;
    std::vector<double> times;
    std::vector<std::vector<Point2>> places; // #times of #rest
};

/// The text of a file of markers, numbers to a hundredth of a unit.
///
///   of   the motion, whose late elements and ground are written too
std::string markers_text(const Tracks& tracks, const ClipFile& of, const std::string& heading);

} // namespace cageform_support

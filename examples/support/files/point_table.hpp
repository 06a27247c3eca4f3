#pragma once

// CSV files of points in space whose other columns stay, such as files of joints and bones.

#include "files/mesh_file.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// Help text on these files.
inline constexpr const char* point_table_format =
    "A CSV file of points has one point per line, such as a joint. The columns x,y,z of its\n"
    "header are the point; without these names, the first three numbers of each line. The\n"
    "other columns do not change. In a file of bones, as skin_mesh reads it, heads and tails\n"
    "move. Lines that begin with # stay.\n";

/// The points of a CSV file, in the order of the file.
struct PointTable {
    std::string name; ///< for messages
    std::string text;
    std::vector<Point3> points;
    std::vector<ObjNumbers> numbers;                  ///< #points: positions in the text
    std::vector<std::array<std::size_t, 2>> segments; ///< heads and tails of bones: indices of points
};

/// Parses a CSV file of points.
///
///   name    prefix of every message
///   fails   if a line has no point, a number of a point is not finite, or there are no points
Expected<PointTable> parse_point_table(std::string text, std::string name);

/// As parse_point_table(), from a file; fails also if it cannot be read.
Expected<PointTable> load_point_table(const std::string& path);

/// The text with moved points. Unchanged numbers keep their digits; others have the fewest digits that
/// restore them.
///
///   moved   #points
std::string to_text(const PointTable& table, std::span<const Point3> moved);

} // namespace cageform_support

#pragma once

// Landmarks: points of a source and their places on a target, from command line words and CSV files.

#include "files/mesh_file.hpp"
#include "files/point_table.hpp"

#include <cageform/fit/types/wrap.hpp>

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// Help text on landmarks.
inline constexpr const char* landmarks_format =
    "A landmark is a point of the source and its place on the target. Each is x,y,z, or the\n"
    "number of a vertex of its file, from 0:\n"
    "\n"
    "    --landmark 881:0,4.37,0.3      vertex 881 of the source, and a position\n"
    "    --landmark 881:412             vertex 412 of the target\n"
    "\n"
    "A CSV file has one landmark per line: VERTEX,VERTEX, or VERTEX,x,y,z, or x,y,z,x,y,z;\n"
    "then optionally a weight, 1 by default. An empty line, a line of words at the top and\n"
    "lines that begin with # are skipped. Of two files of points, SOURCE.csv:TARGET.csv, the\n"
    "first points are a landmark, then the second ones, and so on; a name in the first column\n"
    "has to be the same in both.\n";

/// Landmarks, and a name of each for messages: the option, or file and line.
struct Landmarks {
    std::vector<cageform::Landmark> marks;
    std::vector<std::string> names; ///< #marks

    /// "landmark 4 (pairs.csv:4)" for n = 3.
    std::string name(std::size_t n) const {
        return "landmark " + std::to_string(n + 1) + " (" + names[n] + ')';
    }
};

/// The vertices that landmarks may name.
struct LandmarkVertices {
    std::span<const Point3> source, target;
};

/// Parses SOURCE:TARGET, and appends the landmark. Returns the error; empty on success.
std::string parse_landmark(std::string_view word, const LandmarkVertices& vertices, Landmarks& landmarks);

/// Appends a landmark for each point of two files of points. Returns the error if their numbers or the names
/// of points differ; empty on success.
std::string add_landmarks(const PointTable& source, const PointTable& target, Landmarks& landmarks);

/// Parses a CSV file, and appends its landmarks. Returns the error with the line; empty on success.
std::string parse_landmarks(std::string_view text, const std::string& name, const LandmarkVertices& vertices,
                            Landmarks& landmarks);

} // namespace cageform_support

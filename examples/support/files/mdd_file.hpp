#pragma once

// MDD files, the point caches of LightWave, which Blender and Houdini write: the places of all vertices in
// each frame.

#include "files/obj_file.hpp"

#include <string>
#include <vector>

namespace cageform_support {

struct MddFile {
    std::vector<std::vector<Point3>> frames; ///< #frames · #vertices
    std::vector<double> times;               ///< #frames, in seconds, as the file has them
};

/// Reads an MDD file: the number of frames and that of vertices, whole numbers of 4 bytes; the times
/// of the frames; x, y, z of each vertex in each frame; all of them floats of 4 bytes, big-endian.
///
///   vertices   of the figure
///   fails      where it cannot be read, has another number of vertices, or is shorter or longer than it says
Expected<MddFile> load_mdd(const std::string& path, std::size_t vertices);

} // namespace cageform_support

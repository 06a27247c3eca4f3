#pragma once

// MDD files (point caches of LightWave, also written by Blender and Houdini): all vertex positions per frame.

#include "files/mesh_file.hpp"

#include <string>
#include <vector>

namespace cageform_support {

struct MddFile {
    std::vector<std::vector<Point3>> frames; ///< #frames · #vertices
    std::vector<double> times;               ///< #frames, in seconds
};

/// Reads an MDD file. All numbers are big-endian and have 4 bytes: the number of frames and of vertices
/// (integers), then floats: the times of the frames, and x, y, z of each vertex in each frame.
///
///   vertices   number of vertices of the figure
///   fails      if it cannot be read, has another number of vertices, or its size does not match
Expected<MddFile> load_mdd(const std::string& path, std::size_t vertices);

} // namespace cageform_support

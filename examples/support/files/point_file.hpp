#pragma once

// Reads points in space in blocks: vertices of PLY and OBJ files, and numpy arrays, all of any size. Vertices
// of glTF and STL files are read at once.

#include "files/mesh_file.hpp"
#include "files/ply_file.hpp"
#include "io/input_file.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace cageform_support {

/// Help text on files of points.
inline constexpr const char* point_file_format =
    "Points are the vertices of PLY and OBJ files (.ply, .obj), and arrays of numpy (.npy)\n"
    "of N x 3 numbers in float32 or float64, in C order, of any size; or the vertices of\n"
    "glTF and STL files (.glb, .gltf, .stl). Points that are not finite keep their place in\n"
    "the order, and no pose moves them. A warning counts them.\n";

/// Sequential reader of a file of points. The format follows from the extension.
class PointFile {
public:
    /// On failure error() is set.
    explicit PointFile(const std::string& path);

    /// Appends x, y and z of up to `most` points. Returns the number of points; 0 at the end and after a
    /// failure.
    std::size_t read(std::size_t most, std::vector<double>& numbers);

    /// Reads to the end. Returns hash_memory of all bytes of the file; nothing if it cannot be read.
    std::optional<std::uint64_t> hash_to_end();

    const std::string& error() const { return error_; } ///< the first error; empty if none
    bool may_retry() const;                             ///< InputFile::may_retry

private:
    bool fail(const std::string& why);
    void read_npy_header();
    bool read_vertex(std::vector<double>& numbers);
    bool read_row(std::vector<double>& numbers);

    std::string path_, error_;
    std::optional<PlyReader> ply_; // at most one of these four is set
    std::optional<LineReader> obj_;
    std::optional<InputFile> npy_;
    std::optional<std::vector<Point3>> mesh_; // vertices; unread from at_
    std::string buffer_;                      // of an array; unread from at_
    std::size_t at_ = 0;
    std::uint64_t left_ = 0; // remaining points of an array
    std::size_t number_bytes_ = 0;
};

} // namespace cageform_support

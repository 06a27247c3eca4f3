#pragma once

// Points in space from files of any size, in blocks: the vertices of PLY and OBJ files, arrays of numpy.

#include "files/ply_file.hpp"
#include "io/input_file.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace cageform_support {

/// The text for --help.
inline constexpr const char* point_file_format =
    "Points are the vertices of PLY and OBJ files (.ply, .obj), and arrays of numpy (.npy)\n"
    "of N x 3 numbers in float32 or float64, in C order. Points that are not finite keep\n"
    "their place in the order, and no pose moves them. A warning counts them.\n";

/// A file of points that is read from its beginning. Its kind follows from its ending.
class PointFile {
public:
    /// On failure `error()` says why: the file cannot be read, or is not of its kind.
    explicit PointFile(const std::string& path);

    /// Appends x, y and z of the next `most` points, or of all that are left. Returns the number of points; 0
    /// at their end and after a failure.
    std::size_t read(std::size_t most, std::vector<double>& numbers);

    /// Reads what is left. Returns hash_memory of all bytes of the file; nothing where it cannot be read.
    std::optional<std::uint64_t> hash_to_end();

    const std::string& error() const { return error_; } ///< the first failure; empty while there is none
    bool may_pass() const;                              ///< InputFile::may_pass

private:
    bool fail(const std::string& why);
    void read_npy_header();
    bool read_vertex(std::vector<double>& numbers);
    bool read_row(std::vector<double>& numbers);

    std::string path_, error_;
    std::optional<PlyReader> ply_; // one of these three
    std::optional<LineReader> obj_;
    std::optional<InputFile> npy_;
    std::string buffer_; // of an array, from at_
    std::size_t at_ = 0;
    std::uint64_t left_ = 0; // points of an array
    std::size_t number_bytes_ = 0;
};

} // namespace cageform_support

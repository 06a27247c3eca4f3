#pragma once

// Points in space from files of any size, in blocks: the vertices of PLY and OBJ files, arrays of numpy.

#include "files/input_file.hpp"
#include "files/ply_file.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace cageform_examples {

/// The text for --help.
inline constexpr const char* point_file_format =
    "Points are the vertices of PLY and OBJ files (.ply, .obj), and arrays of numpy (.npy)\n"
    "of N x 3 numbers in float32 or float64, in C order.\n";

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

    const std::string& error() const { return ply_ ? ply_->error() : error_; }    ///< the first; empty: none
    bool may_pass() const { return ply_ ? ply_->may_pass() : file_->may_pass(); } ///< InputFile::may_pass

private:
    enum class Kind : std::uint8_t { ply, obj, npy };

    bool fail(const std::string& why);
    bool read_more();
    void read_npy_header();
    bool read_vertex(std::vector<double>& numbers);

    std::string path_, error_;
    Kind kind_ = Kind::ply;
    std::optional<PlyReader> ply_;
    std::optional<InputFile> file_; // of the other kinds
    std::string buffer_;
    std::size_t at_ = 0; // in the buffer
    std::uint64_t line_ = 0;
    std::uint64_t left_ = 0; // points of an array
    std::size_t number_bytes_ = 0;
};

} // namespace cageform_examples

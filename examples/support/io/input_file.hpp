#pragma once

// Reading files. A failed read is an error, never the end of the file.

#include "io/expected.hpp"

#include <cageform/core/types/packed_data.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// A file or pipe that is read sequentially. Several threads may open files.
class InputFile {
public:
    /// On failure error() is set: the file does not exist, is a folder or cannot be opened.
    explicit InputFile(std::string path);
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;
    ~InputFile();

    /// Appends up to 64 KiB; false at the end and on an error.
    bool read(std::string& text);

    /// The first error, with the path; empty if none.
    const std::string& error() const { return error_; }
    /// Whether the failure may be temporary: a disk or network that does not respond, too many open files.
    bool may_retry() const { return may_retry_; }

    /// Reads to the end. Returns hash_memory of all bytes of the file; nothing if it cannot be read.
    std::optional<std::uint64_t> hash_to_end();

    /// Maps the file into memory; empty on a failure, for a pipe and for an empty file. The bytes are valid
    /// as long as this object, page-aligned and shared between processes.
    std::span<const std::byte> map();

    std::uintmax_t size() const { return size_; }              ///< in bytes; 0 for a pipe
    std::uintmax_t bytes_read() const { return read_so_far_; } ///< so far

private:
    std::string path_;
    int descriptor_ = -1;
    std::uintmax_t size_ = 0, read_so_far_ = 0;
    void* mapped_ = nullptr; // size_ bytes
    std::string error_;
    bool may_retry_ = false;
    cageform::MemoryHash hash_; // of the bytes read so far
};

/// Sorts the files of a sequence by their numbers if they are in alphabetical order, as shell patterns give
/// them: frame_10 before frame_2. One or two files, and files in any other order, keep their order. A '-'
/// before a number is a sign if some names have none there, as in n-1 and n0.
///
///   returns   notes for the user: that files were reordered, and the first gap of more than the smallest
///             step between two numbers
std::vector<std::string> order_by_numbers(std::vector<std::string>& files);

/// Reads a file or pipe line by line. Memory: about one line.
class LineReader {
public:
    /// On failure error() is set.
    ///
    ///   longest   maximum bytes per line; a longer line is an error
    explicit LineReader(const std::string& path, std::size_t longest = ~std::size_t{0});

    /// The next line without its \n, valid until the next call; false at the end of the file and on an error.
    bool next(std::string_view& line);

    /// Appends the rest of the file after the last line.
    void read_rest(std::string& text);
    std::optional<std::uint64_t> hash_to_end(); ///< InputFile::hash_to_end; no lines can be read after it

    const std::string& error() const { return error_; }
    bool may_retry() const { return file_.may_retry(); } ///< InputFile::may_retry

    /// Number of the last line, from 1.
    std::size_t line() const { return line_; }

    /// Fraction of the file that has been read, in [0, 1].
    double fraction() const;

private:
    std::string path_;
    InputFile file_;
    std::size_t longest_;
    std::string text_; // buffer; unread from at_
    std::size_t at_ = 0, line_ = 0;
    std::string error_;
};

/// Whether a failure with this errno may be temporary, so that a retry makes sense.
bool is_temporary_failure(int code);

/// The path under which this program opened the file at `path` as an InputFile; empty if it did not. Links,
/// hard links and different spellings of a path count as the same file.
std::string input_at(const std::filesystem::path& path);

/// The limit for files of meshes, in bytes. A program needs about 20 times as much memory.
inline constexpr std::uintmax_t largest_mesh_file = 2'000'000'000;

/// Reads all bytes of a file or pipe; fails as InputFile does, or if there are more than `most` bytes.
Expected<std::string> read_file(const std::string& path, std::uintmax_t most = ~std::uintmax_t{0});

/// As read_file(), but fails if the file is UTF-16.
Expected<std::string> read_text(const std::string& path);

/// Takes the first line off a text, without its \n; false if the text is empty.
bool take_line(std::string_view& text, std::string_view& line);

} // namespace cageform_support

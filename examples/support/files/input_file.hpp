#pragma once

// Reading files. A read that fails midway is an error, never the end of the file.

#include "svg/path.hpp"

#include <cageform/core/detail/packed_memory.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace cageform_examples {

/// A file, or a pipe, read from its beginning in pieces. Several threads may open files.
class InputFile {
public:
    /// On failure `error()` says why: there is no such file, it is a folder or cannot be opened.
    explicit InputFile(std::string path);
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;
    ~InputFile();

    /// Appends the next bytes of the file, 64 KiB at most; false at its end and on an error.
    bool read(std::string& text);

    /// The reason of the first failure, with the path; empty while there is none.
    const std::string& error() const { return error_; }
    /// Whether the failure may pass by itself: a disk or network that does not answer, too many open files.
    bool may_pass() const { return may_pass_; }

    /// Reads what is left. Returns hash_memory of all bytes of the file; nothing where it cannot be read.
    std::optional<std::uint64_t> hash_to_end();

    std::uintmax_t size() const { return size_; }              ///< bytes; 0 of a pipe
    std::uintmax_t bytes_read() const { return read_so_far_; } ///< so far

private:
    std::string path_;
    int descriptor_ = -1;
    std::uintmax_t size_ = 0, read_so_far_ = 0;
    std::string error_;
    bool may_pass_ = false;
    cageform::detail::MemoryHash hash_; // of the bytes read so far
};

/// Whether a failure with this value of errno may pass by itself, so that another try makes sense.
bool failure_may_pass(int code);

/// The path by which this program has opened, as an InputFile, the file at `path`; empty where it has not.
/// Both paths may lead to it by links, hard ones too, and detours.
std::string input_at(const std::filesystem::path& path);

/// All bytes of a file, or of a pipe; fails as InputFile does.
SvgResult<std::string> read_file(const std::string& path);

/// Takes the first line off a text, without its \n; false where the text is empty.
bool take_line(std::string_view& text, std::string_view& line);

} // namespace cageform_examples

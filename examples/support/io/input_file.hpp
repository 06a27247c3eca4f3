#pragma once

// Reading files. A read that fails midway is an error, never the end of the file.

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

    /// All bytes, read by the system where they are touched; none on a failure, of a pipe, and of an empty
    /// file. They live as long as this object, begin at a page, and several programs share them.
    std::span<const std::byte> map();

    std::uintmax_t size() const { return size_; }              ///< bytes; 0 of a pipe
    std::uintmax_t bytes_read() const { return read_so_far_; } ///< so far

private:
    std::string path_;
    int descriptor_ = -1;
    std::uintmax_t size_ = 0, read_so_far_ = 0;
    void* mapped_ = nullptr; // size_ bytes
    std::string error_;
    bool may_pass_ = false;
    cageform::MemoryHash hash_; // of the bytes read so far
};

/// Sorts the files of a sequence by their numbers. Shell patterns sort names by letters: frame_10 before
/// frame_2. Three or more files in that order are sorted. Files in any other order keep it. A
/// '-' before a number is a sign if some of the names have no '-' there, as n-1 and n0.
///
///   returns   notes. One says that files were reordered. Another names the files between which a number is
///             missing, if the other numbers rise by one step
std::vector<std::string> order_by_numbers(std::vector<std::string>& files);

/// The lines of a file, or of a pipe, one after the other; memory holds little more than one of them.
class LineReader {
public:
    /// On failure `error()` says why.
    ///
    ///   longest   a line of more bytes is an error
    explicit LineReader(const std::string& path, std::size_t longest = ~std::size_t{0});

    /// The next line without its \n, which lives until the next call; false at the end of the file and on an
    /// error.
    bool next(std::string_view& line);

    /// Appends all that follows the last line.
    void read_rest(std::string& text);
    std::optional<std::uint64_t> hash_to_end(); ///< InputFile::hash_to_end; no line comes after it

    const std::string& error() const { return error_; }
    bool may_pass() const { return file_.may_pass(); } ///< InputFile::may_pass

    /// Returns the number of the last line, counted from 1.
    std::size_t line() const { return line_; }

    /// Returns the share of the file that has been read, in [0, 1].
    double fraction() const;

private:
    std::string path_;
    InputFile file_;
    std::size_t longest_;
    std::string text_; // read and not yet taken, from at_
    std::size_t at_ = 0, line_ = 0;
    std::string error_;
};

/// Whether a failure with this value of errno may pass by itself, so that another try makes sense.
bool failure_may_pass(int code);

/// The path by which this program has opened, as an InputFile, the file at `path`; empty where it has not.
/// Both paths may lead to it by links, hard ones too, and detours.
std::string input_at(const std::filesystem::path& path);

/// All bytes of a file, or of a pipe; fails as InputFile does.
Expected<std::string> read_file(const std::string& path);

/// Works as read_file(), for texts: fails also where the file is UTF-16.
Expected<std::string> read_text(const std::string& path);

/// Takes the first line off a text, without its \n; false where the text is empty.
bool take_line(std::string_view& text, std::string_view& line);

} // namespace cageform_support

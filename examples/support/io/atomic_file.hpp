#pragma once

// Files written under a temporary name and renamed into place, so that readers never see half a file.

#include <cstdint>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// A file written in pieces under a temporary name in the same folder; `commit` renames it to `path`. On
/// failure, or without a commit, the old file is kept and the temporary file is removed. The temporary file
/// is also removed if SIGINT, SIGTERM, SIGHUP, SIGPIPE or SIGXCPU ends the program.
///
///   path   if a regular file exists there, it is replaced and its permissions are kept; links are followed.
///          Folders, pipes, devices and files that the program reads (input_at()) are refused; inputs are
///          checked again by finish()
///   sync   none: a power failure may lose the new contents
class AtomicFile {
public:
    explicit AtomicFile(const std::filesystem::path& path);
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;
    ~AtomicFile() { abandon(); }

    const std::filesystem::path& path() const { return path_; }
    /// The path that is written: `path` with links resolved.
    const std::filesystem::path& target() const { return target_; }
    /// The path until commit(). After finish() another program may read the file there.
    const std::filesystem::path& temporary() const { return temporary_; }
    /// A file descriptor for another program to write to, before any write() here; -1 after a failure.
    int descriptor() const { return file_ != nullptr ? fileno(file_) : -1; }

    /// Appends. After a failure, later calls do nothing.
    void write(std::string_view text);
    /// Overwrites existing bytes and flushes, so that all writes are visible through temporary().
    void write_at(std::uintmax_t offset, std::string_view text);
    void refuse(const std::string& why); ///< sets error() and removes the temporary file

    /// The first failure so far.
    const std::optional<std::string>& error() const { return error_; }
    /// Whether the failure may be temporary (is_temporary_failure()): the disk is full or does not respond.
    bool may_retry() const { return may_retry_; }

    /// Closes the temporary file; returns the error, if any. Afterwards nothing can be written, and only the
    /// renaming can fail.
    [[nodiscard]] std::optional<std::string> finish();

    /// Finishes the file and renames it to target(); returns the error, if any.
    [[nodiscard]] std::optional<std::string> commit();

    /// Before commit(): makes a hard link to the old file, which undo() restores. Does nothing if the file
    /// system has no hard links.
    void keep_old();
    /// Restores the old file after commit(); returns the error, if any.
    [[nodiscard]] std::optional<std::string> undo();
    void drop_old(); ///< removes the hard link, if any

private:
    void open();
    bool refuse_input(); // true if the program reads the file
    void refuse_code(int code);
    void abandon();

    std::filesystem::path path_;
    std::filesystem::path target_;
    std::filesystem::path temporary_;
    std::filesystem::path old_; // hard link to the old file; empty if none
    bool in_place_ = false;
    std::string registered_; // name of the temporary file, for the signal handler
    std::filesystem::file_status status_;
    std::FILE* file_ = nullptr;
    std::optional<std::string> error_;
    bool may_retry_ = false;
};

/// All output files of a program. They are renamed into place together, after all are complete.
class OutputFiles {
public:
    /// Adds a file; refuses one that is the same file as an earlier one, by any path.
    AtomicFile& add(const std::filesystem::path& path);

    /// The first failure so far.
    std::optional<std::string> error() const;

    /// Finishes all files, then renames them into place; returns the error, if any. If one renaming fails,
    /// the old files are restored. Without hard links this is impossible, and the error names the files that
    /// were replaced. Signals are blocked meanwhile.
    [[nodiscard]] std::optional<std::string> commit();

private:
    std::string undo(std::string why); // adds the files that could not be restored

    std::deque<AtomicFile> files_;
};

/// Commits all files. Returns the exit code of the program; prints the error, if any.
int commit(OutputFiles& outputs);

/// The extension of a path in lower case, such as ".svg".
std::string lowercase_extension(const std::filesystem::path& path);

/// Checks whether files can be written, before a long computation; returns the error, if any. Call it after
/// opening all input files. Empty paths are ignored; nothing is written.
std::optional<std::string> fault_of_outputs(const std::vector<std::filesystem::path>& paths);

/// Writes `contents` to `path`; returns the error, if any.
[[nodiscard]] std::optional<std::string> write_file_atomically(const std::filesystem::path& path,
                                                               std::string_view contents);

} // namespace cageform_support

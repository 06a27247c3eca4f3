#pragma once

// Files that appear whole or not at all, alone or together.

#include <cstdint>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_support {

/// A file written piece by piece under a temporary name in the same folder; `commit` puts it in the place
/// of `path`. Whatever fails, and without a commit, the old file stays and the temporary is removed, also
/// where SIGINT, SIGTERM, SIGHUP, SIGPIPE or SIGXCPU ends the program.
///
///   path    replaced if it is a regular file, whose permissions are kept; a link is followed; a folder,
///           pipe or device is refused, and so is a file that the program reads (input_at() names it), be
///           that before or after the output is opened
///   not     forced to the disk: a power cut may lose the new contents
class AtomicFile {
public:
    explicit AtomicFile(const std::filesystem::path& path);
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;
    ~AtomicFile() { abandon(); }

    const std::filesystem::path& path() const { return path_; }
    /// The final path: `path` without links and detours.
    const std::filesystem::path& target() const { return target_; }
    /// The temporary path until then. Another program may read the file after finish().
    const std::filesystem::path& temporary() const { return temporary_; }
    /// A descriptor that another program can write to, before anything is written here; -1 after a failure.
    int descriptor() const { return file_ != nullptr ? fileno(file_) : -1; }

    /// Appends; a failure is remembered, later calls do nothing.
    void write(std::string_view text);
    /// Writes over bytes that are there, and lets other readers of temporary() see all that is written.
    void write_at(std::uintmax_t offset, std::string_view text);
    void refuse(const std::string& why); ///< remembers a failure and removes the temporary

    /// The first failure so far.
    const std::optional<std::string>& error() const { return error_; }
    /// Whether it may pass by itself (failure_may_pass()): the disk is full, or does not answer.
    bool may_pass() const { return may_pass_; }

    /// Completes the temporary: what can fail has failed, but for the renaming. Nothing is written after
    /// it.
    [[nodiscard]] std::optional<std::string> finish();

    /// Finishes the file and puts it in its place; returns nothing, or the reason of the failure.
    [[nodiscard]] std::optional<std::string> commit();

    /// Before commit(): gives the old file a second name, from which undo() brings it back; not where the
    /// file system has no hard links.
    void keep_old();
    /// After commit() or a failure: the place is as it was. Nothing, or the reason why it is not.
    [[nodiscard]] std::optional<std::string> undo();
    void drop_old(); ///< removes the second name, if there is one

private:
    void open();
    bool refuse_input(); // whether it is a file that is read
    void refuse_code(int code);
    void abandon();

    std::filesystem::path path_;
    std::filesystem::path target_;
    std::filesystem::path temporary_;
    std::filesystem::path old_; // second name of the file that was there, while it is kept
    bool in_place_ = false;
    std::string registered_; // the temporary's name, for the signal handler
    std::filesystem::file_status status_;
    std::FILE* file_ = nullptr;
    std::optional<std::string> error_;
    bool may_pass_ = false;
};

/// All files that a program writes: none is in its place before all are complete.
class OutputFiles {
public:
    /// A further file. One that is the same file as another, by whatever path, is refused.
    AtomicFile& add(const std::filesystem::path& path);

    /// The first failure so far.
    std::optional<std::string> error() const;

    /// Finishes all files, then puts them in their places; returns nothing, or the reason of the failure.
    /// Where one cannot be put in its place, the others leave theirs, and what was there is there again
    /// (where the file system has hard links: else the reason names the files that stay). Signals wait.
    [[nodiscard]] std::optional<std::string> commit();

private:
    std::string undo(std::string why); // adds the files that stay

    std::deque<AtomicFile> files_;
};

/// The ending of a path in small letters, such as ".svg": it says what kind of file is written.
std::string ending_of(const std::filesystem::path& path);

/// Why one of these files cannot be written, for a program that asks before it computes for long: after it
/// has opened what it reads. Empty paths are left out; nothing is written.
std::optional<std::string> fault_of_outputs(const std::vector<std::filesystem::path>& paths);

/// Writes all of `contents` to `path`; returns nothing, or the reason of the failure.
[[nodiscard]] std::optional<std::string> write_file_atomically(const std::filesystem::path& path,
                                                               std::string_view contents);

} // namespace cageform_support

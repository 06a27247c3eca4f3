#pragma once

// Files that appear whole or not at all.

#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace cageform_examples {

/// A file written piece by piece under a temporary name in the same folder; `commit` puts it in the place
/// of `path`. Whatever fails, and without a commit, the old file stays and the temporary is removed.
///
///   path    replaced if it is a regular file, whose permissions are kept; a link is followed; a folder,
///           pipe or device is refused
///   not     forced to the disk: a power cut may lose the new contents
class AtomicFile {
public:
    explicit AtomicFile(const std::filesystem::path& path);
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;
    ~AtomicFile() { abandon(); }

    /// Appends; a failure is remembered, later calls do nothing.
    void write(std::string_view text);

    /// The first failure so far.
    const std::optional<std::string>& error() const { return error_; }

    /// Finishes the file; returns nothing, or the reason of the failure.
    [[nodiscard]] std::optional<std::string> commit();

private:
    void refuse(const std::string& why);
    void abandon();

    std::filesystem::path path_;
    std::filesystem::path target_;
    std::filesystem::path temporary_;
    std::filesystem::file_status status_;
    std::FILE* file_ = nullptr;
    std::optional<std::string> error_;
};

/// Writes all of `contents` to `path`; returns nothing, or the reason of the failure.
[[nodiscard]] std::optional<std::string> write_file_atomically(const std::filesystem::path& path,
                                                               std::string_view contents);

} // namespace cageform_examples

#include "atomic_file.hpp"

#include <cerrno>
#include <random>
#include <system_error>

namespace cageform_examples {

AtomicFile::AtomicFile(const std::filesystem::path& path)
    : path_(path)
    , target_(path) {
    namespace fs = std::filesystem;
    std::error_code error;
    status_ = fs::status(path, error);
    if (fs::exists(status_)) {
        if (!fs::is_regular_file(status_))
            refuse("it is not a regular file");
        else
            target_ = fs::canonical(path, error);
        if (error) refuse(error.message());
    }
    if (error_) return;
    std::random_device random;
    for (int attempt = 0; attempt < 16 && file_ == nullptr; ++attempt) {
        temporary_ = target_;
        temporary_ += ".tmp" + std::to_string(random());
        file_ = std::fopen(temporary_.string().c_str(), "wbx"); // x: never opens a file of someone else
        if (file_ == nullptr && errno != EEXIST) break;
    }
    if (file_ == nullptr) refuse(std::generic_category().message(errno));
}

void AtomicFile::write(std::string_view text) {
    if (file_ == nullptr) return;
    errno = 0;
    if (std::fwrite(text.data(), 1, text.size(), file_) == text.size()) return;
    refuse(std::generic_category().message(errno));
    abandon();
}

std::optional<std::string> AtomicFile::commit() {
    if (file_ == nullptr) return error_;
    std::error_code error;
    errno = 0;
    const bool flushed = std::fflush(file_) == 0;
    if (!flushed) error.assign(errno, std::generic_category());
    const bool closed = std::fclose(file_) == 0;
    if (flushed && !closed) error.assign(errno, std::generic_category());
    file_ = nullptr;
    if (!error && std::filesystem::exists(status_)) {
        std::filesystem::permissions(temporary_, status_.permissions(), error);
    }
    if (!error) std::filesystem::rename(temporary_, target_, error);
    if (error) {
        refuse(error.message());
        std::filesystem::remove(temporary_, error);
    }
    return error_;
}

void AtomicFile::refuse(const std::string& why) {
    if (!error_) error_ = "cannot write " + path_.string() + ": " + why;
}

void AtomicFile::abandon() {
    if (file_ == nullptr) return;
    std::fclose(file_);
    file_ = nullptr;
    std::error_code ignored;
    std::filesystem::remove(temporary_, ignored);
}

std::optional<std::string> write_file_atomically(const std::filesystem::path& path,
                                                 std::string_view contents) {
    AtomicFile file(path);
    file.write(contents);
    return file.commit();
}

} // namespace cageform_examples

#include "io/atomic_file.hpp"

#include "io/input_file.hpp"
#include "io/messages.hpp"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <random>
#include <system_error>

#include <unistd.h>

namespace cageform_support {

/// Names of temporary files for the signal handler, which may only call async-signal-safe functions such as
/// unlink(). With more files than slots, a signal leaves the last ones behind.
static std::array<std::atomic<const char*>, 128> temporaries;

extern "C" void remove_temporaries_and_end(int number) {
    for (const auto& name : temporaries) {
        if (const char* const path = name.load()) unlink(path);
    }
    std::signal(number, SIG_DFL);
    std::raise(number); // delivered after this handler returns
}

static constexpr std::array ending_signals{SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXCPU};

/// Installs the handler once, for signals with the default action. Ignored signals stay ignored.
static void catch_signals() {
    static const bool done = [] {
        const auto set = [](int number, void (*handler)(int)) {
            struct sigaction old{};
            if (sigaction(number, nullptr, &old) == 0 && old.sa_handler == SIG_DFL)
                std::signal(number, handler);
        };
        for (const int number : ending_signals) set(number, remove_temporaries_and_end);
        set(SIGXFSZ, SIG_IGN); // a write beyond the file size limit then fails with EFBIG
        return true;
    }();
    (void)done;
}

static void register_temporary(const char* path) {
    for (auto& place : temporaries) {
        const char* none = nullptr;
        if (place.compare_exchange_strong(none, path)) return;
    }
}

static void forget_temporary(const char* path) {
    for (auto& place : temporaries) {
        const char* expected = path;
        if (place.compare_exchange_strong(expected, nullptr)) return;
    }
}

AtomicFile::AtomicFile(const std::filesystem::path& path)
    : path_(path)
    , target_(path) {
    open();
}

void AtomicFile::open() {
    namespace fs = std::filesystem;
    std::error_code error;
    status_ = fs::status(path_, error);
    if (fs::exists(status_)) {
        if (!fs::is_regular_file(status_)) return refuse("it is not a regular file");
        target_ = fs::canonical(path_, error);
        if (error) return refuse(error.message());
        if (refuse_input()) return;
    } else {
        fs::path place = fs::absolute(path_);
        for (int links = 0; links < 40 && fs::is_symlink(fs::symlink_status(place, error)); ++links) {
            place = place.parent_path() / fs::read_symlink(place, error); // its target does not exist
        }
        const fs::path folder = fs::weakly_canonical(place.parent_path(), error);
        if (!error) target_ = folder / place.filename();
    }
    catch_signals();
    std::random_device random;
    for (int attempt = 0; attempt < 16 && file_ == nullptr; ++attempt) {
        temporary_ = target_;
        temporary_ += ".tmp" + std::to_string(random());
        file_ = std::fopen(temporary_.c_str(), "wbx"); // x: fails if the file exists
        if (file_ == nullptr && errno != EEXIST) break;
    }
    if (file_ == nullptr) return refuse_code(errno);
    registered_ = temporary_.string();
    register_temporary(registered_.c_str());
}

void AtomicFile::write(std::string_view text) {
    if (file_ == nullptr || text.empty()) return;
    errno = 0;
    if (std::fwrite(text.data(), 1, text.size(), file_) == text.size()) return;
    refuse_code(errno);
}

void AtomicFile::write_at(std::uintmax_t offset, std::string_view text) {
    if (file_ == nullptr) return;
    errno = 0;
    if (fseeko(file_, off_t(offset), SEEK_SET) == 0 &&
        std::fwrite(text.data(), 1, text.size(), file_) == text.size() && fseeko(file_, 0, SEEK_END) == 0 &&
        std::fflush(file_) == 0)
        return;
    refuse_code(errno);
}

std::optional<std::string> AtomicFile::finish() {
    if (file_ == nullptr || refuse_input()) return error_;
    errno = 0;
    const bool flushed = std::fflush(file_) == 0;
    const int code = errno;
    const bool closed = std::fclose(file_) == 0;
    file_ = nullptr;
    std::error_code error;
    if (!flushed || !closed) error.assign(flushed ? errno : code, std::generic_category());
    if (!error && std::filesystem::exists(status_))
        std::filesystem::permissions(temporary_, status_.permissions(), error);
    if (error) refuse_code(error.value());
    return error_;
}

std::optional<std::string> AtomicFile::commit() {
    if (finish()) return error_;
    std::error_code error;
    std::filesystem::rename(temporary_, target_, error);
    if (error) {
        refuse_code(error.value());
        return error_;
    }
    in_place_ = true;
    forget_temporary(registered_.c_str());
    registered_.clear();
    return std::nullopt;
}

void AtomicFile::keep_old() {
    if (!std::filesystem::exists(status_)) return;
    std::filesystem::path name = temporary_;
    name += ".old";
    std::error_code error;
    std::filesystem::create_hard_link(target_, name, error);
    if (!error) old_ = name;
}

std::optional<std::string> AtomicFile::undo() {
    if (!in_place_) {
        drop_old();
        return std::nullopt;
    }
    std::error_code error;
    if (!old_.empty()) {
        std::filesystem::rename(old_, target_, error);
    } else if (!std::filesystem::exists(status_)) {
        std::filesystem::remove(target_, error);
    } else {
        return path_.string() + " was not restored";
    }
    if (error) {
        const std::string kept = old_.empty() ? "" : "; the old file is " + old_.string();
        return path_.string() + " was not restored (" + error.message() + ")" + kept;
    }
    old_.clear();
    in_place_ = false;
    return std::nullopt;
}

void AtomicFile::drop_old() {
    std::error_code ignored;
    if (!old_.empty()) std::filesystem::remove(old_, ignored);
    old_.clear();
}

void AtomicFile::refuse(const std::string& why) {
    if (!error_) error_ = "cannot write " + path_.string() + ": " + why;
    abandon();
}

void AtomicFile::refuse_code(int code) {
    may_retry_ = may_retry_ || (!error_ && is_temporary_failure(code));
    refuse(std::generic_category().message(code));
}

bool AtomicFile::refuse_input() {
    const std::string input = input_at(path_);
    if (!input.empty()) refuse("it is the same file as " + input + ", which is read");
    return !input.empty();
}

void AtomicFile::abandon() {
    if (file_ != nullptr) std::fclose(file_);
    file_ = nullptr;
    if (registered_.empty()) return;
    unlink(registered_.c_str());
    forget_temporary(registered_.c_str());
    registered_.clear();
}

/// Blocks the signals that end the program, so that all files are renamed or none.
class BlockSignals {
public:
    BlockSignals() {
        sigset_t ending;
        sigemptyset(&ending);
        for (const int number : ending_signals) sigaddset(&ending, number);
        pthread_sigmask(SIG_BLOCK, &ending, &before_);
    }
    BlockSignals(const BlockSignals&) = delete;
    BlockSignals& operator=(const BlockSignals&) = delete;
    ~BlockSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

private:
    sigset_t before_{};
};

AtomicFile& OutputFiles::add(const std::filesystem::path& path) {
    AtomicFile& file = files_.emplace_back(path);
    for (const AtomicFile& other : files_) {
        if (&other == &file || other.target() != file.target()) continue;
        file.refuse("it is the same file as " + other.path().string() + ", which is written too");
    }
    return file;
}

std::optional<std::string> OutputFiles::error() const {
    for (const AtomicFile& file : files_) {
        if (file.error()) return file.error();
    }
    return std::nullopt;
}

std::optional<std::string> OutputFiles::commit() {
    for (AtomicFile& file : files_) {
        if (auto why = file.finish()) return why;
    }
    const BlockSignals wait;
    if (files_.size() > 1) {
        for (AtomicFile& file : files_) file.keep_old();
    }
    for (AtomicFile& file : files_) {
        if (const auto why = file.commit()) return undo(*why);
    }
    for (AtomicFile& file : files_) file.drop_old();
    return std::nullopt;
}

std::string OutputFiles::undo(std::string why) {
    for (AtomicFile& file : files_) {
        if (const auto stays = file.undo()) why += "; " + *stays;
    }
    return why;
}

int commit(OutputFiles& outputs) {
    const auto error = outputs.commit();
    return error ? fail(*error) : 0;
}

std::string lowercase_extension(const std::filesystem::path& path) {
    std::string ending = path.extension().string();
    for (char& c : ending) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
    return ending;
}

std::optional<std::string> fault_of_outputs(const std::vector<std::filesystem::path>& paths) {
    OutputFiles outputs;
    for (const std::filesystem::path& path : paths) {
        if (!path.empty()) outputs.add(path);
    }
    return outputs.error();
}

std::optional<std::string> write_file_atomically(const std::filesystem::path& path,
                                                 std::string_view contents) {
    AtomicFile file(path);
    file.write(contents);
    return file.commit();
}

} // namespace cageform_support

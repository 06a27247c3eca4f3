#include "io/input_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <mutex>
#include <set>
#include <span>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace cageform_support {

namespace {

/// A file name split into text and numbers. Numbers compare by value.
struct NumberedName {
    std::vector<std::string> text;    // #numbers + 1: before, between and after the numbers
    std::vector<std::string> numbers; // without leading zeros
    std::vector<bool> is_negative;    // #numbers

    ///   has_signs   whether a '-' before a number is a sign
    NumberedName(const std::string& name, bool has_signs) {
        text.emplace_back();
        bool in_number = false;
        for (const char c : name) {
            const bool is_digit = c >= '0' && c <= '9';
            if (is_digit && !in_number) numbers.emplace_back();
            if (!is_digit && in_number) text.emplace_back();
            in_number = is_digit;
            if (!is_digit)
                text.back() += c;
            else if (numbers.back() == "0")
                numbers.back() = c;
            else
                numbers.back() += c;
        }
        if (in_number) text.emplace_back();
        for (std::size_t k = 0; k < numbers.size(); ++k) {
            is_negative.push_back(has_signs && text[k].ends_with('-'));
            if (is_negative[k]) text[k].pop_back();
        }
    }
    bool operator<(const NumberedName& other) const {
        for (std::size_t k = 0; k < text.size() && k < other.text.size(); ++k) {
            if (text[k] != other.text[k]) return text[k] < other.text[k];
            if (k == numbers.size() || k == other.numbers.size()) break;
            const std::string &a = numbers[k], &b = other.numbers[k];
            if (is_negative[k] != other.is_negative[k]) return bool(is_negative[k]);
            if (a != b) return (a.size() != b.size() ? a.size() < b.size() : a < b) != is_negative[k];
        }
        return text.size() < other.text.size();
    }
};

std::int64_t value_of(const NumberedName& name, std::size_t number) {
    return (name.is_negative[number] ? -1 : 1) * std::stoll(name.numbers[number]);
}

/// The difference of two names that differ in one number; 0 if they differ otherwise.
std::uint64_t step_between(const NumberedName& a, const NumberedName& b) {
    std::int64_t step = 0;
    std::size_t differences = 0;
    constexpr std::size_t most_digits = 15;
    for (std::size_t k = 0; a.text == b.text && k < a.numbers.size(); ++k) {
        if (a.numbers[k] == b.numbers[k] && a.is_negative[k] == b.is_negative[k]) continue;
        ++differences;
        if (a.numbers[k].size() > most_digits || b.numbers[k].size() > most_digits) return 0;
        step = value_of(b, k) - value_of(a, k);
    }
    return differences == 1 ? std::uint64_t(step) : 0;
}

/// Whether a '-' before a number is a sign: some names have it, and otherwise equal names do not.
bool has_signs(const std::vector<std::string>& files) {
    std::set<std::vector<std::string>> texts, without_signs;
    for (const std::string& file : files) {
        texts.insert(NumberedName(file, false).text);
        without_signs.insert(NumberedName(file, true).text);
    }
    return without_signs.size() < texts.size();
}

} // namespace

std::vector<std::string> order_by_numbers(std::vector<std::string>& files) {
    const auto numbered = [has_signs = has_signs(files)](const std::string& name) {
        return NumberedName(name, has_signs);
    };
    const auto by_number = [&](const std::string& a, const std::string& b) {
        return numbered(a) < numbered(b);
    };
    std::vector<std::string> notes;
    const bool is_numbered = std::is_sorted(files.begin(), files.end(), by_number);
    // Two names, and names in neither numeric nor alphabetical order, are not sorted.
    if (files.size() < 3 || (!is_numbered && !std::is_sorted(files.begin(), files.end()))) return notes;
    if (!is_numbered) {
        std::stable_sort(files.begin(), files.end(), by_number);
        notes.push_back("the files were put in the order of their numbers, from " + files.front() + " to " +
                        files.back());
    }
    std::vector<std::uint64_t> steps;
    for (std::size_t k = 1; k < files.size(); ++k)
        steps.push_back(step_between(numbered(files[k - 1]), numbered(files[k])));
    const std::uint64_t least = *std::min_element(steps.begin(), steps.end());
    for (std::size_t k = 0; least > 0 && k < steps.size(); ++k) {
        if (steps[k] == least) continue;
        notes.push_back("a number is missing between " + files[k] + " and " + files[k + 1] + ": others are " +
                        std::to_string(least) + " apart");
        break;
    }
    return notes;
}

/// The paths of all files that were opened so far.
static std::set<std::string>& inputs() {
    static std::set<std::string> all;
    return all;
}

static std::mutex& lock_of_inputs() {
    static std::mutex lock;
    return lock;
}

bool is_temporary_failure(int code) {
    constexpr std::array passing{EIO,    ENOSPC, EDQUOT, EMFILE, ENFILE,    ENOMEM,
                                 EAGAIN, EBUSY,  ESTALE, EINTR,  ETIMEDOUT, ENETDOWN};
    return std::find(passing.begin(), passing.end(), code) != passing.end();
}

InputFile::InputFile(std::string path)
    : path_(std::move(path)) {
    const auto refuse = [this](const std::string& why) { error_ = path_ + ": " + why; };
    descriptor_ = open(path_.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status{};
    if (descriptor_ < 0 || fstat(descriptor_, &status) != 0) {
        const int code = errno;
        may_retry_ = is_temporary_failure(code);
        refuse(code == ENOENT ? "no such file"
                              : "cannot be opened: " + std::generic_category().message(code));
    } else if (S_ISDIR(status.st_mode)) {
        refuse("is a folder");
    } else if (S_ISREG(status.st_mode)) {
        size_ = std::uintmax_t(status.st_size);
        const std::lock_guard guard(lock_of_inputs());
        inputs().insert(path_);
    }
}

InputFile::~InputFile() {
    if (mapped_ != nullptr) munmap(mapped_, std::size_t(size_));
    if (descriptor_ >= 0) close(descriptor_);
}

std::span<const std::byte> InputFile::map() {
    if (!error_.empty() || size_ == 0) return {};
    if (mapped_ == nullptr) {
        void* const all = mmap(nullptr, std::size_t(size_), PROT_READ, MAP_PRIVATE, descriptor_, 0);
        if (all == MAP_FAILED) {
            error_ = path_ + ": cannot be mapped: " + std::generic_category().message(errno);
            return {};
        }
        mapped_ = all;
    }
    return {static_cast<const std::byte*>(mapped_), std::size_t(size_)};
}

bool InputFile::read(std::string& text) {
    if (!error_.empty()) return false;
    constexpr std::size_t most = 65536;
    const std::size_t before = text.size();
    text.resize(before + most);
    ssize_t count = 0;
    do count = ::read(descriptor_, text.data() + before, most);
    while (count < 0 && errno == EINTR);
    const int code = errno;
    text.resize(before + std::size_t(std::max<ssize_t>(count, 0)));
    read_so_far_ += text.size() - before;
    hash_.add(std::as_bytes(std::span(text).subspan(before)));
    may_retry_ = may_retry_ || (count < 0 && is_temporary_failure(code));
    if (count < 0) error_ = path_ + ": cannot be read: " + std::generic_category().message(code);
    return count > 0;
}

std::optional<std::uint64_t> InputFile::hash_to_end() {
    for (std::string text; read(text);) text.clear();
    if (!error_.empty()) return std::nullopt;
    return hash_.value();
}

std::string input_at(const std::filesystem::path& path) {
    const std::lock_guard guard(lock_of_inputs());
    std::error_code none; // for inputs that no longer exist
    for (const std::string& input : inputs()) {
        if (std::filesystem::equivalent(path, input, none)) return input;
    }
    return {};
}

Expected<std::string> read_file(const std::string& path, std::uintmax_t most) {
    InputFile file(path);
    std::string text;
    while (file.size() <= most && text.size() <= most && file.read(text)) continue;
    if (std::max<std::uintmax_t>(file.size(), text.size()) > most)
        return FileError{path + ": has more than " + std::to_string(most / 1'000'000) + " MB"};
    if (!file.error().empty()) return FileError{file.error()};
    return text;
}

/// Returns the error if a text begins with the byte order mark of UTF-16; else empty.
static std::string encoding_fault(std::string_view text) {
    const bool is_wide = text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff");
    return is_wide ? ": is UTF-16 text, but only UTF-8 is read: save it as UTF-8" : "";
}

Expected<std::string> read_text(const std::string& path) {
    auto text = read_file(path);
    if (const std::string why = text ? encoding_fault(*text) : ""; !why.empty()) return FileError{path + why};
    return text;
}

bool take_line(std::string_view& text, std::string_view& line) {
    if (text.empty()) return false;
    const std::size_t end = text.find('\n');
    line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    return true;
}

LineReader::LineReader(const std::string& path, std::size_t longest)
    : path_(path)
    , file_(path)
    , longest_(longest) {
    if (!file_.read(text_)) error_ = file_.error().empty() ? path + ": is empty" : file_.error();
    if (const std::string why = encoding_fault(text_); !why.empty()) error_ = path + why;
}

bool LineReader::next(std::string_view& line) {
    if (!error_.empty()) return false;
    std::size_t end = text_.find('\n', at_);
    while (end == std::string::npos && text_.size() - at_ <= longest_) {
        text_.erase(0, at_);
        at_ = 0;
        const std::size_t searched = text_.size();
        if (!file_.read(text_)) break;
        end = text_.find('\n', searched);
    }
    error_ = file_.error();
    std::string_view rest = std::string_view(text_).substr(at_);
    if (!error_.empty() || !take_line(rest, line)) return false;
    ++line_;
    if (line.size() > longest_) {
        error_ = path_ + ":" + std::to_string(line_) + ": the line has more than " +
                 std::to_string(longest_) + " bytes";
        return false;
    }
    at_ = text_.size() - rest.size();
    return true;
}

void LineReader::read_rest(std::string& text) {
    text.append(text_, at_);
    text_.clear();
    at_ = 0;
    while (file_.read(text)) continue;
    if (error_.empty()) error_ = file_.error();
}

std::optional<std::uint64_t> LineReader::hash_to_end() {
    const auto hash = file_.hash_to_end();
    if (error_.empty()) error_ = file_.error();
    return hash;
}

double LineReader::fraction() const {
    return file_.size() > 0 ? std::min(double(file_.bytes_read()) / double(file_.size()), 1.0) : 1.0;
}

} // namespace cageform_support

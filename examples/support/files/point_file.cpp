#include "files/point_file.hpp"

#include "files/atomic_file.hpp"
#include "files/csv.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>

namespace cageform_examples {

static constexpr std::size_t longest_obj_line = std::size_t{1} << 20; // bytes, of an OBJ file

PointFile::PointFile(const std::string& path)
    : path_(path) {
    const std::string ending = ending_of(path);
    kind_ = ending == ".obj" ? Kind::obj : ending == ".npy" ? Kind::npy : Kind::ply;
    if (kind_ == Kind::ply) {
        ply_.emplace(path);
        (void)ply_->begin("vertex", {"x", "y", "z"});
        return;
    }
    file_.emplace(path);
    error_ = file_->error();
    if (kind_ == Kind::npy && error_.empty()) read_npy_header();
}

bool PointFile::fail(const std::string& why) {
    if (error_.empty()) error_ = file_->error().empty() ? path_ + ": " + why : file_->error();
    return false;
}

bool PointFile::read_more() {
    buffer_.erase(0, at_);
    at_ = 0;
    return file_->read(buffer_);
}

/// The header is a text of Python: {'descr': '<f4', 'fortran_order': False, 'shape': (9, 3), }.
void PointFile::read_npy_header() {
    constexpr std::size_t prefix = 12;
    while (buffer_.size() < prefix && read_more()) continue;
    if (buffer_.size() < prefix || !buffer_.starts_with("\x93NUMPY")) {
        (void)fail("is no .npy file");
        return;
    }
    const auto byte = [&](std::size_t k) { return std::size_t(std::uint8_t(buffer_[k])); };
    const bool is_long = byte(6) > 1;
    const std::size_t begin = is_long ? prefix : 10;
    const std::size_t size = byte(8) + (byte(9) << 8) + (is_long ? (byte(10) << 16) + (byte(11) << 24) : 0);
    constexpr std::size_t longest = std::size_t{1} << 20;
    while (size <= longest && buffer_.size() < begin + size && read_more()) continue;
    if (buffer_.size() < begin + size) {
        (void)fail("is cut off in its header");
        return;
    }
    const std::string header = buffer_.substr(begin, size);
    at_ = begin + size;
    number_bytes_ = header.find("'<f4'") != std::string::npos   ? 4
                    : header.find("'<f8'") != std::string::npos ? 8
                                                                : 0;
    const std::size_t shape = header.find('(');
    const bool has_shape = shape != std::string::npos;
    const char* const end = header.data() + header.size();
    const auto [after, code] =
        has_shape ? std::from_chars(header.data() + shape + 1, end, left_) : std::from_chars_result{end, {}};
    const bool is_sound = has_shape && code == std::errc() &&
                          std::string_view(after, end).starts_with(", 3)") && number_bytes_ != 0 &&
                          header.find("True") == std::string::npos &&
                          std::endian::native == std::endian::little;
    if (!is_sound) {
        (void)fail("is no array of N x 3 numbers in float32 or float64, in C order and little endian");
        return;
    }
    const auto bytes = file_->size() - std::min<std::uintmax_t>(file_->size(), at_);
    if (file_->size() != 0 && left_ > bytes / (3 * number_bytes_))
        (void)fail("is cut off: it is too short for its " + std::to_string(left_) + " points");
}

/// Appends the next vertex of an OBJ file; false at the end and after a failure.
bool PointFile::read_vertex(std::vector<double>& numbers) {
    for (;;) {
        std::size_t end = buffer_.find('\n', at_);
        while (end == std::string::npos && buffer_.size() - at_ < longest_obj_line && read_more())
            end = buffer_.find('\n');
        if (end == std::string::npos && buffer_.size() - at_ >= longest_obj_line)
            return fail("line " + std::to_string(line_ + 1) + ": is too long for an OBJ file");
        if (!file_->error().empty()) return fail({});
        if (end == std::string::npos) end = buffer_.size();
        if (at_ == buffer_.size()) return false;
        std::string_view line = std::string_view(buffer_).substr(at_, end - at_);
        at_ = std::min(end + 1, buffer_.size());
        ++line_;
        line = detail::trim(line);
        if (line.find('\0') != std::string_view::npos)
            return fail("line " + std::to_string(line_) + ": is no text, so this is no OBJ file");
        if (!line.starts_with("v ") && !line.starts_with("v\t")) continue;
        for (int k = 0; k < 3; ++k) {
            line.remove_prefix(std::min(line.find_first_of(" \t"), line.size()));
            line = detail::trim(line);
            double number = 0;
            const std::string why = detail::parse_number(line.substr(0, line.find_first_of(" \t")), number);
            if (!why.empty()) return fail("line " + std::to_string(line_) + ": " + why);
            numbers.push_back(number);
        }
        return true;
    }
}

std::size_t PointFile::read(std::size_t most, std::vector<double>& numbers) {
    if (ply_) return ply_->read(most, numbers);
    const std::size_t before = numbers.size();
    std::size_t count = 0;
    if (kind_ == Kind::obj) {
        while (error_.empty() && count < most && read_vertex(numbers)) ++count;
    } else {
        most = std::size_t(std::min<std::uint64_t>(most, left_));
        const std::size_t bytes = 3 * number_bytes_;
        for (; error_.empty() && count < most; ++count, --left_) {
            while (buffer_.size() - at_ < bytes && read_more()) continue;
            if (buffer_.size() - at_ < bytes) {
                (void)fail("is cut off");
                break;
            }
            for (int k = 0; k < 3; ++k, at_ += number_bytes_) {
                float single = 0;
                double number = 0;
                std::memcpy(number_bytes_ == 4 ? static_cast<void*>(&single) : &number, buffer_.data() + at_,
                            number_bytes_);
                numbers.push_back(number_bytes_ == 4 ? double(single) : number);
            }
        }
    }
    if (error_.empty()) return count;
    numbers.resize(before);
    return 0;
}

std::optional<std::uint64_t> PointFile::hash_to_end() {
    const auto hash = ply_ ? ply_->hash_to_end() : file_->hash_to_end();
    if (!hash && !ply_) (void)fail({});
    return hash;
}

} // namespace cageform_examples

#include "files/point_file.hpp"

#include "io/atomic_file.hpp"
#include "io/csv.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>

namespace cageform_support {

PointFile::PointFile(const std::string& path)
    : path_(path) {
    constexpr std::size_t longest_line = std::size_t{1} << 20; // bytes
    const std::string ending = lowercase_extension(path);
    if (ending == ".obj") {
        error_ = obj_.emplace(path, longest_line).error();
    } else if (ending == ".npy") {
        error_ = npy_.emplace(path).error();
        if (error_.empty()) read_npy_header();
    } else if (ending == ".glb" || ending == ".gltf" || ending == ".stl") {
        auto mesh = load_mesh(path);
        if (mesh)
            mesh_ = std::move(mesh->vertices);
        else
            error_ = to_string(mesh.error());
    } else {
        (void)ply_.emplace(path).begin("vertex", {"x", "y", "z"});
        error_ = ply_->error();
    }
}

bool PointFile::may_retry() const {
    return ply_ ? ply_->may_retry() : obj_ ? obj_->may_retry() : npy_ && npy_->may_retry();
}

bool PointFile::fail(const std::string& why) {
    if (error_.empty()) error_ = path_ + ": " + why;
    return false;
}

/// The header is a Python literal: {'descr': '<f4', 'fortran_order': False, 'shape': (9, 3), }.
void PointFile::read_npy_header() {
    constexpr std::size_t prefix = 12;
    while (buffer_.size() < prefix && npy_->read(buffer_)) continue;
    if (buffer_.size() < prefix || !buffer_.starts_with("\x93NUMPY")) {
        (void)fail("is no .npy file");
        return;
    }
    const auto byte = [&](std::size_t k) { return std::size_t(std::uint8_t(buffer_[k])); };
    const bool is_long = byte(6) > 1;
    const std::size_t begin = is_long ? prefix : 10;
    const std::size_t size = byte(8) + (byte(9) << 8) + (is_long ? (byte(10) << 16) + (byte(11) << 24) : 0);
    constexpr std::size_t longest = std::size_t{1} << 20;
    while (size <= longest && buffer_.size() < begin + size && npy_->read(buffer_)) continue;
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
    const auto bytes = npy_->size() - std::min<std::uintmax_t>(npy_->size(), at_);
    if (npy_->size() != 0 && left_ > bytes / (3 * number_bytes_))
        (void)fail("is cut off: it is too short for its " + std::to_string(left_) + " points");
}

/// Appends the next vertex of an OBJ file; false at the end and after a failure.
bool PointFile::read_vertex(std::vector<double>& numbers) {
    for (std::string_view line; obj_->next(line);) {
        const std::string where = "line " + std::to_string(obj_->line()) + ": ";
        if (line.find('\0') != std::string_view::npos)
            return fail(where + "is no text, so this is no OBJ file");
        line = detail::trim(line);
        if (!line.starts_with("v ") && !line.starts_with("v\t")) continue;
        for (int k = 0; k < 3; ++k) {
            line.remove_prefix(std::min(line.find_first_of(" \t"), line.size()));
            line = detail::trim(line);
            double number = 0;
            const std::string why = detail::parse_number(line.substr(0, line.find_first_of(" \t")), number);
            if (!why.empty()) return fail(where + why);
            numbers.push_back(number);
        }
        return true;
    }
    error_ = obj_->error();
    return false;
}

/// Appends the next row of an array; false at the end and after a failure.
bool PointFile::read_row(std::vector<double>& numbers) {
    if (left_ == 0) return false;
    const std::size_t bytes = 3 * number_bytes_;
    if (buffer_.size() - at_ < bytes) {
        buffer_.erase(0, at_);
        at_ = 0;
        while (buffer_.size() < bytes && npy_->read(buffer_)) continue;
        error_ = npy_->error();
        if (buffer_.size() < bytes) return fail("is cut off");
    }
    for (int k = 0; k < 3; ++k, at_ += number_bytes_) {
        float single = 0;
        double number = 0;
        std::memcpy(number_bytes_ == 4 ? static_cast<void*>(&single) : &number, buffer_.data() + at_,
                    number_bytes_);
        numbers.push_back(number_bytes_ == 4 ? double(single) : number);
    }
    --left_;
    return true;
}

std::size_t PointFile::read(std::size_t most, std::vector<double>& numbers) {
    if (!error_.empty()) return 0;
    const std::size_t before = numbers.size();
    std::size_t count = 0;
    if (ply_) {
        count = ply_->read(most, numbers);
        error_ = ply_->error();
    } else if (mesh_) {
        for (; count < most && at_ < mesh_->size(); ++at_, ++count)
            numbers.insert(numbers.end(), std::begin((*mesh_)[at_].v), std::end((*mesh_)[at_].v));
    } else {
        while (count < most && (obj_ ? read_vertex(numbers) : read_row(numbers))) ++count;
    }
    if (error_.empty()) return count;
    numbers.resize(before);
    return 0;
}

std::optional<std::uint64_t> PointFile::hash_to_end() {
    if (mesh_) return InputFile(path_).hash_to_end();
    if (!ply_ && !obj_ && !npy_) return std::nullopt; // a mesh that could not be read
    const auto hash = ply_ ? ply_->hash_to_end() : obj_ ? obj_->hash_to_end() : npy_->hash_to_end();
    if (error_.empty()) error_ = ply_ ? ply_->error() : obj_ ? obj_->error() : npy_->error();
    return hash;
}

} // namespace cageform_support

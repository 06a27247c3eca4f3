#pragma once

// Points as text: two numbers a line, separated by a comma. Read in batches, so a file may be of any length.

#include "svg_path.hpp"

#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace cageform_examples {

namespace detail {

inline std::string_view trim(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3); // a byte order mark
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

/// "x,y" with anything std::from_chars takes for a number, "nan" and "inf" included; an empty reason is success.
inline std::string parse_point(std::string_view line, Point2& point) {
    std::array<double*, 2> target{&point.x, &point.y};
    for (std::size_t k = 0; k < 2; ++k) {
        const std::size_t comma = line.find(',');
        if (k == 0 && comma == std::string_view::npos) return "two numbers separated by a comma are expected";
        if (k == 1 && comma != std::string_view::npos) return "more than two numbers";
        std::string_view field = trim(line.substr(0, comma));
        if (field.starts_with('+')) field.remove_prefix(1);
        const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), *target[k]);
        if (error == std::errc::result_out_of_range)
            return "number out of range: \"" + std::string(field) + "\"";
        if (error != std::errc{} || end != field.data() + field.size() || field.empty()) {
            return "not a number: \"" + std::string(field) + "\"";
        }
        line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
    }
    return {};
}

/// A first line of words, such as "x,y", is a header.
inline bool is_header(std::string_view line) {
    line = trim(line);
    return !line.empty() && (line.front() == 'x' || line.front() == 'X' || line.front() == '"');
}

} // namespace detail

/// Reads the points of a file some at a time. Empty lines, lines that begin with '#' and a header are skipped.
class PointReader {
public:
    /// On failure `error()` says why.
    explicit PointReader(const std::string& path)
        : path_(path)
        , file_(path) {
        if (std::filesystem::is_directory(path)) {
            error_ = path + ": is a folder";
            return;
        }
        if (!file_ || file_.peek() == std::ifstream::traits_type::eof()) {
            error_ = path + (file_.is_open() ? ": is empty" : ": cannot be read");
            return;
        }
        file_.seekg(0, std::ios::end);
        size_ = file_.tellg();
        file_.clear(); // a pipe has no end to seek
        if (size_ > 0) file_.seekg(0);
    }

    /// Fills `points` with the next at most `most` points; false at the end of the file or on an error.
    bool read(std::vector<Point2>& points, std::size_t most) {
        points.clear();
        std::string line;
        while (error_.empty() && points.size() < most && std::getline(file_, line)) {
            ++line_;
            const std::string_view text = detail::trim(line);
            if (text.empty() || text.front() == '#' || (line_ == 1 && detail::is_header(text))) continue;
            Point2 p;
            const std::string why = detail::parse_point(text, p);
            if (why.empty())
                points.push_back(p);
            else
                error_ = path_ + ":" + std::to_string(line_) + ": " + why;
        }
        return error_.empty() && !points.empty();
    }

    const std::string& error() const { return error_; }

    /// How much of the file has been read, in [0, 1].
    double fraction() {
        const auto at = file_.tellg();
        return size_ > 0 && at >= 0 ? double(at) / double(size_) : 1.0;
    }

private:
    std::string path_;
    std::ifstream file_;
    std::streamoff size_ = 0;
    std::size_t line_ = 0;
    std::string error_;
};

/// The loops of a cage: blocks of "x,y" lines with empty lines between them, the outer loop first.
inline SvgResult<std::vector<std::vector<Point2>>> read_cage_csv(const std::string& path) {
    std::ifstream file(path);
    if (!file) return SvgError{path + ": cannot be read"};
    if (std::filesystem::is_directory(path)) return SvgError{path + ": is a folder"};
    std::vector<std::vector<Point2>> loops;
    bool gap = true;
    std::string line;
    for (std::size_t number = 1; std::getline(file, line); ++number) {
        const std::string_view text = detail::trim(line);
        if (text.empty()) gap = true;
        if (text.empty() || text.front() == '#' || (number == 1 && detail::is_header(text))) continue;
        Point2 p;
        const std::string why = detail::parse_point(text, p);
        if (!why.empty()) return SvgError{path + ":" + std::to_string(number) + ": " + why};
        if (gap) loops.emplace_back();
        gap = false;
        loops.back().push_back(p);
    }
    if (loops.empty()) return SvgError{path + ": holds no points"};
    return loops;
}

} // namespace cageform_examples

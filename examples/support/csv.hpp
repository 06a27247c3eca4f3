#pragma once

// Points as text: two or three numbers a line, separated by commas. Read in batches, so a file may be of any
// length. And cages: blocks of such lines.

#include "svg_path.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <istream>
#include <string>
#include <string_view>
#include <utility>
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

/// Anything std::from_chars takes for a number, "nan" and "inf" included; an empty reason is success.
inline std::string parse_number(std::string_view field, double& number) {
    if (field.starts_with('+')) field.remove_prefix(1);
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), number);
    if (error == std::errc::result_out_of_range) return "number out of range: \"" + std::string(field) + "\"";
    if (error != std::errc{} || end != field.data() + field.size())
        return "not a number: \"" + std::string(field) + "\"";
    return {};
}

/// "x,y" or "x,y,z"; an empty reason is success.
template <std::size_t D>
std::string parse_point(std::string_view line, std::array<double, D>& point) {
    static_assert(D == 2 || D == 3);
    const auto columns = std::size_t(std::count(line.begin(), line.end(), ',')) + 1;
    if (columns != D) {
        return std::to_string(columns) + (columns == 1 ? " column" : " columns") +
               (D == 2 ? " where a cage in the plane needs two: x,y"
                       : " where a cage in space needs three: x,y,z");
    }
    for (double& number : point) {
        const std::string_view field = line.substr(0, line.find(','));
        const std::string why = parse_number(trim(field), number);
        if (!why.empty()) return why;
        line.remove_prefix(std::min(field.size() + 1, line.size()));
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
///
///   D    2 or 3: the numbers of a line
template <std::size_t D>
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
    bool read(std::vector<std::array<double, D>>& points, std::size_t most) {
        points.clear();
        std::string line;
        while (error_.empty() && points.size() < most && std::getline(file_, line)) {
            ++line_;
            const std::string_view text = detail::trim(line);
            if (text.empty() || text.front() == '#' || (line_ == 1 && detail::is_header(text))) continue;
            std::array<double, D> p{};
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

/// Lines of a cage's file that belong together.
struct CageBlock {
    enum class Kind { loop, chain, point };

    Kind kind = Kind::loop;
    double radius = 0; // of a point
    std::vector<Point2> points;
};

namespace detail {

/// Reads "# chain" or "# point RADIUS"; false for any other comment. An empty reason is success.
inline bool parse_block_head(std::string_view comment, CageBlock& block, std::string& why) {
    comment = trim(comment.substr(1));
    const std::string_view word = comment.substr(0, comment.find_first_of(" \t"));
    const std::string_view rest = trim(comment.substr(word.size()));
    if (word != "chain" && word != "point") return false;
    block.kind = word == "chain" ? CageBlock::Kind::chain : CageBlock::Kind::point;
    if (block.kind == CageBlock::Kind::chain)
        why = rest.empty() ? "" : "\"# chain\" stands alone on its line";
    else
        why = rest.empty() ? "the radius is missing: \"# point RADIUS\"" : parse_number(rest, block.radius);
    return true;
}

/// What is wrong with how many points a chain or a point has; empty where nothing is.
inline std::string fault_of_count(const CageBlock& block) {
    const std::size_t count = block.points.size();
    if (block.kind == CageBlock::Kind::loop) return {};
    if (count == 0) return "no points follow";
    if (block.kind == CageBlock::Kind::chain && count < 2) return "a chain has two points or more";
    if (block.kind == CageBlock::Kind::point && count > 1) return "more than one point follows";
    return {};
}

} // namespace detail

/// A cage as blocks of "x,y" lines with empty lines between them: loops, the outer one first; chains, headed by
/// a line "# chain"; points, headed by "# point RADIUS". Other lines that begin with '#' are skipped.
inline SvgResult<std::vector<CageBlock>> parse_cage_csv(std::istream& file, const std::string& name) {
    std::vector<CageBlock> blocks;
    bool open = false; // whether the next line belongs to the last block
    std::size_t number = 0, head = 0;
    const auto refuse = [&](std::size_t at, const std::string& why) {
        return SvgError{name + ":" + std::to_string(at) + ": " + why};
    };
    const auto end_block = [&] {
        return std::exchange(open, false) ? detail::fault_of_count(blocks.back()) : "";
    };
    for (std::string line; std::getline(file, line);) {
        ++number;
        const std::string_view text = detail::trim(line);
        std::string why;
        if (text.empty()) {
            why = end_block();
            if (!why.empty()) return refuse(head, why);
        } else if (text.front() == '#') {
            CageBlock block;
            if (!detail::parse_block_head(text, block, why)) continue;
            if (open) why = "an empty line is missing before " + std::string(text);
            if (!why.empty()) return refuse(number, why);
            blocks.push_back(block);
            open = true;
            head = number;
        } else if (number > 1 || !detail::is_header(text)) {
            std::array<double, 2> p{};
            why = detail::parse_point(text, p);
            if (!why.empty()) return refuse(number, why);
            if (!std::exchange(open, true)) blocks.emplace_back();
            blocks.back().points.push_back({p[0], p[1]});
        }
    }
    const std::string why = end_block();
    if (!why.empty()) return refuse(head, why);
    if (blocks.empty()) return SvgError{name + ": holds no points"};
    const auto is_loop = [](const CageBlock& block) { return block.kind == CageBlock::Kind::loop; };
    if (std::none_of(blocks.begin(), blocks.end(), is_loop)) return SvgError{name + ": holds no loop"};
    return blocks;
}

/// As parse_cage_csv(), from a file; fails also where it cannot be read.
inline SvgResult<std::vector<CageBlock>> read_cage_csv(const std::string& path) {
    std::ifstream file(path);
    if (!file) return SvgError{path + ": cannot be read"};
    if (std::filesystem::is_directory(path)) return SvgError{path + ": is a folder"};
    return parse_cage_csv(file, path);
}

} // namespace cageform_examples

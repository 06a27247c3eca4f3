#include "files/csv.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

namespace cageform_examples {

namespace detail {

std::string_view trim(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3); // a byte order mark
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

std::string separator_fault(std::string_view line) {
    // Semicolons or tabs separate numbers where commas are decimal.
    const bool has_semicolons = line.find(';') != line.npos;
    if (!has_semicolons && trim(line).find('\t') == line.npos) return {};
    return std::string("; it is separated by ") + (has_semicolons ? "semicolons" : "tabs") +
           ", and commas are read";
}

std::vector<std::string_view> parts_of(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (std::size_t end = 0; end != text.npos;) {
        end = text.find(separator);
        parts.push_back(trim(text.substr(0, end)));
        text.remove_prefix(end == text.npos ? text.size() : end + 1);
    }
    return parts;
}

std::string quoted(std::string_view word) {
    std::string text = "\"";
    for (const char c : word.substr(0, 40)) text += c >= 0 && c < ' ' ? '?' : c;
    return text + (word.size() > 40 ? "…\"" : "\"");
}

std::string parse_number(std::string_view field, double& number) {
    if (field.starts_with('+')) field.remove_prefix(1);
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), number);
    if (error == std::errc::result_out_of_range) return "number out of range: " + quoted(field);
    if (error != std::errc{} || end != field.data() + field.size()) return "not a number: " + quoted(field);
    return {};
}

std::string parse_finite(std::string_view text, double& number) {
    const std::string why = parse_number(text, number);
    return why.empty() && !std::isfinite(number) ? quoted(text) + " is not a finite number" : why;
}

std::string digits_of(double x) {
    std::array<char, 32> digits;
    return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr};
}

std::string short_number(double number) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6g", number);
    return text.data();
}

std::string single_precision_fault(double number) {
    if (std::isfinite(float(number))) return {};
    if (!std::isfinite(number)) return "a number is not finite";
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    return std::string(digits.data(), end) + " is beyond single precision, which ends at 3.4e38";
}

bool is_header(std::string_view line) {
    line = trim(line);
    return !line.empty() && (line.front() == 'x' || line.front() == 'X' || line.front() == '"');
}

/// Reads "# chain" or "# point RADIUS"; false for any other comment. An empty reason is success.
bool parse_block_head(std::string_view comment, CageBlock& block, std::string& why) {
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

/// Returns the fault if a chain or a point has a wrong number of points; otherwise empty.
std::string fault_of_count(const CageBlock& block) {
    const std::size_t count = block.points.size();
    if (block.kind == CageBlock::Kind::loop) return {};
    if (count == 0) return "no points follow";
    if (block.kind == CageBlock::Kind::chain && count < 2) return "a chain has two points or more";
    if (block.kind == CageBlock::Kind::point && count > 1) return "more than one point follows";
    return {};
}

} // namespace detail

SvgResult<TableSize> read_table(const std::string& path,
                                const std::function<std::string(std::string_view)>& take) {
    const auto file = read_file(path);
    if (!file) return file.error();
    TableSize size;
    std::string_view text = *file, line;
    while (take_line(text, line)) {
        if (detail::trim(line).empty() && text.empty()) break;
        const std::string at = path + ":" + std::to_string(++size.rows) + ": ";
        std::size_t columns = 0;
        for (bool more = true; more;) {
            const std::size_t end = std::min(line.find(','), line.size());
            const std::string why = take(detail::trim(line.substr(0, end)));
            ++columns;
            if (!why.empty()) return SvgError{at + "column " + std::to_string(columns) + ": " + why};
            more = end < line.size();
            line.remove_prefix(std::min(end + 1, line.size()));
        }
        if (size.rows > 1 && columns != size.columns) {
            return SvgError{at + std::to_string(columns) + " columns, and the first line has " +
                            std::to_string(size.columns)};
        }
        size.columns = columns;
    }
    if (size.rows == 0) return SvgError{path + ": holds no table"};
    return size;
}

SvgResult<std::vector<CageBlock>> parse_cage_csv(std::string_view file, const std::string& name) {
    std::vector<CageBlock> blocks;
    bool open = false; // whether the next line belongs to the last block
    std::size_t number = 0, head = 0;
    const auto refuse = [&](std::size_t at, const std::string& why) {
        return SvgError{name + ":" + std::to_string(at) + ": " + why};
    };
    const auto end_block = [&] {
        return std::exchange(open, false) ? detail::fault_of_count(blocks.back()) : "";
    };
    for (std::string_view line; take_line(file, line);) {
        ++number;
        const std::string_view text = detail::trim(line);
        std::string why;
        if (text.empty()) {
            why = end_block();
            if (!why.empty()) return refuse(head, why);
        } else if (text.front() == '#') {
            CageBlock block;
            if (!detail::parse_block_head(text, block, why)) continue;
            if (open) why = "an empty line is missing before " + std::string(text.substr(0, 40));
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

SvgResult<std::vector<CageBlock>> read_cage_csv(const std::string& path) {
    const auto text = read_file(path);
    return text ? parse_cage_csv(*text, path) : text.error();
}

SvgResult<std::vector<std::string>> read_labels(const std::string& path, std::size_t count) {
    const auto file = read_file(path);
    if (!file) return file.error();
    std::vector<std::string> labels;
    std::map<std::string_view, std::size_t> lines; // of each label
    std::string_view text = *file;
    std::size_t number = 0;
    for (std::string_view line; take_line(text, line);) {
        ++number;
        const std::string_view label = detail::trim(line);
        if (label.starts_with('#')) continue;
        labels.emplace_back(label);
        if (label.empty()) continue;
        const auto refuse = [&](const std::string& why) {
            return SvgError{path + ":" + std::to_string(number) + ": the label " + detail::quoted(label) +
                            why};
        };
        if (std::any_of(label.begin(), label.end(), [](char c) { return (c >= 0 && c < ' ') || c == 127; }))
            return refuse(" holds a control character");
        if (const auto [first, is_new] = lines.emplace(label, number); !is_new)
            return refuse(" occurs in line " + std::to_string(first->second) + " already");
    }
    if (lines.empty()) return SvgError{path + ": holds no labels"};
    if (labels.size() != count)
        return SvgError{path + ": has " + std::to_string(labels.size()) + " lines of labels, the cage " +
                        std::to_string(count) + " vertices"};
    return labels;
}

} // namespace cageform_examples

#include "io/csv.hpp"

#include <cctype>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

namespace cageform_support {

std::string formatted(const char* format, ...) {
    std::array<char, 256> text{};
    std::va_list values;
    va_start(values, format);
    std::vsnprintf(text.data(), text.size(), format, values);
    va_end(values);
    return text.data();
}

namespace detail {

std::string_view trim(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3); // a byte order mark
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

/// Returns a hint on the separators of a line that cannot be parsed; empty if they are correct.
std::string separator_hint(std::string_view line) {
    line = trim(line);
    if (line.starts_with('#')) return {};
    const auto is_digit = [&](std::size_t k) { return k < line.size() && line[k] >= '0' && line[k] <= '9'; };
    const auto is_between_numbers = [&](std::size_t k) {
        const bool has_sign = k + 1 < line.size() && (line[k + 1] == '-' || line[k + 1] == '+');
        return k > 0 && is_digit(k - 1) && is_digit(k + 1 + std::size_t(has_sign));
    };
    std::string_view separators;
    if (line.find(';') != line.npos) {
        separators = "semicolons";
    } else if (line.find('\t') != line.npos) {
        separators = "tabs";
    } else {
        for (std::size_t k = 0; (k = line.find(' ', k)) != line.npos; ++k) {
            if (is_between_numbers(k)) separators = "blanks";
        }
    }
    // With other separators, or in quotes, a comma between digits is a decimal comma.
    bool has_decimal_commas = false, is_quoted = false;
    for (std::size_t k = 0; k < line.size(); ++k) {
        is_quoted ^= line[k] == '"';
        if (line[k] == ',' && (is_quoted || !separators.empty()))
            has_decimal_commas |= is_digit(k + 1) && is_between_numbers(k);
    }
    if (separators.empty() && !has_decimal_commas) return {};
    std::string text = "; the line ";
    if (!separators.empty()) (text += "is separated by ") += separators;
    if (!has_decimal_commas) return text + ", but only commas are read";
    return text + (separators.empty() ? "has" : " and has") +
           " decimal commas; commas are read as separators, points as decimal points";
}

FileError row_fault(const std::string& name, std::size_t number, std::string_view line,
                    const std::string& why) {
    return {name + ":" + std::to_string(number) + ": " + why + separator_hint(line)};
}

bool take_cell(std::string_view& row, std::string_view& cell) {
    if (row.data() == nullptr) return false;
    std::size_t end = row.find(',');
    const std::size_t begin = std::min(row.find_first_not_of(" \t"), row.size());
    const bool is_quoted = row.substr(begin).starts_with('"');
    // A comma after an odd number of quotes is part of the cell.
    for (std::size_t from = 0, quotes = 0; is_quoted && end != row.npos; end = row.find(',', end + 1)) {
        quotes += std::size_t(
            std::count(row.begin() + std::ptrdiff_t(from), row.begin() + std::ptrdiff_t(end), '"'));
        if (quotes % 2 == 0) break;
        from = end;
    }
    cell = trim(row.substr(0, end));
    row = end == row.npos ? std::string_view{} : row.substr(end + 1);
    if (is_quoted && cell.size() > 1 && cell.back() == '"') cell = trim(cell.substr(1, cell.size() - 2));
    return true;
}

std::vector<std::string_view> cells_of(std::string_view row, std::size_t least) {
    std::vector<std::string_view> cells;
    for (std::string_view cell; take_cell(row, cell);) cells.push_back(cell);
    while (cells.size() > least && cells.back().empty()) cells.pop_back();
    return cells;
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
    const std::string_view digits = field.starts_with('+') ? field.substr(1) : field;
    if (field.starts_with("1.#") || field.starts_with("-1.#")) { // 1.#QNAN, 1.#INF: old Windows programs
        number = std::numeric_limits<double>::quiet_NaN();
        return {};
    }
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (error == std::errc::result_out_of_range) {
        number = std::strtod(std::string(digits).c_str(), nullptr); // infinite, or the nearest number to 0
        return {};
    }
    if (error != std::errc{} || end != digits.data() + digits.size()) return "not a number: " + quoted(field);
    return {};
}

std::string parse_finite(std::string_view text, double& number) {
    const std::string why = parse_number(text, number);
    return why.empty() && !std::isfinite(number) ? quoted(text) + " is not a finite number" : why;
}

std::string short_number(double number) {
    return formatted("%.6g", number);
}

std::string single_precision_fault(double number) {
    if (std::isfinite(float(number))) return {};
    if (!std::isfinite(number)) return "a number is not finite";
    return digits_of(number) + " is beyond single precision, which ends at 3.4e38";
}

bool is_empty_row(std::string_view line) {
    return line.find_first_not_of(", \t") == line.npos;
}

bool is_header(std::string_view line) {
    bool has_words = false;
    for (const std::string_view cell : cells_of(trim(line))) {
        if (cell == "control") return false; // the first line of a control of a clip
        for (const std::string_view tabbed : parts_of(cell, '\t')) {
            for (const std::string_view part : parts_of(tabbed, ';')) {
                const bool has_letter = std::any_of(part.begin(), part.end(), [](unsigned char c) {
                    return std::isalpha(c) != 0 || c >= 0x80;
                });
                double number = 0; // "nan" has letters
                const bool begins_as_number = part.find_first_of("0123456789+-.") == 0;
                if (!part.empty() && (!has_letter || begins_as_number || parse_number(part, number).empty()))
                    return false;
                has_words |= has_letter;
            }
        }
    }
    return has_words;
}

bool RowFilter::take(std::string_view& line) {
    line = trim(line);
    if (is_empty_row(line) || line.front() == '#') return false;
    return !std::exchange(is_first_, false) || !is_header(line);
}

/// Parses "# chain" or "# point RADIUS"; false for other comments. An error is stored in `why`.
bool parse_block_head(std::string_view comment, CageBlock& block, std::string& why) {
    comment = trim(comment.substr(1));
    const std::string_view word = comment.substr(0, comment.find_first_of(" \t"));
    const std::string_view rest = trim(comment.substr(word.size()));
    if (word != "chain" && word != "point") return false;
    block.kind = word == "chain" ? CageBlock::Kind::chain : CageBlock::Kind::point;
    if (block.kind == CageBlock::Kind::chain)
        why = rest.empty() ? "" : "\"# chain\" must be alone on its line";
    else
        why = rest.empty() ? "the radius is missing: \"# point RADIUS\"" : parse_finite(rest, block.radius);
    return true;
}

/// Returns the error if a chain or a point has a wrong number of points; else empty.
std::string fault_of_count(const CageBlock& block) {
    const std::size_t count = block.points.size();
    if (block.kind == CageBlock::Kind::loop) return {};
    if (count == 0) return "no points follow";
    if (block.kind == CageBlock::Kind::chain && count < 2) return "a chain has two points or more";
    if (block.kind == CageBlock::Kind::point && count > 1) return "more than one point follows";
    return {};
}

} // namespace detail

Expected<TableSize> read_table(const std::string& path,
                               const std::function<std::string(std::string_view)>& take) {
    const auto file = read_text(path);
    if (!file) return file.error();
    TableSize size;
    std::string_view text = *file, line;
    while (take_line(text, line)) {
        // In a table of one column, an empty line is a cell, except the last.
        const bool is_end = text.find_first_not_of(size.columns > 1 ? " \t\r\n" : "") == text.npos;
        if (detail::trim(line).empty() && is_end) break;
        const auto refuse = [&](const std::string& why) {
            return detail::row_fault(path, size.rows, line, why);
        };
        ++size.rows;
        std::size_t columns = 0;
        std::string_view rest = detail::trim(line);
        for (std::string_view cell; detail::take_cell(rest, cell);) {
            const std::string why = take(cell);
            ++columns;
            if (!why.empty()) return refuse("column " + std::to_string(columns) + ": " + why);
        }
        if (size.rows > 1 && columns != size.columns) {
            return refuse(std::to_string(columns) + " columns, and the first line has " +
                          std::to_string(size.columns));
        }
        size.columns = columns;
    }
    if (size.rows == 0) return FileError{path + ": holds no table"};
    return size;
}

Expected<std::vector<CageBlock>> parse_cage_csv(std::string_view file, const std::string& name) {
    std::vector<CageBlock> blocks;
    bool open = false; // whether the next line belongs to the last block
    detail::RowFilter rows;
    std::size_t number = 0, head = 0;
    std::string_view text;
    const auto refuse = [&](std::size_t at, const std::string& why) {
        return detail::row_fault(name, at, text, why);
    };
    const auto end_block = [&] {
        return std::exchange(open, false) ? detail::fault_of_count(blocks.back()) : "";
    };
    for (std::string_view line; take_line(file, line);) {
        ++number;
        text = line;
        const bool is_row = rows.take(text);
        std::string why;
        if (detail::is_empty_row(text)) {
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
        } else if (is_row) {
            std::array<double, 2> p{};
            why = detail::parse_point(text, p);
            if (!why.empty()) return refuse(number, why);
            if (!std::exchange(open, true)) blocks.emplace_back();
            blocks.back().points.push_back({p[0], p[1]});
        }
    }
    if (const std::string why = end_block(); !why.empty()) return refuse(head, why);
    if (blocks.empty()) return FileError{name + ": holds no points"};
    const auto is_loop = [](const CageBlock& block) { return block.kind == CageBlock::Kind::loop; };
    if (std::none_of(blocks.begin(), blocks.end(), is_loop)) return FileError{name + ": holds no loop"};
    return blocks;
}

Expected<std::vector<CageBlock>> read_cage_csv(const std::string& path) {
    const auto text = read_text(path);
    return text ? parse_cage_csv(*text, path) : text.error();
}

Expected<std::vector<std::string>> read_labels(const std::string& path, std::size_t count) {
    const auto file = read_text(path);
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
            return FileError{path + ":" + std::to_string(number) + ": the label " + detail::quoted(label) +
                             why};
        };
        if (std::any_of(label.begin(), label.end(), [](char c) { return (c >= 0 && c < ' ') || c == 127; }))
            return refuse(" holds a control character");
        if (const auto [first, is_new] = lines.emplace(label, number); !is_new)
            return refuse(" occurs in line " + std::to_string(first->second) + " already");
    }
    if (lines.empty()) return FileError{path + ": holds no labels"};
    if (labels.size() != count)
        return FileError{path + ": has " + std::to_string(labels.size()) + " lines of labels, the cage " +
                         std::to_string(count) + " vertices"};
    return labels;
}

} // namespace cageform_support

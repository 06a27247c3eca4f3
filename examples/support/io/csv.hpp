#pragma once

// CSV files: points (two or three numbers per line, read in batches), tables, cages (blocks of points) and
// vertex labels. Also the parsing and formatting of numbers for all file formats.

#include "io/input_file.hpp"
#include "io/point2.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace cageform_support {

/// Formats like printf(), with at most 255 characters.
#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
std::string
formatted(const char* format, ...);

/// A number and its position in the bytes of a file.
struct PlacedNumber {
    double value = 0;
    std::size_t begin = 0, end = 0;
};

namespace detail {

std::string_view trim(std::string_view text);

/// Splits a text at a separator and trims the parts.
std::vector<std::string_view> parts_of(std::string_view text, char separator);

/// A word of a file in quotes for a message: control characters replaced, at most 40 bytes.
std::string quoted(std::string_view word);

/// Parses what std::from_chars accepts, "nan" and "inf" included, with an optional '+'. A number out of the
/// range of double becomes infinite or the nearest to 0. Returns the error; empty on success.
std::string parse_number(std::string_view field, double& number);

/// As parse_number(), but fails if the number is not finite.
std::string parse_finite(std::string_view text, double& number);

/// Appends a number with the fewest digits that restore it in its own precision.
template <class X>
void append_digits(std::string& text, X x) {
    std::array<char, 32> digits;
    text.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr);
}

/// Formats a number with the fewest digits that restore it.
inline std::string digits_of(double x) {
    std::string text;
    append_digits(text, x);
    return text;
}

/// Reads a whole number without spaces and '+'; false if the text is not one, or out of range of `Integer`.
template <class Integer>
bool parse_whole(std::string_view text, Integer& number) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc{} && end == text.data() + text.size();
}

/// "1 column", "2 columns".
inline std::string counted(std::size_t n, const std::string& noun) {
    return std::to_string(n) + ' ' + noun + (n == 1 ? "" : "s");
}

/// Formats a number for messages, with at most six digits.
std::string short_number(double number);

/// Returns the error if a number is not finite in single precision; else empty.
std::string single_precision_fault(double number);

/// Returns the error "NAME:NUMBER: WHY" of a CSV line, NUMBER from 1. A hint follows if the line has
/// semicolons, tabs, blanks or decimal commas: "; the line is separated by tabs, but only commas are read".
FileError row_fault(const std::string& name, std::size_t number, std::string_view line,
                    const std::string& why);

/// Takes the first cell off a row of CSV, without surrounding spaces and quotes; false at the end.
bool take_cell(std::string_view& row, std::string_view& cell);

/// Splits a row of CSV into cells. Trailing empty cells are dropped, but at least `least` cells are kept.
std::vector<std::string_view> cells_of(std::string_view row, std::size_t least = 1);

/// Parses "x,y" or "x,y,z". Returns the error; empty on success.
template <std::size_t D>
std::string parse_point(std::string_view line, std::array<double, D>& point) {
    static_assert(D == 2 || D == 3);
    std::size_t columns = 0, column = 0;
    std::string why;
    for (std::string_view cell; take_cell(line, cell);) {
        if (column < D && why.empty()) why = parse_number(cell, point[column]);
        if (++column <= D || !cell.empty()) columns = column; // trailing empty cells do not count
    }
    if (columns == D) return why;
    return counted(columns, "column") +
           (D == 2 ? ", but a point in the plane has two: x,y" : ", but a point in space has three: x,y,z");
}

/// Whether all cells of a line are empty.
bool is_empty_row(std::string_view line);

/// Whether a first row is a header, such as "x,y": it has words and no number, whatever the separator.
bool is_header(std::string_view line);

/// Skips the lines of a CSV file that are not rows.
class RowFilter {
public:
    /// Trims a line. Returns false for an empty row, a comment (first character '#') and a header.
    bool take(std::string_view& line);

private:
    bool is_first_ = true;
};

} // namespace detail

/// Reads the points of a file in batches. Empty lines, comments and a header are skipped.
///
///   D   2 or 3: numbers per line
///   T   scalar of the points; a strict reader refuses numbers that are not finite in T
template <std::size_t D, class T = double>
class PointReader {
public:
    /// On failure error() is set.
    explicit PointReader(const std::string& path, bool is_strict = false)
        : path_(path)
        , is_strict_(is_strict)
        , lines_(path)
        , error_(lines_.error()) {}

    /// Reads up to `most` points into `points`; false at the end of the file or on an error.
    bool read(std::vector<std::array<double, D>>& points, std::size_t most) {
        points.clear();
        std::string_view line;
        while (error_.empty() && points.size() < most && lines_.next(line)) {
            if (!rows_.take(line)) continue;
            std::array<double, D> p{};
            std::string why = detail::parse_point(line, p);
            for (const double x : p) {
                if (why.empty() && is_strict_ && !std::isfinite(T(x)))
                    why = detail::single_precision_fault(x);
            }
            if (why.empty())
                points.push_back(p);
            else
                error_ = to_string(detail::row_fault(path_, lines_.line(), line, why));
        }
        if (error_.empty()) error_ = lines_.error();
        return error_.empty() && !points.empty();
    }

    const std::string& error() const { return error_; }

    /// Line number of the last point read, from 1.
    std::size_t line() const { return lines_.line(); }

    /// Fraction of the file that has been read, in [0, 1].
    double fraction() const { return lines_.fraction(); }

private:
    std::string path_;
    bool is_strict_ = false;
    LineReader lines_;
    detail::RowFilter rows_;
    std::string error_;
};

struct TableSize {
    std::size_t rows = 0, columns = 0;
};

/// Reads a table of cells separated by commas, one row per line, all rows of equal length.
///
///   take    called with each trimmed cell, row by row; returns an error, or empty to accept the cell
///   fails   if the file cannot be read, has no rows or rows of different lengths, or `take` rejects a cell;
///           with line and column
Expected<TableSize> read_table(const std::string& path,
                               const std::function<std::string(std::string_view)>& take);

/// A block of lines of a cage's file.
struct CageBlock {
    enum class Kind : std::uint8_t { loop, chain, point };

    Kind kind = Kind::loop;
    double radius = 0; // of a point
    std::vector<Point2> points;
};

/// Parses a cage: blocks of "x,y" lines separated by empty lines. A block is a loop (the outer loop comes
/// first), a chain (after a line "# chain") or a point (after a line "# point RADIUS"). Other lines that
/// begin with '#' are comments.
Expected<std::vector<CageBlock>> parse_cage_csv(std::string_view text, const std::string& name);

/// As parse_cage_csv(), from a file; fails also if the file cannot be read.
Expected<std::vector<CageBlock>> read_cage_csv(const std::string& path);

/// Help text on vertex labels.
inline constexpr const char* labels_format =
    "A file of labels has one line of text per vertex of the cage, in the order of the\n"
    "vertices. An empty line is no label; lines that begin with # are comments.\n";

/// Reads one label per vertex of a cage, one per line; an empty line is no label. Lines that begin with '#'
/// are comments; labels are trimmed.
///
///   fails   if the file cannot be read or has no labels, the number of lines is not `count`, a label occurs
///           twice or contains a control character
Expected<std::vector<std::string>> read_labels(const std::string& path, std::size_t count);

} // namespace cageform_support

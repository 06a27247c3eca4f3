#pragma once

// Reads points from text: two or three numbers per line, separated by commas. They are read in batches, so
// a file may have any length. Also reads cages, which are blocks of such lines, and labels of their
// vertices.

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

namespace detail {

std::string_view trim(std::string_view text);

/// The parts of a text between separators, without blanks around them.
std::vector<std::string_view> parts_of(std::string_view text, char separator);

/// A word of a file for a message: no control characters, and not too much of it.
std::string quoted(std::string_view word);

/// Anything std::from_chars takes for a number, "nan" and "inf" included; an empty reason is success. A
/// number beyond double precision is infinite, or as near to 0 as double precision allows.
std::string parse_number(std::string_view field, double& number);

/// Works as parse_number(); fails also where the number is not finite.
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

/// Returns why a number is not finite in single precision; empty if it is.
std::string single_precision_fault(double number);

/// Returns the error "NAME:NUMBER: WHY" on a line of CSV. A hint follows if the line has semicolons, tabs,
/// blanks or decimal commas: "; the line is separated by tabs, and commas are read".
FileError row_fault(const std::string& name, std::size_t number, std::string_view line,
                    const std::string& why);

/// Takes the first cell of a row of CSV, without blanks and quotes around it; false at the end.
bool take_cell(std::string_view& row, std::string_view& cell);

/// The cells of a row of CSV. Empty cells at its end are left out, but for the first `least` cells.
std::vector<std::string_view> cells_of(std::string_view row, std::size_t least = 1);

/// "x,y" or "x,y,z"; an empty reason is success.
template <std::size_t D>
std::string parse_point(std::string_view line, std::array<double, D>& point) {
    static_assert(D == 2 || D == 3);
    std::size_t columns = 0, column = 0;
    std::string why;
    for (std::string_view cell; take_cell(line, cell);) {
        if (column < D && why.empty()) why = parse_number(cell, point[column]);
        if (++column <= D || !cell.empty()) columns = column; // empty cells at the end do not count
    }
    if (columns == D) return why;
    return counted(columns, "column") +
           (D == 2 ? ", but a point in the plane has two: x,y" : ", but a point in space has three: x,y,z");
}

/// Whether the cells of a line hold no text.
bool is_empty_row(std::string_view line);

/// A first row of words, such as "x,y", is a header. A row with a number is none, whatever separates its
/// cells.
bool is_header(std::string_view line);

/// Tells rows from other lines of a CSV file.
class RowFilter {
public:
    /// Takes the blanks around a line off. Returns false for an empty row, for a line that begins with '#',
    /// and for a header.
    bool take(std::string_view& line);

private:
    bool is_first_ = true;
};

} // namespace detail

/// Reads the points of a file some at a time. Empty lines, lines that begin with '#' and a header are
/// skipped.
///
///   D    2 or 3: the numbers of a line
///   T    what the points are for: a strict reader refuses a number that is not finite in T
template <std::size_t D, class T = double>
class PointReader {
public:
    /// On failure `error()` says why.
    explicit PointReader(const std::string& path, bool is_strict = false)
        : path_(path)
        , is_strict_(is_strict)
        , lines_(path)
        , error_(lines_.error()) {}

    /// Fills `points` with the next at most `most` points; false at the end of the file or on an error.
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

    /// Returns the line of the last point read, counted from 1.
    std::size_t line() const { return lines_.line(); }

    /// Returns the share of the file that has been read, in [0, 1].
    double fraction() const { return lines_.fraction(); }

private:
    std::string path_;
    bool is_strict_ = false;
    LineReader lines_;
    detail::RowFilter rows_;
    std::string error_;
};

/// Rows and columns of a table.
struct TableSize {
    std::size_t rows = 0, columns = 0;
};

/// Reads a table: a row a line, cells between commas, all rows as long as the first.
///
///   take    gets each cell's text, without blanks around it, row by row; returns why it is wrong, else
///           nothing
///   fails   where the file cannot be read, holds no row, rows differ, or a cell is wrong: with line and
///           column
Expected<TableSize> read_table(const std::string& path,
                               const std::function<std::string(std::string_view)>& take);

/// Lines of a cage's file that belong together.
struct CageBlock {
    enum class Kind { loop, chain, point };

    Kind kind = Kind::loop;
    double radius = 0; // of a point
    std::vector<Point2> points;
};

/// A cage as blocks of "x,y" lines with empty lines between them: loops, the outer one first; chains,
/// headed by a line "# chain"; points, headed by "# point RADIUS". Other lines that begin with '#' are
/// skipped.
Expected<std::vector<CageBlock>> parse_cage_csv(std::string_view text, const std::string& name);

/// Works as parse_cage_csv(), from a file; fails also where it cannot be read.
Expected<std::vector<CageBlock>> read_cage_csv(const std::string& path);

/// The text for --help on the labels of a cage's vertices.
inline constexpr const char* labels_format =
    "Labels are a text file with a line for every vertex of the cage, in its order. A\n"
    "vertex whose line is empty has no label; lines that begin with # are comments.\n";

/// Labels of the vertices of a cage, from a file of a line for each; empty where a vertex has none. Lines
/// that begin with '#' are skipped, blanks at both ends of a line are left out.
///
///   fails   where the file cannot be read, has not `count` lines or no labels, a label stands there twice
///           or holds a
///           control character
Expected<std::vector<std::string>> read_labels(const std::string& path, std::size_t count);

} // namespace cageform_support

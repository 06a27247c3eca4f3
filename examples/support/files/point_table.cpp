#include "files/point_table.hpp"

#include "io/csv.hpp"
#include "io/input_file.hpp"

#include <algorithm>
#include <optional>

namespace cageform_support {

namespace {

/// Returns the column of x in a header with neighbouring columns x, y and z; nothing if it has none.
std::optional<std::size_t> named_column(std::string_view header) {
    const auto cells = detail::cells_of(detail::trim(header));
    const auto is = [&](std::size_t k, char axis) {
        return cells[k].size() == 1 && (cells[k][0] == axis || cells[k][0] == axis - 'a' + 'A');
    };
    for (std::size_t k = 0; k + 2 < cells.size(); ++k) {
        if (is(k, 'x') && is(k + 1, 'y') && is(k + 2, 'z')) return k;
    }
    return std::nullopt;
}

bool is_number(std::string_view cell) {
    double ignored = 0;
    return detail::parse_number(cell, ignored).empty();
}

/// Whether a line has the columns of a bone: its name, its parent, its head, its tail and its turn.
bool is_bone(std::span<const std::string_view> cells) {
    return cells.size() == 11 && !is_number(cells[0]) && !is_number(cells[1]) &&
           std::all_of(cells.begin() + 2, cells.end(), is_number);
}

/// Appends the point in three cells. Returns the error; empty on success.
std::string add_point(std::span<const std::string_view> cells, std::size_t column, PointTable& table) {
    if (cells.size() < column + 3) return "a point has three numbers: x,y,z";
    Point3 p;
    ObjNumbers numbers;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::string_view cell = cells[column + k];
        if (const std::string why = detail::parse_finite(cell, p[k]); !why.empty())
            return "column " + std::to_string(column + k + 1) + ": " + why;
        numbers.begin[k] = std::size_t(cell.data() - table.text.data());
        numbers.end[k] = numbers.begin[k] + cell.size();
    }
    table.points.push_back(p);
    table.numbers.push_back(numbers);
    return {};
}

/// Appends the points of a line. Returns the error; empty on success.
std::string add_row(std::string_view line, std::optional<std::size_t> column, PointTable& table) {
    const auto cells = detail::cells_of(line);
    if (!column && is_bone(cells)) {
        const std::size_t head = table.points.size();
        std::string why = add_point(cells, 2, table);
        if (why.empty()) why = add_point(cells, 5, table);
        if (why.empty()) table.segments.push_back({head, head + 1});
        return why;
    }
    const auto first = std::find_if(cells.begin(), cells.end(), is_number);
    return add_point(cells, column.value_or(std::size_t(first - cells.begin())), table);
}

} // namespace

Expected<PointTable> parse_point_table(std::string text, std::string name) {
    PointTable table{std::move(name), std::move(text), {}, {}, {}};
    std::optional<std::size_t> column;
    std::string_view rest = table.text, line;
    detail::RowFilter rows;
    for (std::size_t number = 1; take_line(rest, line); ++number) {
        const std::string_view whole = line;
        if (!rows.take(line)) {
            if (table.points.empty() && !column && detail::is_header(whole)) column = named_column(whole);
            continue;
        }
        const std::string why = add_row(line, column, table);
        if (!why.empty()) return detail::row_fault(table.name, number, line, why);
    }
    if (table.points.empty()) return FileError{table.name + ": holds no points"};
    return table;
}

Expected<PointTable> load_point_table(const std::string& path) {
    auto text = read_text(path);
    return text ? parse_point_table(std::move(*text), path) : text.error();
}

std::string to_text(const PointTable& table, std::span<const Point3> moved) {
    std::string text;
    std::size_t at = 0; // end of what is copied
    for (std::size_t n = 0; n < table.points.size(); ++n) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (moved[n][k] == table.points[n][k]) continue;
            text.append(table.text, at, table.numbers[n].begin[k] - at);
            detail::append_digits(text, moved[n][k]);
            at = table.numbers[n].end[k];
        }
    }
    return text.append(table.text, at);
}

} // namespace cageform_support

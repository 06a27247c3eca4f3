// Draws a field on a grid: a colour map with contour lines, and a surface.
//
//     height_map hills.svg -o hills.csv
//     grid_field hills.csv -o field.png --surface surface.png
//
// The grid is a CSV file with one row per line: numbers, or fractions as puzzle writes them. Cells that are
// empty, "." or "nan" are outside.

#include "io/csv.hpp"
#include "io/messages.hpp"
#include "pictures/field_plot.hpp"
#include "pictures/level_lines.hpp"

#include <cmath>
#include <iostream>
#include <limits>

namespace {

using namespace cageform_support;

struct Grid {
    std::size_t width = 0;
    std::vector<double> values; // row by row; NaN outside

    std::size_t height() const { return values.size() / width; }
};

/// Parses a number or a fraction a/b; returns the fault, or empty.
std::string parse_cell(std::string_view cell, double& value) {
    const std::size_t bar = std::min(cell.find('/'), cell.size());
    std::string why = detail::parse_number(cell.substr(0, bar), value);
    double below = 1;
    if (why.empty() && bar < cell.size()) why = detail::parse_number(cell.substr(bar + 1), below);
    value /= below;
    return why.empty() && std::isinf(value) ? detail::quoted(cell) + " is not finite" : why;
}

/// Reads a grid; an error has the line and the column.
Expected<Grid> load_grid(const std::string& path) {
    Grid grid;
    const auto size = read_table(path, [&](std::string_view cell) -> std::string {
        double& value = grid.values.emplace_back(std::numeric_limits<double>::quiet_NaN());
        if (cell.empty() || cell == ".") return {};
        return parse_cell(cell, value);
    });
    if (!size) return size.error();
    grid.width = size->columns;
    if (std::all_of(grid.values.begin(), grid.values.end(), [](double value) { return std::isnan(value); }))
        return FileError{path + ": has no values"};
    return grid;
}

/// Draws cells as squares of pixels, and over them contour lines through the centres.
Picture draw_cells(const Grid& grid, const PlaneBox& part, const FieldStyle& style) {
    const double scale = 2 * double(style.size) / part.extent();
    const std::size_t width = 2 * std::size_t(std::ceil(part.width() * scale / 2));
    const std::size_t height = 2 * std::size_t(std::ceil(part.height() * scale / 2));
    std::vector<double> values(width * height, std::numeric_limits<double>::quiet_NaN());
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x) {
            const double column = std::floor(part.low.x + (double(x) + 0.5) / scale);
            const double row = std::floor(part.low.y + (double(y) + 0.5) / scale);
            if (column >= 0 && row >= 0 && column < double(grid.width) && row < double(grid.height()))
                values[y * width + x] = grid.values[std::size_t(row) * grid.width + std::size_t(column)];
        }
    }
    FieldStyle plain = style;
    plain.step = 0;
    Picture fine = draw_field(values, width, plain);
    for (double n = 1; n < double(style.levels); ++n) {
        for (const auto& line : level_lines(grid.values, grid.width, style.zero + n * style.step)) {
            for (std::size_t k = 1; k < line.size(); ++k) {
                const auto at = [&](const Point2& p) {
                    return Point2{(p.x + 0.5 - part.low.x) * scale, (p.y + 0.5 - part.low.y) * scale};
                };
                fine.line(at(line[k - 1]), at(line[k]), 2, style.ink());
            }
        }
    }
    return fine.halved();
}

/// The centres of cells in a part of the grid.
FieldSurface surface_of(const Grid& grid, const PlaneBox& part) {
    FieldSurface surface{mesh_of_grid(grid.width, grid.height()), grid.values, {}};
    for (std::size_t i = 0; i < grid.values.size(); ++i) {
        const Point2& p = surface.mesh.places[i];
        if (p.x < part.low.x || p.x > part.high.x || p.y < part.low.y || p.y > part.high.y)
            surface.values[i] = std::numeric_limits<double>::quiet_NaN();
    }
    surface.boundary = rim_of(surface.mesh, surface.values);
    return surface;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Draws a field on a grid from a CSV file with one row of cells per line.");
    line.set_examples({"hills.csv -o field.png", "hills.csv -o field.png --surface surface.png"});
    std::string path, out, zoom;
    FieldStyle style;
    SurfaceView view;
    line.add("grid", path,
             "a CSV file of numbers and fractions; a cell that is empty, \".\" or nan lies outside")
        .required();
    line.add("-o,--output", out, "the PNG file to write").required().ends_with({".png"});
    style.add_options(line);
    line.add("--zoom", zoom, "x,y,width,height: draw only this part of the grid, in cells").check(box_fault);
    view.add_options(line);
    if (const auto code = line.parse(argc, argv)) return *code;

    const auto grid = load_grid(path).value();
    const auto [least, largest] = least_and_largest(grid.values);
    const double size = std::max(std::fabs(least), std::fabs(largest));
    const double zero = style.signs == "root" ? 0 : least, one = style.signs == "root" ? size : largest;
    style.set_range(zero, one > zero ? one : zero + std::max(1.0, std::fabs(zero))); // if all are equal

    const PlaneBox whole{{0, 0}, {double(grid.width), double(grid.height())}};
    const PlaneBox part = parse_box(zoom).value_or(whole);
    OutputFiles outputs;
    with_colour_bar(draw_cells(grid, part, style), least, style.one, style).write_png(outputs.add(out));
    if (!view.path.empty())
        draw_surface(surface_of(grid, part), view, style).write_png(outputs.add(view.path));
    if (const auto error = outputs.commit()) return fail(*error);
    std::cout << grid.height() << " rows of " << grid.width << " cells: " << least << " to " << largest
              << '\n';
    return 0;
}

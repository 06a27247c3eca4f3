// Draws the cells of the adaptive grid for the harmonic functions of a cage, coloured by size. In the plane
// it draws all cells, with the cage and a figure; in space the cells that a plane cuts.
//
//     adaptive_grid --cage cat_cage.svg --figure cat.svg --accuracy 0.001 -o grid.svg --png
//     adaptive_grid --cage character_cage.obj --figure character.obj --slice y=0 -o grid.svg --png

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/mesh_cage.hpp"
#include "files/bind_report.hpp"
#include "files/cage_file.hpp"
#include "io/base64.hpp"
#include "io/messages.hpp"
#include "pictures/field_plot.hpp"
#include "pictures/picture.hpp"
#include "pictures/plot.hpp"
#include "pictures/render.hpp"
#include "svg/document.hpp"

#include <iostream>
#include <map>

namespace {

using namespace cageform_support;

struct Square {
    Point2 low;
    double size;
};
using Segments = std::vector<std::array<Point2, 2>>;

/// The drawing, in the plane of the picture.
struct Section {
    std::vector<Square> cells;
    Segments cage, figure;
    std::string image; // drawn below everything else
    bool y_up = false;
};

/// A plane at right angles to an axis of space.
struct Slice {
    std::size_t axis = 2;
    double at = 0;

    Point2 flat(const Point3& p) const {
        return axis == 0 ? Point2{p[1], p[2]} : Point2{p[0], p[axis == 1 ? 2 : 1]};
    }
};

/// Parses "z=0.5"; empty if the text is not a plane.
std::optional<Slice> parse_slice(const std::string& text) {
    Slice slice;
    if (text.size() < 3 || text[0] < 'x' || text[0] > 'z' || text[1] != '=') return std::nullopt;
    slice.axis = std::size_t(text[0] - 'x');
    const std::string why = detail::parse_number(std::string_view(text).substr(2), slice.at);
    if (!why.empty() || !std::isfinite(slice.at)) return std::nullopt;
    return slice;
}
std::string slice_fault(const std::string& text) {
    return parse_slice(text) ? ""
                             : detail::quoted(text) + " is not a plane: write x=NUMBER, y=NUMBER or z=NUMBER";
}

/// The segments in which a plane cuts a mesh.
Segments cut(const std::vector<Point3>& vertices, const std::vector<std::array<std::uint32_t, 3>>& triangles,
             const Slice& slice) {
    Segments segments;
    for (const auto& triangle : triangles) {
        std::vector<Point2> ends;
        for (std::size_t k = 0; k < 3; ++k) {
            const Point3 &a = vertices[triangle[k]], &b = vertices[triangle[(k + 1) % 3]];
            const double above = a[slice.axis] - slice.at, next = b[slice.axis] - slice.at;
            if ((above > 0) != (next > 0)) ends.push_back(slice.flat(a + (above / (above - next)) * (b - a)));
        }
        if (ends.size() == 2) segments.push_back({ends[0], ends[1]});
    }
    return segments;
}

/// Prints how many cells there are of each size. On failure the report says why.
template <std::size_t D>
std::vector<cageform::GridCell<double, D>> cells_of(const ChosenCoordinates<double, D>& coordinates,
                                                    cageform::BindReport& report) {
    struct Count {
        std::size_t all = 0, cut = 0;
    };
    std::map<double, Count, std::greater<>> counts;
    std::vector<cageform::GridCell<double, D>> cells;
    const auto evaluation = coordinates.for_each_cell([&](const cageform::GridCell<double, D>& cell) {
        cells.push_back(cell);
        Count& count = counts[cell.size];
        ++count.all;
        count.cut += cell.is_cut ? 1 : 0;
    });
    report.status = evaluation.status;
    report.solver = evaluation.solver;
    report.cage = coordinates.cage_report();
    if (report.status != cageform::Status::ok) return cells;
    std::cout << cells.size() << " cells inside the cage or on its boundary\n";
    if (report.solver.tree.finest_size > 0) std::cout << describe_grid(report.solver) << '\n';
    for (const auto& [size, count] : counts)
        std::cout << text_of("%12.4g", size) << " wide: " << count.all << ", cut by the cage: " << count.cut
                  << '\n';
    return cells;
}

std::string number(double x) {
    return text_of("%.9g", x);
}
/// The attributes x, y, width and height of an SVG element.
std::string place(double x, double y, double width, double height) {
    return " x=\"" + number(x) + "\" y=\"" + number(y) + "\" width=\"" + number(width) + "\" height=\"" +
           number(height) + "\"";
}

struct Arguments {
    std::string cage, figure, out, slice, zoom;
    bool png = false;
    bool is_strict = false;
    int png_width = 1200;
    CoordinatesChoice choice;
};

Section in_plane(const Arguments& given) {
    const auto cage = value_or_fail(load_cage(given.cage));
    Section section;
    cage.for_each_edge(
        [&](std::size_t i, std::size_t j) { section.cage.push_back({cage.vertices[i], cage.vertices[j]}); });
    if (!given.figure.empty()) {
        const auto figure = value_or_fail(load_svg(given.figure));
        const auto view = view_box(figure);
        section.image = "<image" + place(view.x, view.y, view.width, view.height) +
                        " href=\"data:image/svg+xml;base64," + base64(to_text(figure)) + "\"/>\n";
    }
    const auto coordinates = make_coordinates<double>(given.choice, cage);
    cageform::BindReport report;
    const auto cells = cells_of(coordinates, report);
    if (report.status != cageform::Status::ok) throw Failure(describe_faults(given.cage, report));
    for (const auto& cell : cells) section.cells.push_back({{cell.low[0], cell.low[1]}, cell.size});
    return section;
}

Section in_space(const Arguments& given) {
    const auto cage = value_or_fail(load_mesh_cage(given.cage));
    auto slice = parse_slice(given.slice);
    if (!slice) { // at right angles to the shortest side of the cage, through its middle
        const auto bounds = cageform::bounds_of(std::span<const Point3>(cage.vertices));
        const auto extent = bounds.upper - bounds.lower;
        slice.emplace();
        for (std::size_t k = 0; k < 3; ++k) slice->axis = extent[k] < extent[slice->axis] ? k : slice->axis;
        slice->at = 0.5 * (bounds.lower[slice->axis] + bounds.upper[slice->axis]);
    }
    Section section;
    section.y_up = true;
    section.cage = cut(cage.vertices, cage.triangles, *slice);
    if (!given.figure.empty()) {
        const auto figure = load_mesh_figure(given.figure, given.is_strict);
        section.figure = cut(figure.vertices, figure.triangles, *slice);
    }
    const auto coordinates = make_coordinates<double>(given.choice, cage);
    cageform::BindReport report;
    const auto cells = cells_of(coordinates, report);
    if (report.status != cageform::Status::ok) throw Failure(describe_mesh_faults(given.cage, report));
    for (const auto& cell : cells) {
        const double above = slice->at - cell.low[slice->axis];
        if (above >= 0 && above < cell.size) section.cells.push_back({slice->flat(cell.low), cell.size});
    }
    if (section.cells.empty()) throw Failure("--slice: the plane does not meet the cage");
    return section;
}

/// A colour in CSS notation.
std::string name_of(const Colour& colour) {
    std::string name = "rgb(";
    for (const float channel : {colour.r, colour.g, colour.b})
        name += std::to_string(std::lround(255 * channel)) + ",";
    name.back() = ')';
    return name;
}
std::string view_box_of(double x, double y, double width, double height) {
    return " viewBox=\"" + number(x) + " " + number(y) + " " + number(width) + " " + number(height) + "\"";
}
std::string lines(const Segments& segments, double up, const char* colour, double thickness) {
    std::string path;
    for (const auto& [a, b] : segments)
        path += "M" + number(a.x) + "," + number(up * a.y) + "L" + number(b.x) + "," + number(up * b.y);
    return "<path d=\"" + path + "\" fill=\"none\" stroke-linecap=\"round\" stroke=\"" + colour +
           "\" stroke-width=\"" + number(thickness) + "\"/>\n";
}

/// Draws each size of cells in one colour, finer cells darker, beside a scale of sizes. Empty if no cell is
/// visible.
std::string draw(const Section& section, const PlaneBox& box) {
    const double up = section.y_up ? -1 : 1, unit = section.cells.front().size;
    std::map<int, std::string> paths; // by the logarithm of the size
    for (const Square& cell : section.cells) {
        const bool is_seen = cell.low.x < box.high.x && cell.low.x + cell.size > box.low.x &&
                             cell.low.y < box.high.y && cell.low.y + cell.size > box.low.y;
        if (!is_seen) continue;
        const std::string size = number(cell.size),
                          y = number(section.y_up ? -cell.low.y - cell.size : cell.low.y);
        paths[int(std::lround(std::log2(cell.size / unit)))] +=
            "M" + number(cell.low.x) + "," + y + "h" + size + "v" + size + "h-" + size + "z";
    }
    if (paths.empty()) return {};
    constexpr double side = 1000, letter = 22; // of the picture, in its own units
    const double scale = side / box.extent(), width = scale * box.width(),
                 height = std::max(scale * box.height(), 36.0 * double(paths.size()));
    const double pen = box.extent() / 400;
    std::string svg =
        "<svg xmlns=\"http://www.w3.org/2000/svg\"" + view_box_of(0, 0, width + 7 * letter, height) +
        " font-family=\"DejaVu Sans, sans-serif\" font-size=\"" + number(letter) + "\">\n<rect" +
        place(0, 0, width + 7 * letter, height) + " fill=\"white\"/>\n<svg" +
        place(0, 0, width, scale * box.height()) +
        view_box_of(box.low.x, section.y_up ? -box.high.y : box.low.y, box.width(), box.height()) + ">\n" +
        section.image;
    std::string sizes;
    double row = 1.2 * letter;
    const int largest = paths.rbegin()->first, steps = std::max(largest - paths.begin()->first, 1);
    for (auto path = paths.rbegin(); path != paths.rend(); ++path, row += 1.5 * letter) { // largest first
        const auto& [level, cells] = *path;
        const double size = std::ldexp(unit, level);
        const Colour colour = heat(-0.05 - 0.35 * double(largest - level) / steps);
        const std::string style =
            " fill=\"" + name_of(colour) + "\" stroke=\"" + name_of(mix(colour, {0, 0, 0}, 0.45f)) + "\"";
        svg += "<path" + style + " fill-opacity=\"0.55\" stroke-width=\"" +
               number(std::min(0.2 * pen, 0.06 * size)) + "\" d=\"" + cells + "\"/>\n";
        sizes += "<rect" + place(width + letter, row - 0.8 * letter, letter, letter) + style +
                 "/><text x=\"" + number(width + 2.4 * letter) + "\" y=\"" + number(row) + "\">" +
                 text_of("%.3g", size) + "</text>\n";
    }
    return svg + lines(section.figure, up, "#1b4f9c", pen) + lines(section.cage, up, "#111111", pen) +
           "</svg>\n" + sizes + "</svg>\n";
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Draws the cells of the adaptive grid for a cage's harmonic functions: in the plane all "
                     "cells, in space the cells that a plane cuts. Finer cells are darker. Prints the number "
                     "of cells of each size.");
    line.set_examples({"--cage cat_cage.svg --figure cat.svg --accuracy 0.001 -o grid.svg --png",
                       "--cage character_cage.obj --figure character.obj --slice y=0 -o grid.svg"});
    Arguments given;
    line.add("--cage", given.cage, "an SVG or CSV file, or in space an OBJ file").required();
    line.add("--figure", given.figure, "an SVG or OBJ file, whose outlines are drawn over the cells");
    line.add("-o,--output", given.out, "the SVG file to write").required().ends_with({".svg"});
    line.add_png(given.png, given.png_width);
    line.add("--accuracy", given.choice.harmonic.accuracy, "the target for the largest error of a weight")
        .range(1e-5, 0.1)
        .show_default();
    line.add("--slice", given.slice,
             "in space: the plane that cuts cage and cells, such as z=0.5; by default through the middle of "
             "the cage's shortest side")
        .check(slice_fault);
    line.add("--zoom", given.zoom,
             "x,y,width,height: draw only this part of the picture's plane, in the cage's units")
        .check(box_fault);
    add_strict(line, given.is_strict);
    line.set_footer(std::string(cage_formats) + "\n" + mesh_formats);
    given.choice.name = "harmonic";
    given.choice.harmonic.accuracy = 1e-3;
    if (const auto code = line.parse(argc, argv)) return *code;

    const bool is_mesh = given.cage.ends_with(".obj");
    if (!is_mesh && !given.slice.empty()) return fail("--slice: " + given.cage + " lies in the plane");
    const auto section = is_mesh ? in_space(given) : in_plane(given);
    PlaneBox around;
    for (const auto& segment : section.cage) {
        for (const Point2& p : segment) around.add(p);
    }
    const double margin = 0.02 * around.extent();
    around.add({around.low.x - margin, around.low.y - margin});
    around.add({around.high.x + margin, around.high.y + margin});
    OutputFiles outputs;
    const auto picture = draw(section, parse_box(given.zoom).value_or(around));
    if (picture.empty()) return fail("no part of the grid is at --zoom " + given.zoom);
    add_svg(outputs, given.out, picture, given.png ? given.png_width : 0);
    return commit(outputs);
}

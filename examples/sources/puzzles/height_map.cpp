// Heights from a few lines: contours, ridges and rivers of a drawing are interpolated harmonically.
//
//     height_map hills.svg -o hills.png --lines hills_lines.svg --3d hills_3d.png --levels 0.1
//
// Each stroke of the SVG has a height: its attribute data-height, or the lightness of its colour. Between the
// lines the field is harmonic and has no extrema.

#include "cli/command_line.hpp"
#include "cli/progress_bar.hpp"
#include "files/stroke_file.hpp"
#include "io/messages.hpp"
#include "pictures/field_plot.hpp"
#include "pictures/level_lines.hpp"

#include <cageform/fields/strokes.hpp>

#include <charconv>
#include <iostream>

namespace {

using namespace cageform_support;

struct HeightOptions {
    std::string strokes, lines;
    std::vector<std::string> outputs;
    double step = 0.1;
    std::size_t size = 512;
    std::string rim = "mirrored";
    SurfaceView view;
};

Expected<std::vector<double>> read_height(const std::string& word) {
    double value = 0;
    const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (fault != std::errc() || end != word.data() + word.size() || !(value >= 0 && value <= 1))
        return FileError{"\"" + word + "\" is not a height from 0 to 1"};
    return std::vector<double>{value};
}
Expected<std::vector<double>> heights_of(const DrawnLine& line) {
    const std::string text = line.attribute("data-height");
    if (!text.empty()) return values_along(line, text, 1, read_height);
    const auto colour = parse_colour(line.stroke);
    if (!colour)
        return FileError{"has no data-height, and its stroke \"" + line.stroke + "\" is not a colour"};
    const auto& [r, g, b] = colour->colour;
    return std::vector<double>(line.points.size(),
                               0.2126 * double(r) + 0.7152 * double(g) + 0.0722 * double(b));
}

/// The field of a drawing, or an error with the stroke.
Expected<cageform::Diffusion<double>> diffuse(const StrokeFile& file, const HeightOptions& options) {
    const auto& [x, y, width, height] = file.canvas;
    cageform::Diffusion<double> field({{x, y}, {x + width, y + height}}, options.size, 1);
    const auto add = [&](const std::string& label, const cageform::Stroke<double>& stroke) {
        const auto status = field.add(stroke);
        return status == cageform::Status::ok ? "" : file.name + ": " + label + ": " + to_string(status);
    };
    for (const DrawnLine& line : file.lines) {
        const auto heights = heights_of(line);
        if (!heights) return FileError{file.name + ": " + line.label + ": " + heights.error().message};
        const std::string fault = add(line.label, {line.points, *heights, {}, 0});
        if (!fault.empty()) return FileError{fault};
    }
    if (options.rim == "frame") {
        const double in = 1e-9 * std::max(width, height);
        const double left = x + in, right = x + width - in, low = y + in, high = y + height - in;
        const std::string fault =
            add("the frame", {{{left, low}, {right, low}, {right, high}, {left, high}, {left, low}},
                              std::vector<double>(5, 0.0),
                              {},
                              0});
        if (!fault.empty()) return FileError{fault};
    }
    ProgressBar bar("height map");
    const auto solved = field.solve({}, {.progress = bar.callback()});
    if (solved.status == cageform::Status::grid_too_coarse) {
        const std::size_t culprit = solved.solver.culprit; // the last stroke is the frame
        return FileError{file.name + ": " +
                         (culprit < file.lines.size() ? file.lines[culprit].label : "the frame") +
                         " is smaller than a pixel: give a larger --size"};
    }
    if (solved.status != cageform::Status::ok) return FileError{file.name + ": " + to_string(solved.status)};
    return field;
}

void write_field(AtomicFile& out, const cageform::Diffusion<double>& field) {
    const auto cells = field.lattice().cells;
    const std::string ending = out.path().extension().string();
    if (ending == ".csv") {
        for (std::size_t i = 0; i < field.field(0).size(); ++i) {
            std::array<char, 32> text{};
            const auto end = std::to_chars(text.data(), text.data() + text.size(), field.field(0)[i]).ptr;
            out.write({text.data(), std::size_t(end - text.data())});
            out.write((i + 1) % cells[0] == 0 ? "\n" : ",");
        }
        return;
    }
    std::vector<std::uint16_t> greys;
    for (const double height : field.field(0))
        greys.push_back(std::uint16_t(std::lround(65535 * std::clamp(height, 0.0, 1.0))));
    if (ending == ".png") return write_png_16(out, cells[0], greys);
    std::string text = "P5 " + std::to_string(cells[0]) + " " + std::to_string(cells[1]) + " 65535\n";
    for (const std::uint16_t grey : greys) {
        text += char(grey >> 8);
        text += char(grey & 255);
    }
    out.write(text);
}

/// Contour lines over the strokes, in the drawing's units; every fifth is thick.
void write_lines(AtomicFile& out, const StrokeFile& file, const cageform::Diffusion<double>& field,
                 double step) {
    const auto lattice = field.lattice();
    const auto& [x, y, width, height] = file.canvas;
    const auto number = [](double value) { return format_number(value, 3); };
    const double thin = std::max(width, height) / 800;
    out.write("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"" + number(x) + " " + number(y) + " " +
              number(width) + " " + number(height) + "\">\n<g fill=\"none\" stroke-linejoin=\"round\">\n");
    for (int n = 1; n * step < 1 - 1e-9; ++n) {
        Path path;
        for (const auto& line : level_lines(field.field(0), lattice.cells[0], n * step)) {
            PathBuilder builder;
            for (const Point2& p : line) {
                const Point2 place{lattice.origin[0] + (p.x + 0.5) * lattice.spacing,
                                   lattice.origin[1] + (p.y + 0.5) * lattice.spacing};
                if (&p == &line.front()) {
                    builder.move_to(place);
                } else {
                    builder.line_to(place);
                }
            }
            for (Subpath& subpath : builder.take()) path.push_back(std::move(subpath));
        }
        if (path.empty()) continue;
        out.write("<path data-level=\"" + number(n * step) + "\" stroke=\"#7a4a21\" stroke-width=\"" +
                  number(n % 5 == 0 ? 2 * thin : thin) + "\" d=\"" + write_path_data(path, 3) + "\"/>\n");
    }
    for (const DrawnLine& line : file.lines) {
        std::string points;
        for (const auto& p : line.points) points += number(p[0]) + "," + number(p[1]) + " ";
        points.pop_back();
        out.write("<polyline stroke=\"#1f4e79\" stroke-width=\"" + number(2.5 * thin) + "\" points=\"" +
                  points + "\"/>\n");
    }
    out.write("</g>\n</svg>\n");
}

/// The heights as a surface, with the strokes on it.
Picture draw_hills(const StrokeFile& file, const cageform::Diffusion<double>& field,
                   const HeightOptions& options) {
    const auto lattice = field.lattice();
    const auto values = field.field(0);
    FieldSurface surface{
        mesh_of_grid(lattice.cells[0], lattice.cells[1]), {values.begin(), values.end()}, {}};
    for (Point2& p : surface.mesh.places) {
        p = {lattice.origin[0] + p.x * lattice.spacing, lattice.origin[1] + p.y * lattice.spacing};
    }
    for (const DrawnLine& line : file.lines) {
        const auto heights = heights_of(line);
        PlaneLine& above = surface.boundary.emplace_back();
        for (const auto& p : line.points) above.points.push_back({p[0], p[1]});
        above.values = *heights;
    }
    FieldStyle style;
    style.step = options.step;
    return draw_surface(surface, options.view, style);
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line(
        "Diffuses the heights of drawn lines over a drawing: a height map, black for 0, white for 1.");
    line.set_examples({"hills.svg -o hills.png --lines hills_lines.svg",
                       "hills.svg -o hills.png --3d hills_3d.png --levels 0.1"});
    HeightOptions options;
    line.add("drawing", options.strokes, "an SVG file; every stroke is a line of known height").required();
    line.add(
            "-o,--output", options.outputs,
            "the height map: .png or .pgm with 16 bits per pixel, .csv with all digits; several may be given")
        .required()
        .ends_with({".png", ".pgm", ".csv"});
    line.add("--lines", options.lines, "an SVG file to write level lines to, over the strokes")
        .ends_with({".svg"});
    line.add("--levels", options.step, "the step from one level line to the next")
        .range(0.001, 1.0)
        .show_default();
    line.add("--size", options.size, "pixels along the longer side").range(16, 8192).show_default();
    options.view.add_options(line, "--3d");
    line.add("--rim", options.rim, "the rim of the picture: nothing flows through it, or a frame of height 0")
        .one_of({"mirrored", "frame"})
        .show_default();
    line.set_footer("The height of a stroke is its attribute data-height, from 0 to 1: one number, or two\n"
                    "for its ends, or one for each of its vertices, interpolated linearly. Without it, the\n"
                    "height is the lightness of the stroke's colour: black is 0, white is 1.\n");
    if (const auto code = line.parse(argc, argv)) return *code;

    const auto file = load_strokes(options.strokes, {"data-height"}).value();
    const auto field = diffuse(file, options).value();
    OutputFiles outputs;
    for (const std::string& path : options.outputs) write_field(outputs.add(path), field);
    if (!options.lines.empty()) write_lines(outputs.add(options.lines), file, field, options.step);
    if (!options.view.path.empty())
        draw_hills(file, field, options).write_png(outputs.add(options.view.path));
    if (const auto error = outputs.commit()) return fail(*error);
    const auto [least, largest] = std::minmax_element(field.field(0).begin(), field.field(0).end());
    std::cout << file.lines.size() << " strokes, heights " << *least << " to " << *largest << '\n';
    return 0;
}

// Diffusion curves: smooth colours from lines with a colour on each side.
//
//     diffuse_colours cat_colours.svg -o cat_colours.png
//
// The attributes data-left and data-right are the colours on the sides of a stroke; the default is the
// stroke's colour. Colours are diffused as linear values, premultiplied by alpha; --srgb uses sRGB values.

#include "cli/command_line.hpp"
#include "cli/progress_bar.hpp"
#include "files/stroke_file.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"
#include "pictures/picture.hpp"

#include <cageform/fields/strokes.hpp>

#include <iostream>

namespace {

using namespace cageform_support;
constexpr std::size_t channels = 4; // red, green, blue, each times alpha, and alpha

/// Conversion of a colour to diffused values, and back.
struct Light {
    bool as_displayed = false;

    Expected<std::vector<double>> read(const std::string& word) const {
        const auto colour = parse_colour(word);
        if (!colour) return FileError{"\"" + word + "\" is not a colour"};
        const double alpha = double(colour->alpha);
        std::vector<double> values;
        for (const float channel : {colour->colour.r, colour->colour.g, colour->colour.b})
            values.push_back(alpha * (as_displayed ? double(channel) : to_linear(double(channel))));
        values.push_back(alpha);
        return values;
    }
    /// Returns the bytes of the mean of `samples` samples.
    std::array<char, channels> bytes(const double* values, std::size_t samples) const {
        std::array<double, channels> mean{};
        for (std::size_t i = 0; i < samples * channels; ++i)
            mean[i % channels] += values[i] / double(samples);
        std::array<char, channels> bytes{};
        for (std::size_t c = 0; c < channels; ++c) {
            double value = mean[c];
            if (c < 3 && mean[3] > 0) value /= mean[3];
            if (c < 3 && !as_displayed) value = to_displayed(value);
            bytes[c] = char(std::lround(255 * std::clamp(value, 0.0, 1.0)));
        }
        return bytes;
    }
};

/// The left and right values of a line on the screen, where y points down. In the library's coordinates, with
/// y up, the sides are swapped.
Expected<cageform::Stroke<double>> stroke_of(const DrawnLine& line, const Light& light) {
    cageform::Stroke<double> stroke{line.points, {}, {}, 0};
    const auto read = [&](const std::string& word) { return light.read(word); };
    const std::string left = line.attribute("data-left"), right = line.attribute("data-right");
    const auto values = [&](const std::string& own, const std::string& other) {
        return values_along(line, !own.empty() ? own : !other.empty() ? other : line.stroke, channels, read);
    };
    auto on_left = values(left, right), on_right = values(right, left);
    if (!on_left) return on_left.error();
    if (!on_right) return on_right.error();
    stroke.left = std::move(*on_right);
    if (!left.empty() && !right.empty()) stroke.right = std::move(*on_left);
    return stroke;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line(
        "Fills a drawing with smooth colours, diffused from the colours on both sides of its lines.");
    line.set_examples({"cat_colours.svg -o cat_colours.png", "cat_colours.svg -o large.png --size 2000"});
    std::string drawing, out_path;
    std::size_t size = 768;
    Light light;
    line.add("drawing", drawing, "an SVG file").required();
    line.add("-o,--output", out_path, "the PNG file to write").required().ends_with({".png"});
    line.add("--size", size, "pixels along the longer side").range(16, 8192).show_default();
    line.add_flag("--srgb", light.as_displayed, "diffuse sRGB values, not linear light");
    line.set_footer("Each stroke has the colours data-left and data-right on its sides, seen along its\n"
                    "direction. If only one is given, or neither and the stroke has a colour of its own,\n"
                    "it is the colour of both sides. An attribute is one colour, or two for the ends of\n"
                    "the stroke, or one for each of its vertices, interpolated linearly. A colour is\n"
                    "#rgb, #rrggbb, #rrggbbaa, rgb(…) or a name.\n");
    if (const auto code = line.parse(argc, argv)) return *code;

    const auto file = load_strokes(drawing, {"data-left", "data-right"}).value();
    const auto& [x, y, width, height] = file.canvas;
    cageform::Diffusion<double> field({{x, y}, {x + width, y + height}}, size, channels);
    for (const DrawnLine& drawn : file.lines) {
        const auto stroke = stroke_of(drawn, light);
        if (!stroke) return fail(file.name + ": " + drawn.label + ": " + stroke.error().message);
        const auto status = field.add(*stroke);
        if (status != cageform::Status::ok)
            return fail(file.name + ": " + drawn.label + ": " + to_string(status));
    }
    {
        ProgressBar bar("diffuse colours");
        const auto solved = field.solve({.tolerance = 1e-4}, {.progress = bar.callback()});
        if (solved.status == cageform::Status::grid_too_coarse) {
            return fail(file.name + ": " + file.lines[solved.solver.culprit].label +
                        " is smaller than a pixel: give a larger --size");
        }
        if (solved.status != cageform::Status::ok) return fail(file.name + ": " + to_string(solved.status));
    }
    // Each pixel is the mean of four places, so that the lines are smooth.
    const auto lattice = field.lattice();
    std::string bytes;
    std::vector<cageform::Vec<double, 2>> places(4 * lattice.cells[0]);
    std::vector<double> values(channels * places.size());
    for (std::size_t row = 0; row < lattice.cells[1]; ++row) {
        for (std::size_t i = 0; i < places.size(); ++i) {
            const double dx = 0.25 + 0.5 * double(i % 2), dy = 0.25 + 0.5 * double(i / 2 % 2);
            places[i] = {lattice.origin[0] + (double(i / 4) + dx) * lattice.spacing,
                         lattice.origin[1] + (double(row) + dy) * lattice.spacing};
        }
        if (field.sample(places, std::span(values)) != cageform::Status::ok) return fail("no field");
        for (std::size_t i = 0; i < places.size(); i += 4) {
            const auto pixel = light.bytes(values.data() + channels * i, 4);
            bytes.append(pixel.data(), pixel.size());
        }
    }
    AtomicFile out(out_path);
    write_png(out, lattice.cells[0], lattice.cells[1], int(channels), bytes);
    if (const auto error = out.commit()) return fail(*error);
    std::cout << file.lines.size() << " strokes, " << lattice.cells[0] << " x " << lattice.cells[1]
              << " pixels\n";
    return 0;
}

// Heat map of one coordinate over its cage: values inside with level lines, boundary values on the cage.
//
//     coordinate_field --cage CAGE.svg --vertex 8 --coordinates harmonic -o field.png

#include "bind_report.hpp"
#include "cage_file.hpp"
#include "command_line.hpp"
#include "coordinates.hpp"
#include "guard.hpp"
#include "picture.hpp"
#include "progress_bar.hpp"

#include <iostream>

namespace {

using namespace cageform_examples;

int fail(const std::string& message) {
    std::cerr << "coordinate_field: " << message << '\n';
    return 1;
}

int run_program(int argc, char** argv) {
    CommandLine line(
        "Draws one coordinate over its cage. Warm colours are positive, blue is negative, green is the "
        "value on the boundary; level lines every tenth.");
    std::string cage_path, out_path;
    std::size_t vertex = 0, size = 900;
    bool y_up = false;
    CoordinatesChoice choice;
    line.add("--cage", cage_path, "an SVG or CSV file").required();
    line.add("--vertex", vertex, "whose coordinate, from 0").required();
    line.add("-o,--output", out_path, "the PNG file to write").required().ends_with({".png"});
    line.add("--size", size, "pixels along the longer side").range(16, 8192).show_default();
    line.add_flag("--y-up", y_up, "the cage's y axis points up (as in most CSV files)");
    choice.add_options(line);
    line.set_footer(cage_formats);
    if (const auto code = line.parse(argc, argv)) return *code;

    const auto cage = load_cage(cage_path);
    if (!cage) return fail(to_string(cage.error()));
    if (vertex >= cage->vertices.size()) {
        return fail("there is no vertex " + std::to_string(vertex) + ": " + cage_path + " has " +
                    std::to_string(cage->vertices.size()));
    }
    const auto polygon = cage->polygon<double>();
    const auto coordinates = make_coordinates<double>(choice, *cage);
    if (coordinates->cage_report.status != cageform::Status::ok) {
        cageform::BindReport bad;
        bad.cage = coordinates->cage_report;
        bad.status = bad.cage.status;
        return fail(describe_faults(cage_path, bad));
    }

    // Twice the pixels, averaged at the end, and a margin for the cage's outline.
    const auto bounds = cageform::bounds_of(polygon.vertices());
    const double extent = std::max(bounds.upper[0] - bounds.lower[0], bounds.upper[1] - bounds.lower[1]);
    const double margin = 0.04 * extent;
    const double scale = 2 * double(size) / (extent + 2 * margin);
    const auto width =
        2 * std::size_t(std::ceil((bounds.upper[0] - bounds.lower[0] + 2 * margin) * scale / 2));
    const auto height =
        2 * std::size_t(std::ceil((bounds.upper[1] - bounds.lower[1] + 2 * margin) * scale / 2));
    const auto to_picture = [&](const cageform::Vec<double, 2>& p) {
        const double y = (p[1] - bounds.lower[1] + margin) * scale;
        return Point2{(p[0] - bounds.lower[0] + margin) * scale, y_up ? double(height) - y : y};
    };
    std::vector<Point2> points;
    points.reserve(width * height);
    for (std::size_t y = 0; y < height; ++y) {
        const double row = y_up ? double(height - y) - 0.5 : double(y) + 0.5;
        for (std::size_t x = 0; x < width; ++x) {
            points.push_back({(double(x) + 0.5) / scale + bounds.lower[0] - margin,
                              row / scale + bounds.lower[1] - margin});
        }
    }

    std::vector<double> values(points.size());
    std::vector<bool> inside(points.size(), true);
    double least = 0, largest = 0;
    std::string failure;
    {
        // Of the weights only one row is kept, so the picture is bound in strips.
        ProgressBar bar("coordinate field");
        const auto evaluation = coordinates->solve({.progress = bar.callback()});
        if (evaluation.status != cageform::Status::ok) failure = cageform::to_string(evaluation.status);
        const std::size_t strip = 16 * width;
        for (std::size_t first = 0; first < points.size() && failure.empty(); first += strip) {
            const std::span<const Point2> part(points.data() + first, std::min(strip, points.size() - first));
            const auto [binding, bound] =
                coordinates->bind(part, {.linear_precision = cageform::LinearPrecision::leave});
            if (bound.status != cageform::Status::ok) return fail(describe_faults(cage_path, bound));
            for (const auto* list : {&bound.outside, &bound.unreached}) {
                for (const std::size_t i : *list) inside[first + i] = false;
            }
            for (std::size_t i = 0; i < part.size(); ++i) {
                if (!inside[first + i]) continue;
                values[first + i] = binding.weight(i, vertex);
                least = std::min(least, values[first + i]);
                largest = std::max(largest, values[first + i]);
            }
        }
    }
    if (!failure.empty()) return fail(failure);

    // On the right of the field the bar that its colours are read by.
    const double letter = std::max(2.0, double(size) / 225); // a seventh of a letter's height
    const auto beside = 2 * std::size_t(28 * letter);
    Picture fine(width + beside, height);
    const Axis bar{least, std::max(largest, 1.0), 0.96 * double(height), 0.04 * double(height)};
    const int most_marks = std::clamp(int((bar.begin - bar.end) / (16 * letter)), 1, 10);
    draw_colour_bar(fine, bar, marks_of(bar, most_marks), double(width) + 4 * letter, 12 * letter, letter);
    const auto level = [&](std::size_t i) { return std::floor(values[i] * 10 + 1e-9); };
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t i = y * width + x;
            if (!inside[i]) continue;
            fine.at(x, y) = heat(values[i]);
            const bool right = x + 1 < width && inside[i + 1] && level(i) != level(i + 1);
            const bool below = y + 1 < height && inside[i + width] && level(i) != level(i + width);
            if (right || below) fine.at(x, y) = mix(fine.at(x, y), {0.15f, 0.1f, 0.1f}, 0.75f);
        }
    }
    const auto handle = [&](std::size_t i) { return cageform::to_vec<double>(cage->vertices[i]); };
    cage->for_each_edge([&](std::size_t i, std::size_t j) {
        constexpr int pieces = 64;
        for (int k = 0; k < pieces; ++k) {
            const double s = double(k) / pieces, t = double(k + 1) / pieces;
            const double value = (i == vertex ? 1 - s : 0.0) + (j == vertex ? s : 0.0);
            fine.line(to_picture((1 - s) * handle(i) + s * handle(j)),
                      to_picture((1 - t) * handle(i) + t * handle(j)), 14, boundary_hue(value));
        }
    });
    const Point2 at = to_picture(handle(vertex));
    fine.line(at, at, 36, {0.1f, 0.1f, 0.1f});
    fine.line(at, at, 24, boundary_hue(1));

    Picture picture(fine.width() / 2, height / 2);
    for (std::size_t y = 0; y < picture.height(); ++y) {
        for (std::size_t x = 0; x < picture.width(); ++x) {
            picture.at(x, y) = mix(mix(fine.at(2 * x, 2 * y), fine.at(2 * x + 1, 2 * y), 0.5f),
                                   mix(fine.at(2 * x, 2 * y + 1), fine.at(2 * x + 1, 2 * y + 1), 0.5f), 0.5f);
        }
    }
    AtomicFile out(out_path);
    picture.write_png(out);
    if (const auto error = out.commit()) return fail(*error);
    std::cout << choice.name << " coordinate of vertex " << vertex << ": " << least << " to " << largest
              << '\n';
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return guarded("coordinate_field", [&] { return run_program(argc, argv); });
}

// Coordinates as means over paths from a point to the boundary: straight rays give mean value coordinates,
// Brownian paths give harmonic coordinates. Rays may leave the cage and enter it again; Brownian paths stay
// inside.
//
//     paths --cage biped_cage.svg --point 150,600 -o paths.svg --png

#include "tables/paths.hpp"
#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "files/bind_report.hpp"
#include "io/messages.hpp"
#include "pictures/plot.hpp"
#include "pictures/render.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

namespace {

using namespace cageform_sources;

struct Arguments {
    std::string cage, point, out;
    std::size_t rays = 200'000, paths = 100'000, drawn = 40, seed = 1;
    bool png = false;
};

/// The library's weights of a point, or an error.
Expected<std::vector<double>> weights_of(const std::string& type, const CageFile& cage, const Point2& p) {
    CoordinatesChoice choice;
    choice.name = type;
    choice.resolution = 256;
    const auto coordinates = make_coordinates<double>(choice, cage);
    const auto [binding, report] =
        coordinates.bind(std::span(&p, 1), {.linear_precision = cageform::LinearPrecision::leave});
    if (report.status != cageform::Status::ok) return FileError{describe_faults(cage.name, report)};
    if (!report.outside.empty() || !report.on_boundary.empty() || !report.unreached.empty())
        return FileError{"the point is not inside " + cage.name};
    std::vector<double> weights;
    for (std::size_t i = 0; i < binding.handle_count(); ++i) weights.push_back(binding.weight(0, i));
    return weights;
}

/// One picture: the cage, the paths from the point, and the point.
class Panel {
public:
    Panel(const cageform::Bounds<double, 2>& bounds, double left, const std::string& title)
        : bounds_(bounds)
        , scale_(width / std::max(bounds.upper[0] - bounds.lower[0], bounds.upper[1] - bounds.lower[1]))
        , left_(left + (width - scale_ * (bounds.upper[0] - bounds.lower[0])) / 2) {
        text_ = "<text x=\"" + number(left + width / 2) +
                "\" y=\"30\" text-anchor=\"middle\" font-size=\"20\">" + title + "</text>\n";
    }
    void line(std::span<const Point2> points, const std::string& style) {
        text_ += "<polyline fill=\"none\" " + style + " points=\"";
        for (const Point2& p : points) text_ += place(p) + " ";
        text_ += "\"/>\n";
    }
    void dot(const Point2& p, double radius, const std::string& colour) {
        const std::string at = place(p);
        const std::size_t comma = at.find(',');
        text_ += "<circle cx=\"" + at.substr(0, comma) + "\" cy=\"" + at.substr(comma + 1) + "\" r=\"" +
                 number(radius) + "\" fill=\"" + colour + "\"/>\n";
    }
    const std::string& text() const { return text_; }

    static constexpr double width = 460, margin = 20, top = 50;

private:
    static std::string number(double x) { return text_of("%.2f", x); }
    std::string place(const Point2& p) const {
        return number(left_ + scale_ * (p.x - bounds_.lower[0])) + "," +
               number(top + scale_ * (p.y - bounds_.lower[1]));
    }

    cageform::Bounds<double, 2> bounds_;
    double scale_, left_;
    std::string text_;
};

std::string draw(const CageFile& cage, const PathBoundary& boundary, const Point2& p, const Arguments& given,
                 double diagonal) {
    const auto bounds = cageform::bounds_of(cage.polygon<double>().vertices());
    Panel rays(bounds, Panel::margin, "straight rays: mean value");
    Panel walks(bounds, 3 * Panel::margin + Panel::width, "Brownian paths: harmonic");
    for (std::size_t n = 0; n < given.drawn; ++n) {
        const double angle = 2 * std::numbers::pi * (double(n) + 0.5) / double(given.drawn);
        auto crossings = boundary.crossings(p, angle);
        std::sort(crossings.begin(), crossings.end(),
                  [](const auto& a, const auto& b) { return a.distance < b.distance; });
        Point2 from = p;
        for (std::size_t k = 0; k < crossings.size(); ++k) {
            const std::array ends{from, crossings[k].at};
            rays.line(ends, k % 2 == 0 ? "stroke=\"#d97706\" stroke-width=\"1.2\""
                                       : "stroke=\"#bbbbbb\" stroke-dasharray=\"3 3\"");
            from = crossings[k].at;
        }
        for (std::size_t k = 0; k < crossings.size(); ++k)
            rays.dot(crossings[k].at, 3, k % 2 == 0 ? "#d97706" : "#2563eb");
    }
    std::mt19937_64 random(given.seed);
    for (std::size_t n = 0; n < given.drawn; ++n) {
        std::vector<Point2> way;
        const auto end = brownian_end(boundary, p, 1e-3 * diagonal, 0.012 * diagonal, random,
                                      [&](const Point2& q) { way.push_back(q); });
        way.push_back(end.at);
        walks.line(way, "stroke=\"hsl(" + text_of("%.0f", std::fmod(137.5 * double(n), 360)) +
                            ",55%,50%)\" stroke-width=\"0.7\" stroke-linejoin=\"round\"");
        walks.dot(end.at, 3, "#16803c");
    }
    for (Panel* panel : {&rays, &walks}) {
        cage.for_each_edge([&](std::size_t i, std::size_t j) {
            const std::array ends{cage.vertices[i], cage.vertices[j]};
            panel->line(ends, "stroke=\"#111111\" stroke-width=\"2.5\" stroke-linecap=\"round\"");
        });
        panel->dot(p, 6, "#111111");
    }
    const double share =
        std::min((bounds.upper[1] - bounds.lower[1]) / (bounds.upper[0] - bounds.lower[0]), 1.0);
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " +
           text_of("%.0f", 2 * Panel::width + 4 * Panel::margin) + " " +
           text_of("%.0f", Panel::top + Panel::margin + Panel::width * share) +
           "\" font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n" +
           rays.text() + walks.text() + "</svg>\n";
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Draws rays and Brownian paths from a point to the boundary of its cage. Prints the "
                     "coordinates as means over them, and those of the library.");
    line.set_examples({"--cage biped_cage.svg --point 150,600 -o paths.svg --png",
                       "--cage cat_cage.svg --point 500,400 -o paths.svg"});
    Arguments given;
    line.add("--cage", given.cage, "an SVG or CSV file").required();
    line.add("--point", given.point, "x,y: where paths begin, inside the cage").required();
    line.add("-o,--output", given.out, "the SVG file to write").required().ends_with({".svg"});
    line.add_flag("--png", given.png, "also write a PNG file of the same name");
    line.add("--rays", given.rays, "the number of rays in the mean").range(1, 100'000'000).show_default();
    line.add("--paths", given.paths, "the number of Brownian paths").range(2, 100'000'000).show_default();
    line.add("--drawn", given.drawn, "the number of rays and of paths to draw")
        .range(1, 10'000)
        .show_default();
    line.add("--seed", given.seed, "the seed of the random numbers").show_default();
    line.set_footer(cage_formats);
    if (const auto code = line.parse(argc, argv)) return *code;

    std::array<double, 2> place{};
    if (const std::string why = detail::parse_point(given.point, place); !why.empty())
        return fail("--point: " + why);
    const Point2 p{place[0], place[1]};
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) return fail("--point: a coordinate is not finite");
    const auto cage = load_cage(given.cage).value();
    if (cage.has_cells()) return fail(given.cage + ": paths need a cage without chains and points inside");
    const auto mean_value = weights_of("mean-value", cage, p).value(),
               harmonic = weights_of("harmonic", cage, p).value();

    std::vector<std::vector<Point2>> loops;
    for (const CageBlock& block : cage.blocks) loops.push_back(block.points);
    const PathBoundary boundary(loops);
    const double diagonal = cageform::bounds_of(cage.polygon<double>().vertices()).diagonal();
    OutputFiles outputs;
    add_svg(outputs, given.out, draw(cage, boundary, p, given, diagonal), given.png ? 1400 : 0);
    if (const auto error = outputs.commit()) return fail(*error);

    std::mt19937_64 random(given.seed);
    const auto by_rays = weights_by_rays(boundary, p, given.rays);
    const auto by_paths = weights_by_brownian_paths(boundary, p, given.paths, 1e-4 * diagonal, random);
    std::printf("seed %zu\n", given.seed);
    std::printf(
        "vertex  mean value: by %zu rays, of the library   harmonic: by %zu paths ± standard error, of the "
        "library\n",
        given.rays, given.paths);
    for (std::size_t i = 0; i < boundary.vertices(); ++i) {
        std::printf("%6zu  %12.8f %12.8f   %9.5f ± %.5f %9.5f\n", i, by_rays[i], mean_value[i],
                    by_paths.mean[i], by_paths.error[i], harmonic[i]);
    }
    return 0;
}

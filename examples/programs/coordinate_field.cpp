// Draws one coordinate over its cage: values inside with contour lines, boundary values on the cage. Or draws
// the interpolation of given values at the vertices, linear on edges: with harmonic coordinates the solution
// of Laplace's equation.
//
//     coordinate_field --cage CAGE.svg --vertex 8 --coordinates harmonic -o field.png
//     coordinate_field --cage RECTANGLE.csv --values 1,2,3,2 --coordinates harmonic -o field.png --surface
//     surface.png

#include "averaging/averaged_coordinates.hpp"
#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/progress_bar.hpp"
#include "files/bind_report.hpp"
#include "files/cage_file.hpp"
#include "io/messages.hpp"
#include "pictures/field_plot.hpp"

#include <iostream>
#include <limits>

namespace {

using namespace cageform_support;
namespace averaging = cageform_sources::averaging;
using cageform_sources::averaged_coordinates;

struct Arguments {
    std::string cage, figure, field, out, zoom, classes; // field: the text of --values
    std::size_t vertex = 0;
    std::vector<double> values; // at every vertex: 1 at `vertex`, or those of --values
    bool is_coordinate = true;
    bool y_up = false;
    bool is_lattice = false;
    bool is_averaged = false; // harmonic: by the papers' solver
    FieldStyle style;
    SurfaceView view;
    CoordinatesChoice choice;

    std::string name() const {
        return (is_lattice ? "lattice" : choice.name) +
               (is_coordinate ? " coordinate of vertex " + std::to_string(vertex)
                              : " interpolation of values");
    }
    /// Whether coordinates interpolate at vertices and are linear on edges.
    bool interpolates() const { return !choice.takes_normals() && !is_lattice; }
    /// The value on the edge from vertex i to vertex j, at a fraction of its length.
    double on_edge(std::size_t i, std::size_t j, double t) const {
        return (1 - t) * values[i] + t * values[j];
    }
};

/// Parses "v0,v1,…", one number per vertex.
std::vector<double> parse_values(const std::string& text, const CageFile& cage) {
    std::vector<double> values;
    std::string_view rest = text;
    for (bool more = true; more;) {
        const std::size_t end = std::min(rest.find(','), rest.size());
        const std::string why =
            detail::parse_number(detail::trim(rest.substr(0, end)), values.emplace_back());
        if (!why.empty()) throw Failure("--values: " + why);
        if (!std::isfinite(values.back())) throw Failure("--values: a value is not finite");
        more = end < rest.size();
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    if (values.size() != cage.vertices.size()) {
        throw Failure("--values: " + std::to_string(values.size()) + " values, but " + cage.name + " has " +
                      std::to_string(cage.vertices.size()) + " vertices");
    }
    return values;
}

/// The field, ready to be sampled.
class CoordinateField {
public:
    CoordinateField(const Arguments& given, const CageFile& cage)
        : coordinates_(given.is_averaged && given.choice.name == "harmonic"
                           ? averaged_coordinates(given.choice, cage)
                           : make_coordinates<double>(given.choice, cage)) {
        for (std::size_t i = 0; i < given.values.size(); ++i) {
            if (given.values[i] != 0) terms_.emplace_back(i, given.values[i]);
        }
    }

    void solve(const std::string& cage_path) {
        if (coordinates_.cage_report().status != cageform::Status::ok)
            throw Failure(describe_faults(cage_path, coordinates_.cage_report()));
        ProgressBar bar("coordinate field");
        const auto evaluation = coordinates_.solve({.progress = bar.callback()});
        if (evaluation.status != cageform::Status::ok) throw Failure(cageform::to_string(evaluation.status));
    }

    /// Returns the values at points, NaN outside. Points are bound in batches to bound the memory.
    std::vector<double> at(std::span<const Point2> points, const std::string& cage_path,
                           cageform::OutsidePoints outside = cageform::OutsidePoints::keep_in_place) const {
        constexpr std::size_t most = 16384;
        std::vector<double> values(points.size());
        for (std::size_t first = 0; first < points.size(); first += most) {
            const auto part = points.subspan(first, std::min(most, points.size() - first));
            const auto [binding, bound] = coordinates_.bind(
                part, {.outside = outside, .linear_precision = cageform::LinearPrecision::leave});
            if (bound.status != cageform::Status::ok) throw Failure(describe_faults(cage_path, bound));
            for (std::size_t i = 0; i < part.size(); ++i) {
                for (const auto& [vertex, value] : terms_)
                    values[first + i] += value * binding.weight(i, vertex);
            }
            for (const auto* list : {&bound.outside, &bound.unreached}) {
                if (list == &bound.outside && outside == cageform::OutsidePoints::nearest_boundary) continue;
                for (const std::size_t i : *list)
                    values[first + i] = std::numeric_limits<double>::quiet_NaN();
            }
        }
        return values;
    }

private:
    std::vector<std::pair<std::size_t, double>> terms_; // vertices with non-zero values
    ChosenCoordinates<double, 2> coordinates_;
};

/// The loops of a cage as polygons; curves are subdivided below visibility.
std::vector<std::vector<Point2>> loops_of(const CageFile& cage) {
    PlaneBox box;
    for (const Point2& p : cage.vertices) box.add(p);
    return cage.loops(1e-4 * box.extent(), 8);
}

/// Boundary edges within a box, with their values. For coordinates that do not interpolate, the values are
/// limits from inside, sampled along each edge.
std::vector<PlaneLine> boundary_of(const Arguments& given, const CageFile& cage, const CoordinateField& field,
                                   const PlaneBox& box) {
    std::vector<PlaneLine> lines;
    const std::size_t pieces = given.interpolates() ? 1 : cage.curves ? 4 : 32;
    const auto add = [&](const Point2& a, const Point2& b, const auto& value) {
        const auto part = clip_segment(a, b, box);
        if (!part) return;
        for (std::size_t n = 0; n < pieces; ++n) {
            PlaneLine& line = lines.emplace_back();
            for (const std::size_t end : {n, n + 1}) {
                const double s = double(end) / double(pieces), t = (1 - s) * (*part)[0] + s * (*part)[1];
                line.points.push_back({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
                line.values.push_back(value(t));
            }
        }
    };
    if (cage.curves) {
        for (const auto& loop : loops_of(cage)) {
            for (std::size_t k = 0; k < loop.size(); ++k)
                add(loop[k], loop[(k + 1) % loop.size()], [](double) { return 0.0; }); // sampled below
        }
    } else {
        cage.for_each_edge([&](std::size_t i, std::size_t j) {
            add(cage.vertices[i], cage.vertices[j], [&](double t) { return given.on_edge(i, j, t); });
        });
    }
    if (pieces == 1) return lines;
    std::vector<Point2> points;
    for (const PlaneLine& line : lines) points.insert(points.end(), line.points.begin(), line.points.end());
    const auto values = field.at(points, given.cage, cageform::OutsidePoints::nearest_boundary);
    for (std::size_t n = 0; n < lines.size(); ++n) lines[n].values = {values[2 * n], values[2 * n + 1]};
    return lines;
}

/// Draws the field over a box, with 2 × 2 supersampling, and the boundary values on top.
Picture draw_map(const Arguments& given, const CageFile& cage, const CoordinateField& field,
                 const PlaneBox& box) {
    const double scale = 2 * double(given.style.size) / box.extent();
    const std::size_t width = 2 * std::size_t(std::ceil(box.width() * scale / 2));
    const std::size_t height = 2 * std::size_t(std::ceil(box.height() * scale / 2));
    const auto row = [&](double y) { return given.y_up ? double(height) - y : y; };
    const auto to_picture = [&](const Point2& p) {
        return Point2{(p.x - box.low.x) * scale, row((p.y - box.low.y) * scale)};
    };
    std::vector<Point2> points;
    points.reserve(width * height);
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x)
            points.push_back(
                {(double(x) + 0.5) / scale + box.low.x, row(double(y) + 0.5) / scale + box.low.y});
    }
    const auto values = field.at(points, given.cage);
    const auto [least, largest] = least_and_largest(values);
    std::cout << given.name() << ": " << least << " to " << largest << '\n';

    Picture fine = draw_field(values, width, given.style);
    for (const PlaneLine& line : boundary_of(given, cage, field, box)) {
        const int pieces = given.interpolates() ? 64 : 2;
        const auto at = [&](double t) {
            const Point2 &a = line.points[0], &b = line.points[1];
            return to_picture({a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)});
        };
        for (int k = 0; k < pieces; ++k) {
            const double t = double(k) / pieces;
            const double value = line.values[0] + t * (line.values[1] - line.values[0]);
            fine.line(at(t), at(t + 1.0 / pieces), 14, boundary_hue(given.style.share(value)));
        }
    }
    if (given.is_coordinate) {
        const Point2 at = to_picture(cage.vertices[given.vertex]);
        fine.line(at, at, 36, {0.1f, 0.1f, 0.1f});
        const double value = given.interpolates()
                                 ? 1
                                 : field.at(std::span(&cage.vertices[given.vertex], 1), given.cage,
                                            cageform::OutsidePoints::nearest_boundary)[0];
        fine.line(at, at, 24, boundary_hue(given.style.share(value)));
    }
    return with_colour_bar(fine.halved(), std::min(least, given.style.zero),
                           std::max(largest, given.style.one), given.style);
}

Picture draw_as_surface(const Arguments& given, const CageFile& cage, const CoordinateField& field,
                        const PlaneBox& box) {
    std::vector<std::vector<Point2>> loops = loops_of(cage);
    if (cage.lattice) { // its box
        const std::size_t last = cage.lattice->points() - 1, along = cage.lattice->axes[0].points - 1;
        auto& box_loop = loops.emplace_back();
        for (const std::size_t i : {std::size_t{0}, along, last, last - along})
            box_loop.push_back(cage.vertices[i]);
    }
    FieldSurface surface;
    surface.mesh = cut_by_lattice(loops, box, std::clamp<std::size_t>(given.style.size / 4, 16, 400));
    surface.values = field.at(surface.mesh.places, given.cage);
    surface.boundary = boundary_of(given, cage, field, box);
    surface.y_up = given.y_up;
    return draw_surface(surface, given.view, given.style);
}

/// Draws the cells of the papers' grid: boundary, inside, outside.
Picture draw_classes(const Arguments& given, const CageFile& cage) {
    const auto polygon = cage.polygon<double>();
    const std::size_t resolution = given.choice.resolution != 0 ? given.choice.resolution : 128;
    const auto domain = averaging::rasterise(
        polygon, averaging::lattice_about(cageform::bounds_of(polygon.vertices()), resolution));
    const auto& [columns, rows] = domain.lattice.cells;
    const double scale =
        2 * double(given.style.size) / double(std::max(columns, rows)); // pixels per cell, supersampled
    Picture fine(2 * std::size_t(std::ceil(double(columns) * scale / 2)),
                 2 * std::size_t(std::ceil(double(rows) * scale / 2)));
    const auto to_picture = [&](const Point2& p) {
        const double y = (p.y - domain.lattice.origin[1]) / domain.lattice.spacing * scale;
        return Point2{(p.x - domain.lattice.origin[0]) / domain.lattice.spacing * scale,
                      given.y_up ? double(fine.height()) - y : y};
    };
    for (std::size_t y = 0; y < fine.height(); ++y) {
        const double from_below = given.y_up ? double(fine.height() - 1 - y) : double(y);
        const std::size_t row = std::min(std::size_t((from_below + 0.5) / scale), rows - 1);
        for (std::size_t x = 0; x < fine.width(); ++x) {
            const std::size_t column = std::min(std::size_t((double(x) + 0.5) / scale), columns - 1);
            using Tag = averaging::CellTag;
            const Tag tag = domain.tags[row * columns + column];
            fine.at(x, y) = tag == Tag::boundary   ? Colour{0.95f, 0.65f, 0.25f}
                            : tag == Tag::interior ? Colour{0.68f, 0.82f, 0.95f}
                                                   : Colour{0.97f, 0.97f, 0.95f};
        }
    }
    constexpr Colour grey{0.8f, 0.8f, 0.8f};
    const double right = double(fine.width()), bottom = double(fine.height());
    for (std::size_t k = 0; k <= columns; ++k)
        fine.line({double(k) * scale, 0}, {double(k) * scale, bottom}, 1, grey);
    for (std::size_t k = 0; k <= rows; ++k)
        fine.line({0, double(k) * scale}, {right, double(k) * scale}, 1, grey);
    cage.for_each_edge([&](std::size_t i, std::size_t j) {
        fine.line(to_picture(cage.vertices[i]), to_picture(cage.vertices[j]), 4, {0.1f, 0.1f, 0.1f});
    });
    return fine.halved();
}

CageFile cage_about(const std::string& figure, const std::string& word, CageEdges edges) {
    if (!CageChoice::of(word).is_auto) return value_or_fail(load_cage(word, edges));
    if (figure.empty()) throw Failure("--cage " + word + " needs a --figure, around which it is made");
    return load_or_make_cage(word, value_or_fail(load_svg(figure)), edges);
}

CommandOption add_options(CommandLine& line, Arguments& given) {
    line.add("--cage", given.cage,
             "an SVG or CSV file" + std::string(auto_cage_help) + " around the --figure")
        .required();
    line.add("--figure", given.figure, "an SVG file, for --cage auto");
    const CommandOption vertex =
        line.add("--vertex", given.vertex, "the vertex whose coordinate is drawn, counted from 0");
    line.add("--values", given.field,
             "v0,v1,...: draw the field of these values at the vertices instead of a coordinate")
        .excludes(vertex);
    line.add("-o,--output", given.out, "the PNG file to write").required().ends_with({".png"});
    given.style.add_options(line);
    line.add("--zoom", given.zoom, "x,y,width,height: draw only this part of the plane, in the cage's units")
        .check(box_fault);
    line.add("--classes", given.classes,
             "a PNG file to draw the papers' grid to, with --resolution cells (128 by default): cells on the "
             "boundary are orange, cells inside are blue")
        .ends_with({".png"});
    line.add_flag("--y-up", given.y_up, "the cage's y axis points up (as in most CSV files)");
    given.view.add_options(line);
    given.choice.in_plane = given.choice.with_normals = true;
    given.choice.add_options(line);
    line.add_text(
            "--solver",
            [&given](const std::string& word) { given.is_averaged = word == "averaging-pyramid"; },
            "harmonic: averaging-pyramid, the solver of the papers on a uniform grid, as a baseline")
        .check([](const std::string& word) {
            return word == "multigrid" || word == "averaging-pyramid"
                       ? std::string()
                       : "\"" + word + "\" is not one of multigrid, averaging-pyramid";
        })
        .show_default("multigrid")
        .rarely_needed();
    return vertex;
}

/// Checks options against the cage, and sets the values at its vertices.
void set_values(Arguments& given, const CageFile& cage) {
    if (!given.classes.empty() && (cage.has_cells() || cage.curves))
        throw Failure("--classes: " + given.cage + ": the papers' grid needs a cage " +
                      (cage.curves ? "of lines" : "without chains and points inside"));
    if (given.is_coordinate != given.field.empty())
        throw Failure("give --vertex or --values to choose what to draw");
    if (given.vertex >= cage.vertices.size()) {
        throw Failure("there is no vertex " + std::to_string(given.vertex) + ": " + given.cage + " has " +
                      std::to_string(cage.vertices.size()));
    }
    given.values.assign(cage.vertices.size(), 0.0);
    given.values[given.vertex] = 1;
    given.style.set_range(0, 1);
    if (given.is_coordinate) return;
    if (given.choice.takes_normals())
        throw Failure("--values: " + given.choice.name + " coordinates do not interpolate at the vertices");
    given.values = parse_values(given.field, cage);
    const auto [least, largest] = least_and_largest(given.values);
    given.style.set_range(least, largest > least ? largest : least + 1);
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Draws one coordinate over its cage, or a field of values at its vertices. Warm colours "
                     "are positive, blue is negative, green is the "
                     "value on the boundary.");
    line.set_examples(
        {"--cage cat_cage.svg --vertex 8 --coordinates harmonic -o field.png",
         "--cage rectangle.csv --values 1,2,3,2 --coordinates harmonic -o field.png --surface surface.png"});
    Arguments given;
    const CommandOption vertex = add_options(line, given);
    line.set_footer(cage_formats + std::string("\n") + lattice_format);
    if (const auto code = line.parse(argc, argv)) return *code;

    const CageFile cage = cage_about(given.figure, given.cage, given.choice.edges());
    given.cage = cage.name;
    given.is_lattice = cage.lattice.has_value();
    given.is_coordinate = vertex.is_given();
    set_values(given, cage);
    PlaneBox around;
    for (const Point2& p : cage.vertices) around.add(p);
    const double margin = 0.04 * around.extent(); // for the cage's outline
    const PlaneBox wide{{around.low.x - margin, around.low.y - margin},
                        {around.high.x + margin, around.high.y + margin}};
    const auto zoomed = parse_box(given.zoom);
    CoordinateField field(given, cage);
    field.solve(given.cage);

    OutputFiles outputs;
    draw_map(given, cage, field, zoomed.value_or(wide)).write_png(outputs.add(given.out));
    if (!given.classes.empty()) draw_classes(given, cage).write_png(outputs.add(given.classes));
    if (!given.view.path.empty())
        draw_as_surface(given, cage, field, zoomed.value_or(around)).write_png(outputs.add(given.view.path));
    return commit(outputs);
}

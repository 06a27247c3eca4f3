// How the solver of harmonic coordinates converges, drawn: the error after each cycle of the multigrid, and the error of
// the weights against the cells of the grid, with corners treated and not, and by the papers' sweeps.
//
//     convergence --cage cat_cage.svg --cage biped_cage.svg -o convergence.svg --png

#include "atomic_file.hpp"
#include "bind_report.hpp"
#include "cage_file.hpp"
#include "command_line.hpp"
#include "coordinates.hpp"
#include "guard.hpp"
#include "plot.hpp"
#include "render.hpp"

#include <cageform/grid/embed.hpp>
#include <cageform/grid/multigrid.hpp>
#include <cageform/grid/simplex_boundary.hpp>

#include <iostream>

extern template class cageform::grid::Multigrid<2>; // compiled in coordinates_2d.cpp

namespace {

using namespace cageform_examples;

int fail(const std::string& message) {
    std::cerr << "convergence: " << message << '\n';
    return 1;
}

struct Curve {
    std::string name, colour, dashes;
    std::vector<std::array<double, 2>> points; // y by its logarithm to the base 10
};

constexpr std::array<const char*, 6> colours{"#1b6ca8", "#c8553d", "#2e8b57",
                                             "#8d5fa8", "#b8860b", "#4a4a4a"};

/// The largest error estimate of all functions after each cycle, at `resolution` cells.
Curve error_by_cycle(const cageform::Polygon<double>& cage, std::size_t resolution) {
    using cageform::grid::Multigrid;
    const auto bounds = cageform::bounds_of(cage.vertices());
    const auto extent = bounds.upper - bounds.lower;
    cageform::Lattice<double, 2> lattice;
    lattice.spacing = std::max(extent[0], extent[1]) / double(resolution);
    lattice.origin = bounds.lower;
    for (std::size_t k = 0; k < 2; ++k)
        lattice.cells[k] = std::size_t(std::ceil(extent[k] / lattice.spacing)) + 1;

    const cageform::grid::SimplexBoundary<2> boundary(cage, lattice);
    const auto problem = cageform::grid::embed(boundary, boundary.crossings());
    const Multigrid<2> multigrid(problem.nodes, problem.cuts, {});
    const auto slot = multigrid.source_slots();

    Curve curve;
    auto block = multigrid.make_block();
    for (std::size_t first = 0; first < cage.size(); first += Multigrid<2>::width) {
        for (auto& row : block.source) row.fill(0.0);
        for (std::size_t c = 0; c < problem.cuts.size(); ++c) {
            const auto& value = problem.values[c];
            for (std::size_t n = 0; n < value.handle.size(); ++n) {
                if (value.handle[n] - first < Multigrid<2>::width)
                    block.source[slot[problem.cuts[c].node]][value.handle[n] - first] +=
                        problem.cuts[c].weight * value.weight[n];
            }
        }
        auto error = multigrid.start(block);
        for (std::size_t cycle = 0; cycle <= 9; ++cycle) {
            if (curve.points.size() == cycle) curve.points.push_back({double(cycle), -300});
            for (const double e : error.estimate)
                curve.points[cycle][1] = std::max(curve.points[cycle][1], std::log10(e));
            error = multigrid.cycle(block);
        }
    }
    return curve;
}

/// Points spread over a cage (a Halton sequence), the same for every grid.
std::vector<Point2> points_in(const cageform::Polygon<double>& cage, std::size_t count) {
    const auto bounds = cageform::bounds_of(cage.vertices());
    const auto radical_inverse = [](std::size_t n, std::size_t base) {
        double x = 0, digit = 1;
        for (; n > 0; n /= base) x += (digit /= double(base)) * double(n % base);
        return x;
    };
    std::vector<Point2> points;
    for (std::size_t n = 1; points.size() < count; ++n) {
        const cageform::Vec<double, 2> p{
            bounds.lower[0] + radical_inverse(n, 2) * (bounds.upper[0] - bounds.lower[0]),
            bounds.lower[1] + radical_inverse(n, 3) * (bounds.upper[1] - bounds.lower[1])};
        if (cageform::locate(cage, p, 0.0) == cageform::PointState::inside) points.push_back({p[0], p[1]});
    }
    return points;
}

constexpr std::size_t finest = 512; // cells shown

cageform::BindResult<double, 2> weights_of(const CageFile& cage, const cageform::HarmonicOptions& options,
                                           std::size_t resolution) {
    return make_coordinates<double>({.name = "harmonic", .resolution = resolution, .harmonic = options}, cage)
        ->bind(points_in(cage.polygon<double>(), 1000));
}

/// The largest difference of weights to those that are `exact` beside.
Curve error_by_cells(const CageFile& cage, const cageform::HarmonicOptions& options,
                     const cageform::Binding<double, 2>& exact) {
    Curve curve;
    for (std::size_t resolution = 32; resolution <= finest; resolution *= 2) {
        const auto coarse = weights_of(cage, options, resolution);
        if (coarse.report.status != cageform::Status::ok) continue; // too coarse for a part of the cage
        double error = 1e-16;
        for (std::size_t i = 0; i < exact.point_count(); ++i) {
            for (std::size_t k = 0; k < exact.handle_count(); ++k)
                error = std::max(error, std::fabs(coarse.binding.weight(i, k) - exact.weight(i, k)));
        }
        curve.points.push_back({std::log2(double(resolution)), std::log10(error)});
    }
    return curve;
}

/// A diagram as a group of SVG elements.
std::string diagram(double left, const std::string& title, const std::string& x_title,
                    const std::vector<Curve>& curves, bool powers_of_two) {
    constexpr double width = 430, height = 330, top = 60;
    double x0 = 1e9, x1 = -1e9, y0 = 0, y1 = -1e9;
    for (const Curve& curve : curves) {
        for (const auto& [x, y] : curve.points) {
            x0 = std::min(x0, x);
            x1 = std::max(x1, x);
            y0 = std::min(y0, std::floor(y));
            y1 = std::max(y1, std::ceil(y));
        }
    }
    const Axis x_axis{x0, x1, left, left + width}, y_axis{y0, y1, top + height, top};
    const auto place = [](double x) { return text_of("%.1f", x); };
    const auto text = [&](double x, double y, const char* anchor, const std::string& words, int size) {
        return "<text x=\"" + place(x) + "\" y=\"" + place(y) + "\" text-anchor=\"" + anchor +
               "\" font-size=\"" + std::to_string(size) + "\">" + words + "</text>\n";
    };
    std::string svg = text(left + width / 2, top - 22, "middle", title, 17);
    const auto grid_line = [&](double xa, double ya, double xb, double yb) {
        svg += "<path d=\"M" + place(xa) + "," + place(ya) + " L" + place(xb) + "," + place(yb) +
               "\" stroke=\"#d8d8d8\"/>\n";
    };
    for (double y = y0; y <= y1; y += 1) grid_line(left, y_axis.at(y), left + width, y_axis.at(y));
    for (const auto& [y, number] : marks_of(y_axis, 9, 1))
        svg += text(left - 8, y_axis.at(y) + 4, "end", "1e" + number, 13);
    for (const auto& [x, number] : marks_of(x_axis, 10, 1)) {
        grid_line(x_axis.at(x), top, x_axis.at(x), top + height);
        svg += text(x_axis.at(x), top + height + 18, "middle",
                    powers_of_two ? number_on_axis(std::exp2(x), 1) : number, 13);
    }
    svg += text(left + width / 2, top + height + 40, "middle", x_title, 14);
    double row = top + height + 64;
    for (const Curve& curve : curves) {
        std::string line;
        for (const auto& [x, y] : curve.points) {
            line += (line.empty() ? "M" : " L") + place(x_axis.at(x)) + "," + place(y_axis.at(y));
            svg += "<circle cx=\"" + place(x_axis.at(x)) + "\" cy=\"" + place(y_axis.at(y)) +
                   "\" r=\"3\" fill=\"" + curve.colour + "\"/>\n";
        }
        const std::string style = "fill=\"none\" stroke=\"" + curve.colour +
                                  "\" stroke-width=\"2\" stroke-dasharray=\"" + curve.dashes + "\"/>\n";
        svg += "<path d=\"" + line + "\" " + style;
        svg += "<path d=\"M" + place(left) + "," + place(row - 4) + " h34\" " + style;
        svg += text(left + 42, row, "start", curve.name, 13);
        row += 19;
    }
    return svg;
}

int run_program(int argc, char** argv) {
    CommandLine line("Draws how the solver of harmonic coordinates converges for some cages.");
    std::vector<std::string> cage_paths;
    std::string out_path;
    bool png = false;
    std::size_t resolution = 512;
    line.add("--cage", cage_paths, "SVG or CSV files, six at most").required().count(1, 6);
    line.add("-o,--output", out_path, "the SVG file to write").required().ends_with({".svg"});
    line.add("--resolution", resolution, "cells of the grid the cycles are shown on")
        .range(16, 4096)
        .show_default();
    line.add_flag("--png", png, "also render it, to the same name with .png");
    line.set_footer(cage_formats);
    if (const auto code = line.parse(argc, argv)) return *code;

    std::vector<Curve> by_cycle, by_cells;
    for (std::size_t n = 0; n < cage_paths.size(); ++n) {
        const auto file = load_cage(cage_paths[n]);
        if (!file) return fail(to_string(file.error()));
        if (file->has_cells()) return fail(cage_paths[n] + ": cages with cells inside are not drawn");
        const auto cage = file->polygon<double>();
        cageform::BindReport report;
        report.cage = cageform::check(cage);
        report.status = report.cage.status;
        if (report.status != cageform::Status::ok) return fail(describe_faults(cage_paths[n], report));
        const std::string name = std::filesystem::path(cage_paths[n]).stem().string();

        auto cycles = error_by_cycle(cage, resolution);
        cycles.name = name;
        cycles.colour = colours[n];
        cycles.dashes = "none";
        std::cout << name << ": error falls by "
                  << text_of("%.3f", std::pow(10.0, (cycles.points[6][1] - cycles.points[1][1]) / 5))
                  << " a cycle\n";
        by_cycle.push_back(std::move(cycles));

        struct Way {
            const char* name;
            const char* dashes;
            cageform::HarmonicOptions options;
        };
        std::array<Way, 3> ways{Way{"", "none", {}}, Way{", corners untreated", "9 5", {}},
                                Way{", the papers' sweeps", "2 4", {}}};
        ways[1].options.multigrid.corner_functions = false;
        ways[2].options.solver = cageform::HarmonicSolver::averaging_pyramid;
        // A grid four times as fine as the finest shown.
        const auto exact = weights_of(*file, {}, 4 * finest);
        if (exact.report.status != cageform::Status::ok)
            return fail(cage_paths[n] + ": " + cageform::to_string(exact.report.status));
        for (const Way& way : ways) {
            auto curve = error_by_cells(*file, way.options, exact.binding);
            curve.name = name + way.name;
            curve.colour = colours[n];
            curve.dashes = way.dashes;
            std::cout << curve.name << ":";
            for (const auto& [cells, error] : curve.points)
                std::cout << "  " << text_of("%.0f", std::exp2(cells)) << " cells "
                          << text_of("%.1e", std::pow(10.0, error));
            std::cout << '\n';
            by_cells.push_back(std::move(curve));
        }
    }
    const double height = 480 + 19 * double(by_cells.size());
    OutputFiles outputs;
    AtomicFile& file = outputs.add(out_path);
    file.write("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 1100 " + text_of("%.0f", height) +
               "\" width=\"1100\" height=\"" + text_of("%.0f", height) +
               "\" font-family=\"DejaVu Sans, sans-serif\">\n<rect width=\"100%\" height=\"100%\" "
               "fill=\"white\"/>\n");
    file.write(diagram(80,
                       "largest error (estimated) after each cycle, " + std::to_string(resolution) + " cells",
                       "cycles of the multigrid", by_cycle, false));
    file.write(diagram(620, "largest error of a weight", "cells along the cage", by_cells, true));
    file.write("</svg>\n");
    if (png) add_png(outputs, file, 1100);
    if (const auto error = outputs.commit()) return fail(*error);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return cageform_examples::guarded("convergence", [&] { return run_program(argc, argv); });
}

// Draws how harmonic coordinates converge. For cages in the plane it shows the error after each cycle of the
// multigrid. It also shows the error of the weights against the cells of the uniform grid: with and without
// corner treatment, and by the papers' sweeps. For oracles (weights known to many digits) it shows the error
// against unknowns and seconds, on the uniform grid and on the adaptive one. With --types it instead prints
// how far the weights of other coordinate types are from those of oracles.
//
//     convergence --cage cat_cage.svg --cage biped_cage.svg -o convergence.svg --png
//     convergence --oracle harmonic2d_cat.json --oracle harmonic3d_l_prism_triangulated.json -o errors.svg
//     convergence --oracle harmonic2d_biped.json --types

#include "averaging/averaged_coordinates.hpp"
#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "files/bind_report.hpp"
#include "files/cage_file.hpp"
#include "io/atomic_file.hpp"
#include "io/input_file.hpp"
#include "io/messages.hpp"
#include "pictures/plot.hpp"
#include "pictures/render.hpp"
#include "svg/xml.hpp"

#include <cageform/grid/lattice/embed.hpp>
#include <cageform/grid/lattice/simplex_boundary.hpp>
#include <cageform/grid/multigrid/multigrid.hpp>

#include <nlohmann/json.hpp>

#include <ctime>
#include <iostream>
#include <sstream>

namespace {

using namespace cageform_support;
using cageform_sources::averaged_coordinates;

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

/// Points distributed over a cage (a Halton sequence), equal for all grids.
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

/// A variant to compute weights, and how its curve is drawn.
struct Variant {
    const char* name = "";
    const char* dashes = "none";
    cageform::HarmonicOptions options{};
    bool is_averaged = false; // by the papers' sweeps
};

cageform::Result<cageform::Binding<double, 2>, cageform::BindReport>
weights_of(const CageFile& cage, const Variant& variant, std::size_t resolution) {
    const CoordinatesChoice choice{.name = "harmonic", .resolution = resolution, .harmonic = variant.options};
    return (variant.is_averaged ? averaged_coordinates(choice, cage) : make_coordinates<double>(choice, cage))
        .bind(points_in(cage.polygon<double>(), 1000));
}

/// The largest difference between weights and `exact` weights.
Curve error_by_cells(const CageFile& cage, const Variant& variant,
                     const cageform::Binding<double, 2>& exact) {
    Curve curve;
    for (std::size_t resolution = 32; resolution <= finest; resolution *= 2) {
        const auto coarse = weights_of(cage, variant, resolution);
        if (!coarse) continue; // too coarse for a part of the cage
        double error = 1e-16;
        for (std::size_t i = 0; i < exact.point_count(); ++i) {
            for (std::size_t k = 0; k < exact.handle_count(); ++k)
                error = std::max(error, std::fabs(coarse.value.weight(i, k) - exact.weight(i, k)));
        }
        curve.points.push_back({std::log2(double(resolution)), std::log10(error)});
    }
    return curve;
}

enum class Steps { ones, doublings, tenfolds }; // of the x axis

/// A diagram as a group of SVG elements.
std::string diagram(double left, double top, const std::string& title, const std::string& x_title,
                    const std::vector<Curve>& curves, Steps steps) {
    constexpr double width = 430, height = 330;
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
                    steps == Steps::ones        ? number
                    : steps == Steps::doublings ? number_on_axis(std::exp2(x), 1)
                                                : "1e" + number,
                    13);
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
        svg += text(left + 42, row, "start", detail::escaped(curve.name), 13);
        row += 19;
    }
    return svg;
}

/// Weights known to many digits.
template <std::size_t D>
struct Oracle {
    std::string name;
    std::conditional_t<D == 2, CageFile, MeshFile> cage;
    std::vector<std::conditional_t<D == 2, Point2, Point3>> points;
    std::vector<std::vector<double>> weights; // [point][handle]
};

/// For --help.
constexpr const char* oracle_format =
    "An oracle is a JSON file with \"cage\", \"points\" and \"coordinates\", which has the\n"
    "weights of all vertices for each point. A cage has \"vertices\" and, in the plane,\n"
    "\"loops\" of their numbers, in space \"faces\". An oracle can also be a text file\n"
    "(.txt) beside its cage.obj with lines x,y,z;vertex:weight;vertex:weight;... for\n"
    "the weights that are not 0.\n";

/// Reads an oracle from JSON. Throws nlohmann's exceptions, and runtime_error if sizes differ.
template <std::size_t D>
Oracle<D> oracle_of(const std::string& name, const nlohmann::json& json) {
    Oracle<D> oracle;
    oracle.name = name;
    const auto places = [](const nlohmann::json& list) {
        std::vector<typename decltype(Oracle<D>::points)::value_type> result;
        for (const auto& p : list) {
            if constexpr (D == 2)
                result.push_back({p.at(0).get<double>(), p.at(1).get<double>()});
            else
                result.push_back({p.at(0).get<double>(), p.at(1).get<double>(), p.at(2).get<double>()});
        }
        return result;
    };
    const auto& cage = json.at("cage");
    const auto vertices = places(cage.at("vertices"));
    if constexpr (D == 2) {
        std::vector<CageBlock> blocks;
        for (const auto& loop : cage.at("loops")) {
            CageBlock& block = blocks.emplace_back();
            for (const auto& i : loop) block.points.push_back(vertices.at(i.get<std::size_t>()));
        }
        oracle.cage = make_cage(name, std::move(blocks));
    } else {
        oracle.cage.name = name;
        oracle.cage.vertices = vertices;
        oracle.cage.triangles = cage.at("faces").get<std::vector<std::array<std::uint32_t, 3>>>();
    }
    oracle.points = places(json.at("points"));
    oracle.weights = json.at("coordinates").get<std::vector<std::vector<double>>>();
    if (oracle.weights.size() != oracle.points.size())
        throw std::runtime_error("points and rows of weights differ in number");
    for (const auto& row : oracle.weights) {
        if (row.size() != vertices.size())
            throw std::runtime_error("vertices and weights of a point differ in number");
    }
    return oracle;
}

/// Reads an oracle from a text file.
Oracle<3> read_oracle(const std::filesystem::path& path, std::string text) {
    auto cage = value_or_fail(load_mesh(path.parent_path() / "cage.obj"));
    const std::string folder = printable(path.parent_path().filename().string()),
                      file = printable(path.stem().string());
    Oracle<3> oracle{file == "reference" ? folder : folder + ", " + file, std::move(cage), {}, {}};
    std::replace_if(text.begin(), text.end(), [](char c) { return c == ',' || c == ';' || c == ':'; }, ' ');
    std::istringstream lines(std::move(text));
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        Point3& p = oracle.points.emplace_back();
        auto& row = oracle.weights.emplace_back(oracle.cage.vertices.size());
        std::size_t vertex = 0;
        double weight = 0;
        words >> p[0] >> p[1] >> p[2];
        while (words >> vertex >> weight && vertex < row.size()) row[vertex] = weight;
        if (!words.eof())
            throw Failure(path.string() + ":" + std::to_string(oracle.points.size()) +
                          ": not a line of an oracle");
    }
    return oracle;
}

struct Measured {
    cageform::Status status = cageform::Status::ok;
    double unknowns = 0, seconds = 0, error = 0;
};

/// A complete bind; the least processor time of several runs.
template <std::size_t D>
Measured measure(const Oracle<D>& oracle, const CoordinatesChoice& choice) {
    Measured measured;
    double spent = 0;
    do {
        const std::clock_t begin = std::clock();
        const auto [binding, report] = make_coordinates<double>(choice, oracle.cage).bind(oracle.points);
        const double seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
        measured.seconds = spent == 0 ? seconds : std::min(measured.seconds, seconds);
        spent += std::max(seconds, 1e-3);
        measured.status = report.status;
        if (measured.status != cageform::Status::ok) return measured;
        measured.unknowns = double(report.solver.cells);
        measured.error = 1e-16;
        for (std::size_t i = 0; i < oracle.points.size(); ++i) {
            for (std::size_t k = 0; k < oracle.weights[i].size(); ++k)
                measured.error =
                    std::max(measured.error, std::fabs(binding.weight(i, k) - oracle.weights[i][k]));
        }
    } while (spent < 0.2);
    return measured;
}

struct Diagrams {
    std::vector<Curve> by_cycle, by_cells, by_unknowns, by_seconds;
};

/// Prints a table, and adds to the diagrams by unknowns and seconds.
template <std::size_t D>
void add_oracle(const Oracle<D>& oracle, const char* colour, Diagrams& diagrams) {
    std::vector<CoordinatesChoice> uniform, adaptive;
    for (std::size_t resolution = D == 2 ? 32 : 16; resolution <= (D == 2 ? 1024u : 128u); resolution *= 2)
        uniform.emplace_back().resolution = resolution;
    for (const double accuracy : {1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5}) {
        if (accuracy >= (D == 2 ? 1e-5 : 5e-4)) adaptive.emplace_back().harmonic.accuracy = accuracy;
    }
    for (auto* variants : {&uniform, &adaptive}) {
        Curve by_unknowns{oracle.name + (variants == &uniform ? ", uniform" : ", adaptive"),
                          colour,
                          variants == &uniform ? "6 4" : "none",
                          {}};
        Curve by_seconds = by_unknowns;
        double seconds = 0;
        for (CoordinatesChoice& choice : *variants) {
            if (seconds > (variants == &uniform && D == 3 ? 0.5 : 2))
                break; // the next takes eight times as long
            choice.name = "harmonic";
            const Measured measured = measure(oracle, choice);
            const std::string asked = choice.resolution != 0
                                          ? std::to_string(choice.resolution) + " cells"
                                          : "accuracy " + text_of("%.0e", choice.harmonic.accuracy);
            std::cout << oracle.name << ", " << asked << ": ";
            if (measured.status != cageform::Status::ok) {
                std::cout << cageform::to_string(measured.status) << '\n';
                continue;
            }
            seconds = measured.seconds;
            std::cout << text_of("%.0f", measured.unknowns) << " unknowns, "
                      << text_of("%.4f", measured.seconds) << " s, error " << text_of("%.1e", measured.error)
                      << '\n';
            by_unknowns.points.push_back({std::log10(measured.unknowns), std::log10(measured.error)});
            by_seconds.points.push_back({std::log10(measured.seconds), std::log10(measured.error)});
        }
        if (by_unknowns.points.empty()) continue;
        diagrams.by_unknowns.push_back(std::move(by_unknowns));
        diagrams.by_seconds.push_back(std::move(by_seconds));
    }
}

/// Prints the mean over points of Σ|w - h|, h the weights of the oracle, for the types that support its cage.
template <std::size_t D>
void print_types(const Oracle<D>& oracle) {
    CoordinatesChoice choice;
    choice.in_plane = D == 2;
    for (const std::string& name : choice.names()) {
        choice.name = name;
        const auto [binding, report] = make_coordinates<double>(choice, oracle.cage).bind(oracle.points);
        if (report.status != cageform::Status::ok) continue;
        double sum = 0;
        for (std::size_t i = 0; i < oracle.points.size(); ++i) {
            for (std::size_t k = 0; k < oracle.weights[i].size(); ++k)
                sum += std::fabs(binding.weight(i, k) - oracle.weights[i][k]);
        }
        std::cout << oracle.name << ", " << name << ": "
                  << text_of("%.3f", sum / double(oracle.points.size())) << " from the oracle\n";
    }
}

/// Calls f with the oracle of a file; returns an error message, or empty.
template <class F>
std::string with_oracle(const std::string& path, F&& f) {
    const auto text = read_file(path);
    if (!text) return to_string(text.error());
    if (path.ends_with(".txt")) {
        f(read_oracle(path, *text));
        return {};
    }
    const std::string name = printable(std::filesystem::path(path).stem().string());
    try {
        const auto json = nlohmann::json::parse(*text);
        if (json.at("cage").contains("faces"))
            f(oracle_of<3>(name, json));
        else
            f(oracle_of<2>(name, json));
    } catch (const std::exception& error) {
        return path + ": " + error.what();
    }
    return {};
}

/// Adds to the diagrams by cycles and cells; returns an error message, or empty.
std::string add_cage(const std::string& path, const char* colour, std::size_t resolution,
                     Diagrams& diagrams) {
    const auto file = load_cage(path);
    if (!file) return to_string(file.error());
    if (file->has_cells()) return path + ": cages with cells inside are not drawn";
    const auto cage = file->polygon<double>();
    const auto report = cageform::check(cage);
    if (report.status != cageform::Status::ok) return describe_faults(path, report);
    const std::string name = printable(std::filesystem::path(path).stem().string());

    auto cycles = error_by_cycle(cage, resolution);
    cycles.name = name;
    cycles.colour = colour;
    cycles.dashes = "none";
    std::cout << name << ": error falls by "
              << text_of("%.3f", std::pow(10.0, (cycles.points[6][1] - cycles.points[1][1]) / 5))
              << " a cycle\n";
    diagrams.by_cycle.push_back(std::move(cycles));

    const std::array variants{
        Variant{}, Variant{", corners untreated", "9 5", {.multigrid = {.corner_functions = false}}},
        Variant{.name = ", the papers' sweeps", .dashes = "2 4", .is_averaged = true}};
    // The reference: a grid four times as fine as the finest in the diagram.
    const auto exact = weights_of(*file, {}, 4 * finest);
    if (!exact) return path + ": " + cageform::to_string(exact.status());
    for (const Variant& variant : variants) {
        auto curve = error_by_cells(*file, variant, exact.value);
        curve.name = name + variant.name;
        curve.colour = colour;
        curve.dashes = variant.dashes;
        std::cout << curve.name << ":";
        for (const auto& [cells, error] : curve.points)
            std::cout << "  " << text_of("%.0f", std::exp2(cells)) << " cells "
                      << text_of("%.1e", std::pow(10.0, error));
        std::cout << '\n';
        diagrams.by_cells.push_back(std::move(curve));
    }
    return {};
}

/// Arranges two diagrams per row.
std::string draw(const Diagrams& diagrams, std::size_t resolution) {
    double top = 60;
    std::string svg;
    if (!diagrams.by_cells.empty()) {
        svg += diagram(80, top,
                       "largest error (estimated) after each cycle, " + std::to_string(resolution) + " cells",
                       "cycles of the multigrid", diagrams.by_cycle, Steps::ones);
        svg += diagram(620, top, "largest error of a weight", "cells along the cage", diagrams.by_cells,
                       Steps::doublings);
        top += 450 + 19 * double(diagrams.by_cells.size());
    }
    if (!diagrams.by_unknowns.empty()) {
        svg += diagram(80, top, "largest error of a known weight", "unknowns of the grid",
                       diagrams.by_unknowns, Steps::tenfolds);
        svg += diagram(620, top, "largest error of a known weight", "seconds of a bind, one thread",
                       diagrams.by_seconds, Steps::tenfolds);
        top += 420 + 19 * double(diagrams.by_unknowns.size());
    }
    const std::string height = text_of("%.0f", top);
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 1100 " + height +
           "\" width=\"1100\" height=\"" + height +
           "\" font-family=\"DejaVu Sans, sans-serif\">\n<rect width=\"100%\" height=\"100%\" "
           "fill=\"white\"/>\n" +
           svg + "</svg>\n";
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line(
        "Draws how harmonic coordinates converge. For cages in the plane: against cycles and cells. For "
        "oracles (known weights): against unknowns and seconds, on the uniform and the adaptive grid.");
    line.set_examples({"--cage cat_cage.svg --cage biped_cage.svg -o convergence.svg --png",
                       "--oracle harmonic2d_cat.json -o errors.svg", "--oracle harmonic2d_cat.json --types"});
    std::vector<std::string> cage_paths, oracle_paths;
    std::string out_path;
    bool png = false, types = false;
    std::size_t resolution = 512;
    line.add("--cage", cage_paths, "SVG or CSV files, six at most").count(1, 6);
    line.add("--oracle", oracle_paths, "files of known weights, six at most").count(1, 6);
    line.add("-o,--output", out_path, "the SVG file to write, required without --types").ends_with({".svg"});
    line.add_flag("--types", types,
                  "draw nothing; print the mean distance of each coordinate type's weights from the oracles");
    line.add("--resolution", resolution, "the number of cells of the grid whose cycles are shown")
        .range(16, 4096)
        .show_default();
    line.add_flag("--png", png, "also render it, to the same name with .png");
    line.set_footer(std::string(cage_formats) + "\n" + oracle_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    if (cage_paths.empty() && oracle_paths.empty()) return fail("--cage or --oracle is required");

    for (const auto* paths : {&cage_paths, &oracle_paths}) {
        for (const std::string& path : *paths) {
            if (const InputFile file(path); !file.error().empty()) return fail(file.error());
        }
    }
    for (std::size_t n = 0; types && n < oracle_paths.size(); ++n)
        fail_if(with_oracle(oracle_paths[n], [](const auto& oracle) { print_types(oracle); }));
    if (types) return 0;
    if (out_path.empty()) return fail("output is required");
    fail_if(fault_of_outputs({out_path, png ? png_of(out_path) : ""}));
    Diagrams diagrams;
    for (std::size_t n = 0; n < cage_paths.size(); ++n) {
        const std::string why = add_cage(cage_paths[n], colours[n], resolution, diagrams);
        fail_if(why);
    }
    for (std::size_t n = 0; n < oracle_paths.size(); ++n) {
        fail_if(with_oracle(oracle_paths[n],
                            [&](const auto& oracle) { add_oracle(oracle, colours[n], diagrams); }));
    }
    OutputFiles outputs;
    add_svg(outputs, out_path, draw(diagrams, resolution), png ? 1100 : 0);
    return commit(outputs);
}

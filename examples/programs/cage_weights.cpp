// Writes the coordinates of points as CSV, for comparison with other implementations.
//
//     cage_weights --cage cat_cage.svg --points points.csv --coordinates mean-value -o weights.csv
//
// A 2D cage is the first closed polygon of an SVG, or a CSV of blocks of "x,y" lines separated by empty
// lines. The blocks are loops (outer first, then holes) and, for harmonic coordinates, interior cells.
// Interior cells may come at any position, each after a header line:
//
//     # chain          edges between successive points; two points or more
//     # point 12.5     one point; everything within the radius follows it
//
// A point of a chain that is equal to an earlier vertex is that vertex. A 3D cage is an OBJ of a closed mesh.
// Points are lines "x,y" or "x,y,z".
//
// sibson and sibson-c1 use points instead of a cage (site_file.hpp): "x,y" or "x,y,z" lines of a CSV, circles
// of an SVG or vertices of an OBJ.
//
// The output has a header, then one line per point: status,w0,w1,… with 17 digits, "nan" if a point has no
// weights. The first columns are the vertices of the loops (or of the OBJ) in the order of the file. The new
// vertices of chains and points follow; for green, the edges (or faces) are last. --labels names the columns
// of vertices.
// Points are read, bound and written in batches, so files may have any length.

#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/progress_bar.hpp"
#include "files/bind_report.hpp"
#include "files/cage_file.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <array>
#include <bit>
#include <charconv>
#include <functional>
#include <iostream>
#include <set>

namespace {

using namespace cageform_support;

struct Settings {
    std::string cage_path, points_path, labels_path, out_path, scalar = "double", outside = "extend",
                                                               linear_precision = "restore";
    double falloff = 0;
    bool report = false, is_strict = false;
    CoordinatesChoice choice;
};

/// "status" and a column name per handle: its label or its index; edges and faces have no labels. Fails if
/// two columns have the same name.
Expected<std::string> header_line(const std::string& labels_path, std::size_t handles, std::size_t vertices) {
    std::vector<std::string> labels;
    if (!labels_path.empty()) {
        auto read = read_labels(labels_path, vertices);
        if (!read) return read.error();
        labels = std::move(*read);
    }
    labels.resize(handles);
    std::string text = "status";
    std::set<std::string> names{text};
    for (std::size_t h = 0; h < handles; ++h) {
        const std::string name = labels[h].empty() ? "w" + std::to_string(h) : labels[h];
        if (!names.insert(name).second)
            return FileError{labels_path + ": two columns would have the name " + detail::quoted(name)};
        text += ',';
        if (name.find_first_of(",\"") == std::string::npos) {
            text += name;
            continue;
        }
        text += '"'; // RFC 4180
        for (const char c : name) text += c == '"' ? "\"\"" : std::string(1, c);
        text += '"';
    }
    return text + '\n';
}

/// Describes the faults of the cage or the sites.
using Describe = std::function<std::string(const cageform::BindReport&)>;

/// Binds and writes.
///
///   origin   of the positions of the coordinates
template <class T, std::size_t D>
int run(const Settings& settings, ChosenCoordinates<T, D> coordinates, const Describe& describe_faults,
        const cageform::Vec<double, D>& origin = {}) {
    PointReader<D, T> reader(settings.points_path, settings.is_strict);
    if (!reader.error().empty()) return fail(reader.error());
    const auto refuse = [&](const cageform::BindReport& report) { return fail(describe_faults(report)); };
    cageform::BindReport total;
    total.cage = coordinates.cage_report();
    total.status = total.cage.status;
    if (total.status != cageform::Status::ok) return refuse(total);
    const std::size_t handles = coordinates.handles().count;
    std::string text =
        header_line(settings.labels_path, handles, handles - coordinates.handles().vector_count()).value();
    AtomicFile out(settings.out_path);
    if (const auto error = out.error()) return fail(*error);

    cageform::BindOptions options;
    const bool is_extended = settings.outside == "extend" && coordinates.has_extension();
    options.outside =
        is_extended ? cageform::OutsidePoints::extend : cageform::OutsidePoints::nearest_boundary;
    options.falloff = settings.falloff;
    if (options.falloff > 0 && settings.outside == "extend" && !is_extended)
        return fail("--falloff: these coordinates are not defined outside: give --outside nearest-boundary");
    options.linear_precision = settings.linear_precision == "restore" ? cageform::LinearPrecision::restore
                                                                      : cageform::LinearPrecision::leave;
    warn_of_closed_gaps(settings.cage_path, coordinates.cage_report());
    if (!coordinates.note.empty()) note(coordinates.note);
    const std::size_t batch = std::clamp<std::size_t>((std::size_t{1} << 22) / handles, 1024, 65536);
    const bool weights_outside = settings.outside == "nearest-boundary" || is_extended;
    const double tolerance = coordinates.boundary_tolerance();
    const auto bounds = point_bounds(coordinates.handles());
    ProgressBar bar("binding");
    const auto progress = bar.callback();
    std::vector<std::array<double, D>> numbers;
    std::vector<std::conditional_t<D == 2, Point2, Point3>> points;
    std::vector<cageform::PointState> states;
    // A first batch without points checks the cage even if there are no points.
    bool more = true, first = true;
    std::size_t not_finite = 0, first_not_finite = 0;
    while (more) {
        more = reader.read(numbers, batch);
        if (!reader.error().empty()) return fail(reader.error());
        if (first && numbers.size() == batch && !coordinates.closed_form()) { // probably more batches
            const auto evaluation = coordinates.solve({.progress = progress});
            total.status = evaluation.status;
            total.solver = evaluation.solver;
            if (evaluation.status != cageform::Status::ok) return refuse(total);
            total.seconds = evaluation.solver.seconds;
        }
        points.clear();
        for (auto p : numbers) {
            for (std::size_t k = 0; k < D; ++k) p[k] -= origin[k];
            points.push_back(std::bit_cast<std::conditional_t<D == 2, Point2, Point3>>(p));
        }
        auto [binding, report] = coordinates.bind(points, options);
        if (report.status != cageform::Status::ok) return refuse(report);
        const auto is_near = [&](std::size_t i) {
            const auto p = cageform::to_vec<T>(points[i]);
            for (std::size_t k = 0; k < D; ++k) { // distances are slow
                if (!(double(p[k]) >= double(bounds.lower[k]) - tolerance &&
                      double(p[k]) <= double(bounds.upper[k]) + tolerance))
                    return false;
            }
            return coordinates.distance_from_boundary(p) <= tolerance;
        };
        auto& outside = report.outside;
        const auto first_near = std::stable_partition(outside.begin(), outside.end(), std::not_fn(is_near));
        report.on_boundary.insert(report.on_boundary.end(), first_near, outside.end());
        outside.erase(first_near, outside.end());
        std::sort(report.on_boundary.begin(), report.on_boundary.end());
        if (first) {
            total.solver = report.solver;
            warn_of_coarse_grid(settings.cage_path, total.solver);
        }
        first = false;
        if (not_finite == 0 && !report.not_finite.empty())
            first_not_finite = total.points + report.not_finite[0];
        not_finite += report.not_finite.size();
        states.assign(points.size(), cageform::PointState::inside);
        for (const std::size_t i : report.on_boundary) states[i] = cageform::PointState::on_boundary;
        for (const std::size_t i : report.outside) states[i] = cageform::PointState::outside;
        for (const std::size_t i : report.not_finite) states[i] = cageform::PointState::not_finite;
        for (const std::size_t i : report.unreached) states[i] = cageform::PointState::unreached;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto state = states[i];
            const bool known = state == cageform::PointState::inside ||
                               state == cageform::PointState::on_boundary ||
                               (state == cageform::PointState::outside && weights_outside);
            text += to_string(state);
            for (std::size_t h = 0; h < binding.handle_count(); ++h) {
                text += ',';
                if (!known) {
                    text += "nan";
                    continue;
                }
                std::array<char, 32> digits;
                const auto end = std::to_chars(digits.begin(), digits.end(), double(binding.weight(i, h)),
                                               std::chars_format::general, 17);
                text.append(digits.data(), end.ptr);
            }
            text += '\n';
        }
        out.write(text);
        text.clear();
        if (settings.report)
            add_batch(total, report, total.points);
        else
            total.points += report.points;
        if (progress) progress(reader.fraction());
    }
    if (total.points == 0) return fail(settings.points_path + ": holds no points");
    if (not_finite > 0) {
        warn(settings.points_path + ": " + std::to_string(not_finite) + " of " +
             std::to_string(total.points) + " points are not finite, first number " +
             std::to_string(first_not_finite) +
             " counted from 0: their weights are nan; --strict refuses the file");
    }
    if (const auto error = out.commit()) return fail(*error);
    if (settings.report) std::cout << describe(total);
    return 0;
}

/// rounding_fault() of points; empty for double.
template <class T, class Point>
std::string fault_of_place(const Settings& settings, const std::vector<Point>& points) {
    if (sizeof(T) == 8) return {};
    std::vector<Point3> places;
    for (const Point& p : points) {
        if constexpr (std::is_same_v<Point, Point2>)
            places.push_back({p.x, p.y, 0});
        else
            places.push_back(p);
    }
    const std::string why = rounding_fault(settings.cage_path, places);
    return why.empty() ? why : why + ", or use --scalar double";
}

/// Reads sites.
template <class T, std::size_t D>
int run_with_sites(const Settings& settings) {
    const auto sites = load_sites<D>(settings.cage_path).value();
    if (const auto why = single_precision_fault(sites); !why.empty() && sizeof(T) == 4) return fail(why);
    if (const auto why = fault_of_place<T>(settings, sites.points); !why.empty()) return fail(why);
    return run(settings, make_coordinates<T>(settings.choice, sites),
               [&](const auto& report) { return describe_site_faults(sites, report); });
}

/// Reads the cage, or sites.
template <class T>
int run(const Settings& settings) {
    if (settings.choice.takes_sites()) {
        const auto dimension = site_dimension(settings.cage_path).value();
        return dimension == 2 ? run_with_sites<T, 2>(settings) : run_with_sites<T, 3>(settings);
    }
    if (settings.cage_path.starts_with("lattice:"))
        return fail(
            "--cage " + settings.cage_path +
            ": there is no figure that determines its box; make_cage --lattice writes a .lattice.json file");
    const auto dimension = cage_dimension(settings.cage_path).value();
    if (dimension == 3) {
        if (settings.choice.is_planar() && !is_lattice_path(settings.cage_path))
            return fail(settings.cage_path + ": " + settings.choice.name + " takes a cage in the plane");
        auto file = load_mesh_cage(settings.cage_path).value();
        if (const auto fault = single_precision_fault(file); fault && sizeof(T) == 4)
            return fail(to_string(*fault));
        const Point3 origin = sizeof(T) == 4 ? far_origin(file) : Point3{};
        file.vertices = counted_from(origin, file.vertices);
        if (file.lattice) file.lattice->frame.translation = file.lattice->frame.translation - origin;
        return run(
            settings, make_coordinates<T>(settings.choice, file),
            [&](const auto& report) { return describe_mesh_faults(settings.cage_path, report); }, origin);
    }
    const auto file = load_cage(settings.cage_path, settings.choice.edges()).value();
    for (std::size_t i = 0; i < file.vertices.size() && sizeof(T) == 4; ++i) {
        for (const double x : {file.vertices[i].x, file.vertices[i].y}) {
            const std::string why = detail::single_precision_fault(x);
            if (!why.empty() && std::isfinite(x))
                return fail(settings.cage_path + ": vertex " + std::to_string(i) + ": " + why);
        }
    }
    if (const auto why = fault_of_place<T>(settings, file.vertices); !why.empty()) return fail(why);
    return run(settings, make_coordinates<T>(settings.choice, file),
               [&](const auto& report) { return describe_faults(settings.cage_path, report); });
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Writes the cage coordinates of points.");
    line.set_examples(
        {"--cage cat_cage.svg --points points.csv -o weights.csv",
         "--cage character_cage.obj --points places.csv --coordinates harmonic -o weights.csv"});
    Settings settings;
    line.add("--cage", settings.cage_path,
             "the cage: in the plane a CSV or SVG file, in space an OBJ file of a closed mesh; for sibson "
             "and sibson-c1 a file of points; or a .lattice.json file")
        .required();
    line.add("--points", settings.points_path,
             "a CSV file with one line x,y or x,y,z per point; a first row of words is a header")
        .required();
    line.add("--labels", settings.labels_path,
             "a text file with names of the cage's vertices, for the columns");
    line.add("-o,--output", settings.out_path, "the CSV file to write: status,w0,w1,…")
        .required()
        .ends_with({".csv"});
    line.set_footer(cage_formats + std::string("\n") + lattice_format + "\n" + obj_format + "\n" +
                    site_formats +
                    "\nw0, w1, … belong to the vertices of the loops (or of the OBJ), then to the new\n"
                    "vertices of chains and points; for sibson they belong to the points. The order is\n"
                    "that of the file. For green, the columns of the edges (or faces) follow; an edge\n"
                    "has the number of its first vertex. These columns multiply normals of the length of\n"
                    "the edge (in space, of the square root of the face's area). nan means that a point\n"
                    "has no weights.\n"
                    "\n" +
                    labels_format);
    line.add("--scalar", settings.scalar, "float or double").one_of({"float", "double"}).show_default();
    line.add("--outside", settings.outside,
             "treatment of points outside: extend (if the coordinates are defined there), keep-in-place or "
             "nearest-boundary")
        .one_of(outside_words())
        .show_default();
    OutsideChoice::add_falloff(line, settings.falloff);
    line.add(
            "--linear-precision", settings.linear_precision,
            "restore or leave the weights without linear precision, such as those of a solver and those near "
            "interior points")
        .one_of({"restore", "leave"})
        .show_default();
    line.add_flag("--report", settings.report, "print the bind report, which counts points from 0");
    line.add_flag("--strict", settings.is_strict,
                  "refuse a file with a point that is not finite in --scalar");
    settings.choice.in_plane = settings.choice.with_sites = settings.choice.with_normals = true;
    settings.choice.in_space = true;
    settings.choice.add_options(line);
    if (const auto code = line.parse(argc, argv)) return *code;
    if (settings.falloff > 0 && settings.outside == "keep-in-place")
        return fail("--falloff: with --outside keep-in-place no point outside moves");
    return settings.scalar == "float" ? run<float>(settings) : run<double>(settings);
}

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
// A point of a chain that is equal to an earlier vertex is that vertex. A 3D cage is a closed mesh.
// Points are lines "x,y" or "x,y,z" of a CSV, vertices of a mesh, or a numpy array (files/point_file.hpp).
//
// sibson and sibson-c1 use points instead of a cage (site_file.hpp): "x,y" or "x,y,z" lines of a CSV, circles
// of an SVG or vertices of a mesh.
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
#include "files/point_file.hpp"
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
std::string header_line(const std::string& labels_path, std::size_t handles, std::size_t vertices) {
    std::vector<std::string> labels;
    if (!labels_path.empty()) {
        labels = value_or_fail(read_labels(labels_path, vertices));
    }
    labels.resize(handles);
    std::string text = "status";
    std::set<std::string> names{text};
    for (std::size_t h = 0; h < handles; ++h) {
        const std::string name = labels[h].empty() ? "w" + std::to_string(h) : labels[h];
        if (!names.insert(name).second)
            throw Failure(labels_path + ": two columns would have the name " + detail::quoted(name));
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
class WeightWriter {
public:
    using Place = std::conditional_t<D == 2, Point2, Point3>;

    WeightWriter(const Settings& settings, ChosenCoordinates<T, D> coordinates,
                 const Describe& describe_faults, const cageform::Vec<double, D>& origin)
        : settings_(settings)
        , coordinates_(std::move(coordinates))
        , describe_faults_(describe_faults)
        , origin_(origin) {
        if (D == 3 &&
            (is_mesh_path(settings.points_path) || lowercase_extension(settings.points_path) == ".npy"))
            file_.emplace(settings.points_path);
        else
            rows_.emplace(settings.points_path, settings.is_strict);
        fail_if(file_ ? file_->error() : rows_->error());
        total_.cage = coordinates_.cage_report();
        check(total_.cage.status, total_);
        bounds_ = point_bounds(coordinates_.handles());
    }

    int run() {
        const std::size_t handles = coordinates_.handles().count;
        text_ = header_line(settings_.labels_path, handles, handles - coordinates_.handles().vector_count());
        AtomicFile out(settings_.out_path);
        fail_if(out.error());
        set_options();
        print_notes(settings_.cage_path, coordinates_.cage_report(), coordinates_.note);
        const std::size_t batch = std::clamp<std::size_t>((std::size_t{1} << 22) / handles, 1024, 65536);
        ProgressBar bar("binding");
        const auto progress = bar.callback();
        std::vector<std::array<double, D>> numbers;
        // A first batch without points checks the cage even if there are no points.
        for (bool more = true, first = true; more; first = false) {
            more = read(numbers, batch);
            if (first && numbers.size() == batch && !coordinates_.closed_form()) { // probably more batches
                const auto evaluation = coordinates_.solve({.progress = progress});
                total_.solver = evaluation.solver;
                check(evaluation.status, total_);
                total_.seconds = evaluation.solver.seconds;
            }
            add(numbers, first);
            out.write(text_);
            text_.clear();
            if (progress && rows_) progress(rows_->fraction());
        }
        if (total_.points == 0) return fail(settings_.points_path + ": holds no points");
        if (not_finite_ > 0) {
            warn(settings_.points_path + ": " + std::to_string(not_finite_) + " of " +
                 std::to_string(total_.points) + " points are not finite, first number " +
                 std::to_string(first_not_finite_) +
                 " counted from 0: their weights are nan; --strict refuses the file");
        }
        fail_if(out.commit());
        if (settings_.report) std::cout << describe(total_);
        return 0;
    }

private:
    /// Reads up to `most` points; false at the end.
    bool read(std::vector<std::array<double, D>>& points, std::size_t most) {
        if (rows_) {
            const bool more = rows_->read(points, most);
            fail_if(rows_->error());
            return more;
        }
        std::vector<double> numbers;
        points.resize(file_->read(most, numbers));
        fail_if(file_->error());
        for (std::size_t n = 0; n < D * points.size(); ++n) {
            if (settings_.is_strict && !std::isfinite(T(numbers[n])))
                throw Failure(settings_.points_path + ": point " + std::to_string(total_.points + n / D) +
                              " is not finite");
            points[n / D][n % D] = numbers[n];
        }
        return !points.empty();
    }

    /// Fails with the report unless the status is ok.
    void check(cageform::Status status, cageform::BindReport& report) const {
        report.status = status;
        if (status != cageform::Status::ok) throw Failure(describe_faults_(report));
    }

    void set_options() {
        const bool is_extended = settings_.outside == "extend" && coordinates_.has_extension();
        weights_outside_ = settings_.outside == "nearest-boundary" || is_extended;
        options_.outside =
            is_extended ? cageform::OutsidePoints::extend : cageform::OutsidePoints::nearest_boundary;
        options_.falloff = settings_.falloff;
        if (options_.falloff > 0 && settings_.outside == "extend" && !is_extended)
            throw Failure(
                "--falloff: these coordinates are not defined outside: give --outside nearest-boundary");
        options_.linear_precision = settings_.linear_precision == "restore"
                                        ? cageform::LinearPrecision::restore
                                        : cageform::LinearPrecision::leave;
    }

    /// Binds a batch, and appends its rows.
    void add(const std::vector<std::array<double, D>>& numbers, bool is_first) {
        points_.clear();
        for (auto p : numbers) {
            for (std::size_t k = 0; k < D; ++k) p[k] -= origin_[k];
            points_.push_back(std::bit_cast<Place>(p));
        }
        auto [binding, report] = coordinates_.bind(points_, options_);
        check(report.status, report);
        move_to_boundary(report);
        if (is_first) {
            total_.solver = report.solver;
            warn_of_coarse_grid(settings_.cage_path, total_.solver);
        }
        if (not_finite_ == 0 && !report.not_finite.empty())
            first_not_finite_ = total_.points + report.not_finite[0];
        not_finite_ += report.not_finite.size();
        append_rows(binding, report);
        if (settings_.report)
            add_batch(total_, report, total_.points);
        else
            total_.points += report.points;
    }

    /// Counts points just outside, within the tolerance, as points on the boundary.
    void move_to_boundary(cageform::BindReport& report) const {
        const double tolerance = coordinates_.boundary_tolerance();
        const auto is_near = [&](std::size_t i) {
            const auto p = cageform::to_vec<T>(points_[i]);
            for (std::size_t k = 0; k < D; ++k) { // distances are slow
                if (!(double(p[k]) >= double(bounds_.lower[k]) - tolerance &&
                      double(p[k]) <= double(bounds_.upper[k]) + tolerance))
                    return false;
            }
            return coordinates_.distance_from_boundary(p) <= tolerance;
        };
        auto& outside = report.outside;
        const auto first_near = std::stable_partition(outside.begin(), outside.end(), std::not_fn(is_near));
        report.on_boundary.insert(report.on_boundary.end(), first_near, outside.end());
        outside.erase(first_near, outside.end());
        std::sort(report.on_boundary.begin(), report.on_boundary.end());
    }

    void append_rows(const cageform::Binding<T, D>& binding, const cageform::BindReport& report) {
        using State = cageform::PointState;
        states_.assign(points_.size(), State::inside);
        for (const std::size_t i : report.on_boundary) states_[i] = State::on_boundary;
        for (const std::size_t i : report.outside) states_[i] = State::outside;
        for (const std::size_t i : report.not_finite) states_[i] = State::not_finite;
        for (const std::size_t i : report.unreached) states_[i] = State::unreached;
        for (std::size_t i = 0; i < points_.size(); ++i) {
            const State state = states_[i];
            const bool known = state == State::inside || state == State::on_boundary ||
                               (state == State::outside && weights_outside_);
            text_ += to_string(state);
            for (std::size_t h = 0; h < binding.handle_count(); ++h) {
                text_ += ',';
                if (!known) {
                    text_ += "nan";
                    continue;
                }
                std::array<char, 32> digits;
                const auto end = std::to_chars(digits.begin(), digits.end(), double(binding.weight(i, h)),
                                               std::chars_format::general, 17);
                text_.append(digits.data(), end.ptr);
            }
            text_ += '\n';
        }
    }

    const Settings& settings_;
    const ChosenCoordinates<T, D> coordinates_;
    const Describe& describe_faults_;
    const cageform::Vec<double, D> origin_;
    std::optional<PointReader<D, T>> rows_; // one of these two is set
    std::optional<PointFile> file_;
    cageform::Bounds<T, D> bounds_; // of the handles
    cageform::BindOptions options_;
    bool weights_outside_ = false;
    cageform::BindReport total_;
    std::size_t not_finite_ = 0, first_not_finite_ = 0;
    std::vector<Place> points_; // of the batch
    std::vector<cageform::PointState> states_;
    std::string text_; // to write
};

template <class T, std::size_t D>
int run(const Settings& settings, ChosenCoordinates<T, D> coordinates, const Describe& describe_faults,
        const cageform::Vec<double, D>& origin = {}) {
    return WeightWriter<T, D>(settings, std::move(coordinates), describe_faults, origin).run();
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
    const auto sites = value_or_fail(load_sites<D>(settings.cage_path));
    if (const auto why = single_precision_fault(sites); !why.empty() && sizeof(T) == 4) return fail(why);
    fail_if(fault_of_place<T>(settings, sites.points));
    return run(settings, make_coordinates<T>(settings.choice, sites),
               [&](const auto& report) { return describe_site_faults(sites, report); });
}

/// Reads the cage, or sites.
template <class T>
int run(const Settings& settings) {
    if (settings.choice.takes_sites()) {
        const auto dimension = value_or_fail(site_dimension(settings.cage_path));
        return dimension == 2 ? run_with_sites<T, 2>(settings) : run_with_sites<T, 3>(settings);
    }
    if (settings.cage_path.starts_with("lattice:"))
        return fail(
            "--cage " + settings.cage_path +
            ": there is no figure that determines its box; make_cage --lattice writes a .lattice.json file");
    const auto dimension = cage_dimension(settings.cage_path);
    if (dimension == 3) {
        if (settings.choice.is_planar() && !is_lattice_path(settings.cage_path))
            return fail(settings.cage_path + ": " + settings.choice.name + " takes a cage in the plane");
        auto file = value_or_fail(load_mesh_cage(settings.cage_path));
        if (const auto fault = single_precision_fault(file); fault && sizeof(T) == 4)
            return fail(to_string(*fault));
        const Point3 origin = sizeof(T) == 4 ? far_origin(file) : Point3{};
        file.vertices = relative_to(origin, file.vertices);
        if (file.lattice) file.lattice->frame.translation = file.lattice->frame.translation - origin;
        return run(
            settings, make_coordinates<T>(settings.choice, file),
            [&](const auto& report) { return describe_mesh_faults(settings.cage_path, report); }, origin);
    }
    const auto file = value_or_fail(load_cage(settings.cage_path, settings.choice.edges()));
    for (std::size_t i = 0; i < file.vertices.size() && sizeof(T) == 4; ++i) {
        for (const double x : {file.vertices[i].x, file.vertices[i].y}) {
            const std::string why = detail::single_precision_fault(x);
            if (!why.empty() && std::isfinite(x))
                return fail(settings.cage_path + ": vertex " + std::to_string(i) + ": " + why);
        }
    }
    fail_if(fault_of_place<T>(settings, file.vertices));
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
             "the cage: in the plane a CSV or SVG file, in space a closed mesh; for sibson "
             "and sibson-c1 a file of points; or a .lattice.json file")
        .required();
    line.add("--points", settings.points_path,
             "a CSV file with one line x,y or x,y,z per point; a first row of words is a header. In space "
             "also the vertices of a mesh, or an array of numpy")
        .required();
    line.add("--labels", settings.labels_path,
             "a text file with names of the cage's vertices, for the columns");
    line.add("-o,--output", settings.out_path, "the CSV file to write: status,w0,w1,…")
        .required()
        .ends_with({".csv"});
    line.set_footer(cage_formats + std::string("\n") + lattice_format + "\n" + mesh_formats + "\n" +
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

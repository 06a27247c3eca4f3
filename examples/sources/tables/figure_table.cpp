// Binds figures to their cages and prints a table of time, accuracy and quality by coordinate type.
//
//     figure_table FIGURE CAGE POSE TYPE[,TYPE…] …
//     figure_table --grid 80 biped.svg biped_cage.svg biped_pose.svg all
//
// Columns:
//
//     us/point      microseconds to bind a point, with the solve of harmonic coordinates; the median of five
//                   binds that take less than a second
//     clone us      microseconds of a clone of all points; median
//     max |Swc - p| the largest error of linear precision, before it is restored
//     least weight  the smallest weight of a vertex, an edge or a face
//     > 1 %         the mean number of weights per point above 0.01
//     to harmonic   the mean over points of Σ|w - h|, h the harmonic weights
//     least det     the smallest determinant of the Jacobian in the pose; negative where the pose folds
//     95 % ratio    the ratio of the largest and the smallest stretch that 95 % of the points do not exceed

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/mesh_cage.hpp"
#include "files/bind_report.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <cageform/clone/clone.hpp>
#include <cageform/clone/jacobians.hpp>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <sstream>

namespace {

using namespace cageform_support;

/// Median seconds of a call, over `repeats` samples of `calls` calls each.
template <class F>
double median_seconds(int repeats, int calls, F&& f) {
    std::vector<double> samples;
    for (int r = 0; r < repeats; ++r) {
        const auto start = std::chrono::steady_clock::now();
        for (int c = 0; c < calls; ++c) f();
        samples.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() /
                          calls);
    }
    std::nth_element(samples.begin(), samples.begin() + repeats / 2, samples.end());
    return samples[std::size_t(repeats / 2)];
}

/// The files of a row, and what is measured.
struct Row {
    std::string figure, cage, pose;
    std::size_t grid = 0; ///< cells of the grid of points; 0: the points of the figure
    double locality = 0;  ///< of a row of local harmonic coordinates after that of harmonic ones; 0: no row
};

template <std::size_t D>
using File = std::conditional_t<D == 2, CageFile, MeshFile>;
template <std::size_t D>
using Drawing = std::conditional_t<D == 2, SvgDocument, MeshFile>;
template <std::size_t D>
using Place = std::conditional_t<D == 2, Point2, Point3>;

Drawing<2> load_figure(const std::string& path, Place<2>) {
    return value_or_fail(load_svg(path));
}
Drawing<3> load_figure(const std::string& path, Place<3>) {
    return load_mesh_figure(path, false);
}
std::vector<Point2> points_of(const SvgDocument& figure) {
    return value_or_fail(figure_vertices(figure));
}
std::vector<Point3> points_of(const MeshFile& figure) {
    return figure.vertices;
}
CageFile load_control(const Row& row, const SvgDocument& figure, const CoordinatesChoice& choice) {
    return load_or_make_cage(row.cage, figure, choice.edges());
}
MeshFile load_control(const Row& row, const MeshFile& figure, const CoordinatesChoice&) {
    return load_or_make_cage(row.cage, figure);
}
CageFile pose_of(const Row& row, const CageFile& cage) {
    return row.pose == row.cage ? cage : value_or_fail(load_pose(row.pose, cage));
}
MeshFile pose_of(const Row& row, const MeshFile& cage) {
    return row.pose == row.cage ? cage : value_or_fail(load_mesh_pose(row.pose, cage));
}

/// A coordinate type and its options.
struct Type {
    std::string label;
    CoordinatesChoice choice;
    bool is_wanted = true; ///< by its name, so that a cage that it does not support is an error
};

/// The measurements of a figure in a cage.
template <std::size_t D>
class Table {
public:
    explicit Table(Row row)
        : row_(std::move(row))
        , figure_(load_figure(row_.figure, Place<D>{}))
        , points_(row_.grid == 0 ? points_of(figure_) : grid_points()) {}

    /// Prints the row of a type.
    void print(const Type& type) {
        if (!type.is_wanted && !has_edges(type.choice.edges())) return;
        const auto cage = load_control(row_, figure_, type.choice);
        const auto coordinates = make(type.choice, cage);
        const auto bound = coordinates.bind(points_);
        const auto& [binding, report] = std::tie(bound.value, bound.report);
        if (report.status != cageform::Status::ok) {
            if (type.is_wanted) throw Failure(describe_faults(row_.cage, report));
            return;
        }
        if (!report.outside.empty())
            throw Failure(row_.figure + ": " + std::to_string(report.outside.size()) +
                          " points lie outside the cage " + row_.cage);
        const auto pose = pose_of(row_, cage);
        std::string warning;
        const auto handles = value_or_fail(pose_of_handles(binding, pose.vertices, row_.pose, warning));
        const auto at_rest = value_or_fail(pose_of_handles(binding, cage.vertices, row_.cage, warning));
        warn(warning);
        const int binds = report.seconds < 1 ? 5 : 1;
        const double bind_seconds = median_seconds(binds, 1, [&] { (void)coordinates.bind(points_); });
        std::vector<Place<D>> out(points_.size());
        cageform::Status status = cageform::Status::ok;
        const double clone_seconds = median_seconds(21, points_.size() > 1000 ? 1 : 100, [&] {
            status = cageform::clone(bound.value, handles, out);
        });
        if (status != cageform::Status::ok) throw Failure(cageform::to_string(status));
        if (cageform::clone(binding, at_rest, out) != cageform::Status::ok || !(out == points_))
            throw Failure(row_.figure + ": the rest pose is not exact");
        std::printf("%-9s %-17s %6zu %7zu %8.2f %8.1f %13.1e %12.4f %6.1f",
                    printable(std::filesystem::path(row_.figure).stem().string()).c_str(), type.label.c_str(),
                    binding.point_count(), binding.handle_count(),
                    bind_seconds * 1e6 / double(points_.size()), clone_seconds * 1e6,
                    report.reproduction_error.value,
                    std::round(1e4 * report.least_weight.value) / 1e4 + 0.0, // no -0
                    influences(binding));
        print_distance(type.choice.takes_normals() || cage.lattice, binding);
        print_stretch(coordinates, handles);
        std::printf("\n");
    }

private:
    using Binding = cageform::Binding<double, D>;
    using Coordinates = ChosenCoordinates<double, D>;

    static Coordinates make(const CoordinatesChoice& choice, const File<D>& cage) {
        if (choice.takes_sites())
            return make_coordinates<double>(choice, SiteFile<D>{cage.name, cage.vertices, {}});
        return make_coordinates<double>(choice, cage);
    }

    /// Whether the edges of the cage can be read so: cells inside are not supported beside curves.
    bool has_edges(CageEdges edges) const {
        if constexpr (D == 2) {
            if (edges == CageEdges::curves)
                return !load_control(row_, figure_, CoordinatesChoice{}).has_cells();
        }
        return true;
    }

    /// The points of a grid with `grid` cells along the longest side of the cage that are inside.
    std::vector<Place<D>> grid_points() const {
        const CoordinatesChoice mean_value; // is defined for all cages, and reports points outside
        const auto cage = load_control(row_, figure_, mean_value);
        const auto coordinates = make_coordinates<double>(mean_value, cage);
        const auto bounds = point_bounds(coordinates.handles());
        const cageform::Vec<double, D> extent = bounds.upper - bounds.lower;
        const double cell = *std::max_element(std::begin(extent.v), std::end(extent.v)) / double(row_.grid);
        std::array<std::size_t, D> counts;
        std::size_t count = 1;
        for (std::size_t k = 0; k < D; ++k) count *= counts[k] = std::size_t(extent[k] / cell) + 1;
        std::vector<cageform::Vec<double, D>> points(count);
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t k = 0, rest = i; k < D; rest /= counts[k++])
                points[i][k] = bounds.lower[k] + (double(rest % counts[k]) + 0.5) * cell;
        }
        const auto report = coordinates.bind(points).report;
        std::vector<bool> leaves_out(count);
        for (const auto* list : {&report.outside, &report.on_boundary}) {
            for (const std::size_t i : *list) leaves_out[i] = true;
        }
        std::vector<Place<D>> inside;
        for (std::size_t i = 0; i < count; ++i) {
            if (!leaves_out[i]) inside.push_back(std::bit_cast<Place<D>>(points[i]));
        }
        if (inside.empty()) throw Failure("--grid: no point is inside " + row_.cage);
        return inside;
    }

    static double influences(const Binding& binding) {
        std::size_t count = 0;
        for (std::size_t i = 0; i < binding.point_count(); ++i) {
            for (std::size_t k = 0; k < binding.handle_count(); ++k)
                count += std::fabs(binding.weight(i, k)) > 0.01 ? 1 : 0;
        }
        return double(count) / double(binding.point_count());
    }

    /// Prints the distance from harmonic weights, unless the type has other handles.
    void print_distance(bool has_other_handles, const Binding& binding) {
        if (has_other_handles) {
            std::printf(" %11s", "-");
            return;
        }
        if (!harmonic_) {
            CoordinatesChoice choice;
            choice.name = "harmonic";
            auto bound = make_coordinates<double>(choice, load_control(row_, figure_, choice)).bind(points_);
            if (!bound) throw Failure(describe_faults(row_.cage, bound.report));
            harmonic_ = std::move(bound.value);
        }
        double sum = 0;
        for (std::size_t i = 0; i < binding.point_count(); ++i) {
            for (std::size_t k = 0; k < binding.handle_count(); ++k)
                sum += std::fabs(binding.weight(i, k) - harmonic_->weight(i, k));
        }
        std::printf(" %11.3f", sum / double(binding.point_count()));
    }

    void print_stretch(const Coordinates& coordinates, const std::vector<Place<D>>& handles) const {
        const auto axes = coordinates.bind_jacobians(points_);
        std::vector<Eigen::Matrix<double, int(D), int(D)>> jacobians(points_.size());
        const cageform::StridedMatrices<double, D> view(jacobians[0].data(), jacobians.size());
        if (!axes || cageform::clone_jacobians(axes.value, handles, view) != cageform::Status::ok) {
            std::printf(" %9s %10s", "-", "-");
            return;
        }
        double least = std::numeric_limits<double>::max();
        std::vector<double> ratios;
        for (const auto& jacobian : jacobians) {
            least = std::min(least, jacobian.determinant());
            const auto stretches = jacobian.jacobiSvd().singularValues();
            ratios.push_back(stretches[0] / stretches[int(D) - 1]);
        }
        const auto at = ratios.begin() + std::ptrdiff_t(0.95 * double(ratios.size() - 1));
        std::nth_element(ratios.begin(), at, ratios.end());
        std::printf(" %9.2f %10.2f", least, *at);
    }

    Row row_;
    Drawing<D> figure_;
    std::vector<Place<D>> points_;
    std::optional<Binding> harmonic_;
};

/// Reads a list of types; "all" are those that the cage supports.
std::vector<Type> parse_types(const std::string& list, std::size_t dimension, double locality) {
    CoordinatesChoice choice;
    choice.in_plane = dimension == 2;
    choice.with_normals = choice.with_sites = true;
    const std::vector<std::string> names = choice.names();
    std::vector<Type> types;
    const auto add = [&](const std::string& name, bool is_wanted) {
        types.push_back({name, choice, is_wanted});
        types.back().choice.name = name;
        if (name != "harmonic" || locality == 0) return;
        types.push_back(types.back());
        types.back().label = "local harmonic";
        types.back().choice.harmonic.locality = locality;
    };
    std::istringstream words(list);
    for (std::string word; std::getline(words, word, ',');) {
        if (word == "all") {
            for (const std::string& name : names) add(name, false);
        } else if (std::find(names.begin(), names.end(), word) != names.end()) {
            add(word, true);
        } else {
            std::string known = "all";
            for (const std::string& name : names) known += ", " + name;
            throw Failure(detail::quoted(word) + " is not one of " + known);
        }
    }
    return types;
}

template <std::size_t D>
void print_rows(const Row& row, const std::string& types) {
    Table<D> table(row);
    if (CageChoice::of(row.cage).is_lattice || is_lattice_path(row.cage))
        return table.print({"splines", {}, true});
    for (const Type& type : parse_types(types, D, row.locality)) table.print(type);
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Prints how long figures take to bind and clone, how exact their weights are, and how "
                     "good poses are, for several coordinate types.");
    line.set_examples(
        {"cat.svg cat_cage.svg cat_pose.svg mean-value,harmonic",
         "--grid 80 biped.svg biped_cage.svg biped_pose.svg all",
         "cat.svg cat_cage.svg cat_pose.svg harmonic character.obj cage.obj pose.obj mean-value"});
    std::vector<std::string> words;
    Row row;
    line.add("rows", words,
             "FIGURE CAGE POSE TYPE[,TYPE…], repeatedly; a type has the name that other programs give it, "
             "or is all: those that support the cage. A lattice has only its own type. A pose with "
             "the name of its cage is the cage at rest")
        .required();
    line.add("--grid", row.grid,
             "measure at the points inside the cage of a grid with this many cells along its longest side, "
             "not at the points of the figure; 0: at those of the figure")
        .range(0, 2000)
        .show_default();
    line.add("--locality", row.locality,
             "after each row of harmonic coordinates, a row of local ones: the locality, up to 40; 0: no row")
        .range(0.0, cageform::HarmonicOptions::most_locality)
        .show_default();
    line.set_footer(std::string(cage_formats) + "\n" + mesh_formats);
    if (const auto code = line.parse(argc, argv)) return *code;
    if (words.size() % 4 != 0) return fail("arguments are FIGURE CAGE POSE TYPE[,TYPE…], repeatedly");
    std::printf("%-9s %-17s %6s %7s %8s %8s %13s %12s %6s %11s %9s %10s\n", "figure", "type", "points",
                "handles", "us/point", "clone us", "max |Swc - p|", "least weight", "> 1 %", "to harmonic",
                "least det", "95 % ratio");
    for (std::size_t i = 0; i < words.size(); i += 4) {
        row.figure = words[i];
        row.cage = words[i + 1];
        row.pose = words[i + 2];
        if (is_mesh_path(row.figure))
            print_rows<3>(row, words[i + 3]);
        else
            print_rows<2>(row, words[i + 3]);
    }
    return 0;
}

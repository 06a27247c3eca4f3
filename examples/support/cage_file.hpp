#pragma once

// Cages and poses as files, coordinate types as words: what the example programs have in common.

#include "csv.hpp"
#include "svg_document.hpp"

#include <cageform/cageform.hpp>

template <>
struct cageform::PointTraits<cageform_examples::Point2> {
    using P = cageform_examples::Point2;
    using scalar = double;
    static constexpr std::size_t dimension = 2;
    static constexpr double get(const P& p, std::size_t axis) noexcept { return axis == 0 ? p.x : p.y; }
    static constexpr void set(P& p, std::size_t axis, double x) noexcept { (axis == 0 ? p.x : p.y) = x; }
};

namespace cageform_examples {

/// A polygon of one or several loops, as read.
struct CageFile {
    std::string name;
    std::vector<Point2> vertices;
    std::vector<std::size_t> loop_sizes;

    template <class T>
    cageform::Polygon<T> polygon() const {
        return {vertices, loop_sizes};
    }
};

/// Reads a cage or a pose: the first closed polygon of an SVG file, or a CSV file of loops.
inline SvgResult<CageFile> load_cage(const std::string& path) {
    CageFile cage;
    cage.name = path;
    std::vector<std::vector<Point2>> loops;
    if (path.ends_with(".csv")) {
        auto read = read_cage_csv(path);
        if (!read) return read.error();
        loops = std::move(*read);
    } else {
        const auto document = load_svg(path);
        if (!document) return document.error();
        auto read = first_polygon(*document);
        if (!read) return read.error();
        loops = std::move(*read);
    }
    for (const auto& loop : loops) {
        cage.loop_sizes.push_back(loop.size());
        cage.vertices.insert(cage.vertices.end(), loop.begin(), loop.end());
    }
    return cage;
}

/// The same, where the number of vertices has to be that of the cage at rest.
inline SvgResult<CageFile> load_pose(const std::string& path, const CageFile& cage) {
    auto pose = load_cage(path);
    if (pose && pose->loop_sizes != cage.loop_sizes) {
        const auto describe = [](const CageFile& file) {
            std::string text = std::to_string(file.vertices.size()) + " vertices";
            if (file.loop_sizes.size() > 1)
                text += " in " + std::to_string(file.loop_sizes.size()) + " loops";
            return text;
        };
        return SvgError{path + ": the pose has " + describe(*pose) + ", the cage " + cage.name + " " +
                        describe(cage)};
    }
    return pose;
}

/// What the programs' --coordinates, --resolution and --tolerance say.
struct CoordinatesChoice {
    std::string name = "mean-value";
    cageform::HarmonicOptions harmonic;

    static const std::vector<std::string>& names() {
        static const std::vector<std::string> all{"barycentric", "mean-value", "harmonic"};
        return all;
    }

    /// Adds the three options to a CLI11 application.
    template <class App>
    void add_options(App& app, const char* description = "barycentric, mean-value or harmonic") {
        app.add_option("--coordinates", name, description)->check([](const std::string& given) {
            const auto& known = names();
            return std::find(known.begin(), known.end(), given) != known.end()
                       ? std::string()
                       : "\"" + given + "\" is not one of barycentric, mean-value, harmonic";
        });
        app.add_option("--resolution", harmonic.resolution, "harmonic: grid cells along the longer side")
            ->capture_default_str();
        app.template add_option_function<double>(
               "--tolerance",
               [this](double t) { harmonic.multigrid.tolerance = harmonic.averaging.tolerance = t; },
               "harmonic: where the solver ends; the error (multigrid) or the mean change of a cell")
            ->default_str("1e-06");
        app.template add_option_function<std::string>(
               "--solver",
               [this](const std::string& given) {
                   harmonic.solver = given == "multigrid" ? cageform::HarmonicSolver::multigrid
                                                          : cageform::HarmonicSolver::averaging_pyramid;
               },
               "harmonic: multigrid, or the papers' averaging-pyramid")
            ->check([](const std::string& given) {
                return given == "multigrid" || given == "averaging-pyramid"
                           ? std::string()
                           : "\"" + given + "\" is not one of multigrid, averaging-pyramid";
            })
            ->default_str("multigrid");
    }
};

/// Calls f(coordinates) with the type that was chosen.
template <class T, class F>
auto with_coordinates(const CoordinatesChoice& choice, const cageform::Polygon<T>& cage, F&& f) {
    if (choice.name == "barycentric") return f(cageform::BarycentricCoordinates<T, 2>(cage));
    if (choice.name == "harmonic") return f(cageform::HarmonicCoordinates<T, 2>(cage, choice.harmonic));
    return f(cageform::MeanValueCoordinates<T, 2>(cage));
}

/// "edges cross or touch (3, 7)", with only the numbers that mean something.
inline std::string describe_fault(const cageform::CageFault& fault) {
    using Kind = cageform::CageFaultKind;
    if (fault.kind == Kind::degenerate_simplex) return cageform::to_string(fault.kind);
    const bool one = fault.kind == Kind::vertex_not_finite || fault.kind == Kind::no_area ||
                     fault.kind == Kind::collinear_vertex || fault.kind == Kind::loop_turns_otherwise;
    return std::string(cageform::to_string(fault.kind)) + " (" + std::to_string(fault.a) +
           (one ? "" : ", " + std::to_string(fault.b)) + ")";
}

/// One line per fault of the cage that prevents a bind: "cat_cage.svg: edges cross or touch (3, 7)".
inline std::string describe_faults(const std::string& name, const cageform::BindReport& report) {
    std::string text = name + ": " + cageform::to_string(report.status);
    if (report.solver.unseen_handle != report.solver.none) {
        text += " (vertex " + std::to_string(report.solver.unseen_handle) + ")";
        if (report.solver.sufficient_resolution != 0)
            text += "; --resolution " + std::to_string(report.solver.sufficient_resolution) + " sees it";
    }
    for (const auto& fault : report.cage.faults) {
        if (cageform::status_of(fault.kind) == cageform::Status::ok) continue;
        text += "\n  " + describe_fault(fault);
    }
    return text;
}

/// The report of a bind for people.
inline std::string describe(const cageform::BindReport& report) {
    std::ostringstream text;
    const auto list = [&](const char* what, const std::vector<std::size_t>& indices) {
        text << "  " << what << ": " << indices.size();
        for (std::size_t i = 0; i < std::min<std::size_t>(indices.size(), 8); ++i)
            text << (i == 0 ? " (" : ", ") << indices[i];
        if (!indices.empty()) text << (indices.size() > 8 ? ", …)" : ")");
        text << '\n';
    };
    text << "status: " << cageform::to_string(report.status) << '\n';
    for (const auto& fault : report.cage.faults) {
        text << "  cage: " << describe_fault(fault) << '\n';
    }
    text << "points: " << report.points << '\n';
    list("on the boundary", report.on_boundary);
    list("outside", report.outside);
    list("not finite", report.not_finite);
    list("not reached by the solver", report.unreached);
    const auto extreme = [&](const char* what, const cageform::Extreme& value) {
        text << what << ": ";
        if (value.point == value.none)
            text << "no point bound\n";
        else
            text << value.value << " at point " << value.point << '\n';
    };
    extreme("largest |sum w - 1|", report.partition_error);
    extreme("largest |sum w c - p|", report.reproduction_error);
    extreme("least weight", report.least_weight);
    text << "linear precision restored from: " << report.residual_restored.value
         << " (largest change of a weight " << report.weight_change.value << ")\n";
    if (report.solver.cycles > 0) {
        text << "solver: " << report.solver.cells << " unknowns, " << report.solver.solves << " functions, "
             << report.solver.cycles << " cycles, error " << report.solver.error_estimate << " (never above "
             << report.solver.error_bound << "), convergence factor " << report.solver.convergence_factor
             << ", " << double(report.solver.bytes) / 1048576 << " MiB, " << report.solver.seconds << " s\n";
    } else if (report.solver.solves > 0) {
        text << "solver: " << report.solver.cells << " cells, " << report.solver.solves << " functions, "
             << report.solver.sweeps << " sweeps of the finest grid, last mean change "
             << report.solver.largest_mean_change << ", " << report.solver.crowded_cells << " crowded cells, "
             << report.solver.seconds << " s\n";
    }
    text << "time: " << report.seconds << " s\n";
    return text.str();
}

} // namespace cageform_examples

#pragma once

// Cages and poses as files, coordinate types as words: what the example programs have in common.

#include "csv.hpp"
#include "svg_document.hpp"

#include <cageform/cageform.hpp>

#include <numeric>
#include <sstream>

template <>
struct cageform::PointTraits<cageform_examples::Point2> {
    using P = cageform_examples::Point2;
    using scalar = double;
    static constexpr std::size_t dimension = 2;
    static constexpr double get(const P& p, std::size_t axis) noexcept { return axis == 0 ? p.x : p.y; }
    static constexpr void set(P& p, std::size_t axis, double x) noexcept { (axis == 0 ? p.x : p.y) = x; }
};

namespace cageform_examples {

/// A cage in the plane, as read: loops, and perhaps chains and points inside them.
struct CageFile {
    std::string name;
    std::vector<CageBlock> blocks;
    std::vector<std::vector<std::size_t>> handles; // of each block's points
    std::vector<Point2> vertices; // by handle: the loops', then those that chains and points add

    bool has(CageBlock::Kind kind) const {
        return std::any_of(blocks.begin(), blocks.end(),
                           [&](const CageBlock& block) { return block.kind == kind; });
    }
    bool has_cells() const { return has(CageBlock::Kind::chain) || has(CageBlock::Kind::point); }

    /// The loops alone.
    template <class T>
    cageform::Polygon<T> polygon() const {
        std::vector<Point2> points;
        std::vector<std::size_t> sizes;
        for (const CageBlock& block : blocks) {
            if (block.kind != CageBlock::Kind::loop) continue;
            sizes.push_back(block.points.size());
            points.insert(points.end(), block.points.begin(), block.points.end());
        }
        return {points, sizes};
    }

    /// The loops and what is inside them.
    template <class T>
    cageform::CellComplex<T, 2> complex() const {
        cageform::CellComplex<T, 2> cage(polygon<T>());
        for (const CageBlock& block : blocks) add_cells(cage, block);
        return cage;
    }

    /// Calls f(cage) with a Polygon, or with a CellComplex where there are chains or points.
    template <class T, class F>
    auto visit(F&& f) const {
        return has_cells() ? f(complex<T>()) : f(polygon<T>());
    }

    /// Calls f(i, j) with the handles of every edge of a loop or chain; f(i, i) for a point.
    template <class F>
    void for_each_edge(F&& f) const {
        for (std::size_t b = 0; b < blocks.size(); ++b) {
            const bool closed = blocks[b].kind != CageBlock::Kind::chain;
            for (std::size_t k = closed ? 0 : 1, n = handles[b].size(); k < n; ++k)
                f(handles[b][(k + n - 1) % n], handles[b][k]);
        }
    }

    /// Adds a chain or a point to a cage; returns the handles, none for a loop.
    template <class T>
    static std::vector<std::size_t> add_cells(cageform::CellComplex<T, 2>& cage, const CageBlock& block) {
        if (block.kind == CageBlock::Kind::chain) return cage.add_chain(block.points);
        if (block.kind == CageBlock::Kind::point)
            return {cage.add_point(block.points.front(), T(block.radius))};
        return {};
    }
};

inline CageFile make_cage(std::string name, std::vector<CageBlock> blocks) {
    CageFile cage{std::move(name), std::move(blocks), {}, {}};
    cageform::CellComplex<double, 2> complex(cage.polygon<double>());
    std::size_t first = 0;
    for (const CageBlock& block : cage.blocks) {
        auto& handles = cage.handles.emplace_back(CageFile::add_cells(complex, block));
        if (block.kind != CageBlock::Kind::loop) continue;
        handles.resize(block.points.size());
        std::iota(handles.begin(), handles.end(), first);
        first += handles.size();
    }
    for (const auto& v : complex.vertices()) cage.vertices.push_back({v[0], v[1]});
    return cage;
}

/// Reads a cage: the first closed polygon of an SVG file, or a CSV file of loops, chains and points.
inline SvgResult<CageFile> load_cage(const std::string& path) {
    if (path.ends_with(".csv")) {
        auto blocks = read_cage_csv(path);
        if (!blocks) return blocks.error();
        return make_cage(path, std::move(*blocks));
    }
    const auto document = load_svg(path);
    if (!document) return document.error();
    auto loops = first_polygon(*document);
    if (!loops) return loops.error();
    std::vector<CageBlock> blocks;
    for (auto& loop : *loops) blocks.push_back({CageBlock::Kind::loop, 0, std::move(loop)});
    return make_cage(path, std::move(blocks));
}

/// "a chain of 3 points".
inline std::string describe(const CageBlock& block) {
    std::ostringstream text;
    switch (block.kind) {
    case CageBlock::Kind::loop: text << "a loop of " << block.points.size() << " vertices"; break;
    case CageBlock::Kind::chain: text << "a chain of " << block.points.size() << " points"; break;
    case CageBlock::Kind::point: text << "a point of radius " << block.radius; break;
    }
    return text.str();
}

/// Gives a pose, read as a cage, the handles of the cage it is a pose of. Its blocks have to be those of the
/// cage, and what is one vertex there has to be at one place.
inline SvgResult<CageFile> make_pose(CageFile pose, const CageFile& cage) {
    const auto differ = [&](const std::string& where, const std::string& has, const std::string& expected) {
        return SvgError{pose.name + ": " + where + "the pose has " + has + ", the cage " + cage.name + " " +
                        expected};
    };
    const std::size_t count = cage.blocks.size();
    for (std::size_t b = 0; b < std::min(pose.blocks.size(), count); ++b) {
        const CageBlock &is = pose.blocks[b], &was = cage.blocks[b];
        if (is.kind == was.kind && is.points.size() == was.points.size() && is.radius == was.radius) continue;
        return differ(count > 1 ? "block " + std::to_string(b + 1) + ": " : "", describe(is), describe(was));
    }
    const auto blocks = [](std::size_t n) { return std::to_string(n) + (n == 1 ? " block" : " blocks"); };
    if (pose.blocks.size() != count) return differ("", blocks(pose.blocks.size()), blocks(count));

    pose.handles = cage.handles;
    pose.vertices.resize(cage.vertices.size());
    std::vector<bool> known(cage.vertices.size());
    for (std::size_t b = 0; b < count; ++b) {
        for (std::size_t k = 0; k < pose.handles[b].size(); ++k) {
            const std::size_t i = pose.handles[b][k];
            const Point2& p = pose.blocks[b].points[k];
            if (known[i] && !(p == pose.vertices[i])) {
                std::ostringstream text;
                text << pose.name << ": vertex " << i << " of the cage " << cage.name << " is at ("
                     << pose.vertices[i].x << ", " << pose.vertices[i].y << ") and, in block " << b + 1
                     << ", at (" << p.x << ", " << p.y << ')';
                return SvgError{text.str()};
            }
            pose.vertices[i] = p;
            known[i] = true;
        }
    }
    return pose;
}

/// As make_pose(), from a file; fails also as load_cage() does.
inline SvgResult<CageFile> load_pose(const std::string& path, const CageFile& cage) {
    auto pose = load_cage(path);
    return pose ? make_pose(std::move(*pose), cage) : pose;
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

/// Calls f(coordinates) with the type that was chosen, for a cage of the library: in space a TriangleMesh.
template <class Cage, class F>
auto with_coordinates(const CoordinatesChoice& choice, const Cage& cage, F&& f) {
    using T = typename Cage::scalar;
    constexpr std::size_t D = Cage::dimension;
    if (choice.name == "harmonic") return f(cageform::HarmonicCoordinates(cage, choice.harmonic));
    if (choice.name == "mean-value") return f(cageform::MeanValueCoordinates<T, D>(cage));
    if constexpr (D == 2)
        return f(cageform::BarycentricCoordinates<T, 2>(cage));
    else
        return f(cageform::BarycentricCoordinates<T, 3>(cage.vertices()));
}

/// The same for a cage in the plane from a file; `T` is the scalar.
template <class T, class F>
auto with_coordinates(const CoordinatesChoice& choice, const CageFile& file, F&& f) {
    return file.visit<T>([&](const auto& cage) { return with_coordinates(choice, cage, f); });
}

/// How many of its two numbers mean something to a kind of fault.
inline int numbers_of(cageform::CageFaultKind kind) {
    using Kind = cageform::CageFaultKind;
    switch (kind) {
    case Kind::degenerate_simplex:
    case Kind::no_volume: // of a mesh; no program reads a box, which would have an axis
        return 0;
    case Kind::vertex_not_finite:
    case Kind::no_area:
    case Kind::face_without_vertex:
    case Kind::face_without_area:
    case Kind::vertex_not_manifold:
    case Kind::radius_not_positive:
    case Kind::interior_cell_outside:
    case Kind::interior_cells_not_supported:
    case Kind::collinear_vertex:
    case Kind::vertex_unused:
    case Kind::loop_turns_otherwise:
    case Kind::shell_turns_otherwise: return 1;
    case Kind::too_few_vertices:
    case Kind::not_a_simplex:
    case Kind::loops_do_not_match:
    case Kind::duplicate_vertices:
    case Kind::edges_cross:
    case Kind::open_edge:
    case Kind::edge_not_manifold:
    case Kind::face_flipped:
    case Kind::faces_cross:
    case Kind::interior_cells_touch:
    case Kind::gap_closed: return 2;
    }
    return 0;
}

/// "edges cross or touch (3, 7)", with only the numbers that mean something.
inline std::string describe_fault(const cageform::CageFault& fault) {
    const int count = numbers_of(fault.kind);
    std::string text = cageform::to_string(fault.kind);
    if (count > 0) text += " (" + std::to_string(fault.a);
    if (count > 1) text += ", " + std::to_string(fault.b);
    return count > 0 ? text + ")" : text;
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
        if (fault.kind == cageform::CageFaultKind::interior_cells_not_supported)
            text += ": --coordinates harmonic takes them";
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

// A face pulled out of a board: free-form deformation by a lattice in the middle of it (Sederberg, Parry,
// SIGGRAPH 1986).
//
//     lattice_board -o board.png
//
// fit_lattice moves the control points of a spline lattice so that the board fits a relief. Two outer layers
// of points are frozen, so there is no crease at the border. A coarse lattice makes a soft face; refined
// twice, it has enough points for eyes and a mouth. The picture shows the board at rest, by the coarse and by
// the fine lattice.

#include "cli/command_line.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"
#include "pictures/mesh_picture.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/binding/fit_lattice.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/lattice/refine.hpp>

#include <cmath>
#include <iostream>

namespace {

using namespace cageform_support;
using Lattice = cageform::LatticeCoordinates<double, 3>;
using Axes = std::array<cageform::LatticeAxis, 3>;

/// The height of the relief; 0 at the frozen points.
double relief(double x, double y) {
    const auto bump = [&](double height, double at_x, double at_y, double wide, double high) {
        const double u = (std::fabs(x) - at_x) / wide, v = (y - at_y) / high; // both sides are alike
        return height * std::exp(-u * u - v * v);
    };
    const double inside = 1 - std::pow(x / 0.72, 2) - std::pow(y / 0.92, 2);
    const double t = std::clamp(1.5 * inside, 0.0, 1.0), head = t * t * (3 - 2 * t);
    const double nose =
        bump(0.2, 0, 0.05, 0.09, 0.3) + bump(0.16, 0, -0.14, 0.11, 0.1) + bump(0.06, 0.12, -0.18, 0.06, 0.06);
    const double eyes = bump(-0.14, 0.3, 0.24, 0.16, 0.1) + bump(0.12, 0.3, 0.22, 0.09, 0.06) +
                        bump(0.09, 0.3, 0.4, 0.2, 0.06);
    const double mouth = bump(0.12, 0, -0.41, 0.22, 0.06) + bump(0.12, 0, -0.55, 0.17, 0.06) -
                         bump(0.12, 0, -0.48, 0.26, 0.03) + bump(0.1, 0, -0.74, 0.16, 0.1);
    return head * (0.3 + nose + eyes + mouth);
}

/// The board: its front first, a grid of points, then the rim.
struct Board {
    std::vector<Point3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};
Board make_board() {
    constexpr std::uint32_t columns = 180, rows = 150;
    constexpr double wide = 1.5, high = 1.25, thick = 0.08;
    Board board;
    const auto add_grid = [&](std::uint32_t across, std::uint32_t along, const auto& place) {
        const auto first = std::uint32_t(board.vertices.size());
        for (std::uint32_t n = 0; n < (across + 1) * (along + 1); ++n)
            board.vertices.push_back(
                place(2.0 * (n % (across + 1)) / across - 1, 2.0 * (n / (across + 1)) / along - 1));
        for (std::uint32_t row = 0; row < along; ++row) {
            for (std::uint32_t column = 0; column < across; ++column) {
                const std::uint32_t a = first + row * (across + 1) + column, b = a + across + 1;
                board.triangles.push_back({a, a + 1, b + 1});
                board.triangles.push_back({a, b + 1, b});
            }
        }
    };
    add_grid(columns, rows, [](double u, double v) { return Point3{wide * u, high * v, thick}; });
    for (const double side : {-1.0, 1.0}) {
        add_grid(1, 1, [=](double u, double v) { return Point3{side * wide, high * v, -side * thick * u}; });
        add_grid(1, 1, [=](double u, double v) { return Point3{wide * u, side * high, side * -thick * v}; });
    }
    return board;
}

/// All frozen handles: those of the back, and two layers at the four sides.
std::vector<std::uint32_t> frozen(const Lattice& lattice) {
    std::vector<std::uint32_t> list;
    const std::size_t wide = lattice.points(0), high = lattice.points(1);
    for (std::uint32_t n = 0; n < lattice.handles().size(); ++n) {
        const std::size_t i = n % wide, j = n / wide % high;
        if (n < wide * high || i < 2 || i + 2 >= wide || j < 2 || j + 2 >= high) list.push_back(n);
    }
    return list;
}

/// The board deformed by a lattice that is fitted to the relief.
struct Fitted {
    std::vector<Point3> pose, moved;
    cageform::LatticeFitReport report;
};
Expected<Fitted> fitted(const Board& board, const Lattice& lattice) {
    const auto bound =
        cageform::bind(lattice, board.vertices, {.outside = cageform::OutsidePoints::keep_in_place});
    if (!bound) return FileError{cageform::to_string(bound.status())};
    std::vector<Point3> targets;
    std::vector<double> weights; // 1 for points inside the lattice, 0 for others
    for (std::size_t i = 0; i < board.vertices.size(); ++i) {
        const Point3& p = board.vertices[i];
        targets.push_back({0, 0, relief(p[0], p[1])});
        weights.push_back(1);
    }
    for (const std::size_t i : bound.report.outside) weights[i] = 0;
    const auto still = frozen(lattice);
    auto fit = cageform::fit_lattice(lattice, bound.value, targets,
                                     {.smoothness = 1e-10, .point_weights = weights, .frozen = still});
    if (!fit) return FileError{cageform::to_string(fit.status())};
    Fitted result{std::move(fit.value), board.vertices, fit.report};
    const auto status = cageform::clone(bound.value, result.pose, result.moved);
    if (status != cageform::Status::ok) return FileError{cageform::to_string(status)};
    std::cout << lattice.points(0) << " x " << lattice.points(1) << " x " << lattice.points(2)
              << " points: distances of the board from the relief: rms " << result.report.rms << ", largest "
              << result.report.largest << '\n';
    return result;
}

/// The rows and columns of the front layer, each line as a triangle of no area.
std::vector<std::array<std::uint32_t, 3>> lines_of(const Lattice& lattice) {
    std::vector<std::array<std::uint32_t, 3>> lines;
    const auto wide = std::uint32_t(lattice.points(0)), high = std::uint32_t(lattice.points(1));
    for (std::uint32_t n = 0; n < wide * high; ++n) {
        const std::uint32_t at = wide * high + n;
        if (n % wide + 1 < wide) lines.push_back({at, at + 1, at + 1});
        if (n / wide + 1 < high) lines.push_back({at, at + wide, at + wide});
    }
    return lines;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Draws a face pulled out of a board by lattices of control points.");
    line.set_examples({"-o board.png"});
    std::string out;
    line.add("-o,--output", out, "the PNG file to write").required().ends_with({".png"});
    if (const auto code = line.parse(argc, argv)) return *code;

    const Board board = make_board();
    const cageform::Transform<double, 3> box{{Point3{2.2, 0, 0}, Point3{0, 2.3, 0}, Point3{0, 0, 0.2}},
                                             {-1.1, -1.15, -0.1}};
    Axes axes{{{.points = 11}, {.points = 11}, {.points = 2}}};
    const Lattice coarse(axes, box);
    const auto soft = fitted(board, coarse).value();
    for (int round = 0; round < 2; ++round) {
        for (const std::size_t axis : {0u, 1u}) {
            auto finer = cageform::halve_spans(axes[axis]);
            if (!finer) return fail(cageform::to_string(finer.status()));
            axes[axis] = std::move(finer.value.axis);
        }
    }
    const Lattice fine(axes, box);
    const auto sharp = fitted(board, fine).value();

    const auto lines = lines_of(coarse);
    const std::vector<Point3> rest(coarse.handles().begin(), coarse.handles().end());
    const std::array<MeshScene, 3> scenes{{{{board.vertices, board.triangles}, {rest, lines}},
                                           {{soft.moved, board.triangles}, {soft.pose, lines}},
                                           {{sharp.moved, board.triangles}, {}}}};
    OutputFiles outputs;
    draw_meshes(scenes, 1500, 480, {.turn = 22, .rise = 8}).write_png(outputs.add(out));
    return commit(outputs);
}

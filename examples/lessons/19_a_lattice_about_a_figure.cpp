// 19. A lattice around a figure: free-form deformation. The handles are control points of splines in a box.
// No cage is needed, all poses are smooth, and lattices can be refined.
#include <cageform/cageform.hpp>

#include <cageform/binding/fit_lattice.hpp>

#include <array>
#include <cmath>
#include <cstdio>

using Point = cageform::Vec<double, 2>;
using Points = std::vector<Point>;
using Lattice = cageform::LatticeCoordinates<double, 2>;

/// Binds points and moves them, or ends the program.
Points moved(const Lattice& lattice, const Points& points, const Points& pose) {
    Points out(points.size());
    const auto [binding, report] = cageform::bind(lattice, points);
    if (report.status != cageform::Status::ok || clone(binding, pose, out) != cageform::Status::ok)
        std::puts(to_string(report.status));
    return out;
}

int main() {
    // A board of 4 by 2, in a lattice of 7 x 5 control points. An optional third argument of the lattice is
    // the falloff distance.
    const Points board{{0, 0}, {2, 0}, {4, 0}, {0, 1}, {2, 1}, {4, 1}, {0, 2}, {2, 2}, {4, 2}};
    const auto box = cageform::box_around(board);
    if (!box) return std::puts(to_string(box.status()));
    std::array<cageform::LatticeAxis, 2> axes{{{.points = 7}, {.points = 5}}}; // cubic
    const Lattice lattice(axes, box.value);

    // The control point at the centre moves up. The first axis varies fastest: column 3 of row 2 is control
    // point 2 * 7 + 3.
    Points pose(lattice.handles().begin(), lattice.handles().end());
    pose[2 * 7 + 3][1] += 1;
    const Points out = moved(lattice, board, pose);
    std::printf("the middle of the board moves up by %.3f, its edge by %.3f, its corner by %.3f\n",
                out[4][1] - board[4][1], out[7][1] - board[7][1], out[8][1] - board[8][1]);

    // If the two outer layers of control points stay at rest, displacements and their slopes are zero at the
    // faces of the box. Points outside can then stay in place.
    std::printf("%zu of %zu control points are in the two outer layers\n", lattice.frozen_handles(2).size(),
                lattice.handles().size());

    // Refinement adds control points, for finer changes. It does not change the deformation.
    const auto finer = cageform::halve_spans(axes[0]);
    if (!finer) return std::puts(to_string(finer.status()));
    axes[0] = finer.value.axis;
    const Lattice fine(axes, box.value);
    const Points fine_pose = cageform::refined_points<double, 2>(pose, {7, 5}, 0, finer.value);
    double change = 0;
    const Points again = moved(fine, board, fine_pose);
    for (std::size_t i = 0; i < board.size(); ++i)
        change = std::fmax(change, std::fabs(again[i][1] - out[i][1]));
    std::printf("%zu control points instead of %zu: the board %s\n", fine.handles().size(), pose.size(),
                change < 1e-14 ? "does not move" : "moves");

    // The inverse problem: which pose moves the points of the board to given positions?
    Points wanted;
    for (const Point& p : board) wanted.push_back({0, std::sin(p[0])});
    const auto bound = cageform::bind(lattice, board);
    const auto fit = cageform::fit_lattice(lattice, bound.value, wanted);
    if (!fit) return std::puts(to_string(fit.status()));
    std::printf("least-squares pose: error at most %.4f, %zu control points without effect\n",
                fit.report.largest, fit.report.idle.size());
}

//> the middle of the board moves up by 0.333, its edge by 0.006, its corner by 0.000
//> 32 of 35 control points are in the two outer layers
//> 55 control points instead of 35: the board does not move
//> least-squares pose: error at most 0.0003, 0 control points without effect

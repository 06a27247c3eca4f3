// 3. Reports: errors of an invalid cage and of invalid points.
#include <cageform/cageform.hpp>

#include <array>
#include <cmath>
#include <cstdio>

using Point = std::array<double, 2>;

int main() {
    // A bow-tie: edges 0-1 and 2-3 cross. Nothing is bound; the report lists the edges.
    const std::array<Point, 4> bow_tie{{{0, 0}, {2, 2}, {2, 0}, {0, 2}}};
    const std::array<Point, 4> figure{{{1, 0.5}, {5, 0.5}, {std::nan(""), 0}, {2, 1}}};
    const auto refused = cageform::bind(cageform::MeanValueCoordinates(bow_tie), figure);
    std::printf("bow-tie: %s\n", cageform::to_string(refused.report.status));
    for (const auto& fault : refused.report.cage.faults) {
        std::printf("  %s: %zu and %zu\n", cageform::to_string(fault.kind), fault.a, fault.b);
    }

    // A valid cage and some invalid points: they are listed, the others are bound.
    const std::array<Point, 4> square{{{0, 0}, {2, 0}, {2, 2}, {0, 2}}};
    cageform::BindOptions options;
    options.outside = cageform::OutsidePoints::nearest_boundary;
    const auto [binding, report] = cageform::bind(cageform::MeanValueCoordinates(square), figure, options);
    std::printf("square: %s\n", cageform::to_string(report.status));
    for (const std::size_t i : report.outside) std::printf("  outside: point %zu\n", i);
    for (const std::size_t i : report.not_finite) std::printf("  not finite: point %zu\n", i);
    for (const std::size_t i : report.on_boundary) std::printf("  on the boundary: point %zu\n", i);
    std::printf("  weights reproduce the points to rounding: %s\n",
                report.reproduction_error.value < 1e-15 ? "yes" : "no");

    // Point 1 follows the nearest boundary point, (2, 0.5), at a constant offset.
    std::array<Point, 4> pose = square;
    pose[1] = {3, 0};
    pose[2] = {3, 2};
    std::array<Point, 4> out{};
    if (cageform::clone(binding, pose, out) != cageform::Status::ok) return 1;
    std::printf("  point 1 moves to (%g, %g)\n", out[1][0], out[1][1]);

    // A pose of the wrong size is an error; the output does not change.
    const std::array<Point, 3> wrong{};
    std::printf("wrong pose: %s\n", cageform::to_string(cageform::clone(binding, wrong, out)));
}

//> bow-tie: two edges of the cage cross or touch
//>   edges cross or touch: 0 and 2
//> square: ok
//>   outside: point 1
//>   not finite: point 2
//>   on the boundary: point 3
//>   weights reproduce the points to rounding: yes
//>   point 1 moves to (6, 0.5)
//> wrong pose: the pose has another number of points than the cage

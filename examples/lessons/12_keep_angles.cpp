// 12. Keep angles: Green coordinates, whose handles are the cage's vertices and its edges.
#include <cageform/cageform.hpp>

#include <array>
#include <cmath>
#include <cstdio>

using Point = std::array<double, 2>;

/// The angle at the first of three points, in degrees.
double angle(const Point* p) {
    const double ax = p[1][0] - p[0][0], ay = p[1][1] - p[0][1], bx = p[2][0] - p[0][0],
                 by = p[2][1] - p[0][1];
    return std::atan2(ax * by - ay * bx, ax * bx + ay * by) * 180 / 3.14159265358979323846;
}

int main() {
    // The figure is a small right angle; the cage, a square, is sheared and stretched.
    const std::vector<Point> cage{{0, 0}, {4, 0}, {4, 4}, {0, 4}}, pose{{0, 0}, {5, 1}, {7, 4}, {1, 4}};
    const std::vector<Point> corner{{1, 2}, {1.001, 2}, {1, 2.001}};
    std::vector<Point> out(corner.size());

    const auto mean_value = cageform::bind(cageform::MeanValueCoordinates<double, 2>(cage), corner);
    if (clone(mean_value.value, pose, out) != cageform::Status::ok) return 1;
    std::printf("mean value: 90 degrees become %.1f\n", angle(out.data()));

    // Green coordinates have one handle per vertex and one per edge. pose_handles computes the pose of all
    // handles from a pose of the vertices.
    const auto [binding, report] = cageform::bind(cageform::GreenCoordinates<double, 2>(cage), corner);
    if (report.status != cageform::Status::ok) return 1;
    std::printf("Green, %zu handles: %s\n", binding.handle_count(), to_string(clone(binding, pose, out)));
    std::vector<Point> handles(binding.handle_count());
    if (pose_handles(binding, pose, handles).status != cageform::Status::ok) return 1;
    if (clone(binding, handles, out) != cageform::Status::ok) return 1;
    std::printf("Green: 90 degrees become %.1f\n", angle(out.data()));

    // The drawback: points on the cage do not stay on it.
    const std::vector<Point> on_edge{{2, 0}};
    const auto bound = cageform::bind(cageform::GreenCoordinates<double, 2>(cage), on_edge);
    if (clone(bound.value, handles, out = on_edge) != cageform::Status::ok) return 1;
    std::printf("the middle of an edge moves to (%.2f, %.2f), not to (2.50, 0.50)\n", out[0][0], out[0][1]);
}

//> mean value: 90 degrees become 67.3
//> Green, 8 handles: the pose has another number of points than the cage
//> Green: 90 degrees become 90.0
//> the middle of an edge moves to (3.13, 0.03), not to (2.50, 0.50)

// 22. Fit a pose to given points by gradients. `clone` computes points from a pose; `clone_transposed`
// converts gradients of points to gradients of handles. An optimiser needs only these two.
#include <cageform/cageform.hpp>

#include <cmath>
#include <cstdio>

using Point = cageform::Vec<double, 2>;
using Points = std::vector<Point>;

double product(const Points& a, const Points& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += dot(a[i], b[i]);
    return sum;
}
/// Adds a multiple of b to a.
void add(Points& a, double factor, const Points& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] = a[i] + factor * b[i];
}

int main() {
    // A star of five arms, and points inside.
    Points cage, points;
    for (int k = 0; k < 25; ++k) {
        const double angle = 6.283185307179586 / 25 * k, r = 3 + std::cos(5 * angle);
        cage.push_back({r * std::cos(angle), r * std::sin(angle)});
    }
    const cageform::Polygon<double> star(cage);
    for (int n = 0; n < 81 * 81; ++n) {
        const Point p{0.1 * (n % 81) - 4, 0.1 * double(n / 81) - 4};
        if (locate(star, p, 0.0) == cageform::PointState::inside) points.push_back(p);
    }
    const auto [binding, report] = cageform::bind(cageform::MeanValueCoordinates(star), points);
    if (report.status != cageform::Status::ok) return std::puts(to_string(report.status));

    // Markers: the positions of the points in an unknown pose.
    Points sought = cage, markers(points.size());
    for (Point& h : sought) h = h + Point{0.1 * h[1] * h[1], 0.5 * std::sin(h[0])};
    if (clone(binding, sought, markers) != cageform::Status::ok) return 1;

    // The function: f = ½ Σ |p' − marker|². Its gradient at the points is p' − marker.
    Points pose = cage, gap = points, slope(cage.size()), way(cage.size(), Point{});
    add(gap, -1, markers);
    double last = 1;
    for (int step = 0; step < 40; ++step) {
        if (clone_transposed(binding, gap, slope) != cageform::Status::ok) return 1;
        const double size = product(slope, slope);
        if (step == 0 || step == 2 || step == 4 || step == 8)
            std::printf("after %2d steps: RMS distance from the markers %.5f\n", step,
                        std::sqrt(product(gap, gap) / double(points.size())));
        // Conjugate gradients: the gradient and a multiple of the previous direction (Hestenes, Stiefel
        // 1952).
        for (Point& w : way) w = (step == 0 ? 0 : size / last) * w;
        add(way, -1, slope);
        last = size;
        // Exact line search: points depend linearly on handles, so a clone of the direction gives the
        // displacements of the points per unit of step length.
        Points ahead = cage, moves(points.size(), Point{});
        add(ahead, 1, way);
        if (clone(binding, ahead, moves, {.mode = cageform::CloneMode::add}) != cageform::Status::ok)
            return 1;
        const double length = size / product(moves, moves);
        add(pose, length, way);
        add(gap, length, moves);
    }

    // In exact arithmetic the method converges in as many steps as handles.
    add(pose, -1, sought);
    std::printf("%zu handles from %zu points: %s\n", cage.size(), points.size(),
                std::sqrt(product(pose, pose)) < 1e-6 ? "the pose is found" : "another pose");
}

//> after  0 steps: RMS distance from the markers 0.57174
//> after  2 steps: RMS distance from the markers 0.09007
//> after  4 steps: RMS distance from the markers 0.01828
//> after  8 steps: RMS distance from the markers 0.00035
//> 25 handles from 2845 points: the pose is found

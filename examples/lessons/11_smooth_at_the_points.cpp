// 11. Sibson coordinates of degree 3, which are smooth at the control points; and the rational clone, with a
// weight per control point.
#include <cageform/cageform.hpp>
#include <cageform/clone/clone_rational.hpp>

#include <array>
#include <cstdio>

using Point = std::array<double, 2>;

int main() {
    // Control points on a square and in its middle; the figure is a line through the middle.
    const std::vector<Point> sites{{-2, -2}, {2, -2}, {2, 2}, {-2, 2}, {0, 0}};
    std::vector<Point> line;
    for (int i = -4; i <= 4; ++i) line.push_back({0.25 * i, 0.1 * i});
    auto pose = sites;
    pose[4] = {0, 1}; // the middle goes up

    // Degree 1 has a crease at a control point, degree 3 is smooth there. Degree 3 has negative weights: if
    // no handle moves by more than 1, a point moves by at most the amplification.
    std::vector<Point> out(line.size());
    for (const int degree : {1, 3}) {
        const cageform::SibsonCoordinates<double, 2> coordinates(sites, {.degree = degree});
        const auto [binding, report] = cageform::bind(coordinates, line);
        if (report.status != cageform::Status::ok || clone(binding, pose, out) != cageform::Status::ok)
            return 1;
        std::printf("degree %d goes up by", degree);
        for (std::size_t i = 0; i < line.size(); ++i) std::printf(" %.2f", out[i][1] - line[i][1]);
        std::printf(", amplification %.2f\n", report.amplification.value);
    }

    // A larger weight attracts the figure, even in the rest pose. With equal weights the result is the clone,
    // bit for bit.
    const auto bound = cageform::bind(cageform::SibsonCoordinates<double, 2>(sites), line);
    const auto [rational, status] = rational_view(bound.value.view());
    if (status != cageform::Status::ok) return std::puts(to_string(status));
    for (const double weight : {1.0, 3.0, 100.0}) {
        const std::array<double, 5> weights{1, 1, 1, 1, weight};
        if (clone_rational(rational, sites, weights, out) != cageform::Status::ok) return 1;
        std::printf("weight %3g: the line's end (%.2f, %.2f) moves to (%.2f, %.2f)\n", weight, line.back()[0],
                    line.back()[1], out.back()[0], out.back()[1]);
    }

    // Negative weights are an error: the quotient could be unbounded.
    const auto cubic = cageform::bind(cageform::SibsonCoordinates<double, 2>(sites, {.degree = 3}), line);
    std::printf("degree 3: %s\n", to_string(rational_view(cubic.value.view()).status()));
}

//> degree 1 goes up by 0.50 0.62 0.74 0.87 1.00 0.87 0.74 0.62 0.50, amplification 1.00
//> degree 3 goes up by 0.65 0.78 0.89 0.97 1.00 0.97 0.89 0.78 0.65, amplification 1.15
//> weight   1: the line's end (1.00, 0.40) moves to (1.00, 0.40)
//> weight   3: the line's end (1.00, 0.40) moves to (0.50, 0.20)
//> weight 100: the line's end (1.00, 0.40) moves to (0.02, 0.01)
//> degree 3: the binding has negative weights: rational clones need non-negative ones

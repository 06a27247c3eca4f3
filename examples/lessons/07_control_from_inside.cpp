// 7. Control from inside: a vertex and a chain of edges inside the cage are additional handles.
#include <cageform/cageform.hpp>

#include <array>
#include <cstdio>

using Point = std::array<double, 2>;

int main() {
    const std::vector<Point> outline{{0, 0}, {8, 0}, {8, 4}, {0, 4}};
    cageform::CellComplex<double, 2> cage(cageform::Polygon<double>{outline});
    const std::size_t head = cage.add_point(Point{7, 2}, 0.5); // points within 0.5 translate with it
    const auto spine = cage.add_chain(std::vector<Point>{{1, 2}, {3, 2}, {5, 2}});
    std::printf("handles: 0 to 3 the outline, %zu the head, %zu to %zu the spine\n", head, spine.front(),
                spine.back());

    const std::array<Point, 4> figure{{{7.2, 2.1}, {4, 2}, {4, 3}, {0.5, 0.5}}};
    const cageform::HarmonicCoordinates coordinates(cage);
    const auto [binding, report] = cageform::bind(coordinates, figure);
    if (report.status != cageform::Status::ok) return std::puts(to_string(report.status));

    std::vector<Point> pose;
    for (const auto& v : cage.vertices()) pose.push_back({v[0], v[1]});
    pose[head] = {7, 3};     // the head up by 1
    pose[spine[1]] = {3, 1}; // the middle of the spine down by 1; the outline stays
    std::array<Point, 4> moved;
    if (clone(binding, pose, moved) != cageform::Status::ok) return 1;
    for (std::size_t i = 0; i < figure.size(); ++i) {
        std::printf("(%.1f, %.1f) moves up by %5.2f\n", figure[i][0], figure[i][1],
                    moved[i][1] - figure[i][1] + 0.0);
    }

    // Mean value coordinates do not support handles inside: an error.
    const auto refused = cageform::bind(cageform::MeanValueCoordinates<double, 2>(cage), figure).report;
    std::printf("mean value: %s\n", to_string(refused.status));
}

//> handles: 0 to 3 the outline, 4 the head, 5 to 7 the spine
//> (7.2, 2.1) moves up by  1.01
//> (4.0, 2.0) moves up by -0.50
//> (4.0, 3.0) moves up by -0.21
//> (0.5, 0.5) moves up by -0.02
//> mean value: this coordinate type does not support interior cells

// 16. A cage for any figure: make_cage makes one around strokes, outlines and scattered parts.
#include <cageform/cageform.hpp>
#include <cageform/enclose/make_cage.hpp> // editors include it, games do not

#include <cstdio>

int main() {
    // A stick figure: the head is a dot of radius 3; the spine, the arms and the legs are strokes.
    using Segment = cageform::DrawnSegment<double>;
    const std::vector<Segment> figure{{{0, 20}, {0, 20}, 3}, {{0, 16}, {0, 8}, 1}, {{0, 14}, {-7, 12}, 1},
                                      {{0, 14}, {7, 12}, 1}, {{0, 8}, {-4, 0}, 1}, {{0, 8}, {4, 0}, 1}};
    cageform::MakeCageOptions options;
    options.vertices = 20;
    options.mirror = cageform::MirrorPlane{0}; // symmetric
    const auto made = make_cage(figure, options);
    if (!made) return std::puts(to_string(made.status()));
    std::printf("vertices: %zu, clearance: %.0f %% of the margin, parts: %zu, bridges: %zu\n",
                made.value.size(), 100 * made.report.clearance / made.report.margin, made.report.components,
                made.report.bridges);

    // The cage is a Polygon.
    std::vector<cageform::Vec<double, 2>> points(figure.size());
    for (std::size_t k = 0; k < figure.size(); ++k) points[k] = figure[k].b;
    const cageform::HarmonicCoordinates<double, 2> coordinates(made.value);
    const auto [binding, report] = cageform::bind(coordinates, points);
    std::vector<cageform::Vec<double, 2>> pose(made.value.vertices().begin(), made.value.vertices().end());
    for (auto& p : pose) {
        if (p[0] > 2 && p[1] > 8) p[1] += 6; // the vertices around one arm
    }
    std::vector<cageform::Vec<double, 2>> out(points.size());
    if (clone(binding, pose, out) != cageform::Status::ok) return 1;
    std::printf("right hand from %.0f to %.0f, left from %.0f to %.0f\n", points[3][1], out[3][1],
                points[2][1], out[2][1]);
}

//> vertices: 20, clearance: 97 % of the margin, parts: 1, bridges: 0
//> right hand from 12 to 18, left from 12 to 12

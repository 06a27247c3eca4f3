// 25. One body on another: a lattice lays a source on a target, and clothes of the source follow.
#include <cageform/fit/push_out.hpp>
#include <cageform/fit/wrap.hpp>

#include <cmath>
#include <cstdio>

using Point = cageform::Vec<double, 3>;
using Points = std::vector<Point>;
using Faces = std::vector<std::array<int, 3>>;

/// A vase of height 2: 24 rings of 20 vertices, and a vertex at each end.
struct Vase {
    Points vertices;
    Faces faces;
    Vase(double belly, double wider) {
        for (int r = 0; r < 24; ++r) {
            const double s = 3.14159265 * (r + 0.5) / 24, bulge = std::sin(s) * std::sin(s);
            const double radius = 0.15 * std::sqrt(std::sin(s)) + belly * bulge * bulge + wider;
            for (int a = 0; a < 20; ++a)
                vertices.push_back(
                    {radius * std::sin(0.314159265 * a), -std::cos(s), radius * std::cos(0.314159265 * a)});
        }
        vertices.push_back({0, -1, 0});
        vertices.push_back({0, 1, 0});
        for (int a = 0; a < 20; ++a) {
            const int next = (a + 1) % 20, top = 23 * 20;
            faces.push_back({480, next, a});
            faces.push_back({481, top + a, top + next});
            for (int r = 0; r < top; r += 20) {
                faces.push_back({r + a, r + next, r + 20 + next});
                faces.push_back({r + a, r + 20 + next, r + 20 + a});
            }
        }
    }
};

int main() {
    const Vase source(0.1, 0), target(0.25, 0), coat(0.1, 0.02); // the coat is 0.02 off the source
    const cageform::SurfaceMesh from(source.vertices, source.faces), to(target.vertices, target.faces);

    // Points that follow are kept outside the target, softly. Without landmarks, both have the same pose.
    const auto [wrap, report] = cageform::wrap(from, to, {.follow = coat.vertices, .finest = 12});
    if (report.status != cageform::Status::ok) return std::puts(to_string(report.status));
    std::printf("from %.1f %% of the height to %s\n", 100 * report.start.mean,
                report.to_target.mean < 0.003 ? "less than 0.3 %" : "more");
    std::printf("folds: %zu\n", report.folded_vertices + report.folded_followers + report.folded_samples);

    // The map moves all of space: clothes, joints, hair.
    Points moved(coat.vertices.size());
    if (move(wrap, coat.vertices, moved) != cageform::Status::ok) return 1;
    std::printf("the coat at the belly: %.2f, the target: 0.40\n", moved[240][2]);

    // The last step for clothes: at least 0.01 outside the target.
    const auto pushed = push_out(to, {moved, coat.faces}, {}, moved, 0.01);
    if (pushed.status != cageform::Status::ok) return 1;
    std::printf("inside the target: %zu\n", pushed.left);
}

//> from 2.6 % of the height to less than 0.3 %
//> folds: 0
//> the coat at the belly: 0.42, the target: 0.40
//> inside the target: 0

// 1. Bind once, clone often: three points in a square cage. One corner of the cage moves.
#include <cageform/cageform.hpp>

#include <array>
#include <cstdio>

int main() {
    using Point = std::array<double, 2>; // other point types: see 02

    const std::array<Point, 4> cage{{{0, 0}, {2, 0}, {2, 2}, {0, 2}}};
    const std::array<Point, 3> figure{{{0.5, 0.5}, {1, 1}, {2, 1.5}}};

    // Bind time. A coordinate type stores the cage; `bind` computes a weight per point and cage vertex.
    const cageform::MeanValueCoordinates coordinates(cage);
    const auto [binding, report] = cageform::bind(coordinates, figure);
    if (report.status != cageform::Status::ok) {
        std::printf("%s\n", cageform::to_string(report.status));
        return 1;
    }
    std::printf("weights of (1, 1):");
    for (std::size_t h = 0; h < binding.handle_count(); ++h) std::printf(" %.4f", binding.weight(1, h));

    // Run time, every frame: no allocation; only a pose of the wrong size is an error.
    std::array<Point, 4> pose = cage;
    pose[2] = {3, 3};
    std::array<Point, 3> out{};
    if (cageform::clone(binding, pose, out) != cageform::Status::ok) return 1;
    std::printf("\n");
    for (std::size_t i = 0; i < out.size(); ++i) {
        std::printf("(%.2f, %.2f) moves to (%.4f, %.4f)\n", figure[i][0], figure[i][1], out[i][0], out[i][1]);
    }

    // The rest pose reproduces the figure bit for bit.
    if (cageform::clone(binding, cage, out) != cageform::Status::ok) return 1;
    std::printf("rest pose exact: %s\n", out == figure ? "yes" : "no");
}

// The centre has equal weights for all corners. The last point lies on the right edge, so only the ends of
// that edge have weights: it moves by three quarters of the corner's displacement.
//
//> weights of (1, 1): 0.2500 0.2500 0.2500 0.2500
//> (0.50, 0.50) moves to (0.5729, 0.5729)
//> (1.00, 1.00) moves to (1.2500, 1.2500)
//> (2.00, 1.50) moves to (2.7500, 2.2500)
//> rest pose exact: yes

// 6. Three dimensions: a box as the cage, its top twisted. The Jacobian of the deformation, Σ C'_i ∇h_i with
// the posed vertices C'_i and the weight functions h_i, transforms normals.
#include <cageform/cageform.hpp>

#include <array>
#include <cstdio>

using Point = std::array<double, 3>;

int main() {
    // Two divisions along x and y, four along z: 42 vertices.
    const auto cage = cageform::box_mesh<double>({-1, -1, 0}, {1, 1, 4}, {2, 2, 4});
    const std::array<Point, 3> points{{{0.5, 0, 0}, {0.5, 0, 2}, {0.5, 0, 4}}};

    cageform::HarmonicOptions options;
    options.resolution = 32; // cells along z
    cageform::HarmonicCoordinates coordinates(cage, options, cageform::UniformGrid{});
    if (coordinates.solve().status != cageform::Status::ok) return 1; // stores the solution for two uses
    const auto [binding, report] = cageform::bind(coordinates, points);
    std::printf("%zu handles: %s, %zu cycles\n", binding.handle_count(), cageform::to_string(report.status),
                report.solver.multigrid.cycles);

    // A twist of 90 degrees from bottom to top.
    std::vector<Point> pose;
    for (const auto& v : cage.vertices()) {
        const double angle = v[2] / 4 * 1.5707963267948966, c = std::cos(angle), s = std::sin(angle);
        pose.push_back({c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]});
    }
    std::array<Point, 3> moved;
    if (cageform::clone(binding, pose, moved) != cageform::Status::ok) return 1;
    for (const auto& p : moved) std::printf("point at (%5.2f, %5.2f, %5.2f)\n", p[0], p[1], p[2]);

    // The gradients of all functions at the middle point: one row per axis and handle.
    const std::size_t handles = binding.handle_count();
    std::vector<cageform::Lanes<double>> place(3), rows(3 * handles);
    for (std::size_t k = 0; k < 3; ++k) place[k][0] = points[1][k];
    cageform::PointState state = cageform::PointState::inside;
    const cageform::BlockView<double> gradients{rows.data(), 3 * handles, 1};
    const auto outcome = coordinates.evaluate_gradients({place.data(), 3, 1}, gradients, {&state, 1});
    if (outcome.status != cageform::Status::ok) return 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        Point column{}; // the derivative along the axis
        for (std::size_t i = 0; i < handles; ++i) {
            for (std::size_t k = 0; k < 3; ++k) column[k] += pose[i][k] * gradients(0, axis * handles + i);
        }
        for (double& x : column) x = std::round(100 * x) / 100 + 0.0; // no negative zero
        std::printf("derivative along %c: (%5.2f, %5.2f, %5.2f)\n", "xyz"[axis], column[0], column[1],
                    column[2]);
    }
}

//> 42 handles: ok, 3 cycles
//> point at ( 0.50,  0.00,  0.00)
//> point at ( 0.34,  0.34,  2.00)
//> point at ( 0.00,  0.50,  4.00)
//> derivative along x: ( 0.70,  0.70,  0.00)
//> derivative along y: (-0.69,  0.69,  0.00)
//> derivative along z: (-0.13,  0.13,  1.00)

// 2. Your own points: matrices, vertex buffers, structs. The library reads and writes them in place, by a
// trait or a strided view.
#include <cageform/adapt/eigen.hpp>
#include <cageform/cageform.hpp>

#include <cstdio>
#include <vector>

struct Waypoint { // a struct without array access
    float east, north;
    int id;
};

template <>
struct cageform::PointTraits<Waypoint> {
    using scalar = float;
    static constexpr std::size_t dimension = 2;
    static constexpr float get(const Waypoint& p, std::size_t axis) noexcept {
        return axis == 0 ? p.east : p.north;
    }
    static constexpr void set(Waypoint& p, std::size_t axis, float x) noexcept {
        (axis == 0 ? p.east : p.north) = x;
    }
};

int main() {
    // The cage: one column per point, as in Eigen.
    Eigen::Matrix2Xf cage(2, 3);
    cage << 0, 4, 0, //
        0, 0, 4;
    const cageform::BarycentricCoordinates<float, 2> coordinates(cageform::points_in_columns<2>(cage));

    // The figure: an interleaved vertex buffer x, y, u, v, of which x and y are the points.
    std::vector<float> buffer{1, 1, 0.25f, 0.25f, 2, 1, 0.5f, 0.25f};
    const cageform::StridedPoints<float, 2> positions(buffer.data(), 2, 4 * sizeof(float));
    const auto [binding, report] = cageform::bind(coordinates, positions);
    if (report.status != cageform::Status::ok) return 1;

    // The pose: our own struct. The result is written to the vertex buffer; u and v do not change.
    const std::vector<Waypoint> pose{{0, 0, 17}, {8, 0, 18}, {0, 4, 19}};
    if (cageform::clone(binding, pose, positions) != cageform::Status::ok) return 1;
    for (std::size_t i = 0; i < 8; i += 4) {
        std::printf("%g %g  (u v: %g %g)\n", buffer[i], buffer[i + 1], buffer[i + 2], buffer[i + 3]);
    }

    // The result can also be written to the rows of a matrix.
    Eigen::MatrixXd rows(2, 2);
    if (cageform::clone(binding, pose, cageform::points_in_rows<2>(rows)) != cageform::Status::ok) return 1;
    std::printf("%g %g\n%g %g\n", rows(0, 0), rows(0, 1), rows(1, 0), rows(1, 1));

    // A cage in space from a vertex and a flat index buffer, three indices per triangle.
    const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::vector<std::uint16_t> indices{0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
    const cageform::TriangleMesh mesh(cageform::StridedPoints<const float, 3>(corners.data(), 4),
                                      cageform::faces_of(indices));
    std::printf("%zu faces: %s\n", mesh.given_faces(), cageform::to_string(check(mesh).status));
}

// The pose stretches the triangle to twice its width, so x doubles.
//
//> 2 1  (u v: 0.25 0.25)
//> 4 1  (u v: 0.5 0.25)
//> 2 1
//> 4 1
//> 4 faces: ok

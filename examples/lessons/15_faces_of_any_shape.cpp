// 15. Faces of any shape: a cage of polygons, with weights that do not depend on a triangulation.
#include <cageform/cageform.hpp>

#include <array>
#include <cstdio>

using Point = std::array<double, 3>;

template <class Coordinates>
void print(const char* name, const Coordinates& coordinates) {
    std::array<double, 8> weights{};
    if (weights_at(coordinates, Point{0.5, 0.5, 0.8}, std::span(weights)) != cageform::PointState::inside)
        return;
    std::printf("%-22s", name);
    for (std::size_t i = 4; i < 8; ++i) std::printf(" %.3f", weights[i]);
    std::printf("\n");
}

int main() {
    const std::vector<Point> vertices{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                      {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    const std::vector<std::vector<int>> quads{{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                              {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    const cageform::PolyhedralMesh<double> cage(vertices, quads);

    // At a point below the centre of the lid, the lid's corners have equal weights, unless a diagonal splits
    // the lid.
    std::puts("weights of the lid's corners:");
    cageform::HarmonicOptions options;
    options.resolution = 32;
    print("harmonic, quads", cageform::HarmonicCoordinates(cage, options, cageform::UniformGrid{}));
    print("harmonic, triangles",
          cageform::HarmonicCoordinates(cage.triangles(), options, cageform::UniformGrid{}));
    print("mean value, quads",
          cageform::MeanValueCoordinates<double, 3, cageform::PolyhedralMesh<double>>(cage));
    print("mean value, triangles", cageform::MeanValueCoordinates<double, 3>(cage.triangles()));

    // Faces must be planar. The report lists non-planar faces. off_plane is the allowed distance of a corner
    // from the plane of its face.
    auto bent = vertices;
    bent[6] = {1, 1, 1.01};
    for (const auto& fault : check(cageform::PolyhedralMesh<double>(bent, quads)).faults)
        std::printf("%s: face %zu, vertex %zu\n", to_string(fault.kind), fault.a, fault.b);
    const auto report = check(cageform::PolyhedralMesh<double>(bent, quads, {.off_plane = 0.01}));
    std::printf("up to 0.01: %s\n", to_string(report.status));

    // Alternatively, each non-planar face becomes a triangle fan around the mean of its corners.
    const cageform::PolyhedralMesh<double> fans(bent, quads,
                                                {.non_planar = cageform::PolyhedralOptions::NonPlanar::fan});
    std::printf("as fans: %s\n", to_string(check(fans).status));
    print("mean value, fans",
          cageform::MeanValueCoordinates<double, 3, cageform::PolyhedralMesh<double>>(fans));
}

//> weights of the lid's corners:
//> harmonic, quads        0.200 0.200 0.200 0.200
//> harmonic, triangles    0.115 0.285 0.115 0.285
//> mean value, quads      0.200 0.200 0.200 0.200
//> mean value, triangles  0.119 0.281 0.119 0.281
//> face not planar: face 1, vertex 4
//> up to 0.01: ok
//> as fans: ok
//> mean value, fans       0.200 0.200 0.199 0.200

// Closed triangle meshes for tests: bumpy spheres, tori, and points about them.
#pragma once

#include "cages.hpp"

#include <cageform/cage/triangle_mesh.hpp>

#include <map>
#include <numbers>

namespace cageform_tests {

/// The number of times that a mesh encloses a point, by the sum of solid angles.
template <cageform::Scalar T>
double winding_number(const cageform::TriangleMesh<T>& mesh, const cageform::Vec<T, 3>& p) {
    double sum = 0;
    for (const auto& face : mesh.faces()) {
        const cageform::Facet<3> facet(face, mesh.vertices());
        sum += cageform::detail::half_solid_angle(cageform::vec_cast<double>(p), facet.corner);
    }
    return sum / (2 * std::numbers::pi);
}

template <class T>
using Points3 = std::vector<Vec<T, 3>>;
using Faces = std::vector<std::array<int, 3>>;

struct MeshData {
    Points3<double> vertices;
    Faces faces;

    template <class T>
    cageform::TriangleMesh<T> mesh() const {
        Points3<T> converted;
        for (const auto& v : vertices) converted.push_back(vec_cast<T>(v));
        return {converted, faces};
    }
};

/// An octahedron refined `steps` times, its vertices on the unit sphere.
inline MeshData sphere(int steps) {
    MeshData data{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
                  {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
    for (; steps > 0; --steps) {
        std::map<std::pair<int, int>, int> middles;
        const auto middle = [&](int a, int b) {
            const auto [at, added] = middles.insert({std::minmax(a, b), int(data.vertices.size())});
            if (added) {
                const auto m = data.vertices[std::size_t(a)] + data.vertices[std::size_t(b)];
                data.vertices.push_back((1 / std::sqrt(dot(m, m))) * m);
            }
            return at->second;
        };
        Faces finer;
        for (const auto& [a, b, c] : data.faces) {
            const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
        }
        data.faces = std::move(finer);
    }
    return data;
}

/// A torus of 3 × 3 vertices and more.
inline MeshData torus(int around, int across) {
    MeshData data;
    for (int i = 0; i < around; ++i) {
        for (int j = 0; j < across; ++j) {
            const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across;
            const double r = 1 + 0.4 * std::cos(v);
            data.vertices.push_back({r * std::cos(u), r * std::sin(u), 0.4 * std::sin(v)});
            const int a = i * across + j, b = ((i + 1) % around) * across + j;
            const int c = ((i + 1) % around) * across + (j + 1) % across, d = i * across + (j + 1) % across;
            data.faces.insert(data.faces.end(), {{a, b, c}, {a, c, d}});
        }
    }
    return data;
}

/// A box about the origin of cells along each axis, its faces divided into their squares.
inline MeshData divided_box(std::array<int, 3> cells, double edge) {
    MeshData data;
    std::map<std::array<int, 3>, int> vertices;
    const auto vertex = [&](const std::array<int, 3>& at) {
        const auto [found, added] = vertices.insert({at, int(data.vertices.size())});
        if (added) {
            data.vertices.push_back({edge * (at[0] - 0.5 * cells[0]), edge * (at[1] - 0.5 * cells[1]),
                                     edge * (at[2] - 0.5 * cells[2])});
        }
        return found->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int i = 0; i < cells[u]; ++i) {
            for (int j = 0; j < cells[v]; ++j) {
                for (const bool far : {false, true}) {
                    const auto corner = [&](int along_u, int along_v) {
                        std::array<int, 3> at{};
                        at[axis] = far ? cells[axis] : 0;
                        at[u] = i + along_u;
                        at[v] = j + along_v;
                        return vertex(at);
                    };
                    const int a = corner(0, 0), b = corner(far ? 1 : 0, far ? 0 : 1), c = corner(1, 1),
                              d = corner(far ? 0 : 1, far ? 1 : 0);
                    data.faces.insert(data.faces.end(), {{a, b, c}, {a, c, d}});
                }
            }
        }
    }
    return data;
}

/// A bumpy sphere (concave in places) or a torus, somewhere, of some size, turned; 6 to 258 vertices.
inline MeshData random_mesh(std::uint64_t seed) {
    Random random(seed);
    MeshData data;
    if (seed % 4 == 3) {
        data = torus(3 + int(random.below(12)), 3 + int(random.below(8)));
    } else {
        data = sphere(int(random.below(4)));
        for (auto& v : data.vertices) v = random.uniform(0.6, 1.2) * v;
    }
    const double scale = std::pow(10.0, random.uniform(-3, 3)), turn = random.uniform(0, 6.3);
    const Vec<double, 3> centre{random.uniform(-2, 2) * scale, random.uniform(-2, 2) * scale,
                                random.uniform(-2, 2) * scale};
    for (auto& v : data.vertices) {
        const Vec<double, 3> turned{std::cos(turn) * v[0] - std::sin(turn) * v[2], v[1],
                                    std::sin(turn) * v[0] + std::cos(turn) * v[2]};
        v = centre + scale * turned;
    }
    return data;
}

/// As `random_mesh`, of 20 to 500 vertices.
inline MeshData random_large_mesh(std::uint64_t seed) {
    for (std::uint64_t n = seed;; n += 1000) {
        Random random(n);
        auto data = random_mesh(n);
        if (n % 4 == 3) data = torus(4 + int(random.below(22)), 5 + int(random.below(16)));
        if (data.vertices.size() >= 20 && data.vertices.size() <= 500) return data;
    }
}

/// Points in the mesh's box made half as large again.
inline Points3<double> points_about(const MeshData& data, std::size_t count, std::uint64_t seed) {
    Random random(seed);
    const auto bounds = cageform::bounds_of(std::span<const Vec<double, 3>>(data.vertices));
    Points3<double> points(count);
    for (auto& p : points) {
        for (std::size_t k = 0; k < 3; ++k) {
            const double middle = 0.5 * (bounds.lower[k] + bounds.upper[k]);
            p[k] = middle + 1.5 * (random.uniform(bounds.lower[k], bounds.upper[k]) - middle);
        }
    }
    return points;
}

} // namespace cageform_tests

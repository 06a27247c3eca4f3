// Cages and points of the benchmarks, from formulas and seeds, so that other libraries can use the same
// input.
#pragma once

#include <cageform/cage/polygon.hpp>
#include <cageform/cage/polyhedral_mesh.hpp>

#include <array>
#include <cstdint>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

namespace cageform_bench {

using Point = cageform::Vec<double, 2>;

/// STAR(m): m vertices at angle t = 2πk/m and radius 1 + 0.35 sin 5t + 0.1 cos 3t; concave.
inline std::vector<Point> star(std::size_t m) {
    std::vector<Point> vertices(m);
    for (std::size_t k = 0; k < m; ++k) {
        const double t = 2 * std::numbers::pi * double(k) / double(m);
        const double r = 1 + 0.35 * std::sin(5 * t) + 0.1 * std::cos(3 * t);
        vertices[k] = {r * std::cos(t), r * std::sin(t)};
    }
    return vertices;
}

/// EGG(m): m vertices at angle t = 2πk/m on the ellipse with half axes 1 and 0.7; convex.
inline std::vector<Point> egg(std::size_t m) {
    std::vector<Point> vertices(m);
    for (std::size_t k = 0; k < m; ++k) {
        const double t = 2 * std::numbers::pi * double(k) / double(m);
        vertices[k] = {std::cos(t), 0.7 * std::sin(t)};
    }
    return vertices;
}

/// BUMPY112: 112 vertices and 220 faces around the origin; concave. Vertices at the poles and on ten rings of
/// eleven, at θ = πi/11 from the north pole and φ = 2πj/11. The radius is 1 + 0.35 cos 3θ + 0.25 sin θ cos
/// 4φ.
template <class T>
cageform::TriangleMesh<T> bumpy112() {
    constexpr std::uint32_t rings = 10, around = 11, south = 1 + rings * around;
    const auto at = [](double theta, double phi) {
        const double r = 1 + 0.35 * std::cos(3 * theta) + 0.25 * std::sin(theta) * std::cos(4 * phi);
        return cageform::Vec<double, 3>{r * std::sin(theta) * std::cos(phi),
                                        r * std::sin(theta) * std::sin(phi), r * std::cos(theta)};
    };
    const auto on_ring = [](std::uint32_t i, std::uint32_t j) { return 1 + (i - 1) * around + j % around; };
    std::vector<cageform::Vec<double, 3>> vertices{at(0, 0)};
    for (std::uint32_t i = 1; i <= rings; ++i) {
        for (std::uint32_t j = 0; j < around; ++j)
            vertices.push_back(
                at(std::numbers::pi * i / (rings + 1), 2 * std::numbers::pi * j / double(around)));
    }
    vertices.push_back(at(std::numbers::pi, 0));
    std::vector<std::array<std::uint32_t, 3>> faces;
    for (std::uint32_t j = 0; j < around; ++j) {
        faces.push_back({0, on_ring(1, j), on_ring(1, j + 1)});
        faces.push_back({south, on_ring(rings, j + 1), on_ring(rings, j)});
        for (std::uint32_t i = 1; i < rings; ++i) {
            faces.push_back({on_ring(i, j), on_ring(i + 1, j), on_ring(i + 1, j + 1)});
            faces.push_back({on_ring(i, j), on_ring(i + 1, j + 1), on_ring(i, j + 1)});
        }
    }
    return {vertices, faces};
}

/// A triangle mesh.
struct ObjMesh {
    std::vector<cageform::Vec<double, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> faces;
};
/// Reads lines "v x y z" and "f a b c …" of an OBJ file, corners as "a/b/c" or numbers. Triangulates larger
/// faces as fans. Empty if the file cannot be read.
inline ObjMesh read_obj(const char* name) {
    ObjMesh mesh;
    std::ifstream file(name != nullptr ? name : "");
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "v") {
            auto& p = mesh.vertices.emplace_back();
            words >> p[0] >> p[1] >> p[2];
        } else if (word == "f") {
            std::vector<std::uint32_t> corners;
            while (words >> word) corners.push_back(std::uint32_t(std::stoul(word)) - 1);
            for (std::size_t k = 2; k < corners.size(); ++k)
                mesh.faces.push_back({corners[0], corners[k - 1], corners[k]});
        }
    }
    return mesh;
}

/// A box about the origin, its faces divided into cells: 42 vertices for 2 × 2 × 4 cells, 300 for 4 × 7 × 11.
template <class T>
cageform::TriangleMesh<T> divided_box(std::array<int, 3> cells, double edge) {
    std::map<std::array<int, 3>, std::uint32_t> numbers;
    std::vector<cageform::Vec<double, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> faces;
    const auto vertex = [&](const std::array<int, 3>& at) {
        const auto [found, added] = numbers.insert({at, std::uint32_t(vertices.size())});
        if (added) {
            vertices.push_back({edge * (at[0] - 0.5 * cells[0]), edge * (at[1] - 0.5 * cells[1]),
                                edge * (at[2] - 0.5 * cells[2])});
        }
        return found->second;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int n = 0; n < 2 * cells[u] * cells[v]; ++n) {
            const bool far = n % 2 == 1;
            const auto corner = [&](int along_u, int along_v) {
                std::array<int, 3> at{};
                at[axis] = far ? cells[axis] : 0;
                at[u] = n / 2 % cells[u] + (far ? along_u : along_v);
                at[v] = n / 2 / cells[u] + (far ? along_v : along_u);
                return vertex(at);
            };
            faces.push_back({corner(0, 0), corner(1, 0), corner(1, 1)});
            faces.push_back({corner(0, 0), corner(1, 1), corner(0, 1)});
        }
    }
    return {vertices, faces};
}

/// `count` uniform points inside a cage about the origin, at least three percent from the boundary
/// (SplitMix64).
template <class Cage>
auto points_inside(const Cage& cage, std::size_t count, std::uint64_t seed) {
    const auto bounds = cageform::bounds_of(cage.vertices());
    const auto uniform = [&seed](double low, double high) {
        std::uint64_t z = (seed += 0x9E3779B97F4A7C15u);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
        return low + (high - low) * double((z ^ (z >> 31)) >> 11) * 0x1p-53;
    };
    std::vector<cageform::Vec<double, Cage::dimension>> points;
    points.reserve(count);
    while (points.size() < count) {
        cageform::Vec<double, Cage::dimension> p;
        for (std::size_t k = 0; k < Cage::dimension; ++k) p[k] = uniform(bounds.lower[k], bounds.upper[k]);
        if (cageform::locate(cage, (1 / 0.97) * p, 0.0) == cageform::PointState::inside) points.push_back(p);
    }
    return points;
}
inline std::vector<Point> points_inside(const std::vector<Point>& vertices, std::size_t count) {
    return points_inside(cageform::Polygon<double>(vertices), count, 1);
}
/// A vase with 112 vertices: 98 planar quadrilaterals in seven rings, floor and lid with 14 corners.
template <class T>
cageform::PolyhedralMesh<T> vase112() {
    constexpr std::uint32_t rings = 8, around = 14;
    std::vector<cageform::Vec<double, 3>> vertices;
    std::vector<std::vector<std::uint32_t>> faces(2);
    for (std::uint32_t i = 0; i < rings; ++i) {
        const double z = 3.0 * i / (rings - 1), r = 1 + 0.3 * std::cos(2 * z);
        for (std::uint32_t j = 0; j < around; ++j) {
            const double phi = 2 * std::numbers::pi * j / around;
            vertices.push_back({r * std::cos(phi), r * std::sin(phi), z});
            const std::uint32_t next = (j + 1) % around, at = i * around;
            if (i + 1 < rings) faces.push_back({at + j, at + next, at + around + next, at + around + j});
        }
    }
    for (std::uint32_t j = 0; j < around; ++j) {
        faces[0].push_back(around - 1 - j);
        faces[1].push_back((rings - 1) * around + j);
    }
    return {vertices, faces};
}

/// Whether the vase has polygons or triangles as faces.
enum class VaseOf { polygons, triangles };
template <VaseOf of, class T>
auto vase() {
    if constexpr (of == VaseOf::polygons)
        return vase112<T>();
    else
        return vase112<T>().triangles();
}
inline std::vector<cageform::Vec<double, 3>> points_inside_vase() {
    return points_inside(vase112<double>().triangles(), 8019, 2);
}

/// The points bound to BUMPY112.
inline std::vector<cageform::Vec<double, 3>> points_inside_bumpy112() {
    return points_inside(bumpy112<double>(), 8019, 2);
}

} // namespace cageform_bench

// Harmonic weights of a point in a mesh by walks on spheres: slow, unbiased, and no code in common with the grids.
#pragma once

#include <cageform/cage/triangle_mesh.hpp>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace cageform_tests {

/// Random numbers of a walk (SplitMix64; Steele, Lea, Flood 2014); any walk can be repeated alone.
class WalkNumbers {
public:
    WalkNumbers(std::uint64_t seed, std::uint64_t walk)
        : state_(mixed(seed + 0x9e3779b97f4a7c15u * (walk + 1))) {}
    double next() { return double(mixed(state_ += 0x9e3779b97f4a7c15u) >> 11) * 0x1p-53; } ///< in [0, 1)

private:
    static std::uint64_t mixed(std::uint64_t x) {
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
        return x ^ (x >> 31);
    }
    std::uint64_t state_;
};

/// The weights of all handles at a point, and the standard errors of the estimates.
struct WalkWeights {
    std::vector<double> weight, error;
};

/// Walks from a point inside to the boundary, each time to a random place of the largest sphere that is free
/// (Muller, Ann. Math. Stat. 27 (1956)). A walk ends at a millionth of the mesh's size off the boundary. The
/// weights of the nearest face, continued linearly, are a control variate: their mean is known, and next to the
/// face they explain most of the noise.
inline WalkWeights walk_on_spheres(const cageform::TriangleMesh<double>& mesh,
                                   const cageform::Vec<double, 3>& from, std::uint64_t walks,
                                   std::uint64_t seed) {
    using Point = cageform::Vec<double, 3>;
    using cageform::Facet;
    struct Near {
        std::uint32_t face = 0;
        double distance2;
        std::array<double, 3> weights{};
    };
    const auto nearest = [&](const Point& p, double most) {
        Near near{0, most * most};
        mesh.boxes().for_each_near(p, near.distance2, [&](std::uint32_t f) {
            const Facet<3> facet(mesh.faces()[f], mesh.vertices());
            const auto weights = cageform::nearest_on_facet(p, facet.corner);
            const auto way = cageform::detail::point_on_facet(weights, facet.corner) - p;
            if (dot(way, way) < near.distance2) near = {f, dot(way, way), weights};
            return near.distance2;
        });
        return near;
    };
    const double size = bounds_of(mesh.vertices()).diagonal(), enough = 1e-6 * size;
    const auto first = nearest(from, size);
    const Facet<3> face(mesh.faces()[first.face], mesh.vertices());
    const auto u = face.corner[1] - face.corner[0], v = face.corner[2] - face.corner[0], n = cross(u, v);
    const auto linear = [&](const Point& p) {
        const auto q = p - face.corner[0];
        const double b = dot(cross(q, v), n) / dot(n, n), c = dot(cross(u, q), n) / dot(n, n);
        return std::array<double, 3>{1 - b - c, b, c};
    };
    std::vector<double> sum(mesh.size()), squares(mesh.size());
    std::array<double, 3> off_sum{}, off_squares{}, products{};
    const auto here = linear(from);
    for (std::uint64_t walk = 0; walk < walks; ++walk) {
        WalkNumbers numbers(seed, walk);
        Point p = from;
        Near near = first;
        while (near.distance2 > enough * enough) {
            const double r = std::sqrt(near.distance2), z = 2 * numbers.next() - 1;
            const double turn = 2 * std::numbers::pi * numbers.next(), across = std::sqrt(1 - z * z);
            p = p + r * Point{across * std::cos(turn), across * std::sin(turn), z};
            near = nearest(p, 2.001 * r);
        }
        const auto off = linear(p);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t handle = mesh.faces()[near.face][k];
            sum[handle] += near.weights[k];
            squares[handle] += near.weights[k] * near.weights[k];
            off_sum[k] += off[k] - here[k];
            off_squares[k] += (off[k] - here[k]) * (off[k] - here[k]);
            for (std::size_t l = 0; l < 3; ++l)
                products[l] += handle == face.vertex[l] ? near.weights[k] * (off[l] - here[l]) : 0.0;
        }
    }
    WalkWeights found{std::vector<double>(mesh.size()), std::vector<double>(mesh.size())};
    const double all = double(walks);
    for (std::size_t i = 0; i < mesh.size(); ++i) {
        found.weight[i] = sum[i] / all;
        found.error[i] = std::sqrt((squares[i] / all - found.weight[i] * found.weight[i]) / all);
    }
    for (std::size_t k = 0; k < 3; ++k) {
        double &weight = found.weight[face.vertex[k]], &error = found.error[face.vertex[k]];
        const double together = products[k] / all - weight * off_sum[k] / all,
                     variance = off_squares[k] / all - off_sum[k] / all * (off_sum[k] / all);
        if (!(variance > 0)) continue;
        weight -= together / variance * off_sum[k] / all;
        error = std::sqrt((std::max)(0.0, error * error - together * together / variance / all));
    }
    return found;
}

/// Points below random faces of a mesh, between 0.05 and 3 altitudes of the face deep.
inline std::vector<cageform::Vec<double, 3>> points_below_faces(const cageform::TriangleMesh<double>& mesh,
                                                                std::size_t count, std::uint64_t seed) {
    std::vector<cageform::Vec<double, 3>> points;
    for (std::uint64_t n = 0; points.size() < count; ++n) {
        WalkNumbers numbers(seed, n);
        const auto f = std::size_t(numbers.next() * double(mesh.faces().size()));
        const cageform::Facet<3> face(mesh.faces()[f], mesh.vertices());
        const auto& [a, b, c] = face.corner;
        const double s = std::sqrt(numbers.next()), t = numbers.next();
        const auto normal = cross(b - a, c - a);
        const double area = std::sqrt(dot(normal, normal));
        const double longest =
            std::sqrt((std::max)({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)}));
        const double depth = area / longest * 0.05 * std::pow(60, numbers.next());
        const auto p = (1 - s) * a + (s * (1 - t)) * b + (s * t) * c - (depth / area) * normal;
        if (locate(mesh, p, 1e-9) != cageform::PointState::inside) continue;
        cageform::Vec<double, 3> foot;
        (void)nearest_boundary_value(mesh, p, foot);
        if (dot(foot - p, foot - p) >= 0.25 * depth * depth) points.push_back(p); // else another face is near
    }
    return points;
}
/// Points anywhere inside a mesh.
inline std::vector<cageform::Vec<double, 3>> points_anywhere(const cageform::TriangleMesh<double>& mesh,
                                                             std::size_t count, std::uint64_t seed) {
    std::vector<cageform::Vec<double, 3>> points;
    const auto bounds = bounds_of(mesh.vertices());
    for (std::uint64_t n = 0; points.size() < count; ++n) {
        WalkNumbers numbers(seed, n);
        cageform::Vec<double, 3> p;
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = bounds.lower[k] + numbers.next() * (bounds.upper[k] - bounds.lower[k]);
        if (locate(mesh, p, 1e-9) == cageform::PointState::inside) points.push_back(p);
    }
    return points;
}

} // namespace cageform_tests

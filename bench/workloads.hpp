// Cages and points of the benchmarks, from formulas and seeds, so that other libraries can be fed the same.
#pragma once

#include <cageform/cage/inside.hpp>

#include <cstdint>
#include <numbers>
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

/// `count` points inside, uniform, three percent away from the boundary (SplitMix64, seed 1).
inline std::vector<Point> points_inside(const std::vector<Point>& vertices, std::size_t count) {
    const cageform::Polygon<double> polygon(vertices);
    const auto bounds = cageform::bounds_of(polygon.vertices());
    std::uint64_t state = 1;
    const auto uniform = [&state](double low, double high) {
        std::uint64_t z = (state += 0x9E3779B97F4A7C15u);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
        return low + (high - low) * double((z ^ (z >> 31)) >> 11) * 0x1p-53;
    };
    std::vector<Point> points;
    points.reserve(count);
    while (points.size() < count) {
        Point p;
        p[0] = uniform(bounds.lower[0], bounds.upper[0]);
        p[1] = uniform(bounds.lower[1], bounds.upper[1]);
        if (cageform::locate(polygon, (1 / 0.97) * p, 0.0) == cageform::PointState::inside)
            points.push_back(p);
    }
    return points;
}

} // namespace cageform_bench

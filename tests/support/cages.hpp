// Random and named cages and points for the tests. Everything follows from a seed, on every machine.
#pragma once

#include <cageform/cage/polygon.hpp>

#include <cstdint>
#include <numbers>
#include <vector>

namespace cageform_tests {

using cageform::Vec;

/// SplitMix64 (Steele, Lea, Flood 2014): the same numbers with every standard library.
class Random {
public:
    explicit Random(std::uint64_t seed)
        : state_(seed * 0x9E3779B97F4A7C15u + 1) {}

    std::uint64_t bits() {
        std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
        return z ^ (z >> 31);
    }
    double uniform(double low, double high) { return low + (high - low) * double(bits() >> 11) * 0x1p-53; }
    std::size_t below(std::size_t n) { return std::size_t(bits() % n); }

private:
    std::uint64_t state_;
};

template <class T>
using Points2 = std::vector<Vec<T, 2>>;

/// A star-shaped polygon of 3 to 40 vertices, concave as a rule, clockwise for every other seed, moved,
/// turned and scaled (10^-3 … 10^3).
template <class T>
Points2<T> random_star(std::uint64_t seed) {
    Random random(seed);
    const std::size_t count = 3 + random.below(38);
    const double scale = std::pow(10.0, random.uniform(-3, 3));
    const Vec<double, 2> centre{random.uniform(-2, 2) * scale, random.uniform(-2, 2) * scale};
    const double turn = random.uniform(0, 2 * std::numbers::pi);
    Points2<T> vertices(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double jitter = random.uniform(-0.3, 0.3);
        const double angle = turn + 2 * std::numbers::pi * (double(i) + jitter) / double(count);
        const double radius = scale * random.uniform(0.3, 1.0);
        vertices[seed % 2 == 0 ? i : count - 1 - i] = {T(centre[0] + radius * std::cos(angle)),
                                                       T(centre[1] + radius * std::sin(angle))};
    }
    return vertices;
}

/// A random point that is inside the polygon and farther from its boundary than `clearance` diagonals.
template <class T>
Vec<T, 2> random_inside(const cageform::Polygon<T>& polygon, Random& random, double clearance = 1e-3) {
    const auto bounds = cageform::bounds_of(polygon.vertices());
    for (;;) {
        const Vec<T, 2> p{T(random.uniform(bounds.lower[0], bounds.upper[0])),
                          T(random.uniform(bounds.lower[1], bounds.upper[1]))};
        if (cageform::locate(polygon, p, T(0)) == cageform::PointState::inside &&
            cageform::nearest_on_boundary(polygon, p).distance > clearance * bounds.diagonal()) {
            return p;
        }
    }
}

} // namespace cageform_tests

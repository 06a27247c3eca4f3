// Random poses by pins of moderate strength, for figures that the defaults of a PoseSolver were not chosen on.
#pragma once

#include "pins.hpp"

namespace cageform_tests {

/// Pins far from each other in a figure's inside, and where they are to go.
template <std::size_t D>
struct RandomPins {
    Places<D> pins, targets;
};

/// Picks pins among samples one after the other, each the farthest from those before, and moves about half of
/// them by up to `strength` of the figure's size, and by at most half the way to the next pin.
template <class T, std::size_t D>
RandomPins<D> random_pins(const PoseSamples<T, D>& samples, Random& random, double strength) {
    RandomPins<D> made;
    const auto distance = [](const Vec<double, D>& a, const Vec<double, D>& b) {
        return std::sqrt(dot(a - b, a - b));
    };
    std::vector<double> away(samples.points.size(), std::numeric_limits<double>::infinity());
    const std::size_t count = 4 + random.below(4);
    for (std::size_t next = random.below(away.size()); made.pins.size() < count;) {
        made.pins.push_back(cageform::vec_cast<double>(samples.points[next]));
        next = 0;
        for (std::size_t s = 0; s < away.size(); ++s) {
            away[s] =
                std::fmin(away[s], distance(cageform::vec_cast<double>(samples.points[s]), made.pins.back()));
            if (away[s] > away[next]) next = s;
        }
    }
    made.targets = made.pins;
    for (std::size_t n = 0; n < count; ++n) {
        double reach = 2 * strength * samples.size;
        for (std::size_t m = 0; m < count; ++m) {
            if (m != n) reach = std::fmin(reach, distance(made.pins[n], made.pins[m]));
        }
        Vec<double, D> way;
        do {
            for (std::size_t k = 0; k < D; ++k) way[k] = random.uniform(-1, 1);
        } while (!(dot(way, way) <= 1));
        if (n == 0 || random.below(2) == 0) made.targets[n] = made.pins[n] + (reach / 2) * way;
    }
    return made;
}

} // namespace cageform_tests

// The singular functions at corners: harmonic, with their boundary data, and bounded.
#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/grid/corners/corner_functions.hpp>

namespace corner_functions_tests {

using cageform::grid::Corner;
using cageform_tests::Random;
using cageform_tests::Vec;

namespace {

constexpr double pi = std::numbers::pi;

/// A corner at (3, 1) of interior angle `angle`, rotated by `turn`.
Corner corner_of(double angle, double turn) {
    const Vec<double, 2> vertex{3, 1};
    const double other = turn + angle;
    const Vec<double, 2> after = vertex + Vec<double, 2>{20 * std::cos(turn), 20 * std::sin(turn)};
    const Vec<double, 2> before = vertex + Vec<double, 2>{30 * std::cos(other), 30 * std::sin(other)};
    return Corner(vertex, before, after, 20);
}
Vec<double, 2> place(double angle, double turn, double r, double part) {
    const double at = turn + part * angle;
    return {3 + r * std::cos(at), 1 + r * std::sin(at)};
}

} // namespace

TEST_CASE("corner functions vanish on the edges, except w, which is r on the edge before",
          "[grid][corners][property]") {
    const double angle =
        GENERATE(0.4, pi / 2, 2.1, pi - 1e-7, pi, pi + 1e-4, 1.5 * pi, 2 * pi - 0.02, 2 * pi - 1e-9);
    CAPTURE(angle);
    Random random(3);
    for (int n = 0; n < 50; ++n) {
        const double turn = random.uniform(-4, 4), r = 20 * std::pow(10.0, random.uniform(-6, 0));
        const auto corner = corner_of(angle, turn);
        REQUIRE(corner.count() >= 1);
        const auto after = corner.functions(place(angle, turn, r, 1e-12));
        const auto before = corner.functions(place(angle, turn, r, 1 - 1e-12));
        for (std::size_t k = 1; k <= corner.count(); ++k) {
            CHECK(std::fabs(after[k]) <= 1e-9);
            CHECK(std::fabs(before[k]) <= 1e-9);
        }
        CHECK(std::fabs(after[0]) <= 1e-6 * r);
        CHECK(std::fabs(before[0] - r) <=
              1e-6 * 20); // rounding of the angle over its distance to a multiple of π

        // The mean over a small circle is the value at its centre.
        const double part = random.uniform(0.2, 0.8);
        const auto middle = place(angle, turn, r, part);
        const auto value = corner.functions(middle);
        const double small = 0.05 * r * std::min(1.0, angle);
        std::array<double, Corner::most + 1> sum{};
        constexpr int steps = 24;
        for (int i = 0; i < steps; ++i) {
            const double at = 2 * pi * i / steps;
            const auto f = corner.functions(middle + small * Vec<double, 2>{std::cos(at), std::sin(at)});
            for (std::size_t k = 0; k < f.size(); ++k) sum[k] += f[k] / steps;
        }
        for (std::size_t k = 0; k <= corner.count(); ++k) {
            CAPTURE(k);
            CHECK(std::isfinite(value[k]));
            CHECK(std::fabs(sum[k] - value[k]) <= 1e-7 * (k == 0 ? 20 : 1));
        }
    }
}

} // namespace corner_functions_tests

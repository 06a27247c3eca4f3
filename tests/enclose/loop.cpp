// Internal steps of 2D cages: relaxation and insertion of vertices.

#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/enclose/plane/relax_loop.hpp>

namespace loop_tests {

using namespace cageform;
using namespace cageform_tests;
using Point = Vec<double, 2>;

namespace {

/// Distances from a disc of radius 0.5, which includes the margin.
detail::DistanceLattice<2> lattice_of_disc() {
    detail::DistanceLattice<2> lattice({-2, -2}, 0.05, {81, 81}, 4);
    for (std::size_t node = 0; node < lattice.size(); ++node)
        lattice[node] = float(detail::length(lattice.position(node)) - 0.5);
    return lattice;
}

} // namespace

TEST_CASE("relaxed loops are tighter and more even, and clear of the figure", "[enclose][property]") {
    const auto lattice = lattice_of_disc();
    const detail::Obstacles obstacles(lattice, 0.05, {{-2, -2}, {2, 2}});
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        Random random(seed);
        const bool half = seed % 3 == 0;
        const std::size_t count = 8 + random.below(8);
        detail::CageLoop loop{{}, half};
        const double whole = half ? std::numbers::pi : 2 * std::numbers::pi;
        for (std::size_t k = 0; k < count; ++k) {
            const double angle = whole * double(k) / double(half ? count - 1 : count);
            const double radius = random.uniform(0.9, 1.4);
            loop.points.push_back({radius * std::sin(angle), -radius * std::cos(angle)});
        }
        if (half) loop.points.front()[0] = loop.points.back()[0] = 0;
        CAPTURE(seed, half, count);
        const detail::LoopEnergy energy(loop, loop.whole_size(), 1);
        const double area = detail::signed_area(loop.points), before = energy.of(loop);
        REQUIRE(area > 0);
        detail::LoopRelaxation(energy, obstacles).relax(loop, 30);
        CHECK(loop.size() == count);
        CHECK(energy.of(loop) < 0.7 * before);
        CHECK(detail::signed_area(loop.points) < 0.6 * area);
        for (std::size_t i = 0; i < loop.edge_count(); ++i) // half a spacing: the resolution of the lattice
            CHECK(detail::segment_distance(Point{}, Point{}, loop.points[i], loop.points[loop.next(i)]) >=
                  0.475);
        if (half) CHECK((loop.points.front()[0] == 0 && loop.points.back()[0] == 0));
    }
}

TEST_CASE("an edge is split opposite to a vertex close across the inside, otherwise in the middle",
          "[enclose]") {
    const auto lattice = lattice_of_disc();
    const detail::Obstacles obstacles(lattice, 0.05, {{-2, -2}, {2, 2}});
    const auto split = [&](const std::vector<Point>& corners) {
        detail::CageLoop loop{corners, false};
        const detail::LoopEnergy energy(loop, loop.size(), 1);
        detail::LoopRelaxation(energy, obstacles).insert(loop, loop.size() + 1);
        for (std::size_t i = 0; i < loop.size(); ++i) { // the new vertex
            if (i == corners.size() || loop.points[i] != corners[i]) return loop.points[i];
        }
        return Point{};
    };
    // A limb of 4 × 0.5 whose upper side is longest.
    CHECK(detail::length(split({{0, 0}, {2.2, 0}, {4, 0}, {4, 0.5}, {0, 0.5}}) - Point{2.2, 0.5}) <= 1e-12);
    CHECK(detail::length(split({{0, 0}, {0.4, 0}, {4, 0}, {4, 0.5}, {0, 0.5}}) - Point{2, 0.5}) <= 1e-12);
    // Takes the nearer of two vertices; ignores vertices hidden by an edge.
    CHECK(detail::length(split({{0, 0}, {1.6, 0}, {2.5, 0.2}, {4, 0}, {4, 0.5}, {0, 0.5}}) -
                         Point{2.5, 0.5}) <= 1e-12);
    CHECK(detail::length(split({{0, -3}, {1.9, -3}, {4, -3}, {4, 0.5}, {0, 0.5}}) - Point{2, 0.5}) <= 1e-12);
    CHECK(detail::length(split({{0, 0}, {4, 0}, {4, 0.5}, {0, 0.5}}) - Point{2, 0}) <= 1e-12);
}

} // namespace loop_tests

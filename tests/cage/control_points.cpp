// Control points from a figure and around it.
#include "catch.hpp"
#include "support/cages.hpp"

#include <cageform/cage/control_points.hpp>

#include <array>
#include <set>

namespace control_points_tests {

using namespace cageform_tests;
using cageform::sites_with_figure_points;
using cageform::Status;
using cageform::surround;
using cageform::SurroundSites;

namespace {

template <class T, std::size_t D>
std::vector<Vec<T, D>> random_places(std::size_t count, Random& random) {
    std::vector<Vec<T, D>> places(count);
    for (auto& p : places) {
        for (std::size_t k = 0; k < D; ++k) p[k] = T(random.uniform(-5, 7));
    }
    return places;
}

template <class T, std::size_t D>
void check_surround(std::uint64_t seed) {
    CAPTURE(seed, D);
    Random random(seed);
    const auto points = random_places<T, D>(30, random);
    const double margin = random.uniform(0.01, 2);
    const auto box = cageform::bounds_of(std::span<const Vec<T, D>>(points));
    for (const auto kind : {SurroundSites::corners, SurroundSites::lattice}) {
        const auto [sites, status] = surround(points, {margin, kind});
        REQUIRE(status == Status::ok);
        CHECK(sites.size() == (kind == SurroundSites::corners ? 1u << D : D == 2 ? 8u : 26u));
        std::set<std::array<T, D>> different;
        const auto outer = cageform::bounds_of(std::span<const Vec<T, D>>(sites));
        for (std::size_t k = 0; k < D; ++k) { // each side at the given distance
            const double distance = margin * double(box.diagonal());
            CHECK(double(box.lower[k] - outer.lower[k]) == Approx(distance).epsilon(1e-4));
            CHECK(double(outer.upper[k] - box.upper[k]) == Approx(distance).epsilon(1e-4));
        }
        for (const auto& site : sites) {
            bool on_side = false;
            std::array<T, D> numbers;
            for (std::size_t k = 0; k < D; ++k) {
                on_side = on_side || site[k] == outer.lower[k] || site[k] == outer.upper[k];
                numbers[k] = site[k];
            }
            CHECK(on_side);
            different.insert(numbers);
        }
        CHECK(different.size() == sites.size());
    }
}

} // namespace

TEMPLATE_TEST_CASE("surround puts sites on the sides of a box around all points", "[cage][control_points]",
                   CAGEFORM_SCALARS) {
    const auto seed = std::uint64_t(GENERATE(range(0, 10)));
    check_surround<TestType, 2>(seed);
    check_surround<TestType, 3>(seed);
}

TEST_CASE("surround refuses points without a box", "[cage][control_points][status]") {
    using Points = std::vector<Vec<double, 3>>;
    CHECK(surround(Points{}).status() == Status::too_few_vertices);
    CHECK(surround(Points{{1, 2, 3}, {1, 2, 3}}).status() == Status::cage_has_no_volume);
    CHECK(surround(std::vector<Vec<double, 2>>{{1, 2}}).status() == Status::cage_has_no_area);
    CHECK(surround(Points{{1, 2, 3}, {1, std::nan(""), 3}}).status() == Status::vertex_not_finite);
    for (const double margin : {0.0, -1.0, std::nan(""), HUGE_VAL})
        CHECK(surround(Points{{1, 2, 3}, {2, 3, 4}}, {margin}).status() == Status::radius_not_positive);
    const float far = 3e38f;
    CHECK(surround(std::vector<Vec<float, 2>>{{-far, 0}, {far, 0}}, {1.0}).status() ==
          Status::value_not_finite);
    const auto flat =
        surround(Points{{0, 0, 1}, {3, 4, 1}}, {0.1}); // planar points get the margin across the plane too
    REQUIRE(flat.status() == Status::ok);
    CHECK(flat.value.front()[2] == Approx(0.5));
    CHECK(flat.value.back()[2] == Approx(1.5));
}

TEMPLATE_TEST_CASE("figure points become sites once and have handles", "[cage][control_points]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = std::uint64_t(GENERATE(range(0, 20)));
    CAPTURE(seed);
    Random random(seed);
    const auto sites = random_places<T, 3>(20, random);
    auto figure = random_places<T, 3>(50, random);
    figure[7] = sites[4];
    figure[8] = sites[4];
    figure[8][0] += T(4) * cageform::epsilon<T> * T(5); // coincides within rounding
    figure[9] = figure[3];
    const std::vector<std::size_t> indices{3, 7, 9, 8, 3, 20};
    const auto result = sites_with_figure_points(sites, figure, indices);
    REQUIRE(result.status() == Status::ok);
    const auto& [all, handles] = result.value;
    CHECK(all.size() == 22); // one site each for figure points 3 and 20
    CHECK(std::equal(sites.begin(), sites.end(), all.begin()));
    CHECK(handles == std::vector<std::uint32_t>{20, 4, 20, 4, 20, 21});
    CHECK(all[20] == figure[3]);
    CHECK(all[21] == figure[20]);
}

TEST_CASE("figure points out of range or not finite are refused", "[cage][control_points][status]") {
    const std::vector<Vec<double, 2>> sites{{0, 0}, {1, 0}}, figure{{2, 2}, {std::nan(""), 0}};
    const auto status = [&](std::size_t index) {
        const std::array<std::size_t, 1> indices{index};
        const auto result = sites_with_figure_points(sites, figure, indices);
        if (result.status() != Status::ok)
            CHECK((result.value.sites.empty() && result.value.handles.empty()));
        return result.status();
    };
    CHECK(status(0) == Status::ok);
    CHECK(status(1) == Status::vertex_not_finite);
    CHECK(status(2) == Status::index_out_of_range);
}

} // namespace control_points_tests

// Means over rays and over Brownian paths are the coordinates that the documentation states.
#include "tables/paths.hpp"

#include "catch.hpp"
#include "support/cages.hpp"
#include "support/larger.hpp"
#include "support/oracle.hpp"

namespace path_tests {

using namespace cageform_tests;
using namespace cageform_sources;

std::vector<std::vector<Point2>> loops_of(const Oracle& oracle) {
    std::vector<std::vector<Point2>> loops;
    std::size_t first = 0;
    for (const std::size_t size : oracle.loop_sizes) {
        auto& loop = loops.emplace_back();
        for (std::size_t k = 0; k < size; ++k)
            loop.push_back({oracle.vertices[first + k][0], oracle.vertices[first + k][1]});
        first += size;
    }
    return loops;
}

TEST_CASE("means over rays are mean value coordinates", "[examples][paths][oracle]") {
    for (const char* name : {"meanvalue2d_l_shape", "meanvalue2d_star", "meanvalue2d_square_square_hole"}) {
        CAPTURE(name);
        const Oracle oracle = read_oracle(name);
        const PathBoundary boundary(loops_of(oracle));
        std::size_t compared = 0;
        for (std::size_t i = 0; i < oracle.points.size(); ++i) {
            if (oracle.tags[i] != "inside") continue;
            const auto weights =
                weights_by_rays(boundary, {oracle.points[i][0], oracle.points[i][1]}, 20'000);
            REQUIRE(weights.size() == oracle.coordinates[i].size());
            for (std::size_t k = 0; k < weights.size(); ++k)
                CHECK(weights[k] == Approx(oracle.coordinates[i][k]).epsilon(0).margin(1e-6));
            ++compared;
        }
        CHECK(compared >= 5);
    }
    // The error of 200,000 rays stated by the reference values: at least 3e-11.
    const auto reference = read_json("fields");
    const auto& in_l = reference["rays_in_the_l"];
    std::vector<Point2> loop;
    for (const auto& p : in_l["cage"]) loop.push_back({double(p[0]), double(p[1])});
    const PathBoundary boundary(std::span(&loop, 1));
    const auto weights =
        weights_by_rays(boundary, {double(in_l["point"][0]), double(in_l["point"][1])}, 200'000);
    REQUIRE(weights.size() == in_l["mean_value"].size());
    for (std::size_t k = 0; k < weights.size(); ++k)
        CHECK(weights[k] == Approx(double(in_l["mean_value"][k])).margin(1e-10).epsilon(0));
}

TEST_CASE("the error of rays falls with the square of their number", "[examples][paths]") {
    const Oracle oracle = read_oracle("meanvalue2d_l_shape");
    const PathBoundary boundary(loops_of(oracle));
    const auto error = [&](std::size_t rays) { // the largest of all points: it varies
        double largest = 0;
        for (std::size_t i = 0; i < oracle.points.size(); ++i) {
            if (oracle.tags[i] != "inside") continue;
            const auto weights = weights_by_rays(boundary, {oracle.points[i][0], oracle.points[i][1]}, rays);
            for (std::size_t k = 0; k < weights.size(); ++k)
                largest = cageform_tests::larger(largest, std::fabs(weights[k] - oracle.coordinates[i][k]));
        }
        return largest;
    };
    CHECK(error(400) > 30 * error(4000)); // 100 in the limit
}

TEST_CASE("means over Brownian paths are harmonic coordinates", "[examples][paths][oracle]") {
    const auto seed = GENERATE(range(1u, 4u));
    CAPTURE(seed);
    const Oracle oracle = read_oracle("harmonic2d_l_shape");
    const PathBoundary boundary(loops_of(oracle));
    std::mt19937_64 random(seed);
    std::size_t compared = 0;
    for (std::size_t i = 0; i < oracle.points.size() && compared < 3; ++i) {
        if (oracle.tags[i] != "interior") continue;
        ++compared;
        const auto weights = weights_by_brownian_paths(boundary, {oracle.points[i][0], oracle.points[i][1]},
                                                       20'000, 3e-4, random);
        double sum = 0;
        for (std::size_t k = 0; k < weights.mean.size(); ++k) {
            // On the last 3e-4 of a path a hat function changes at most by its slope, 1 over the edge length.
            CHECK(std::fabs(weights.mean[k] - oracle.coordinates[i][k]) < 5 * weights.error[k] + 3e-4);
            CHECK(weights.error[k] < 0.5 / std::sqrt(20'000.0));
            sum += weights.mean[k];
        }
        CHECK(sum == Approx(1).epsilon(0).margin(1e-12));
    }
    CHECK(compared == 3);
}

TEST_CASE("a path begins at the point, stays inside and ends at the boundary",
          "[examples][paths][property]") {
    const std::vector<std::vector<Point2>> loops{{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}};
    const PathBoundary boundary(loops);
    std::mt19937_64 random(5);
    for (int n = 0; n < 50; ++n) {
        std::vector<Point2> way;
        const auto end =
            brownian_end(boundary, {0.5, 1.5}, 1e-3, 0.1, random, [&](const Point2& p) { way.push_back(p); });
        CHECK(way.front() == Point2{0.5, 1.5});
        for (std::size_t k = 1; k < way.size(); ++k) {
            const bool is_in = way[k].x > 0 && way[k].y > 0 && (way[k].x < 1 || way[k].y < 1) &&
                               way[k].x < 2 && way[k].y < 2;
            CHECK(is_in);
            CHECK(std::hypot(way[k].x - way[k - 1].x, way[k].y - way[k - 1].y) < 0.1 + 1e-12);
        }
        CHECK(end.distance < 1e-3);
    }
}

} // namespace path_tests

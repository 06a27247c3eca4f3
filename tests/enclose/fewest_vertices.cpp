// Laws of cages with a limit on their looseness.

#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/effort.hpp"

#include <cageform/enclose/detail/fewest_vertices.hpp>
#include <cageform/enclose/make_cage.hpp>
#include <cageform/enclose/make_cage_3d.hpp>

#include <algorithm>
#include <limits>
#include <vector>

namespace fewest_vertices_tests {

using namespace cageform;
using namespace cageform_tests;

/// A tree of strokes, whose fingers need vertices.
std::vector<DrawnSegment<double>> random_tree(std::uint64_t seed, double scale = 1) {
    Random random(seed);
    std::vector<Vec<double, 2>> ends{{0, 0}, {0, 8}};
    std::vector<DrawnSegment<double>> tree{{scale * ends[0], scale * ends[1], scale}};
    for (std::size_t k = 0; k < 3 + random.below(4); ++k) {
        const auto from = ends[random.below(ends.size())];
        ends.push_back(from + Vec<double, 2>{random.uniform(-6, 6), random.uniform(-6, 6)});
        tree.push_back({scale * from, scale * ends.back(), scale * 0.5});
    }
    return tree;
}

struct Soup {
    std::vector<Vec<double, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> faces;
};

/// A chain of faces; each shares a vertex with an earlier one.
Soup random_soup(std::uint64_t seed, double scale = 1) {
    Random random(seed);
    Soup soup;
    const auto place = [&] {
        return scale * Vec<double, 3>{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
    };
    soup.vertices = {place(), place(), place()};
    soup.faces = {{0, 1, 2}};
    for (std::uint32_t n = 3; n < 11; n += 2) {
        soup.vertices.push_back(place());
        soup.vertices.push_back(place());
        soup.faces.push_back({std::uint32_t(random.below(n)), n, n + 1});
    }
    return soup;
}

/// Checks the report: the answer is within the limit, and a number at most 5 % smaller is not. `step` is the
/// granularity of vertex counts.
void check_answer(const MakeCageReport& report, double looseness, std::size_t step = 1) {
    REQUIRE(to_string(report.status) == std::string("ok"));
    CHECK(report.area <= report.tightest_area * (1 + looseness) * (1 + 1e-9));
    CHECK(report.clearance >= 0.9 * report.margin);
    REQUIRE_FALSE(report.attempts.empty());
    const auto& all = report.attempts;
    CHECK(std::is_sorted(all.begin(), all.end(),
                         [](const auto& a, const auto& b) { return a.vertices < b.vertices; }));
    const auto made = std::find_if(all.begin(), all.end(),
                                   [&](const auto& attempt) { return attempt.vertices == report.vertices; });
    REQUIRE(made != all.end());
    CHECK(std::fabs(made->excess - (report.area / report.tightest_area - 1)) <= 1e-9);
    for (const auto& attempt : all) {
        CHECK(attempt.hollow >= 0);
        if (attempt.vertices < report.vertices) CHECK(attempt.excess > looseness);
    }
    if (made == all.begin()) return; // no smaller number is possible
    const std::size_t below = std::prev(made)->vertices;
    CHECK((below + step >= report.vertices || 21 * below >= 20 * report.vertices));
}

TEST_CASE("candidate vertex counts are at most 5 % apart", "[enclose][property]") {
    const std::uint64_t seed = 4;
    CAPTURE(seed);
    Random random(seed);
    for (int round = 0; round < 50; ++round) {
        const std::size_t least = 3 + random.below(2), base = 10 + random.below(30),
                          most = least + random.below(3000);
        CAPTURE(least, base, most);
        const auto counts = detail::vertex_counts(least, base, most);
        CHECK(counts.front() == least);
        CHECK(counts.back() == most);
        for (std::size_t k = 1; k < counts.size(); ++k) {
            const std::size_t low = counts[k - 1], high = counts[k];
            CHECK((high == low + 1 || (high > low && 20 * high <= 21 * low)));
        }
        for (std::size_t n = base; n < most; n *= 2) CHECK(std::count(counts.begin(), counts.end(), n) == 1);
    }
}

TEST_CASE("deepest_hollow is the maximum over all points", "[enclose][property]") {
    const std::uint64_t seed = 9;
    CAPTURE(seed);
    Random random(seed);
    const auto place = [&] {
        return Vec<double, 3>{random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
    };
    for (int round = 0; round < 20; ++round) {
        std::vector<Vec<double, 3>> points(1 + random.below(40));
        for (auto& p : points) p = place();
        std::vector<detail::Corners<3>> facets;
        for (std::size_t k = 1 + random.below(9); k > 0; --k) facets.push_back({place(), place(), place()});
        double most = 0;
        for (const auto& p : points) {
            double least = std::numeric_limits<double>::infinity();
            for (const auto& facet : facets) least = std::min(least, detail::distance_to_facet(p, facet));
            most = std::max(most, least);
        }
        CHECK(detail::deepest_hollow<3>(points, facets) == most);
    }
}

TEST_CASE("2D: finds the fewest vertices within the limit", "[enclose][property]") {
    for (std::uint64_t seed = 0; seed < effort(6u, 2u); ++seed) {
        CAPTURE(seed);
        Random random(seed + 100);
        MakeCageOptions options;
        options.looseness = random.uniform(0.02, 0.4);
        options.margin = 0.05;
        const auto found = make_cage(random_tree(seed), options);
        check_answer(found.report, options.looseness);
        const auto scaled = make_cage(random_tree(seed, 2), options);
        CHECK(scaled.report.vertices == found.report.vertices);
        // The cage equals the cage made with this number of vertices.
        MakeCageOptions direct;
        direct.margin = options.margin;
        direct.vertices = found.report.vertices;
        const auto again = make_cage(random_tree(seed), direct);
        CHECK(std::ranges::equal(found.value.vertices(), again.value.vertices()));
        CHECK(again.report.attempts.empty());
    }
}

TEST_CASE("3D: finds the fewest vertices within the limit", "[enclose][property]") {
    for (std::uint64_t seed = 0; seed < effort(3u, 1u); ++seed) {
        CAPTURE(seed);
        Random random(seed + 200);
        MakeCageOptions options;
        options.looseness = random.uniform(0.1, 0.4);
        options.margin = 0.1;
        options.vertices = effort(300u, 60u); // upper bound
        const auto soup = random_soup(seed), twice = random_soup(seed, 2);
        const auto found = make_cage(soup.vertices, soup.faces, options);
        if (found.report.area <= found.report.tightest_area * (1 + options.looseness))
            check_answer(found.report, options.looseness);
        else // only of few
            CHECK(options.vertices < 300);
        const auto scaled = make_cage(twice.vertices, twice.faces, options);
        CHECK(scaled.report.vertices == found.report.vertices);
        MakeCageOptions direct;
        direct.margin = options.margin;
        direct.vertices = found.report.vertices;
        const auto again = make_cage(soup.vertices, soup.faces, direct);
        // Rounds stop at eight times the requested vertices, so this cage differs: over 30 seeds its volume was
        // 6 % smaller to 7 % larger.
        CHECK(again.report.vertices == found.report.vertices);
        CHECK(std::fabs(again.report.area / found.report.area - 1) <= 0.1);
    }
}

TEST_CASE("looseness works for mirrored cages and for several shells", "[enclose]") {
    const auto soup = random_soup(3);
    MakeCageOptions options;
    options.looseness = 0.3;
    options.margin = 0.15;
    options.vertices = 100;
    options.mirror = MirrorPlane{1, {}};
    check_answer(make_cage(soup.vertices, soup.faces, options).report, options.looseness, 2);
    check_answer(make_cage(random_tree(3), options).report, options.looseness, 2);
    options.mirror = {};
    options.one_cage = false;
    check_answer(make_cage(soup.vertices, soup.faces, options).report, options.looseness);
}

TEST_CASE("if no number of vertices is within the limit, the tightest cage is returned", "[enclose][error]") {
    const auto soup = random_soup(5);
    MakeCageOptions options;
    options.looseness = 1e-9;
    options.margin = 0.1;
    options.vertices = 20;
    const auto of_space = make_cage(soup.vertices, soup.faces, options).report;
    const auto of_plane = make_cage(random_tree(5), options).report;
    for (const auto& report : {of_space, of_plane}) {
        REQUIRE(to_string(report.status) == std::string("ok"));
        REQUIRE_FALSE(report.attempts.empty());
        CHECK(report.vertices <= 20);
        const double excess = report.area / report.tightest_area - 1;
        CHECK(excess > options.looseness);
        for (const auto& attempt : report.attempts) CHECK(excess <= attempt.excess + 1e-9);
    }
    options.shape = CageShape::box; // fixed number of vertices
    CHECK(make_cage(soup.vertices, soup.faces, options).report.attempts.empty());
    CHECK(make_cage(random_tree(5), options).report.attempts.empty());
    for (const double none : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
        options = {.vertices = 20, .margin = 0.1, .looseness = none};
        CHECK(make_cage(random_tree(5), options).report.attempts.empty());
    }
    options.looseness = std::numeric_limits<double>::infinity();
    CHECK(make_cage(random_tree(5), options).report.vertices == 3);
}

TEST_CASE("the search for the fewest vertices reports progress and can be cancelled", "[enclose]") {
    const auto soup = random_soup(6);
    MakeCageOptions options;
    options.looseness = 0.3;
    options.margin = 0.15;
    options.vertices = 60;
    const auto stops = [](const auto& make) {
        std::vector<double> told;
        cageform::Running running;
        running.progress = [&](double done) {
            told.push_back(done);
            return true;
        };
        CHECK(make(running) == Status::ok);
        CHECK(std::is_sorted(told.begin(), told.end()));
        CHECK(told.back() == 1);
        for (const std::size_t stop : {std::size_t{0}, told.size() / 2, told.size() - 2, told.size() - 1}) {
            std::size_t calls = 0;
            running.progress = [&](double) { return calls++ < stop; };
            CHECK(make(running) == Status::cancelled);
        }
    };
    stops([&](const Running& running) { return make_cage(random_tree(6), options, running).report.status; });
    stops([&](const Running& running) {
        return make_cage(soup.vertices, soup.faces, options, running).report.status;
    });
}

} // namespace fewest_vertices_tests

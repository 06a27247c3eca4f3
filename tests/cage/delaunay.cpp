#include "catch.hpp"
#include "support/cages.hpp"

#include <cageform/cage/point_set.hpp>
#include <cageform/cage/sites/hull_facets.hpp>

#include <algorithm>
#include <set>

namespace delaunay_tests {

using namespace cageform;
using cageform_tests::Random;

namespace {

template <std::size_t D>
using Points = std::vector<Vec<double, D>>;

/// Random points; a lattice; points on a sphere; some of them on a common plane.
template <std::size_t D>
Points<D> sites_of(std::uint64_t seed) {
    Random random(seed);
    Points<D> sites;
    const std::size_t count = seed % 4 == 1 ? (D == 2 ? 36 : 64) : D + 1 + random.below(60);
    for (std::size_t i = 0; i < count; ++i) {
        Vec<double, D> p{};
        for (std::size_t k = 0; k < D; ++k) p[k] = random.uniform(-1, 1);
        if (seed % 4 == 1) {
            std::size_t rest = i;
            for (std::size_t k = 0; k < D; ++k) {
                p[k] = double(rest % (D == 2 ? 6 : 4));
                rest /= D == 2 ? 6 : 4;
            }
        }
        if (seed % 4 == 2) p = (1 / std::sqrt(dot(p, p))) * p;
        if (seed % 4 == 3 && i % 2 == 0) p[D - 1] = -1;
        sites.push_back(p);
    }
    return sites;
}

template <std::size_t D>
Delaunay<D> triangulated(const Points<D>& sites) {
    const detail::SiteLattice<D> lattice(bounds_of(std::span<const Vec<double, D>>(sites)));
    std::vector<detail::LatticePoint<D>> places;
    for (const auto& site : sites) places.push_back(lattice.position(site));
    return Delaunay<D>(places);
}

/// Neighbours refer to each other and have a common facet, no simplex is flat or inverted, no ball contains
/// a site, and every facet has two sides.
template <std::size_t D>
void check_sound(const Delaunay<D>& sites) {
    REQUIRE(!sites.empty());
    std::size_t wrong = 0;
    for (std::uint32_t s = 0; s < sites.simplices().size(); ++s) {
        const auto& simplex = sites.simplices()[s];
        for (std::size_t k = 0; k <= D; ++k) {
            const auto& next = sites.simplices()[simplex.neighbour[k]];
            wrong += next.neighbour[next.index_of_neighbour(s)] != s;
            for (std::size_t i = 0; i <= D; ++i)
                wrong += i != k && std::find(next.vertex.begin(), next.vertex.end(), simplex.vertex[i]) ==
                                       next.vertex.end();
        }
        if (simplex.is_ghost()) continue;
        wrong += detail::orientation<D>(sites.corners(simplex)) <= 0;
        for (std::uint32_t v = 0; v < sites.size(); ++v)
            wrong += detail::in_sphere<D>(sites.corners(simplex), sites.point(v)) > 0;
    }
    CHECK(wrong == 0);
}

/// The simplices, by the caller's indices.
template <std::size_t D>
std::set<std::set<std::uint32_t>> by_sites(const Delaunay<D>& sites, std::size_t count, bool reversed) {
    std::set<std::set<std::uint32_t>> all;
    for (const auto& simplex : sites.simplices()) {
        std::set<std::uint32_t> one;
        for (const std::uint32_t v : simplex.vertex) {
            if (v != Delaunay<D>::infinite)
                one.insert(reversed ? std::uint32_t(count - 1) - sites.site(v) : sites.site(v));
        }
        all.insert(one);
    }
    return all;
}

template <std::size_t D>
void check_delaunay(std::uint64_t seed) {
    CAPTURE(seed, D);
    const auto sites = sites_of<D>(seed);
    const auto delaunay = triangulated<D>(sites);
    check_sound(delaunay);
    const auto other = triangulated<D>(Points<D>(sites.rbegin(), sites.rend()));
    CHECK(by_sites(delaunay, sites.size(), false) == by_sites(other, sites.size(), true));
    // locate finds a simplex that contains the point.
    typename Delaunay<D>::Search search;
    Random random(seed);
    for (int n = 0; n < 20; ++n) {
        detail::LatticePoint<D> p;
        for (auto& x : p) x = std::int64_t(random.bits() >> 5);
        const auto& found = delaunay.simplices()[delaunay.locate(p, search)];
        for (std::size_t k = 0; k <= D; ++k) {
            if (found.is_ghost() && k < D) continue;
            std::array<detail::LatticePoint<D>, D + 1> a;
            for (std::size_t i = 0; i <= D; ++i) a[i] = i == k ? p : delaunay.point(found.vertex[i]);
            CHECK(detail::orientation<D>(a) >= (found.is_ghost() ? 1 : 0));
        }
    }
}

} // namespace

TEST_CASE("Delaunay triangulations are valid and do not depend on the order of sites",
          "[cage][delaunay][property]") {
    const auto seed = GENERATE(range(0, 16));
    check_delaunay<2>(std::uint64_t(seed));
    check_delaunay<3>(std::uint64_t(seed));
}

TEST_CASE("a Delaunay triangulation skips duplicates, and is empty if all sites are in a plane",
          "[cage][delaunay]") {
    auto sites = sites_of<3>(0);
    sites.push_back(sites[2]);
    sites.push_back(sites[0]);
    const auto delaunay = triangulated<3>(sites);
    check_sound(delaunay);
    CHECK(triangulated<3>({{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {3, 2, 1}}).empty());
    CHECK(triangulated<2>({{0, 0}, {1, 1}, {2, 2}, {5, 5}}).empty());
    CHECK(Delaunay<2>(std::vector<detail::LatticePoint<2>>{}).empty());
}

TEST_CASE("hull facets that are coplanar within rounding are merged", "[cage][delaunay]") {
    const double angle = GENERATE(0.0, 0.3, 0.7);
    Points<3> sites;
    for (std::size_t i = 0; i < 64; ++i) {
        const Vec<double, 3> p{double(i % 4), double(i / 4 % 4), double(i / 16)};
        const double c = std::cos(angle), s = std::sin(angle);
        const Vec<double, 3> q{c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
        sites.push_back({c * q[0] - s * q[2], q[1], s * q[0] + c * q[2]});
    }
    const detail::SiteLattice<3> lattice(bounds_of(std::span<const Vec<double, 3>>(sites)));
    const auto delaunay = triangulated<3>(sites);
    check_sound(delaunay);
    Points<3> at;
    for (std::uint32_t v = 0; v < delaunay.size(); ++v) at.push_back(lattice.to_extents(delaunay.point(v)));
    const detail::HullFacets<3> hull(delaunay, at, 0x1p-49);
    CHECK(hull.facets.size() == 6);
    for (const auto& facet : hull.facets) {
        CHECK(facet.vertex.size() == 16);
        for (const auto& p : at) CHECK(facet.distance(p) <= 0x1p-49);
    }
}

TEST_CASE("signs of determinants are exact near zero", "[cage][delaunay][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 40)));
    CAPTURE(seed);
    Random random(seed);
    // Points in a plane through two directions, then one step off it.
    const auto small = [&] { return std::int64_t(random.bits() >> 35) - (std::int64_t(1) << 28); };
    std::array<detail::LatticePoint<3>, 4> a{};
    for (auto& x : a[0]) x = std::int64_t(1) << 59;
    detail::LatticePoint<3> u, v;
    for (std::size_t k = 0; k < 3; ++k) {
        u[k] = small();
        v[k] = small();
    }
    for (std::size_t i = 1; i < 4; ++i) {
        const std::int64_t m = small(), n = small();
        for (std::size_t k = 0; k < 3; ++k) a[i][k] = a[0][k] + m * u[k] + n * v[k];
    }
    CHECK(detail::orientation<3>(a) == 0);
    const auto normal = cross(detail::to_double<3>(detail::difference<3>(a[1], a[0])),
                              detail::to_double<3>(detail::difference<3>(a[2], a[0])));
    auto off = a;
    off[3][0] += 1;
    CHECK(detail::orientation<3>(off) == (normal[0] > 0 ? 1 : -1));
    off[3][0] -= 2;
    CHECK(detail::orientation<3>(off) == (normal[0] > 0 ? -1 : 1));
    // Corners of a box are on a sphere; a step inwards or outwards is not.
    const std::int64_t x = std::int64_t(random.bits() >> 6), y = std::int64_t(random.bits() >> 6),
                       z = std::int64_t(random.bits() >> 6);
    const std::array<detail::LatticePoint<3>, 4> box{{{0, 0, 0}, {x, 0, 0}, {0, y, 0}, {0, 0, z}}};
    CHECK(detail::in_sphere<3>(box, {x, y, z}) == 0);
    CHECK(detail::in_sphere<3>(box, {x - 1, y, z}) > 0);
    CHECK(detail::in_sphere<3>(box, {x, y, z + 1}) < 0);
    const std::array<detail::LatticePoint<2>, 3> rectangle{{{0, 0}, {x, 0}, {0, y}}};
    CHECK(detail::in_sphere<2>(rectangle, {x, y}) == 0);
    CHECK(detail::in_sphere<2>(rectangle, {x, y - 1}) > 0);
    CHECK(detail::in_sphere<2>(rectangle, {x + 1, y}) < 0);
}

TEST_CASE("the site lattice preserves the precision of doubles", "[cage][delaunay]") {
    // Far from the origin, and close to zero in a large set.
    const detail::SiteLattice<2> far(Bounds<double, 2>{{1e9, -1e9}, {1e9 + 1, -1e9 + 1}});
    CHECK(far.position({1e9 + 0x1p-20, -1e9})[0] - far.position({1e9, -1e9})[0] == std::int64_t(1) << 39);
    const detail::SiteLattice<2> wide(Bounds<double, 2>{{-1, -1}, {1, 1}});
    CHECK(wide.position({0x1p-58, 0})[0] - wide.position({-0x1p-58, 0})[0] == 2);
    CHECK(wide.position({1, 0})[0] - wide.position({-1, 0})[0] <= std::int64_t(1) << 60);
    // Any magnitude.
    for (const double size : {1e-310, 1e-200, 1.0, 1e200, 1e308}) {
        const detail::SiteLattice<2> lattice(Bounds<double, 2>{{-size, -size}, {size, size}});
        const auto a = lattice.position({-size, -size}), b = lattice.position({size, size / 2});
        CHECK(b[0] - a[0] > std::int64_t(1) << 58);
        CHECK(b[0] - a[0] <= std::int64_t(1) << 60);
        CHECK(std::fabs(double(b[1] - a[1]) / double(b[0] - a[0]) - 0.75) <= 1e-6);
    }
}

TEST_CASE("check of a point set finds every fault", "[cage][point_set]") {
    Random random(3);
    Points<3> sites(2000);
    for (auto& p : sites) p = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    CHECK(check(PointSet(sites)).faults.empty());
    for (std::size_t i = 0; i < 100; ++i) sites.push_back(sites[7 * i] + Vec<double, 3>{1e-17, 0, 1e-16});
    const auto report = check(PointSet(sites));
    CHECK(report.status == Status::duplicate_vertices);
    std::set<std::pair<std::size_t, std::size_t>> pairs, expected;
    for (const auto& fault : report.faults) pairs.insert({fault.a, fault.b});
    for (std::size_t i = 0; i < 100; ++i) expected.insert({7 * i, 2000 + i});
    CHECK(pairs == expected);
    CHECK(check(PointSet(Points<3>(5000, {1, 2, 3}))).fault_count == 4999);
    CHECK(check(PointSet<double, 3>()).status == Status::too_few_vertices);
    for (auto& p : sites) p[1] = 3 * p[0] - p[2];
    sites.resize(2000);
    CHECK(check(PointSet(sites)).status == Status::sites_in_a_plane);
    sites[5][1] += 1e-9;
    CHECK(check(PointSet(sites)).status == Status::ok);
    sites[9][2] = std::numeric_limits<double>::infinity();
    REQUIRE(check(PointSet(sites)).faults.size() == 1);
    CHECK(check(PointSet(sites)).faults[0].a == 9);
    // At the limits of the range of double.
    for (const double size : {1e-310, 1e308}) {
        const Points<2> corners{{-size, -size}, {size, -size}, {0, size}};
        CHECK(check(PointSet(corners)).status == Status::ok);
    }
}

} // namespace delaunay_tests

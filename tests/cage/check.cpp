#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/cage/detail/facet_pairs.hpp>
#include <cageform/cage/polygon.hpp>

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <tuple>

namespace check_tests {

using cageform::CageFaultKind;
using cageform::CageReport;
using cageform::check;
using cageform::epsilon;
using cageform::Polygon;
using cageform::Status;
using cageform::Vec;
using cageform::detail::FacetPairs;
using cageform_tests::Points2;
using cageform_tests::Random;
using cageform_tests::random_star;

namespace {

using Sizes = std::vector<std::size_t>;

/// The faults of a report, regardless of their order.
using Faults = std::set<std::tuple<CageFaultKind, std::size_t, std::size_t>>;

Faults faults_of(const CageReport& report) {
    Faults faults;
    for (const auto& fault : report.faults) faults.emplace(fault.kind, fault.a, fault.b);
    CHECK(faults.size() == report.faults.size()); // no duplicates
    return faults;
}

template <class T>
void check_faults(const Points2<T>& points, const Sizes& sizes, Status status, const Faults& expected) {
    const auto report = check(Polygon<T>(points, sizes));
    CHECK(report.status == status);
    CHECK(faults_of(report) == expected);
}

template <class T>
Points2<T> joined(std::initializer_list<Points2<T>> loops) {
    Points2<T> all;
    for (const auto& loop : loops) all.insert(all.end(), loop.begin(), loop.end());
    return all;
}

template <class T>
Points2<T> square(T low, T high) {
    return {{low, low}, {high, low}, {high, high}, {low, high}};
}

template <class T>
Points2<T> reversed(Points2<T> points) {
    std::reverse(points.begin(), points.end());
    return points;
}

template <class T>
Points2<T> transformed(Points2<T> points, T scale, Vec<T, 2> move) {
    for (auto& p : points) p = scale * p + move;
    return points;
}

// ---- polygons with small integer coordinates, with an exact reference ---------------------------

using Corner = std::array<int, 2>;

int turn(const Corner& a, const Corner& b, const Corner& c) {
    const int area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    return (area > 0) - (area < 0);
}

bool on_segment(const Corner& p, const Corner& a, const Corner& b) {
    return turn(a, b, p) == 0 && std::min(a[0], b[0]) <= p[0] && p[0] <= std::max(a[0], b[0]) &&
           std::min(a[1], b[1]) <= p[1] && p[1] <= std::max(a[1], b[1]);
}

bool meet(const Corner& a, const Corner& b, const Corner& c, const Corner& d) {
    return (turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0) || on_segment(a, c, d) ||
           on_segment(b, c, d) || on_segment(c, a, b) || on_segment(d, a, b);
}

struct IntegerPolygon {
    std::vector<Corner> corners;
    Sizes sizes;

    template <class T>
    Points2<T> points() const {
        Points2<T> result;
        for (const auto& c : corners) result.push_back({T(c[0]), T(c[1])});
        return result;
    }
};

IntegerPolygon random_integer_polygon(Random& random) {
    IntegerPolygon polygon;
    const int side = int(3 + random.below(14));
    for (std::size_t loops = 1 + random.below(2); loops > 0; --loops)
        polygon.sizes.push_back(3 + random.below(5));
    for (const std::size_t size : polygon.sizes) {
        for (std::size_t i = 0; i < size; ++i)
            polygon.corners.push_back(
                {int(random.below(std::size_t(side))), int(random.below(std::size_t(side)))});
    }
    return polygon;
}

struct Edge {
    std::size_t i, j;
};

/// The warnings of a polygon without faults.
Faults warnings_of(const IntegerPolygon& polygon, const std::vector<Edge>& edges) {
    Faults faults;
    const auto& p = polygon.corners;
    std::size_t begin = 0;
    for (std::size_t k = 0; k < polygon.sizes.size(); begin += polygon.sizes[k++]) {
        const std::size_t size = polygon.sizes[k];
        int area = 0;
        for (std::size_t n = 0; n < size; ++n) {
            const auto& a = p[begin + (n + size - 1) % size];
            const auto& b = p[begin + n];
            const auto& c = p[begin + (n + 1) % size];
            if (turn(a, b, c) == 0) faults.emplace(CageFaultKind::collinear_vertex, begin + n, 0);
            area += b[0] * c[1] - b[1] * c[0];
        }
        // For at most two loops: a loop is a hole if the other one winds around its first vertex.
        double winding = 0;
        for (const Edge& e : edges) {
            if (e.i >= begin && e.i < begin + size) continue;
            const Vec<double, 2> u{double(p[e.i][0] - p[begin][0]), double(p[e.i][1] - p[begin][1])};
            const Vec<double, 2> v{double(p[e.j][0] - p[begin][0]), double(p[e.j][1] - p[begin][1])};
            winding += std::atan2(cross(u, v), dot(u, v));
        }
        if ((area < 0) != (std::fabs(winding) > 1))
            faults.emplace(CageFaultKind::loop_orientation_reversed, k, 0);
    }
    return faults;
}

/// Tests every pair of edges and every vertex in integers.
Faults brute_force(const IntegerPolygon& polygon) {
    Faults faults;
    std::vector<Edge> edges;
    std::size_t begin = 0;
    const auto& p = polygon.corners;
    for (std::size_t k = 0; k < polygon.sizes.size(); begin += polygon.sizes[k++]) {
        bool flat = true;
        for (std::size_t n = 0; n < polygon.sizes[k]; ++n) {
            const std::size_t i = begin + n;
            const std::size_t j = begin + (n + 1) % polygon.sizes[k];
            edges.push_back({i, j});
            if (p[i] == p[j]) faults.emplace(CageFaultKind::duplicate_vertices, i, j);
            for (std::size_t m = 0; m < n; ++m) flat = flat && turn(p[begin], p[begin + m], p[i]) == 0;
        }
        if (flat) faults.emplace(CageFaultKind::no_area, k, 0);
    }
    if (!faults.empty()) return faults;

    for (std::size_t m = 0; m < edges.size(); ++m) {
        for (std::size_t n = m + 1; n < edges.size(); ++n) {
            const Edge e = edges[m];
            const Edge f = edges[n];
            bool touch;
            if (e.j == f.i) {
                touch = on_segment(p[e.i], p[f.i], p[f.j]) || on_segment(p[f.j], p[e.i], p[e.j]);
            } else if (f.j == e.i) {
                touch = on_segment(p[f.i], p[e.i], p[e.j]) || on_segment(p[e.j], p[f.i], p[f.j]);
            } else {
                touch = meet(p[e.i], p[e.j], p[f.i], p[f.j]);
            }
            if (touch) faults.emplace(CageFaultKind::edges_cross, e.i, f.i);
        }
    }
    if (!faults.empty()) return faults;

    return warnings_of(polygon, edges);
}

/// Facets of all sizes: scattered, slivers at a few common points, parallel slivers.
template <std::size_t D>
std::vector<cageform::Facet<D>> random_facets(Random& random, std::vector<std::uint32_t>& groups) {
    std::vector<Vec<double, D>> vertices;
    const auto place = [&](const Vec<double, D>& about, double size) {
        Vec<double, D> p = about;
        for (std::size_t k = 0; k < D; ++k) p[k] += size * random.uniform(-1, 1);
        return std::uint32_t((vertices.push_back(p), vertices.size() - 1));
    };
    const Vec<double, D> zero{};
    std::vector<std::array<std::uint32_t, D>> corners;
    const std::size_t scattered = random.below(80), fans = random.below(4);
    const double flat = random.below(2) == 0 ? 0 : 1;
    for (std::size_t n = 0; n < scattered; ++n) {
        const auto first = place(zero, 1);
        const double size = std::pow(10.0, random.uniform(-3, 0.5));
        std::array<std::uint32_t, D> facet{first};
        for (std::size_t k = 1; k < D; ++k) facet[k] = place(vertices[first], size);
        corners.push_back(facet);
        groups.push_back(FacetPairs<D>::no_group);
    }
    for (std::uint32_t fan = 0; fan < fans; ++fan) {
        const std::uint32_t apex = place(zero, 1);
        for (std::size_t n = 0; n < 60; ++n) {
            std::array<std::uint32_t, D> facet{apex, place(zero, 1)};
            vertices[facet[1]][D - 1] *= flat;
            if (D == 3) facet[D - 1] = place(vertices[facet[1]], 0.01);
            corners.push_back(facet);
            groups.push_back(fan);
        }
    }
    std::vector<cageform::Facet<D>> facets;
    for (const auto& facet : corners) facets.emplace_back(facet, std::span<const Vec<double, D>>(vertices));
    return facets;
}

/// Returns the number of pairs that meet.
template <std::size_t D>
std::size_t find_as_all_pairs_do(int seed) {
    Random random{std::uint64_t(seed)};
    std::vector<std::uint32_t> groups;
    const auto facets = random_facets<D>(random, groups);
    const double margin = 1e-15;
    std::set<std::pair<std::size_t, std::size_t>> expected, found;
    const auto meet = [&](std::size_t m, std::size_t n) {
        return cageform::detail::facets_touch(facets[m], facets[n], margin);
    };
    for (std::size_t m = 0; m < facets.size(); ++m) {
        for (std::size_t n = m + 1; n < facets.size(); ++n) {
            const bool in_group = groups[m] == groups[n] && groups[m] != FacetPairs<D>::no_group;
            if (!in_group && meet(m, n)) expected.insert({m, n});
        }
    }
    std::size_t calls = 0;
    FacetPairs<D>(facets, groups, margin).for_each(meet, [&](std::size_t m, std::size_t n) {
        found.insert({m, n});
        ++calls;
    });
    CHECK(found == expected);
    CHECK(calls == found.size()); // each pair once
    return calls;
}

} // namespace

TEST_CASE("every fault kind has a text and a status", "[cage][check]") {
    std::set<std::string> names;
    for (unsigned value = 0; value <= unsigned(CageFaultKind::loop_orientation_reversed); ++value) {
        CAPTURE(value);
        const auto kind = CageFaultKind(value);
        const std::string name = to_string(kind);
        CHECK(!name.empty());
        CHECK(name != "unknown fault");
        CHECK(names.insert(name).second);
        const bool warning = kind == CageFaultKind::collinear_vertex ||
                             kind == CageFaultKind::vertex_unused || kind == CageFaultKind::gap_closed ||
                             kind == CageFaultKind::face_fanned || kind == CageFaultKind::edge_has_cusp ||
                             kind == CageFaultKind::shell_orientation_reversed ||
                             kind == CageFaultKind::loop_orientation_reversed;
        CHECK((status_of(kind) == Status::ok) == warning);
    }
    CHECK(to_string(CageFaultKind(unsigned(CageFaultKind::loop_orientation_reversed) + 1)) ==
          std::string("unknown fault"));
}

TEST_CASE("the status of a report is that of its first fault", "[cage][check]") {
    CageReport report;
    CHECK(report.status == Status::ok);
    report.add(CageFaultKind::collinear_vertex, 3);
    CHECK(report.status == Status::ok);
    report.add(CageFaultKind::edges_cross, 1, 2);
    CHECK(report.status == Status::cage_self_crossing);
    report.add(CageFaultKind::no_area, 0);
    CHECK(report.status == Status::cage_self_crossing);
    REQUIRE(report.faults.size() == 3);
    CHECK((report.faults[1].a == 1 && report.faults[1].b == 2));
}

// ---- each fault alone --------------------------------------------------------------------------

TEMPLATE_TEST_CASE("check: too few vertices", "[cage][check]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto kind = CageFaultKind::too_few_vertices;
    const auto status = Status::too_few_vertices;
    const auto outer = square<T>(0, 4);
    CHECK(faults_of(check(Polygon<T>())) == Faults{{kind, 0, 0}});
    check_faults<T>({}, {}, status, {{kind, 0, 0}});
    check_faults<T>({{1, 1}}, {}, status, {{kind, 0, 1}});
    check_faults<T>({{1, 1}, {2, 2}}, {}, status, {{kind, 0, 2}});
    check_faults<T>(joined<T>({outer, {{1, 1}, {2, 2}}}), {4, 2}, status, {{kind, 1, 2}});
    check_faults<T>(outer, {4, 0}, status, {{kind, 1, 0}});
}

TEMPLATE_TEST_CASE("check: loop sizes that do not add up", "[cage][check]", CAGEFORM_SCALARS) {
    const auto kind = CageFaultKind::loops_do_not_match;
    const auto status = Status::loops_do_not_match;
    const auto outer = square<TestType>(0, 4);
    check_faults<TestType>(outer, {3}, status, {{kind, 3, 4}});
    check_faults<TestType>(outer, {3, 3}, status, {{kind, 6, 4}});
    check_faults<TestType>({}, {3}, status, {{kind, 3, 0}});
    // Sizes whose sum is right only modulo 2^64 are refused.
    const std::size_t most = std::numeric_limits<std::size_t>::max();
    CHECK(check(Polygon<TestType>(outer, Sizes{5, most})).status == status);
}

TEMPLATE_TEST_CASE("check: a vertex that is not finite", "[cage][check]", CAGEFORM_SCALARS) {
    using limits = std::numeric_limits<TestType>;
    for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t axis = 0; axis < 2; ++axis) {
            for (const TestType x : {limits::quiet_NaN(), limits::infinity(), -limits::infinity()}) {
                CAPTURE(i, axis, x);
                auto points = square<TestType>(0, 4);
                points[i][axis] = x;
                check_faults<TestType>(points, {}, Status::vertex_not_finite,
                                       {{CageFaultKind::vertex_not_finite, i, 0}});
            }
        }
    }
}

TEMPLATE_TEST_CASE("check: consecutive vertices that coincide", "[cage][check]", CAGEFORM_SCALARS) {
    for (std::size_t i = 0; i < 4; ++i) {
        for (const TestType apart : {TestType(0), 4 * epsilon<TestType>}) {
            CAPTURE(i, apart);
            auto points = square<TestType>(0, 4);
            auto copy = points[i];
            copy[0] += apart;
            points.insert(points.begin() + std::ptrdiff_t(i), copy);
            check_faults<TestType>(points, {}, Status::duplicate_vertices,
                                   {{CageFaultKind::duplicate_vertices, i, i + 1}});
        }
    }
    auto closed = square<TestType>(0, 4);
    closed.push_back(closed.front()); // some file formats repeat the first vertex
    check_faults<TestType>(closed, {}, Status::duplicate_vertices,
                           {{CageFaultKind::duplicate_vertices, 4, 0}});

    // Close, but many times the tolerance of 8 ε √2 · 4.
    auto near = square<TestType>(0, 4);
    near.insert(near.begin() + 1, {4 - 500 * epsilon<TestType>, TestType(-0.5)});
    near[1][1] = -500 * epsilon<TestType>;
    CHECK(check(Polygon<TestType>(near)).status == Status::ok);
}

TEMPLATE_TEST_CASE("check: a loop without area", "[cage][check]", CAGEFORM_SCALARS) {
    using T = TestType;
    check_faults<T>({{0, 0}, {1, 2}, {3, 6}, {2, 4}}, {}, Status::cage_has_no_area,
                    {{CageFaultKind::no_area, 0, 0}});
    check_faults<T>({{0, 0}, {4, 0}, {2, 0}}, {}, Status::cage_has_no_area, {{CageFaultKind::no_area, 0, 0}});
    check_faults<T>(joined<T>({square<T>(0, 4), {{1, 1}, {3, 2}, {2, T(1.5)}}}), {4, 3},
                    Status::cage_has_no_area, {{CageFaultKind::no_area, 1, 0}});
    // A thin loop has an area.
    CHECK(check(Polygon<T>(Points2<T>{{0, 0}, {1, 0}, {T(0.5), 100 * epsilon<T>}})).status == Status::ok);
}

TEMPLATE_TEST_CASE("check: edges that cross or touch", "[cage][check]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto kind = CageFaultKind::edges_cross;
    const auto status = Status::cage_self_crossing;
    SECTION("a bow tie") {
        check_faults<T>({{0, 0}, {2, 2}, {2, 0}, {0, 3}}, {}, status, {{kind, 0, 2}});
    }
    SECTION("a vertex on an edge") {
        check_faults<T>({{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}, {}, status, {{kind, 0, 2}, {kind, 0, 3}});
    }
    SECTION("two vertices at one place") {
        check_faults<T>({{0, 0}, {2, 0}, {1, 1}, {2, 2}, {0, 2}, {1, 1}}, {}, status,
                        {{kind, 1, 4}, {kind, 1, 5}, {kind, 2, 4}, {kind, 2, 5}});
    }
    SECTION("an edge that folds back onto its predecessor") {
        check_faults<T>({{0, 0}, {4, 0}, {2, 0}, {2, 3}}, {}, status, {{kind, 0, 1}, {kind, 0, 2}});
        check_faults<T>({{2, 0}, {2, 3}, {0, 0}, {4, 0}}, {}, status, {{kind, 0, 2}, {kind, 2, 3}});
    }
    SECTION("edges that run along each other") {
        check_faults<T>({{0, 0}, {6, 0}, {6, 2}, {4, 2}, {4, 0}, {2, 0}, {2, 2}, {0, 2}}, {}, status,
                        {{kind, 0, 3}, {kind, 0, 4}, {kind, 0, 5}});
    }
    SECTION("a hole that crosses the outer loop") {
        check_faults<T>(joined<T>({square<T>(0, 4), {{3, 1}, {3, 3}, {5, 3}, {5, 1}}}), {4, 4}, status,
                        {{kind, 1, 5}, {kind, 1, 7}});
    }
    SECTION("a hole that touches the outer loop") {
        check_faults<T>(joined<T>({square<T>(0, 4), {{4, 2}, {2, 1}, {2, 3}}}), {4, 3}, status,
                        {{kind, 1, 4}, {kind, 1, 6}});
    }
    SECTION("a loop given twice") {
        CHECK(check(Polygon<T>(joined<T>({square<T>(0, 4), square<T>(0, 4)}), Sizes{4, 4})).status == status);
    }
}

TEMPLATE_TEST_CASE("check: a reversed loop is a warning", "[cage][check]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto kind = CageFaultKind::loop_orientation_reversed;
    check_faults<T>(square<T>(0, 4), {}, Status::ok, {});
    check_faults<T>(reversed(square<T>(0, 4)), {}, Status::ok, {{kind, 0, 0}});

    // An outer loop, a hole in it and an island in the hole, in each orientation and order.
    const Points2<T> nest[] = {square<T>(0, 9), reversed(square<T>(1, 8)), square<T>(2, 7)};
    for (const auto& order : {std::array{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}) {
        for (unsigned flips = 0; flips < 8; ++flips) {
            CAPTURE(order[0], order[1], order[2], flips);
            Points2<T> points;
            Faults expected;
            for (std::size_t k = 0; k < 3; ++k) {
                const bool flip = (flips >> k) & 1u;
                const auto& loop = nest[std::size_t(order[k])];
                const auto given = flip ? reversed(loop) : loop;
                points.insert(points.end(), given.begin(), given.end());
                if (flip) expected.emplace(kind, k, 0);
            }
            check_faults<T>(points, {4, 4, 4}, Status::ok, expected);
        }
    }
    // Two outer loops side by side.
    check_faults<T>(joined<T>({square<T>(0, 4), square<T>(5, 9)}), {4, 4}, Status::ok, {});
}

TEMPLATE_TEST_CASE("check: a collinear vertex is a warning", "[cage][check]", CAGEFORM_SCALARS) {
    for (std::size_t i = 0; i < 4; ++i) {
        CAPTURE(i);
        auto points = square<TestType>(0, 4);
        const auto middle = TestType(0.5) * (points[i] + points[(i + 1) % 4]);
        points.insert(points.begin() + std::ptrdiff_t(i) + 1, middle);
        check_faults<TestType>(points, {}, Status::ok, {{CageFaultKind::collinear_vertex, i + 1, 0}});
    }
}

// ---- laws --------------------------------------------------------------------------------------

TEMPLATE_TEST_CASE("check finds no faults in stars", "[cage][check][property]", CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(200));
    CAPTURE(seed);
    Faults expected;
    if (seed % 2 == 1) expected.emplace(CageFaultKind::loop_orientation_reversed, 0, 0); // clockwise
    check_faults<TestType>(random_star<TestType>(std::uint64_t(seed)), {}, Status::ok, expected);
}

TEMPLATE_TEST_CASE("check accepts walls slightly farther apart than the tolerance", "[cage][check]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    // A deep slit in a square, from the top. The square's diagonal is √2, so the tolerance is 8 √2 ε,
    // 1.3e-6 for float. A gap of 1e-6 diagonals is the smallest that float distinguishes from a fault,
    // apart from its own rounding; hence twice that.
    const T narrow = sizeof(T) == 4 ? T(2e-6) : T(1e-6);
    for (const T gap : {T(0.1), T(1e-3), T(1e-5), narrow, std::max(64 * epsilon<T>, narrow / 1000000)}) {
        if (sizeof(T) == 4 && gap < narrow) continue;
        const T g = gap * std::sqrt(T(2));
        CAPTURE(gap);
        const T x = T(0.5);
        const Points2<T> cut{{0, 0},          {1, 0},      {1, 1}, {x + g, 1},
                             {x + g, T(0.2)}, {x, T(0.2)}, {x, 1}, {0, 1}};
        const Points2<T> wedge{{0, 0}, {1, 0}, {1, 1}, {x + g, 1}, {x, T(0.2)}, {x, 1}, {0, 1}};
        check_faults<T>(cut, {}, Status::ok, {});
        check_faults<T>(wedge, {}, Status::ok, {});
        // The same for the shape rotated by 90 degrees and slanted.
        for (auto shape : {cut, wedge}) {
            for (auto& p : shape) p = {p[1] - p[0] / 3, -p[0]};
            check_faults<T>(shape, {}, Status::ok, {});
        }
    }
    // Walls within rounding of each other touch.
    const T touch = 2 * epsilon<T>;
    Points2<T> squares = square<T>(0, 1);
    for (const auto& p : square<T>(0, 1)) squares.push_back(p + Vec<T, 2>{1 + touch, 0});
    CHECK(check(Polygon<T>(squares, Sizes{4, 4})).status == Status::cage_self_crossing);
    squares = square<T>(0, 1);
    for (const auto& p : square<T>(0, 1)) squares.push_back(p + Vec<T, 2>{1 + 100 * epsilon<T>, 0});
    check_faults<T>(squares, {4, 4}, Status::ok, {});
}

TEMPLATE_TEST_CASE("check agrees with brute force on integer polygons", "[cage][check][property]",
                   CAGEFORM_SCALARS) {
    // Parts of two integer polygons that do not touch are at least 1/(16 √2) apart, far above the
    // tolerance.
    std::size_t accepted = 0;
    std::size_t crossing = 0;
    for (std::uint64_t seed = 0; seed < 2000; ++seed) {
        CAPTURE(seed);
        Random random(seed);
        const auto polygon = random_integer_polygon(random);
        const auto expected = brute_force(polygon);
        const auto report = check(Polygon<TestType>(polygon.points<TestType>(), polygon.sizes));
        CHECK(faults_of(report) == expected);
        accepted += report.status == Status::ok;
        crossing += report.status == Status::cage_self_crossing;
    }
    CHECK(accepted > 50); // both outcomes occurred
    CHECK(crossing > 500);
}

TEMPLATE_TEST_CASE("check is invariant to scaling by a power of two", "[cage][check][property]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(40));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const int largest = sizeof(TestType) == 4 ? 100 : 400;
    const auto integers = random_integer_polygon(random);
    const auto star = random_star<TestType>(std::uint64_t(seed));
    const auto points = integers.points<TestType>();
    const auto faults = faults_of(check(Polygon<TestType>(points, integers.sizes)));
    const auto star_faults = faults_of(check(Polygon<TestType>(star)));
    for (const int exponent : {-largest, -20, -1, 1, 20, largest}) {
        CAPTURE(exponent);
        const TestType scale = std::ldexp(TestType(1), exponent);
        const auto scaled = transformed<TestType>(points, scale, {0, 0});
        CHECK(faults_of(check(Polygon<TestType>(scaled, integers.sizes))) == faults);
        const auto scaled_star = transformed<TestType>(star, scale, {0, 0});
        CHECK(faults_of(check(Polygon<TestType>(scaled_star))) == star_faults);
    }
}

TEMPLATE_TEST_CASE("check is invariant to translation by a power of two", "[cage][check][property]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(40));
    CAPTURE(seed);
    Random random{std::uint64_t(seed)};
    const auto integers = random_integer_polygon(random);
    const auto points = integers.points<TestType>();
    const auto faults = faults_of(check(Polygon<TestType>(points, integers.sizes)));
    // The tolerance, 8 ε of the distance, stays below the smallest gap of 1/(16 √2).
    const int farthest = sizeof(TestType) == 4 ? 14 : 40;
    for (const int exponent : {0, 5, farthest}) {
        for (const int sign : {-1, 1}) {
            CAPTURE(exponent, sign);
            const TestType x = TestType(sign) * std::ldexp(TestType(1), exponent);
            const auto moved = transformed<TestType>(points, 1, {x, -x / 2});
            CHECK(faults_of(check(Polygon<TestType>(moved, integers.sizes))) == faults);
        }
    }
}

TEST_CASE("FacetPairs finds the same pairs as testing all pairs", "[cage][check][oracle]") {
    std::size_t edges = 0, faces = 0;
    for (int seed = 0; seed < 10; ++seed) {
        CAPTURE(seed);
        edges += find_as_all_pairs_do<2>(seed);
        faces += find_as_all_pairs_do<3>(seed);
    }
    CHECK(edges > 5000);
    CHECK(faces > 200);
}

TEST_CASE("FacetPairs separates the slivers of two caps with few tests", "[cage][check]") {
    const bool corner_fan = GENERATE(false, true);
    const std::uint32_t n = 1000;
    std::vector<Vec<double, 3>> vertices;
    for (const double z : {0.0, 1.0}) {
        for (std::uint32_t i = 0; i < n; ++i) {
            const double angle = 2 * std::numbers::pi / n * i;
            vertices.push_back({std::cos(angle), std::sin(angle), z});
        }
    }
    vertices.push_back({0, 0, 0});
    vertices.push_back({0, 0, 1});
    std::vector<std::array<std::uint32_t, 3>> faces;
    std::vector<std::uint32_t> apex;
    const auto add = [&](const std::array<std::uint32_t, 3>& face, std::uint32_t at) {
        faces.push_back(face);
        apex.push_back(at);
    };
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t j = (i + 1) % n, bottom = corner_fan ? 0 : 2 * n,
                            top = corner_fan ? n : 2 * n + 1;
        for (const auto& wall : {std::array{i, j, n + j}, std::array{i, n + j, n + i}}) {
            const bool at_apex = corner_fan && (i == 0 || j == 0);
            add(wall, at_apex && wall[0] == 0 ? 0 : FacetPairs<3>::no_group);
        }
        if (i != bottom && j != bottom) add({bottom, j, i}, bottom);
        if (n + i != top && n + j != top) add({top, n + i, n + j}, top);
    }
    std::vector<cageform::Facet<3>> facets;
    for (const auto& face : faces) facets.emplace_back(face, std::span<const Vec<double, 3>>(vertices));
    std::size_t tests = 0;
    FacetPairs<3>(facets, apex, 1e-15)
        .for_each(
            [&](std::size_t, std::size_t) {
                ++tests;
                return false;
            },
            [](std::size_t, std::size_t) {});
    CHECK(tests >= 2 * n);              // at least the neighbours in the wall
    CHECK(tests <= 20 * facets.size()); // testing all pairs would take 2,000 each
}

TEST_CASE("a report lists the first faults and counts all", "[cage][check][status]") {
    Random random(7);
    Points2<double> points(300);
    for (auto& p : points) p = {random.uniform(0, 1), random.uniform(0, 1)};
    const auto report = check(Polygon<double>(points));
    CHECK(report.status == Status::cage_self_crossing);
    std::size_t crossings = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            const auto next = [&](std::size_t k) { return (k + 1) % points.size(); };
            if (next(j) == i || next(i) == j) continue;
            crossings +=
                cageform::detail::segments_touch(points[i], points[next(i)], points[j], points[next(j)]);
        }
    }
    CHECK(report.fault_count == crossings);
    CHECK(crossings > CageReport::most_listed);
    CHECK(report.faults.size() == CageReport::most_listed);
    CHECK(faults_of(report).size() == report.faults.size());

    CageReport warnings;
    for (std::size_t i = 0; i < 5000; ++i) warnings.add(CageFaultKind::collinear_vertex, i);
    CHECK(warnings.faults.size() == 5000); // at most one per vertex
    CHECK(warnings.fault_count == 0);
    CHECK(warnings.status == Status::ok);
}

} // namespace check_tests

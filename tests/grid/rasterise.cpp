#include "../catch.hpp"
#include "../support/cages.hpp"

#include <cageform/cage/polygon.hpp>
#include <cageform/grid/pyramid/rasterise.hpp>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace rasterise_tests {

using cageform::bounds_of;
using cageform::check;
using cageform::epsilon;
using cageform::Lattice;
using cageform::locate;
using cageform::nearest_on_edge;
using cageform::PointState;
using cageform::Polygon;
using cageform::Status;
using cageform::Vec;
using cageform::vec_cast;
using cageform::grid::CellTag;
using cageform::grid::GridDomain;
using cageform::grid::lattice_about;
using cageform::grid::rasterise;
using cageform_tests::Points2;
using cageform_tests::Random;
using cageform_tests::random_star;

namespace {

using Sizes = std::vector<std::size_t>;

/// Whether the segment ab meets the square of half side `r` about `c`: it is clipped by the two slabs.
bool meets_square(const Vec<double, 2>& a, const Vec<double, 2>& b, const Vec<double, 2>& c, double r) {
    double from = 0;
    double to = 1;
    for (std::size_t k = 0; k < 2; ++k) {
        const double d = b[k] - a[k];
        if (d == 0) {
            if (std::fabs(a[k] - c[k]) > r) return false;
            continue;
        }
        const double s = (c[k] - r - a[k]) / d;
        const double t = (c[k] + r - a[k]) / d;
        from = std::fmax(from, std::fmin(s, t));
        to = std::fmin(to, std::fmax(s, t));
    }
    return from <= to;
}

/// How much the test shrinks or grows a cell, in cells. The rasteriser itself reaches 1e-6 cells too far, and
/// the vertices' places in the lattice are rounded relative to the largest of their coordinates.
template <class T>
double slack_of(const Polygon<T>& polygon, const Lattice<T, 2>& lattice) {
    double largest = bounds_of(polygon.vertices()).magnitude();
    for (std::size_t k = 0; k < 2; ++k) {
        largest = std::fmax(largest, std::fabs(double(lattice.origin[k])));
        largest = std::fmax(largest, double(lattice.spacing) * double(lattice.cells[k]));
    }
    return 4e-6 + 8 * double(epsilon<T>) * largest / double(lattice.spacing);
}

/// Everything that rasterise promises, by the slow way: every edge against every cell.
template <class T>
void check_domain(const Polygon<T>& polygon, const GridDomain<T, 2>& domain) {
    const auto& lattice = domain.lattice;
    REQUIRE(domain.tags.size() == lattice.size());
    REQUIRE(domain.places.size() == domain.boundary_cells.size());
    const double slack = slack_of(polygon, lattice);
    REQUIRE(slack < 0.25);
    const double spacing = lattice.spacing;
    const double rounding = slack * spacing;

    struct Edge {
        std::size_t i, j;
    };
    std::vector<Edge> edges;
    polygon.for_each_edge([&](std::size_t i, std::size_t j) { edges.push_back({i, j}); });

    std::vector<std::size_t> slot(lattice.size(), lattice.size());
    for (std::size_t b = 0; b < domain.boundary_cells.size(); ++b) {
        REQUIRE(domain.boundary_cells[b] < lattice.size());
        CHECK(slot[domain.boundary_cells[b]] == lattice.size()); // each cell once
        slot[domain.boundary_cells[b]] = b;
    }
    std::size_t surely_crowded = 0;
    std::size_t maybe_crowded = 0;
    std::size_t wrong_side = 0;
    std::size_t leaks = 0;
    for (std::size_t cell = 0; cell < lattice.size(); ++cell) {
        const auto index = lattice.index(cell);
        const auto centre = lattice.centre(index);
        const auto c = vec_cast<double>(centre);
        const CellTag tag = domain.tags[cell];
        std::vector<Edge> surely;
        std::vector<Edge> maybe;
        for (const Edge& e : edges) {
            const auto a = vec_cast<double>(polygon[e.i]);
            const auto b = vec_cast<double>(polygon[e.j]);
            if (meets_square(a, b, c, (0.5 - slack) * spacing)) surely.push_back(e);
            if (meets_square(a, b, c, (0.5 + slack) * spacing)) maybe.push_back(e);
        }
        CAPTURE(index[0], index[1], int(tag));
        CHECK((slot[cell] != lattice.size()) == (tag == CellTag::boundary));
        if (!surely.empty()) CHECK(tag == CellTag::boundary);
        if (maybe.empty()) CHECK((tag == CellTag::interior || tag == CellTag::exterior));

        if (tag == CellTag::boundary) {
            const auto& place = domain.places[slot[cell]];
            const auto is_its_edge = [&](const Edge& e) { return e.i == place.i && e.j == place.j; };
            CHECK(std::any_of(maybe.begin(), maybe.end(), is_its_edge));
            CHECK((place.s >= 0 && place.s <= 1));
            const auto x = vec_cast<double>(place.position);
            const auto a = vec_cast<double>(polygon[place.i]);
            const auto b = vec_cast<double>(polygon[place.j]);
            const double s = place.s;
            CHECK(std::hypot((1 - s) * a[0] + s * b[0] - x[0], (1 - s) * a[1] + s * b[1] - x[1]) <= rounding);
            CHECK(std::fabs(std::hypot(x[0] - c[0], x[1] - c[1]) - double(place.distance)) <= rounding);
            for (const Edge& e : surely) {
                const auto other = nearest_on_edge(polygon, e.i, e.j, centre);
                CHECK(double(place.distance) <= double(other.distance) + rounding);
            }
        } else {
            const bool inside = locate(polygon, centre, T(0)) == PointState::inside;
            wrong_side += tag != (inside ? CellTag::interior : CellTag::exterior);
        }
        for (int dx = -1; dx <= 1 && tag == CellTag::interior; ++dx) {
            for (int dy = -1; dy <= 1; ++dy) {
                const std::size_t x = index[0] + std::size_t(dx);
                const std::size_t y = index[1] + std::size_t(dy);
                if (x >= lattice.cells[0] || y >= lattice.cells[1]) continue;
                leaks += domain.tags[lattice.number({x, y})] == CellTag::exterior;
            }
        }
        const auto without_common_vertex = [](const std::vector<Edge>& list) {
            for (const Edge& e : list) {
                for (const Edge& f : list) {
                    if (e.i != f.i && e.j != f.i && f.j != e.i) return true;
                }
            }
            return false;
        };
        surely_crowded += without_common_vertex(surely);
        maybe_crowded += without_common_vertex(maybe);
    }
    CHECK(wrong_side == 0);
    CHECK(leaks == 0);
    CHECK(surely_crowded <= domain.crowded_cells);
    CHECK(domain.crowded_cells <= maybe_crowded);
}

template <class T>
Lattice<T, 2> unit_lattice(std::size_t columns, std::size_t rows, T x = 0, T y = 0) {
    Lattice<T, 2> lattice;
    lattice.cells = {columns, rows};
    lattice.origin = {x, y};
    lattice.spacing = 1;
    return lattice;
}

/// The tags as text, the top row first: '#' boundary, '+' interior, '.' exterior.
template <class T>
std::vector<std::string> picture(const GridDomain<T, 2>& domain) {
    std::vector<std::string> rows(domain.lattice.cells[1]);
    for (std::size_t cell = 0; cell < domain.tags.size(); ++cell) {
        const CellTag tag = domain.tags[cell];
        rows[domain.lattice.cells[1] - 1 - domain.lattice.index(cell)[1]] += tag == CellTag::boundary   ? '#'
                                                                             : tag == CellTag::interior ? '+'
                                                                             : tag == CellTag::exterior ? '.'
                                                                                                        : '?';
    }
    return rows;
}

std::size_t count_of(const std::vector<CellTag>& tags, CellTag tag) {
    return std::size_t(std::count(tags.begin(), tags.end(), tag));
}

template <class T>
void append_square(Points2<T>& points, T low, T high) {
    for (const auto& p : {Vec<T, 2>{low, low}, {high, low}, {high, high}, {low, high}}) points.push_back(p);
}

} // namespace

TEMPLATE_TEST_CASE("rasterise keeps its promises on stars", "[grid][rasterise][property]", CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(30));
    CAPTURE(seed);
    const Polygon<TestType> cage(random_star<TestType>(std::uint64_t(seed)));
    for (const std::size_t resolution : {8u, 16u, 33u, 90u}) {
        CAPTURE(resolution);
        const auto domain = rasterise(cage, lattice_about(bounds_of(cage.vertices()), resolution));
        check_domain(cage, domain);
        if (resolution == 90 && sizeof(TestType) == 8) CHECK(count_of(domain.tags, CellTag::exterior) > 0);
    }
}

TEMPLATE_TEST_CASE("rasterise: edges along grid lines and through corners of cells",
                   "[grid][rasterise][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    std::size_t tried = 0;
    for (std::uint64_t seed = 0; seed < 120; ++seed) {
        CAPTURE(seed);
        // Vertices on corners of the grid; few directions, so that many edges follow lines and diagonals.
        Points2<T> points;
        Random random(seed);
        const int count = int(4 + random.below(8));
        for (int i = 0; i < count; ++i) {
            const double angle = 2 * std::numbers::pi * double(i) / double(count);
            const double radius = random.uniform(2, 9);
            points.push_back(
                {T(std::lround(radius * std::cos(angle))), T(std::lround(radius * std::sin(angle)))});
        }
        const Polygon<T> cage(points);
        if (check(cage).status != Status::ok) continue; // rounding may have made neighbours one
        ++tried;
        check_domain(cage, rasterise(cage, unit_lattice<T>(24, 24, -12, -12)));
        auto finer = unit_lattice<T>(48, 48, -12, -12);
        finer.spacing = T(0.5);
        check_domain(cage, rasterise(cage, finer));
    }
    CHECK(tried > 60);
}

TEMPLATE_TEST_CASE("rasterise: an edge marks all the cells it touches", "[grid][rasterise]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    SECTION("a square on grid lines marks both sides of them") {
        Points2<T> points;
        append_square<T>(points, 2, 6);
        const auto domain = rasterise(Polygon<T>(points), unit_lattice<T>(8, 8));
        CHECK(picture(domain) == std::vector<std::string>{"........", ".######.", ".######.", ".##++##.",
                                                          ".##++##.", ".######.", ".######.", "........"});
        CHECK(domain.crowded_cells == 0);
    }
    SECTION("a diagonal through corners marks the cells on either side of each corner") {
        const Polygon<T> cage(Points2<T>{{4, 1}, {7, 4}, {4, 7}, {1, 4}});
        CHECK(picture(rasterise(cage, unit_lattice<T>(8, 8))) ==
              std::vector<std::string>{"...##...", "..####..", ".######.", "###++###", "###++###", ".######.",
                                       "..####..", "...##..."});
    }
    SECTION("a square within cells marks one row of cells") {
        Points2<T> points;
        append_square<T>(points, T(1.5), T(6.5));
        CHECK(picture(rasterise(Polygon<T>(points), unit_lattice<T>(8, 8))) ==
              std::vector<std::string>{"........", ".######.", ".#++++#.", ".#++++#.", ".#++++#.", ".#++++#.",
                                       ".######.", "........"});
    }
}

TEMPLATE_TEST_CASE("rasterise: holes, islands and several outer loops", "[grid][rasterise]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    Points2<T> points;
    for (const T r : {T(9.5), T(6.5), T(3.5)}) append_square<T>(points, -r, r);
    const Polygon<T> nest(points, Sizes{4, 4, 4});
    const auto domain = rasterise(nest, unit_lattice<T>(24, 24, -12, -12));
    check_domain(nest, domain);
    CHECK(domain.tags[domain.lattice.number({4, 12})] == CellTag::interior);
    CHECK(domain.tags[domain.lattice.number({7, 12})] == CellTag::exterior);
    CHECK(domain.tags[domain.lattice.number({12, 12})] == CellTag::interior);
    CHECK(domain.tags[0] == CellTag::exterior);

    points.clear();
    append_square<T>(points, T(-9.5), T(-0.5));
    append_square<T>(points, T(0.5), T(9.5));
    const Polygon<T> pair(points, Sizes{4, 4});
    check_domain(pair, rasterise(pair, unit_lattice<T>(24, 24, -12, -12)));
}

TEMPLATE_TEST_CASE("rasterise: rings of random stars", "[grid][rasterise][property]", CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(15));
    CAPTURE(seed);
    const auto star = random_star<double>(std::uint64_t(seed));
    Vec<double, 2> centre{0, 0};
    for (const auto& p : star) centre = centre + (1.0 / double(star.size())) * p;
    Points2<TestType> points;
    for (const double size : {1.0, 0.6, 0.5}) {
        for (const auto& p : star) points.push_back(vec_cast<TestType>(centre + size * (p - centre)));
    }
    const Polygon<TestType> ring(points, Sizes{star.size(), star.size(), star.size()});
    for (const std::size_t resolution : {12u, 60u})
        check_domain(ring, rasterise(ring, lattice_about(bounds_of(ring.vertices()), resolution)));
}

TEMPLATE_TEST_CASE("rasterise: walls thinner than a cell keep both sides apart", "[grid][rasterise]", float,
                   double) {
    using T = TestType;
    // Two chambers joined at the bottom; the wall between them, of the exterior, is an eighth of a cell.
    const T left = T(9.5);
    const T right = left + T(0.125);
    const Polygon<T> chambers(Points2<T>{{T(1.5), T(1.5)},
                                         {T(18.5), T(1.5)},
                                         {T(18.5), T(12.5)},
                                         {right, T(12.5)},
                                         {right, T(5.5)},
                                         {left, T(5.5)},
                                         {left, T(12.5)},
                                         {T(1.5), T(12.5)}});
    const auto domain = rasterise(chambers, unit_lattice<T>(20, 14));
    check_domain(chambers, domain);
    // The cells of the wall hold its two sides, which have no vertex in common: rows 5 … 12 of column 9.
    CHECK(domain.crowded_cells == 8);

    // A sliver of a cage: no cell is all inside.
    const Polygon<T> sliver(Points2<T>{{T(1.3), T(1.4)}, {T(17.1), T(9.3)}, {T(17), T(9.6)}});
    const auto thin = rasterise(sliver, unit_lattice<T>(20, 14));
    check_domain(sliver, thin);
    CHECK(count_of(thin.tags, CellTag::interior) == 0);
}

TEMPLATE_TEST_CASE("rasterise: the count of crowded cells does not depend on where a loop begins",
                   "[grid][rasterise]", CAGEFORM_SCALARS) {
    using T = TestType;
    // A slit, narrower than a cell, with a bottom: three edges in the cell at its end.
    Points2<T> points{{T(1.5), T(1.5)}, {T(8.5), T(1.5)}, {T(8.5), T(8.5)}, {T(5.7), T(8.5)},
                      {T(5.7), T(4.4)}, {T(5.3), T(4.4)}, {T(5.3), T(8.5)}, {T(1.5), T(8.5)}};
    for (std::size_t start = 0; start < points.size(); ++start) {
        CAPTURE(start);
        const Polygon<T> cage(points);
        const auto domain = rasterise(cage, unit_lattice<T>(10, 10));
        check_domain(cage, domain);
        CHECK(domain.crowded_cells == 5); // rows 4 … 8 of column 5
        std::rotate(points.begin(), points.begin() + 1, points.end());
    }
}

TEMPLATE_TEST_CASE("rasterise: a cage smaller than a cell", "[grid][rasterise]", CAGEFORM_SCALARS) {
    const Polygon<TestType> dot(Points2<TestType>{
        {TestType(2.25), TestType(2.25)}, {TestType(2.5), TestType(2.25)}, {TestType(2.25), TestType(2.5)}});
    const auto domain = rasterise(dot, unit_lattice<TestType>(5, 5));
    check_domain(dot, domain);
    CHECK(domain.boundary_cells == std::vector<std::size_t>{12});
    CHECK(domain.crowded_cells == 0); // in a triangle each edge meets both others
}

} // namespace rasterise_tests

#include "averaging/rasterise.hpp"
#include "../catch.hpp"
#include "../support/cages.hpp"
#include "../support/effort.hpp"
#include "../support/larger.hpp"
#include "../support/meshes.hpp"

#include <cageform/cage/box_mesh.hpp>

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
using cageform_sources::averaging::CellTag;
using cageform_sources::averaging::GridDomain;
using cageform_sources::averaging::lattice_about;
using cageform_sources::averaging::rasterise;
using cageform_tests::effort;
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
        from = cageform_tests::larger(from, std::fmin(s, t));
        to = std::fmin(to, std::fmax(s, t));
    }
    return from <= to;
}

/// How much the test shrinks or grows a cell, in cells. The rasteriser itself reaches 1e-6 cells too
/// far, and the vertices' places in the lattice are rounded relative to the largest of their
/// coordinates.
template <class T>
double slack_of(const Polygon<T>& polygon, const Lattice<T, 2>& lattice) {
    double largest = bounds_of(polygon.vertices()).magnitude();
    for (std::size_t k = 0; k < 2; ++k) {
        largest = cageform_tests::larger(largest, std::fabs(double(lattice.origin[k])));
        largest = cageform_tests::larger(largest, double(lattice.spacing) * double(lattice.cells[k]));
    }
    return 4e-6 + 8 * double(epsilon<T>) * largest / double(lattice.spacing);
}

using CellData = std::vector<std::pair<std::uint32_t, double>>; // handles and values

/// Returns the data of every cell of a domain, and checks the domain's sums.
template <class T, std::size_t D>
std::vector<CellData> data_by_cell(const GridDomain<T, D>& domain, std::size_t handles) {
    std::vector<CellData> data(domain.tags.size());
    std::size_t count = 0, wrong = 0;
    for (std::uint32_t handle = 0; handle < handles; ++handle) {
        for (const auto& given : domain.data_of(handle)) {
            const bool in_range = given.handle == handle && given.cell < data.size();
            REQUIRE(in_range);
            const auto& cell = data[given.cell];
            wrong += !(given.value > 0 && given.value <= 1 + 4 * epsilon<T>);
            wrong += !cell.empty() && cell.back().first == handle; // twice
            data[given.cell].emplace_back(handle, given.value);
            ++count;
        }
    }
    CHECK(count == domain.data.size());
    for (const auto& cell : data) {
        double sum = 0;
        for (const auto& [handle, value] : cell) sum += value;
        wrong += !cell.empty() && !(std::fabs(sum - 1) <= 16 * double(epsilon<T>));
    }
    CHECK(wrong == 0);
    return data;
}

template <class T, std::size_t D>
Vec<double, D> place_of(const CellData& data, std::span<const Vec<T, D>> vertices) {
    Vec<double, D> place{};
    for (const auto& [handle, value] : data) place = place + value * vec_cast<double>(vertices[handle]);
    return place;
}

/// Everything that rasterise promises, by the slow way: every edge against every cell.
template <class T>
void check_domain(const Polygon<T>& polygon, const GridDomain<T, 2>& domain) {
    const auto& lattice = domain.lattice;
    REQUIRE(domain.tags.size() == lattice.size());
    const double slack = slack_of(polygon, lattice);
    REQUIRE(slack < 0.25);
    const double spacing = lattice.spacing;
    const double rounding = slack * spacing;

    struct Edge {
        std::size_t i, j;
    };
    std::vector<Edge> edges;
    polygon.for_each_edge([&](std::size_t i, std::size_t j) { edges.push_back({i, j}); });

    const auto data = data_by_cell(domain, polygon.size());
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
        CHECK(!data[cell].empty() == (tag == CellTag::boundary));
        if (!surely.empty()) CHECK(tag == CellTag::boundary);
        if (maybe.empty()) CHECK((tag == CellTag::interior || tag == CellTag::exterior));

        if (tag == CellTag::boundary) {
            // The data of one place of an edge, no farther from the centre than any other edge.
            const std::uint32_t i = data[cell].front().first, j = data[cell].back().first;
            const auto is_its_edge = [a = i, b = j](const Edge& e) { // or ends there, where a is b
                return (e.i == a && (a == b || e.j == b)) || (e.j == a && (a == b || e.i == b));
            };
            CHECK(std::any_of(maybe.begin(), maybe.end(), is_its_edge));
            CHECK(data[cell].size() <= 2);
            const auto x = place_of(data[cell], polygon.vertices());
            const double distance = std::hypot(x[0] - c[0], x[1] - c[1]);
            for (const Edge& e : surely) {
                const auto other = nearest_on_edge(polygon, e.i, e.j, centre);
                CHECK(distance <= double(other.distance) + rounding);
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
    CHECK(surely_crowded <= domain.unresolved_cells);
    CHECK(domain.unresolved_cells <= maybe_crowded);
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
    const auto seed = GENERATE(seeds(effort(30, 8)));
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
    constexpr std::uint64_t cages = effort(120u, 30u);
    for (std::uint64_t seed = 0; seed < cages; ++seed) {
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
    CHECK(tried > cages / 2);
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
        CHECK(domain.unresolved_cells == 0);
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

TEMPLATE_TEST_CASE("rasterise: walls thinner than a cell keep both sides apart", "[grid][rasterise]",
                   CAGEFORM_SCALARS) {
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
    CHECK(domain.unresolved_cells == 8);

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
        CHECK(domain.unresolved_cells == 5); // rows 4 … 8 of column 5
        std::rotate(points.begin(), points.begin() + 1, points.end());
    }
}

TEMPLATE_TEST_CASE("rasterise: a cage smaller than a cell", "[grid][rasterise]", CAGEFORM_SCALARS) {
    const Polygon<TestType> dot(Points2<TestType>{
        {TestType(2.25), TestType(2.25)}, {TestType(2.5), TestType(2.25)}, {TestType(2.25), TestType(2.5)}});
    const auto domain = rasterise(dot, unit_lattice<TestType>(5, 5));
    check_domain(dot, domain);
    CHECK(count_of(domain.tags, CellTag::boundary) == 1);
    CHECK(domain.tags[12] == CellTag::boundary);
    CHECK(domain.unresolved_cells == 0); // in a triangle each edge meets both others
}

TEMPLATE_TEST_CASE("rasterise: a corner of the lattice that the cage cuts off", "[grid][rasterise]",
                   CAGEFORM_SCALARS) {
    const auto at = [](double x, double y) { return Vec<TestType, 2>{TestType(x), TestType(y)}; };
    for (const double side : {0.0, 5.0}) { // the first cell, the last cell
        const auto place = [&](double x, double y) { return side > 0 ? at(side - x, side - y) : at(x, y); };
        const Polygon<TestType> cage(Points2<TestType>{place(0.5, 1.875), place(1.875, 0.5), place(4, 4)});
        const auto domain = rasterise(cage, unit_lattice<TestType>(5, 5));
        check_domain(cage, domain);
        CHECK(domain.tags[side > 0 ? 24 : 0] == CellTag::exterior);
    }
}

// ---- in space ----------------------------------------------------------------------------------

namespace {

/// Whether a convex polygon meets the cube of half side `r` about `c`: clipped by its six planes.
bool meets_cube(std::vector<Vec<double, 3>> polygon, const Vec<double, 3>& c, double r) {
    for (std::size_t plane = 0; plane < 6 && !polygon.empty(); ++plane) {
        const std::size_t axis = plane / 2;
        const double sign = plane % 2 == 0 ? 1 : -1;
        const auto beyond = [&](const Vec<double, 3>& p) { return sign * (p[axis] - c[axis]) - r; };
        std::vector<Vec<double, 3>> clipped;
        for (std::size_t n = 0; n < polygon.size(); ++n) {
            const auto &p = polygon[n], &q = polygon[(n + 1) % polygon.size()];
            const double a = beyond(p), b = beyond(q);
            if (a <= 0) clipped.push_back(p);
            if ((a < 0 && b > 0) || (a > 0 && b < 0)) clipped.push_back(p + (a / (a - b)) * (q - p));
        }
        polygon = std::move(clipped);
    }
    return !polygon.empty();
}

/// A face of a cage in space, as a convex polygon of its vertices.
struct Face {
    std::vector<std::uint32_t> vertex;
    std::vector<Vec<double, 3>> corner;
    cageform::Bounds<double, 3> bounds;

    template <class T>
    Face(const std::vector<std::uint32_t>& of, std::span<const Vec<T, 3>> vertices)
        : vertex(of) {
        for (const auto n : of) corner.push_back(vec_cast<double>(vertices[n]));
        bounds = bounds_of(std::span<const Vec<double, 3>>(corner));
    }
    bool meets(const Face& other) const {
        return std::find_first_of(vertex.begin(), vertex.end(), other.vertex.begin(), other.vertex.end()) !=
               vertex.end();
    }
};
template <class T>
std::vector<Face> faces_of(const cageform::TriangleMesh<T>& mesh) {
    std::vector<Face> faces;
    for (const auto& [a, b, c] : mesh.faces()) faces.emplace_back(std::vector{a, b, c}, mesh.vertices());
    return faces;
}
/// The place of a face nearest to `p`.
template <class T>
Vec<double, 3> nearest_place(const cageform::TriangleMesh<T>&, const Face& face, const Vec<double, 3>& p) {
    const cageform::detail::Corners<3> corner{face.corner[0], face.corner[1], face.corner[2]};
    return cageform::detail::point_on_facet(cageform::nearest_on_facet(p, corner), corner);
}

/// Everything that rasterise promises in space, by the slow way: every face against every cell.
///   returns  how many cells' data were compared: no face may come so near to them that rounding
///            tells whether it touches them
template <class C>
std::size_t check_domain(const C& cage, std::size_t resolution) {
    using T = typename C::scalar;
    const auto lattice = lattice_about(bounds_of(cage.vertices()), resolution);
    const auto domain = rasterise(cage, lattice);
    REQUIRE(domain.tags.size() == lattice.size());
    const double spacing = lattice.spacing;
    const double slack =
        4e-6 + 16 * double(epsilon<T>) *
                   (double(resolution) + double(bounds_of(cage.vertices()).magnitude()) / spacing);
    REQUIRE(slack < 0.1);
    const auto faces = faces_of(cage);
    const auto data = data_by_cell(domain, cage.size());
    std::size_t surely_crowded = 0, maybe_crowded = 0, wrong_side = 0, leaks = 0, missed = 0, too_many = 0;
    std::size_t compared = 0, without_data = 0;
    double farthest = 0, worst_mean = 0;
    for (std::size_t cell = 0; cell < lattice.size(); ++cell) {
        const auto index = lattice.index(cell);
        const auto c = vec_cast<double>(lattice.centre(index));
        const CellTag tag = domain.tags[cell];
        std::vector<const Face*> surely, maybe;
        for (const Face& face : faces) {
            bool near = true;
            for (std::size_t k = 0; k < 3; ++k)
                near = near && face.bounds.lower[k] < c[k] + spacing && face.bounds.upper[k] > c[k] - spacing;
            if (!near || !meets_cube(face.corner, c, (0.5 + slack) * spacing)) continue;
            maybe.push_back(&face);
            if (meets_cube(face.corner, c, (0.5 - slack) * spacing)) surely.push_back(&face);
        }
        missed += !surely.empty() && tag != CellTag::boundary;
        too_many += maybe.empty() && tag == CellTag::boundary;
        without_data += data[cell].empty() == (tag == CellTag::boundary);
        if (tag == CellTag::boundary) {
            const auto place = place_of(data[cell], cage.vertices());
            farthest = cageform_tests::larger(farthest, cageform::detail::length(place - c) / spacing);
            if (surely.size() == maybe.size()) {
                Vec<double, 3> mean{};
                for (const Face* face : surely)
                    mean = mean + (1.0 / double(surely.size())) * nearest_place(cage, *face, c);
                worst_mean =
                    cageform_tests::larger(worst_mean, cageform::detail::length(mean - place) / spacing);
                ++compared;
            }
        } else {
            const bool inside = locate(cage, lattice.centre(index), T(0)) == PointState::inside;
            wrong_side += tag != (inside ? CellTag::interior : CellTag::exterior);
        }
        for (std::size_t n = 0; n < 27 && tag == CellTag::interior; ++n) {
            const typename Lattice<T, 3>::Index next{index[0] + n % 3 - 1, index[1] + n / 3 % 3 - 1,
                                                     index[2] + n / 9 - 1};
            leaks += domain.tags[lattice.number(next)] == CellTag::exterior;
        }
        const auto without_common_vertex = [](const std::vector<const Face*>& list) {
            for (const Face* a : list) {
                for (const Face* b : list) {
                    if (!a->meets(*b)) return true;
                }
            }
            return false;
        };
        surely_crowded += without_common_vertex(surely);
        maybe_crowded += without_common_vertex(maybe);
    }
    CHECK(missed == 0);
    CHECK(too_many == 0);
    CHECK(wrong_side == 0);
    CHECK(leaks == 0);
    CHECK(without_data == 0);
    CHECK(worst_mean <= 2 * slack);
    CHECK(farthest <= std::sqrt(0.75) + 2 * slack); // half a diagonal
    CHECK(surely_crowded <= domain.unresolved_cells);
    CHECK(domain.unresolved_cells <= maybe_crowded);
    return compared;
}

} // namespace

TEMPLATE_TEST_CASE("rasterise keeps its promises in meshes", "[grid][rasterise][mesh][property]",
                   CAGEFORM_SCALARS) {
    const auto seed = GENERATE(seeds(effort(6, 3)));
    CAPTURE(seed);
    const auto mesh = cageform_tests::random_mesh(std::uint64_t(seed)).mesh<TestType>();
    for (const std::size_t resolution : {9u, 16u}) {
        CAPTURE(resolution);
        CHECK(check_domain(mesh, resolution) > 30);
    }
}

TEST_CASE("rasterise: cavities, faces along grid planes, boxes", "[grid][rasterise][mesh]") {
    // A shell within another, and a third one within that: each part is told by itself.
    cageform_tests::MeshData nest;
    for (const double size : {1.0, 0.6, 0.25}) {
        const auto shell = cageform_tests::sphere(1);
        const int first = int(nest.vertices.size());
        for (const auto& v : shell.vertices) nest.vertices.push_back(size * v);
        for (auto face : shell.faces) {
            for (int& vertex : face) vertex += first;
            if (size == 0.6) std::swap(face[1], face[2]);
            nest.faces.push_back(face);
        }
    }
    const auto mesh = nest.mesh<double>();
    REQUIRE(check(mesh).status == Status::ok);
    CHECK(check_domain(mesh, 32) > 100);
    const auto lattice = lattice_about(bounds_of(mesh.vertices()), 40);
    const auto domain = rasterise(mesh, lattice);
    CHECK(domain.tags[lattice.number({20, 20, 20})] == CellTag::interior);
    CHECK(domain.tags[lattice.number({20, 20, 28})] == CellTag::exterior); // in the cavity
    CHECK(domain.tags[lattice.number({20, 20, 34})] == CellTag::interior);

    const auto cube = cageform_tests::divided_box({3, 4, 2}, 1);
    for (const std::size_t resolution : {8u, 12u, 21u}) { // faces on, and between, planes of the grid
        const bool between = resolution == 21;
        CHECK((check_domain(cube.mesh<double>(), resolution) > 0) == between);
    }
    // A box thinner than a cell has no interior, and opposite sides in all its cells but its ends'.
    const auto thin = cageform::box_mesh<double>({0, 0, 0}, {10, 10, 0.1}).triangles();
    const auto flat = rasterise(thin, lattice_about(bounds_of(thin.vertices()), 14));
    CHECK(count_of(flat.tags, CellTag::interior) == 0);
    CHECK(flat.unresolved_cells == count_of(flat.tags, CellTag::boundary));
}

} // namespace rasterise_tests

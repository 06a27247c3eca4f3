#include "catch.hpp"
#include "support/gradients.hpp"
#include "support/larger.hpp"
#include "support/oracle.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/sibson.hpp>
#include <cageform/parallel/threads.hpp>

namespace sibson_tests {

using namespace cageform;
using namespace cageform_tests;

namespace {

template <std::size_t D>
using Points = std::vector<Vec<double, D>>;

// ---- reference files ----------------------------------------------------------------------------

template <std::size_t D>
Points<D> read_points(const nlohmann::json& list) {
    Points<D> points;
    for (const auto& p : list) {
        Vec<double, D> x{};
        for (std::size_t k = 0; k < D; ++k) x[k] = p[k].get<double>();
        points.push_back(x);
    }
    return points;
}
nlohmann::json read_sets(const std::string& name) {
    std::ifstream file(std::string(CAGEFORM_TEST_DATA) + "/sibson/" + name + ".json");
    return nlohmann::json::parse(file)["sets"];
}

template <class T, std::size_t D>
std::vector<Vec<T, D>> rounded(const Points<D>& points) {
    std::vector<Vec<T, D>> result;
    for (const auto& p : points) result.push_back(vec_cast<T>(p));
    return result;
}
template <class T, std::size_t D>
bool is_exact(const Points<D>& points) {
    return std::all_of(points.begin(), points.end(),
                       [](const auto& p) { return vec_cast<double>(vec_cast<T>(p)) == p; });
}

/// Compares in double and in float. Rounding moves sites and points that are not floats, which costs a digit.
/// Points within float's tolerance of a site have that site's row.
template <class T, std::size_t D>
void check_weights(const SibsonCoordinates<T, D>& sibson, const Points<D>& sites,
                   const nlohmann::json& entry) {
    const auto p = read_points<D>(nlohmann::json::array({entry["point"]}));
    const double close = double(coincidence_tolerance(
                             bounds_of(std::span<const Vec<double, D>>(sites.data(), sites.size())))) *
                         double(epsilon<T> / epsilon<double>);
    for (const auto& site : sites) {
        if (site != p[0] && distance(site, p[0]) <= close) return;
    }
    const auto row = evaluate_all(sibson, rounded<T>(p));
    REQUIRE(row.status() == Status::ok);
    CHECK(row.states[0] == (entry["where"] == "hull" ? PointState::on_boundary : row.states[0]));
    CHECK(row.states[0] != PointState::outside);
    const bool exact = is_exact<T>(p) && is_exact<T>(sites);
    const double tolerance = std::is_same_v<T, double> ? 1e-13 : exact ? 1e-6 : 1e-5;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        CAPTURE(i);
        CHECK(std::fabs(double(row.rows[0][i]) - entry["weights"][i].get<double>()) <= tolerance);
    }
}

/// Leaves out gradients at sites. In the file, rounding decides which of two sites has the facet between a
/// cell and its mirror image, and moves two sites of a flat face 1e-16 inside. The test "does not depend on
/// motion" covers the rotated lattice.
constexpr const char* turned_lattice = "grid 2x2x4, turned and rounded to double";

template <class T, std::size_t D>
void check_file(const std::string& file, int degree) {
    std::size_t sets = 0;
    for (const auto& set : read_sets(file)) {
        CAPTURE(file, set["name"].get<std::string>());
        const auto sites = read_points<D>(set["sites"]);
        const SibsonCoordinates<T, D> sibson(rounded<T>(sites), {.degree = degree});
        REQUIRE(sibson.cage_report().status == Status::ok);
        if (degree == 3 && set["name"] == turned_lattice) continue;
        for (const auto& entry : set["points"]) {
            CAPTURE(entry["point"].dump());
            check_weights<T, D>(sibson, sites, entry);
            if (!entry.contains("gradients") || !std::is_same_v<T, double>) continue;
            const auto expected = read_points<D>(entry["gradients"]);
            const auto found = gradients_of<T, D>(
                sibson, rounded<T>(read_points<D>(nlohmann::json::array({entry["point"]}))));
            for (std::size_t i = 0; i < sites.size(); ++i)
                CHECK(distance(found.rows[0][i], expected[i]) <=
                      1e-13 * std::max(1.0, 1e2 * std::sqrt(dot(expected[i], expected[i]))));
        }
        ++sets;
    }
    CHECK(sets >= 4);
}

/// The parts of degree 3: gradients at sites, with the file's classification of the hull, and, with frames,
/// the coefficients of values and gradients at a point.
template <std::size_t D>
void check_parts(const std::string& file) {
    for (const auto& set : read_sets(file)) {
        CAPTURE(file, set["name"].get<std::string>());
        const auto sites = read_points<D>(set["sites"]);
        const std::size_t n = sites.size();
        const detail::NaturalNeighbours<D> neighbours(
            sites,
            coincidence_tolerance(bounds_of(std::span<const Vec<double, D>>(sites.data(), sites.size()))));
        const detail::SiteGradientRows<D> rows(neighbours, SiteGradients::facets,
                                               set["on_hull"].get<std::vector<bool>>());
        for (const auto& expected : set["gradient_rows"]) {
            if (set["name"] == turned_lattice) break;
            std::vector<Vec<double, D>> row(n), found(n);
            double largest = 0;
            for (const auto& term : expected["terms"]) {
                const auto v = read_points<D>(nlohmann::json::array({term["vector"]}))[0];
                row[term["site"].get<std::size_t>()] = v;
                largest = cageform_tests::larger(largest, std::sqrt(dot(v, v)));
            }
            for (const auto& term : rows.row(expected["site"].get<std::size_t>()))
                found[term.site] = found[term.site] + term.vector;
            for (std::size_t i = 0; i < n; ++i) CHECK(distance(row[i], found[i]) <= 1e-12 * largest);
        }
        const SibsonCoordinates<double, D> tips(sites, {.degree = 3, .frames = true});
        REQUIRE(tips.handles().size() == (D + 1) * n);
        for (const auto& entry : set["points"]) {
            const auto row =
                evaluate_all(tips, read_points<D>(nlohmann::json::array({entry["point"]}))).rows[0];
            const auto expected = read_points<D>(entry["gradient_weights"]);
            const double size =
                bounds_of(std::span<const Vec<double, D>>(sites.data(), sites.size())).diagonal();
            for (std::size_t i = 0; i < n; ++i) {
                double value = row[i];
                for (std::size_t k = 0; k < D; ++k) {
                    const double w = row[n + D * i + k];
                    value += w;
                    const double reach = tips.handles()[n + D * i + k][k] - sites[i][k];
                    CHECK(std::fabs(w * reach - expected[i][k]) <= 1e-13 * size);
                }
                CHECK(std::fabs(value - entry["value_weights"][i].get<double>()) <= 1e-12);
            }
        }
    }
}

/// The older files of decimals, with lattices and rings.
template <std::size_t D>
void check_older(const std::string& name) {
    CAPTURE(name);
    const auto json = read_json(name);
    const auto row = evaluate_all(SibsonCoordinates<double, D>(read_points<D>(json["sites"])),
                                  read_points<D>(json["points"]));
    REQUIRE(row.rows.size() >= 5);
    for (std::size_t n = 0; n < row.rows.size(); ++n) {
        for (std::size_t i = 0; i < row.rows[n].size(); ++i)
            CHECK(std::fabs(row.rows[n][i] - json["coordinates"][n][i].get<double>()) <= 1e-13);
    }
}

// ---- random sets --------------------------------------------------------------------------------

/// Random sites, clusters, a lattice, or rings around an axis.
template <std::size_t D>
Points<D> random_sites(std::uint64_t seed) {
    Random random(seed);
    Points<D> sites;
    const std::size_t kind = seed % 4;
    if (kind < 2) {
        for (std::size_t i = 0; i < 30; ++i) {
            Vec<double, D> p{};
            const double size = kind == 1 && i > 8 ? 0.05 : 1;
            for (std::size_t k = 0; k < D; ++k)
                p[k] = size * random.uniform(-1, 1) + (1 - size) * (i % 2 == 0 ? 0.3 : -0.6);
            sites.push_back(p);
        }
    } else if (kind == 2) {
        for (std::size_t i = 0; i < (D == 2 ? 16u : 27u); ++i) {
            const std::size_t side = D == 2 ? 4 : 3;
            Vec<double, D> p{double(i % side) / 2, double(i / side % side) / 2};
            if constexpr (D == 3) p[2] = double(i / 9) / 2;
            sites.push_back(p);
        }
    } else {
        for (std::size_t i = 0; i < 24; ++i) {
            const double angle = std::numbers::pi / 4 * double(i % 8), ring = double(i / 8);
            Vec<double, D> p{std::cos(angle), std::sin(angle)};
            if constexpr (D == 3)
                p[2] = ring;
            else
                p = (1 + ring) * p;
            sites.push_back(p);
        }
    }
    return sites;
}

/// A random motion and scaling.
template <std::size_t D>
Points<D> moved(Points<D> points, std::uint64_t seed) {
    Random random(seed + 1000);
    const double a = random.uniform(0, 6), b = random.uniform(0, 6),
                 scale = std::pow(10.0, random.uniform(-3, 3));
    for (auto& p : points) {
        for (std::size_t k = 0; k + 1 < D; ++k) {
            const double angle = k == 0 ? a : b;
            const double x = p[k], y = p[k + 1];
            p[k] = std::cos(angle) * x - std::sin(angle) * y;
            p[k + 1] = std::sin(angle) * x + std::cos(angle) * y;
        }
        for (std::size_t k = 0; k < D; ++k) p[k] = scale * (p[k] + 0.5 * double(k));
    }
    return points;
}

/// Points inside the hull: convex combinations of sites.
template <std::size_t D>
Points<D> mixtures(const Points<D>& sites, std::uint64_t seed, std::size_t count = 12) {
    Random random(seed + 77);
    Points<D> points(count);
    for (auto& p : points) {
        double sum = 0;
        for (std::size_t k = 0; k < 2 * D; ++k) {
            const double share = random.uniform(0.05, 1);
            p = p + share * sites[random.below(sites.size())];
            sum += share;
        }
        p = (1 / sum) * p;
    }
    return points;
}

template <class C, class P>
auto rows_of(const C& coordinates, const P& points, const Running& running = {}) {
    const auto all = evaluate_all(coordinates, points, running);
    REQUIRE(all.status() == Status::ok);
    for (const PointState state : all.states)
        REQUIRE((state == PointState::inside || state == PointState::on_boundary));
    return all.rows;
}

template <class R>
double farthest(const R& a, const R& b) {
    double worst = 0;
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i)
        worst = cageform_tests::larger(worst, std::fabs(double(a[i]) - double(b[i])));
    return worst;
}

template <class T, std::size_t D>
void check_laws(std::uint64_t seed) {
    CAPTURE(seed, D);
    const auto sites = rounded<T>(moved(random_sites<D>(seed), seed));
    Points<D> wide;
    for (const auto& s : sites) wide.push_back(vec_cast<double>(s));
    const auto points = rounded<T>(mixtures(wide, seed));
    const double size = double(bounds_of(std::span<const Vec<T, D>>(sites)).magnitude());
    const detail::NaturalNeighbours<D> neighbours(
        wide, double(coincidence_tolerance(bounds_of(std::span<const Vec<T, D>>(sites)))));
    for (const SibsonOptions options :
         {SibsonOptions{}, SibsonOptions{.degree = 3}, SibsonOptions{.degree = 3, .frames = true}}) {
        CAPTURE(options.degree, options.frames);
        // At degree 3 a weight is a sum of gradients of many sites, with terms larger than the weight.
        const double tolerance = (options.degree == 1 ? 4 : 12) * double(epsilon<T>);
        const SibsonCoordinates<T, D> sibson(sites, options);
        const auto rows = rows_of(sibson, points);
        for (std::size_t n = 0; n < rows.size(); ++n) {
            double sizes = 0;
            for (const T w : rows[n]) sizes += std::fabs(double(w));
            CHECK(std::fabs(double(sum_of(rows[n]) - 1)) <= tolerance * sizes);
            CHECK(distance(combine(rows[n], sibson.handles()), points[n]) <= tolerance * size * sizes);
            if (options.degree == 1) CHECK(*std::min_element(rows[n].begin(), rows[n].end()) >= 0);
        }
        // Interpolation.
        const auto units = rows_of(sibson, sites);
        for (std::size_t i = 0; i < sites.size(); ++i) {
            for (std::size_t h = 0; h < units[i].size(); ++h) CHECK(units[i][h] == T(h == i ? 1 : 0));
        }
    }
}

/// A weight is positive exactly in the balls of the Delaunay simplices at its site.
template <std::size_t D>
void check_support(std::uint64_t seed) {
    CAPTURE(seed, D);
    const auto sites = random_sites<D>(4 * seed); // no point is near a ball's boundary
    const auto points = mixtures(sites, seed);
    const auto rows = rows_of(SibsonCoordinates<double, D>(sites), points);
    const detail::SiteLattice<D> lattice(
        bounds_of(std::span<const Vec<double, D>>(sites.data(), sites.size())));
    std::vector<detail::LatticePoint<D>> places;
    for (const auto& s : sites) places.push_back(lattice.position(s));
    const Delaunay<D> delaunay(places);
    for (std::size_t n = 0; n < points.size(); ++n) {
        std::vector<bool> near(sites.size());
        for (const auto& simplex : delaunay.simplices()) {
            if (simplex.is_ghost() ||
                detail::in_sphere<D>(delaunay.corners(simplex), lattice.position(points[n])) <= 0)
                continue;
            for (const std::uint32_t v : simplex.vertex) near[delaunay.site(v)] = true;
        }
        for (std::size_t i = 0; i < sites.size(); ++i) CHECK((rows[n][i] > 0) == near[i]);
    }
}

/// The area of the cell of `p` among `sites`, clipped by the cell of site `i` unless it is none.
double clipped_area(const Points<2>& sites, const Vec<double, 2>& p, std::size_t i) {
    Points<2> cell{{-1e3, -1e3}, {1e3, -1e3}, {1e3, 1e3}, {-1e3, 1e3}};
    const auto clip = [&](const Vec<double, 2>& near, const Vec<double, 2>& far) {
        Points<2> cut;
        const auto side = [&](const Vec<double, 2>& x) {
            return dot(far - near, x) - 0.5 * (dot(far, far) - dot(near, near));
        };
        for (std::size_t a = 0; a < cell.size(); ++a) {
            const auto &from = cell[a], &to = cell[(a + 1) % cell.size()];
            const double s = side(from), t = side(to);
            if (s <= 0) cut.push_back(from);
            if ((s < 0 && t > 0) || (s > 0 && t < 0)) cut.push_back(from + (s / (s - t)) * (to - from));
        }
        cell = cut;
    };
    for (std::size_t j = 0; j < sites.size(); ++j) {
        clip(p, sites[j]);
        if (i < sites.size() && j != i) clip(sites[i], sites[j]);
        if (cell.empty()) return 0;
    }
    double area = 0;
    for (std::size_t a = 0; a < cell.size(); ++a)
        area += cross(cell[a] - p, cell[(a + 1) % cell.size()] - p) / 2;
    return area;
}

/// Expects equal weights for moved, rotated, scaled and reordered sites; reordered sites bitwise.
template <std::size_t D>
void check_invariance(std::uint64_t seed) {
    CAPTURE(seed, D);
    const auto sites = random_sites<D>(seed);
    auto points = mixtures(sites, seed);
    const auto all = [&](const Points<D>& list) { // moves both alike
        auto joined = list;
        joined.insert(joined.end(), points.begin(), points.end());
        return moved(joined, seed);
    };
    const auto joined = all(sites);
    const Points<D> there(joined.begin(), joined.begin() + std::ptrdiff_t(sites.size()));
    const Points<D> points_there(joined.begin() + std::ptrdiff_t(sites.size()), joined.end());
    const Points<D> reversed(sites.rbegin(), sites.rend());
    for (const int degree : {1, 3}) {
        CAPTURE(degree);
        const auto rows = rows_of(SibsonCoordinates<double, D>(sites, {.degree = degree}), points);
        const auto other = rows_of(SibsonCoordinates<double, D>(there, {.degree = degree}), points_there);
        const auto back = rows_of(SibsonCoordinates<double, D>(reversed, {.degree = degree}), points);
        for (std::size_t n = 0; n < rows.size(); ++n) {
            double sizes = 0;
            for (const double w : rows[n]) sizes += std::fabs(w);
            CHECK(farthest(rows[n], other[n]) <= 1e-12 * sizes * sizes);
            if (degree == 1) CHECK(rows[n] == std::vector<double>(back[n].rbegin(), back[n].rend()));
        }
    }
}

} // namespace

TEMPLATE_TEST_CASE("sibson has the exact weights of the reference files", "[coordinates][sibson]",
                   CAGEFORM_SCALARS) {
    check_file<TestType, 2>("sibson-2d", 1);
    check_file<TestType, 3>("sibson-3d", 1);
    check_file<TestType, 2>("sibson-c1-2d", 3);
    check_file<TestType, 3>("sibson-c1-3d", 3);
}

TEST_CASE("sibson has the parts of degree 3 and the weights of the older files", "[coordinates][sibson]") {
    check_parts<2>("sibson-c1-2d");
    check_parts<3>("sibson-c1-3d");
    for (const std::string name : {"grid", "random", "ring"}) check_older<2>("sibson2d_" + name + "_points");
    for (const std::string name : {"cube", "random"}) check_older<3>("sibson3d_" + name + "_points_3d");
}

TEMPLATE_TEST_CASE("sibson sums to one, reproduces its point and interpolates",
                   "[coordinates][sibson][property]", CAGEFORM_SCALARS) {
    const auto seed = GENERATE(range(0, 8));
    check_laws<TestType, 2>(std::uint64_t(seed));
    check_laws<TestType, 3>(std::uint64_t(seed));
}

TEST_CASE("a sibson weight is positive exactly in the balls at its site", "[coordinates][sibson][property]") {
    const auto seed = GENERATE(range(0, 6));
    check_support<2>(std::uint64_t(seed));
    check_support<3>(std::uint64_t(seed));
}

TEST_CASE("sibson agrees with clipped Voronoi cells", "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 12)));
    CAPTURE(seed);
    const auto sites = random_sites<2>(seed);
    const auto points = mixtures(sites, seed);
    const auto all = evaluate_all(SibsonCoordinates<double, 2>(sites), points);
    std::size_t compared = 0;
    for (std::size_t n = 0; n < points.size(); ++n) {
        const double area = clipped_area(sites, points[n], sites.size());
        if (all.states[n] != PointState::inside || area > 1e3)
            continue; // next to the hull the oracle's box changes the result
        for (std::size_t i = 0; i < sites.size(); ++i)
            CHECK(std::fabs(all.rows[n][i] - clipped_area(sites, points[n], i) / area) <= 1e-9);
        ++compared;
    }
    CHECK(compared > 0);
}

TEST_CASE("sibson does not depend on motion, scale or order", "[coordinates][sibson][property]") {
    const auto seed = GENERATE(range(0, 8));
    check_invariance<2>(std::uint64_t(seed));
    check_invariance<3>(std::uint64_t(seed));
}

// ---- the hull -----------------------------------------------------------------------------------

TEST_CASE("sibson is linear on hull edges and barycentric on hull triangles",
          "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 6)));
    CAPTURE(seed);
    Random random(seed);
    // An edge with further sites: linear between the two sites next to the point.
    Points<2> sites{{0, 0}, {1, 0}, {4, 0}, {9, 0}, {9, 5}, {0, 5}, {3, 2}};
    sites = moved(sites, seed);
    const double s = random.uniform(0.01, 0.99);
    const auto row =
        rows_of(SibsonCoordinates<double, 2>(sites), Points<2>{(1 - s) * sites[1] + s * sites[2]})[0];
    const std::vector<double> expected{0, 1 - s, s, 0, 0, 0, 0};
    CHECK(farthest(row, expected) <= 1e-14);
    // A simplex, and a triangle of its hull.
    Points<3> corners(4);
    for (auto& p : corners) p = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    const double a = random.uniform(0.1, 0.4), b = random.uniform(0.1, 0.4);
    const SibsonCoordinates<double, 3> simplex(corners);
    const auto on =
        rows_of(simplex, Points<3>{a * corners[0] + b * corners[1] + (1 - a - b) * corners[2]})[0];
    CHECK(farthest(on, std::vector<double>{a, b, 1 - a - b, 0}) <= 1e-13);
    const auto in =
        rows_of(simplex, Points<3>{0.5 * (a * corners[0] + b * corners[1] + (1 - a - b) * corners[2]) +
                                   0.5 * corners[3]})[0];
    CHECK(farthest(in, std::vector<double>{a / 2, b / 2, (1 - a - b) / 2, 0.5}) <= 1e-13);
}

TEST_CASE("sibson is multilinear in boxes", "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 6)));
    CAPTURE(seed);
    Random random(seed);
    const Vec<double, 3> size{random.uniform(0.1, 5), random.uniform(0.1, 5), random.uniform(0.1, 5)};
    Points<3> corners;
    for (std::size_t n = 0; n < 8; ++n)
        corners.push_back({double(n & 1) * size[0], double(n >> 1 & 1) * size[1], double(n >> 2) * size[2]});
    // Inside, next to a face and on it.
    for (const double z : {random.uniform(0.1, 0.9), 0x1p-20, 0x1p-40, 0.0}) {
        CAPTURE(z);
        const Vec<double, 3> t{random.uniform(0.1, 0.9), random.uniform(0.1, 0.9), z};
        const auto row = rows_of(SibsonCoordinates<double, 3>(corners),
                                 Points<3>{{t[0] * size[0], t[1] * size[1], t[2] * size[2]}})[0];
        for (std::size_t n = 0; n < 8; ++n) {
            double w = 1;
            for (std::size_t k = 0; k < 3; ++k) w *= (n >> k & 1) != 0 ? t[k] : 1 - t[k];
            CHECK(std::fabs(row[n] - w) <= 1e-13);
        }
    }
}

TEST_CASE("sibson is continuous at a hull facet", "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 6)));
    CAPTURE(seed);
    Random random(seed);
    // A flat facet of six sites, below others. Sibson's 2D coordinates differ by 1e-2 there.
    Points<3> sites;
    for (std::size_t n = 0; n < 6; ++n) {
        const double angle = std::numbers::pi / 3 * (double(n) + random.uniform(-0.3, 0.3));
        const double radius = random.uniform(0.8, 1.2);
        sites.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    }
    for (std::size_t n = 0; n < 4; ++n)
        sites.push_back({random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(1, 2)});
    const SibsonCoordinates<double, 3> sibson(sites);
    const Vec<double, 3> p{random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), 0};
    const auto on = evaluate_all(sibson, Points<3>{p});
    REQUIRE(on.states[0] == PointState::on_boundary);
    for (const double depth : {0x1p-10, 0x1p-20, 0x1p-40}) {
        CAPTURE(depth);
        const auto near = evaluate_all(sibson, Points<3>{{p[0], p[1], depth}});
        REQUIRE(near.states[0] == PointState::inside);
        CHECK(farthest(near.rows[0], on.rows[0]) <= 4 * depth + 1e-12);
    }
    Points<2> plane;
    for (std::size_t n = 0; n < 6; ++n) plane.push_back({sites[n][0], sites[n][1]});
    auto row = evaluate_all(SibsonCoordinates<double, 2>(plane), Points<2>{{p[0], p[1]}}).rows[0];
    row.resize(10, 0);
    CHECK(farthest(row, on.rows[0]) > 1e-4);
}

TEST_CASE("sibson treats a face flat to rounding as flat", "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 8)));
    CAPTURE(seed);
    Random random(seed);
    Points<3> lattice, points;
    for (std::size_t n = 0; n < 27; ++n) lattice.push_back({double(n % 3), double(n / 3 % 3), double(n / 9)});
    for (std::size_t n = 0; n < 8; ++n) points.push_back({random.uniform(0, 2), random.uniform(0, 2), 0});
    const auto rows = rows_of(SibsonCoordinates<double, 3>(lattice), points);
    auto joined = lattice;
    joined.insert(joined.end(), points.begin(), points.end());
    joined = moved(joined, seed);
    const Points<3> there(joined.begin(), joined.begin() + 27);
    const auto all =
        evaluate_all(SibsonCoordinates<double, 3>(there), Points<3>(joined.begin() + 27, joined.end()));
    for (std::size_t n = 0; n < points.size(); ++n) {
        CHECK(all.states[n] == PointState::on_boundary);
        CHECK(farthest(rows[n], all.rows[n]) <= 1e-12);
    }
}

TEST_CASE("sibson outside the hull: kept in place, or at the nearest point",
          "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 4)));
    CAPTURE(seed);
    const auto sites = random_sites<3>(seed);
    const SibsonCoordinates<double, 3> sibson(sites);
    Random random(seed);
    for (int n = 0; n < 20; ++n) {
        const double far = std::pow(10.0, random.uniform(0, n == 0 ? 300 : 6));
        const Vec<double, 3> p{far * random.uniform(-4, 4), far * random.uniform(3, 4),
                               far * random.uniform(-4, 4)};
        std::vector<double> row(sites.size());
        CHECK(weights_at(sibson, p, std::span<double>(row)) == PointState::outside);
        const auto place = sibson.nearest_boundary(p, row);
        CHECK(std::fabs(double(sum_of(row)) - 1) <= 1e-14);
        CHECK(distance(combine(row, sites), place) <= 1e-13);
        if (far > 1e6) continue;
        for (const auto& q : mixtures(sites, std::uint64_t(n)))
            CHECK(distance(p, place) <= distance(p, q) * (1 + 1e-12));
    }
    // Binds figures that are half outside.
    auto points = mixtures(sites, seed);
    for (std::size_t n = 0; n < points.size(); n += 2) points[n][1] += 10;
    for (const auto outside :
         {OutsidePoints::extend, OutsidePoints::keep_in_place, OutsidePoints::nearest_boundary}) {
        const auto result = bind(sibson, points, BindOptions{.outside = outside});
        CHECK(result.report.status == Status::ok);
        CHECK(result.report.outside.size() == (points.size() + 1) / 2);
        CHECK(result.report.amplification.value <= 1 + 1e-12);
    }
}

/// Sites of which most lie within `off` of a plane (a line): nearly coplanar hull facets.
template <std::size_t D>
void check_nearly_flat_hull(std::uint64_t seed) {
    Random random(seed + 500);
    const double off = std::pow(10.0, random.uniform(-16, -9));
    CAPTURE(D, seed, off);
    Points<D> sites(14);
    for (std::size_t i = 0; i < sites.size(); ++i) {
        for (std::size_t k = 0; k < D; ++k) sites[i][k] = random.uniform(-1, 1);
        sites[i][D - 1] = i < 11 ? off * sites[i][D - 1] : -1;
    }
    const SibsonCoordinates<double, D> sibson(sites);
    REQUIRE(sibson.cage_report().status == Status::ok);
    for (int n = 0; n < 20; ++n) {
        Vec<double, D> p{};
        for (std::size_t k = 0; k < D; ++k) p[k] = random.uniform(-1.2, 1.2);
        p[D - 1] = n % 2 == 0 ? std::fabs(p[D - 1]) : 0;
        std::vector<double> row(sites.size());
        const auto place = sibson.nearest_boundary(p, row);
        CHECK(distance(combine(row, sites), place) <= 1e-13);
        const PointState state = weights_at(sibson, p, std::span<double>(row));
        if (state != PointState::outside) CHECK(distance(combine(row, sites), p) <= 1e-13);
    }
}

TEST_CASE("sibson reproduces points of a hull with triangles thin to rounding",
          "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 40)));
    Random random(seed + 900);
    const double off = std::pow(10.0, random.uniform(-13, -9));
    CAPTURE(seed, off);
    Points<3> sites(6);
    for (auto& p : sites) {
        const double x = random.uniform(-1, 1);
        p = {x + off * random.uniform(-1, 1), x + off * random.uniform(-1, 1),
             2 * x + off * random.uniform(-1, 1)};
    }
    const SibsonCoordinates<double, 3> sibson(sites);
    if (sibson.cage_report().status != Status::ok) return; // coplanar up to rounding
    for (int n = 0; n < 20; ++n) {
        const Vec<double, 3> p{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        std::vector<double> row(sites.size());
        const auto place = sibson.nearest_boundary(p, row);
        CHECK(std::fabs(double(sum_of(row)) - 1) <= 1e-14);
        CHECK(*std::min_element(row.begin(), row.end()) >= 0);
        CHECK(distance(combine(row, sites), place) <= 1e-14);
    }
}

TEST_CASE("sibson uses the nearest of nearly coplanar hull facets", "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 30)));
    check_nearly_flat_hull<2>(seed);
    check_nearly_flat_hull<3>(seed);
}

// ---- locality -----------------------------------------------------------------------------------

TEST_CASE("a site without weight changes no other weight, to the bit", "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 12)));
    CAPTURE(seed);
    const auto sites = random_sites<3>(4 * seed);
    const auto points = mixtures(sites, seed, 100);
    const auto rows = rows_of(SibsonCoordinates<double, 3>(sites), points);
    auto more = sites;
    more.push_back(mixtures(sites, seed + 5, 1)[0]);
    const auto with = rows_of(SibsonCoordinates<double, 3>(more), points);
    std::size_t untouched = 0;
    for (std::size_t n = 0; n < points.size(); ++n) {
        if (with[n].back() != 0) continue;
        CHECK(rows[n] == std::vector<double>(with[n].begin(), with[n].end() - 1));
        ++untouched;
    }
    CHECK(untouched > 0);
    // A point at the position of a site.
    more.back() = points[0];
    CHECK(rows_of(SibsonCoordinates<double, 3>(more), points)[0].back() == 1);
}

/// Sibson's weights with a relative error each. Those of one site are negative, so that `bind` does not
/// project the weights of points near it, which would keep zeros too.
template <class T, bool Local>
struct Disturbed {
    using scalar = T;
    static constexpr std::size_t dimension = 3;
    static constexpr bool has_extension = false, closed_form = true, local = Local;
    SibsonCoordinates<T, 3> sibson;

    auto handles() const noexcept { return sibson.handles(); }
    const cageform::CageReport& cage_report() const noexcept { return sibson.cage_report(); }
    cageform::Evaluation evaluate(cageform::BlockView<const T> points, cageform::BlockView<T> weights,
                                  std::span<PointState> states, const cageform::Running& running = {}) const {
        const auto result = sibson.evaluate(points, weights, states, running);
        for (std::size_t i = 0; i < points.points; ++i) {
            for (std::size_t h = 0; h < handles().size(); ++h)
                weights(i, h) *= (h == 0 ? T(-1) : T(1)) + T(0x1p-12) * T(int(h % 3) - 1);
        }
        return result;
    }
    Vec<T, 3> nearest_boundary(const Vec<T, 3>& p, std::span<T> row) const {
        return sibson.nearest_boundary(p, row);
    }
};

TEMPLATE_TEST_CASE("bind keeps exact zeros when it restores linear precision",
                   "[coordinates][sibson][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = std::uint64_t(GENERATE(range(0, 4)));
    CAPTURE(seed);
    const auto wide = random_sites<3>(seed);
    const auto sites = rounded<T>(wide), points = rounded<T>(mixtures(wide, seed, 60));
    const SibsonCoordinates<T, 3> sibson(sites);
    REQUIRE(sibson.cage_report().status == Status::ok);
    const auto result = bind(Disturbed<T, true>{sibson}, points);
    CHECK(result.report.weight_change.value > 0x1p-20);
    CHECK(result.report.not_restored.empty());
    const auto everywhere = bind(Disturbed<T, false>{sibson}, points);
    const auto exact = bind(sibson, points);
    std::size_t lost = 0, lost_everywhere = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t h = 0; h < sites.size(); ++h) {
            if (exact.value.weight(i, h) != 0) continue;
            lost += result.value.weight(i, h) != 0 ? 1 : 0;
            lost_everywhere += everywhere.value.weight(i, h) != 0 ? 1 : 0;
        }
    }
    CHECK(lost == 0);
    CHECK(lost_everywhere > 0);
}

TEST_CASE("sibson gives the same bits for any number of threads", "[coordinates][sibson]") {
    const auto sites = random_sites<3>(2);
    const auto points = mixtures(sites, 1, 500);
    for (const int degree : {1, 3}) {
        const SibsonCoordinates<double, 3> sibson(sites, {.degree = degree});
        CHECK(rows_of(sibson, points) == rows_of(sibson, points, {.parallel = ThreadedFor{4}}));
    }
    // In another order of points, walks begin elsewhere.
    const SibsonCoordinates<double, 3> sibson(sites);
    auto forth = rows_of(sibson, points), back = rows_of(sibson, Points<3>(points.rbegin(), points.rend()));
    std::reverse(back.begin(), back.end());
    CHECK(forth == back);
}

// ---- gradients ----------------------------------------------------------------------------------

namespace {

template <std::size_t D>
void check_gradients(std::uint64_t seed, const SibsonOptions& options) {
    CAPTURE(seed, D, options.degree, options.frames);
    const auto sites = random_sites<D>(seed);
    const SibsonCoordinates<double, D> sibson(sites, options);
    const std::size_t handles = sibson.handles().size();
    for (const auto& p : mixtures(sites, seed, 4)) {
        const auto found = gradients_of<double, D>(sibson, {p});
        if (found.states[0] != PointState::inside) continue;
        const double h = 1e-5;
        Vec<double, D> sum{};
        for (const auto& g : found.rows[0]) sum = sum + g;
        CHECK(std::sqrt(dot(sum, sum)) <= 1e-10);
        for (std::size_t k = 0; k < D; ++k) {
            auto low = p, high = p;
            low[k] -= h;
            high[k] += h;
            const auto rows = evaluate_all(sibson, Points<D>{low, high}).rows;
            double size = 1;
            for (const auto& g : found.rows[0]) size = cageform_tests::larger(size, std::fabs(g[k]));
            // Second derivatives jump on Delaunay spheres.
            for (std::size_t i = 0; i < handles; ++i)
                CHECK(std::fabs((rows[1][i] - rows[0][i]) / (2 * h) - found.rows[0][i][k]) <= 2e-3 * size);
            // Σ c ∇wᵀ = identity.
            Vec<double, D> moment{};
            for (std::size_t i = 0; i < handles; ++i)
                moment = moment + found.rows[0][i][k] * sibson.handles()[i];
            moment[k] -= 1;
            CHECK(std::sqrt(dot(moment, moment)) <= 1e-10 * size);
        }
    }
}

} // namespace

TEST_CASE("gradients of sibson are derivatives of its weights", "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 4)));
    for (const SibsonOptions options :
         {SibsonOptions{}, SibsonOptions{.degree = 3}, SibsonOptions{.degree = 3, .frames = true}}) {
        check_gradients<2>(seed, options);
        check_gradients<3>(seed, options);
    }
}

TEST_CASE("gradients of sibson are continuous across a Delaunay circle", "[coordinates][sibson]") {
    // The circle around the square passes through the interior of a larger hull.
    Points<2> sites{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {-3, -2}, {4, -2}, {4, 3}, {-3, 3}};
    const double angle = GENERATE(0.2, 1.3, 4.0);
    const Vec<double, 2> out{std::cos(angle), std::sin(angle)};
    for (const int degree : {1, 3}) {
        const SibsonCoordinates<double, 2> sibson(sites, {.degree = degree});
        const Vec<double, 2> centre{0.5, 0.5};
        const auto found = gradients_of<double, 2>(
            sibson, {centre + (std::sqrt(0.5) - 1e-9) * out, centre + (std::sqrt(0.5) + 1e-9) * out});
        for (std::size_t i = 0; i < sites.size(); ++i)
            CHECK(distance(found.rows[0][i], found.rows[1][i]) <= 1e-7);
    }
}

TEST_CASE("gradients of sibson at sites and on the hull are those slightly inside", "[coordinates][sibson]") {
    const auto check = []<std::size_t D>(const Points<D>& sites, const Points<D>& points) {
        const SibsonCoordinates<double, D> sibson(sites);
        const auto found = gradients_of<double, D>(sibson, points);
        REQUIRE(found.evaluation.status == Status::ok);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(D, i);
            CHECK(law_error<double, D>(std::span<const Vec<double, D>>(sites.data(), sites.size()), points[i],
                                       found.rows[i]) <= 1e-6);
        }
    };
    Random random(5);
    Points<2> plane{{0, 0}, {4, 0}, {4, 3}, {0, 3}};
    Points<3> space;
    for (int n = 0; n < 8; ++n) space.push_back({4.0 * (n & 1), 3.0 * (n >> 1 & 1), 2.0 * (n >> 2)});
    for (int n = 0; n < 8; ++n) {
        plane.push_back({random.uniform(0.5, 3.5), random.uniform(0.5, 2.5)});
        space.push_back({random.uniform(0.5, 3.5), random.uniform(0.5, 2.5), random.uniform(0.5, 1.5)});
    }
    auto in_plane = plane; // all sites, and points between neighbours on the hull
    in_plane.insert(in_plane.end(), {{1, 0}, {4, 1.5}, {2.5, 3}});
    auto in_space = space;
    in_space.insert(in_space.end(), {{1, 0, 0}, {1, 1, 0}, {4, 1.5, 0.5}});
    check(plane, in_plane);
    check(space, in_space);
}

TEST_CASE("degree 3 has the estimated gradient at a site, from every side", "[coordinates][sibson]") {
    const auto sites = random_sites<3>(0);
    for (const auto rule : {SiteGradients::facets, SiteGradients::gentle, SiteGradients::mirrored}) {
        const SibsonCoordinates<double, 3> sibson(sites, {.degree = 3, .gradients = rule});
        const auto near = rows_of(sibson, sites); // units
        for (std::size_t i = 0; i < 6; ++i) {
            const auto at = gradients_of<double, 3>(sibson, {sites[i]});
            Random random(i);
            for (int n = 0; n < 3; ++n) {
                // Towards the inside of the hull.
                const auto q = sites[i] + 1e-7 * (mixtures(sites, i + std::uint64_t(n), 1)[0] - sites[i]);
                const auto beside = gradients_of<double, 3>(sibson, {q});
                for (std::size_t h = 0; h < sites.size(); ++h)
                    CHECK(distance(at.rows[0][h], beside.rows[0][h]) <= 1e-4);
            }
        }
    }
}

// ---- degree 3 -----------------------------------------------------------------------------------

TEST_CASE("degree 3 is the cubic simplex of Farin", "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 4)));
    CAPTURE(seed);
    Random random(seed);
    const auto sites = random_sites<3>(seed);
    const std::size_t n = sites.size();
    const SibsonCoordinates<double, 3> cubic(sites, {.degree = 3, .frames = true});
    std::vector<double> z(n), pose(4 * n);
    Points<3> g(n);
    for (std::size_t i = 0; i < n; ++i) {
        z[i] = random.uniform(-1, 1);
        g[i] = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        pose[i] = z[i];
        for (std::size_t k = 0; k < 3; ++k)
            pose[n + 3 * i + k] = z[i] + g[i][k] * (cubic.handles()[n + 3 * i + k][k] - sites[i][k]);
    }
    const auto b2 = [&](std::size_t i, std::size_t j) { return z[i] + dot(g[i], sites[j] - sites[i]) / 3; };
    for (const auto& p : mixtures(sites, seed, 4)) {
        const auto u = rows_of(SibsonCoordinates<double, 3>(sites), Points<3>{p})[0];
        double sum = 0;
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = 0; j < n; ++j) {
                for (std::size_t k = 0; u[i] * u[j] != 0 && k < n; ++k) {
                    double b = z[i];
                    if (i != j && j != k && i != k) {
                        b = (b2(i, j) + b2(j, i) + b2(i, k) + b2(k, i) + b2(j, k) + b2(k, j)) / 4 -
                            (z[i] + z[j] + z[k]) / 6;
                    } else if (i == j && j != k) {
                        b = b2(i, k);
                    } else if (i == k && j != k) {
                        b = b2(i, j);
                    } else if (j == k && i != j) {
                        b = b2(j, i);
                    }
                    sum += b * u[i] * u[j] * u[k];
                }
            }
        }
        const auto row = rows_of(cubic, Points<3>{p})[0];
        double value = 0;
        for (std::size_t h = 0; h < row.size(); ++h) value += row[h] * pose[h];
        CHECK(std::fabs(value - sum) <= 1e-12);
    }
}

TEST_CASE("degree 3 reproduces quadratics", "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 6)));
    CAPTURE(seed);
    Random random(seed);
    double c[3], m[3][3];
    for (std::size_t a = 0; a < 3; ++a) {
        c[a] = random.uniform(-1, 1);
        for (std::size_t b = 0; b <= a; ++b) m[a][b] = m[b][a] = random.uniform(-1, 1);
    }
    const auto f = [&](const Vec<double, 3>& x) {
        double sum = 0.3;
        for (std::size_t a = 0; a < 3; ++a) {
            sum += c[a] * x[a];
            for (std::size_t b = 0; b < 3; ++b) sum += m[a][b] * x[a] * x[b];
        }
        return sum;
    };
    const auto interpolated = [&](const auto& coordinates, const std::vector<double>& pose,
                                  const Vec<double, 3>& p) {
        const auto row = rows_of(coordinates, Points<3>{p})[0];
        double value = 0;
        for (std::size_t h = 0; h < row.size(); ++h) value += row[h] * pose[h];
        return value;
    };
    // With given gradients, by frames: everywhere.
    const auto sites = random_sites<3>(seed);
    const std::size_t n = sites.size();
    const SibsonCoordinates<double, 3> tips(sites, {.degree = 3, .frames = true});
    std::vector<double> pose(4 * n);
    for (std::size_t i = 0; i < n; ++i) {
        pose[i] = f(sites[i]);
        for (std::size_t k = 0; k < 3; ++k) {
            double slope = c[k];
            for (std::size_t b = 0; b < 3; ++b) slope += 2 * m[k][b] * sites[i][b];
            pose[n + 3 * i + k] = f(sites[i]) + slope * (tips.handles()[n + 3 * i + k][k] - sites[i][k]);
        }
    }
    for (const auto& p : mixtures(sites, seed, 4))
        CHECK(std::fabs(interpolated(tips, pose, p) - f(p)) <= 1e-12);
    // With estimated gradients: in the middle of a lattice, where natural neighbours are inside.
    Points<3> lattice;
    std::vector<double> values;
    for (std::size_t i = 0; i < 64; ++i)
        lattice.push_back({double(i % 4), double(i / 4 % 4), double(i / 16)});
    for (const auto& x : lattice) values.push_back(f(x));
    const SibsonCoordinates<double, 3> estimated(lattice, {.degree = 3});
    const Vec<double, 3> p{random.uniform(1.4, 1.6), random.uniform(1.4, 1.6), random.uniform(1.4, 1.6)};
    CHECK(std::fabs(interpolated(estimated, values, p) - f(p)) <= 1e-11);
    // And a + b·x + γ|x|² if all natural neighbours are inside.
    const double gamma = random.uniform(-1, 1);
    const auto round = [&](const Vec<double, 3>& x) {
        return 0.3 + dot(Vec<double, 3>{c[0], c[1], c[2]}, x) + gamma * dot(x, x);
    };
    Points<3> jittered;
    for (std::size_t i = 0; i < 343; ++i)
        jittered.push_back({double(i % 7) + random.uniform(-0.2, 0.2),
                            double(i / 7 % 7) + random.uniform(-0.2, 0.2),
                            double(i / 49) + random.uniform(-0.2, 0.2)});
    values.clear();
    for (const auto& x : jittered) values.push_back(round(x));
    const Vec<double, 3> q{random.uniform(2.8, 3.2), random.uniform(2.8, 3.2), random.uniform(2.8, 3.2)};
    CHECK(std::fabs(interpolated(SibsonCoordinates<double, 3>(jittered, {.degree = 3}), values, q) -
                    round(q)) <= 1e-11);
}

TEST_CASE("sibson has linear precision in thin sets, and in ones as small as their rounding",
          "[coordinates][sibson][property]") {
    const auto seed = std::uint64_t(GENERATE(range(0, 4)));
    const double width = GENERATE(1e-3, 1e-7, 1e-11);
    CAPTURE(seed, width);
    auto sites = random_sites<3>(4 * seed);
    for (auto& p : sites) p[2] *= width;
    const auto points = mixtures(sites, seed);
    for (const int degree : {1, 3}) {
        const auto rows = rows_of(SibsonCoordinates<double, 3>(sites, {.degree = degree}), points);
        for (std::size_t n = 0; n < points.size(); ++n) {
            double sizes = 0;
            for (const double w : rows[n]) sizes += std::fabs(w);
            CHECK(std::fabs(double(sum_of(rows[n]) - 1)) <= 1e-14 * sizes);
            CHECK(distance(combine(rows[n], sites), points[n]) <= 1e-14 * sizes);
        }
    }
    // As long as two steps of float's tolerance.
    const std::vector<Vec<float, 2>> small{{1e6f, 1e6f}, {1e6f + 2, 1e6f}, {1e6f, 1e6f + 2}};
    const SibsonCoordinates<float, 2> sibson(small);
    REQUIRE(sibson.cage_report().status == Status::ok);
    const auto units = rows_of(sibson, small);
    for (std::size_t i = 0; i < 3; ++i) CHECK(units[i][i] == 1);
}

TEMPLATE_TEST_CASE("frames pose the neighbourhood of a site", "[coordinates][sibson][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = std::uint64_t(GENERATE(range(0, 4)));
    CAPTURE(seed);
    const auto wide = random_sites<3>(seed);
    const auto sites = rounded<T>(wide), points = rounded<T>(mixtures(wide, seed, 60));
    const SibsonCoordinates<T, 3> sibson(sites, {.degree = 3, .frames = true});
    REQUIRE(sibson.cage_report().status == Status::ok);
    const auto bound = bind(sibson, points);
    REQUIRE(bound.report.status == Status::ok);
    std::vector<Vec<T, 3>> pose(sibson.handles().size()), moved(points.size());

    // One affine map in all frames moves the figure by this map.
    Random random(seed);
    std::array<Vec<T, 3>, 3> columns;
    for (auto& column : columns)
        column = {T(random.uniform(-1, 1)), T(random.uniform(-1, 1)), T(random.uniform(-1, 1))};
    const auto map = [&](const Vec<T, 3>& p) {
        return p[0] * columns[0] + p[1] * columns[1] + p[2] * columns[2] + Vec<T, 3>{1, -2, 3};
    };
    std::vector<Vec<T, 3>> to;
    for (const auto& p : sites) to.push_back(map(p));
    std::vector<std::array<Vec<T, 3>, 3>> frames(sites.size(), columns);
    REQUIRE(sibson.pose_of(to, std::span(std::as_const(frames)), std::span(pose)) == Status::ok);
    REQUIRE(clone(bound.value, pose, moved) == Status::ok);
    const double size = double(bounds_of(std::span<const Vec<T, 3>>(sites)).diagonal()) + 10;
    for (std::size_t i = 0; i < points.size(); ++i)
        CHECK(distance(moved[i], map(points[i])) <= 2000 * double(epsilon<T>) * size);

    // A single frame acts near its site: to second order, the clone is the frame's map.
    for (auto& frame : frames) frame = {Vec<T, 3>{1, 0, 0}, Vec<T, 3>{0, 1, 0}, Vec<T, 3>{0, 0, 1}};
    frames[3] = columns;
    REQUIRE(sibson.pose_of(sites, std::span(std::as_const(frames)), std::span(pose)) == Status::ok);
    if constexpr (sizeof(T) == 8) {
        double gap = 1e30;
        for (std::size_t i = 0; i < sites.size(); ++i) {
            if (i != 3) gap = std::min(gap, distance(sites[i], sites[3]));
        }
        std::array<double, 2> errors{};
        for (std::size_t level = 0; level < 2; ++level) {
            const double step = gap * (level == 0 ? 1e-3 : 1e-4);
            const Vec<double, 3> toward = (step / std::sqrt(3)) * Vec<double, 3>{1, -1, 1};
            const auto near = bind(sibson, Points<3>{sites[3] + toward});
            Points<3> out(1);
            if (!near.report.outside.empty()) return; // the site is on the hull
            REQUIRE(clone(near.value, pose, out) == Status::ok);
            const auto expected =
                sites[3] + toward[0] * columns[0] + toward[1] * columns[1] + toward[2] * columns[2];
            errors[level] = distance(out[0], expected) / step;
        }
        CHECK(errors[1] < 0.2 * errors[0] + 1e-9);
    }

    const auto before = pose;
    CHECK(SibsonCoordinates<T, 3>(sites, {.degree = 3})
              .pose_of(sites, std::span(std::as_const(frames)), std::span(pose)) ==
          Status::sibson_degree_not_supported);
    CHECK(sibson.pose_of(points, std::span(std::as_const(frames)), std::span(pose)) ==
          Status::pose_size_differs);
    CHECK(sibson.pose_of(sites, std::span(std::as_const(frames)), std::span(pose).first(sites.size())) ==
          Status::output_too_small);
    frames[1][2][0] = std::numeric_limits<T>::quiet_NaN();
    CHECK(sibson.pose_of(sites, std::span(std::as_const(frames)), std::span(pose)) ==
          Status::pose_not_finite);
    CHECK(pose == before);
}

// ---- faults -------------------------------------------------------------------------------------

TEST_CASE("sibson names faults of sites", "[coordinates][sibson]") {
    const auto status = [](const auto& sites, const SibsonOptions& options = {}) {
        return SibsonCoordinates<double, 2>(sites, options).cage_report();
    };
    const Points<2> sound{{0, 0}, {1, 0}, {0, 1}};
    CHECK(status(sound).status == Status::ok);
    CHECK(status(Points<2>{{0, 0}, {1, 0}}).status == Status::too_few_vertices);
    CHECK(status(Points<2>{}).status == Status::too_few_vertices);
    CHECK(status(Points<2>{{0, 0}, {1, 0}, {std::numeric_limits<double>::quiet_NaN(), 1}, {0, 1}}).status ==
          Status::vertex_not_finite);
    const auto twice = status(Points<2>{{0, 0}, {1, 0}, {0, 1}, {1, 1e-16}, {0, 1}});
    CHECK(twice.status == Status::duplicate_vertices);
    REQUIRE(twice.faults.size() == 2);
    CHECK(twice.faults[0].a + twice.faults[0].b + twice.faults[1].a + twice.faults[1].b == 1 + 3 + 2 + 4);
    CHECK(status(Points<2>{{0, 0}, {1, 1}, {0.5, 0.5}, {0.3, 0.3 + 1e-16}}).status ==
          Status::sites_in_a_plane);
    CHECK(SibsonCoordinates<float, 3>(
              std::vector<Vec<float, 3>>{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1.0000001f}})
              .cage_report()
              .status == Status::sites_in_a_plane);
    CHECK(status(sound, {.degree = 2}).status == Status::sibson_degree_not_supported);
    // Moved-from coordinates bind nothing.
    SibsonCoordinates<double, 2> given(sound);
    const auto taken = std::move(given);
    CHECK(bind(taken, sound).report.status == Status::ok);
    CHECK(bind(given, sound).report.status == // NOLINT(bugprone-use-after-move): what is tested
          Status::coordinates_empty);
    // Nor do refused sites.
    CHECK(bind(SibsonCoordinates<double, 2>(Points<2>{}), sound).report.status == Status::too_few_vertices);
}

} // namespace sibson_tests

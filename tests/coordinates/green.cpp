#include "../support/green.hpp"
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/oracle.hpp"
#include "../support/thin_cages.hpp"

#include <cageform/coordinates/green.hpp>

namespace green_tests {

using namespace cageform;
using namespace cageform_tests;

namespace {

template <class T>
using Green2 = GreenCoordinates<T, 2>;

/// A 2D file of reference values: weights of the vertices and of the edges' unit normals, with lengths in the
/// file's unit.
struct PlaneFile {
    Points2<double> vertices, points;
    std::vector<std::size_t> loops;
    std::vector<std::vector<double>> phi, psi;
    nlohmann::json json;

    explicit PlaneFile(const std::string& name)
        : json(read_json(name)) {
        const auto places = [](const nlohmann::json& list) {
            Points2<double> result;
            for (const auto& p : list) result.push_back({p[0].get<double>(), p[1].get<double>()});
            return result;
        };
        vertices = places(json["cage"]["vertices"]);
        points = places(json["points"]);
        for (const auto& loop : json["cage"]["loops"])
            loops.push_back(loop.is_array() ? loop.size() : loop.get<std::size_t>());
        if (json.contains("rows")) {
            for (const auto& row : json["rows"]) {
                phi.push_back(row["phi_numbers"].get<std::vector<double>>());
                psi.push_back(row["psi_numbers"].get<std::vector<double>>());
            }
        } else {
            phi = json["vertex_coordinates"].get<std::vector<std::vector<double>>>();
            psi = json["edge_coordinates"].get<std::vector<std::vector<double>>>();
        }
    }
    Polygon<double> cage() const { return {vertices, loops}; }
};

/// φ, then the handle weights for ψ: divided by the length, with the cage's diagonal as unit of length.
std::vector<double> expected_row(const Green2<double>& green, const std::vector<double>& phi,
                                 const std::vector<double>& psi) {
    auto row = phi;
    const double gauge = std::log(bounds_of(green.cage().vertices()).diagonal()) / (2 * std::numbers::pi);
    for (std::size_t j = 0; j < psi.size(); ++j)
        row.push_back(psi[j] / detail::length(green.handles()[phi.size() + j]) + gauge);
    return row;
}

/// The definition in long double, for points inside.
template <class T>
std::vector<long double> by_definition(const Green2<T>& green, const Vec<T, 2>& at) {
    using L = long double;
    const auto p = vec_cast<L>(at);
    const std::size_t count = green.cage().size();
    std::vector<L> row(green.handles().size());
    const L unit = static_cast<L>(bounds_of(green.cage().vertices()).diagonal());
    for (std::size_t j = 0; j < green.handle_faces().size(); ++j) {
        const auto [from, to] = green.handle_faces()[j];
        const auto a = vec_cast<L>(green.cage()[from]) - p, b = vec_cast<L>(green.cage()[to]) - p, e = b - a;
        const L length = std::sqrt(dot(e, e)), size = 2 * std::numbers::pi_v<L> * length;
        const L ra = std::sqrt(dot(a, a)), rb = std::sqrt(dot(b, b));
        const L d = (ra < rb ? cross(a, e) : cross(b, e)) / length;
        const L s1 = dot(a, e) / length, s2 = dot(b, e) / length;
        const L theta = std::atan2(d * length, dot(a, b)), ratio = std::log(rb / ra);
        row[from] += (s2 * theta - d * ratio) / size;
        row[to] += (d * ratio - s1 * theta) / size;
        row[count + j] = -(s2 * std::log(rb / unit) - s1 * std::log(ra / unit) - length + d * theta) / size;
    }
    return row;
}

template <class T>
Polygon<T> random_cage(std::uint64_t seed) {
    return seed % 2 == 0 ? Polygon<T>(random_star<T>(seed)) : random_rings<T>(seed);
}

/// Points inside and outside, near and far, and within 1e-12 of edges and vertices.
template <class T>
Points2<T> points_about(const Polygon<T>& cage, std::uint64_t seed) {
    Random random(seed + 77);
    const auto bounds = bounds_of(cage.vertices());
    const double diagonal = double(bounds.diagonal());
    Points2<T> points;
    for (int i = 0; i < 20; ++i) points.push_back(random_inside(cage, random, 0));
    for (const double far : {0.6, 1.0, 10.0, 1e3, 1e6, 1e9}) {
        const double angle = random.uniform(0, 6.3);
        points.push_back({T(double(bounds.lower[0]) + far * diagonal * std::cos(angle)),
                          T(double(bounds.lower[1]) + far * diagonal * std::sin(angle))});
    }
    for (int i = 0; i < 30; ++i) {
        const auto place = on_edge(cage, random.below(cage.size()), i % 3 == 0 ? 0 : random.uniform(0, 1));
        const double angle = random.uniform(0, 6.3);
        const double away = i % 10 == 0 ? 0 : diagonal * std::pow(10.0, random.uniform(-14, -3));
        points.push_back({T(double(place.position[0]) + away * std::cos(angle)),
                          T(double(place.position[1]) + away * std::sin(angle))});
    }
    return points;
}

} // namespace

TEST_CASE("Green weights in the plane are those of the oracle", "[coordinates][green][oracle]") {
    std::size_t outside = 0, gradients = 0, posed = 0;
    for (const char* name : {"green2d_l_shape", "green2d_right_triangle", "green2d_unit_square",
                             "green2d_biped", "green2d_star", "green2d_cat"}) {
        const PlaneFile file(name);
        const Green2<double> green(file.cage());
        REQUIRE(green.cage_report().status == Status::ok);
        const auto weights = evaluate_all(green, file.points);
        const auto slopes = gradients_of<double, 2>(green, file.points);
        REQUIRE(weights.rows.size() >= 8);
        for (std::size_t i = 0; i < file.points.size(); ++i) {
            CAPTURE(name, i, text(weights.rows[i]));
            CHECK(difference(weights.rows[i], expected_row(green, file.phi[i], file.psi[i])) <=
                  1e-14); // measured: below 1e-15
            if (!file.json.contains("rows")) continue;
            const auto row = file.json["rows"][i];
            CHECK(to_string(weights.states[i]) == row["state"].get<std::string>());
            outside += row.contains("exit_edge") ? 1 : 0;
            if (!row.contains("gradient")) continue;
            ++gradients;
            for (std::size_t h = 0; h < green.handles().size(); ++h) {
                const std::size_t n = green.cage().size();
                const double size = h < n ? 1 : detail::length(green.handles()[h]);
                for (std::size_t k = 0; k < 2; ++k)
                    CHECK(std::fabs(size * slopes.rows[i][h][k] - row["gradient"][k][h].get<double>()) <=
                          1e-13);
            }
        }
        if (!file.json.contains("pose")) continue;
        const auto bound = bind(green, file.points, {.outside = OutsidePoints::extend});
        REQUIRE(bound.report.status == Status::ok);
        Points2<double> pose, out(file.points.size());
        const auto places = file.json["pose"];
        for (const auto& p : places) pose.push_back({p[0].get<double>(), p[1].get<double>()});
        REQUIRE(clone(bound.value, posed_handles(bound.value, pose), out) == Status::ok);
        for (std::size_t i = 0; i < out.size(); ++i) {
            const auto at = file.json["rows"][i]["posed_numbers"].get<std::vector<double>>();
            CHECK(distance(out[i], Vec<double, 2>{at[0], at[1]}) <= 1e-14);
            ++posed;
        }
    }
    CHECK(outside == 6);
    CHECK(gradients == 12);
    CHECK(posed == 24);
}

TEST_CASE("Green weights on the boundary of plane cages are the limits", "[coordinates][green][limit]") {
    const auto json = read_json("green_limits");
    std::size_t checked = 0;
    const auto cases = json["cases"];
    for (const auto& one : cases) {
        const auto name = one["cage"].get<std::string>();
        if (one["point"].size() != 2) continue;
        CAPTURE(name, one["point"]);
        // There is no file of the square with a hole here.
        const Polygon<double> ring(
            Points2<double>{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {1, 1}, {1, 3}, {3, 3}, {3, 1}},
            std::vector<std::size_t>{4, 4});
        const Green2<double> green(name == "green2d_square_with_hole" ? ring : PlaneFile(name).cage());
        const Points2<double> point{{one["point"][0].get<double>(), one["point"][1].get<double>()}};
        const auto weights = evaluate_all(green, point);
        const auto expected = expected_row(green, one["phi_numbers"].get<std::vector<double>>(),
                                           one["psi_numbers"].get<std::vector<double>>());
        CHECK(weights.states[0] == PointState::on_boundary);
        CHECK(difference(weights.rows[0], expected) <= 1e-14);
        std::vector<double> row(expected.size());
        CHECK(distance(green.nearest_boundary(point[0], row), point[0]) == 0);
        CHECK(difference(row, expected) <= 1e-14);
        ++checked;
    }
    CHECK(checked == 8);
}

TEMPLATE_TEST_CASE("Green weights of the plane are those of the definition", "[coordinates][green][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(60, 10)));
    CAPTURE(seed);
    const Green2<T> green(random_cage<T>(std::uint64_t(seed)));
    REQUIRE(green.cage_report().status == Status::ok);
    const auto points = points_about(green.cage(), std::uint64_t(seed));
    const auto weights = evaluate_all(green, points);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (weights.states[i] != PointState::inside) continue;
        ++inside;
        CAPTURE(i, text(weights.rows[i]));
        CHECK(difference(weights.rows[i], by_definition(green, points[i])) <= 16 * double(epsilon<T>));
    }
    CHECK(inside >= 20);
}

TEMPLATE_TEST_CASE("Green weights in the plane reproduce every point", "[coordinates][green][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(60, 10)));
    CAPTURE(seed);
    const Green2<T> green(random_cage<T>(std::uint64_t(seed)));
    const auto& cage = green.cage();
    auto points = points_about(cage, std::uint64_t(seed));
    const auto weights = evaluate_all(green, points);
    const T tolerance = coincidence_tolerance(bounds_of(cage.vertices()));
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, points[i][0], points[i][1], text(weights.rows[i]));
        CHECK(missed(green, weights.rows[i], points[i]) <= 24 * double(epsilon<T>));
        const double away = double(nearest_on_boundary(cage, points[i]).distance) / double(tolerance);
        if (away < 0.8) CHECK(weights.states[i] == PointState::on_boundary);
        if (away > 1.25) CHECK(weights.states[i] == locate(cage, points[i], T(0)));
    }
}

TEMPLATE_TEST_CASE("gradients of Green weights: sums, and the Cauchy-Riemann equations in every pose",
                   "[coordinates][green][gradient][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(40, 8)));
    CAPTURE(seed);
    const Green2<T> green(random_cage<T>(std::uint64_t(seed)));
    const auto& cage = green.cage();
    const double diagonal = double(bounds_of(cage.vertices()).diagonal());
    const auto points = points_about(cage, std::uint64_t(seed));
    const auto slopes = gradients_of<T, 2>(green, points);
    const auto binding = bind(green, points).value;
    Random random(std::uint64_t(seed) + 5);
    Points2<T> pose(cage.size());
    for (auto& v : pose) v = {T(diagonal * random.uniform(-1, 1)), T(diagonal * random.uniform(-1, 1))};
    const auto posed = posed_handles(binding, pose);
    const Points2<T> rest(green.handles().begin(), green.handles().end());
    std::vector<Vec<T, 2>> ones(rest.size());
    for (std::size_t h = 0; h < cage.size(); ++h) ones[h] = {1, 0};
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, points[i][0], points[i][1], to_string(slopes.states[i]));
        double size = 1 / diagonal;
        for (const auto& g : slopes.rows[i]) size += std::fabs(double(g[0])) + std::fabs(double(g[1]));
        size *= diagonal * double(epsilon<T>);
        const auto sums = jacobian(slopes.rows[i], ones);
        CHECK(double(std::fabs(sums[0][0]) + std::fabs(sums[0][1])) * diagonal <= 8 * size);
        const auto identity = jacobian(slopes.rows[i], rest);
        for (std::size_t k = 0; k < 4; ++k)
            CHECK(std::fabs(double(identity[k / 2][k % 2]) - (k % 3 == 0 ? 1 : 0)) <=
                  8 * size * size_of(cage.vertices()) / diagonal);
        const auto J = jacobian(slopes.rows[i], posed);
        CHECK(double(std::fabs(J[0][0] - J[1][1]) + std::fabs(J[0][1] + J[1][0])) <= 16 * size);
    }
}

TEST_CASE("gradients of Green weights are the differences of the weights",
          "[coordinates][green][gradient][property]") {
    const auto seed = GENERATE(seeds(effort(30, 6)));
    CAPTURE(seed);
    const Green2<double> green(random_cage<double>(std::uint64_t(seed)));
    const double diagonal = bounds_of(green.cage().vertices()).diagonal(), step = 1e-5 * diagonal;
    std::size_t checked = 0;
    for (const auto& p : points_about(green.cage(), std::uint64_t(seed))) {
        const double room = nearest_on_boundary(green.cage(), p).distance / diagonal;
        if (room < 0.01 || room > 2) continue;
        const auto slopes = gradients_of<double, 2>(green, {p}).rows[0];
        const auto x = evaluate_all(green, Points2<double>{{p[0] + step, p[1]}, {p[0] - step, p[1]}}).rows;
        const auto y = evaluate_all(green, Points2<double>{{p[0], p[1] + step}, {p[0], p[1] - step}}).rows;
        double worst = 0;
        for (std::size_t h = 0; h < slopes.size(); ++h) {
            worst = std::max({worst, std::fabs((x[0][h] - x[1][h]) / (2 * step) - slopes[h][0]),
                              std::fabs((y[0][h] - y[1][h]) / (2 * step) - slopes[h][1])});
        }
        CAPTURE(p[0], p[1], room);
        CHECK(worst * diagonal <= 1e-5 / room); // values jump across seams outside; there is no seam here
        ++checked;
    }
    CHECK(checked >= 8);
}

TEST_CASE("Green coordinates are continuous across the edge they are continued through",
          "[coordinates][green][outside]") {
    const auto seed = GENERATE(seeds(effort(40, 8)));
    CAPTURE(seed);
    const Green2<double> green(random_cage<double>(std::uint64_t(seed)));
    Random random{std::uint64_t(seed)};
    const double diagonal = bounds_of(green.cage().vertices()).diagonal();
    for (int n = 0; n < 10; ++n) {
        const std::size_t edge = random.below(green.cage().size());
        const auto at = on_edge(green.cage(), edge, random.uniform(0.1, 0.9)).position;
        const auto& across = green.handles()[green.cage().size() + edge];
        const auto step = (1e-9 * diagonal / detail::length(across)) * across;
        const auto rows = evaluate_all(green, Points2<double>{at - step, at, at + step});
        CHECK(rows.states ==
              std::vector<PointState>{PointState::inside, PointState::on_boundary, PointState::outside});
        const double least = detail::length(across) / diagonal; // weights change over the length of an edge
        CHECK(difference(rows.rows[0], rows.rows[1]) <= 1e-8 / least);
        CHECK(difference(rows.rows[2], rows.rows[1]) <= 1e-8 / least);
        const auto slopes = gradients_of<double, 2>(green, {at - step, at + step}).rows;
        for (std::size_t h = 0; h < slopes[0].size(); ++h)
            CHECK(distance(slopes[0][h], slopes[1][h]) * diagonal <= 1e-6 / (least * least));
    }
}

TEST_CASE(
    "Green weights of vertices are positive in convex cages, and all weights have the mean value property",
    "[coordinates][green][property]") {
    const auto seed = GENERATE(seeds(effort(30, 6)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 9);
    Points2<double> ellipse;
    const std::size_t corners = 3 + random.below(9);
    for (std::size_t i = 0; i < corners; ++i) {
        const double angle = 2 * std::numbers::pi * (double(i) + random.uniform(-0.4, 0.4)) / double(corners);
        ellipse.push_back({3 * std::cos(angle), std::sin(angle)});
    }
    const Green2<double> green(ellipse);
    const auto p = random_inside(green.cage(), random, 0.02);
    const double radius = 0.9 * nearest_on_boundary(green.cage(), p).distance;
    Points2<double> points{p};
    constexpr std::size_t count = 256; // the error decreases like 0.9^count
    for (std::size_t i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * double(i) / double(count);
        points.push_back({p[0] + radius * std::cos(angle), p[1] + radius * std::sin(angle)});
    }
    const auto rows = evaluate_all(green, points).rows;
    for (std::size_t h = 0; h < green.handles().size(); ++h) {
        double mean = 0;
        for (std::size_t i = 1; i <= count; ++i) mean += rows[i][h] / double(count);
        CAPTURE(h);
        CHECK(std::fabs(mean - rows[0][h]) <= 1e-10);
        for (std::size_t i = 0; h < corners && i <= count; ++i) CHECK(rows[i][h] >= -1e-16);
    }
}

TEST_CASE("an edge split by a vertex on it changes nothing", "[coordinates][green][property]") {
    const auto seed = GENERATE(seeds(effort(20, 5)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 3);
    const Points2<double> whole = random_star<double>(std::uint64_t(seed));
    const auto diagonal = bounds_of(std::span<const Vec<double, 2>>(whole)).diagonal();
    const std::size_t edge = random.below(whole.size()), next = (edge + 1) % whole.size();
    Points2<double> pose(whole), points;
    for (auto& v : pose) v = v + Vec<double, 2>{diagonal * random.uniform(-0.3, 0.3), 0.1 * diagonal};
    const auto divide = [&](Points2<double> vertices) { // at the midpoints, exact to a rounding
        vertices.insert(vertices.begin() + std::ptrdiff_t(edge) + 1, 0.5 * (vertices[edge] + vertices[next]));
        return vertices;
    };
    const Green2<double> green(whole), divided(divide(whole));
    for (int i = 0; i < 10; ++i) points.push_back(random_inside(green.cage(), random, 0));
    const auto one = bind(green, points).value, two = bind(divided, points).value;
    Points2<double> here(points), there(points);
    REQUIRE(clone(one, posed_handles(one, pose), here) == Status::ok);
    REQUIRE(clone(two, posed_handles(two, divide(pose)), there) == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i)
        CHECK(distance(here[i], there[i]) <= 1e-12 * size_of(whole));
}

TEMPLATE_TEST_CASE("Green weights do not depend on the unit of length", "[coordinates][green][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto cage = random_star<T>(4);
    Random random(4);
    Points2<T> points;
    for (int i = 0; i < 40; ++i) points.push_back(random_inside(Polygon<T>(cage), random, 0));
    const auto rows = evaluate_all(Green2<T>(cage), points).rows;
    const auto scaled = [](Points2<T> list, double unit) {
        for (auto& p : list) p = T(unit) * p;
        return list;
    };
    for (const double unit : {0x1p-60, 0x1p40, sizeof(T) == 4 ? 4.0 : 0x1p500, 3.0}) {
        const auto same = evaluate_all(Green2<T>(scaled(cage, unit)), scaled(points, unit)).rows;
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (unit != 3) CHECK(same[i] == rows[i]);
            CHECK(difference(same[i], rows[i]) <= 1e3 * double(epsilon<T>)); // 3 roundings of positions
        }
    }
}

TEMPLATE_TEST_CASE("a binding by Green coordinates is bitwise exact at rest and follows similarities",
                   "[coordinates][green][bind]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(20, 5)));
    CAPTURE(seed);
    const Green2<T> green(random_cage<T>(std::uint64_t(seed)));
    auto points = points_about(green.cage(), std::uint64_t(seed));
    points[3][1] = std::numeric_limits<T>::quiet_NaN();
    const auto bound = bind(green, points, {.outside = OutsidePoints::extend});
    REQUIRE(bound.report.status == Status::ok);
    CHECK(bound.report.not_finite == std::vector<std::size_t>{3});
    CHECK(bound.report.unreached.empty());
    CHECK(bound.report.not_restored.empty());
    points[3] = points[4];
    const auto& binding = bound.value;
    const Points2<T> vertices(green.cage().vertices().begin(), green.cage().vertices().end());
    Points2<T> out(points.size());
    REQUIRE(clone(binding, posed_handles(binding, vertices), out) == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) CHECK((i == 3 || out[i] == points[i]));

    Random random(std::uint64_t(seed) + 50);
    AffineMap<2> turn;
    const double a = random.uniform(-2, 2), b = random.uniform(-2, 2);
    turn.rows[0] = {a, -b};
    turn.rows[1] = {b, a};
    turn.shift = {size_of(vertices), 0.5};
    const auto pose = turn(std::span<const Vec<T, 2>>(vertices));
    REQUIRE(clone(binding, posed_handles(binding, pose), out) == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i == 3) continue;
        CAPTURE(i, points[i][0], points[i][1]);
        double weight = 0;
        for (std::size_t h = 0; h < binding.handle_count(); ++h)
            weight += std::fabs(double(binding.weight(i, h)));
        const double size = weight * (size_of(vertices) + size_of(pose)) + distance(points[i], vertices[0]);
        CHECK(distance(out[i], turn(vec_cast<long double>(points[i]))) <= 24 * double(epsilon<T>) * size);
    }
    CHECK(clone(binding, vertices, out) == Status::pose_size_differs); // only the vertices
}

TEMPLATE_TEST_CASE("Green coordinates of thin cages in the plane", "[coordinates][green][thin]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(30));
    Random random{std::uint64_t(seed)};
    const double w = std::pow(10.0, random.uniform(sizeof(T) == 4 ? -5.5 : -14, -1)), v = 1 - w;
    CAPTURE(seed, w);
    const auto at = [](double x, double y) { return Vec<T, 2>{T(x), T(y)}; };
    const Points2<T> bar{at(0, 0), at(1, 0), at(1, w), at(0, w)};
    const Points2<T> ring{at(0, 0), at(1, 0), at(1, 1), at(0, 1), at(w, w), at(v, w), at(v, v), at(w, v)};
    const std::vector<std::size_t> loops{4, 4};
    const Green2<T> hollow(Polygon<T>(ring, loops));
    check_thin_states(Green2<T>(bar), random);
    check_thin_states(hollow, random);
    check_thin_states(Green2<T>(thin_simplex<T, 2>(random, w)), random);
    Points2<T> points;
    for (int i = 0; i < 20; ++i) points.push_back(at(random.uniform(0.1, 0.9), w * random.uniform(0.3, 0.7)));
    for (const Green2<T>& green : {Green2<T>(bar), hollow}) {
        REQUIRE(green.cage_report().status == Status::ok);
        const auto weights = evaluate_all(green, points);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(i, points[i][0], points[i][1], text(weights.rows[i]));
            CHECK(weights.states[i] == PointState::inside);
            CHECK(missed(green, weights.rows[i], points[i]) <= 24 * double(epsilon<T>));
        }
    }
    CHECK(evaluate_all(hollow, Points2<T>{at(0.5, 0.5), at(0.3, 0.6)}).states ==
          std::vector<PointState>{PointState::outside, PointState::outside});
}

TEST_CASE("unsupported cages are refused by Green coordinates", "[coordinates][green][status]") {
    const Points2<double> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    CHECK(Green2<double>(Points2<double>{{0, 0}, {1, 1}, {1, 0}, {0, 1}}).cage_report().status ==
          Status::cage_self_crossing);
    CHECK(Green2<double>(Points2<double>{{0, 0}, {1, 1}}).cage_report().status == Status::too_few_vertices);
    CellComplex<double, 2> complex{Polygon<double>(square)};
    CHECK(Green2<double>(complex).cage_report().status == Status::ok);
    CHECK(evaluate_all(Green2<double>(complex), square).rows ==
          evaluate_all(Green2<double>(square), square).rows);
    complex.add_chain(Points2<double>{{0.25, 0.25}, {0.5, 0.5}});
    const Green2<double> refused(complex);
    CHECK(refused.cage_report().status == Status::interior_cells_not_supported);
    CHECK(bind(refused, square).report.status == Status::interior_cells_not_supported);
    // Far away the weights overflow the scalar.
    const auto far =
        evaluate_all(Green2<double>(square), Points2<double>{{1e300, 0}, {1e308, 1e308}, {-1e17, 3}});
    CHECK(far.states[2] == PointState::outside);
    for (std::size_t i = 0; i < 3; ++i) {
        CAPTURE(i);
        CHECK((far.states[i] == PointState::unreached || missed(Green2<double>(square), far.rows[i],
                                                                Vec<double, 2>{i == 0   ? 1e300
                                                                               : i == 1 ? 1e308
                                                                                        : -1e17,
                                                                               i == 0   ? 0
                                                                               : i == 1 ? 1e308
                                                                                        : 3}) < 1e-14));
    }
}

} // namespace green_tests

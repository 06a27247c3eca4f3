#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/figures.hpp"
#include "../support/green.hpp"
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"
#include "../support/thin_cages.hpp"

#include <cageform/coordinates/green.hpp>

namespace green_3d_tests {

using namespace cageform;
using namespace cageform_tests;

namespace {

template <class T>
using Green3 = GreenCoordinates<T, 3>;
using L = long double;

Points3<double> places(const nlohmann::json& list) {
    Points3<double> result;
    for (const auto& p : list) result.push_back({p[0].get<double>(), p[1].get<double>(), p[2].get<double>()});
    return result;
}
Green3<double> read_cage(const nlohmann::json& json) {
    return {places(json["cage"]["vertices"]), json["cage"]["faces"].get<Faces>()};
}

/// φ, then the handle weights for ψ: divided by √area.
std::vector<double> expected_row(const Green3<double>& green, const std::vector<double>& phi,
                                 const std::vector<double>& psi) {
    auto row = phi;
    for (std::size_t j = 0; j < psi.size(); ++j)
        row.push_back(psi[j] / detail::length(green.handles()[phi.size() + j]));
    return row;
}

/// The closed form in long double, for points inside. Both faces of an edge measure distances from the vector
/// to the edge's line, relative to the nearer end; otherwise half of the digits would be lost.
template <class T>
std::vector<L> by_definition(const Green3<T>& green, const Vec<T, 3>& at) {
    const auto unit = [](const Vec<L, 3>& v) { return (1 / std::sqrt(dot(v, v))) * v; };
    const auto p = vec_cast<L>(at);
    const std::size_t count = green.cage().size();
    std::vector<L> row(green.handles().size());
    for (std::size_t j = 0; j < green.handle_faces().size(); ++j) {
        const auto& face = green.handle_faces()[j];
        Vec<L, 3> c[3], nu[3], q[3];
        for (std::size_t k = 0; k < 3; ++k) c[k] = vec_cast<L>(green.cage()[face[k]]);
        const auto twice = cross(c[1] - c[0], c[2] - c[0]);
        const auto n = unit(twice);
        const L area = std::sqrt(dot(twice, twice)) / 2;
        L rho[3], f[3], s1[3], s2[3], a[3], b[3], height = 0, least = 1e30L;
        for (std::size_t k = 0; k < 3; ++k) {
            std::size_t i = face[(k + 1) % 3], o = face[(k + 2) % 3];
            if (o < i) std::swap(i, o);
            const auto u = vec_cast<L>(green.cage()[i]) - p, v = vec_cast<L>(green.cage()[o]) - p;
            const auto tau = unit(v - u);
            const L length = std::sqrt(dot(v - u, v - u));
            a[k] = std::sqrt(dot(u, u));
            b[k] = std::sqrt(dot(v, v));
            const auto& end = a[k] < b[k] ? u : v;
            q[k] = end - dot(end, tau) * tau;
            q[k] = q[k] - dot(q[k], tau) * tau;
            s1[k] = dot(end, tau) - (a[k] < b[k] ? 0 : length);
            s2[k] = dot(end, tau) + (a[k] < b[k] ? length : 0);
            nu[k] = unit(cross(c[(k + 2) % 3] - c[(k + 1) % 3], n));
            rho[k] = dot(q[k], nu[k]);
            f[k] = s1[k] >= 0   ? std::log((b[k] + s2[k]) / (a[k] + s1[k]))
                   : s2[k] <= 0 ? std::log((a[k] - s1[k]) / (b[k] - s2[k]))
                                : std::log((b[k] + s2[k]) * (a[k] - s1[k]) / dot(q[k], q[k]));
            if (dot(q[k], q[k]) >= least) continue;
            least = dot(q[k], q[k]);
            height = dot(q[k], n);
        }
        L angle = 0, potential = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const L size = std::fabs(height), d = dot(q[k], q[k]);
            angle +=
                std::atan2(rho[k] * s2[k], d + size * b[k]) - std::atan2(rho[k] * s1[k], d + size * a[k]);
            potential += rho[k] * f[k];
        }
        angle = height < 0 ? -angle : angle;
        constexpr L full = 4 * std::numbers::pi_v<L>;
        for (std::size_t k = 0; k < 3; ++k) {
            L sum = 0;
            for (std::size_t l = 0; l < 3; ++l) sum += dot(nu[k], nu[l]) * f[l];
            row[face[k]] += (rho[k] * angle + height * sum) / (full * dot(nu[k], c[(k + 1) % 3] - c[k]));
        }
        row[count + j] = (potential - height * angle) / (full * std::sqrt(area));
    }
    return row;
}

/// Points inside and outside, near and far, and within 1e-14 to 1e-3 diagonals of faces, edges and vertices.
template <class T>
Points3<T> points_near(const TriangleMesh<T>& mesh, std::uint64_t seed) {
    Random random(seed + 77);
    const auto bounds = bounds_of(mesh.vertices());
    const double diagonal = double(bounds.diagonal());
    auto points = points_in(mesh, 20, seed);
    const auto direction = [&] {
        Vec<double, 3> d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        return (1 / detail::length(d)) * d;
    };
    for (const double far : {0.8, 1.0, 10.0, 1e3, 1e6, 1e9})
        points.push_back(vec_cast<T>(vec_cast<double>(bounds.lower) + far * diagonal * direction()));
    for (int i = 0; i < 40; ++i) {
        const auto& face = mesh.faces()[random.below(mesh.faces().size())];
        const double u = i % 3 == 0 ? 0 : random.uniform(0, 1), v = i % 3 == 2 ? random.uniform(0, 1 - u) : 0;
        const auto a = vec_cast<double>(mesh[face[0]]), b = vec_cast<double>(mesh[face[1]]),
                   c = vec_cast<double>(mesh[face[2]]);
        const double away = i % 10 == 0 ? 0 : diagonal * std::pow(10.0, random.uniform(-14, -3));
        points.push_back(vec_cast<T>(a + u * (b - a) + v * (c - a) + away * direction()));
    }
    return points;
}

} // namespace

TEST_CASE("Green weights in space are those of the oracle", "[coordinates][green][space][oracle]") {
    std::size_t outside = 0, gradients = 0;
    const auto slopes_of = read_json("green3d_gradients")["cages"];
    for (const std::string name : {"tetrahedron", "cube"}) {
        const auto json = read_json("green3d_" + name);
        const auto green = read_cage(json);
        REQUIRE(green.cage_report().status == Status::ok);
        const auto points = places(json["points"]), pose = places(json["pose"]);
        const std::size_t n = green.cage().size();
        const auto weights = evaluate_all(green, points);
        const auto slopes = gradients_of<double, 3>(green, points);
        const auto bound = bind(green, points, {.outside = OutsidePoints::extend});
        Points3<double> out(points.size());
        const auto handles = posed_handles(bound.value, pose);
        REQUIRE(clone(bound.value, handles, out) == Status::ok);
        const auto expected_handles = places(json["pose_handles"]);
        REQUIRE(points.size() == 8);
        for (std::size_t h = 0; h < handles.size(); ++h) { // the file has s n'
            const double size = h < n ? 1 : detail::length(green.handles()[h]);
            CHECK(distance(handles[h], size * expected_handles[h]) <= 1e-14);
        }
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto row = json["rows"][i];
            CAPTURE(name, i, text(weights.rows[i]));
            CHECK(to_string(weights.states[i]) == row["state"].get<std::string>());
            CHECK(difference(weights.rows[i],
                             expected_row(green, row["phi_numbers"].get<std::vector<double>>(),
                                          row["psi_numbers"].get<std::vector<double>>())) <= 4e-15);
            CHECK(distance(out[i], places(nlohmann::json::array({row["posed_numbers"]}))[0]) <= 1e-14);
            outside += row.contains("exit_face") ? 1 : 0;
            if (i >= slopes_of[name].size()) continue;
            ++gradients;
            for (std::size_t h = 0; h < green.handles().size(); ++h) {
                const double size = h < n ? 1 : detail::length(green.handles()[h]);
                for (std::size_t k = 0; k < 3; ++k)
                    CHECK(std::fabs(size * slopes.rows[i][h][k] - slopes_of[name][i][k][h].get<double>()) <=
                          1e-14);
            }
        }
    }
    CHECK(outside == 4);
    CHECK(gradients == 8);
}

TEST_CASE("Green weights on the boundary of meshes are the limits", "[coordinates][green][space][limit]") {
    const auto cases = read_json("green_limits")["cases"];
    const auto cube = read_cage(read_json("green3d_cube"));
    std::size_t checked = 0;
    for (const auto& one : cases) {
        if (one["cage"] != "green3d_cube") continue;
        const auto point = places(nlohmann::json::array({one["point"]}));
        CAPTURE(one["point"]);
        const auto weights = evaluate_all(cube, point);
        const auto expected = expected_row(cube, one["phi_numbers"].get<std::vector<double>>(),
                                           one["psi_numbers"].get<std::vector<double>>());
        CHECK(weights.states[0] == PointState::on_boundary);
        CHECK(difference(weights.rows[0], expected) <= 4e-15);
        std::vector<double> row(expected.size());
        CHECK(distance(cube.nearest_boundary(point[0], row), point[0]) == 0);
        CHECK(difference(row, expected) <= 4e-15);
        ++checked;
    }
    CHECK(checked == 4);
}

TEMPLATE_TEST_CASE("Green weights of space are those of the closed form in higher precision",
                   "[coordinates][green][space][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(24, 5)));
    CAPTURE(seed);
    const Green3<T> green(random_mesh(std::uint64_t(seed)).mesh<T>());
    REQUIRE(green.cage_report().status == Status::ok);
    const auto points = points_near(green.cage(), std::uint64_t(seed));
    const auto weights = evaluate_all(green, points);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (weights.states[i] != PointState::inside) continue;
        ++inside;
        CAPTURE(i, points[i][0], points[i][1], points[i][2]);
        CHECK(difference(weights.rows[i], by_definition(green, points[i])) <= 64 * double(epsilon<T>));
    }
    CHECK(inside >= 20);
}

TEMPLATE_TEST_CASE("Green weights in space reproduce every point", "[coordinates][green][space][property]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(24, 5)));
    CAPTURE(seed);
    const Green3<T> green(random_mesh(std::uint64_t(seed)).mesh<T>());
    const auto& cage = green.cage();
    const auto points = points_near(cage, std::uint64_t(seed));
    const auto weights = evaluate_all(green, points);
    const T tolerance = coincidence_tolerance(bounds_of(cage.vertices()));
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, points[i][0], points[i][1], points[i][2]);
        CHECK(missed(green, weights.rows[i], points[i]) <= 64 * double(epsilon<T>));
        Vec<T, 3> place{};
        (void)nearest_boundary_value(cage, points[i], place);
        const double away = distance(place, points[i]) / double(tolerance);
        if (away < 0.8) CHECK(weights.states[i] == PointState::on_boundary);
        if (away > 1.25) CHECK(weights.states[i] == locate(cage, points[i], T(0)));
    }
}

TEMPLATE_TEST_CASE("gradients of Green weights in space: sums, and similarity poses",
                   "[coordinates][green][space][gradient][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(16, 4)));
    CAPTURE(seed);
    const Green3<T> green(random_mesh(std::uint64_t(seed)).mesh<T>());
    const auto& cage = green.cage();
    const double diagonal = double(bounds_of(cage.vertices()).diagonal());
    const auto points = points_near(cage, std::uint64_t(seed));
    const auto slopes = gradients_of<T, 3>(green, points);
    const Points3<T> rest(green.handles().begin(), green.handles().end());
    std::vector<Vec<T, 3>> ones(rest.size());
    for (std::size_t h = 0; h < cage.size(); ++h) ones[h] = {1, 0, 0};
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, points[i][0], points[i][1], points[i][2], to_string(slopes.states[i]));
        double size = 1 / diagonal;
        for (const auto& g : slopes.rows[i])
            size += std::fabs(double(g[0])) + std::fabs(double(g[1])) + std::fabs(double(g[2]));
        size *= diagonal * double(epsilon<T>);
        const auto sums = jacobian(slopes.rows[i], ones);
        for (std::size_t k = 0; k < 3; ++k) CHECK(std::fabs(double(sums[0][k])) * diagonal <= 8 * size);
        const auto identity = jacobian(slopes.rows[i], rest);
        for (std::size_t k = 0; k < 9; ++k)
            CHECK(std::fabs(double(identity[k / 3][k % 3]) - (k % 4 == 0 ? 1 : 0)) <=
                  16 * size * size_of(cage.vertices()) / diagonal);
    }
}

TEST_CASE("gradients of Green weights in space are the differences of the weights",
          "[coordinates][green][space][gradient][property]") {
    const auto seed = GENERATE(seeds(effort(12, 3)));
    CAPTURE(seed);
    const Green3<double> green(random_mesh(std::uint64_t(seed)).mesh<double>());
    const double diagonal = bounds_of(green.cage().vertices()).diagonal(), step = 1e-5 * diagonal;
    std::size_t checked = 0;
    for (const auto& p : points_near(green.cage(), std::uint64_t(seed))) {
        Vec<double, 3> place{};
        (void)nearest_boundary_value(green.cage(), p, place);
        const double room = distance(place, p) / diagonal;
        if (room < 0.01 || room > 2) continue;
        const auto slopes = gradients_of<double, 3>(green, {p}).rows[0];
        double worst = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            Points3<double> ends{p, p};
            ends[0][k] += step;
            ends[1][k] -= step;
            const auto rows = evaluate_all(green, ends).rows;
            for (std::size_t h = 0; h < slopes.size(); ++h)
                worst = std::max(
                    worst, std::fabs((rows[0][h] - rows[1][h]) / (ends[0][k] - ends[1][k]) - slopes[h][k]));
        }
        CAPTURE(p[0], p[1], p[2], room);
        CHECK(worst * diagonal <= 1e-5 / room);
        ++checked;
    }
    CHECK(checked >= 8);
}

TEST_CASE("Green coordinates in space are continuous across faces, positive in convex cages",
          "[coordinates][green][space][outside]") {
    const auto seed = GENERATE(seeds(effort(12, 3)));
    CAPTURE(seed);
    const Green3<double> green(random_mesh(std::uint64_t(seed)).mesh<double>());
    Random random{std::uint64_t(seed)};
    const double diagonal = bounds_of(green.cage().vertices()).diagonal();
    for (int n = 0; n < 10; ++n) {
        const std::size_t f = random.below(green.cage().faces().size());
        const auto& face = green.handle_faces()[f];
        const double u = random.uniform(0.1, 0.4), v = random.uniform(0.1, 0.4);
        const auto at =
            (1 - u - v) * green.cage()[face[0]] + u * green.cage()[face[1]] + v * green.cage()[face[2]];
        const auto& across = green.handles()[green.cage().size() + f];
        const auto step = (1e-9 * diagonal / detail::length(across)) * across;
        const auto rows = evaluate_all(green, Points3<double>{at - step, at, at + step});
        CHECK(rows.states ==
              std::vector<PointState>{PointState::inside, PointState::on_boundary, PointState::outside});
        const double least = detail::length(across) / diagonal; // weights change over the length of a face
        CHECK(difference(rows.rows[0], rows.rows[1]) <= 1e-8 / least);
        CHECK(difference(rows.rows[2], rows.rows[1]) <= 1e-8 / least);
    }
    const auto ball = points_in(sphere(2).mesh<double>(), 40, random.bits());
    const Green3<double> convex(sphere(2).mesh<double>());
    const auto inside = evaluate_all(convex, ball);
    for (std::size_t i = 0; i < ball.size(); ++i) {
        REQUIRE(inside.states[i] == PointState::inside);
        CHECK(*std::min_element(inside.rows[i].begin(), inside.rows[i].end()) >= -1e-16);
    }
}

TEMPLATE_TEST_CASE(
    "a binding by Green coordinates in space is bitwise exact at rest and follows similarities",
    "[coordinates][green][space][bind]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(effort(12, 3)));
    CAPTURE(seed);
    const Green3<T> green(random_mesh(std::uint64_t(seed)).mesh<T>());
    const auto points = points_near(green.cage(), std::uint64_t(seed));
    const auto bound = bind(green, points, {.outside = OutsidePoints::extend});
    REQUIRE(bound.report.status == Status::ok);
    CHECK(bound.report.unreached.empty());
    CHECK(bound.report.not_restored.empty());
    const auto& binding = bound.value;
    const Points3<T> vertices(green.cage().vertices().begin(), green.cage().vertices().end());
    Points3<T> out(points.size());
    REQUIRE(clone(binding, posed_handles(binding, vertices), out) == Status::ok);
    CHECK(out == points);

    Random random(std::uint64_t(seed) + 50);
    AffineMap<3> turn;
    const double scale = random.uniform(0.5, 2), a = random.uniform(-3, 3), b = random.uniform(-3, 3);
    turn.rows[0] = scale * Vec<double, 3>{std::cos(a), -std::sin(a), 0};
    turn.rows[1] = scale * Vec<double, 3>{std::sin(a) * std::cos(b), std::cos(a) * std::cos(b), -std::sin(b)};
    turn.rows[2] = scale * Vec<double, 3>{std::sin(a) * std::sin(b), std::cos(a) * std::sin(b), std::cos(b)};
    turn.shift = {size_of(vertices), 0.5, -1};
    const auto pose = turn(std::span<const Vec<T, 3>>(vertices));
    REQUIRE(clone(binding, posed_handles(binding, pose), out) == Status::ok);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, points[i][0], points[i][1], points[i][2]);
        double weight = 0;
        for (std::size_t h = 0; h < binding.handle_count(); ++h)
            weight += std::fabs(double(binding.weight(i, h)));
        const double size = weight * (size_of(vertices) + size_of(pose)) + distance(points[i], vertices[0]);
        CHECK(distance(out[i], turn(vec_cast<long double>(points[i]))) <= 24 * double(epsilon<T>) * size);
    }
    CHECK(clone(binding, vertices, out) == Status::pose_size_differs); // only the vertices
}

TEMPLATE_TEST_CASE("Green coordinates of thin cages in space", "[coordinates][green][space][thin]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(seeds(30));
    Random random{std::uint64_t(seed)};
    const double width = std::pow(10.0, random.uniform(sizeof(T) == 4 ? -5.5 : -13, -1));
    CAPTURE(seed, width);
    const Faces box{{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    for (const double depth : {1.0, width}) { // a plate and a rod
        Points3<T> corners, points;
        for (int i = 0; i < 8; ++i)
            corners.push_back({T(i & 1), T(depth * (i >> 1 & 1)), T(width * (i >> 2 & 1))});
        const Green3<T> green(corners, box);
        REQUIRE((green.cage_report().status == Status::ok || depth < 1)); // a rod's ends may have no area
        if (green.cage_report().status != Status::ok) continue;
        check_thin_states(green, random);
        for (int i = 0; i < 20; ++i)
            points.push_back({T(random.uniform(0.1, 0.9)), T(depth * random.uniform(0.3, 0.7)),
                              T(width * random.uniform(0.3, 0.7))});
        const auto weights = evaluate_all(green, points);
        const auto bound = bind(green, points);
        CHECK(bound.report.not_restored.empty());
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(depth, i, points[i][0], points[i][1], points[i][2], text(weights.rows[i]));
            CHECK(weights.states[i] == PointState::inside);
            // The faces of the rim have the height `width`, and the points are farther away than that.
            CHECK(missed(green, weights.rows[i], points[i]) <= 4 * double(epsilon<T>) / width);
            std::vector<T> row;
            for (std::size_t h = 0; h < bound.value.handle_count(); ++h)
                row.push_back(bound.value.weight(i, h));
            CHECK(missed(green, row, points[i]) <= 64 * double(epsilon<T>));
        }
    }
    check_thin_states(
        Green3<T>(thin_simplex<T, 3>(random, width), Faces{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}}),
        random);
}

TEST_CASE("unsupported meshes are refused by Green coordinates", "[coordinates][green][space][status]") {
    const auto ball = sphere(1);
    auto open = ball;
    open.faces.resize(20);
    CHECK(Green3<double>(open.mesh<double>()).cage_report().status == Status::cage_not_closed);
    CellComplex<double, 3> complex(ball.mesh<double>());
    complex.add_point(Vec<double, 3>{0, 0, 0}, 0.1);
    const Green3<double> refused(complex);
    CHECK(refused.cage_report().status == Status::interior_cells_not_supported);
    CHECK(bind(refused, ball.vertices).report.status == Status::interior_cells_not_supported);

    // A cavity with a shell of either orientation, and a reflex corner of an L with 3/8 of the full solid
    // angle.
    for (const bool turned : {false, true}) {
        auto hollow = ball;
        const int count = int(ball.vertices.size());
        for (const auto& v : ball.vertices) hollow.vertices.push_back(0.5 * v);
        for (const auto& [a, b, c] : ball.faces)
            hollow.faces.push_back({count + a, count + (turned ? c : b), count + (turned ? b : c)});
        const Green3<double> green(hollow.mesh<double>());
        const Points3<double> points{{0, 0, 0}, {0.6, 0.1, 0.1}, {2, 0, 0}};
        const auto weights = evaluate_all(green, points);
        CHECK(weights.states ==
              std::vector<PointState>{PointState::outside, PointState::inside, PointState::outside});
        for (std::size_t i = 0; i < 3; ++i) CHECK(missed(green, weights.rows[i], points[i]) <= 1e-14);
    }
}

TEMPLATE_TEST_CASE("a cage near the largest number is refused or clones at rest",
                   "[coordinates][green][space][status]", CAGEFORM_SCALARS) {
    using T = TestType;
    const T largest = (std::numeric_limits<T>::max)();
    const auto clones = [&](const Points3<T>& vertices, const auto& faces) {
        const GreenCoordinates<T, 3> green(vertices, faces);
        const Points3<T> points{{0, 0, 0}, vertices[0]};
        const auto bound = bind(green, points);
        CHECK(bound.report.status == green.cage_report().status);
        if (bound.report.status != Status::ok) return bound.report.status;
        Points3<T> out(2);
        CHECK(clone(bound.value, green.handles(), out) == Status::ok);
        CHECK(out == points);
        return Status::ok;
    };
    const auto ball = sphere(0);
    for (const double share : {1e-9, 1e-6, 1e-3, 0.03, 0.3, 0.9}) {
        CAPTURE(share);
        Points3<T> vertices;
        for (const auto& v : ball.vertices) vertices.push_back(largest * T(share) * vec_cast<T>(v));
        const Status status = clones(vertices, ball.faces);
        // Squares of distances between doubles overflow before.
        if (std::is_same_v<T, float> && share < 1e-2) CHECK(status == Status::ok);
    }
    // A prism of the largest finite height: its sides are valid triangles whose normals overflow.
    const Points3<T> ring{{T(0.029) * largest, 0, 0}, {0, T(1.6e-5) * largest, 0}, {-1, -1, 0}};
    Points3<T> vertices = ring;
    for (const auto& v : ring) vertices.push_back({v[0], v[1], T(0.995) * largest});
    const std::vector<std::array<int, 3>> prism{{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4},
                                                {2, 0, 3}, {2, 3, 5}, {0, 2, 1}, {3, 4, 5}};
    const Status status = clones(vertices, prism);
    CHECK(status != Status::ok);
    if (std::is_same_v<T, float>) CHECK(status == Status::vertex_not_finite);
}

} // namespace green_3d_tests

// Gradients of mean value and barycentric coordinates: differences in long double, the laws, and critical
// points of the formulas.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/gradients.hpp"
#include "../support/larger.hpp"
#include "../support/meshes.hpp"
#include "../support/oracle.hpp"
#include "../support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/barycentric.hpp>
#include <cageform/coordinates/harmonic.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/parallel/threads.hpp>

namespace mean_value_gradients_tests {

using namespace cageform_tests;
using cageform::epsilon;
using cageform::Polygon;
using cageform::TriangleMesh;

namespace {

using Real = long double;
/// The rounding of Real. Differences of doubles would have fewer digits than a wider long double.
constexpr double real_rounding = double(std::numeric_limits<Real>::epsilon()) / 1.1e-19;

/// The weights by the textbook formula.
template <class T>
std::vector<Real> by_definition(const Polygon<T>& cage, const Vec<Real, 2>& p) {
    std::vector<Real> w(cage.size(), 0);
    std::vector<Real> sign(cage.size()); // outer loops are counter-clockwise, holes clockwise
    for (std::size_t k = 0; k < cage.loops().size(); ++k) {
        const auto& loop = cage.loops()[k];
        const bool turned = (signed_area(cage, loop) > 0) != (cageform::detail::loop_depth(cage, k) % 2 == 0);
        for (std::size_t i = loop.begin; i < loop.end; ++i) sign[i] = turned ? -1 : 1;
    }
    cage.for_each_edge([&](std::size_t i, std::size_t j) {
        const auto u = vec_cast<Real>(cage[i]) - p, v = vec_cast<Real>(cage[j]) - p;
        const Real r = std::sqrt(dot(u, u)), q = std::sqrt(dot(v, v)), c = sign[i] * cross(u, v),
                   d = dot(u, v);
        const Real t = d > 0 ? c / (r * q + d) : (r * q - d) / c;
        w[i] += t / r;
        w[j] += t / q;
    });
    Real sum = 0;
    for (const Real x : w) sum += x;
    for (Real& x : w) x /= sum;
    return w;
}
template <class T>
std::vector<Real> by_definition(const TriangleMesh<T>& cage, const Vec<Real, 3>& p) {
    std::vector<Real> w(cage.size(), 0);
    for (const auto& face : cageform::detail::outward_faces(cage)) {
        std::array<Vec<Real, 3>, 3> c, normal;
        for (std::size_t k = 0; k < 3; ++k) c[k] = vec_cast<Real>(cage[face[k]]) - p;
        Vec<Real, 3> m{};
        for (std::size_t k = 0; k < 3; ++k) {
            const auto &a = c[(k + 1) % 3], &b = c[(k + 2) % 3];
            normal[k] = cross(a, b);
            const Real sine = std::sqrt(dot(normal[k], normal[k]));
            normal[k] = (1 / sine) * normal[k];
            m = m + (std::atan2(sine, dot(a, b)) / 2) * normal[k];
        }
        for (std::size_t k = 0; k < 3; ++k) w[face[k]] += dot(normal[k], m) / dot(normal[k], c[k]);
    }
    Real sum = 0;
    for (const Real x : w) sum += x;
    for (Real& x : w) x /= sum;
    return w;
}

/// Central differences of fourth order, with a step much smaller than the distance from the boundary. By row,
/// times the diagonal.
template <class Cage, class T, std::size_t D>
std::vector<Vec<double, D>> differences(const Cage& cage, const Vec<T, D>& p) {
    const Real size = Real(bounds_of(cage.vertices()).diagonal());
    Vec<T, D> place;
    (void)nearest_boundary_value(cage, p, place);
    const Real step = Real(2e-3) * std::min(Real(distance(place, p)), size / 100);
    std::vector<Vec<double, D>> result(cage.size());
    for (std::size_t k = 0; k < D; ++k) {
        const auto at = [&](Real s) {
            auto q = vec_cast<Real>(p);
            q[k] += s;
            return by_definition(cage, q);
        };
        const auto a = at(step), b = at(-step), c = at(2 * step), d = at(-2 * step);
        for (std::size_t i = 0; i < cage.size(); ++i)
            result[i][k] = double((8 * (a[i] - b[i]) - (c[i] - d[i])) / (12 * step) * size);
    }
    return result;
}

template <class T>
using Mean2 = cageform::MeanValueCoordinates<T, 2>;
template <class T>
using Mean3 = cageform::MeanValueCoordinates<T, 3>;

static_assert(cageform::GradientCoordinates<Mean2<float>> && cageform::GradientCoordinates<Mean3<double>>);
static_assert(cageform::GradientCoordinates<cageform::BarycentricCoordinates<float, 3>>);
static_assert(cageform::GradientCoordinates<cageform::HarmonicCoordinates<double, 2>>);
static_assert(!cageform::GradientCoordinates<Polygon<double>>);

/// Points inside, next to edges and vertices, outside and far outside.
template <class T>
Points2<T> points_about(const Polygon<T>& cage, Random& random) {
    const auto bounds = bounds_of(cage.vertices());
    const double size = double(bounds.diagonal());
    Points2<T> points;
    for (int n = 0; n < 120; ++n) {
        auto p = vec_cast<double>(random_inside(cage, random, 1e-4));
        if (n % 3 == 1) {
            const double s = n % 2 == 0 ? 0.0 : random.uniform(0, 1);
            p = vec_cast<double>(on_edge(cage, random.below(cage.size()), s).position);
        }
        const double reach = n % 3 == 1   ? std::pow(10, random.uniform(sizeof(T) == 8 ? -8 : -4, -2))
                             : n % 3 == 2 ? std::pow(10, random.uniform(-1, 1))
                                          : 0;
        for (std::size_t k = 0; k < 2; ++k) p[k] += size * reach * random.uniform(-1, 1);
        points.push_back(vec_cast<T>(p));
    }
    return points;
}

} // namespace

TEMPLATE_TEST_CASE("gradients of mean value weights in the plane are their differences",
                   "[coordinates][meanvalue][gradients][oracle]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(16, 4)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 3);
    const auto cage = seed % 2 == 0 ? Polygon<T>(random_star<T>(std::uint64_t(seed)))
                                    : random_rings<T>(std::uint64_t(seed));
    const double size = double(bounds_of(cage.vertices()).diagonal());
    const auto points = points_about(cage, random);
    const auto gradients = gradients_of<T, 2>(Mean2<T>(cage), points);
    const auto weights = evaluate_all(Mean2<T>(cage), points);
    REQUIRE(gradients.evaluation.status == Status::ok);
    CHECK(gradients.states == weights.states);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, points[i][0], points[i][1], to_string(gradients.states[i]));
        // Outside, next to an edge of a ring, rounding alone causes 1e-11 (plain products) to 2e-10 (fused
        // products).
        CHECK(law_error<T, 2>(cage.vertices(), points[i], gradients.rows[i]) <=
              (sizeof(T) == 4                               ? 1e-6
               : gradients.states[i] == PointState::outside ? 1e-9
                                                            : 1e-10));
        if (gradients.states[i] == PointState::on_boundary) continue;
        // Next to the boundary, differences are less accurate than gradients.
        CHECK(error_of(gradients.rows[i], differences(cage, points[i]), size) <=
              (sizeof(T) == 8 ? 1e-7 * real_rounding : 1e-6 * real_rounding));
    }
}

TEMPLATE_TEST_CASE("gradients of mean value weights in space are their differences",
                   "[coordinates][meanvalue][space][gradients][oracle]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(12, 4)));
    CAPTURE(seed);
    const auto data = random_mesh(std::uint64_t(seed));
    const auto mesh = data.mesh<T>();
    const double size = double(bounds_of(mesh.vertices()).diagonal());
    Points3<T> points;
    for (const auto& p : points_about(data, 60, std::uint64_t(seed) + 1)) points.push_back(vec_cast<T>(p));
    const auto gradients = gradients_of<T, 3>(Mean3<T>(mesh), points);
    const auto weights = evaluate_all(Mean3<T>(mesh), points);
    REQUIRE(gradients.evaluation.status == Status::ok);
    CHECK(gradients.states == weights.states);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, to_string(gradients.states[i]));
        CHECK(law_error<T, 3>(mesh.vertices(), points[i], gradients.rows[i]) <=
              (sizeof(T) == 8 ? 1e-11 : 2e-6));
        if (gradients.states[i] == PointState::on_boundary) continue;
        // Next to planes of faces, the definition is less accurate than the gradients.
        CHECK(error_of(gradients.rows[i], differences(mesh, points[i]), size) <=
              (sizeof(T) == 8 ? 1e-6 * real_rounding : 1e-5 * real_rounding));
    }
}

TEST_CASE("gradients of mean value weights are continuous through planes of faces and beyond edges",
          "[coordinates][meanvalue][space][gradients][limits]") {
    // On either side of a plane, beside its face, gradients differ by the distance. The plain formulas divide
    // by that distance.
    const int seed = GENERATE(seeds(effort(10, 4)));
    CAPTURE(seed);
    const auto mesh = random_mesh(std::uint64_t(seed)).mesh<double>();
    const Mean3<double> coordinates(mesh);
    const double size = bounds_of(mesh.vertices()).diagonal();
    Random random(std::uint64_t(seed) + 40);
    int compared = 0;
    for (int n = 0; n < 60; ++n) {
        const auto& face = mesh.faces()[random.below(mesh.faces().size())];
        const auto a = mesh[face[0]], b = mesh[face[1]], c = mesh[face[2]];
        auto normal = cross(b - a, c - a);
        normal = (1 / std::sqrt(dot(normal, normal))) * normal;
        // In the plane, or on the line of an edge.
        const auto foot =
            a + random.uniform(-2, 3) * (b - a) + (n % 3 == 0 ? 0.0 : random.uniform(-2, 3)) * (c - a);
        Vec<double, 3> place;
        (void)nearest_boundary_value(mesh, foot, place);
        if (distance(place, foot) < 0.02 * size) continue;
        ++compared;
        Points3<double> points;
        for (const double height : {0.0, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6})
            points.insert(points.end(), {foot + height * size * normal, foot - height * size * normal});
        const auto rows = gradients_of<double, 3>(coordinates, points).rows;
        for (std::size_t i = 1; i < points.size(); ++i) {
            double largest = 1, worst = 0;
            for (std::size_t h = 0; h < mesh.size(); ++h) {
                largest = cageform_tests::larger(largest, size * std::sqrt(dot(rows[0][h], rows[0][h])));
                const double d = size * distance(rows[i][h], rows[0][h]);
                worst = cageform_tests::larger(worst, d);
            }
            CAPTURE(n, i, largest);
            // Second derivatives are some hundreds near corners.
            CHECK(worst <= largest * (1e-8 + 1e3 * distance(points[i], points[0]) / size));
        }
    }
    CHECK(compared > 10);
}

TEMPLATE_TEST_CASE("gradients in planes and on lines of edges are continuous",
                   "[coordinates][meanvalue][space][gradients][limits]", CAGEFORM_SCALARS) {
    using T = TestType;
    for (const char* name : {"cube", "l_prism"}) {
        const auto json = read_json(std::string("meanvalue3d_") + name);
        MeshData data;
        for (const auto& v : json["cage"]["vertices"]) data.vertices.push_back({v[0], v[1], v[2]});
        for (const auto& f : json["cage"]["faces"]) data.faces.push_back({f[0], f[1], f[2]});
        const auto mesh = data.mesh<T>();
        const double size = double(bounds_of(mesh.vertices()).diagonal());
        std::array<std::vector<T>, 3> at; // coordinates of vertices, one half-way between, one outside
        for (std::size_t k = 0; k < 3; ++k) {
            for (const auto& v : mesh.vertices()) at[k].push_back(v[k]);
            std::sort(at[k].begin(), at[k].end());
            at[k].erase(std::unique(at[k].begin(), at[k].end()), at[k].end());
            at[k].push_back(T(0.5) * (at[k][0] + at[k][1]));
            at[k].push_back(at[k][0] - T(0.25) * (at[k][1] - at[k][0]));
        }
        Points3<T> points, beside;
        Random random(5);
        for (std::size_t n = 0; n < at[0].size() * at[1].size() * at[2].size(); ++n) {
            const Vec<T, 3> p{at[0][n % at[0].size()], at[1][n / at[0].size() % at[1].size()],
                              at[2][n / at[0].size() / at[1].size()]};
            Vec<T, 3> place;
            (void)nearest_boundary_value(mesh, p, place);
            if (distance(place, p) < 0.01 * size) continue;
            points.push_back(p);
            beside.push_back(p);
            for (std::size_t k = 0; k < 3; ++k) beside.back()[k] += T(1e-6 * size * random.uniform(-1, 1));
        }
        REQUIRE(points.size() > 10);
        const auto rows = gradients_of<T, 3>(Mean3<T>(mesh), points).rows;
        const auto expected = gradients_of<T, 3>(Mean3<T>(mesh), beside).rows;
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(name, i, points[i][0], points[i][1], points[i][2]);
            CHECK(law_error<T, 3>(mesh.vertices(), points[i], rows[i]) <= (sizeof(T) == 8 ? 1e-12 : 1e-6));
            for (std::size_t h = 0; h < mesh.size(); ++h)
                CHECK(size * distance(rows[i][h], expected[i][h]) <= 1e-4);
        }
    }
}

TEMPLATE_TEST_CASE(
    "gradients of mean value weights on and next to the boundary keep the laws and are those inside",
    "[coordinates][meanvalue][gradients][limits]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(10, 4)));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 60);
    const double tolerance = sizeof(T) == 8 ? 1e-10 : 2e-6;

    const auto mesh = random_mesh(std::uint64_t(seed)).mesh<T>();
    const double size = double(bounds_of(mesh.vertices()).diagonal());
    Points3<T> points;
    for (int n = 0; n < 60; ++n) { // on faces, edges and vertices
        const auto& face = mesh.faces()[random.below(mesh.faces().size())];
        const auto a = vec_cast<double>(mesh[face[0]]), b = vec_cast<double>(mesh[face[1]]),
                   c = vec_cast<double>(mesh[face[2]]);
        const double u = n % 3 == 2 ? 0.0 : random.uniform(0, 1);
        const double v = n % 3 == 0 ? random.uniform(0, 1 - u) : 0.0;
        points.push_back(vec_cast<T>(a + u * (b - a) + v * (c - a)));
    }
    const auto gradients = gradients_of<T, 3>(Mean3<T>(mesh), points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        // Rounding of float coordinates may move points off the boundary.
        CHECK(gradients.states[i] == PointState::on_boundary);
        CHECK(law_error<T, 3>(mesh.vertices(), points[i], gradients.rows[i]) <= tolerance);
        // Bounded, although the individual terms are not.
        double largest = 0;
        for (const auto& g : gradients.rows[i])
            largest = cageform_tests::larger(largest, size * std::sqrt(double(dot(g, g))));
        CHECK(largest <= 1e3);
    }
    // In the middle of a face, gradients are continuous with those inside.
    if constexpr (std::is_same_v<T, double>) {
        const Mean3<double> coordinates(mesh);
        const auto faces = cageform::detail::outward_faces(mesh);
        for (std::size_t f = 0; f < faces.size(); f += 1 + faces.size() / 40) {
            const auto& face = faces[f];
            const auto a = mesh[face[0]], b = mesh[face[1]], c = mesh[face[2]];
            auto inwards = cross(c - a, b - a);
            const double area = std::sqrt(dot(inwards, inwards));
            inwards = (1 / area) * inwards;
            const auto middle = (1.0 / 3) * (a + b + c);
            Points3<double> towards{middle};
            for (const double height : {1e-11, 1e-9, 1e-7, 1e-5})
                towards.push_back(middle + height * size * inwards);
            const auto rows = gradients_of<double, 3>(coordinates, towards).rows;
            for (std::size_t i = 1; i < towards.size(); ++i) {
                double worst = 0;
                for (std::size_t h = 0; h < mesh.size(); ++h)
                    worst = cageform_tests::larger(worst, size * distance(rows[i][h], rows[0][h]));
                CHECK(worst <= 0.05);
            }
        }
    }

    const Polygon<T> cage(random_star<T>(std::uint64_t(seed)));
    const double extent = double(bounds_of(cage.vertices()).diagonal());
    Points2<T> border;
    for (std::size_t i = 0; i < cage.size(); ++i) {
        border.push_back(cage[i]);
        border.push_back(on_edge(cage, i, random.uniform(0.2, 0.8)).position);
    }
    const Mean2<T> flat(cage);
    const auto on_border = gradients_of<T, 2>(flat, border);
    for (std::size_t i = 0; i < border.size(); ++i) {
        CAPTURE(i);
        CHECK(on_border.states[i] == PointState::on_boundary);
        CHECK(law_error<T, 2>(cage.vertices(), border[i], on_border.rows[i]) <= tolerance);
        double largest = 0;
        for (const auto& g : on_border.rows[i])
            largest = cageform_tests::larger(largest, extent * std::sqrt(double(dot(g, g))));
        CHECK(largest <= 1e3);
    }
}

TEST_CASE("gradients at a point that sees an edge under an exact right angle are continuous",
          "[coordinates][mean_value]") {
    const std::vector<Vec<double, 2>> cage{{-1, 0}, {1, 0}, {1.5, 3}, {-2, 2.5}};
    const cageform::MeanValueCoordinates coordinates(cage);
    const auto at = [&](const Vec<double, 2>& p) {
        const auto bound = cageform::bind_jacobians(coordinates, std::vector<Vec<double, 2>>{p},
                                                    {.linear_precision = cageform::LinearPrecision::leave});
        REQUIRE(bound);
        return bound;
    };
    const auto here = at({0, 1}); // (−1, 0) and (1, 0) are seen under a right angle
    const auto beside = at({1e-9, 1 + 1e-9});
    CHECK(here.report.reproduction_error.value <= 1e-14);
    for (std::size_t k = 0; k < 2; ++k) {
        for (std::size_t i = 0; i < cage.size(); ++i)
            CHECK(std::fabs(here.value[k].weight(0, i) - beside.value[k].weight(0, i)) <= 1e-8);
    }
}

TEST_CASE("gradients of mean value weights keep the laws far away",
          "[coordinates][meanvalue][gradients][far]") {
    const auto mesh = random_mesh(2).mesh<double>();
    const double size = bounds_of(mesh.vertices()).diagonal();
    const Polygon<double> cage(random_star<double>(4));
    const double extent = bounds_of(cage.vertices()).diagonal();
    Random random(8);
    for (const double reach : {3.0, 30.0, 1e3, 1e4}) {
        Points3<double> points;
        Points2<double> flat;
        for (int n = 0; n < 20; ++n) {
            const Vec<double, 3> way{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            points.push_back(mesh[0] + reach * size * way);
            flat.push_back(cage[0] + reach * extent * Vec<double, 2>{way[0], way[1]});
        }
        CAPTURE(reach);
        const auto in_space = gradients_of<double, 3>(Mean3<double>(mesh), points);
        const auto in_plane = gradients_of<double, 2>(Mean2<double>(cage), flat);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CHECK(in_space.states[i] == PointState::outside);
            CHECK(law_error<double, 3>(mesh.vertices(), points[i], in_space.rows[i]) <=
                  (reach > 1e3 ? 1e-7 : 1e-9));
            CHECK(law_error<double, 2>(cage.vertices(), flat[i], in_plane.rows[i]) <= 1e-9);
        }
    }
}

TEMPLATE_TEST_CASE("gradients of barycentric weights are those of affine functions",
                   "[coordinates][barycentric][gradients]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(6));
    const auto check = [&]<std::size_t D>(std::integral_constant<std::size_t, D>) {
        CAPTURE(seed, D);
        const auto corners = random_simplex<T, D>(std::uint64_t(seed));
        const cageform::BarycentricCoordinates<T, D> coordinates(corners);
        Random random(std::uint64_t(seed) + 1);
        std::vector<Vec<T, D>> points{corners[0]};
        for (int n = 0; n < 20; ++n) {
            auto p = vec_cast<T>(combine(random_shares(D + 1, random), corners));
            if (n % 4 == 0) p = p + T(10) * (p - corners[0]);
            points.push_back(p);
        }
        const auto gradients = gradients_of<T, D>(coordinates, points);
        CHECK(gradients.states == evaluate_all(coordinates, points).states);
        CHECK(gradients.states[0] == PointState::on_boundary);
        for (std::size_t i = 0; i < points.size(); ++i) {
            CHECK(gradients.rows[i] == gradients.rows[0]);
            CHECK(law_error<T, D>(corners, points[i], gradients.rows[i]) <= 64 * double(epsilon<T>));
        }
    };
    check(std::integral_constant<std::size_t, 1>{});
    check(std::integral_constant<std::size_t, 2>{});
    check(std::integral_constant<std::size_t, 3>{});
}

TEST_CASE("gradients of mean value weights are unreached where they do not exist",
          "[coordinates][meanvalue][gradients][status]") {
    const auto data = random_mesh(2);
    const auto mesh = data.mesh<double>();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    Points3<double> points = points_about(data, 200, 9);
    points[3][1] = nan;
    const Mean3<double> coordinates(mesh);
    const auto gradients = gradients_of<double, 3>(coordinates, points);
    CHECK(gradients.states[3] == PointState::not_finite);
    cageform::Running threaded;
    threaded.parallel = cageform::ThreadedFor{2};
    const auto again = gradients_of<double, 3>(coordinates, points, threaded);
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i != 3) CHECK(again.rows[i] == gradients.rows[i]);
    }
    std::size_t calls = 0;
    threaded.progress = [&](double) { return ++calls < 1; };
    CHECK(gradients_of<double, 3>(coordinates, points, threaded).evaluation.status == Status::cancelled);

    auto open = sphere(1);
    open.faces.resize(open.faces.size() / 2);
    CHECK(gradients_of<double, 3>(Mean3<double>(open.mesh<double>()), points).evaluation.status ==
          Status::cage_not_closed);
}

} // namespace mean_value_gradients_tests

// Coordinates of cages whose faces are planar polygons.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/gradients.hpp"
#include "../support/larger.hpp"
#include "../support/oracle.hpp"
#include "../support/polyhedra.hpp"
#include "../support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/coordinates/mean_value.hpp>
#include <cageform/coordinates/uniform_harmonic.hpp>

#include <optional>

namespace polyhedral_tests {

using namespace cageform_tests;
using cageform::HarmonicCoordinates;
using cageform::HarmonicOptions;
using cageform::MeanValueCoordinates;
using cageform::PolyhedralMesh;

namespace {

template <class T>
using MeanValue = MeanValueCoordinates<T, 3, PolyhedralMesh<T>>;

HarmonicOptions at_resolution(std::size_t resolution) {
    HarmonicOptions options;
    options.resolution = resolution;
    return options;
}

/// A random point of a face, in one of its triangles.
template <class T>
Vec<T, 3> random_on_face(const PolyhedralMesh<T>& mesh, std::size_t f, Random& random) {
    const auto [first, last] = mesh.triangles_of(f);
    const auto& triangle = mesh.triangles().faces()[first + random.below(last - first)];
    const auto shares = random_shares(3, random);
    Vec<double, 3> p{};
    for (std::size_t k = 0; k < 3; ++k) p = p + shares[k] * vec_cast<double>(mesh[triangle[k]]);
    return vec_cast<T>(p);
}

template <class T>
std::vector<Vec<T, 3>> random_points(const PolyhedralMesh<T>& mesh, std::size_t count, Random& random,
                                     double beyond = 0) {
    const auto bounds = bounds_of(mesh.vertices());
    std::vector<Vec<T, 3>> points(count);
    for (auto& p : points) {
        for (std::size_t k = 0; k < 3; ++k) {
            const double extent = double(bounds.upper[k]) - double(bounds.lower[k]);
            p[k] = T(double(bounds.lower[k]) + random.uniform(-beyond, 1 + beyond) * extent);
        }
    }
    return points;
}

} // namespace

TEST_CASE("harmonic coordinates of cages with polygons as faces: reference values",
          "[coordinates][polyhedral][harmonic][oracle]") {
    struct Case {
        const char* name;
        double
            /// Bilinear boundary values are met to the solver's tolerance; order 4/3 beside the reflex edge
            /// of the L.
            tolerance;
    };
    const auto [name, tolerance] = GENERATE(values<Case>({{"harmonic3d_cube_quads", 1e-6},
                                                          {"harmonic3d_box_mixed_diagonals_quads", 1e-6},
                                                          {"harmonic3d_l_prism_product", 4e-3}}));
    CAPTURE(name);
    const auto json = read_json(name);
    const auto points_of = [](const nlohmann::json& list) {
        std::vector<Vec<double, 3>> points;
        for (const auto& p : list)
            points.push_back({p[0].get<double>(), p[1].get<double>(), p[2].get<double>()});
        return points;
    };
    const PolyhedralMesh<double> cage(points_of(json["cage"]["vertices"]),
                                      json["cage"]["faces"].get<Loops>());
    const HarmonicCoordinates coordinates(cage, at_resolution(48), cageform::UniformGrid{});
    const auto found = evaluate_all(coordinates, points_of(json["points"]));
    REQUIRE(found.status() == Status::ok);
    REQUIRE(found.rows.size() >= 10);
    double sum = 0;
    for (std::size_t i = 0; i < found.rows.size(); ++i) {
        const auto expected = json["coordinates"][i].get<std::vector<double>>();
        CAPTURE(i, text(found.rows[i]), text(expected));
        CHECK(difference(found.rows[i], expected) <= tolerance);
        sum += difference(found.rows[i], expected);
    }
    CHECK(sum <= 0.3 * tolerance * double(found.rows.size()));
}

TEST_CASE("harmonic coordinates of a prism are those of its floor times a linear function",
          "[coordinates][polyhedral][harmonic]") {
    // A convex heptagon, without corners that need a finer grid.
    std::vector<Vec<double, 2>> base;
    for (int k = 0; k < 7; ++k) {
        const double angle = 2 * std::numbers::pi * k / 7, radius = k % 2 == 0 ? 1 : 0.8;
        base.push_back({radius * std::cos(angle), radius * std::sin(angle)});
    }
    const auto data = prism_over(base, 1.5);
    const HarmonicCoordinates coordinates(data.cage<double>(), at_resolution(48), cageform::UniformGrid{});
    HarmonicOptions fine = at_resolution(512);
    const HarmonicCoordinates plane(cageform::Polygon<double>(base), fine, cageform::UniformGrid{});
    Random random(7);
    const auto points = random_points(data.cage<double>(), 200, random);
    std::vector<Vec<double, 2>> flat;
    for (const auto& p : points) flat.push_back({p[0], p[1]});
    const auto found = evaluate_all(coordinates, points), below = evaluate_all(plane, flat);
    REQUIRE(found.status() == Status::ok);
    REQUIRE(below.status() == Status::ok);
    std::size_t inside = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        REQUIRE(found.states[i] == below.states[i]);
        if (found.states[i] != PointState::inside) continue;
        ++inside;
        const double z = points[i][2] / 1.5;
        std::vector<double> expected;
        for (const double h : below.rows[i]) expected.push_back((1 - z) * h);
        for (const double h : below.rows[i]) expected.push_back(z * h);
        CHECK(difference(found.rows[i], expected) <= 1e-3); // measured: 4e-4, the grid's error
    }
    CHECK(inside > 80);
}

TEMPLATE_TEST_CASE("on a face the weights are those in its plane", "[coordinates][polyhedral]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(range<std::uint64_t>(0, effort(6u, 1u)));
    CAPTURE(seed);
    const auto data = random_prism(seed);
    const auto cage = data.template cage<T>();
    const MeanValue<T> mean_value(cage);
    const HarmonicCoordinates harmonic(cage, at_resolution(24), cageform::UniformGrid{});
    Random random(seed);
    std::vector<Vec<T, 3>> points;
    std::vector<std::size_t> face_of;
    for (int n = 0; n < 40; ++n) {
        const std::size_t f = n % 2 == 0 ? std::size_t(n / 2) % 2 : random.below(cage.face_count());
        points.push_back(random_on_face(cage, f, random));
        face_of.push_back(f);
    }
    const auto by_mean_value = evaluate_all(mean_value, points), by_harmonic = evaluate_all(harmonic, points);
    REQUIRE(by_mean_value.status() == Status::ok);
    const bool seen = by_harmonic.status() == Status::ok; // the grid may miss a corner of a thin star
    if (!seen) REQUIRE(by_harmonic.status() == Status::grid_too_coarse);
    std::vector<std::optional<cageform::HarmonicCoordinates<double, 2>>> in_plane(cage.face_count());
    std::size_t on_face = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto plane = cageform::detail::plane_of(cage, face_of[i]);
        const auto polygon = cageform::detail::flat_face(cage, face_of[i], plane);
        const auto q = plane.flat(vec_cast<double>(points[i]));
        std::vector<double> row(polygon.size());
        const auto spread = [&](const auto& coordinates) {
            (void)weights_at(coordinates, q, std::span(row));
            std::vector<double> all(cage.size());
            for (std::size_t k = 0; k < row.size(); ++k) all[cage.face(face_of[i])[k]] = row[k];
            return all;
        };
        CAPTURE(i, face_of[i]);
        if (by_mean_value.states[i] == PointState::on_boundary) {
            ++on_face;
            CHECK(difference(by_mean_value.rows[i], spread(MeanValueCoordinates<double, 2>(polygon))) <=
                  (sizeof(T) == 4 ? 2e-5 : 1e-10));
        }
        if (!seen || by_harmonic.states[i] != PointState::on_boundary) continue;
        // Functions of faces are solved to 1e-5 for every resolution; rectangles are exact.
        auto& face = in_plane[face_of[i]];
        if (!face) {
            face.emplace(polygon, HarmonicOptions{.accuracy = 1e-5});
            REQUIRE(face->solve().status == Status::ok);
        }
        CHECK(difference(by_harmonic.rows[i], spread(*face)) <= 1e-5);
    }
    CHECK(on_face > points.size() / 2);
}

TEMPLATE_TEST_CASE("weights sum to 1 and reproduce the place, harmonic ones are in [0, 1]",
                   "[coordinates][polyhedral]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(range<std::uint64_t>(0, 25));
    CAPTURE(seed);
    const auto cage = random_prism(seed).template cage<T>();
    Random random(seed);
    auto points = random_points(cage, 100, random, 0.2);
    for (int n = 0; n < 20; ++n) {
        auto p = random_on_face(cage, random.below(cage.face_count()), random);
        points.push_back(p);
        p[2] = T(double(p[2]) * (1 + 1e-5)); // above the ceiling, or along a side
        points.push_back(p);
    }
    const double size = size_of(cage.vertices()), rounding = double(cageform::epsilon<T>);
    const auto check_rows = [&](const auto& found, double tolerance, bool in_range) {
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (in_range && found.states[i] == PointState::outside) continue;
            CAPTURE(i, text(found.rows[i]), int(found.states[i]));
            REQUIRE(found.states[i] != PointState::unreached);
            const double scale = absolute_sum(found.rows[i]);
            CHECK(std::fabs(double(sum_of(found.rows[i])) - 1) <= tolerance * scale);
            CHECK(distance(combine(found.rows[i], cage.vertices()), points[i]) <= tolerance * scale * size);
            for (const T w : found.rows[i]) CHECK((!in_range || (w >= 0 && w <= 1)));
        }
    };
    const auto by_mean_value = evaluate_all(MeanValue<T>(cage), points);
    REQUIRE(by_mean_value.status() == Status::ok);
    check_rows(by_mean_value, 200 * rounding, false);
    const auto by_harmonic =
        evaluate_all(HarmonicCoordinates(cage, at_resolution(24), cageform::UniformGrid{}), points);
    if (by_harmonic.status() == Status::grid_too_coarse) return;
    REQUIRE(by_harmonic.status() == Status::ok);
    check_rows(by_harmonic, 2e-5, true);
}

TEST_CASE("the start of a face's loop has no effect, its triangulation has", "[coordinates][polyhedral]") {
    auto data = l_prism();
    const auto cage = data.cage<double>();
    Random random(5);
    for (auto& face : data.faces)
        std::rotate(face.begin(), face.begin() + std::ptrdiff_t(1 + random.below(face.size() - 1)),
                    face.end());
    const auto begun_elsewhere = data.cage<double>();
    const auto points = random_points(cage, 200, random, 0.3);
    const auto compare = [&](const auto& a, const auto& b) {
        double worst = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (a.states[i] == PointState::inside)
                worst = cageform_tests::larger(worst, difference(a.rows[i], b.rows[i]));
        }
        return worst;
    };
    const auto by_mean_value = evaluate_all(MeanValue<double>(cage), points);
    CHECK(compare(by_mean_value, evaluate_all(MeanValue<double>(begun_elsewhere), points)) <= 1e-13);
    CHECK(compare(by_mean_value, evaluate_all(MeanValueCoordinates<double, 3>(cage.triangles()), points)) >
          0.05);
    const auto options = at_resolution(32);
    const auto by_harmonic =
        evaluate_all(HarmonicCoordinates(cage, options, cageform::UniformGrid{}), points);
    CHECK(compare(by_harmonic,
                  evaluate_all(HarmonicCoordinates(begun_elsewhere, options, cageform::UniformGrid{}),
                               points)) <= 1e-5);
    CHECK(compare(by_harmonic,
                  evaluate_all(HarmonicCoordinates(cage.triangles(), options, cageform::UniformGrid{}),
                               points)) > 0.05);
}

TEMPLATE_TEST_CASE("of triangles alone the weights are those of a TriangleMesh, to the bit",
                   "[coordinates][polyhedral]", CAGEFORM_SCALARS) {
    using T = TestType;
    const auto prism = random_prism(3);
    const auto triangles = prism.template cage<T>().triangles();
    const PolyhedralMesh<T> cage(triangles.vertices(), triangles.faces());
    Random random(4);
    const auto points = random_points(cage, 150, random, 0.2);
    CHECK(evaluate_all(MeanValue<T>(cage), points).rows ==
          evaluate_all(MeanValueCoordinates<T, 3>(triangles), points).rows);
    const auto options = at_resolution(24);
    const auto found = evaluate_all(HarmonicCoordinates(cage, options, cageform::UniformGrid{}), points);
    const auto expected =
        evaluate_all(HarmonicCoordinates(triangles, options, cageform::UniformGrid{}), points);
    REQUIRE(found.status() == expected.status());
    CHECK(found.states == expected.states);
    for (std::size_t i = 0; i < found.rows.size(); ++i) {
        if (found.states[i] == PointState::inside) CHECK(found.rows[i] == expected.rows[i]);
    }
}

TEMPLATE_TEST_CASE("gradients of mean value coordinates of polygons", "[coordinates][polyhedral][gradients]",
                   CAGEFORM_SCALARS) {
    using T = TestType;
    const auto seed = GENERATE(range<std::uint64_t>(0, 6));
    CAPTURE(seed);
    const auto cage = random_prism(seed).template cage<T>();
    const MeanValue<T> coordinates(cage);
    const MeanValue<double> precise(random_prism(seed).template cage<double>());
    Random random(seed);
    const auto points = random_points(cage, 40, random, 0.1);
    const auto gradients = gradients_of<T, 3>(coordinates, points);
    REQUIRE(gradients.evaluation.status == Status::ok);
    const double size = double(bounds_of(cage.vertices()).diagonal());
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i);
        CHECK(law_error<T, 3>(cage.vertices(), points[i], gradients.rows[i]) <=
              (sizeof(T) == 4 ? 1e-4 : 1e-9));
        const double step = 1e-5 * size;
        std::vector<Vec<double, 3>> expected(cage.size());
        for (std::size_t k = 0; k < 3; ++k) {
            std::vector<double> low(cage.size()), high(cage.size());
            auto q = vec_cast<double>(points[i]);
            q[k] -= step;
            (void)weights_at(precise, q, std::span(low));
            q[k] += 2 * step;
            (void)weights_at(precise, q, std::span(high));
            for (std::size_t h = 0; h < cage.size(); ++h)
                expected[h][k] = (high[h] - low[h]) / (2 * step) * size;
        }
        CHECK(error_of(gradients.rows[i], expected, size) <= 1e-3); // the error of differences next to edges
    }
}

TEST_CASE("mean value coordinates of polygons are continuous up to faces, edges and vertices",
          "[coordinates][polyhedral]") {
    const auto seed = GENERATE(range<std::uint64_t>(0, 12));
    CAPTURE(seed);
    const auto cage = random_prism(seed).cage<double>();
    const MeanValue<double> coordinates(cage);
    const double size = double(bounds_of(cage.vertices()).diagonal());
    Random random(seed);
    std::vector<Vec<double, 3>> on, beside;
    for (int n = 0; n < 60; ++n) {
        const std::size_t f = random.below(cage.face_count());
        auto p = random_on_face(cage, f, random);
        const auto loop = cage.face(f);
        const std::size_t k = random.below(loop.size());
        const auto &a = cage[loop[k]], &b = cage[loop[(k + 1) % loop.size()]];
        if (n % 3 == 1) p = a + random.uniform(0, 1) * (b - a);
        if (n % 3 == 2) p = a;
        Vec<double, 3> aside;
        for (std::size_t axis = 0; axis < 3; ++axis) aside[axis] = random.uniform(-1, 1);
        on.push_back(p);
        beside.push_back(p + (1e-9 * size) * aside);
    }
    const auto at = evaluate_all(coordinates, on), near = evaluate_all(coordinates, beside);
    for (std::size_t i = 0; i < on.size(); ++i) {
        CAPTURE(i, text(at.rows[i]), text(near.rows[i]));
        CHECK(difference(at.rows[i], near.rows[i]) <= 2e-6); // 1e-9 over the shortest edge and angle
    }
}

TEST_CASE("mean value coordinates of polygons are continuous across the planes of faces, beside them too",
          "[coordinates][polyhedral]") {
    const auto cage = l_prism().cage<double>();
    const MeanValue<double> coordinates(cage);
    Random random(5);
    std::vector<Vec<double, 3>> on, beside;
    for (int n = 0; n < 300; ++n) { // multiples of 1/4: exactly in the planes, inside the cage and outside
        Vec<double, 3> p, aside;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            p[axis] = 0.25 * double(random.below(14)) - 0.5;
            aside[axis] = random.uniform(-1, 1);
        }
        on.push_back(p);
        beside.push_back(p + 1e-9 * aside);
    }
    const auto at = evaluate_all(coordinates, on), near = evaluate_all(coordinates, beside);
    std::size_t inside = 0, beyond = 0;
    for (std::size_t i = 0; i < on.size(); ++i) {
        CAPTURE(i, text(at.rows[i]), text(near.rows[i]));
        CHECK(difference(at.rows[i], near.rows[i]) <= 1e-7);
        inside += at.states[i] == PointState::inside ? 1 : 0;
        beyond += at.states[i] == PointState::outside ? 1 : 0;
    }
    CHECK(inside > 10);
    CHECK(beyond > 100);
}

TEST_CASE("bind accepts polyhedral cages and outside points", "[coordinates][polyhedral][bind]") {
    const auto cage = l_prism().cage<double>();
    Random random(11);
    const auto points = random_points(cage, 300, random, 0.3);
    const auto check_binding = [&](const auto& coordinates) {
        const auto bound = cageform::bind(coordinates, points);
        REQUIRE(bound.report.status == Status::ok);
        std::vector<double> row(cage.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            CAPTURE(i);
            if (locate(cage, points[i], 0.0) == PointState::inside) {
                for (std::size_t h = 0; h < cage.size(); ++h) row[h] = bound.value.view().weights(i, h);
                CHECK(distance(combine(row, cage.vertices()), points[i]) <= 1e-14 * size_of(cage.vertices()));
            }
            const auto place = coordinates.nearest_boundary(points[i], row);
            CHECK(locate(cage, place, 1e-12) == PointState::on_boundary);
            CHECK(distance(combine(row, cage.vertices()), place) <= 1e-5);
        }
    };
    check_binding(HarmonicCoordinates(cage, at_resolution(32), cageform::UniformGrid{}));
    check_binding(MeanValue<double>(cage));
}

TEST_CASE("faulty polyhedral cages are refused by both types", "[coordinates][polyhedral][status]") {
    auto data = l_prism();
    data.vertices[3][2] = 0.01;
    const HarmonicCoordinates harmonic(data.cage<double>(), at_resolution(32), cageform::UniformGrid{});
    const MeanValue<double> mean_value(data.cage<double>());
    const std::vector<Vec<double, 3>> points{{0.5, 0.5, 0.5}};
    CHECK(evaluate_all(harmonic, points).status() == Status::face_not_planar);
    CHECK(evaluate_all(mean_value, points).status() == Status::face_not_planar);
    CHECK(harmonic.cage_report().faults.front().b == 3);
    // A cage that allows corners off the planes, by a negligible distance.
    data.vertices[3][2] = 1e-4;
    const MeanValue<double> lenient(data.vertices, data.faces,
                                    cageform::PolyhedralOptions{.off_plane = 1e-3});
    const auto found = evaluate_all(lenient, points);
    REQUIRE(found.status() == Status::ok);
    CHECK(distance(combine(found.rows[0], lenient.handles()), points[0]) <= 1e-4);
}

} // namespace polyhedral_tests

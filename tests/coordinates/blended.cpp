// Coordinates of several cages over one figure.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/meshes.hpp"
#include "../support/uniform_harmonic.hpp"
#include "../support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/coordinates/blended.hpp>
#include <cageform/coordinates/mean_value.hpp>

namespace blended_tests {

using namespace cageform_tests;
using cageform::BlendedCoordinates;
using cageform::HarmonicCoordinates;
using cageform::MeanValueCoordinates;
using cageform::Polygon;
using cageform::detail::Depth;

namespace {

template <class T>
Points2<T> rectangle(double left, double bottom, double right, double top) {
    return {{T(left), T(bottom)}, {T(right), T(bottom)}, {T(right), T(top)}, {T(left), T(top)}};
}

/// Two cages that overlap for x in [1, 2] and y in [0, 1].
template <class C>
BlendedCoordinates<C> pair_of_cages() {
    using T = typename C::scalar;
    return BlendedCoordinates<C>(
        {C(Polygon<T>(rectangle<T>(0, 0, 2, 1))), C(Polygon<T>(rectangle<T>(1, -1, 3, 2)))});
}

} // namespace

TEMPLATE_TEST_CASE("depth is smooth, positive inside, and proportional to the distance at the boundary",
                   "[cage][depth][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(12, 4)));
    CAPTURE(seed);
    const auto rings = random_rings<T>(std::uint64_t(seed));
    const Depth<Polygon<T>> depth(rings);
    Random random{std::uint64_t(seed)};
    const double size = double(bounds_of(rings.vertices()).diagonal());
    for (int n = 0; n < 60; ++n) {
        const auto p = random_inside(rings, random);
        const double distance = double(nearest_on_boundary(rings, p).distance);
        CHECK(depth(p) > 0);
        CHECK(depth(p) <= 2 * distance); // with equality if half of the directions are blocked
    }
    for (std::size_t edge = 0; edge < rings.size();
         ++edge) { // next to the middle of an edge: half the distance
        const auto on = on_edge(rings, edge, 0.5);
        const auto along = vec_cast<double>(rings[on.j]) - vec_cast<double>(rings[on.i]);
        const double step = 1e-4 * cageform::detail::length(along);
        for (const double side : {-step, step}) {
            const Vec<double, 2> across{-side * along[1] / cageform::detail::length(along),
                                        side * along[0] / cageform::detail::length(along)};
            const auto q = vec_cast<T>(vec_cast<double>(on.position) + across);
            if (locate(rings, q, T(0)) != PointState::inside) continue;
            const double distance = double(nearest_on_boundary(rings, q).distance);
            if (distance > 1e-3 * size || distance < 1e3 * double(cageform::epsilon<T>) * size) continue;
            CHECK(std::fabs(depth(q) / distance - 0.5) <= 0.02);
        }
    }
}

TEST_CASE("the depth of meshes and boxes", "[cage][depth]") {
    const auto ball = sphere(3).mesh<double>();
    const Depth<cageform::TriangleMesh<double>> depth(ball);
    CHECK(std::fabs(depth(Vec<double, 3>{0, 0, 0}) * 4 * std::numbers::pi - 1) <= 0.02); // 1/ρ = 1
    // On a ray to the boundary: 1/∫ tends to zero like 1/π of the distance.
    const double near = depth(Vec<double, 3>{0.95, 0.02, 0.01}),
                 nearer = depth(Vec<double, 3>{0.975, 0.02, 0.01});
    CHECK(near > nearer);
    CHECK(nearer > 0);
    // A cube with a dent, at points on the line of an edge, from which the edge is seen as a point.
    const Points3<double> corners{{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1},
                                  {1, -1, 1},   {1, 1, 1},   {-1, 1, 1}, {0, 0, 0}};
    const Faces faces{{0, 2, 1}, {0, 3, 2}, {0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5}, {2, 3, 7},
                      {2, 7, 6}, {3, 0, 4}, {3, 4, 7}, {4, 5, 8}, {5, 6, 8}, {6, 7, 8}, {7, 4, 8}};
    const Depth<cageform::TriangleMesh<double>> dented(cageform::TriangleMesh<double>(corners, faces));
    const Vec<double, 3> beyond{-0.25, -0.25, -0.25};
    CHECK(dented(beyond) > 0.01);
    CHECK(dented(beyond) == Approx(dented(beyond + Vec<double, 3>{1e-8, -2e-8, 1e-8})).epsilon(1e-6));
}

TEMPLATE_TEST_CASE(
    "blended weights sum to 1, reproduce the point, and are those of the one cage where there is one",
    "[coordinates][blended][property]", (MeanValueCoordinates<float, 2>), (HarmonicCoordinates<double, 2>)) {
    using C = TestType;
    using T = typename C::scalar;
    const auto coordinates = pair_of_cages<C>();
    REQUIRE(coordinates.handles().size() == 8);
    Random random(4);
    Points2<T> points;
    for (int n = 0; n < 500; ++n)
        points.push_back({T(random.uniform(-0.5, 3.5)), T(random.uniform(-1.5, 2.5))});
    for (const Points2<T>& more : {Points2<T>{{0, T(0.5)}, {2, T(0.5)}, {1, 1}, {3, 2}, {1, T(1.5)}}})
        points.insert(points.end(), more.begin(), more.end());
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    const auto first = evaluate_all(coordinates.components()[0], points),
               second = evaluate_all(coordinates.components()[1], points);
    const double tolerance = 64 * double(cageform::epsilon<T>) + (C::closed_form ? 0 : 1e-5);
    for (std::size_t i = 0; i < points.size(); ++i) {
        CAPTURE(i, points[i][0], points[i][1]);
        const auto a = first.states[i], b = second.states[i];
        if (a == PointState::outside && b == PointState::outside) {
            CHECK(weights.states[i] == PointState::outside);
            continue;
        }
        CHECK(weights.states[i] != PointState::outside);
        CHECK(std::fabs(double(sum_of(weights.rows[i])) - 1) <= tolerance);
        CHECK(distance(combine(weights.rows[i], coordinates.handles()), points[i]) <= 4 * tolerance);
        const std::vector<T> head(weights.rows[i].begin(), weights.rows[i].begin() + 4),
            tail(weights.rows[i].begin() + 4, weights.rows[i].end());
        if (b == PointState::outside || (b == PointState::on_boundary && a == PointState::inside)) {
            CHECK(difference(head, first.rows[i]) <= tolerance);
            CHECK(absolute_sum(tail) == 0);
        } else if (a == PointState::outside || (a == PointState::on_boundary && b == PointState::inside)) {
            CHECK(difference(tail, second.rows[i]) <= tolerance);
            CHECK(absolute_sum(head) == 0);
        } else {
            CHECK(absolute_sum(head) > 0);
            CHECK(absolute_sum(tail) > 0);
        }
    }
}

TEST_CASE("a figure in two cages is exact at rest and under common affine moves",
          "[coordinates][blended][clone]") {
    std::vector<MeanValueCoordinates<double, 3>> parts;
    auto body = sphere(1), head = sphere(1);
    for (auto& v : head.vertices) v = Vec<double, 3>{0.5 * v[0], 0.5 * v[1], 0.5 * v[2] + 1.2};
    parts.emplace_back(body.mesh<double>());
    parts.emplace_back(head.mesh<double>());
    const BlendedCoordinates<MeanValueCoordinates<double, 3>> coordinates(std::move(parts));
    Points3<double> figure;
    Random random(8);
    while (figure.size() < 300) {
        const Vec<double, 3> p{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 2)};
        if (locate(coordinates.components()[0].cage(), p, 1e-12) == PointState::inside ||
            locate(coordinates.components()[1].cage(), p, 1e-12) == PointState::inside)
            figure.push_back(p);
    }
    const auto [binding, report] = cageform::bind(coordinates, figure);
    REQUIRE(report.status == Status::ok);
    CHECK(report.outside.empty());
    Points3<double> out(figure.size());
    REQUIRE(cageform::clone(binding, coordinates.handles(), out) == Status::ok);
    CHECK((out == figure));
    const auto map = random_affine<3>(random, 2);
    REQUIRE(cageform::clone(binding, map(coordinates.handles()), out) == Status::ok);
    for (std::size_t i = 0; i < figure.size(); ++i) CHECK(distance(out[i], map(figure[i])) <= 1e-12);
    // Moving the head's cage does not move points outside it.
    Points3<double> pose(coordinates.handles().begin(), coordinates.handles().end());
    for (std::size_t h = coordinates.first_handle(1); h < pose.size(); ++h) pose[h][2] += 1;
    REQUIRE(cageform::clone(binding, pose, out) == Status::ok);
    for (std::size_t i = 0; i < figure.size(); ++i) {
        if (locate(coordinates.components()[1].cage(), figure[i], 1e-12) == PointState::outside)
            CHECK((out[i] == figure[i]));
    }
}

TEST_CASE("blended coordinates refuse invalid cages and name the component",
          "[coordinates][blended][status]") {
    using Mean = MeanValueCoordinates<double, 2>;
    const BlendedCoordinates<Mean> nothing{std::vector<Mean>{}};
    const Points2<double> points{{0.5, 0.5}};
    CHECK(cageform::bind(nothing, points).report.status == Status::too_few_vertices);
    REQUIRE(nothing.cage_report().faults.size() == 1);
    CHECK(nothing.cage_report().faults[0].a == 0);
    const Polygon<double> good(rectangle<double>(0, 0, 1, 1)),
        bad(Points2<double>{{0, 0}, {1, 1}, {1, 0}, {0, 1}});
    const BlendedCoordinates<Mean> coordinates({Mean(good), Mean(bad)});
    CHECK(coordinates.refused_component() == 1);
    CHECK(cageform::bind(coordinates, points).report.status == Status::cage_self_crossing);
    const BlendedCoordinates<Mean> sound({Mean(good), Mean(Polygon<double>(rectangle<double>(2, 0, 3, 1)))});
    std::vector<double> row(8);
    const auto place = sound.nearest_boundary({1.8, 0.5}, row);
    CHECK(distance(place, Vec<double, 2>{2, 0.5}) == 0);
    CHECK(row == std::vector<double>{0, 0, 0, 0, 0.5, 0, 0, 0.5});
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const auto report = cageform::bind(sound, Points2<double>{{nan, 0}, {5, 5}, {2.5, 0.5}}).report;
    CHECK(report.not_finite == std::vector<std::size_t>{0});
    CHECK(report.outside == std::vector<std::size_t>{1});
    double last = 0;
    cageform::Running until_half;
    until_half.progress = [&](double done) {
        CHECK(done >= last);
        last = done;
        return done < 0.5;
    };
    using Harmonic = HarmonicCoordinates<double, 2>;
    CHECK(cageform::bind(pair_of_cages<Harmonic>(), points, {}, until_half).report.status ==
          Status::cancelled);
    std::vector<double> told;
    cageform::Running to_the_end;
    to_the_end.progress = [&](double done) {
        told.push_back(done);
        return true;
    };
    BlendedCoordinates<Harmonic> solved = pair_of_cages<Harmonic>();
    CHECK(solved.solve(to_the_end).status == Status::ok);
    REQUIRE(told.size() > 2);
    CHECK(std::is_sorted(told.begin(), told.end()));
    CHECK((told.front() < 0.5 && told.back() <= 1));
    CHECK(std::any_of(told.begin(), told.end(), [](double done) { return done > 0 && done < 0.5; }));
    CHECK(cageform::bind(solved, points).report.solver.solves == 8);
}

TEST_CASE("reports of several cages number corners by all handles", "[coordinates][blended]") {
    using Harmonic = cageform_tests::UniformHarmonic<double, 2>;
    const cageform::HarmonicOptions coarse{.resolution = 8}; // no corner has ten free cells
    const BlendedCoordinates<Harmonic> coordinates(
        {Harmonic(rectangle<double>(0, 0, 2, 1), coarse), Harmonic(rectangle<double>(1, -1, 3, 2), coarse)});
    const auto weights = evaluate_all(coordinates, Points2<double>{{1.5, 0.5}});
    REQUIRE(weights.status() == Status::ok);
    std::vector<std::size_t> told;
    for (const auto& corner : weights.evaluation.solver.multigrid.corners) told.push_back(corner.handles[0]);
    CHECK(told == std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7});
}

TEST_CASE("the share of a cage falls to zero towards its boundary, however near", "[coordinates][blended]") {
    auto outer = sphere(0), inner = sphere(0);
    for (auto& v : inner.vertices) v = 0.5 * v;
    using Mean = MeanValueCoordinates<double, 3>;
    const BlendedCoordinates<Mean> coordinates({Mean(outer.mesh<double>()), Mean(inner.mesh<double>())});
    double before = 1;
    for (const double h :
         {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14}) { // distances inwards from a face of the inner cage
        const double c = 0.5 / 3 - h;
        const auto weights = evaluate_all(coordinates, Points3<double>{{c, c, c}});
        double share = 0;
        for (std::size_t k = 6; k < 12; ++k) share += weights.rows[0][k];
        CAPTURE(h, share);
        CHECK(share < before);
        CHECK(share <= 1e4 * h * h);
        before = share;
    }
}

} // namespace blended_tests

// Boxes as cages, and harmonic coordinates in them: the laws to the solver's tolerance, and the oracle.
#include "../catch.hpp"
#include "../support/effort.hpp"
#include "../support/oracle.hpp"
#include "../support/weights.hpp"

#include <cageform/binding/bind.hpp>
#include <cageform/core/threads.hpp>
#include <cageform/papers/pyramid_solver.hpp>

namespace harmonic_box_tests {

using namespace cageform_tests;
using cageform::Box;
using cageform::CageFaultKind;
using cageform::epsilon;
using cageform::HarmonicOptions;

namespace {

template <class T>
using Harmonic = cageform::HarmonicCoordinates<T, 3, Box<T>>;
template <class T>
using Points3 = std::vector<Vec<T, 3>>;

template <class T>
Box<T> random_box(std::uint64_t seed) {
    Random random(seed);
    const double scale = std::pow(10.0, random.uniform(-3, 3));
    Vec<T, 3> lower, upper;
    typename Box<T>::Divisions divisions;
    for (std::size_t k = 0; k < 3; ++k) {
        const double low = random.uniform(-2, 2) * scale;
        lower[k] = T(low);
        upper[k] = T(low + random.uniform(0.4, 1) * scale);
        divisions[k] = 1 + random.below(4);
    }
    return {lower, upper, divisions};
}

/// Inside, and every tenth on a face.
template <class T>
Points3<T> points_in(const Box<T>& box, std::size_t count, std::uint64_t seed) {
    Random random(seed);
    Points3<T> points(count);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 3; ++k)
            points[i][k] = T(random.uniform(double(box.lower()[k]), double(box.upper()[k])));
        if (i % 10 == 0)
            points[i][i / 10 % 3] = (i / 30) % 2 == 0 ? box.lower()[i / 10 % 3] : box.upper()[i / 10 % 3];
    }
    return points;
}

} // namespace

TEST_CASE("a box has the vertices of its divided faces, and data that is right on them", "[cage][box]") {
    const int seed = GENERATE(seeds(30));
    const auto box = random_box<double>(std::uint64_t(seed));
    CAPTURE(seed, box.divisions());
    const auto [a, b, c] = box.divisions();
    CHECK(box.size() == (a + 1) * (b + 1) * (c + 1) - (a - 1) * (b - 1) * (c - 1));
    REQUIRE(check(box).status == Status::ok);
    const double size = distance(box.lower(), box.upper());
    for (const auto& p : points_in(box, 60, std::uint64_t(seed))) {
        Vec<double, 3> place;
        const auto value = nearest_boundary_value(box, p, place);
        CHECK(cageform::locate(box, place,
                               cageform::coincidence_tolerance(cageform::bounds_of(box.vertices()))) ==
              PointState::on_boundary);
        Vec<double, 3> sum{};
        double total = 0;
        for (std::size_t n = 0; n < 4; ++n) {
            CHECK(value.weight[n] >= 0);
            total += value.weight[n];
            sum = sum + value.weight[n] * box.vertices()[value.handle[n]];
        }
        CHECK(std::fabs(total - 1) <= 4 * epsilon<double>);
        CHECK(distance(sum, place) <= 1e-14 * (size + distance(place, Vec<double, 3>{})));
        // No face is nearer.
        double least = size;
        for (std::size_t k = 0; k < 3; ++k)
            least = std::min({least, p[k] - box.lower()[k], box.upper()[k] - p[k]});
        CHECK(std::fabs(distance(p, place) - least) <= 1e-13 * (size + distance(place, Vec<double, 3>{})));
    }
    const std::vector<Vec<double, 3>> beside{box.upper() + (box.upper() - box.lower()),
                                             {box.lower()[0] - 1e-3 * size, box.upper()[1], box.lower()[2]}};
    for (const auto& p : beside) {
        CHECK(cageform::locate(box, p, 0.0) == PointState::outside);
        Vec<double, 3> place;
        (void)nearest_boundary_value(box, p, place);
        for (std::size_t k = 0; k < 3; ++k)
            CHECK(place[k] == std::clamp(p[k], box.lower()[k], box.upper()[k]));
    }
}

TEST_CASE("boxes without volume or with corners that are no numbers are named", "[cage][box][status]") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::size_t many = 1'000'000, all = std::numeric_limits<std::size_t>::max();
    for (const Box<double>::Divisions& divisions :
         {Box<double>::Divisions{many, many, many}, {1, all, 1}, {all, all, all}, {4096, 1, 2048}}) {
        const Box<double> box({0, 0, 0}, {1, 1, 1}, divisions);
        CHECK(box.status() == Status::too_many_handles);
        CHECK(box.size() == 0);
        CHECK(check(box).status == Status::too_many_handles);
        CHECK(Harmonic<double>(box).solve().status == Status::too_many_handles);
    }
    for (const std::size_t axis : {0U, 1U, 2U}) {
        Box<double>::Divisions divisions{many, many, many};
        divisions[axis] = 0;
        const auto report = check(Box<double>({0, 0, 0}, {1, 1, 1}, divisions));
        CHECK(report.status == Status::cage_has_no_volume);
        CHECK(report.faults.front().a == axis);
    }
    const auto flat = check(Box<double>({0, 1, 0}, {1, 1, 1}));
    REQUIRE(flat.status == Status::cage_has_no_volume);
    CHECK(flat.faults.front().kind == CageFaultKind::no_volume);
    CHECK(flat.faults.front().a == 1);
    CHECK(check(Box<double>({0, 0, 2}, {1, 1, 1})).faults.front().a == 2); // upside down
    CHECK(check(Box<double>({0, nan, 0}, {1, 1, 1})).status == Status::vertex_not_finite);
    CHECK(check(Box<double>()).status == Status::cage_has_no_volume);
    CHECK(evaluate_all(Harmonic<double>(Box<double>({0, 1, 0}, {1, 1, 1})), Points3<double>{{0.5, 1, 0.5}})
              .status() == Status::cage_has_no_volume);
    const Box<double> box({0, 0, 0}, {1, 1, 1});
    HarmonicOptions averaging;
    averaging.solver = cageform::HarmonicSolver::averaging_pyramid;
    CHECK(evaluate_all(Harmonic<double>(box, averaging), Points3<double>{{0.5, 0.5, 0.5}}).status() ==
          Status::solver_not_supported);
    CHECK(Harmonic<double>(box, averaging).solve().status == Status::solver_not_supported);
    // Coordinates with both solvers take either.
    using Both =
        cageform::HarmonicCoordinates<double, 3, Box<double>, cageform::WithAveragingPyramid<Box<double>>>;
    averaging.resolution = 20;
    const auto by_pyramid = evaluate_all(Both(box, averaging), Points3<double>{{0.5, 0.5, 0.5}}).evaluation;
    CHECK(by_pyramid.status == Status::ok);
    CHECK(by_pyramid.solver.pyramid.sweeps > 8);
    const auto by_multigrid =
        evaluate_all(Both(box, {.resolution = 20}), Points3<double>{{0.5, 0.5, 0.5}}).evaluation;
    CHECK(by_multigrid.status == Status::ok);
    CHECK(by_multigrid.solver.multigrid.cycles > 0);
    CHECK(by_multigrid.solver.pyramid.sweeps == 0);
    CHECK(evaluate_all(Harmonic<double>(box, {.resolution = 2000}), Points3<double>{{0.5, 0.5, 0.5}})
              .status() == Status::resolution_not_supported);
    const Box<double> fine({0, 0, 0}, {1, 1, 1}, {40, 2, 2}); // more divisions than cells
    const auto coarse =
        evaluate_all(Harmonic<double>(fine, {.resolution = 16}), Points3<double>{{0.5, 0.5, 0.5}});
    CHECK(coarse.status() == Status::grid_too_coarse);
    CHECK(coarse.evaluation.solver.sufficient_resolution == 32);
}

TEST_CASE("weights in a box are those of the oracle", "[coordinates][harmonic][box][oracle]") {
    for (const char* name : {"cube_quads", "box_mixed_diagonals_quads"}) {
        const auto json = read_json(std::string("harmonic3d_") + name);
        const auto& vertices = json["cage"]["vertices"];
        const auto vertex = [&](std::size_t i) {
            return Vec<double, 3>{vertices[i][0], vertices[i][1], vertices[i][2]};
        };
        const Box<double> box(vertex(0), vertex(6));
        Points3<double> points;
        for (const auto& p : json["points"]) points.push_back({p[0], p[1], p[2]});
        for (const std::size_t resolution : {std::size_t{9}, std::size_t{24}, std::size_t{64}}) {
            if (resolution == 64 && (name[0] == 'c' || effort(false, true))) continue; // of one box
            CAPTURE(name, resolution);
            const auto weights = evaluate_all(Harmonic<double>(box, {.resolution = resolution}), points);
            REQUIRE(weights.status() == Status::ok);
            CHECK(weights.evaluation.solver.multigrid.convergence_factor <= 0.2);
            for (std::size_t i = 0; i < points.size(); ++i) {
                for (std::size_t k = 0; k < 8; ++k) {
                    const auto at = std::find(box.vertices().begin(), box.vertices().end(), vertex(k));
                    REQUIRE(at != box.vertices().end());
                    const auto handle = std::size_t(at - box.vertices().begin());
                    // Trilinear functions solve the difference equations: what is left is the solver's
                    // tolerance.
                    CHECK(std::fabs(weights.rows[i][handle] - json["coordinates"][i][k].get<double>()) <=
                          1e-6);
                }
            }
        }
    }
}

TEMPLATE_TEST_CASE("weights in a box sum to 1, reproduce the point and stay in [0, 1] at every resolution",
                   "[coordinates][harmonic][box][property]", CAGEFORM_SCALARS) {
    using T = TestType;
    const int seed = GENERATE(seeds(effort(6, 3)));
    const std::size_t resolution = GENERATE(std::size_t{12}, effort<std::size_t>(29, 9));
    CAPTURE(seed, resolution);
    const auto box = random_box<T>(std::uint64_t(seed));
    const auto points = points_in(box, 200, std::uint64_t(seed));
    const Harmonic<T> coordinates(box, {.resolution = resolution});
    const auto weights = evaluate_all(coordinates, points);
    REQUIRE(weights.status() == Status::ok);
    const double m = double(box.size());
    const double size = distance(box.lower(), box.upper()) + distance(box.lower(), Vec<T, 3>{});
    for (std::size_t i = 0; i < points.size(); ++i) {
        const bool on_face = weights.states[i] == PointState::on_boundary;
        CHECK(weights.states[i] != PointState::outside);
        const double tolerance = (on_face ? 0.0 : 1e-6) + 4 * double(epsilon<T>);
        CHECK(std::fabs(double(sum_of(weights.rows[i])) - 1) <= m * tolerance);
        CHECK(distance(combine(weights.rows[i], box.vertices()), points[i]) <= m * tolerance * size);
        for (const T w : weights.rows[i]) CHECK((w >= T(0) && w <= T(1)));
    }
    cageform::Running threaded;
    threaded.parallel = cageform::ThreadedFor{2};
    CHECK((evaluate_all(coordinates, points, threaded).rows == weights.rows));
}

TEST_CASE("a binding in a box follows the cage", "[coordinates][harmonic][box][binding]") {
    const Box<double> box({-1, -1, -1}, {1, 1, 1}, {2, 3, 1});
    const auto points = points_in(box, 400, 3);
    const auto [binding, report] = cageform::bind(Harmonic<double>(box, {.resolution = 24}), points);
    REQUIRE(report.status == Status::ok);
    CHECK(report.weight_change.value <= 1e-6 * double(box.size()));
    CHECK(binding.handle_count() == box.size());
}

} // namespace harmonic_box_tests

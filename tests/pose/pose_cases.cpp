// Degenerate poses by pins with bounds; named refusals; memory.
#include "../support/allocations.hpp"
#include "../support/pins.hpp"

#include <cageform/binding/any_coordinates.hpp>

#include <cstring>
#include <numeric>

namespace pose_cases_tests {

using namespace cageform_tests;
using cageform::AnyCoordinates;
using cageform::GreenCoordinates;
using cageform::HarmonicCoordinates;
using cageform::MeanValueCoordinates;
using cageform::PosePins;
using cageform::PoseTurn;

namespace {

constexpr PoseSampleOptions few{.samples = 1000};

using Coordinates = MeanValueCoordinates<double, 2>;

Coordinates cat() {
    return Coordinates(cat_cage());
}
/// Points of a figure that fill the cat.
Places<2> inside_cat(std::size_t count, std::uint64_t seed) {
    Random random(seed);
    const cageform::Polygon<double> cage(cat_cage());
    Places<2> points;
    for (std::size_t n = 0; n < count; ++n) points.push_back(random_inside(cage, random, 0.01));
    return points;
}
Places<2> moved(Places<2> places, std::size_t n, const Vec<double, 2>& by) {
    places[n] = places[n] + by;
    return places;
}

/// Mean value coordinates that cannot be differentiated.
struct WithoutGradients {
    using scalar = double;
    static constexpr std::size_t dimension = 2;
    static constexpr bool has_extension = true, closed_form = true;

    auto handles() const { return own.handles(); }
    const cageform::CageReport& cage_report() const { return own.cage_report(); }
    auto evaluate(cageform::BlockView<const double> points, cageform::BlockView<double> weights,
                  std::span<cageform::PointState> states, const cageform::Running& running) const {
        return own.evaluate(points, weights, states, running);
    }
    auto nearest_boundary(const Vec<double, 2>& p, std::span<double> row) const {
        return own.nearest_boundary(p, row);
    }

    Coordinates own;
};

} // namespace

TEST_CASE("without pins the last pose is kept", "[pose]") {
    Pinned figure(cat(), cat_pins(), few);
    figure.solve(cat_targets(), 3);
    const auto pose = figure.pose;
    REQUIRE(figure.solver.set_pins({}) == Status::ok);
    for (auto& h : figure.pose) h = {};
    const auto report = figure.solve({});
    CHECK(report.settled);
    CHECK(figure.distance_from_pose(pose) <= 1e-15);
    figure.solver.reset();
    figure.solve({});
    CHECK((figure.pose == figure.rest));
}

TEST_CASE("two pins drawn apart or pushed together stretch and fold nothing", "[pose]") {
    for (const double share : {1.5, 0.1}) {
        CAPTURE(share);
        Pinned figure(cat(), {{1.37, 0.5}, {5.65, 0.5}}, few);
        const auto report = figure.solve({{1.37, 0.5}, {1.37 + share * 4.28, 0.5}}, 100);
        CHECK(report.folded == 0);
        CHECK(report.largest_stretch <= 2.5);
        CHECK(report.miss <= 0.01 * figure.size());
    }
}

TEST_CASE("coincident pins move to the mean of their targets", "[pose]") {
    Pinned figure(cat(), {{1.37, 0.5}, {5.65, 0.5}, {3.75, 3.2}, {3.75, 3.2}}, few);
    auto targets = figure.pins;
    targets[2] = {3.25, 3.7};
    targets[3] = {4.25, 3.7};
    figure.solve(targets, 30);
    Places<2> out(4);
    REQUIRE(clone(figure.binding, figure.pose, out) == Status::ok);
    CHECK(std::fabs(out[2][0] - 3.75) <= 1e-3);
    CHECK(std::fabs(out[2][1] - 3.7) <= 1e-3);
}

TEST_CASE("nearly coincident pins with distant targets give a finite pose", "[pose]") {
    for (const bool hard : {false, true}) {
        for (const double apart : {1e-5, 1e-3, 1e-2}) {
            CAPTURE(hard, apart);
            const double d = apart * 9.8;
            Pinned figure(cat(), {{1.37, 0.5}, {5.65, 0.5}, {3.75, 3.2}, {3.75 + d, 3.2}}, few,
                          {.hard_pins = hard});
            auto targets = figure.pins;
            targets[2] = {3.25, 3.2};
            targets[3] = {4.25, 3.2};
            const auto report = figure.solve(targets, 50);
            CHECK(report.largest_stretch <= (hard ? 300 : 30));
            // a pull of 1 unit on a pin of weight 1e4; hard pins miss by less
            CHECK(report.miss <= (hard ? 0.5 : 0.51));
        }
    }
}

TEST_CASE("hard pins miss a thousand times less", "[pose]") {
    Pinned soft(cat(), cat_pins(), few);
    Pinned hard(cat(), cat_pins(), few, {.hard_pins = true});
    const double soft_miss = soft.solve(cat_targets(), 40).miss,
                 hard_miss = hard.solve(cat_targets(), 40).miss;
    CAPTURE(soft_miss, hard_miss);
    CHECK(hard_miss <= 2e-3 * soft_miss);
    CHECK(hard.distance_from_pose(soft.pose) <= 1e-2);
    // With a held handle.
    const std::array<std::uint32_t, 1> held{12};
    REQUIRE(hard.solver.set_held(held) == Status::ok);
    CHECK(hard.solve(cat_targets(), 40).miss <= 2e-3 * soft_miss);
}

TEST_CASE("with more pins than handles, a small pin weight prevents distortion", "[pose]") {
    const auto pins = inside_cat(38, 7);
    for (const double weight : {1e2, 1e6}) {
        CAPTURE(weight);
        Pinned figure(cat(), pins, few, {.pin_weight = weight});
        auto targets = pins;
        for (std::size_t n = 0; n < targets.size(); ++n)
            targets[n] =
                targets[n] + Vec<double, 2>{0.2 * std::sin(3 * pins[n][1]), 0.2 * std::cos(4 * pins[n][0])};
        const auto report = figure.solve(targets, 60);
        if (weight == 1e2) {
            CHECK(report.folded == 0);
            CHECK(report.largest_stretch <= 1.7);
        } else {
            CHECK(report.largest_stretch > 2); // justifies a small weight
        }
    }
}

TEST_CASE("held handles keep their positions, and the others follow", "[pose]") {
    Pinned figure(cat(), cat_pins(), few);
    const std::array<std::uint32_t, 3> held{9, 3, 17};
    figure.solve(cat_targets());
    REQUIRE(figure.solver.set_held(held) == Status::ok);
    for (const auto h : held) figure.pose[h] = figure.rest[h] + Vec<double, 2>{0.5, 0.25};
    const auto report = figure.solve(cat_targets(), 30);
    for (const auto h : held) {
        const auto off = figure.pose[h] - figure.rest[h] - Vec<double, 2>{0.5, 0.25};
        CHECK(std::sqrt(dot(off, off)) <= 1e-14);
    }
    CHECK(report.settled);
    CHECK(report.miss <= 1e-2 * figure.size());

    // If all others are held, the pin has no effect.
    std::vector<std::uint32_t> all(24);
    std::iota(all.begin(), all.end(), 0u);
    figure.solver.reset();
    figure.pose = figure.rest;
    REQUIRE(figure.solver.set_held(all) == Status::ok);
    figure.solve(moved(cat_pins(), 3, {-1, 1}), 30);
    CHECK(figure.distance_from_rest() <= 0.1);
    all.push_back(24);
    REQUIRE(figure.solver.set_held(all) == Status::ok);
    figure.pose = figure.rest;
    figure.solve(cat_targets());
    CHECK((figure.pose == figure.rest));
}

TEST_CASE("full turns return to rest", "[pose]") {
    for (const int steps : {4, 24, 72}) {
        CAPTURE(steps);
        Pinned figure(cat(), cat_pins(), few);
        for (int n = 1; n <= steps; ++n)
            figure.solve(Motion<2>{2 * std::numbers::pi * n / steps, {0, 0}}.of(figure.pins));
        CHECK(figure.distance_from_rest() <= 1e-11);
    }
    // A pin wound twice around the body unwinds.
    Pinned figure(cat(), cat_pins(), few);
    for (int n = 1; n <= 48; ++n) {
        const double angle = 4 * std::numbers::pi * n / 48;
        auto targets = figure.pins;
        targets[3] = Vec<double, 2>{3.75, 3.2} + Motion<2>{angle, {0, 0}}(targets[3] - targets[4], false);
        figure.solve(targets);
    }
    figure.solve(figure.pins, 100);
    CHECK(figure.distance_from_rest() <= 1e-9);
}

TEST_CASE("mirrored and collapsed poses return to rest", "[pose]") {
    const auto check = [](auto figure) {
        auto mirrored = figure.rest, collapsed = figure.rest;
        for (std::size_t i = 0; i < figure.rest.size(); ++i) {
            mirrored[i][0] = -mirrored[i][0];
            collapsed[i] = figure.rest[0];
        }
        for (const auto& start : {mirrored, collapsed}) {
            REQUIRE(figure.solver.set_pose(start) == Status::ok);
            const auto report = figure.solve(figure.pins, 200);
            CHECK(report.folded == 0);
            CHECK(figure.distance_from_rest() <= 1e-6);
        }
    };
    check(Pinned(cat(), cat_pins(), few));
    check(Pinned(MeanValueCoordinates(bar().mesh<double>()), bar_pins(), few));
}

TEST_CASE("pins outside the cage pull by the extension", "[pose]") {
    Pinned figure(cat(), {{1.37, 0.5}, {1.25, 5.5}, {8.4, 5.85}, {3.75, 1.4}}, few);
    const auto report = figure.solve(moved(figure.pins, 3, {0, -0.3}), 50);
    CHECK(report.folded == 0);
    CHECK(report.miss <= 0.01 * figure.size());
}

TEST_CASE("a thin ribbon bends", "[pose]") {
    Places<2> ribbon;
    for (int n = 0; n <= 10; ++n) ribbon.push_back({100.0 * n, 0});
    for (int n = 10; n >= 0; --n) ribbon.push_back({100.0 * n, 10});
    Pinned figure(Coordinates(ribbon), {{5, 5}, {500, 5}, {995, 5}}, {.samples = 2000});
    auto targets = figure.pins;
    targets[1][1] = 200;
    const auto report = figure.solve(targets, 100);
    CHECK(report.folded == 0);
    CHECK(report.largest_stretch <= 1.6);
    CHECK(report.miss <= 1e-3 * figure.size());
}

TEST_CASE("weak handles are reported, and spokes keep them near the figure", "[pose]") {
    Places<2> left;
    for (const auto& p : inside_cat(500, 3)) {
        if (p[0] < 4) left.push_back(p);
    }
    const Places<2> pins{{1.37, 0.5}, {1.25, 5.5}, {3.0, 3.2}};
    const GreenCoordinates green(cat_cage());
    auto [samples, report] = pose_samples(green, left);
    REQUIRE(report.status == Status::ok);
    CHECK(report.samples == left.size());
    PoseSolver<double, 2> solver(std::move(samples));
    const auto binding = bound(green, pins);
    REQUIRE(solver.set_pins({.binding = binding.view()}) == Status::ok);
    std::vector<Vec<double, 2>> pose(green.handles().size());
    const auto targets = moved(Motion<2>{1, {0, 0}}.of(pins), 0, {0.3, 0});
    for (int n = 0; n < 50; ++n) REQUIRE(solver.solve(targets, pose).status == Status::ok);
    for (const auto& h : pose) CHECK(std::sqrt(dot(h, h)) <= 2 * solver.samples().size);
}

TEST_CASE("a pin with an angle turns the figure around it", "[pose]") {
    Pinned figure(cat(), {{3.75, 3.2}}, few);
    const auto axes = bind_jacobians(figure.coordinates, figure.pins);
    REQUIRE(axes);
    REQUIRE(figure.solver.set_pins({.binding = figure.binding.view(),
                                    .axes = {axes.value[0].view(), axes.value[1].view()}}) == Status::ok);
    const std::vector<PoseTurn<2>> turns{{0.7}};
    REQUIRE(figure.solver.solve(figure.pins, figure.pose, turns).status == Status::ok);
    const auto turned = [&](const Vec<double, 2>& h, bool) {
        return figure.pins[0] + Motion<2>{0.7, {0, 0}}(h - figure.pins[0], false);
    };
    CHECK(figure.distance_from(turned) <= 1e-10);
    REQUIRE(figure.solver.solve(figure.pins, figure.pose).status == Status::pins_do_not_match);

    Pinned in_space(MeanValueCoordinates(bar().mesh<double>()), {{0.1, 0, 0.1}, {0, 0, 1}}, few);
    const auto axes3 = bind_jacobians(in_space.coordinates, in_space.pins);
    REQUIRE(axes3);
    const std::vector<std::uint8_t> turned_pins{1, 0};
    REQUIRE(in_space.solver.set_pins(
                {.binding = in_space.binding.view(),
                 .axes = {axes3.value[0].view(), axes3.value[1].view(), axes3.value[2].view()},
                 .turned = turned_pins}) == Status::ok);
    const double s = 0.9 / std::sqrt(14.0);
    const std::vector<PoseTurn<3>> in_space_turns{{s, 2 * s, 3 * s}, {0, 0, 0}};
    const Motion<3> motion{0.9, {1, 2, -1}};
    REQUIRE(in_space.solver.solve(motion.of(in_space.pins), in_space.pose, in_space_turns).status ==
            Status::ok);
    CHECK(in_space.distance_from(motion) <= 1e-10);
}

TEST_CASE("refusals have their own status and change nothing", "[pose]") {
    Pinned figure(cat(), cat_pins(), few);
    figure.solve(cat_targets());
    const auto before = figure.pose;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const auto refuses = [&](const Places<2>& targets, Status status, std::size_t culprit) {
        const auto report = figure.solver.solve(targets, figure.pose);
        CHECK(report.status == status);
        CHECK(report.culprit == culprit);
        CHECK((figure.pose == before));
    };
    refuses({{1, 2}}, Status::pins_do_not_match, PoseSolverReport::none);
    refuses(moved(cat_targets(), 4, {nan, 0}), Status::pose_not_finite, 4);
    refuses(moved(cat_targets(), 2, {1e308, 1e308}), Status::pose_not_finite, PoseSolverReport::none);
    std::vector<Vec<double, 2>> wrong(7);
    CHECK(figure.solver.solve(cat_targets(), wrong).status == Status::pose_size_differs);
    CHECK(figure.solver.set_pose(wrong) == Status::pose_size_differs);
    wrong.assign(25, {nan, 0});
    CHECK(figure.solver.set_pose(wrong) == Status::pose_not_finite);

    auto& solver = figure.solver;
    const auto view = figure.binding.view();
    const std::vector<double> two{1, 1}, bad{1, 1, 1, -1, 1, 1};
    CHECK(solver.set_pins({.binding = view, .weights = two}) == Status::pins_do_not_match);
    CHECK(solver.set_pins({.binding = view, .weights = bad}) == Status::weights_not_positive);
    CHECK(solver.culprit() == 3);
    const std::vector<std::uint32_t> points{1, 2, 99};
    CHECK(solver.set_pins({.binding = view, .points = points}) == Status::index_out_of_range);
    CHECK(solver.culprit() == 2);
    const std::vector<std::uint8_t> turned(6, 1);
    CHECK(solver.set_pins({.binding = view, .turned = turned}) == Status::pins_do_not_match);
    const auto one = bound(figure.coordinates, Places<2>{{1.3, 0.5}});
    CHECK(solver.set_pins({.binding = view, .axes = {one.view(), one.view()}}) == Status::bindings_differ);
    const auto other = bound(Coordinates(Places<2>{{0, 0}, {1, 0}, {0, 1}}), Places<2>{{0.2, 0.2}});
    CHECK(solver.set_pins({.binding = other.view()}) == Status::bindings_differ);
    const auto out = cageform::bind(figure.coordinates, Places<2>{{1.37, 0.5}, {5, -3}},
                                    {.outside = cageform::OutsidePoints::keep_in_place});
    REQUIRE(out);
    CHECK(solver.set_pins({.binding = out.value.view()}) == Status::pin_without_weights);
    CHECK(solver.culprit() == 1);
    const std::vector<std::uint32_t> held{3, 25};
    CHECK(solver.set_held(held) == Status::index_out_of_range);
    CHECK(solver.culprit() == 25);
    const auto report = solver.solve(cat_targets(), figure.pose); // the pins are unchanged
    CHECK(report.status == Status::ok);
    CHECK(report.miss <= 0.1);

    PoseSolver<double, 2> empty(PoseSamples<double, 2>{});
    CHECK(empty.status() == Status::samples_missing);
    CHECK(empty.set_pins({}) == Status::samples_missing);
    CHECK(empty.solve(Places<2>{}, figure.pose).status == Status::samples_missing);
    CHECK(PoseSolver<double, 2>().status() == Status::samples_missing);
    PoseSamples<double, 2> many;
    many.rest_handles.resize(5000);
    CHECK(PoseSolver<double, 2>(std::move(many)).status() == Status::too_many_handles);

    CHECK(pose_samples(figure.coordinates, Places<2>{}).status() == Status::samples_missing);
    CHECK(pose_samples(figure.coordinates, {.smoothing = nan}).status() == Status::value_not_finite);
    CHECK(pose_samples(figure.coordinates, {.spokes = nan}).status() == Status::value_not_finite);
    CHECK(pose_samples(Coordinates(Places<2>{{0, 0}, {1, 1}, {1, 0}, {0, 1}})).status() ==
          Status::cage_self_crossing);
    const auto some = pose_samples(figure.coordinates, Places<2>{{1.37, 0.5}, {nan, 0}, {3.75, 3.2}});
    CHECK(some.status() == Status::ok);
    CHECK(some.report.left_out == 1);
}

TEST_CASE("AnyCoordinates give the samples of the type they hold", "[pose]") {
    const auto compare = [](const auto& coordinates) {
        using C = std::decay_t<decltype(coordinates)>;
        const AnyCoordinates<typename C::scalar, C::dimension> any = coordinates;
        const PoseSampleOptions options{.samples = 300, .rotations = 20, .smoothing = 0.01};
        const auto expected = sampled(coordinates, options), samples = sampled(any, options);
        CHECK(samples.stiffness == expected.stiffness);
        CHECK(samples.points == expected.points);
        CHECK(samples.clusters == expected.clusters);
        CHECK(samples.handle_kinds == expected.handle_kinds);
        bool same = samples.gradients.size() == expected.gradients.size();
        for (std::size_t n = 0; same && n < samples.gradients.size(); ++n)
            same =
                std::memcmp(&samples.gradients[n], &expected.gradients[n], sizeof samples.gradients[n]) == 0;
        CHECK(same);
    };
    compare(Coordinates(cat_cage()));
    compare(HarmonicCoordinates<double, 2>(cat_cage()));
    compare(GreenCoordinates<double, 2>(cat_cage()));
    compare(MeanValueCoordinates(bar().mesh<float>()));

    const AnyCoordinates<double, 2> plain = WithoutGradients{cat()};
    CHECK(pose_samples(plain).status() == Status::gradients_not_supported);
    CHECK(pose_samples(AnyCoordinates<double, 2>{}).status() == Status::coordinates_empty);
}

TEST_CASE("frames allocate nothing, and failed allocations are reported", "[pose]") {
    Pinned figure(MeanValueCoordinates(bar().mesh<double>()), bar_pins(), few, {.hard_pins = true});
    auto targets = bar_targets();
    Random random(5);
    const std::size_t before = allocations;
    bool is_ok = true;
    for (std::size_t n = 0; n < effort<std::size_t>(10000, 100); ++n) {
        targets[n % 7][n % 3] += random.uniform(-0.01, 0.01);
        is_ok = is_ok && figure.solver.solve(targets, figure.pose).status == Status::ok;
    }
    CHECK(allocations == before);
    CHECK(is_ok);
    // Every allocation of set_pins fails once; the previous pins are kept.
    const auto pose = figure.pose;
    const std::vector<std::uint32_t> points{0, 1, 2};
    std::size_t failures = 0;
    for (;; ++failures) {
        failing_allocation = allocations + 1 + failures;
        const Status status = figure.solver.set_pins({.binding = figure.binding.view(), .points = points});
        failing_allocation = 0;
        if (status == Status::ok) break;
        REQUIRE(status == Status::out_of_memory);
        REQUIRE(figure.solver.solve(targets, figure.pose).status == Status::ok);
    }
    CHECK(failures > 10);
    CHECK(figure.solver.solve(targets, figure.pose).status == Status::pins_do_not_match);
}

} // namespace pose_cases_tests

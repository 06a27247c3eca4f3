// Laws of poses by pins: rest, rigid motions, a decreasing energy with a stationary limit, invariance.
#include "../support/pins.hpp"

#include <cageform/coordinates/lattice.hpp>
#include <cageform/coordinates/sibson.hpp>

#include <cageform/binding/pack.hpp>
#include <cageform/parallel/threads.hpp>

namespace pose_solver_tests {

using namespace cageform_tests;
using cageform::GreenCoordinates;
using cageform::HarmonicCoordinates;
using cageform::MeanValueCoordinates;

namespace {

constexpr PoseSampleOptions few{.samples = effort<std::size_t>(1000, 300)};

/// Calls f with pinned figures in 2D and 3D, with point handles and vector handles.
template <class F>
void for_each_figure(const F& f, const PoseSampleOptions& how = few, const PoseOptions& options = {}) {
    const auto plane = [&](const char* name, const auto& coordinates) {
        CAPTURE(name);
        f(Pinned(coordinates, cat_pins(), how, options), cat_targets());
    };
    plane("mean value", MeanValueCoordinates(cat_cage()));
    HarmonicCoordinates harmonic(cat_cage());
    REQUIRE(harmonic.solve().status == Status::ok); // all evaluations use the same functions
    plane("harmonic", harmonic);
    plane("Green", GreenCoordinates(cat_cage()));
    const auto space = [&](const char* name, const auto& coordinates) {
        CAPTURE(name);
        f(Pinned(coordinates, bar_pins(), how, options), bar_targets());
    };
    const auto mesh = bar().template mesh<double>();
    space("mean value in space", MeanValueCoordinates(mesh));
    space("Green in space", GreenCoordinates(mesh));
}

} // namespace

TEST_CASE("pins at rest give bitwise the pose at rest", "[pose]") {
    for_each_figure([](auto figure, const auto& targets) {
        (void)targets;
        for (auto& h : figure.pose) h = {};
        const auto report = figure.solve(figure.pins, 3);
        CHECK((figure.pose == figure.rest));
        CHECK(report.rigid_energy == 0);
        CHECK(report.pin_energy == 0);
        CHECK(report.miss == 0);
        CHECK(report.settled);
        CHECK(report.folded == 0);
        CHECK(report.weak_handles == 0);
        CHECK(report.least_stretch > 1 - 1e-14);
        CHECK(report.largest_stretch < 1 + 1e-14);
    });
}

TEST_CASE("pins that move rigidly move the cage rigidly, in one frame and by any angle", "[pose]") {
    constexpr std::array angles{3.141592653589793, 0.01, 0.5, 1.5, 2.007, -2.5};
    const double angle = angles[std::size_t(GENERATE(seeds(effort(6, 2))))];
    CAPTURE(angle);
    for_each_figure([&](auto figure, const auto& targets) {
        constexpr std::size_t D = std::remove_cvref_t<decltype(figure)>::D;
        Motion<D> motion{angle, {}};
        for (std::size_t k = 0; k < D; ++k) motion.shift[k] = 3.0 - double(k);
        const auto report = figure.solve(motion.of(figure.pins));
        CHECK(figure.distance_from(motion) <= 1e-10);
        CHECK(report.rigid_energy <= 1e-12);
        // From a bent pose too: the motion preserves its shape.
        auto moved = figure;
        for (auto* one : {&figure, &moved}) {
            one->solver.reset();
            one->solve(targets, 2);
        }
        figure.set_pins(); // forces a new rigid motion
        figure.solve(targets);
        moved.solve(motion.of(targets));
        for (std::size_t i = 0; i < figure.pose.size(); ++i)
            figure.pose[i] = motion(figure.pose[i], handle_view(figure.coordinates).is_point(i));
        CHECK(moved.distance_from_pose(figure.pose) <= 1e-10);
    });
}

TEST_CASE("one pin translates the cage", "[pose]") {
    Pinned figure{MeanValueCoordinates(cat_cage()), {{3.75, 3.2}}, few};
    figure.solve({{5.0, -2.0}});
    CHECK(figure.distance_from(Motion<2>{0, {1.25, -5.2}}) <= 1e-12);
    Pinned in_space{MeanValueCoordinates(bar().mesh<double>()), {{0.1, 0, 0.1}}, few};
    in_space.solve({{5.1, -2, 0.1}});
    CHECK(in_space.distance_from(Motion<3>{0, {5, -2, 0}}) <= 1e-12);
}

TEST_CASE("two pins in space turn the cage by the smallest rotation", "[pose]") {
    Pinned figure{MeanValueCoordinates(bar().mesh<double>()), {{0, 0, -1}, {0, 0, 1}}, few};
    figure.solve({{-1, 0, 0}, {1, 0, 0}}); // a quarter turn about y
    const auto turned = [](const Vec<double, 3>& h, bool) { return Vec<double, 3>{h[2], h[1], -h[0]}; };
    CHECK(figure.distance_from(turned) <= 1e-12);
    figure.solve({{1, 0, 0}, {-1, 0, 0}}); // a half turn about any orthogonal axis
    const auto report = figure.solve({{0, 0, 1}, {0, 0, -1}});
    CHECK(report.rigid_energy <= 1e-12);
    CHECK(report.miss <= 1e-12);
}

TEST_CASE("the energy is that of the samples, and never rises", "[pose]") {
    const bool is_hard = GENERATE(false, true);
    CAPTURE(is_hard);
    const PoseSampleOptions how{.samples = effort<std::size_t>(1000, 300)};
    for_each_figure(
        [&](auto figure, const auto& targets) {
            const SampledEnergy energy(figure, targets);
            double last = std::numeric_limits<double>::infinity();
            for (std::size_t n = 0; n < effort<std::size_t>(60, 20); ++n) {
                const auto report = figure.solve(targets);
                const double now = energy(energy.handles_of(figure.pose));
                CAPTURE(n, last, now);
                CHECK(std::fabs(report.rigid_energy + report.pin_energy - now) <= 1e-12 * (1 + now));
                if (!is_hard || n > 1) CHECK(now <= last + 1e-13);
                last = now;
            }
        },
        how, {.hard_pins = is_hard, .iterations = 1});
}

TEST_CASE("a settled pose is stationary", "[pose]") {
    const PoseSampleOptions how{.samples = effort<std::size_t>(1000, 300)};
    for_each_figure(
        [](auto figure, const auto& targets) {
            // The gradient of the energy at any pose agrees with differences.
            const SampledEnergy energy(figure, targets);
            figure.solve(targets);
            auto handles = energy.handles_of(figure.pose);
            const auto slopes = energy.gradient(handles);
            const double step = 1e-5 * figure.size();
            for (Eigen::Index i = 0; i < handles.cols(); i += effort(5, 25)) {
                auto before = handles, after = handles;
                before(0, i) -= step;
                after(0, i) += step;
                const double slope = (energy(after) - energy(before)) / 2e-5;
                CHECK(std::fabs(slope - slopes(0, i)) <= 1e-6);
            }
            figure.solve(targets, 150);
            const double left = energy.gradient(energy.handles_of(figure.pose)).norm();
            CAPTURE(left);
            CHECK(left <= 1e-8); // pins of weight 1e4 amplify rounding of the pose
            CHECK(figure.solve(targets).settled);
        },
        how, {.iterations = 16});
}

TEST_CASE("the order of pins, and splitting their weights, have no effect", "[pose]") {
    for_each_figure([](auto figure, const auto& targets) {
        const std::size_t count = targets.size();
        figure.solve(targets, 3);
        const auto pose = figure.pose;
        // In reverse order, as indices of the same binding.
        std::vector<std::uint32_t> points;
        auto reversed = targets;
        std::reverse(reversed.begin(), reversed.end());
        for (std::size_t n = count; n-- > 0;) points.push_back(std::uint32_t(n));
        REQUIRE(figure.solver.set_pins({.binding = figure.binding.view(), .points = points}) == Status::ok);
        figure.solver.reset();
        figure.solve(reversed, 3);
        CHECK(figure.distance_from_pose(pose) <= 1e-9);
        // The last pin as three pins at the same point.
        std::vector<double> weights(count, 1.0);
        auto divided = targets;
        points.clear();
        for (std::size_t n = 0; n < count; ++n) points.push_back(std::uint32_t(n));
        weights.back() = 0.5;
        for (const double weight : {0.2, 0.3}) {
            weights.push_back(weight);
            points.push_back(std::uint32_t(count - 1));
            divided.push_back(targets.back());
        }
        REQUIRE(figure.solver.set_pins(
                    {.binding = figure.binding.view(), .points = points, .weights = weights}) == Status::ok);
        figure.solver.reset();
        figure.solve(divided, 3);
        CHECK(figure.distance_from_pose(pose) <= 1e-9);
    });
}

TEST_CASE("position and size of a figure have no effect", "[pose]") {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        Random random(seed);
        const double scale = std::pow(10.0, random.uniform(-3, 3));
        const Vec<double, 2> shift{scale * random.uniform(-50, 50), scale * random.uniform(-50, 50)};
        CAPTURE(seed, scale);
        const auto moved = [&](Places<2> places) {
            for (auto& p : places) p = scale * p + shift;
            return places;
        };
        Pinned figure{MeanValueCoordinates(cat_cage()), cat_pins(), few};
        Pinned other{MeanValueCoordinates(moved(cat_cage())), moved(cat_pins()), few};
        CHECK((figure.solver.samples().clusters == other.solver.samples().clusters));
        figure.solve(cat_targets(), 2);
        other.solve(moved(cat_targets()), 2);
        figure.pose = moved(figure.pose);
        CHECK(other.distance_from_pose(figure.pose) <= 1e-9);
    }
}

TEST_CASE("samples do not depend on threads", "[pose]") {
    const auto mesh = bar().mesh<double>();
    const MeanValueCoordinates coordinates(mesh);
    const auto alone = pose_samples(coordinates, {.smoothing = 0.02});
    cageform::Running running;
    running.parallel = cageform::ThreadedFor{3};
    const auto together = pose_samples(coordinates, {.smoothing = 0.02}, running);
    REQUIRE(alone);
    REQUIRE(together);
    CHECK((alone.value.points == together.value.points));
    CHECK((alone.value.clusters == together.value.clusters));
    CHECK((alone.value.stiffness == together.value.stiffness));
    REQUIRE(alone.value.gradients.size() == together.value.gradients.size());
    CHECK(std::memcmp(alone.value.gradients.data(), together.value.gradients.data(),
                      alone.value.gradients.size() * sizeof(alone.value.gradients[0])) == 0);
}

TEST_CASE("one rotation per sample gives the original method", "[pose]") {
    const PoseSampleOptions how{.samples = 60, .rotations = 100000};
    for_each_figure(
        [](auto figure, const auto& targets) {
            const auto& samples = figure.solver.samples();
            CHECK(samples.cluster_count == samples.points.size());
            for (std::size_t s = 0; s < samples.clusters.size(); ++s) REQUIRE(samples.clusters[s] == s);
            const SampledEnergy energy(figure, targets);
            const auto report = figure.solve(targets, 20);
            const double now = energy(energy.handles_of(figure.pose));
            CHECK(std::fabs(report.rigid_energy + report.pin_energy - now) <= 1e-12 * (1 + now));
        },
        how);
}

TEST_CASE("float and double agree", "[pose]") {
    Pinned figure{MeanValueCoordinates(cat_cage()), cat_pins(), few};
    std::vector<Vec<float, 2>> cage;
    for (const auto& p : cat_cage()) cage.push_back(cageform::vec_cast<float>(p));
    Pinned in_float{MeanValueCoordinates(cage), cat_pins(), few};
    figure.solve(cat_targets(), 5);
    const auto report = in_float.solve(cat_targets(), 5);
    CHECK(report.miss <= 1e-2);
    CHECK(in_float.distance_from([&](const auto& h, bool) {
        std::size_t i = 0;
        while (cageform::vec_cast<double>(cage[i]) != h) ++i;
        return figure.pose[i];
    }) <= 1e-4);
    in_float.solver.reset();
    std::vector<Vec<float, 2>> rest_pins; // as bound
    for (std::size_t n = 0; n < cat_pins().size(); ++n) rest_pins.push_back(in_float.binding.rest_point(n));
    const auto still = in_float.solver.solve(rest_pins, in_float.pose);
    CHECK(still.status == Status::ok);
    CHECK((in_float.pose == in_float.rest));
}

TEST_CASE("packed pins act like dense pins", "[pose]") {
    Pinned figure{MeanValueCoordinates(bar().mesh<double>()), bar_pins(), few};
    figure.solve(bar_targets(), 3);
    const auto pose = figure.pose;
    for (const auto format : {cageform::WeightFormat::scalar, cageform::WeightFormat::half,
                              cageform::WeightFormat::int16, cageform::WeightFormat::int8}) {
        CAPTURE(int(format));
        // Among other points, so that the order of points differs.
        auto points = bar_pins();
        for (double z = -1.4; z < 1.5; z += 0.1) points.push_back({0.1 * z, 0.2, z});
        std::rotate(points.begin(), points.begin() + 7, points.end());
        const auto binding = bound(figure.coordinates, points);
        const auto [packed, report] = cageform::pack(binding, {.format = format});
        REQUIRE(report.status == Status::ok);
        std::vector<std::uint32_t> pins;
        for (std::size_t n = points.size() - 7; n < points.size(); ++n) pins.push_back(std::uint32_t(n));
        REQUIRE(figure.solver.set_pins({.binding = packed.view(), .points = pins}) == Status::ok);
        figure.solver.reset();
        figure.solve(bar_targets(), 3);
        const double loss = format == cageform::WeightFormat::scalar ? 1e-10 : 2e-2;
        CHECK(figure.distance_from_pose(pose) <= loss);
        figure.solver.reset();
        figure.solve(bar_pins());
        CHECK((figure.pose == figure.rest));
    }
}

} // namespace pose_solver_tests

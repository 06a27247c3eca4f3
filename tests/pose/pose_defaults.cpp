// The defaults of PoseSampleOptions and PoseOptions on figures that were not used to choose them: a biped, a
// man and icons in generated cages, BUMPY112, a production cage with thin fingers; random moderate poses.
#include "../bench/workloads.hpp"
#include "../support/figures.hpp"
#include "../support/fingers.hpp"
#include "../support/held_out.hpp"

#include <cageform/enclose/make_cage.hpp>

namespace pose_defaults_tests {

using namespace cageform_tests;
using cageform::DrawnSegment;
using cageform::GreenCoordinates;
using cageform::HarmonicCoordinates;
using cageform::MeanValueCoordinates;

namespace {

/// Limits for the poses of a figure. Distances are relative to its size.
struct Bounds {
    std::size_t seeds;
    std::size_t frames;     ///< number of frames until a pose has settled
    double left;            ///< distance of the settled pose from its limit
    double median, largest; ///< distances from the limit for four times as many samples and rotations
};

/// Poses a figure with the defaults, and with four times as many samples and rotations if the bounds require
/// it.
template <class C>
class HeldOut {
    using T = typename C::scalar;
    static constexpr std::size_t D = C::dimension;
    using Pose = std::vector<Vec<T, D>>;

public:
    HeldOut(const C& coordinates, const Places<D>& figure, const Bounds& bounds)
        : coordinates_(coordinates)
        , figure_(bound(coordinates, figure))
        , samples_(sampled(coordinates))
        , solver_(samples_) {
        if (bounds.largest == 0) return;
        const std::size_t wanted = std::max<std::size_t>(4000, 16 * samples_.handle_count());
        reference_ = PoseSolver<T, D>(
            sampled(coordinates, {.samples = 4 * wanted, .rotations = 4 * samples_.cluster_count}));
        REQUIRE(reference_.status() == Status::ok);
    }

    void check(const Bounds& bounds) {
        std::vector<double> distances;
        for (std::uint64_t seed = 1; seed <= bounds.seeds; ++seed) {
            CAPTURE(seed);
            Random random(seed);
            const auto pins = random_pins(samples_, random, 0.15);
            const auto binding = bound(coordinates_, pins.pins);
            solver_.reset();
            REQUIRE(solver_.set_pins({.binding = binding.view()}) == Status::ok);
            Pose pose(samples_.handle_count());
            PoseSolverReport report;
            double last = std::numeric_limits<double>::infinity(), rise = 0;
            std::size_t frames = 0;
            const auto frame = [&] {
                report = solver_.solve(pins.targets, pose);
                REQUIRE(report.status == Status::ok); // includes that all numbers are finite
                const double energy = report.rigid_energy + report.pin_energy;
                rise = std::fmax(rise, energy - last);
                last = energy;
            };
            do {
                frame();
                ++frames;
            } while (!report.settled && frames < bounds.frames);
            CHECK(report.settled);
            CHECK(report.miss <= 5e-4 * samples_.size);
            const Pose settled = pose;
            for (std::size_t n = 0; n < 300 && report.step > 1e-7 * samples_.size; ++n) frame();
            const double left = apart(settled, pose);
            CAPTURE(frames, rise, left, last);
            CHECK(left <= bounds.left);
            CHECK(rise <= 1e-12);
            if (bounds.largest > 0) {
                distances.push_back(apart(pose, end_of_reference(binding, pins.targets)));
                CAPTURE(distances.back());
                CHECK(distances.back() <= bounds.largest);
            }
        }
        if (distances.size() < 5) return; // too few for a median
        std::sort(distances.begin(), distances.end());
        CAPTURE(distances);
        CHECK(distances[distances.size() / 2] <= bounds.median);
    }

private:
    Pose end_of_reference(const cageform::Binding<T, D>& binding, const Places<D>& targets) {
        reference_.reset();
        REQUIRE(reference_.set_pins({.binding = binding.view()}) == Status::ok);
        Pose pose(samples_.handle_count());
        PoseSolverReport report;
        for (std::size_t n = 0; n < 300 && !(report.step <= 1e-6 * samples_.size && n > 0); ++n)
            report = reference_.solve(targets, pose);
        return pose;
    }
    double apart(const Pose& a, const Pose& b) const {
        Pose of_a(figure_.point_count()), of_b(of_a);
        REQUIRE(clone(figure_, a, of_a) == Status::ok);
        REQUIRE(clone(figure_, b, of_b) == Status::ok);
        double largest = 0;
        for (std::size_t n = 0; n < of_a.size(); ++n)
            largest = std::fmax(largest, double(dot(of_a[n] - of_b[n], of_a[n] - of_b[n])));
        return std::sqrt(largest) / samples_.size;
    }

    const C& coordinates_;
    cageform::Binding<T, D> figure_;
    PoseSamples<T, D> samples_;
    PoseSolver<T, D> solver_, reference_;
};

template <class C>
void check_defaults(const char* name, const C& coordinates, const Places<C::dimension>& figure,
                    const Bounds& bounds) {
    CAPTURE(name);
    HeldOut<C>(coordinates, figure, bounds).check(bounds);
}

///   left  see Bounds
void check_in_plane(const char* name, const cageform::Polygon<double>& cage, double left = 5e-4) {
    CAPTURE(name);
    Random random(9);
    Places<2> figure;
    while (figure.size() < 300) figure.push_back(random_inside(cage, random, 0.005));
    const Bounds bounds{effort<std::size_t>(6, 1), 40, left, 0.01, 0.02};
    HarmonicCoordinates harmonic(cage);
    REQUIRE(harmonic.solve().status == Status::ok); // all evaluations use the same functions
    check_defaults("harmonic", harmonic, figure, bounds);
    check_defaults("mean value", MeanValueCoordinates(cage), figure, bounds);
    // Spokes of vectors are ten times stronger, and their choice of a rotation changes the limit by
    // hundredths.
    check_defaults("Green", GreenCoordinates(cage), figure, {bounds.seeds, 40, left, 0.02, 0.04});
}

/// Makes a polyline of strokes, closed or open.
void draw(std::vector<DrawnSegment<double>>& drawing, const Places<2>& line, double radius, bool closed) {
    for (std::size_t n = 0; n + (closed ? 0 : 1) < line.size(); ++n)
        drawing.push_back({line[n], line[(n + 1) % line.size()], radius});
}
cageform::Polygon<double> made_cage(const std::vector<DrawnSegment<double>>& drawing, std::size_t vertices) {
    auto made = make_cage(drawing, {.vertices = vertices});
    REQUIRE(made);
    return std::move(made.value);
}

} // namespace

TEST_CASE("the defaults of pins suit other figures in the plane", "[pose][defaults]") {
    std::vector<DrawnSegment<double>> man, fork, spiral;
    draw(fork, {{0, 0}, {0, 4}, {-1, 5}, {-1, 7}}, 0.2, false);
    draw(fork, {{0, 4}, {1, 5}, {1, 7}}, 0.2, false);
    check_in_plane("fork", made_cage(fork, 24));
#if !defined(CAGEFORM_SANITIZED) // takes a minute there, with the same code
    check_in_plane("biped", cageform::Polygon<double>(read_oracle("meanvalue2d_biped").vertices));
    draw(man, {{280, 218}, {304, 200}, {316, 164}, {292, 130}, {254, 130}, {232, 164}, {248, 206}, {214, 226},
               {142, 262}, {104, 334}, {132, 348}, {172, 292}, {212, 282}, {138, 452}, {84, 540},  {64, 596},
               {104, 618}, {116, 558}, {178, 484}, {226, 424}, {258, 424}, {206, 474}, {246, 486}, {314, 392},
               {254, 352}, {272, 284}, {322, 322}, {392, 262}, {368, 236}, {326, 276}},
         3, true);
    check_in_plane("man", made_cage(man, 24));
    // A long limb: for accuracies from 2e-3 to 1e-4, 13 to 24 of 300 random poses drift by more than 5e-4
    // after settling, at most by 4.4e-3.
    draw(spiral, {{0, 0}, {1, 0}, {1, 1}, {-1, 1}, {-1, -1}, {2, -1}, {2, 2}, {-2, 2}}, 0.12, false);
    check_in_plane("spiral", made_cage(spiral, 40), 5e-3);
#endif
}

TEST_CASE("the defaults of pins suit other cages in space", "[pose][defaults]") {
    const auto bumpy = cageform_bench::bumpy112<double>();
    const auto figure = points_in(bumpy, 300, 5);
    const std::size_t seeds = effort<std::size_t>(5, 1);
    // The reference has four times as many samples: half a minute under sanitizers, with the same code.
    check_defaults("mean value", MeanValueCoordinates(bumpy), figure,
                   {seeds, 12, 1e-4, effort(0.01, 0.0), effort(0.02, 0.0)});
    check_defaults("Green", GreenCoordinates(bumpy), figure, {seeds, 12, 1e-4, 0, 0});
}

#if !defined(CAGEFORM_SANITIZED)
TEST_CASE("the defaults of pins suit a production cage of 762 vertices", "[pose][defaults]") {
    // Hands on thin arms drift after a pose counts as settled, by up to 0.03 of the size.
    const Fingers fingers(std::string(CAGEFORM_TEST_DATA) + "/fingers");
    check_defaults("mean value", MeanValueCoordinates(fingers.cage()), fingers.points, {2, 100, 0.04, 0, 0});
}
#endif

} // namespace pose_defaults_tests

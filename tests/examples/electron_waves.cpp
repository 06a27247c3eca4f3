// Electrons as waves: properties of the product formula, and results of the scenes.
#include "waves/wave_tables.hpp"

#include "catch.hpp"
#include "support/cages.hpp"

namespace electron_waves_tests {

using namespace cageform_sources;
using cageform_tests::Random;

namespace {

/// A random wave in a random potential, with random bonds if there are several rows.
LatticeWave<double> random_wave(Random& random, std::size_t columns, std::size_t rows) {
    const WaveLattice lattice{columns, rows, random.uniform(0.05, 0.3)};
    WaveTerms terms;
    for (std::size_t n = 0; n < lattice.size(); ++n) {
        terms.potential.push_back(random.uniform(-1, 3));
        if (rows > 1) terms.bonds.push_back(random.uniform(-3, 3));
    }
    LatticeWave<double> wave(lattice, terms);
    wave.start([&](double, double) { return Complex(random.uniform(-1, 1), random.uniform(-1, 1)); });
    return wave;
}

std::vector<Complex> values_of(const LatticeWave<double>& wave) {
    std::vector<Complex> values(wave.lattice().size());
    for (std::size_t n = 0; n < values.size(); ++n) values[n] = wave.value(n);
    return values;
}

double largest_energy(const LatticeWave<double>& wave) {
    const double mesh = wave.lattice().mesh;
    return 3 +
           (wave.lattice().rows > 1 ? 2 : 1) * 4 / (3 * std::numbers::pi * std::numbers::pi * mesh * mesh);
}

/// Runs a scene on a small coarse lattice. Its walls reflect, so norm and energy are conserved.
LatticeWave<double> played(const WaveScene& scene, std::size_t run, double step) {
    LatticeWave<double> wave(scene.lattice, scene.runs[run].terms);
    wave.start(scene.runs[run].start);
    wave.set_step(step);
    const double energy = wave.energy();
    wave.advance(scene.steps(step));
    CHECK(std::fabs(wave.energy() - energy) < 1e-6);
    CHECK(std::fabs(wave.norm() - 1) < 1e-11);
    return wave;
}
const WaveLattice coarse{112, 84, 0.2};

} // namespace

TEST_CASE("steps of a wave are of fourth order, those of S2 of second order", "[examples][waves][property]") {
    const auto seed = GENERATE(seeds(4));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 1);
    const auto start = seed < 2 ? random_wave(random, 30, 1) : random_wave(random, 9, 8);
    const double time = 8 / largest_energy(start);
    const auto exact = exact_wave(start, time, largest_energy(start));
    std::array<double, 2> errors{}, errors_second{};
    for (std::size_t k = 0; k < 2; ++k) {
        const std::size_t steps = std::size_t{16} << k;
        auto wave = start, second = start;
        wave.set_step(time / double(steps));
        second.set_step(time / double(steps));
        wave.advance(steps);
        for (std::size_t n = 0; n < steps; ++n) second.advance_second_order();
        errors[k] = wave_distance(wave, exact);
        errors_second[k] = wave_distance(second, exact);
    }
    CAPTURE(errors[0], errors[1], errors_second[0], errors_second[1]);
    CHECK(errors[0] / errors[1] > 14);
    CHECK(errors[0] / errors[1] < 18);
    CHECK(errors_second[0] / errors_second[1] > 3.7);
    CHECK(errors_second[0] / errors_second[1] < 4.3);
}

TEST_CASE("steps of any size keep the norm and are reversible", "[examples][waves][property]") {
    const auto seed = GENERATE(seeds(8));
    CAPTURE(seed);
    Random random(std::uint64_t(seed) + 2);
    const auto start = random_wave(random, 3 + random.below(40), seed % 2 == 0 ? 1 : 2 + random.below(20));
    auto wave = start;
    wave.set_step(random.uniform(0, 10));
    wave.advance(4096);
    CAPTURE(1e12 * (wave.norm() - 1));
    CHECK(std::fabs(wave.norm() - 1) < 1e-11);

    wave = start;
    const double step = random.uniform(0.5, 2) / largest_energy(start);
    wave.set_step(step);
    for (int part = 0; part < 10; ++part) wave.advance(20);
    CHECK(wave_distance(wave, values_of(start)) > 0.1);
    wave.set_step(-step);
    wave.advance(200);
    CHECK(wave_distance(wave, values_of(start)) < 1e-10);
}

TEST_CASE("steps do not depend on the number of calls or threads", "[examples][waves]") {
    const WaveScene scene = make_wave_scene("spin", {200, 160, 0.1}, false);
    LatticeWave<float> one(scene.lattice, scene.runs[0].terms), three(scene.lattice, scene.runs[0].terms, 3);
    for (auto* const wave : {&one, &three}) {
        wave->start(scene.runs[0].start);
        wave->set_step(0.04);
        wave->advance(5);
    }
    bool is_equal = true;
    for (std::size_t n = 0; n < scene.lattice.size(); ++n)
        is_equal = is_equal && one.value(n) == three.value(n);
    CHECK(is_equal);

    Random random(3);
    auto whole = random_wave(random, 30, 8), parts = whole;
    whole.set_step(0.1);
    parts.set_step(0.1);
    whole.advance(7);
    for (const std::size_t steps : {0u, 3u, 4u}) parts.advance(steps);
    CHECK(wave_distance(whole, values_of(parts)) < 1e-13);
}

TEST_CASE("a free packet in the plane is a product of two on lines", "[examples][waves]") {
    const WaveLattice plane{90, 75, 0.12}, across{90, 1, 0.12}, down{75, 1, 0.12};
    LatticeWave<double> wave(plane, {}), x(across, {}), y(down, {});
    const auto first = packet(3, 0, 0.8, 1), second = packet(4, 0, 1.1, 1);
    wave.start([&](double at_x, double at_y) { return first(at_x, 0) * second(at_y, 0); });
    x.start(first);
    y.start(second);
    wave.set_step(0.05);
    x.set_step(0.05);
    y.set_step(0.05);
    wave.advance(300);
    x.advance(300);
    y.advance(300);
    std::vector<Complex> product;
    for (std::size_t n = 0; n < plane.size(); ++n) product.push_back(x.value(n % 90) * y.value(n / 90));
    CHECK(wave_distance(wave, product) < 1e-11);
}

TEST_CASE("densities do not depend on the gauge of a field", "[examples][waves][property]") {
    Random random(4);
    const WaveLattice lattice{24, 20, 0.15};
    WaveTerms terms, other;
    std::vector<double> phase(lattice.rows);
    for (double& angle : phase) angle = random.uniform(-3, 3);
    for (std::size_t n = 0; n < lattice.size(); ++n) {
        const std::size_t j = n / lattice.columns;
        terms.bonds.push_back(random.uniform(-1, 1));
        other.bonds.push_back(terms.bonds[n] + (j + 1 < lattice.rows ? phase[j + 1] - phase[j] : 0));
    }
    LatticeWave<double> wave(lattice, terms), turned(lattice, other);
    for (std::size_t n = 0; n < lattice.size(); ++n) {
        wave.set(n, {random.uniform(-1, 1), random.uniform(-1, 1)});
        turned.set(n, wave.value(n) * std::polar(1.0, phase[n / lattice.columns]));
    }
    CHECK(turned.energy() == Approx(wave.energy()).epsilon(1e-12));
    wave.set_step(0.1);
    turned.set_step(0.1);
    wave.advance(100);
    turned.advance(100);
    double largest = 0;
    for (std::size_t n = 0; n < lattice.size(); ++n)
        largest = std::max(largest, std::fabs(wave.density(n) - turned.density(n)));
    CHECK(largest < 1e-12);
}

TEST_CASE("a free packet moves and spreads as in theory", "[examples][waves]") {
    WaveLine line{50, 0.1, 15, 1.5};
    const double time = 30;
    const WaveMoments known = free_packet(line, time);
    std::array<double, 2> errors{};
    for (std::size_t k = 0; k < 2; ++k) {
        line.mesh = k == 0 ? 0.1 : 0.05;
        auto wave = wave_on_line(line);
        const double energy = wave.energy();
        wave.advance(std::size_t(std::lround(time / (4 * line.mesh * line.mesh))));
        const WaveMoments found = moments_along(wave);
        errors[k] = std::fabs(found.mean - known.mean);
        CHECK(std::fabs(found.width - known.width) < (k == 0 ? 0.02 : 0.002));
        CHECK(std::fabs(wave.energy() - energy) < 1e-6);
    }
    CAPTURE(errors[0], errors[1]);
    CHECK(errors[0] / errors[1] > 14); // of fourth order in the mesh width
    CHECK(errors[0] < 0.06);
}

TEST_CASE("the transmission of a barrier is that of plane waves", "[examples][waves]") {
    WaveLine line{60, 0.1, 14, 3, 1.25, 29, 29.2};
    const double known = transmitted_of_plane_waves(line);
    CHECK(known == Approx(0.58720).margin(5e-6));
    auto wave = wave_on_line(line);
    wave.advance(2125); // until t = 85
    const double through = wave.sum_of([&](std::size_t n) { return wave.lattice().x(n) > 29.1 ? 1.0 : 0.0; });
    CHECK(through == Approx(0.6156).margin(5e-4)); // V jumps: of second order in the mesh width
}

TEST_CASE("walls of a scene reflect or absorb", "[examples][waves]") {
    for (const bool absorbing : {false, true}) {
        WaveScene scene = make_wave_scene("slit", {80, 60, 0.2}, absorbing);
        scene.runs[0].terms.potential.clear();
        LatticeWave<double> wave(scene.lattice, scene.runs[0].terms);
        wave.start(packet(6, scene.middle(), 1.2, 1.2));
        wave.set_step(0.16);
        double before = 1;
        for (int part = 0; part < 10; ++part) {
            wave.advance(40);
            CHECK(wave.norm() < before + 1e-11);
            before = wave.norm();
        }
        if (absorbing)
            CHECK(before < 0.01);
        else
            CHECK(std::fabs(before - 1) < 1e-11);
    }
}

TEST_CASE("a symmetric scene stays symmetric", "[examples][waves]") {
    const WaveLattice coarser{72, 56, 0.2};
    for (const char* const name : {"slit", "two-slits", "shadow"}) {
        CAPTURE(name);
        const WaveScene scene = make_wave_scene(name, coarser, false);
        const auto wave = played(scene, scene.runs.size() - 1, 0.08);
        double largest = 0;
        for (std::size_t n = 0; n < coarser.size(); ++n) {
            const std::size_t mirrored =
                (coarser.rows - 1 - n / coarser.columns) * coarser.columns + n % coarser.columns;
            largest = std::max(largest, std::abs(wave.value(n) - wave.value(mirrored)));
        }
        CHECK(largest < 1e-12);
    }
}

TEST_CASE("a beam that has tunnelled is narrower than that of the open slit", "[examples][waves]") {
    const WaveScene scene = make_wave_scene("slit", coarse, false);
    const auto open = played(scene, 0, 0.16), barrier = played(scene, 1, 0.16);
    const double wide = half_width(beam_by_angle(open, scene)),
                 narrow = half_width(beam_by_angle(barrier, scene));
    CAPTURE(wide, narrow);
    CHECK(narrow < 0.7 * wide);
    CHECK(narrow > 5);
}

TEST_CASE("a magnetised tip bends both spins alike", "[examples][waves]") {
    const WaveScene scene = make_wave_scene("spin", coarse, false);
    const auto up = played(scene, 0, 0.16), down = played(scene, 1, 0.16);
    const double angle = beam_angle(up, scene);
    CAPTURE(angle);
    CHECK(std::fabs(angle) > 8);
    CHECK(std::fabs(angle - beam_angle(down, scene)) < 0.01 * std::fabs(angle));
    CHECK(up.energy() - down.energy() == Approx(scene.zeeman).epsilon(1e-3));
    CHECK(up.energy(scene.beyond) - down.energy(scene.beyond) == Approx(scene.zeeman).epsilon(0.02));
}

TEST_CASE("two slits give bright beams at multiples of the wavelength by their distance",
          "[examples][waves]") {
    const WaveScene scene = make_wave_scene("two-slits", {128, 96, 0.2}, false);
    const auto beams = maxima(beam_by_angle(played(scene, 0, 0.16), scene), 4, 0.05);
    CAPTURE(beams);
    REQUIRE(beams.size() >= 5);
    const std::size_t middle = beams.size() / 2;
    for (int k = -2; k <= 2; ++k) {
        const double degrees = std::asin(k / 4.0) * 180 / std::numbers::pi; // slits 4 wavelengths apart
        CHECK(beams[std::size_t(std::ptrdiff_t(middle) + k)] - 90 == Approx(degrees).margin(1.5));
    }
}

TEST_CASE("half widths and maxima of known curves are found", "[examples][waves]") {
    std::vector<double> bell, two;
    for (int k = 0; k <= 180; ++k) {
        bell.push_back(std::exp(-std::pow((k - 83.0) / 20, 2)));
        two.push_back(std::exp(-std::pow((k - 40.3) / 9, 2)) + 0.3 * std::exp(-std::pow((k - 120.0) / 9, 2)));
    }
    CHECK(half_width(bell) == Approx(20 * std::sqrt(std::log(2.0))).margin(0.05));
    CHECK(half_width(std::vector<double>(181)) == 0);
    const auto places = maxima(two, 5, 0.1);
    REQUIRE(places.size() == 2);
    CHECK(places[0] == Approx(40.3).margin(0.05));
    CHECK(places[1] == Approx(120.0).margin(0.05));
    CHECK(maxima({1, 2, 1}, 3, 0.1).empty());
}

} // namespace electron_waves_tests

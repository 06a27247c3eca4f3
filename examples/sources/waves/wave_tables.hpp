#pragma once

// Errors of the product formula in one dimension, against the exact exponential, a free packet, and plane
// waves at a barrier.

#include "waves/wave_scenes.hpp"

namespace cageform_sources {

/// A packet of energy 1 on a line, and a wall of `height` between `from` and `to`; `sigma` is the standard
/// deviation of |Φ|².
struct WaveLine {
    double length = 0, mesh = 0.1, middle = 0, sigma = 1;
    double height = 0, from = 0, to = 0;
    double step = 0; ///< 0: 4 mesh², for which errors in time are below errors in space
};

inline LatticeWave<double> wave_on_line(const WaveLine& line) {
    const WaveLattice lattice{std::size_t(std::lround(line.length / line.mesh)), 1, line.mesh};
    WaveTerms terms;
    for (std::size_t i = 0; i < lattice.columns && line.height > 0; ++i)
        terms.potential.push_back(line.height * inside(lattice.x(i), line.from, line.to, line.mesh * 1e-6));
    LatticeWave<double> wave(lattice, terms);
    wave.start(packet(line.middle, 0, line.sigma, 1));
    wave.set_step(line.step != 0 ? line.step : 4 * line.mesh * line.mesh);
    return wave;
}

/// e^{−iHt}Φ by Taylor series over short steps, exact up to rounding.
inline std::vector<Complex> exact_wave(LatticeWave<double> wave, double time, double largest_energy) {
    const std::size_t size = wave.lattice().size(), parts = std::size_t(std::ceil(time * largest_energy));
    std::vector<Complex> sum(size), term(size);
    for (std::size_t n = 0; n < size; ++n) sum[n] = wave.value(n);
    for (std::size_t part = 0; part < parts; ++part) {
        term = sum;
        for (int k = 1; k <= 24; ++k) {
            for (std::size_t n = 0; n < size; ++n) wave.set(n, term[n]);
            for (std::size_t n = 0; n < size; ++n)
                sum[n] += term[n] = Complex(0, -time / double(parts) / k) * wave.hamiltonian(n);
        }
    }
    return sum;
}

/// √∑|Φ − other|², scaled like the norm.
inline double wave_distance(const LatticeWave<double>& wave, const std::vector<Complex>& other) {
    double sum = 0;
    for (std::size_t n = 0; n < other.size(); ++n) sum += std::norm(wave.value(n) - other[n]);
    return std::sqrt(sum * std::pow(wave.lattice().mesh, wave.lattice().rows > 1 ? 2 : 1));
}

struct WaveMoments {
    double mean = 0, width = 0;
};
inline WaveMoments moments_along(const LatticeWave<double>& wave) {
    const auto x = [&](std::size_t n) { return wave.lattice().x(n % wave.lattice().columns); };
    const double norm = wave.norm(), mean = wave.sum_of(x) / norm;
    return {mean,
            std::sqrt(wave.sum_of([&](std::size_t n) { return (x(n) - mean) * (x(n) - mean); }) / norm)};
}

/// A free packet after a time: the mean moves at 1/π, the width grows.
inline WaveMoments free_packet(const WaveLine& line, double time) {
    const double pi = std::numbers::pi;
    return {line.middle + time / pi,
            line.sigma * std::hypot(1.0, time / (4 * pi * pi * line.sigma * line.sigma))};
}

/// The share of a packet that a wall transmits: plane waves, averaged over the energies of the packet.
inline double transmitted_of_plane_waves(const WaveLine& line) {
    const double pi = std::numbers::pi, deviation = 1 / (4 * pi * line.sigma); // of k/2π
    double sum = 0, weights = 0;
    for (int k = -4000; k <= 4000; ++k) {
        const double q = 1 + deviation * k / 500.0, energy = q * q;
        if (q <= 0) continue;
        const Complex root = std::sqrt(Complex(line.height - energy, 0)) * 2.0 * pi * (line.to - line.from);
        const double bent = std::norm(std::sinh(root)) * line.height * line.height;
        const double weight = std::exp(-0.5 * (k / 500.0) * (k / 500.0));
        sum += weight / (1 + bent / (4 * energy * std::fabs(line.height - energy)));
        weights += weight;
    }
    return sum / weights;
}

} // namespace cageform_sources

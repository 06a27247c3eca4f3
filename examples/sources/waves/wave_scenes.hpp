#pragma once

// Scenes of electrons: walls with slits, a magnetised tip, the shadow of a square; measurements of beams.

#include "waves/lattice_wave.hpp"

#include <string>

namespace cageform_sources {

using Complex = std::complex<double>;

/// One run of a scene.
struct WaveRun {
    std::string name;
    WaveTerms terms;
    std::function<Complex(double, double)> start;
};

/// A scene; lengths are in wavelengths. Beams leave `exit` to the right, near the middle height.
struct WaveScene {
    std::string name;
    WaveLattice lattice;
    std::vector<WaveRun> runs;
    std::vector<double> field;              ///< magnetic field, relative to its maximum; empty: none
    double exit = 0;                        ///< x of the right side of the wall
    double beyond = 0;                      ///< the part of the wave right of this x is transmitted
    double distance = 0;                    ///< path of the centre of the packet
    double source = 0, front = 0, half = 0; ///< shadow: x of the tip's end and of the square; half its side
    double zeeman = 0;                      ///< spin: energy difference between the spins, in E_F

    std::size_t steps(double step) const {
        return std::size_t(std::ceil(distance * std::numbers::pi / std::fabs(step)));
    }
    double middle() const { return lattice.height() / 2; }
};

inline const std::vector<std::string>& wave_scene_names() {
    static const std::vector<std::string> names{"slit", "two-slits", "spin", "shadow"};
    return names;
}

/// 1 between `from` and `to`, 0 outside, ½ at both; linear over one mesh width.
inline double inside(double at, double from, double to, double mesh) {
    return std::clamp(std::min(at - from, to - at) / mesh + 0.5, 0.0, 1.0);
}

/// A minimum-uncertainty packet of energy 1 that moves right; `wide` and `high` are the standard deviations
/// of |Φ|².
inline auto packet(double x, double y, double wide, double high) {
    return [=](double at_x, double at_y) {
        const double u = (at_x - x) / (2 * wide), v = (at_y - y) / (2 * high);
        return std::polar(std::exp(-u * u - v * v), 2 * std::numbers::pi * at_x);
    };
}

/// A scene, and what its runs have in common.
struct SceneBuilder {
    static constexpr double metal = 6, pi = std::numbers::pi; // the height of walls, in E_F
    WaveScene scene;
    double width = scene.lattice.width(), height = scene.lattice.height(), mesh = scene.lattice.mesh;
    double middle = height / 2;
    WaveTerms walls{};

    /// Samples a function of x and of y from the middle.
    template <class F>
    std::vector<double> fill(const F& function) const {
        const WaveLattice& lattice = scene.lattice;
        std::vector<double> values(lattice.size());
        for (std::size_t n = 0; n < values.size(); ++n)
            values[n] = function(lattice.x(n % lattice.columns), lattice.y(n / lattice.columns) - middle);
        return values;
    }
    void absorb() {
        const double layer = 0.1 * std::min(width, height);
        walls.losses = fill([&](double x, double y) {
            const double side = std::min({x, width - x, middle - std::fabs(y)});
            const double depth = std::max(0.0, 1 - side / layer);
            return 3 * depth * depth;
        });
    }
    template <class Potential, class Start>
    WaveRun& add(const std::string& run, const Potential& potential, const Start& start) {
        scene.runs.push_back({run, walls, start});
        scene.runs.back().terms.potential = fill(potential);
        return scene.runs.back();
    }
    /// A wall one wavelength thick; `open` is 1 in a hole and 0 in the wall.
    double wall(double x, double open) const {
        return metal * (1 - open) * inside(x, scene.exit - 1, scene.exit, mesh);
    }
    auto wide() const { return packet(0.16 * width, middle, 0.04 * width, 0.12 * height); }

    void add_slit() {
        const auto slit = [&](double x, double y) { return wall(x, inside(y, -0.5, 0.5, mesh)); };
        add("open", slit, wide());
        add(
            "barrier",
            [&, exit = scene.exit](double x, double y) { // the potential between metal and vacuum: a triangle
                const double fall = 1.5 * std::max(0.0, 1 - (x - exit) / 2);
                return slit(x, y) + fall * inside(x, exit, exit + 4, mesh);
            },
            wide());
    }
    void add_two_slits() {
        add(
            "two slits", [&](double x, double y) { return wall(x, inside(std::fabs(y), 1.5, 2.5, mesh)); },
            wide());
    }
    void add_spin() {
        // B is constant up to two wavelengths beyond the wall, then falls to 0 within two wavelengths. A
        // points along y and is the integral of B over x. A is 0 where the packet starts.
        constexpr double strength = 0.18;
        const double edge = scene.exit + 2;
        const auto at = [&](double x) {
            const double t = std::clamp((x - edge) / 2, 0.0, 1.0);
            return strength * (0.5 + 0.5 * std::cos(pi * t));
        };
        const auto potential_of_field = [&](double x) {
            const double t = std::clamp((x - edge) / 2, 0.0, 1.0);
            return strength * (std::min(x, edge) - 0.16 * width + t + std::sin(pi * t) / pi);
        };
        scene.field = fill([&](double x, double) { return at(x) / strength; });
        scene.beyond = scene.exit + 5;
        scene.zeeman = 2 * strength / (4 * pi * pi);
        for (const double spin : {1.0, -1.0}) {
            add(
                spin > 0 ? "spin up" : "spin down",
                [&](double x, double y) {
                    return wall(x, inside(y, -0.75, 0.75, mesh)) + spin * at(x) / (4 * pi * pi);
                },
                wide())
                .terms.bonds = fill([&](double x, double) { return mesh * potential_of_field(x); });
        }
    }
    void add_shadow() {
        scene.source = 0.25 * width;
        scene.front = 0.5 * width;
        scene.half = 1;
        scene.exit = scene.front;
        scene.beyond = 0.85 * width;
        scene.distance = 0.95 * width;
        const auto square = [&, front = scene.front, half = scene.half](double x, double y) {
            return metal * inside(x, front, front + 2 * half, mesh) * inside(y, -half, half, mesh);
        };
        // A channel that ends at the tip, with the wave of its lowest mode in it.
        constexpr double channel = 0.75;
        const auto tip = [&, end = scene.source](double x, double y) {
            return x > end + mesh / 2
                       ? 0.0
                       : metal * inside(x, -1, end, mesh) * (1 - inside(y, -channel / 2, channel / 2, mesh));
        };
        const double most = 2 * pi * std::sqrt(metal); // mode² + decay² = most²
        double mode = pi / channel, decay = 0;
        for (int round = 0; round < 60; ++round) {
            decay = std::sqrt(most * most - mode * mode);
            mode = 2 / channel * std::atan(decay / mode);
        }
        const auto in_channel = [=, width = width, middle = middle](double x, double y) {
            const double u = (x - 0.13 * width) / (0.06 * width), side = std::fabs(y - middle) - channel / 2;
            const double across = side < 0 ? std::cos(mode * (y - middle))
                                           : std::cos(mode * channel / 2) * std::exp(-decay * side);
            return std::polar(std::exp(-u * u), x * std::sqrt(4 * pi * pi - mode * mode)) * across;
        };
        add("Gaussian", square, packet(0.16 * width, middle, 0.04 * width, 2));
        add("tip", [&](double x, double y) { return tip(x, y) + square(x, y); }, in_channel);
    }
};

/// Makes one of the four scenes.
///
///   rows       a multiple of 4: pairs of rows are then symmetric about the middle
///   absorbing  the sides of the lattice absorb the wave; otherwise they reflect it
///
/// Follows "Computer animation of electron motion in nanometre-scale devices", fig. 1–5; dimensions are ours.
inline WaveScene make_wave_scene(const std::string& name, const WaveLattice& lattice, bool absorbing) {
    SceneBuilder builder{{name, lattice, {}, {}, 0.35 * lattice.width(), 0, 0.58 * lattice.width()}};
    builder.scene.beyond = builder.scene.exit + 2;
    if (absorbing) builder.absorb();
    if (name == "slit")
        builder.add_slit();
    else if (name == "two-slits")
        builder.add_two_slits();
    else if (name == "spin")
        builder.add_spin();
    else
        builder.add_shadow();
    return std::move(builder.scene);
}

/// |Φ|² by direction from the middle of the exit, at −90, −89, …, 90 degrees. Ignores points close to the
/// exit.
template <class T>
std::vector<double> beam_by_angle(const LatticeWave<T>& wave, const WaveScene& scene) {
    const double least = 0.35 * (wave.lattice().width() - scene.exit);
    std::vector<double> beam(182);
    for (std::size_t n = 0; n < wave.lattice().size(); ++n) {
        const double x = wave.lattice().x(n % wave.lattice().columns) - scene.exit;
        const double y = wave.lattice().y(n / wave.lattice().columns) - scene.middle();
        if (x <= 0 || std::hypot(x, y) < least) continue;
        const double degrees = std::atan2(y, x) * 180 / std::numbers::pi + 90,
                     part = degrees - std::floor(degrees);
        const auto k = std::size_t(degrees);
        beam[k] += (1 - part) * wave.density(n);
        beam[k + 1] += part * wave.density(n);
    }
    beam.pop_back();
    return beam;
}

/// Half the width of the beam at half of its maximum, in degrees.
inline double half_width(const std::vector<double>& beam) {
    const auto peak = std::size_t(std::max_element(beam.begin(), beam.end()) - beam.begin());
    const auto edge = [&](std::ptrdiff_t way) {
        auto k = std::ptrdiff_t(peak);
        const auto at = [&](std::ptrdiff_t place) {
            return place < 0 || place >= std::ptrdiff_t(beam.size()) ? 0.0 : beam[std::size_t(place)];
        };
        while (at(k + way) > beam[peak] / 2) k += way;
        return std::fabs(double(k - std::ptrdiff_t(peak))) + (at(k) - beam[peak] / 2) / (at(k) - at(k + way));
    };
    return beam[peak] > 0 ? (edge(1) + edge(-1)) / 2 : 0;
}

/// Positions of local maxima, as fractional indices. A maximum is the largest value within `reach` indices,
/// and larger than `least` times the largest of all.
inline std::vector<double> maxima(const std::vector<double>& values, std::size_t reach, double least) {
    std::vector<double> places;
    if (values.size() <= 2 * reach) return places;
    const double most = *std::max_element(values.begin(), values.end());
    for (std::size_t k = reach; k + reach < values.size(); ++k) {
        const auto around = values.begin() + std::ptrdiff_t(k);
        const auto low = around - std::ptrdiff_t(reach), high = around + std::ptrdiff_t(reach) + 1;
        if (values[k] <= least * most || std::max_element(low, high) != around) continue;
        const double a = values[k - 1], b = values[k], c = values[k + 1], bend = a - 2 * b + c;
        places.push_back(double(k) + (bend < 0 ? (a - c) / (2 * bend) : 0));
    }
    return places;
}

/// The direction of the mean position right of `scene.beyond`, from the exit, in degrees.
template <class T>
double beam_angle(const LatticeWave<T>& wave, const WaveScene& scene) {
    double x = 0, y = 0;
    for (std::size_t n = 0; n < wave.lattice().size(); ++n) {
        const double right = wave.lattice().x(n % wave.lattice().columns);
        if (right < scene.beyond) continue;
        x += (right - scene.exit) * wave.density(n);
        y += (wave.lattice().y(n / wave.lattice().columns) - scene.middle()) * wave.density(n);
    }
    return std::atan2(y, x) * 180 / std::numbers::pi;
}

/// The distance of the k-th bright fringe (k ≥ 1) from the middle of the shadow: Fresnel's integral at a
/// straight edge.
inline double fresnel_fringe(const WaveScene& scene, int k) {
    const double a = scene.front - scene.source, b = scene.beyond - scene.front;
    const double place = std::sqrt(2 * (k - 1) + 0.75) * std::sqrt(2.0); // 1.22, 2.35, …
    return scene.half * (a + b) / a + place * std::sqrt(b * (a + b) / (2 * a));
}

} // namespace cageform_sources

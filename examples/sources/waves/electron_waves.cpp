// Electron waves: through slits, from a magnetised tip, past an opaque square.
//
//     electron_waves --scene slit -o slit.png --csv slit.csv --gif slit.gif
//
// Follows "Computer animation of electron motion in nanometre-scale devices": the Schrödinger
// equation on a lattice, by a product formula of fourth order. A picture has a row per run of a scene and a
// column for each of four times. Densities |Φ|² are grey, potentials orange, magnetic fields blue. Densities
// behind walls are brightened; the caption has the factor.

#include "waves/wave_tables.hpp"

#include "cli/command_line.hpp"
#include "cli/progress_bar.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"
#include "pictures/plot.hpp"
#include "pictures/render.hpp"

#include <chrono>
#include <cstdio>
#include <iostream>
#include <optional>

#include <unistd.h>

namespace {

using namespace cageform_sources;
using namespace cageform_support;

struct Settings {
    std::string scene = "slit", walls, out, csv, gif, stills;
    WaveLattice lattice{384, 288, 0.1};
    double step = 0;
    int steps = 0, frames = 24, threads = 1;
    bool single = false, benchmark = false, tables = false;

    unsigned thread_count() const { return unsigned(threads); }
};

/// Parses columns and rows "384x288"; returns the fault, or empty.
std::string parse_size(const std::string& text, WaveLattice& lattice) {
    int columns = 0, rows = 0, end = 0;
    if (std::sscanf(text.c_str(), "%6dx%6d%n", &columns, &rows, &end) != 2 || end != int(text.size()))
        return text + ": give columns and rows, such as 384x288";
    if (columns < 32 || rows < 32 || columns > 65536 || rows > 65536)
        return text + ": a lattice has from 32 to 65536 columns and rows";
    if (rows % 4 != 0) return text + ": rows have to be a multiple of 4, for symmetry";
    lattice.columns = std::size_t(columns);
    lattice.rows = std::size_t(rows);
    return "";
}

/// The pictures and screen densities of a run.
struct Recorded {
    std::string name;
    std::vector<std::vector<float>> frames; ///< densities at half the resolution
    std::vector<std::vector<float>> passed; ///< shadow: time integrals of the densities
    std::vector<double> screen;             ///< time integral of the density at `beyond`, by rows
};

template <class T>
std::vector<float> half_resolution(const LatticeWave<T>& wave) {
    const std::size_t columns = wave.lattice().columns, width = columns / 2, height = wave.lattice().rows / 2;
    std::vector<float> halves(width * height);
    for (std::size_t n = 0; n < halves.size(); ++n) {
        const std::size_t at = n / width * 2 * columns + n % width * 2;
        halves[n] = float(wave.density(at) + wave.density(at + 1) + wave.density(at + columns) +
                          wave.density(at + columns + 1));
    }
    return halves;
}

/// Bright fringes on both sides of the square's shadow: positions, and brightness relative to the brightest.
std::string fringes(const WaveScene& scene, const std::vector<double>& screen) {
    const std::size_t half = screen.size() / 2;
    const double mesh = scene.lattice.mesh;
    const auto from = std::size_t(scene.half / mesh);
    std::vector<double> side; // from the square's side to the absorbing layer
    for (std::size_t j = from; double(j) < 0.88 * double(half); ++j)
        side.push_back(screen[half + j] + screen[half - 1 - j]);
    std::string words;
    for (const double place : maxima(side, std::size_t(0.8 / mesh), 0.01)) {
        const double bright =
            side[std::size_t(std::lround(place))] / *std::max_element(side.begin(), side.end());
        words += text_of(" %.1f", (place + double(from) + 0.5) * mesh) + text_of(" (%.2f)", bright);
    }
    return words.empty() ? " none" : words;
}

/// Measurements of a run.
struct Measured {
    double norm = 1, norm_off = 0, first_energy = 0, energy_off = 0, through = 0;
};

/// Prints the directions of the beams of a run.
///
///   screen   densities on the screen, of the scene shadow
template <class T>
void print_run(const WaveScene& scene, const WaveRun& run, const LatticeWave<T>& wave,
               const Measured& measured, const std::vector<double>& screen) {
    const auto& [norm, norm_off, first_energy, energy_off, through] = measured;
    std::cout << run.name << ": ";
    if (scene.half == 0) std::cout << "transmitted " << text_of("%.4g", through);
    const auto beam = beam_by_angle(wave, scene);
    if (scene.zeeman > 0)
        std::cout << ", direction " << text_of("%.2f", beam_angle(wave, scene)) << " degrees, energy "
                  << text_of("%.9f", first_energy)
                  << text_of(", of the transmitted part %.6f", wave.energy(scene.beyond));
    else if (scene.name == "slit")
        std::cout << ", half width " << text_of("%.1f", half_width(beam)) << " degrees";
    else if (scene.half > 0)
        std::cout << "bright fringes" << fringes(scene, screen);
    else
        for (const double place : maxima(beam, 4, 0.01)) std::cout << text_of(", %.1f degrees", place - 90);
    if (run.terms.losses.empty())
        std::cout << "; norm off by at most " << text_of("%.1e", norm_off) << ", energy by "
                  << text_of("%.1e", energy_off);
    else
        std::cout << "; remaining norm " << text_of("%.3g", norm);
    std::cout << std::endl;
}

/// Runs a scene once, and prints the directions of its beams.
template <class T>
Recorded play(const WaveScene& scene, const WaveRun& run, const Settings& settings, std::size_t steps,
              double step, std::string& csv) {
    LatticeWave<T> wave(scene.lattice, run.terms, settings.thread_count());
    wave.start(run.start);
    wave.set_step(step);
    const WaveLattice& lattice = scene.lattice;
    Recorded recorded{run.name, {}, {}, std::vector<double>(lattice.rows)};
    std::vector<float> passed(lattice.columns / 2 * (lattice.rows / 2));
    const auto screen = std::size_t(scene.beyond / lattice.mesh);
    const auto x = [&](std::size_t n) { return lattice.x(n % lattice.columns); };
    const auto y = [&](std::size_t n) { return lattice.y(n / lattice.columns); };
    Measured measured{.first_energy = wave.energy()};
    auto& [norm, norm_off, first_energy, energy_off, through] = measured;
    ProgressBar bar(run.name);
    const auto tell = bar.callback();
    for (std::size_t frame = 0, done = 0;; ++frame) {
        if (tell) tell(double(frame) / settings.frames);
        norm = wave.norm();
        const double energy = wave.energy();
        norm_off = std::max(norm_off, std::fabs(norm - 1));
        energy_off = std::max(energy_off, std::fabs(energy - first_energy));
        through = wave.sum_of([&](std::size_t n) { return x(n) > scene.beyond ? 1.0 : 0.0; });
        csv += run.name;
        for (const double value :
             {double(done) * step, norm, energy, wave.sum_of(x) / norm, wave.sum_of(y) / norm, through})
            csv += text_of(",%.12g", value);
        csv += '\n';
        recorded.frames.push_back(half_resolution(wave));
        if (scene.half > 0) recorded.passed.push_back(passed);
        if (frame == std::size_t(settings.frames)) break;
        const std::size_t next = steps * (frame + 1) / std::size_t(settings.frames);
        while (done < next) {
            if (scene.half == 0) {
                wave.advance(next - done);
                break;
            }
            const std::size_t part =
                std::min<std::size_t>(next - done, 16); // samples the screen every 16 steps
            wave.advance(part);
            done += part;
            for (std::size_t j = 0; j < lattice.rows; ++j)
                recorded.screen[j] += wave.density(j * lattice.columns + screen) * double(part);
            const auto now = half_resolution(wave);
            for (std::size_t n = 0; n < now.size(); ++n) passed[n] += now[n] * float(part);
        }
        done = next;
    }
    print_run(scene, run, wave, measured, recorded.screen);
    return recorded;
}

/// A row of pictures: densities of all frames, and their scale.
struct Row {
    std::string caption;
    std::vector<std::vector<float>> frames; ///< grey in [0, 1]
    const std::vector<double>* potential = nullptr;
};

/// Densities as greys. The largest density behind a position is white. In front of it, with a separate scale,
/// the largest initial density is white, and the caption has the ratio of the scales.
Row grey_row(const WaveScene& scene, const std::string& caption, std::vector<std::vector<float>> frames,
             const WaveTerms& terms, double beyond, bool two_scales) {
    const std::size_t width = scene.lattice.columns / 2;
    const auto right = [&](std::size_t n, double by) { return scene.lattice.x(n % width * 2) > beyond + by; };
    const float at_start = *std::max_element(frames.front().begin(), frames.front().end());
    float right_most = std::max(1e-30f, 1e-9f * at_start); // else rounding would be drawn
    for (const auto& frame : frames) {
        for (std::size_t n = 0; n < frame.size(); ++n)
            if (right(n, 4)) right_most = std::max(right_most, frame[n]);
    }
    const float left_most = two_scales ? at_start : right_most;
    for (auto& frame : frames) {
        for (std::size_t n = 0; n < frame.size(); ++n) frame[n] /= right(n, 0) ? right_most : left_most;
    }
    const std::string words = text_of(", beyond x %.3g", double(left_most) / double(right_most));
    return {caption + (two_scales ? words : ""), std::move(frames), &terms.potential};
}

std::vector<Row> rows_of(const WaveScene& scene, const std::vector<Recorded>& runs) {
    std::vector<Row> rows;
    for (std::size_t k = 0; k < runs.size(); ++k) {
        const double from = runs[k].name == "tip" ? scene.source : scene.exit;
        rows.push_back(grey_row(scene, runs[k].name, runs[k].frames, scene.runs[k].terms, from, true));
    }
    for (std::size_t k = 0; k < runs.size() && scene.half > 0; ++k)
        rows.push_back(grey_row(scene, runs[k].name + ": time-integrated density", runs[k].passed,
                                scene.runs[k].terms, scene.exit, false));
    if (scene.name != "spin") return rows;
    const std::size_t width = scene.lattice.columns / 2;
    auto sum = runs[0].frames;
    for (std::size_t k = 0; k < sum.size(); ++k) {
        for (std::size_t n = 0; n < sum[k].size(); ++n) {
            sum[k][n] += runs[1].frames[k][n];
            const bool is_up = (n % width / 4 + n / width / 4) % 2 == 0; // squares of four pixels
            float& up = rows[0].frames[k][n];
            up = 0.5f + 0.5f * (is_up ? std::min(up, 1.0f) : -std::min(rows[1].frames[k][n], 1.0f));
        }
    }
    rows[0].caption = "spin up bright, down dark";
    rows[1] = grey_row(scene, "sum", std::move(sum), scene.runs[0].terms, scene.exit, true);
    return rows;
}

/// Arranges frames in rows, each row with its caption.
Picture draw(const WaveScene& scene, const std::vector<Row>& rows, const std::vector<std::size_t>& frames) {
    constexpr std::size_t gap = 4, head = 14;
    const std::size_t width = scene.lattice.columns / 2, height = scene.lattice.rows / 2;
    Picture picture(frames.size() * (width + gap) - gap, rows.size() * (height + head));
    for (std::size_t r = 0; r < rows.size(); ++r) {
        const std::size_t top = r * (height + head) + head;
        picture.text({2, double(top) - 6}, rows[r].caption, 1, {0.1f, 0.1f, 0.1f});
        for (std::size_t k = 0; k < frames.size(); ++k) {
            Picture tile(width, height);
            for (std::size_t n = 0; n < width * height; ++n) {
                const std::size_t at = n / width * 2 * scene.lattice.columns + n % width * 2;
                const float grey = std::clamp(rows[r].frames[frames[k]][n], 0.0f, 1.0f);
                const auto tint = [&](double size) { return float(0.6 * std::clamp(size, 0.0, 1.0)); };
                Colour colour{grey, grey, grey};
                if (!scene.field.empty())
                    colour = mix(colour, {0.25f, 0.45f, 1}, tint(0.4 * scene.field[at]));
                colour = mix(colour, {1, 0.6f, 0.15f}, tint((*rows[r].potential)[at] / 1.5));
                tile.at(n % width, n / width) = colour;
            }
            picture.place(tile, k * (width + gap), top);
        }
    }
    return picture;
}

/// Writes all requested files.
int write(const Settings& settings, const WaveScene& scene, const std::vector<Recorded>& runs,
          const std::string& csv) {
    const std::vector<Row> rows = rows_of(scene, runs);
    const auto last = std::size_t(settings.frames);
    OutputFiles outputs;
    if (!settings.out.empty())
        draw(scene, rows, {0, (last + 1) / 3, (2 * last + 1) / 3, last}).write_png(outputs.add(settings.out));
    if (!settings.csv.empty())
        outputs.add(settings.csv).write("run,time,norm,energy,mean_x,mean_y,transmitted\n" + csv);
    std::optional<Film> film;
    if (!settings.gif.empty()) film.emplace(outputs, settings.gif, 12, 0);
    for (std::size_t k = 0; k <= last && (film || !settings.stills.empty()); ++k) {
        const Picture frame = draw(scene, rows, {k});
        if (film) film->add_frame(frame);
        if (!settings.stills.empty())
            frame.write_png(outputs.add(settings.stills + (k < 10 ? "0" : "") + std::to_string(k) + ".png"));
    }
    if (film) film->finish();
    return commit(outputs);
}

/// Memory of two runs, with their frames and pictures, in bytes.
double memory_of(const Settings& settings) {
    const double number = settings.single ? sizeof(float) : sizeof(double);
    const double point = 16 * number + 6 * sizeof(double) + 3 * sizeof(Colour);
    return double(settings.lattice.size()) * (point + 8.0 * (settings.frames + 1) * sizeof(float) / 4);
}

/// Prints the steps per second for 1024 x 512 points in float, and compares a step with reading and writing Φ
/// once.
int benchmark(const Settings& settings) {
    using Clock = std::chrono::steady_clock;
    const auto seconds = [](const auto& body) { // the best of many
        double best = 1e300;
        for (int round = 0; round < 25; ++round) {
            const auto start = Clock::now();
            body();
            best = std::min(best, std::chrono::duration<double>(Clock::now() - start).count());
        }
        return best;
    };
    const WaveLattice lattice{1024, 512, 0.1};
    LatticeWave<float> wave(lattice, {}, settings.thread_count());
    wave.start(packet(20, lattice.height() / 2, 3, 4));
    wave.set_step(0.04);
    constexpr std::size_t count = 4;
    const double step = seconds([&] { wave.advance(count); }) / double(count);
    std::vector<float> field(2 * lattice.size(), 1.0f);
    const double once = seconds([&] {
        for (float& number : field) number = number * 0.999f + 0.001f;
    });
    std::cout << text_of("%.1f", 1 / step) << " steps per second for 1024 x 512 points in float, on "
              << settings.threads << (settings.threads == 1 ? " thread" : " threads") << ": a step takes "
              << text_of("%.2f", 1e3 * step) << " ms, " << text_of("%.0f", step / once)
              << " times as long as reading and writing the field once (" << text_of("%.3f", 1e3 * once)
              << " ms)\n";
    return field[0] > 0 && wave.norm() > 0 ? 0 : 1;
}

int tables() {
    std::cout << "error after t = 8 against the exact exponential, 200 points, mesh 0.1\n"
                 "step   S4        ratio   energy    S2        ratio\n";
    double before = 0, before_second = 0;
    for (const double step : {0.16, 0.08, 0.04, 0.02, 0.01}) {
        const WaveLine line{20, 0.1, 8, 1.5, 0.2, 12, 14, step};
        auto wave = wave_on_line(line), second = wave;
        const auto exact = exact_wave(wave, 8, 20);
        const auto steps = std::size_t(std::lround(8 / step));
        const double energy = wave.energy();
        wave.advance(steps);
        for (std::size_t k = 0; k < steps; ++k) second.advance_second_order();
        const double error = wave_distance(wave, exact), error_second = wave_distance(second, exact);
        std::cout << text_of("%-5.2f  ", step) << text_of("%.2e  ", error)
                  << text_of("%5.1f   ", before / error)
                  << text_of("%.1e   ", std::fabs(wave.energy() - energy)) << text_of("%.2e  ", error_second)
                  << text_of("%5.1f", before_second / error_second) << '\n';
        before = error;
        before_second = error_second;
    }
    auto wild = wave_on_line({20, 0.1, 8, 1.5, 0.2, 12, 14, 5});
    wild.advance(1000);
    std::cout << "norm after 1,000 steps of 5: 1 " << text_of("%+.1e", wild.norm() - 1) << '\n';

    const WaveLine free{60, 0.1, 15, 1.5};
    const WaveMoments known = free_packet(free, 60);
    std::cout << "free packet after t = 60: mean, width\nexact       " << text_of("%.4f", known.mean)
              << text_of("  %.4f\n", known.width);
    for (const double mesh : {0.1, 0.05}) {
        WaveLine line = free;
        line.mesh = mesh;
        auto wave = wave_on_line(line);
        wave.advance(std::size_t(std::lround(60 / (4 * mesh * mesh))));
        const WaveMoments found = moments_along(wave);
        std::cout << text_of("mesh %-6g ", mesh) << text_of("%.4f", found.mean)
                  << text_of("  %.4f\n", found.width);
    }
    const WaveLine barrier{80, 0.1, 20, 3, 1.25, 40, 40.2};
    std::cout << "through a barrier of 1.25, 0.2 wide\nplane waves "
              << text_of("%.5f", transmitted_of_plane_waves(barrier)) << '\n';
    for (const double mesh : {0.1, 0.05, 0.025}) {
        WaveLine line = barrier;
        line.mesh = mesh;
        auto wave = wave_on_line(line);
        wave.advance(std::size_t(std::lround(110 / (4 * mesh * mesh))));
        std::cout << text_of("mesh %-6g ", mesh) << text_of("%.5f\n", wave.sum_of([&](std::size_t n) {
            return wave.lattice().x(n) > 40.1 ? 1.0 : 0.0;
        }));
    }
    return 0;
}

void add_options(CommandLine& line, Settings& settings) {
    line.add("--scene", settings.scene, "slit, with and without a barrier; two-slits; spin; shadow")
        .one_of(wave_scene_names())
        .show_default();
    line.add("-o,--output", settings.out, "the picture to write: four times of each run").ends_with({".png"});
    line.add("--csv", settings.csv, "also write norm, energy, mean position and transmitted part over time")
        .ends_with({".csv"});
    line.add("--gif", settings.gif, "also write the frames as a GIF, if ffmpeg is installed")
        .ends_with({".gif"});
    line.add("--stills", settings.stills,
             "also write the frames to files whose names begin with this: 00.png, 01.png, …");
    line.add("--frames", settings.frames, "the number of frames after the first").range(3, 99).show_default();
    line.add_text(
            "--size", [&settings](const std::string& text) { parse_size(text, settings.lattice); },
            "columns and rows of the lattice; 384x288 by default")
        .check([](const std::string& text) {
            WaveLattice lattice;
            return parse_size(text, lattice);
        });
    line.add("--mesh", settings.lattice.mesh, "the distance between neighbours, in wavelengths")
        .range(0.01, 0.2)
        .show_default();
    line.add("--step", settings.step, "the step in time, in units of h/2 pi E_F; 0 means 4 mesh^2")
        .range(0.0, 10.0)
        .show_default();
    line.add("--steps", settings.steps, "the number of steps; 0 means until the wave has crossed the lattice")
        .range(0, 100000000)
        .show_default();
    line.add("--walls", settings.walls,
             "the sides of the lattice: absorbing by default in the scene shadow, else reflecting")
        .one_of({"reflecting", "absorbing"});
    line.add("--threads", settings.threads, "the number of threads").range(1, 64).show_default();
    line.add_flag("--float", settings.single,
                  "compute in float: half the time, errors of the norm up to 0.0003");
    line.add_flag("--benchmark", settings.benchmark, "print steps per second, and write nothing");
    line.add_flag("--tables", settings.tables,
                  "print errors of the method in one dimension, and write nothing");
}

/// Fails if a file cannot be written, the lattice is too small, or memory does not suffice.
void check(const Settings& settings) {
    std::vector<std::filesystem::path> paths{settings.out, settings.csv, settings.gif};
    if (!settings.stills.empty()) paths.emplace_back(settings.stills + "00.png");
    fail_if(fault_of_outputs(paths));

    const double wide = settings.lattice.width(), high = settings.lattice.height();
    if (wide < 12 || high < 9)
        throw Failure("--size with this --mesh is " + text_of("%.1f", wide) + text_of(" x %.1f", high) +
                      " wavelengths: a scene needs at least 12 x 9");
    const double gigabyte = 1e9, memory = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGESIZE));
    if (const double needed = memory_of(settings); needed > 0.8 * memory)
        throw Failure("--size needs " + text_of("%.1f", needed / gigabyte) + " GB, and the machine has " +
                      text_of("%.1f", memory / gigabyte) + ": give fewer points, fewer --frames or --float");
}

} // namespace

int run_program(int argc, char** argv) {
    Settings settings;
    CommandLine line("Simulates electrons as waves on a lattice, and measures the waves.");
    line.set_examples({"--scene slit -o slit.png --csv slit.csv",
                       "--scene shadow --size 512x512 --gif shadow.gif",
                       "--scene spin --stills spin_ --frames 12", "--benchmark", "--tables"});
    add_options(line, settings);
    if (const auto code = line.parse(argc, argv)) return *code;
    if (settings.benchmark) return benchmark(settings);
    if (settings.tables) return tables();
    if (settings.out.empty() && settings.csv.empty() && settings.gif.empty() && settings.stills.empty())
        return fail("nothing to write: give -o, --csv, --gif or --stills");
    check(settings);
    const bool absorbing =
        settings.walls.empty() ? settings.scene == "shadow" : settings.walls == "absorbing";
    const WaveScene scene = make_wave_scene(settings.scene, settings.lattice, absorbing);
    const double step = settings.step > 0 ? settings.step : 4 * scene.lattice.mesh * scene.lattice.mesh;
    if (settings.steps == 0 && scene.distance * std::numbers::pi / step > 1e8)
        return fail("--step " + text_of("%g", step) +
                    " needs more than 100000000 steps: give a longer step, or --steps");
    const std::size_t steps = settings.steps > 0 ? std::size_t(settings.steps) : scene.steps(step);
    std::vector<Recorded> runs;
    std::string csv;
    for (const WaveRun& run : scene.runs)
        runs.push_back(settings.single ? play<float>(scene, run, settings, steps, step, csv)
                                       : play<double>(scene, run, settings, steps, step, csv));
    if (scene.half > 0)
        std::cout << "Fresnel's integral: bright fringes" << text_of(" %.1f", fresnel_fringe(scene, 1))
                  << text_of(" %.1f wavelengths from the middle", fresnel_fringe(scene, 2)) << std::endl;
    return write(settings, scene, runs, csv);
}

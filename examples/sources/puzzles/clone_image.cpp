// Instant image cloning: copies a region of one picture into another without a seam (Farbman, Hoffer, Lipman,
// Cohen-Or, Lischinski, Coordinates for instant image cloning, ACM Trans. Graph. 28(3) (2009)).
//
//     clone_image --make .
//     clone_image noon.png evening.png --region boat.svg -o boat.png --report
//
// The result is the source plus a smooth function whose values on the outline are the differences of target
// and source. Mean value coordinates of the outline interpolate this function. The weights are bound once;
// each position in the target then needs the differences, a clone, and a blend. --poisson and --report
// compare with the solution of the Poisson equation.

#include "cli/command_line.hpp"
#include "cli/progress_bar.hpp"
#include "files/cage_file.hpp"
#include "io/base64.hpp"
#include "io/messages.hpp"
#include "pictures/image_clone.hpp"
#include "pictures/render.hpp"
#include "puzzles/harbour.hpp"

#include <cageform/parallel/threads.hpp>

#include <chrono>
#include <filesystem>
#include <iostream>
#include <limits>
#include <optional>

namespace {

using namespace cageform_sources;

struct Given {
    std::string source, target, region, out, pasted, poisson, frames, film, folder;
    std::vector<PixelPlace> places;
    std::size_t steps = 1, size = 640, threads = 1;
    bool report = false;
};

/// Seconds since construction or the last call.
class Stopwatch {
public:
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Parses "30,-12", in pixels.
std::optional<PixelPlace> parse_place(const std::string& text) {
    std::array<double, 2> at{};
    if (!detail::parse_point(text, at).empty()) return std::nullopt;
    for (const double x : at) {
        if (!(std::fabs(x) <= 1e9) || x != std::round(x)) return std::nullopt;
    }
    return PixelPlace{std::int64_t(at[0]), std::int64_t(at[1])};
}

int make_pictures(const Given& given) {
    std::error_code error;
    std::filesystem::create_directories(given.folder, error);
    if (error) return fail("cannot make the folder " + given.folder + ": " + error.message());
    const Harbour harbour(given.size);
    OutputFiles outputs;
    const std::filesystem::path folder(given.folder);
    harbour.noon().write_png(outputs.add(folder / "noon.png"));
    harbour.evening().write_png(outputs.add(folder / "evening.png"));
    outputs.add(folder / "boat.svg").write(harbour.boat_outline());
    fail_if(outputs.commit());
    for (const char* name : {"noon.png", "evening.png", "boat.svg"})
        std::cout << printable((folder / name).string()) << '\n';
    return 0;
}

/// The region of a mask or an outline in the source.
PixelRegion load_region(const std::string& path, const Pixels& source) {
    const auto refuse = [&](const std::string& why) { return Failure(path + ": " + why); };
    const std::string size = std::to_string(source.width) + " x " + std::to_string(source.height);
    PixelRegion region;
    if (const std::string ending = lowercase_extension(path);
        ending == ".svg" || ending == ".svgz" || ending == ".csv") {
        const auto outline = value_or_fail(load_cage(path, CageEdges::as_drawn));
        const auto loops = outline.loops(0.1);
        constexpr double slack = 1e-6; // of a pixel
        for (const auto& loop : loops) {
            for (const Point2& p : loop) {
                if (p.x >= -slack && p.y >= -slack && p.x <= double(source.width) + slack &&
                    p.y <= double(source.height) + slack)
                    continue;
                throw refuse("the outline reaches (" + detail::short_number(p.x) + ", " +
                             detail::short_number(p.y) + "), outside the source of " + size +
                             " pixels; its units are pixels from the upper left corner");
            }
        }
        region = make_region(mask_of(loops, source.width, source.height), source.width);
        if (region.is_empty()) throw refuse("the outline contains no centre of a pixel");
    } else {
        const auto mask = value_or_fail(read_png(path));
        if (mask.width != source.width || mask.height != source.height)
            throw refuse("the mask has " + std::to_string(mask.width) + " x " + std::to_string(mask.height) +
                         " pixels, and the source " + size + ": make them equal");
        region = make_region(mask_of(mask), source.width);
        if (region.is_empty()) throw refuse("the mask is empty: no pixel is light and opaque");
    }
    if (region.inside == 0)
        throw refuse(
            "the region has no inside: all its pixels lie on its outline; it has to be 3 pixels wide");
    return region;
}

/// The given positions, with steps between them.
std::vector<PixelPlace> way_of(const Given& given, const PixelRegion& region) {
    if (given.places.empty()) return {{std::int64_t(region.left), std::int64_t(region.top)}};
    std::vector<PixelPlace> way{given.places.front()};
    for (std::size_t n = 1; n < given.places.size(); ++n) {
        const PixelPlace &from = given.places[n - 1], &to = given.places[n];
        for (std::size_t k = 1; k <= given.steps; ++k) {
            const double t = double(k) / double(given.steps);
            way.push_back({std::llround(std::lerp(double(from.x), double(to.x), t)),
                           std::llround(std::lerp(double(from.y), double(to.y), t))});
        }
    }
    return way;
}

/// The name of a frame, numbered from 1, with the digits of the last frame.
std::string frame_path(const std::string& begin, std::size_t frame, std::size_t count) {
    std::string number = std::to_string(frame + 1);
    number.insert(
        0, std::max<std::size_t>(2, std::to_string(count).size()) - std::min<std::size_t>(2, number.size()),
        '0');
    return begin + number + ".png";
}

std::string in_svg(const Pixels& picture) {
    const std::string width = std::to_string(picture.width), height = std::to_string(picture.height);
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + width + "\" height=\"" + height +
           "\"><image width=\"" + width + "\" height=\"" + height + "\" href=\"data:image/png;base64," +
           base64(picture.png()) + "\"/></svg>";
}

/// Fails if the region does not fit into the target at a place.
void check_places(const Given& given, const PixelRegion& region, const Pixels& target,
                  const std::vector<PixelPlace>& way) {
    for (const PixelPlace& at : way) {
        const std::string why = fault_of_place(region, target, at);
        if (why.empty()) continue;
        throw Failure((given.places.empty()
                           ? "without --at: "
                           : "--at " + std::to_string(at.x) + "," + std::to_string(at.y) + ": ") +
                      why);
    }
}

/// The source, the target and the region, with the threads of the program.
struct Scene {
    Pixels source, target;
    PixelRegion region;
    cageform::ParallelFor parallel = cageform::SerialFor{};
};

/// The picture at the last place, and the seconds of all moves.
struct Moved {
    Pixels picture;
    double moves = 0, shortest = std::numeric_limits<double>::infinity();
};

/// Clones the region at all places, and adds the picture or the strip, frames and film to the outputs.
Moved move_region(const Given& given, const Scene& scene, Membrane& membrane,
                  const std::vector<PixelPlace>& way, OutputFiles& outputs) {
    const auto& [source, target, region, parallel] = scene;
    std::optional<Film> film;
    const std::size_t widest = std::min<std::size_t>(target.width, 640);
    if (!given.film.empty()) film.emplace(outputs, given.film, 20, int(widest));
    std::vector<Pixels> strip;
    Moved moved;
    auto& [picture, moves, shortest] = moved;
    Stopwatch watch;
    for (std::size_t n = 0; n < way.size(); ++n) {
        picture = target;
        watch.lap();
        paste(source, region, way[n], outline_differences(source, region, target, way[n]), membrane, picture);
        const double move = watch.lap();
        moves += move;
        shortest = std::min(shortest, move);
        if (!given.frames.empty()) picture.write_png(outputs.add(frame_path(given.frames, n, way.size())));
        if (film) film->add_frame(in_svg(shrunk(picture, 1280)));
        if (way.size() > 1) strip.push_back(shrunk(picture, 480));
    }
    if (film) film->finish();
    if (!given.out.empty())
        (way.size() > 1 ? side_by_side(strip, 8) : picture).write_png(outputs.add(given.out));
    return moved;
}

/// Clones the region at a place by Poisson's equation; returns a line on the differences from `picture`.
std::string compare_poisson(const Given& given, const Scene& scene, const PixelPlace& at,
                            const Pixels& picture, OutputFiles& outputs) {
    const auto& [source, target, region, parallel] = scene;
    Pixels exact = target;
    Stopwatch watch;
    {
        ProgressBar bar("Poisson");
        const auto solved = poisson_function(region, outline_differences(source, region, target, at),
                                             {.parallel = parallel, .progress = bar.callback()});
        if (!solved) throw Failure(given.region + ": " + solved.error().message);
        paste(source, region, at, *solved, exact);
    }
    const double seconds = watch.lap();
    if (!given.poisson.empty()) exact.write_png(outputs.add(given.poisson));
    const ColourDifference apart = colour_difference(picture, exact, region, at);
    return "Poisson: " + detail::short_number(seconds) + " s a place; its colours differ by at most " +
           std::to_string(apart.largest) + ", in the mean by " + detail::short_number(apart.mean) +
           ", of 255\n";
}

int clone_region(const Given& given) {
    Scene scene{value_or_fail(read_png(given.source)), value_or_fail(read_png(given.target)), {}};
    scene.region = load_region(given.region, scene.source);
    const auto& [source, target, region, parallel] = scene;
    if (given.threads > 1) scene.parallel = cageform::ThreadedFor{unsigned(given.threads)};
    const std::vector<PixelPlace> way = way_of(given, region);
    check_places(given, region, target, way);
    fail_if(fault_of_outputs({given.out, given.pasted, given.poisson, given.film}));
    Stopwatch watch;
    auto membrane = Membrane::bind(region, {}, parallel);
    if (!membrane) return fail(given.region + ": " + membrane.error().message);
    const double set_up = watch.lap();

    OutputFiles outputs;
    const auto [picture, moves, shortest] = move_region(given, scene, *membrane, way, outputs);
    // The last place again, by the other methods.
    if (!given.pasted.empty()) {
        Pixels pasted = target;
        paste(source, region, way.back(), std::vector<Membrane::Values>(region.kinds.size()), pasted);
        pasted.write_png(outputs.add(given.pasted));
    }
    std::string compared;
    if (!given.poisson.empty() || given.report)
        compared = compare_poisson(given, scene, way.back(), picture, outputs);
    fail_if(outputs.commit());

    std::cout << region.inside << " pixels inside, " << region.outline.size() << " on the outline, "
              << way.size() << (way.size() == 1 ? " place\n" : " places\n");
    if (given.report) {
        const MembraneReport& made = membrane->report();
        std::cout << made.loops << (made.loops == 1 ? " loop of " : " loops of ") << made.vertices
                  << " vertices, " << made.points << " points with "
                  << detail::short_number(double(made.weights) /
                                          double(std::max<std::size_t>(made.points, 1)))
                  << " weights each\nset-up: " << detail::short_number(set_up)
                  << " s; a move: " << detail::short_number(1e3 * moves / double(way.size()))
                  << " ms, at least " << detail::short_number(1e3 * shortest)
                  << " ms; threads: " << given.threads << '\n';
    }
    std::cout << compared;
    return 0;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Puts a region of one picture into another without a seam, by mean value coordinates.");
    line.set_examples(
        {"--make .", "noon.png evening.png --region boat.svg -o boat.png",
         "noon.png evening.png --region boat.svg --at 40,60 -o boat.png --poisson exact.png --report",
         "noon.png evening.png --region boat.svg --at 0,60 --at 280,60 --steps 40 --gif boat.gif"});
    Given given;
    CommandOption source = line.add("source", given.source, "the PNG file that contains the region");
    line.add("target", given.target, "the PNG file into which the region is cloned");
    line.add("--region", given.region,
             "the region, in pixels of the source: a PNG mask of equal size, light inside; the first closed "
             "outline of an SVG; or loops of a CSV file");
    line.add_text(
            "--at", [&](const std::string& text) { given.places.push_back(*parse_place(text)); },
            "X,Y: the pixel of the target for the upper left corner of the region's box; can be repeated; by "
            "default the pixel in the source")
        .check([](const std::string& text) {
            return parse_place(text) ? "" : "\"" + text + "\" is not a pixel X,Y, two whole numbers";
        })
        .in_order();
    line.add("--steps", given.steps, "the number of places from each --at to the next")
        .range(1, 1000)
        .show_default();
    line.add("-o,--output", given.out,
             "the PNG file to write; several places make a strip of frames, each at most 480 pixels wide")
        .ends_with({".png"});
    line.add("--frames", given.frames, "also write the frames to files with this prefix: 01.png, 02.png, …");
    line.add("--gif", given.film, "also write a GIF of the frames, if ffmpeg is installed")
        .ends_with({".gif"});
    line.add("--poisson", given.poisson,
             "also write the exact solution of the Poisson equation, at the last place")
        .ends_with({".png"});
    line.add("--pasted", given.pasted, "also write the region as it is, with its seam, at the last place")
        .ends_with({".png"});
    line.add_flag("--report", given.report,
                  "print the times and the differences from the solution of the Poisson equation");
    line.add("--threads", given.threads, "the number of threads").range(1, 256).show_default();
    CommandOption make =
        line.add("--make", given.folder, "make two pictures and an outline in this folder instead");
    line.add("--size", given.size, "the width of these pictures in pixels").range(32, 8192).show_default();
    line.set_footer(
        "The outline's pixels belong to the region, and keep the colours of the target. Inside, the "
        "target's\n"
        "alpha is kept, and the target is visible where the source is translucent. PNG files of 16 bits are\n"
        "read with 8.\n");
    make.excludes(source);
    if (const auto code = line.parse(argc, argv)) return *code;
    if (!given.folder.empty()) return make_pictures(given);
    if (given.source.empty() || given.target.empty())
        return fail("give a source and a target, two PNG files; --make FOLDER makes a pair");
    if (given.region.empty()) return fail("--region is required: a mask, or an outline");
    if (given.out.empty() && given.frames.empty() && given.film.empty())
        return fail("nothing to write: give -o, --frames or --gif");
    return clone_region(given);
}

// Animates an SVG figure by a cage and a motion of the cage.
//
//     animate_svg cat.svg --cage cat_cage.svg --clip cat_walk.csv --coordinates harmonic -o walk.svg
//     animate_svg cat.svg --cage auto --turn 6-9:-20@v5,10 -o wag.svg
//     animate_svg cat.svg --cage cat_cage.svg --markers cat_markers.csv --coordinates harmonic -o walk.svg
//
// The figure is bound once. Each frame samples the clip and clones the figure. The SVG file plays in a
// browser. A frame is equal to the output of deform_svg for its pose; all frames have the same segments, as
// SVG requires. --help-all describes clip files.

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/figure_motion.hpp"
#include "cli/pinned_figure.hpp"
#include "cli/pose_choice.hpp"
#include "cli/progress_bar.hpp"
#include "files/cage_file.hpp"
#include "files/clip_file.hpp"
#include "files/marker_file.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"
#include "pictures/render.hpp"
#include "pictures/text.hpp"

#include <cageform/parallel/threads.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <iostream>

namespace {

using namespace cageform_support;

/// A line with tufts of grass that repeat every `period` units. It begins `period` left of the view.
pugi::xml_node draw_ground(SvgDocument& document, double y, double period) {
    const auto view = view_box(document);
    const double left = view.x - period, right = view.x + view.width, step = period / 4;
    auto root = detail::root_element(document.xml);
    auto group = root.prepend_child((detail::name_prefix(root) + "g").c_str());
    group.append_attribute("fill") = "none";
    group.append_attribute("stroke") = "#7c8f4e";
    group.append_attribute("stroke-width") = 4;
    group.append_attribute("stroke-linecap") = "round";
    Path path{{{left, y}, {{{left, y}, {right, y}, {right, y}, 1}}, false}};
    constexpr std::array<double, 4> heights{16, 9, 13, 6};
    for (std::size_t i = 0; left + double(i) * step < right; ++i) {
        const double x = left + (double(i) + 0.5) * step, height = heights[i % 4];
        for (const double lean : {-0.5, 0.1, 0.6}) {
            const Point2 tip{x + lean * height, y + 6 - height};
            path.push_back({{x + 8 * lean, y + 6}, {{tip, tip, tip, 1}}, false});
        }
    }
    group.append_child((detail::name_prefix(root) + "path").c_str()).append_attribute("d") =
        write_path_data(path, 1).c_str();
    return group;
}

struct Settings {
    std::string figure, cage, clip, pose, out, stills; // clip: the name of the motion in messages
    std::string markers, save_clip, save_tracks;
    std::vector<Point2> tracked; // --track
    PoseChoice operations;
    PinChoice pins;
    bool report = false;
    double seconds = 2;
    std::size_t size_limit = 0; // maximum bytes of the SVG; 0: no limit
    std::vector<std::string> films;
    std::size_t width = 800; // of films
    double rate = 0;         // 0: the default of the output format
    std::size_t still_count = 12;
    bool text_as_paths = false;
    CoordinatesChoice choice;
    OutsideChoice outside;
    std::size_t threads = 0;
    DeformOptions options;
};

std::size_t still_count_of(const Settings& settings) {
    return settings.stills.empty() ? 0 : settings.still_count;
}

std::string still_path(const Settings& settings, std::size_t n) {
    return settings.stills + (n < 9 ? "0" : "") + std::to_string(n + 1) + ".svg";
}

/// Makes a motion from rest to a pose and back, with every vertex on a straight line.
ClipFile clip_to(const CageFile& pose, const CageFile& cage, double seconds) {
    ClipFile clip{pose.name == cage.name ? "the pose" : pose.name, seconds, {}, {}, {}};
    constexpr auto ease = cageform::KeyKind::bezier;
    for (std::size_t i = 0; i < cage.vertices.size(); ++i) {
        const Point2 &rest = cage.vertices[i], &there = pose.vertices[i];
        clip.controls.push_back({"vertex " + std::to_string(i),
                                 {{i, 1}},
                                 rest,
                                 {{0, {}, ease},
                                  {seconds / 2, {there.x - rest.x, there.y - rest.y, 0}, ease},
                                  {seconds, {}, ease}}});
    }
    return clip;
}

ClipFile read_clip(const Settings& settings, const CageFile& cage) {
    if (!settings.markers.empty()) return value_or_fail(load_markers(settings.markers));
    if (settings.pins.is_given()) return motion_to(value_or_fail(settings.pins.pins<2>()), settings.seconds);
    if (!settings.clip.empty()) {
        const auto held = settings.operations.still(cage.lattice);
        ClipFile clip = value_or_fail(load_clip(settings.clip, cage.vertices.size()));
        for (ClipControl& control : clip.controls) {
            std::erase_if(control.shares, [&](const auto& share) {
                return std::find(held.begin(), held.end(), share.vertex) != held.end();
            });
        }
        return clip;
    }
    const bool is_made = CageChoice::of(settings.cage).is_auto;
    return clip_to(read_pose(settings.pose, settings.operations, cage, is_made), cage, settings.seconds);
}

/// The keys of all handles, and their rest positions.
struct HandleKeys {
    ClipFile file;
    std::vector<Point2> rest;
};

/// Converts a motion of pins to keys of the cage. Other motions are used unchanged.
HandleKeys keys_of(const Settings& settings, const CageFile& cage, const ClipFile& motion,
                   FigureControl& control) {
    if (!motion.has_pins()) {
        if (!settings.pins.held.empty()) throw Failure("--hold is for pins, and the motion has none");
        return {motion, cage.vertices};
    }
    const auto still = settings.operations.still(cage.lattice);
    const auto places = cage.places();
    const std::size_t count = cage.lattice ? cage.lattice->points() : places.size();
    auto held = settings.pins.held_handles(std::span(places).first(count), still);
    auto figure = value_or_fail(PinnedFigure::make(
        control, {settings.choice, settings.pins, settings.outside, cage.vertices, std::move(held)},
        pins_of(motion)));
    auto keys = value_or_fail(figure.keys_of(motion));
    if (settings.report) {
        std::cout << figure.cage().report() << "keys: " << keys.controls.front().rows.size()
                  << " of every vertex\n";
    }
    warn(figure.cage().warning());
    if (!settings.save_clip.empty() && control.poses_all_handles)
        throw Failure("--save-clip " + settings.save_clip +
                      ": with these coordinates pins also pose edges, which a clip cannot store; use "
                      "mean-value or harmonic");
    return {std::move(keys), figure.rest()};
}

/// Writes the positions of figure points in every frame; the last row repeats the first.
std::string tracks_of(const Settings& settings, const FigureControl& control, const ClipFile& file) {
    Tracks tracks{settings.tracked, {}, {}};
    tracks.places = move_points(tracks.rest, settings.figure, control, settings.outside);
    tracks.places.push_back(tracks.places.front());
    for (std::size_t f = 0; f <= control.frames; ++f)
        tracks.times.push_back(file.length * double(f) / double(control.frames));
    return markers_text(tracks, file, "Points of a figure through its motion");
}

/// An animation as a file.
struct PlayedFile {
    std::string text;
    std::size_t keys = 0;
    double tolerance = 0;
};

/// Encodes key frames within `tolerance`, which is doubled until the file is within the size limit.
///
///   most    the largest tolerance to try
///   fails   if the file is larger even then
PlayedFile played_file(AnimatedSvg& drawing, const Settings& settings, double seconds, double tolerance,
                       double most) {
    PlayedFile file;
    for (file.tolerance = tolerance;; file.tolerance *= 2) {
        file.keys = drawing.play(seconds, file.tolerance);
        file.text = to_text(drawing.document);
        if (settings.size_limit == 0 || file.text.size() <= settings.size_limit) return file;
        if (2 * file.tolerance > most)
            throw Failure(settings.out + ": has " + std::to_string(file.text.size()) +
                          " bytes with key frames within " + detail::short_number(file.tolerance) +
                          " units, more than --size-limit " + std::to_string(settings.size_limit));
    }
}

/// Returns the conflict between options; empty if there is none.
std::string fault_of(const Settings& settings) {
    const bool has_operations = !settings.operations.operations.empty();
    if (!settings.clip.empty() && has_operations)
        return "give --clip or operations such as --turn, but not both";
    const int motions = int(!settings.clip.empty()) + int(!settings.markers.empty()) +
                        int(settings.pins.is_given()) + int(!settings.pose.empty() || has_operations);
    if (motions > 1) return "give only one of --clip, --markers, pins, and a pose";
    if (settings.size_limit != 0 && lowercase_extension(settings.out) != ".svg")
        return "--size-limit is for SVG files";
    if (settings.save_tracks.empty() != settings.tracked.empty())
        return "--track and --save-tracks need each other";
    return {};
}

/// The number of frames of a clip, and the distance that its ground moves.
struct Plan {
    std::size_t frames = 0;
    double passed = 0; // how far the ground moves during the clip
};

Plan plan_of(const Settings& settings, const ClipFile& file, const ViewBox& view) {
    const double frames = std::max(1.0, std::round(file.length * settings.rate));
    const double most = settings.films.empty() ? 1e5 : 3600;
    if (!(frames <= most))
        throw Failure(settings.clip + ": its length needs " + detail::short_number(frames) + " frames; " +
                      (settings.films.empty() ? "at most " : "a film has at most ") +
                      std::to_string(int(most)) + "; a smaller --rate needs fewer");
    const double passed = file.ground ? file.ground->speed * file.length : 0;
    if (passed != 0 && !(std::fabs(passed) >= 1e-3 * view.width && std::fabs(passed) <= 1e3 * view.width))
        throw Failure(settings.clip + ": during the clip the ground moves by " +
                      detail::short_number(passed) +
                      " units; allowed are 0.001 to 1000 times the picture's width");
    return {std::size_t(frames), passed};
}

/// The vertices of the cage in all frames. Each delayed layer has its own player, so every player moves
/// forward one frame at a time.
std::vector<std::vector<Point2>> poses_of(const cageform::CageClip<double, 2>& clip, const ClipFile& file,
                                          std::size_t frames, std::size_t vertices) {
    std::vector<std::vector<Point2>> poses;
    std::vector<cageform::Vec<double, 2>> pose(vertices);
    for (std::size_t layer = 0; layer <= file.late.size(); ++layer) {
        auto cursor = clip.make_cursor();
        const double late = layer == 0 ? 0 : file.late[layer - 1].seconds;
        for (std::size_t f = 0; f < frames; ++f) {
            clip.sample(double(f) * file.length / double(frames) - late, cursor, pose);
            auto& points = poses.emplace_back();
            for (const auto& p : pose) points.push_back({p[0], p[1]});
        }
    }
    return poses;
}

/// Fails before the computation if a file cannot be written.
void check_outputs(const Settings& settings) {
    std::vector<std::filesystem::path> outputs(settings.films.begin(), settings.films.end());
    for (const std::string& path : {settings.out, settings.save_clip, settings.save_tracks})
        outputs.emplace_back(path);
    for (std::size_t n = 0; n < still_count_of(settings); ++n) outputs.emplace_back(still_path(settings, n));
    fail_if(fault_of_outputs(outputs));
}

/// The figure in all frames, and the ground below it.
class Play {
public:
    Play(const Settings& settings, const ClipFile& file, const Plan& plan, AnimatedSvg& drawing,
         const ViewBox& view)
        : settings_(settings)
        , file_(file)
        , plan_(plan)
        , drawing_(drawing)
        , diagonal_(std::hypot(view.width, view.height)) {
        const double period = plan.passed != 0 ? std::fabs(plan.passed) : view.width / 8;
        if (file.ground) ground_ = draw_ground(drawing.document, file.ground->y, period);
    }

    void write_stills(OutputFiles& outputs) {
        const std::size_t stills = still_count_of(settings_);
        for (std::size_t n = 0; n < stills; ++n)
            outputs.add(still_path(settings_, n)).write(text_of_frame(n * plan_.frames / stills));
    }

    void write_films(OutputFiles& outputs) {
        if (settings_.films.empty()) return;
        ProgressBar bar("frames");
        const auto tell = bar.callback();
        std::deque<Film> films;
        for (const std::string& path : settings_.films)
            films.emplace_back(outputs, path, double(plan_.frames) / file_.length, int(settings_.width));
        for (std::size_t f = 0; f < plan_.frames && !outputs.error(); ++f) {
            const std::string text = text_of_frame(f);
            for (Film& film : films) film.add_frame(text);
            if (tell) tell(double(f + 1) / double(plan_.frames));
        }
        for (Film& film : films) film.finish();
        fail_if(outputs.error());
    }

    /// Writes the animation and returns its size for the report. Stills and films use absolute positions, so
    /// they come first.
    std::string write_animation(OutputFiles& outputs, double tolerance) {
        drawing_.show(0);
        if (ground_) {
            ground_.remove_attribute("transform");
            AnimatedSvg::append_animation(ground_, "transform", "translate", file_.length,
                                          "0 0;" + format_number(plan_.passed, 2) + " 0");
        }
        const auto played = played_file(drawing_, settings_, file_.length, tolerance, 0.02 * diagonal_);
        outputs.add(settings_.out).write(played.text);
        return ", " + std::to_string(played.text.size()) + " bytes, " + std::to_string(played.keys) +
               " key frames of attributes, within " + detail::short_number(played.tolerance) + " units";
    }

private:
    std::string text_of_frame(std::size_t f) {
        drawing_.show(f);
        if (ground_) {
            const double x = plan_.passed * double(f) / double(plan_.frames);
            detail::set_attribute(ground_, "transform", "translate(" + format_number(x, 2) + ')');
        }
        return to_text(drawing_.document);
    }

    const Settings& settings_;
    const ClipFile& file_;
    const Plan& plan_;
    AnimatedSvg& drawing_;
    double diagonal_; // of the view
    pugi::xml_node ground_;
};

int animate(const Settings& settings, const SvgDocument& document, const CageFile& cage,
            const ClipFile& file) {
    const auto view = view_box(document);
    const Plan plan = plan_of(settings, file, view);
    check_outputs(settings);
    FigureControl control = control_of(settings.choice, cage);
    control.pose_name = settings.clip;
    control.frames = plan.frames;
    const HandleKeys keys = keys_of(settings, cage, file, control);
    const auto clip = value_or_fail(make_clip(keys.file, keys.rest));
    control.poses = poses_of(clip, file, plan.frames, keys.rest.size());
    DeformOptions options = settings.options;
    for (const ClipFile::Late& late : file.late) options.layers.push_back(late.element);
    if (options.tolerance == 0) options.tolerance = 2e-4 * std::hypot(view.width, view.height);
    auto moved = move_figure(document, settings.figure, control, settings.outside, options,
                             cageform::ThreadedFor{unsigned(settings.threads)});
    warn(pose_faults(control, cage));

    Play play(settings, file, plan, moved.drawing, view);
    OutputFiles outputs;
    play.write_stills(outputs);
    play.write_films(outputs);
    const std::string size = settings.out.empty() ? "" : play.write_animation(outputs, options.tolerance);
    if (!settings.save_clip.empty())
        outputs.add(settings.save_clip)
            .write(clip_text(keys.file, "A motion of the cage, by keys of its vertices"));
    if (!settings.save_tracks.empty())
        outputs.add(settings.save_tracks).write(tracks_of(settings, control, file));
    fail_if(outputs.commit());
    std::cout << printable(settings.out.empty() ? settings.films.front() : settings.out) << ": "
              << plan.frames << " frames of " << file.length << " s, " << moved.drawing.report.segments
              << " segments, " << moved.drawing.report.points << " points bound, clip of " << clip.bytes()
              << " bytes" << size << '\n';
    return 0;
}

void add_motion(CommandLine& line, Settings& settings) {
    const CommandOption clip =
        line.add("--clip", settings.clip, "its motion: a CSV file of keys of the cage or of pins");
    line.add("--markers", settings.markers,
             "its motion: a CSV file of tracked points of the figure, for example from motion capture");
    line.add("--pose", settings.pose,
             "instead of --clip: move to this pose and back, or give operations such as --turn. With --cage "
             "auto and none of these, half the figure bends and returns")
        .excludes(clip);
    settings.operations.in_plane = true;
    settings.operations.add_options(line);
    settings.pins.add_options(line);
    line.add("--seconds", settings.seconds, "the duration of the motion to the pose and back")
        .range(0.01, 1000.0)
        .show_default()
        .excludes(clip);
}

void add_animation(CommandLine& line, Settings& settings) {
    line.add("-o,--output", settings.out,
             "the file to write: an SVG that browsers play, or, if ffmpeg is installed, a GIF, an animated "
             "PNG or a video")
        .required()
        .ends_with({".svg", ".gif", ".apng", ".png", ".mp4"});
    line.add("--rate", settings.rate,
             "the frames per second; a browser interpolates linearly between them; 0 means 60, or 25 if all "
             "outputs are films")
        .check([](const std::string& text) {
            const double rate = std::strtod(text.c_str(), nullptr);
            return rate == 0 || (rate >= 1 && rate <= 240) ? "" : text + " is neither 0 nor from 1 to 240";
        })
        .show_default();
    line.add("--flatness", settings.options.tolerance,
             "the largest error in user units, of drawn curves and of frames between key frames; 0 means "
             "1/5000 of the picture's diagonal")
        .range(0.0, 1e100)
        .show_default();
    line.add("--size-limit", settings.size_limit,
             "the maximum size of an SVG in bytes: the error is doubled until the file fits, up to 1/50 of "
             "the diagonal, and printed")
        .range(1, 1000000000);
    line.add_flag("--fit", settings.options.fit,
                  "enlarge the viewBox and the size of the picture so that all frames fit");
    add_text_as_paths(line, settings.text_as_paths);
}

void add_further_files(CommandLine& line, Settings& settings) {
    line.add("--stills", settings.stills, "also write frames to files with this prefix: 01.svg, 02.svg, …");
    line.add("--still-count", settings.still_count, "the number of these frames, equally spaced")
        .range(1, 99)
        .show_default();
    line.add("--save-clip", settings.save_clip, "also write the keys of the cage to a file that --clip reads")
        .ends_with({".csv"});
    line.add_text(
            "--track",
            [&settings](const std::string& word) {
                std::array<double, 2> p{};
                detail::parse_point(word, p);
                settings.tracked.push_back({p[0], p[1]});
            },
            "a point x,y of the figure for --save-tracks; one for each --track")
        .check([](const std::string& word) {
            std::array<double, 2> p{};
            const std::string why = detail::parse_point(word, p);
            return !why.empty() || (std::isfinite(p[0]) && std::isfinite(p[1])) ? why
                                                                                : word + " is not finite";
        })
        .in_order()
        .rarely_needed();
    line.add("--save-tracks", settings.save_tracks,
             "also write the tracks of these points to a file that --markers reads")
        .ends_with({".csv"})
        .rarely_needed();
    line.add_flag("--report", settings.report, "print the errors of pins");
    const auto add_film = [&](const std::string& name, const std::string& help,
                              const std::vector<std::string>& endings) {
        line.add_text(
                "--" + name, [&settings](const std::string& path) { settings.films.push_back(path); },
                "also write " + help + ", if ffmpeg is installed")
            .ends_with(endings);
    };
    add_film("gif", "a GIF of the frames", {".gif"});
    add_film("apng", "an animated PNG", {".png", ".apng"});
    add_film("mp4", "a video", {".mp4"});
    line.add("--width", settings.width, "the width of films, in pixels").range(16, 8192).show_default();
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Animates an SVG figure by a moving cage.");
    line.set_examples({"cat.svg --cage auto --turn 6-9:-20@v5,10 -o wag.svg",
                       "cat.svg --cage cat_cage.svg --clip cat_walk.csv -o walk.gif --fit"});
    Settings settings;
    line.add("figure", settings.figure, "the SVG file to animate").required();
    add_cage(line, settings.cage, CageFiles::drawing);
    add_motion(line, settings);
    add_animation(line, settings);
    add_further_files(line, settings);
    settings.outside.add_options(line);
    add_threads(line, settings.threads);
    settings.choice.in_plane = settings.choice.with_normals = true;
    settings.choice.add_options(line);
    line.set_footer(cage_formats + std::string("\n") + lattice_format + "\n" + pose_operations_format + "\n" +
                    pins_format + "\n" + clip_format + "\n" + markers_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    fail_if(fault_of(settings));
    fail_if(settings.outside.fault());
    if (lowercase_extension(settings.out) != ".svg") {
        settings.films.insert(settings.films.begin(), settings.out);
        settings.out.clear();
    }
    if (settings.rate == 0) settings.rate = settings.out.empty() ? 25 : 60;
    const auto document = value_or_fail(load_figure(settings.figure, settings.text_as_paths));
    settings.outside.cage_is_made = CageChoice::of(settings.cage).is_auto;
    const bool is_first_look = settings.clip.empty() && settings.markers.empty() &&
                               !settings.pins.is_given() && settings.pose.empty() &&
                               settings.operations.operations.empty();
    settings.options.fit = settings.options.fit || is_first_look;
    const auto cage = load_or_make_cage(settings.cage, document, settings.choice.edges());
    const ClipFile file = read_clip(settings, cage);
    settings.clip = file.name;
    return animate(settings, document, cage, file);
}

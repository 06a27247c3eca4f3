// Animates any SVG figure by a cage and a motion of it.
//
//     animate_svg cat.svg --cage cat_cage.svg --clip cat_walk.csv --coordinates harmonic -o walk.svg
//     animate_svg cat.svg --cage auto --turn 6-9:-20@v5,10 -o wag.svg
//
// The figure is bound once. Every frame samples the clip and clones; what is written plays in a browser.
// Curves and long lines are refined so that they follow the shape in all frames, in the same pieces in every
// frame, as SVG asks. --help tells what a clip file holds.

#include "atomic_file.hpp"
#include "auto_cage.hpp"
#include "bind_report.hpp"
#include "cage_file.hpp"
#include "clip_file.hpp"
#include "command_line.hpp"
#include "coordinates.hpp"
#include "csv.hpp"
#include "guard.hpp"
#include "pose_choice.hpp"
#include "progress_bar.hpp"
#include "render.hpp"
#include "svg_paint.hpp"

#include <cageform/clone/clone.hpp>

#include <array>
#include <iostream>
#include <iterator>
#include <numbers>
#include <optional>
#include <utility>

namespace {

using namespace cageform_examples;

/// A shape's segments at equal steps of their parameters, in all frames.
struct MovedShape {
    static constexpr std::size_t steps = 24; // of a segment
    detail::DrawnShape drawn;
    std::size_t layer = 0; // 0, or that of ClipFile::late before which it is counted
    std::size_t first = 0; // among all points
};

Point2 point_on(const Point2& a, const Segment& s, double t) {
    const double u = 1 - t, b0 = u * u * u, b1 = 3 * u * u * t, b2 = 3 * u * t * t, b3 = t * t * t;
    return {b0 * a.x + b1 * s.p1.x + b2 * s.p2.x + b3 * s.p3.x,
            b0 * a.y + b1 * s.p1.y + b2 * s.p2.y + b3 * s.p3.y};
}

/// The cubic through samples 0, 1/3, 2/3 and 1 of these, or the line from the first to the last.
Segment segment_through(std::span<const Point2> p, bool line) {
    const std::size_t n = p.size() - 1;
    const Point2 a = p[0], b = p[n / 3], c = p[2 * n / 3], d = p[n];
    if (line)
        return {
            {(2 * a.x + d.x) / 3, (2 * a.y + d.y) / 3}, {(a.x + 2 * d.x) / 3, (a.y + 2 * d.y) / 3}, d, true};
    return {{(-5 * a.x + 18 * b.x - 9 * c.x + 2 * d.x) / 6, (-5 * a.y + 18 * b.y - 9 * c.y + 2 * d.y) / 6},
            {(2 * a.x - 9 * b.x + 18 * c.x - 5 * d.x) / 6, (2 * a.y - 9 * b.y + 18 * c.y - 5 * d.y) / 6},
            d,
            false};
}

/// How far samples lie from a segment through them, at most. For lines, at any place of the line.
double miss_of(std::span<const Point2> p, bool line) {
    const Segment s = segment_through(p, line);
    const double dx = p.back().x - p[0].x, dy = p.back().y - p[0].y, square = dx * dx + dy * dy;
    double most = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
        double t = double(i) / double(p.size() - 1);
        if (line && square > 0)
            t = std::clamp(((p[i].x - p[0].x) * dx + (p[i].y - p[0].y) * dy) / square, 0.0, 1.0);
        const Point2 q = point_on(p[0], s, t);
        most = std::max(most, std::hypot(q.x - p[i].x, q.y - p[i].y));
    }
    return most;
}

/// A segment, or a part of one, that is written as one.
struct Part {
    std::size_t first = 0, steps = 0; // among all points
    bool line = false;
};

using Frames = std::vector<std::vector<Point2>>; // every point in every frame

/// Halves a segment until a line or a cubic is within the tolerance in every frame.
void split(const Frames& frames, std::size_t first, std::size_t steps, bool was_line, double tolerance,
           std::vector<Part>& parts) {
    const auto fits = [&](bool line) {
        return std::all_of(frames.begin(), frames.end(), [&](const std::vector<Point2>& points) {
            return miss_of(std::span(points).subspan(first, steps + 1), line) <= tolerance;
        });
    };
    if (was_line && fits(true)) {
        parts.push_back({first, steps, true});
    } else if (steps == 3 || fits(false)) {
        parts.push_back({first, steps, false});
    } else {
        split(frames, first, steps / 2, was_line, tolerance, parts);
        split(frames, first + steps / 2, steps / 2, was_line, tolerance, parts);
    }
}

/// A line with tufts of grass, which repeat every `period` units; begins `period` before the view.
pugi::xml_node draw_ground(SvgDocument& document, double y, double period) {
    const auto view = view_box(document);
    const double left = view->x - period, right = view->x + view->width, step = period / 4;
    auto root = detail::root_element(document.xml);
    auto group = root.prepend_child((detail::name_prefix(root) + "g").c_str());
    group.append_attribute("fill") = "none";
    group.append_attribute("stroke") = "#7c8f4e";
    group.append_attribute("stroke-width") = 4;
    group.append_attribute("stroke-linecap") = "round";
    Path path{{{left, y}, {{{left, y}, {right, y}, {right, y}, true}}, false}};
    constexpr std::array<double, 4> heights{16, 9, 13, 6};
    for (std::size_t i = 0; left + double(i) * step < right; ++i) {
        const double x = left + (double(i) + 0.5) * step, height = heights[i % 4];
        for (const double lean : {-0.5, 0.1, 0.6}) {
            const Point2 tip{x + lean * height, y + 6 - height};
            path.push_back({{x + 8 * lean, y + 6}, {{tip, tip, tip, true}}, false});
        }
    }
    group.append_child((detail::name_prefix(root) + "path").c_str()).append_attribute("d") =
        write_path_data(path, 1).c_str();
    return group;
}

/// A gradient of one shape, and its gradientTransform in all frames.
struct MovedGradient {
    std::size_t shape = 0;
    detail::PaintServer gradient;
    std::vector<Affine2> transforms;
};

/// The best affine map of a shape's points in a frame.
std::optional<Affine2> best_map(std::span<const Point2> rest, std::span<const Point2> moved,
                                const Path& path) {
    detail::Motion motion;
    std::size_t i = 0;
    for (const Subpath& subpath : path) {
        motion.add(rest[i], moved[i], 0); // a start stands for no length
        for (std::size_t n = subpath.segments.size() * MovedShape::steps; n > 0; --n) {
            ++i;
            motion.add(rest[i], moved[i], std::hypot(rest[i].x - rest[i - 1].x, rest[i].y - rest[i - 1].y));
        }
        ++i;
    }
    return motion.best_map();
}

/// The four animations whose product is a map: SVG animates no matrix. Each is a type and its values.
std::array<std::pair<const char*, std::string>, 4> animated_parts(const std::vector<Affine2>& maps) {
    std::array<std::pair<const char*, std::string>, 4> parts{
        {{"translate", {}}, {"rotate", {}}, {"skewX", {}}, {"scale", {}}}};
    constexpr double degree = std::numbers::pi / 180;
    double turn = 0;
    const auto put = [&](const Affine2& m) {
        const double before = turn;
        turn = std::atan2(m.b, m.a);
        turn +=
            2 * std::numbers::pi * std::round((before - turn) / (2 * std::numbers::pi)); // the shorter way
        const double along = m.c * std::cos(turn) + m.d * std::sin(turn);
        const double across = -m.c * std::sin(turn) + m.d * std::cos(turn);
        const double lean = std::atan(along / across);
        const auto pair = [](double x, double y) {
            return format_number(x, 5) + ' ' + format_number(y, 5) + ';';
        };
        parts[0].second += pair(m.e, m.f);
        parts[1].second += format_number(turn / degree, 4) + ';';
        parts[2].second += format_number(lean / degree, 4) + ';';
        parts[3].second += pair(std::hypot(m.a, m.b), across);
    };
    for (const Affine2& m : maps) put(m);
    put(maps.front()); // ends as it begins
    for (auto& [type, values] : parts) values.pop_back();
    return parts;
}

struct Settings {
    std::string figure, cage, clip, pose, out, stills; // clip: its name for messages, whatever it comes from
    PoseChoice operations;
    double seconds = 2;
    std::vector<std::string> films;
    std::size_t width = 800; // of films
    double rate = 60, tolerance = 0.2;
    std::size_t still_count = 12;
    int decimals = 1;
    CoordinatesChoice choice;
    OutsideChoice outside;
};

/// From rest to a pose and back, every vertex on a straight line.
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

SvgResult<ClipFile> read_clip(const Settings& settings, const CageFile& cage) {
    if (!settings.clip.empty()) return load_clip(settings.clip, cage.vertices.size());
    const auto pose =
        read_pose(settings.pose, settings.operations, cage, CageWord::of(settings.cage).is_auto);
    if (!pose) return pose.error();
    return clip_to(*pose, cage, settings.seconds);
}

int animate(const Settings& settings, const SvgDocument& document, const CageFile& cage,
            const ClipFile& file) {
    const double frame_count = std::max(1.0, std::round(file.length * settings.rate));
    constexpr double most_frames = 1e5;
    if (!(frame_count <= most_frames))
        return fail(settings.clip + ": its length takes " + detail::short_number(frame_count) +
                    " frames; 100000 at most, a smaller --rate takes fewer");
    if (!settings.films.empty() && frame_count > 3600)
        return fail(settings.clip + ": its length takes " + detail::short_number(frame_count) +
                    " frames; a film has 3600 at most, a smaller --rate takes fewer");
    const double passed = file.ground ? file.ground->speed * file.length : 0;
    const auto view = view_box(document);
    if (file.ground && !view) return fail(to_string(view.error()));
    if (passed != 0 && !(std::fabs(passed) >= 1e-3 * view->width && std::fabs(passed) <= 1e3 * view->width))
        return fail(settings.clip + ": in the clip's length the ground passes by " +
                    detail::short_number(passed) +
                    " units; from a thousandth to a thousand times the picture's width is drawn");
    const auto clip = make_clip(file, cage.vertices);
    if (!clip) return fail(to_string(clip.error()));

    // The figure's shapes, and points along them.
    SvgDocument work = detail::copy_of(document);
    std::vector<std::string> warnings;
    detail::adapt_style_sheets(work, warnings);
    auto all = detail::drawn_shapes(work, warnings);
    if (!all) return fail(to_string(all.error()));
    print_warnings(warnings);
    std::vector<MovedShape> shapes;
    std::vector<Point2> points;
    for (detail::DrawnShape& drawn : *all) {
        MovedShape shape{std::move(drawn), 0, points.size()};
        for (pugi::xml_node up = shape.drawn.node; up; up = up.parent()) {
            for (std::size_t n = 0; n < file.late.size(); ++n) {
                if (up.attribute("id") && detail::attribute_text(up, "id") == file.late[n].element)
                    shape.layer = n + 1;
            }
        }
        for (const Subpath& subpath : shape.drawn.path) {
            Point2 from = subpath.start;
            points.push_back(from);
            for (const Segment& s : subpath.segments) {
                for (std::size_t k = 1; k <= MovedShape::steps; ++k)
                    points.push_back(point_on(from, s, double(k) / MovedShape::steps));
                from = s.p3;
            }
        }
        shapes.push_back(std::move(shape));
    }

    for (std::size_t n = 0; n < file.late.size(); ++n) {
        if (std::none_of(shapes.begin(), shapes.end(),
                         [&](const auto& shape) { return shape.layer == n + 1; }))
            return fail(settings.clip + ": the figure has no shape in \"" + file.late[n].element + '"');
    }

    const auto coordinates = make_coordinates<double>(settings.choice, cage);
    cageform::BindOptions bind_options;
    bind_options.outside = settings.outside.policy(*coordinates);
    const auto [binding, report] = coordinates->bind(points, bind_options);
    if (report.status != cageform::Status::ok) return fail(describe_faults(settings.cage, report));
    warn_of_coarse_grid(settings.cage, report.solver);
    const auto outside = settings.outside.judge(*coordinates, report, points, settings.figure, settings.cage);
    if (!outside.fault.empty()) return fail(outside.fault);
    if (!outside.warning.empty()) warn(outside.warning);

    // All frames. A late layer has a player of its own, so that every player goes forth a frame at a time.
    const auto count = std::size_t(frame_count);
    Frames frames(count, std::vector<Point2>(points.size()));
    std::vector<cageform::Vec<double, 2>> pose(cage.vertices.size());
    std::vector<Point2> moved(points.size());
    for (std::size_t layer = 0; layer <= file.late.size(); ++layer) {
        auto cursor = clip->make_cursor();
        const double late = layer == 0 ? 0 : file.late[layer - 1].seconds;
        for (std::size_t f = 0; f < count; ++f) {
            clip->sample(double(f) * file.length / double(count) - late, cursor, pose);
            CageFile posed = cage;
            for (std::size_t b = 0; b < posed.blocks.size(); ++b) {
                for (std::size_t k = 0; k < posed.handles[b].size(); ++k) {
                    const auto& p = pose[posed.handles[b][k]];
                    posed.blocks[b].points[k] = {p[0], p[1]};
                }
            }
            const auto sound = cageform::check(posed.polygon<double>());
            if (sound.status != cageform::Status::ok)
                return fail(settings.clip + ": frame " + std::to_string(f) + ": " +
                            cageform::to_string(sound.status));
            std::string warning;
            const auto handles =
                pose_of_handles(binding, pose, settings.clip + ": frame " + std::to_string(f), warning);
            if (!handles) return fail(to_string(handles.error()));
            if (!warning.empty()) warn(warning);
            const auto status = cageform::clone(binding, *handles, moved);
            if (status != cageform::Status::ok)
                return fail(settings.clip + ": " + cageform::to_string(status));
            for (const MovedShape& shape : shapes) {
                if (shape.layer != layer) continue;
                const std::size_t end = &shape == &shapes.back() ? points.size() : (&shape + 1)->first;
                for (std::size_t i = shape.first; i < end; ++i) frames[f][i] = moved[i];
            }
        }
    }

    const auto seconds = format_number(file.length, 6) + 's';
    const std::string prefix = detail::name_prefix(shapes.empty() ? work.xml : shapes[0].drawn.node);
    const auto play = [&](pugi::xml_node node, const char* element, const char* attribute,
                          const std::string& values, const char* type = "") {
        auto animation = node.append_child((prefix + element).c_str());
        animation.append_attribute("attributeName") = attribute;
        if (*type != 0) animation.append_attribute("type") = type;
        animation.append_attribute("dur") = seconds.c_str();
        animation.append_attribute("repeatCount") = "indefinite";
        animation.append_attribute("values") = values.c_str();
    };
    const std::size_t stills = settings.stills.empty() ? 0 : settings.still_count;
    std::vector<std::vector<std::string>> data(shapes.size()); // of every shape in every frame
    std::size_t segments = 0;
    const detail::StyleSheets styles(detail::root_element(work.xml));
    detail::IdTable ids(detail::root_element(work.xml));
    detail::PaintFollower paint(work, styles, ids, 0);
    std::vector<MovedGradient> gradients;
    for (std::size_t s = 0; s < shapes.size(); ++s) {
        std::vector<std::vector<Part>> parts; // of every subpath
        std::size_t first = shapes[s].first;
        for (const Subpath& subpath : shapes[s].drawn.path) {
            auto& of_subpath = parts.emplace_back();
            for (const Segment& segment : subpath.segments) {
                split(frames, first, MovedShape::steps, segment.is_line, settings.tolerance, of_subpath);
                first += MovedShape::steps;
            }
            ++first;
            segments += of_subpath.size();
        }
        std::vector<MovedGradient> own;
        for (const char* property : {"fill", "stroke"}) {
            if (shapes[s].drawn.clips) break; // what clips shows no paint
            auto gradient = paint.own_gradient(shapes[s].drawn, property);
            if (gradient) own.push_back({s, std::move(*gradient), {}});
        }
        for (const auto& at : frames) {
            Path path;
            std::size_t start = shapes[s].first;
            for (std::size_t k = 0; k < parts.size(); ++k) {
                const Subpath& was = shapes[s].drawn.path[k];
                Subpath subpath{at[start], {}, was.closed};
                for (const Part& part : parts[k])
                    subpath.segments.push_back(
                        segment_through(std::span(at).subspan(part.first, part.steps + 1), part.line));
                start += was.segments.size() * MovedShape::steps + 1;
                path.push_back(std::move(subpath));
            }
            const Path local = transformed(std::move(path), shapes[s].drawn.from_root);
            data[s].push_back(write_path_data(local, settings.decimals));
            if (own.empty()) continue;
            const detail::DrawnShape& drawn = shapes[s].drawn;
            const auto best = best_map(std::span(points).subspan(shapes[s].first),
                                       std::span(at).subspan(shapes[s].first), drawn.path);
            for (MovedGradient& g : own) {
                const Affine2 last = g.transforms.empty() ? g.gradient.transform : g.transforms.back();
                const Affine2 map =
                    compose(compose(drawn.from_root, best.value_or(Affine2())), drawn.to_root);
                const detail::Box rest = detail::bounds(drawn.path, drawn.from_root);
                const auto followed = detail::moved_gradient(g.gradient, map, rest, detail::bounds(local));
                g.transforms.push_back(best && followed ? *followed : last);
            }
        }
        std::move(own.begin(), own.end(), std::back_inserter(gradients));
        detail::write_shape(shapes[s].drawn.node, data[s][0]);
    }
    print_warnings(paint.warnings);

    pugi::xml_node ground;
    if (file.ground)
        ground =
            draw_ground(work, file.ground->y, std::fabs(passed) > 0 ? std::fabs(passed) : view->width / 8);
    const auto text_of_frame = [&](std::size_t f) {
        for (std::size_t s = 0; s < shapes.size(); ++s)
            detail::set_attribute(shapes[s].drawn.node, "d", data[s][f]);
        for (const MovedGradient& g : gradients)
            detail::set_attribute(g.gradient.chain.front(), "gradientTransform",
                                  detail::write_transform(g.transforms[f]));
        if (ground) {
            const double x = passed * double(f) / double(count);
            detail::set_attribute(ground, "transform", "translate(" + format_number(x, 2) + ')');
        }
        return to_text(work);
    };
    OutputFiles outputs;
    // Stills and films first, by their places; then what moves.
    for (std::size_t n = 0; n < stills; ++n) {
        const std::string path = settings.stills + (n < 9 ? "0" : "") + std::to_string(n + 1) + ".svg";
        outputs.add(path).write(text_of_frame(n * count / stills));
    }
    for (const std::string& path : settings.films) {
        ProgressBar bar(path);
        const auto tell = bar.callback();
        Film film(outputs, path, double(count) / file.length, int(settings.width));
        for (std::size_t f = 0; f < count && !outputs.error(); ++f) {
            film.add_frame(text_of_frame(f));
            if (tell) tell(double(f + 1) / double(count));
        }
        film.finish();
        if (const auto error = outputs.error()) return fail(*error);
    }
    if (ground) {
        ground.remove_attribute("transform");
        play(ground, "animateTransform", "transform", "0 0;" + format_number(passed, 2) + " 0", "translate");
    }
    for (const MovedGradient& g : gradients) {
        pugi::xml_node node = g.gradient.chain.front();
        detail::set_attribute(node, "gradientTransform", detail::write_transform(g.transforms[0]));
        for (const auto& [type, values] : animated_parts(g.transforms)) {
            play(node, "animateTransform", "gradientTransform", values, type);
            if (type != std::string_view("translate")) node.last_child().append_attribute("additive") = "sum";
        }
    }
    for (std::size_t s = 0; s < shapes.size(); ++s) {
        std::string values;
        for (const std::string& d : data[s]) values += d + ';';
        detail::set_attribute(shapes[s].drawn.node, "d", data[s][0]);
        play(shapes[s].drawn.node, "animate", "d", values + data[s][0]); // ends as it begins
    }
    outputs.add(settings.out).write(to_text(work));
    if (const auto error = outputs.commit()) return fail(*error);
    std::cout << printable(settings.out) << ": " << count << " frames of " << file.length << " s, "
              << segments << " segments, " << points.size() << " points bound, clip of " << clip->bytes()
              << " bytes\n";
    return 0;
}

int run_program(int argc, char** argv) {
    CommandLine line("Animates an SVG figure by a cage and a motion of it.");
    Settings settings;
    line.add("figure", settings.figure, "the SVG file to animate").required();
    line.add("--cage", settings.cage,
             "its cage: the first closed polygon of an SVG, or a CSV file of loops, chains and points" +
                 std::string(auto_cage_help))
        .required();
    CommandOption clip = line.add("--clip", settings.clip, "its motion: a CSV file of controls and keys");
    line.add("--pose", settings.pose,
             "instead of a motion: to this moved cage and back; or operations, or with --cage auto nothing: "
             "half the figure bends and returns")
        .excludes(clip);
    settings.operations.add_options(line);
    line.add("--seconds", settings.seconds, "to the pose and back")
        .range(0.01, 1000.0)
        .show_default()
        .excludes(clip);
    line.add("-o,--output", settings.out, "the SVG file to write").required().ends_with({".svg"});
    line.add("--rate", settings.rate, "frames a second written; a browser goes straight between them")
        .range(1.0, 240.0)
        .show_default();
    line.add("--flatness", settings.tolerance, "how far curves may miss the shape, in user units")
        .range(1e-6, 1e100)
        .show_default();
    line.add("--stills", settings.stills, "also write frames to files that begin so: 01.svg, 02.svg, …");
    line.add("--still-count", settings.still_count, "how many, equally far apart")
        .range(1, 99)
        .show_default();
    const auto add_film = [&](const std::string& name, const std::string& help,
                              const std::vector<std::string>& endings) {
        line.add_text(
                "--" + name, [&](const std::string& path) { settings.films.push_back(path); },
                "also write " + help + ", by ffmpeg where it is installed")
            .ends_with(endings);
    };
    add_film("gif", "a GIF of the frames", {".gif"});
    add_film("apng", "an animated PNG", {".png", ".apng"});
    add_film("mp4", "a video", {".mp4"});
    line.add("--width", settings.width, "of these, in pixels").range(16, 8192).show_default();
    settings.outside.add_option(line);
    settings.choice.in_plane = settings.choice.with_normals = true;
    settings.choice.add_options(line);
    line.set_footer(cage_formats + std::string("\n") + pose_operations_format + "\n" + clip_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    if (!settings.clip.empty() && !settings.operations.operations.empty())
        return fail("--clip, or operations such as --turn, but not both");
    const auto document = load_svg(settings.figure);
    if (!document) return fail(to_string(document.error()));
    const auto cage = load_or_make_cage(settings.cage, *document);
    if (!cage) return fail(to_string(cage.error()));
    const auto file = read_clip(settings, *cage);
    if (!file) return fail(to_string(file.error()));
    settings.clip = file->name;
    settings.cage = cage->name;
    return animate(settings, *document, *cage, *file);
}

} // namespace

int main(int argc, char** argv) {
    return guarded("animate_svg", [&] { return run_program(argc, argv); });
}

// Compares a cage of curves with an equivalent polygon.
//
//     leaf_cages leaf.svg --cage leaf_cage.svg --pose leaf_pose.svg -o leaf.svg --png --seconds
//
// The polygon has its vertices on the curves, at equal parameter steps, at rest and posed. Both cages deform
// the figure by Green coordinates. The picture shows both, at rest and posed, with their handles. The program
// prints numbers of handles, seconds, and the distance between the two figures.

#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/figure_motion.hpp"
#include "files/bind_report.hpp"
#include "io/messages.hpp"
#include "pictures/field_plot.hpp"
#include "pictures/render.hpp"
#include "svg/document.hpp"

#include <cageform/clone/clone.hpp>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace {

using namespace cageform_support;

struct Arguments {
    std::string figure, cage, pose, out;
    std::size_t vertices = 25;
    bool png = false, seconds = false;
};

/// The polygon with equally distributed vertices on the curves of a cage.
CageFile polygon_on(const CageFile& cage, std::size_t vertices) {
    std::vector<CageBlock> blocks;
    std::size_t edges = 0, edge = 0;
    for (const auto& degrees : cage.curves->degrees) edges += degrees.size();
    for (const Subpath& loop : cage.outline()) {
        CageBlock& block = blocks.emplace_back(CageBlock{CageBlock::Kind::loop, 0, {}});
        Point2 from = loop.start;
        for (const Segment& s : loop.segments) {
            const std::size_t pieces = (edge + 1) * vertices / edges - edge * vertices / edges;
            for (std::size_t n = 0; n < pieces; ++n)
                block.points.push_back(place_on(from, s, double(n) / double(pieces)));
            from = s.p3;
            ++edge;
        }
    }
    return make_cage("the polygon on " + cage.name, std::move(blocks));
}

/// A cage, its pose, and the deformed figure.
struct Trial {
    CageFile cage, pose;
    std::string coordinates, title;
    SvgDocument posed;
    std::vector<Point2> places; // of the points, posed
    std::size_t handles = 0;
    double bind_seconds = 0, clone_seconds = 0;
};

/// Returns the least seconds of several calls.
template <class F>
double least_seconds(F&& f) {
    using Clock = std::chrono::steady_clock;
    double least = HUGE_VAL;
    for (int n = 0; n < 7; ++n) {
        const auto begin = Clock::now();
        f();
        least = std::min(least, std::chrono::duration<double>(Clock::now() - begin).count());
    }
    return least;
}

/// Binds and poses; returns an error message, or empty. Removes `points` outside the cage.
std::string run_trial(const Arguments& given, const SvgDocument& figure, std::vector<Point2>& points,
                      Trial& trial) {
    CoordinatesChoice choice;
    choice.name = trial.coordinates;
    FigureControl control = control_of(choice, trial.cage);
    control.pose_name = trial.pose.name;
    control.poses = {trial.pose.vertices};
    trial.posed = move_figure(figure, given.figure, control, {.word = "extend"}, {}).drawing.document;

    std::vector<bool> is_outside(points.size());
    for (const std::size_t i : control.coordinates.bind(points).report.outside) is_outside[i] = true;
    std::size_t number = 0;
    std::erase_if(points, [&](const Point2&) { return is_outside[number++]; });
    cageform::Binding<double, 2> binding;
    cageform::Status status = cageform::Status::ok;
    trial.bind_seconds = least_seconds([&] {
        auto [bound, report] = control.coordinates.bind(points);
        status = report.status;
        binding = std::move(bound);
    });
    if (status != cageform::Status::ok) return cageform::to_string(status);
    trial.handles = binding.handle_count();
    std::string warning;
    const auto handles = pose_of_handles(binding, trial.pose.vertices, trial.pose.name, warning);
    if (!handles) return to_string(handles.error());
    trial.places.resize(points.size());
    trial.clone_seconds = least_seconds([&] { status = cageform::clone(binding, *handles, trial.places); });
    return status == cageform::Status::ok ? "" : cageform::to_string(status);
}

/// A part of the picture: a document with a cage drawn over it, and a title below.
std::string panel(const SvgDocument& document, const CageFile& cage, const ViewBox& view, double x, double y,
                  const std::string& title) {
    SvgDocument copy = detail::copy_of(document);
    const double diagonal = std::hypot(view.width, view.height);
    draw_cage(copy, cage, diagonal, "#c2377a");
    if (!cage.curves) {
        auto group = copy.xml.document_element().append_child("g");
        group.append_attribute("fill") = "#c2377a";
        for (const Point2& p : cage.vertices) {
            auto dot = group.append_child("circle");
            dot.append_attribute("cx") = p.x;
            dot.append_attribute("cy") = p.y;
            dot.append_attribute("r") = diagonal / 200;
        }
    }
    auto root = copy.xml.document_element();
    detail::set_attribute(root, "x", text_of("%.9g", x));
    detail::set_attribute(root, "y", text_of("%.9g", y));
    return to_text(copy) + "<text x=\"" + text_of("%.9g", x + view.width / 2) + "\" y=\"" +
           text_of("%.9g", y + view.height + 24) + "\">" + title + "</text>\n";
}

/// The largest distance between the figures of both trials.
double distance(const std::array<Trial, 2>& trials) {
    double largest = 0;
    for (std::size_t i = 0; i < trials[0].places.size(); ++i) {
        const Point2 &p = trials[0].places[i], &q = trials[1].places[i];
        largest = std::max(largest, std::hypot(p.x - q.x, p.y - q.y));
    }
    return largest;
}

/// The picture: the figure at rest and posed, in each cage.
std::string draw(const Arguments& given, const SvgDocument& figure, const std::array<Trial, 2>& trials) {
    const auto view = view_box(figure);
    const double gap = 40;
    std::string text;
    for (std::size_t n = 0; n < 2; ++n) {
        const Trial& trial = trials[n];
        const double y = double(n) * (view.height + gap);
        const std::string handles = std::to_string(trial.handles) + " handles, " +
                                    std::to_string(trial.handles / 2) +
                                    (trial.cage.curves ? " of them control points" : " of them vertices");
        text += panel(figure, trial.cage, view, 0, y, trial.title + ": " + handles);
        text += panel(trial.posed, trial.pose, view, view.width, y,
                      given.seconds ? text_of("%.0f", double(trial.places.size())) + " points: bound in " +
                                          text_of("%.0f", 1000 * trial.bind_seconds) + " ms, posed in " +
                                          text_of("%.1f", 1000 * trial.clone_seconds) + " ms"
                                    : "posed");
    }
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + text_of("%.9g", 2 * view.width) +
           ' ' + text_of("%.9g", 2 * (view.height + gap)) +
           "\" font-family=\"DejaVu Sans, sans-serif\" font-size=\"17\" text-anchor=\"middle\">\n" + text +
           "</svg>\n";
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line(
        "Draws a figure in a cage of curves beside the equivalent polygon, and prints handles and seconds.");
    line.set_examples({"leaf.svg --cage leaf_cage.svg --pose leaf_pose.svg -o leaf_cages.svg --png"});
    Arguments given;
    line.add("figure", given.figure, "the SVG file to deform").required();
    line.add("--cage", given.cage, "an outline, in an SVG file").required();
    line.add("--pose", given.pose, "the pose: an outline of the same commands").required();
    line.add("--vertices", given.vertices, "the vertices of the polygon").range(3, 1000).show_default();
    line.add("-o,--output", given.out, "the SVG file to write").required().ends_with({".svg"});
    line.add_flag("--seconds", given.seconds,
                  "write the seconds into the picture, which differ from run to run");
    line.add_flag("--png", given.png, "also render it, to the same name with .png");
    line.set_footer(cage_formats);
    if (const auto code = line.parse(argc, argv)) return *code;

    const auto figure = value_or_fail(load_svg(given.figure));
    const auto cage = value_or_fail(load_cage(given.cage, CageEdges::curves));
    if (!cage.curves) return fail(given.cage + ": is no outline");
    const auto pose = value_or_fail(load_pose(given.pose, cage));
    const auto view = view_box(figure);

    constexpr std::size_t along = 400; // points across the picture
    std::vector<Point2> points;
    for (std::size_t n = 0; n < along * along; ++n)
        points.push_back({view.x + view.width * (0.5 + double(n % along)) / along,
                          view.y + view.height * (0.5 + double(n / along)) / along});
    std::array<Trial, 2> trials;
    trials[0] = {cage, pose, "curved-green", "curves", {}, {}};
    trials[1] = {
        polygon_on(cage, given.vertices), polygon_on(pose, given.vertices), "green", "polygon", {}, {}};
    for (const std::size_t n : {1u, 0u, 1u}) // the polygon's points lie in both
        fail_if(run_trial(given, figure, points, trials[n]));
    for (const Trial& trial : trials)
        std::printf("%-8s %3zu handles, %zu points: bound in %.4f s, posed in %.4f s\n", trial.title.c_str(),
                    trial.handles, points.size(), trial.bind_seconds, trial.clone_seconds);
    const double largest = distance(trials);
    std::printf("the figures differ by %.3g at most, %.2g of the picture's width\n", largest,
                largest / view.width);
    OutputFiles outputs;
    add_svg(outputs, given.out, draw(given, figure, trials), given.png ? 1400 : 0);
    return commit(outputs);
}

// Deforms an SVG figure by a cage and a pose of the cage.
//
//     deform_svg cat.svg --cage auto -o first_look.svg --png
//     deform_svg cat.svg --cage cat_cage.svg --pose cat_pose_step.svg --coordinates harmonic -o step.svg
//     --png
//     deform_svg cat.svg --cage auto:24 --turn 5-10:-30 -o tail.svg
//     deform_svg cat.svg --cage auto --pin 915,165:760,60 --pin 180,740 --pin 770,740 -o pulled.svg
//
// Curves and long lines are refined until they follow the deformed shape. Everything that is not geometry
// does not change: styles, gradients, groups, identifiers.
//
// CSV cages may have interior chains and points (see cage_weights.cpp), which harmonic coordinates support.
// The pose then has the same blocks; a vertex of several blocks must have the same position in all. sibson
// and sibson-c1 use the circles of an SVG or the lines of a CSV as control points.

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/figure_motion.hpp"
#include "cli/pinned_figure.hpp"
#include "cli/pose_choice.hpp"
#include "files/bind_report.hpp"
#include "files/cage_file.hpp"
#include "io/base64.hpp"
#include "io/messages.hpp"
#include "pictures/cage_picture.hpp"
#include "pictures/render.hpp"
#include "pictures/text.hpp"
#include "svg/document.hpp"

#include <cageform/parallel/threads.hpp>

#include <iostream>

namespace {

using namespace cageform_support;

/// Bounds and warnings of a document.
std::vector<Point2> control_points(const SvgDocument& figure) {
    SvgDocument work = detail::copy_of(figure);
    std::vector<std::string> told_later; // printed when the figure is deformed
    const auto all = value_or_fail(detail::drawn_shapes(work, told_later));
    std::vector<Point2> points;
    for (const detail::DrawnShape& shape : all) {
        if (shape.level > 0) continue;
        for (const Subpath& subpath : shape.path) {
            points.push_back(subpath.start);
            for (const Segment& s : subpath.segments) points.insert(points.end(), {s.p1, s.p2, s.p3});
        }
    }
    return points;
}

struct Arguments {
    std::string figure, cage, pose, out, save_pose;
    PoseChoice operations;
    PinChoice pins;
    CoordinatesChoice choice;
    OutsideChoice outside;
    SiteChoice of_sites;
    DeformOptions options;
    bool png = false, show_cage = false, show_lines = false, show_rest = false, show_pins = false,
         report = false, text_as_paths = false;
    int png_width = 900;
    std::size_t threads = 0;

    bool has_pose() const { return !pose.empty() || !operations.operations.empty(); }
};

/// The control of the figure, and its pose.
struct Control {
    FigureControl control;
    CageFile drawn;
    std::string fault; // a warning about the pose
    std::vector<Pin<2>> pins;
    std::string on_pins;   // for --report
    std::size_t saved = 0; // the number of vertices of --save-pose: without the corners of --surround
};

/// Solves for the vertices by pins, if there are any; held vertices are fixed.
///
///   rest    of the vertices that --hold may select
///   still   fixed vertices
void pin_pose(Control& to, const Arguments& given, std::span<const cageform::Vec<double, 2>> rest,
              const std::vector<std::size_t>& still) {
    if (!given.pins.is_given()) return;
    auto pins = value_or_fail(given.pins.pins<2>());
    auto held = given.pins.held_handles(rest, still);
    auto figure = value_or_fail(PinnedFigure::make(
        to.control, {given.choice, given.pins, given.outside, to.control.poses.front(), std::move(held)},
        std::move(pins)));
    auto pose = value_or_fail(figure.settled());
    to.control.pose_name = "the pose by pins";
    to.pins = figure.cage().pins();
    to.on_pins = figure.cage().report();
    warn(figure.cage().warning());
    auto places = to.drawn.places();
    for (std::size_t i = 0; i < places.size(); ++i) places[i] = {pose[i].x, pose[i].y};
    to.drawn = moved_cage(std::move(to.drawn), places);
    to.control.poses = {std::move(pose)};
}

Control read_sites(const Arguments& given, const SvgDocument& figure) {
    if (!given.has_pose() && !given.pins.is_given()) throw Failure("--pose is required for points");
    if (given.pins.is_given() && !given.of_sites.weights.empty())
        throw Failure("--weights: pins do not support points with weights");
    const std::string& pose_name = given.pose.empty() ? given.cage : given.pose;
    auto [sites, pose, weights] =
        load_posed_sites<2>(given.cage, pose_name, given.of_sites, [&] { return control_points(figure); });
    Control result;
    result.drawn.name = given.cage;
    result.drawn.vertices = pose.points;
    for (std::size_t i = 0; i < pose.points.size(); ++i) {
        result.drawn.blocks.push_back({CageBlock::Kind::point, 0, {pose.points[i]}});
        result.drawn.handles.push_back({i});
    }
    FigureControl& control = result.control;
    control.coordinates = make_coordinates<double>(given.choice, sites);
    control.name = given.cage;
    control.pose_name = pose_name;
    control.poses = {std::move(pose.points)};
    control.weights = std::move(weights);
    control.weights_name = given.of_sites.weights;
    std::vector<cageform::Vec<double, 2>> rest;
    for (const Point2& p : sites.points) rest.push_back({p.x, p.y});
    constexpr std::size_t corners = 4; // of the box of --surround
    result.saved = rest.size() - (given.of_sites.surround > 0 ? corners : 0);
    std::vector<std::size_t> still;
    for (std::size_t i = result.saved; i < rest.size(); ++i) still.push_back(i);
    control.describe_faults = [known = std::move(sites)](const cageform::BindReport& report) {
        return describe_site_faults(known, report);
    };
    pin_pose(result, given, std::span(rest).first(result.saved), still);
    return result;
}

Control read_control(const Arguments& given, const SvgDocument& figure) {
    if (given.choice.takes_sites()) return read_sites(given, figure);
    const auto cage = load_or_make_cage(given.cage, figure, given.choice.edges());
    const bool is_made = CageChoice::of(given.cage).is_auto;
    const auto rest = cage.places();
    auto pose = given.pins.is_given() && !given.has_pose()
                    ? moved_cage(cage, rest)
                    : read_pose(given.pose, given.operations, cage, is_made);
    Control result{control_of(given.choice, cage), std::move(pose), {}, {}, {}, cage.vertices.size()};
    result.control.pose_name = !given.pose.empty() ? given.pose : is_made ? given.figure : given.cage;
    result.control.poses = {result.drawn.vertices};
    const auto still = given.operations.still(cage.lattice);
    const std::size_t count = cage.lattice ? cage.lattice->points() : rest.size();
    pin_pose(result, given, std::span(rest).first(count), still);
    result.fault = pose_faults(result.control, cage);
    return result;
}

/// The text of --save-pose: a pose of a cage or of control points.
std::string saved_pose(const Control& posed, const Arguments& given, const ViewBox& view) {
    const std::string option = "--save-pose " + given.save_pose;
    if (posed.control.coordinates.handles().vector_count() > 0 && posed.control.poses_all_handles)
        throw Failure(option + ": with these coordinates pins also pose edges, which a file of vertices "
                               "cannot store; use mean-value or harmonic");
    if (!given.choice.takes_sites()) {
        const auto text = pose_text(posed.drawn, given.save_pose, view);
        return text ? *text : throw Failure("--save-pose " + to_string(text.error()));
    }
    if (lowercase_extension(given.save_pose) != ".csv") throw Failure(option + ": points need a .csv file");
    std::string text;
    for (std::size_t i = 0; i < posed.saved; ++i) {
        const Point2& p = posed.drawn.vertices[i];
        text += detail::digits_of(p.x) + ',' + detail::digits_of(p.y) + '\n';
    }
    return text;
}

/// Draws a figure below everything else, white with an outline. It is an embedded picture, so its identifiers
/// and styles do not conflict with the document.
void draw_rest(SvgDocument& document, const std::string& rest, const ViewBox& view) {
    auto root = document.xml.document_element();
    auto filter = root.prepend_child("filter");
    filter.append_attribute("id") = "white-at-rest";
    for (const char* name : {"x", "y"}) filter.append_attribute(name) = "0";
    for (const char* name : {"width", "height"}) filter.append_attribute(name) = "1";
    const auto step = [&](const char* name,
                          const std::vector<std::pair<const char*, std::string>>& attributes) {
        auto element = filter.append_child(name);
        for (const auto& [key, value] : attributes) element.append_attribute(key) = value.c_str();
        return element;
    };
    const double radius = std::hypot(view.width, view.height) / 500;
    step("feMorphology", {{"in", "SourceAlpha"},
                          {"operator", "dilate"},
                          {"radius", format_number(radius, 3)},
                          {"result", "wide"}});
    step("feFlood", {{"flood-color", "#888888"}});
    step("feComposite", {{"in2", "wide"}, {"operator", "in"}, {"result", "rim"}});
    step("feFlood", {{"flood-color", "#ffffff"}});
    step("feComposite", {{"in2", "SourceAlpha"}, {"operator", "in"}, {"result", "white"}});
    auto merge = step("feMerge", {});
    for (const char* layer : {"rim", "white"})
        merge.append_child("feMergeNode").append_attribute("in") = layer;

    auto image = root.insert_child_after("image", filter);
    image.append_attribute("x") = view.x;
    image.append_attribute("y") = view.y;
    image.append_attribute("width") = view.width;
    image.append_attribute("height") = view.height;
    image.append_attribute("filter") = "url(#white-at-rest)";
    image.append_attribute("href") = ("data:image/svg+xml;base64," + base64(rest)).c_str();
}

void add_inputs(CommandLine& line, Arguments& given) {
    line.add("figure", given.figure, "the SVG file to deform").required();
    add_cage(line, given.cage, CageFiles::drawing_or_sites);
    line.add("--pose", given.pose,
             "the pose: the same blocks or points with vertices moved. Or give operations such as --turn, or "
             "pins. With --cage auto and none of these, half the figure bends, and the picture is enlarged "
             "to fit");
    given.operations.in_plane = true;
    given.operations.add_options(line);
    given.pins.add_options(line);
}

void add_outputs(CommandLine& line, Arguments& given) {
    line.add("--save-pose", given.save_pose, "also write the posed vertices to a file that --pose reads")
        .ends_with({".svg", ".csv"});
    line.add("-o,--output", given.out, "the SVG file to write").required().ends_with({".svg"});
    line.add_png(given.png, given.png_width);
}

void add_drawing(CommandLine& line, Arguments& given) {
    add_text_as_paths(line, given.text_as_paths);
    line.add_flag("--fit", given.options.fit,
                  "enlarge the viewBox and the size of the picture so that the deformed figure fits");
    line.add("--flatness", given.options.tolerance,
             "the largest distance between drawn and exact deformed curves, in user units; 0 means invisibly "
             "small")
        .range(0.0, 1e100)
        .show_default();
    line.add_flag("--show-cage", given.show_cage,
                  "draw the posed cage over the figure, with the numbers of its vertices");
    line.add_flag("--show-cage-lines", given.show_lines, "draw the posed cage without numbers")
        .rarely_needed();
    line.add_flag("--show-pins", given.show_pins, "draw the pins at their targets, with their displacements");
    line.add_flag("--show-rest", given.show_rest, "draw the figure at rest below, in white");
    line.add_flag("--report", given.report,
                  "print the bind report, the numbers of shapes and points, and the errors of pins");
}

int deform_figure(const Arguments& given, SvgDocument document) {
    const Control posed = read_control(given, document);
    fail_if(fault_of_outputs({given.out, given.png ? png_of(given.out) : "", given.save_pose}));
    const std::string rest = given.show_rest ? to_text(document) : "";
    const auto rest_view = view_box(document);
    const std::string pose_file = given.save_pose.empty() ? "" : saved_pose(posed, given, rest_view);
    auto moved = move_figure(document, given.figure, posed.control, given.outside, given.options,
                             cageform::ThreadedFor{unsigned(given.threads)});
    warn(posed.fault);
    document = std::move(moved.drawing.document);
    if (given.show_rest) draw_rest(document, rest, rest_view);
    const auto view = view_box(document);
    const double diagonal = std::hypot(view.width, view.height);
    if (given.show_cage || given.show_lines) draw_cage(document, posed.drawn, diagonal, "#c2377a");
    if (given.show_cage) draw_numbers(document, posed.drawn, diagonal / 60);
    if (given.show_pins) draw_pins(document, posed.pins, diagonal);
    OutputFiles outputs;
    add_svg(outputs, given.out, to_text(document), given.png ? given.png_width : 0);
    if (!given.save_pose.empty()) outputs.add(given.save_pose).write(pose_file);
    fail_if(outputs.commit());
    if (given.report) {
        const DeformReport& deformed = moved.drawing.report;
        std::cout << "shapes: " << deformed.shapes << ", segments written: " << deformed.segments
                  << ", points bound: " << deformed.points << " in " << deformed.batches
                  << " batches\nfirst batch:\n"
                  << describe(moved.bound) << posed.on_pins;
    }
    return 0;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Deforms an SVG figure by a cage and a pose of the cage. Strokes keep their width; "
                     "gradients and patterns follow the affine map that fits the deformation best.");
    line.set_examples({"icon.svg --cage auto -o look.svg --png --show-cage",
                       "icon.svg --cage auto --turn 5-10:-30 --move 3:0,12 -o pose.svg --png --fit",
                       "icon.svg --cage auto --pin 12,40 --pin 36,40 --pin 24,8:+6,0 -o pulled.svg --fit"});
    Arguments given;
    add_inputs(line, given);
    add_outputs(line, given);
    given.outside.with_sites = given.choice.with_sites = true;
    given.choice.in_plane = given.choice.with_normals = true;
    given.outside.add_options(line);
    add_threads(line, given.threads);
    given.of_sites.add_options(line);
    add_drawing(line, given);
    given.choice.add_options(line);
    line.set_footer(cage_formats + std::string("\n") + lattice_format + "\n" + pose_operations_format + "\n" +
                    pins_format + "\n" + site_formats + "\n" + site_weights_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    fail_if(given.of_sites.fault(given.choice));
    fail_if(given.pins.fault(given.has_pose()));
    fail_if(given.outside.fault());
    if (!given.has_pose() && !given.pins.is_given()) given.options.fit = true;
    given.outside.cage_is_made = CageChoice::of(given.cage).is_auto;
    return deform_figure(given, value_or_fail(load_figure(given.figure, given.text_as_paths)));
}

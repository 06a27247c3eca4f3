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
Expected<std::vector<Point2>> control_points(const SvgDocument& figure) {
    SvgDocument work = detail::copy_of(figure);
    std::vector<std::string> told_later; // printed when the figure is deformed
    const auto all = detail::drawn_shapes(work, told_later);
    if (!all) return all.error();
    std::vector<Point2> points;
    for (const detail::DrawnShape& shape : *all) {
        if (shape.level > 0) continue;
        for (const Subpath& subpath : shape.path) {
            points.push_back(subpath.start);
            for (const Segment& s : subpath.segments) points.insert(points.end(), {s.p1, s.p2, s.p3});
        }
    }
    return points;
}

/// --cage, --pose, operations and pins.
struct CagePaths {
    std::string cage, pose;
    PoseChoice operations;
    PinChoice pins;

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
Expected<bool> pin_pose(Control& to, const CoordinatesChoice& choice, const CagePaths& paths,
                        const OutsideChoice& outside, std::span<const cageform::Vec<double, 2>> rest,
                        const std::vector<std::size_t>& still) {
    if (!paths.pins.is_given()) return true;
    auto pins = paths.pins.pins<2>();
    if (!pins) return pins.error();
    auto held = paths.pins.held_handles(rest, still);
    if (!held) return held.error();
    auto figure = PinnedFigure::make(
        to.control, {choice, paths.pins, outside, to.control.poses.front(), std::move(*held)},
        std::move(*pins));
    if (!figure) return figure.error();
    auto pose = figure->settled();
    if (!pose) return pose.error();
    to.control.pose_name = "the pose by pins";
    to.pins = figure->cage().pins();
    to.on_pins = figure->cage().report();
    if (const std::string why = figure->cage().warning(); !why.empty()) warn(why);
    auto places = to.drawn.places();
    for (std::size_t i = 0; i < places.size(); ++i) places[i] = {(*pose)[i].x, (*pose)[i].y};
    to.drawn = moved_cage(std::move(to.drawn), places);
    to.control.poses = {std::move(*pose)};
    return true;
}

Expected<Control> read_sites(const CoordinatesChoice& choice, const CagePaths& paths,
                             const SiteChoice& of_sites, const OutsideChoice& outside,
                             const SvgDocument& figure) {
    if (!paths.has_pose() && !paths.pins.is_given()) return FileError{"--pose is required for points"};
    if (paths.pins.is_given() && !of_sites.weights.empty())
        return FileError{"--weights: pins do not support points with weights"};
    const bool has_pose = !paths.pose.empty();
    auto posed = load_posed_sites<2>(paths.cage, has_pose ? paths.pose : paths.cage, of_sites,
                                     [&] { return control_points(figure); });
    if (!posed) return posed.error();
    auto& [sites, pose, weights] = *posed;
    Control result;
    result.drawn.name = paths.cage;
    result.drawn.vertices = pose.points;
    for (std::size_t i = 0; i < pose.points.size(); ++i) {
        result.drawn.blocks.push_back({CageBlock::Kind::point, 0, {pose.points[i]}});
        result.drawn.handles.push_back({i});
    }
    FigureControl& control = result.control;
    control.coordinates = make_coordinates<double>(choice, sites);
    control.name = paths.cage;
    control.pose_name = has_pose ? paths.pose : paths.cage;
    control.poses = {std::move(pose.points)};
    control.weights = std::move(weights);
    control.weights_name = of_sites.weights;
    std::vector<cageform::Vec<double, 2>> rest;
    for (const Point2& p : sites.points) rest.push_back({p.x, p.y});
    constexpr std::size_t corners = 4; // of the box of --surround
    result.saved = rest.size() - (of_sites.surround > 0 ? corners : 0);
    std::vector<std::size_t> still;
    for (std::size_t i = result.saved; i < rest.size(); ++i) still.push_back(i);
    control.describe_faults = [known = std::move(sites)](const cageform::BindReport& report) {
        return describe_site_faults(known, report);
    };
    const auto pinned = pin_pose(result, choice, paths, outside, std::span(rest).first(result.saved), still);
    if (!pinned) return pinned.error();
    return result;
}

Expected<Control> read_control(const CoordinatesChoice& choice, const CagePaths& paths,
                               const SiteChoice& of_sites, const OutsideChoice& outside,
                               const SvgDocument& figure, const std::string& figure_path) {
    if (choice.takes_sites()) return read_sites(choice, paths, of_sites, outside, figure);
    const auto cage = load_or_make_cage(paths.cage, figure, choice.edges());
    if (!cage) return cage.error();
    const bool is_made = CageWord::of(paths.cage).is_auto, pinned = paths.pins.is_given();
    const auto rest = cage->places();
    auto pose = pinned && !paths.has_pose() ? moved_cage(*cage, rest)
                                            : read_pose(paths.pose, paths.operations, *cage, is_made);
    if (!pose) return pose.error();
    Control result{control_of(choice, *cage), std::move(*pose), {}, {}, {}, cage->vertices.size()};
    result.control.pose_name = !paths.pose.empty() ? paths.pose : is_made ? figure_path : paths.cage;
    result.control.poses = {result.drawn.vertices};
    const auto still = paths.operations.still(cage->lattice);
    if (!still) return still.error();
    const std::size_t count = cage->lattice ? cage->lattice->points() : rest.size();
    const auto done = pin_pose(result, choice, paths, outside, std::span(rest).first(count), *still);
    if (!done) return done.error();
    result.fault = pose_faults(result.control, *cage);
    return result;
}

/// The text of a pose of a cage or of control points.
Expected<std::string> saved_pose(const Control& posed, bool of_sites, const std::string& path,
                                 const ViewBox& view) {
    if (posed.control.coordinates.handles().vector_count() > 0 && posed.control.poses_all_handles)
        return FileError{
            "--save-pose " + path +
            ": with these coordinates pins also pose edges, which a file of vertices cannot store; use "
            "mean-value or harmonic"};
    if (!of_sites) {
        const auto text = pose_text(posed.drawn, path, view);
        return text ? text : FileError{"--save-pose " + to_string(text.error())};
    }
    if (ending_of(path) != ".csv") return FileError{"--save-pose " + path + ": points need a .csv file"};
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

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Deforms an SVG figure by a cage and a pose of the cage. Strokes keep their width; "
                     "gradients and patterns follow the affine map that fits the deformation best.");
    line.set_examples({"icon.svg --cage auto -o look.svg --png --show-cage",
                       "icon.svg --cage auto --turn 5-10:-30 --move 3:0,12 -o pose.svg --png --fit",
                       "icon.svg --cage auto --pin 12,40 --pin 36,40 --pin 24,8:+6,0 -o pulled.svg --fit"});
    std::string figure_path, out_path, save_path;
    CagePaths paths;
    auto& [cage_path, pose_path, operations, pins] = paths;
    bool png = false, show_cage = false, show_lines = false, show_rest = false, show_pins = false,
         report = false, text_as_paths = false;
    int png_width = 900;
    CoordinatesChoice choice;
    OutsideChoice outside;
    std::size_t threads = 0;
    SiteChoice of_sites;
    DeformOptions options;
    line.add("figure", figure_path, "the SVG file to deform").required();
    add_cage(line, cage_path, CageFiles::drawing_or_sites);
    line.add("--pose", pose_path,
             "the pose: the same blocks or points with vertices moved. Or give operations such as --turn, or "
             "pins. With --cage auto and none of these, half the figure bends, and the picture is enlarged "
             "to fit");
    operations.in_plane = true;
    operations.add_options(line);
    pins.add_options(line);
    line.add("--save-pose", save_path, "also write the posed vertices to a file that --pose reads")
        .ends_with({".svg", ".csv"});
    line.add("-o,--output", out_path, "the SVG file to write").required().ends_with({".svg"});
    line.add_flag("--png", png, "also render it, to the same name with .png");
    line.add("--png-width", png_width, "the width of the PNG file, in pixels").range(1, 16384).show_default();
    outside.with_sites = choice.with_sites = choice.in_plane = choice.with_normals = true;
    outside.add_options(line);
    line.add("--threads", threads, "the number of threads that bind; 0: all processors")
        .range(0, 1024)
        .show_default();
    of_sites.add_options(line);
    line.add_flag(
        "--text-as-paths", text_as_paths,
        "deform the outlines of letters (as rsvg-convert draws them); otherwise a text moves as a whole");
    line.add_flag("--fit", options.fit,
                  "enlarge the viewBox and the size of the picture so that the deformed figure fits");
    line.add("--flatness", options.tolerance,
             "the largest distance between drawn and exact deformed curves, in user units; 0 means "
             "invisibly small")
        .range(0.0, 1e100)
        .show_default();
    line.add_flag("--show-cage", show_cage,
                  "draw the posed cage over the figure, with the numbers of its vertices");
    line.add_flag("--show-cage-lines", show_lines, "draw the posed cage without numbers").rarely_needed();
    line.add_flag("--show-pins", show_pins, "draw the pins at their targets, with their displacements");
    line.add_flag("--show-rest", show_rest, "draw the figure at rest below, in white");
    line.add_flag("--report", report,
                  "print the bind report, the numbers of shapes and points, and the errors of pins");
    choice.add_options(line);
    line.set_footer(cage_formats + std::string("\n") + lattice_format + "\n" + pose_operations_format + "\n" +
                    pins_format + "\n" + site_formats + "\n" + site_weights_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    if (const std::string why = of_sites.fault(choice); !why.empty()) return fail(why);
    if (const std::string why = pins.fault(paths.has_pose()); !why.empty()) return fail(why);
    if (const std::string why = outside.fault(); !why.empty()) return fail(why);

    if (!paths.has_pose() && !pins.is_given()) options.fit = true;
    auto document = load_figure(figure_path, text_as_paths).value();
    outside.cage_is_made = CageWord::of(cage_path).is_auto;
    const auto posed = read_control(choice, paths, of_sites, outside, document, figure_path).value();
    const std::string png_path = png ? png_of(out_path).string() : "";
    if (const auto fault = fault_of_outputs({out_path, png_path, save_path})) return fail(*fault);

    const std::string rest = show_rest ? to_text(document) : "";
    const auto rest_view = view_box(document);
    std::string pose_file;
    if (!save_path.empty()) {
        pose_file = saved_pose(posed, choice.takes_sites(), save_path, rest_view).value();
    }
    auto moved = move_figure(document, figure_path, posed.control, outside, options,
                             cageform::ThreadedFor{unsigned(threads)})
                     .value();
    if (!posed.fault.empty()) warn(posed.fault);
    document = std::move(moved.drawing.document);
    if (show_rest) draw_rest(document, rest, rest_view);
    const auto view = view_box(document);
    const double diagonal = std::hypot(view.width, view.height);
    if (show_cage || show_lines) draw_cage(document, posed.drawn, diagonal, "#c2377a");
    if (show_cage) draw_numbers(document, posed.drawn, diagonal / 60);
    if (show_pins) draw_pins(document, posed.pins, diagonal);
    OutputFiles outputs;
    add_svg(outputs, out_path, to_text(document), png ? png_width : 0);
    if (!save_path.empty()) outputs.add(save_path).write(pose_file);
    if (const auto error = outputs.commit()) return fail(*error);
    if (report) {
        const DeformReport& deformed = moved.drawing.report;
        std::cout << "shapes: " << deformed.shapes << ", segments written: " << deformed.segments
                  << ", points bound: " << deformed.points << " in " << deformed.batches
                  << " batches\nfirst batch:\n"
                  << describe(moved.bound) << posed.on_pins;
    }
    return 0;
}

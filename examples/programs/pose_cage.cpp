// Poses a cage by operations on its vertices, in the given order, and draws the vertex numbers.
//
//     pose_cage cat_cage.svg --picture numbers.svg
//     pose_cage cat_cage.svg --turn 7-11:-30@775,400 --move 15-20:20,40 -o pose.svg --picture numbers.svg
//     pose_cage character_cage.obj --bend 'x>0:xy,0.2,0.3,-60' -o pose.obj --picture pose.png

#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/pose_choice.hpp"
#include "files/obj_file.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"
#include "pictures/cage_picture.hpp"
#include "pictures/field_plot.hpp"
#include "pictures/parts_picture.hpp"
#include "pictures/render.hpp"
#include "svg/document.hpp"

#include <iostream>

namespace {

using namespace cageform_support;

struct Arguments {
    std::string cage, out, picture, figure, coordinates;
    bool png = false;
    PoseChoice choice;
};

/// Poses the cage, and prints the number of moved vertices and the bounds at rest.
template <std::size_t D>
std::vector<cageform::Vec<double, D>>
posed(const Arguments& given, const std::vector<cageform::Vec<double, D>>& rest,
      const std::optional<LatticeBox<D>>& lattice, const CageFile* curves = nullptr,
      const cageform::CageParts* parts = nullptr) {
    auto pose = given.choice.posed(rest, lattice, curves, parts);
    std::size_t moved = 0;
    for (std::size_t i = 0; i < rest.size(); ++i) moved += pose[i] == rest[i] ? 0 : 1;
    std::cout << printable(given.cage) << ": " << moved << " of " << rest.size()
              << (curves != nullptr ? " control points moved; at rest" : " vertices moved; at rest");
    const auto box = cageform::bounds_of(std::span(rest)); // for selections by position
    for (std::size_t k = 0; k < D; ++k)
        std::cout << (k == 0 ? " " : ", ") << "xyz"[k] << " from " << detail::short_number(box.lower[k])
                  << " to " << detail::short_number(box.upper[k]);
    std::cout << '\n';
    return pose;
}

/// Returns the view of the SVG, or the bounds of a CSV cage.
ViewBox view_of(const CageFile& cage) {
    if (cage.name.ends_with(".csv") || cage.lattice) {
        PlaneBox box;
        for (const Point2& p : cage.vertices) box.add(p);
        return {box.low.x, box.low.y, box.width(), box.height()};
    }
    return view_box(value_or_fail(load_svg(cage.name)));
}

int pose_in_plane(const Arguments& given) {
    const auto cage =
        value_or_fail(load_cage(given.cage, given.coordinates.empty()             ? CageEdges::as_drawn
                                            : given.coordinates == "curved-green" ? CageEdges::curves
                                                                                  : CageEdges::lines));
    if (lowercase_extension(given.out) == ".obj")
        return fail("-o " + given.out + ": the cage lies in the plane: write .svg or .csv");
    if (lowercase_extension(given.picture) == ".png")
        return fail("--picture " + given.picture +
                    ": in the plane the picture is an .svg file; --png renders it too");
    SvgDocument below;
    if (!given.figure.empty()) {
        below = value_or_fail(load_svg(given.figure));
    }
    const auto moved = posed<2>(given, cage.places(), cage.lattice, cage.curves ? &cage : nullptr);
    const CageFile pose = moved_cage(cage, moved);
    OutputFiles outputs;
    if (!given.out.empty()) {
        const auto view = view_of(pose);
        const auto text = pose_text(pose, given.out, view);
        if (!text) return fail("-o " + to_string(text.error()));
        outputs.add(given.out).write(*text);
    }
    if (!given.picture.empty()) {
        const auto picture =
            value_or_fail(draw_pose(cage, pose, given.figure.empty() ? nullptr : &below, given.picture));
        add_svg(outputs, given.picture, to_text(picture), given.png ? 1200 : 0);
    }
    return commit(outputs);
}

int pose_in_space(const Arguments& given) {
    const auto cage = value_or_fail(load_mesh_cage(given.cage));
    if (!given.out.empty() && lowercase_extension(given.out) != ".obj")
        return fail("-o " + given.out + ": the cage lies in space: write .obj");
    if (lowercase_extension(given.picture) == ".svg" || given.png || !given.figure.empty())
        return fail(given.cage + " lies in space: --picture takes a .png file, without --figure and --png");
    if (given.coordinates == "curved-green")
        return fail("--coordinates curved-green: " + given.cage + " lies in space, and curves in the plane");
    fail_if(fault_of_outputs({given.out, given.picture}));
    const auto parts = cage_parts(cage);
    const auto pose = posed<3>(given, cage.vertices, cage.lattice, nullptr, &parts);
    OutputFiles outputs;
    if (!given.out.empty()) outputs.add(given.out).write(to_text(cage, pose));
    if (!given.picture.empty()) draw_pose(cage, pose).write_png(outputs.add(given.picture));
    return commit(outputs);
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Poses a cage: moves, turns, scales, bends and twists vertices, selected by their "
                     "numbers or positions, in the order given, and draws the numbers.");
    line.set_examples(
        {"cage.svg --figure icon.svg --picture numbers.svg",
         "cage.svg --turn 7-11:-30@v6,12 --move 3:20,40 -o pose.svg --picture pose_numbers.svg"});
    Arguments given;
    line.add("cage", given.cage, "an SVG or CSV file, in space a mesh, or a .lattice.json file").required();
    CoordinatesChoice of_coordinates;
    of_coordinates.in_plane = of_coordinates.with_normals = true;
    line.add("--coordinates", given.coordinates,
             "the coordinates for the pose: curved-green also poses the edges of polygons, as cubics; others "
             "refuse paths with curves")
        .one_of(of_coordinates.names());
    given.choice.in_plane = true;
    given.choice.add_options(line);
    line.add("-o,--output", given.out, "the pose to write: .svg or .csv; in space .obj")
        .ends_with({".svg", ".csv", ".obj"});
    line.add("--picture", given.picture,
             "draw the pose and the numbers of its vertices over the cage at rest, to an .svg file; in space "
             "a .png file")
        .ends_with({".svg", ".png"});
    line.add("--figure", given.figure, "an SVG file to draw below the cage in the picture");
    line.add_flag("--png", given.png, "also render the picture, to the same name with .png");
    line.set_footer(pose_operations_format + std::string("\n") + cage_formats + "\n" + mesh_formats + "\n" +
                    lattice_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    if (given.out.empty() && given.picture.empty())
        return fail("nothing to write: give -o, --picture or both");
    if (given.picture.empty() && (given.png || !given.figure.empty()))
        return fail("--png and --figure are for --picture");
    const auto dimension = cage_dimension(given.cage);
    return dimension == 3 ? pose_in_space(given) : pose_in_plane(given);
}

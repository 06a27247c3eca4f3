// Makes a cage with few vertices around a figure.
//
//     make_cage cat.svg --vertices 24 -o cat_cage.svg --picture cat_numbers.svg --png
//     make_cage icon.svg --mirror x --margin 4% -o icon_cage.csv
//     make_cage character.obj --vertices 112 -o character_cage.obj --picture cage.png
//     make_cage character.obj --vertices auto --volume 15% -o character_cage.obj
//     make_cage character.obj --quads --rings --mirror x -o character_cage.obj
//     make_cage cat.svg --lattice 4x4 -o cat.lattice.json --picture cat_numbers.svg
//
// The cage contains everything visible of the figure, at a distance of the margin, and passes all checks of
// the library. --cage auto of the other programs makes the same cage.

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/progress_bar.hpp"
#include "files/bind_report.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"
#include "pictures/cage_picture.hpp"
#include "pictures/parts_picture.hpp"
#include "pictures/render.hpp"
#include "pictures/text.hpp"
#include "pictures/view_choice.hpp"

#include <cmath>
#include <iostream>

namespace {

using namespace cageform_support;

/// The number of --vertices; `fewest` for auto.
struct VertexCount {
    std::size_t count = 0;
    bool fewest = false;
};

struct Arguments {
    std::string figure, out, picture;
    ViewChoice view;
    bool png = false;
    bool quads = false, parts = false;
    VertexCount vertices;
    bool is_strict = false;
    cageform::MakeCageOptions options;
    std::optional<LatticeWord> lattice;

    double lattice_margin() const {
        return options.margin > 0 ? options.margin : cageform_support::lattice_margin;
    }
};

/// Parses "2.5%" or "0.025".
std::string parse_margin(const std::string& word, double& margin) {
    const bool is_share = word.ends_with('%');
    const std::string number = is_share ? word.substr(0, word.size() - 1) : word;
    if (const std::string why = detail::parse_number(number, margin); !why.empty()) return why;
    if (is_share) margin /= 100;
    if (!is_share && margin >= 1)
        return "a margin is a share of the figure's diagonal: " + word + "% or, as a number, " +
               detail::short_number(margin / 100) + "?";
    if (!(margin > 0 && margin < 10))
        return "a margin is a share of the figure's diagonal, such as 2.5% or 0.025";
    return {};
}

/// Parses "24" or "auto" (the fewest).
std::string parse_vertices(const std::string& word, VertexCount& vertices) {
    double count = 0;
    vertices.fewest = word == "auto";
    if (vertices.fewest) return {};
    if (!detail::parse_number(word, count).empty() || !(count >= 3 && count <= 1e6) ||
        count != std::floor(count))
        return "a whole number from 3 to 1000000, or auto, not " + detail::quoted(word);
    vertices.count = std::size_t(count);
    return {};
}

/// Parses "x" or "y=12.5".
std::string parse_mirror(const std::string& word, std::optional<cageform::MirrorPlane>& plane) {
    cageform::MirrorPlane& mirror = plane.emplace();
    if (word.empty() || word[0] < 'x' || word[0] > 'z' || (word.size() > 1 && word[1] != '='))
        return "write an axis, x, y or z, or with its position x=12.5";
    mirror.axis = std::size_t(word[0] - 'x');
    if (word.size() == 1) return {};
    double place = 0;
    if (const std::string why = detail::parse_number(std::string_view(word).substr(2), place); !why.empty())
        return why;
    if (!std::isfinite(place)) return "its position is not finite";
    mirror.position = place;
    return {};
}

/// Enlarges the view of the picture to contain the cage.
ViewBox view_about(const CageFile& cage, const ViewBox& view) {
    Point2 low{view.x, view.y}, high{view.x + view.width, view.y + view.height};
    for (const Point2& p : cage.vertices) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    return {low.x, low.y, high.x - low.x, high.y - low.y};
}

int write_in_plane(const Arguments& given, const SvgDocument& figure, const CageFile& cage,
                   const ViewBox& view, const std::string& description) {
    OutputFiles outputs;
    if (!given.out.empty()) {
        const Expected<std::string> text = is_lattice_path(given.out) ? to_json(*cage.lattice)
                                           : given.out.ends_with(".csv")
                                               ? to_csv(cage)
                                               : to_svg(cage, view_about(cage, view));
        if (!text) return fail(given.out + ": " + to_string(text.error()));
        outputs.add(given.out).write(*text);
    }
    if (!given.picture.empty()) {
        const auto picture = value_or_fail(draw_pose(cage, cage, &figure, given.picture));
        add_svg(outputs, given.picture, to_text(picture), given.png ? 1200 : 0);
    }
    fail_if(outputs.commit());
    std::cout << description;
    return 0;
}

int cage_in_plane(const Arguments& given) {
    if (given.options.fill_tunnels) return fail("--fill-tunnels is for figures in space");
    if (given.options.rings) return fail("--rings is for figures in space: a cage in the plane has no limbs");
    if (given.quads) return fail("--quads is for figures in space: a cage in the plane has no faces");
    const auto figure = value_or_fail(load_figure(given.figure));
    const auto view = view_box(figure);
    if (given.lattice) {
        const auto made = make_lattice_for(figure, *given.lattice, given.lattice_margin());
        return write_in_plane(given, figure, made, view, describe(*made.lattice) + '\n');
    }
    const auto made = make_cage_for(figure, given.options);
    print_warnings(warnings_of(made.report, given.options));
    return write_in_plane(given, figure, made.cage, view, describe(made.report, 2));
}

int write_in_space(const Arguments& given, const MeshFile& figure, const MeshFile& cage,
                   const std::string& description) {
    OutputFiles outputs;
    if (!given.out.empty())
        outputs.add(given.out).write(is_lattice_path(given.out) ? to_json(*cage.lattice) : cage.text);
    if (!given.picture.empty()) {
        draw_cage_parts(figure, cage, 1600, 1000, given.view.sight).write_png(outputs.add(given.picture));
    }
    fail_if(outputs.commit());
    std::cout << description;
    return 0;
}

int cage_in_space(const Arguments& given) {
    if (given.options.holes)
        return fail("--holes is for figures in the plane; in space tunnels are always kept");
    if (given.png) return fail("--png: in space the picture is a .png file already");
    const auto figure = load_mesh_figure(given.figure, given.is_strict);
    fail_if(fault_of_outputs({given.out, given.picture}));
    if (given.lattice) {
        const auto made = make_lattice_for(figure, *given.lattice, given.lattice_margin());
        return write_in_space(given, figure, made, describe(*made.lattice) + '\n');
    }
    ProgressBar bar("making the cage");
    const auto made = make_cage_for(figure, given.options, bar.callback());
    print_warnings(warnings_of(made.report, given.options));
    if (!given.quads) {
        return write_in_space(given, figure, made.cage,
                              describe(made.report, 3) + describe_rings(made.report) +
                                  describe_parts(cage_parts(made.cage)));
    }
    const auto paired = with_quads(made, figure, given.options);
    return write_in_space(given, figure, paired.cage,
                          describe(paired.report, 3) + describe_quads(paired.report) +
                              describe_rings(paired.report) + describe_parts(cage_parts(paired.cage)));
}

/// Parses "4x4" or "4x4x4".
std::string parse_lattice(const std::string& word, std::optional<LatticeWord>& lattice) {
    auto read = parse_lattice_word(word);
    if (!read) return to_string(read.error());
    lattice = std::move(*read);
    return {};
}

/// Adds --lattice and the options on the size of cages.
CommandOption add_size(CommandLine& line, Arguments& given) {
    auto& options = given.options;
    const CommandOption lattice =
        line.add_parsed("--lattice", given.lattice, parse_lattice,
                        "make a lattice of points around the figure instead of a cage: 4x4, in space 4x4x4; "
                        "--help-all describes the format");
    line.add_parsed("--vertices", given.vertices, parse_vertices,
                    "the number of the cage's vertices, 24 by default, in space 112; or auto: the fewest "
                    "that --volume allows")
        .excludes(lattice);
    line.add_parsed("--volume,--area", options.looseness, parse_looseness,
                    "use the fewest vertices, to within 5 %, whose volume (in the plane area) exceeds that "
                    "of the tightest cage by at most this share. Print the volume for each doubling. With "
                    "--vertices auto the default is 25%, in the plane 5%. The limit is --vertices N, by "
                    "default 1000, in the plane 200")
        .excludes(lattice);
    line.add_parsed("--margin", options.margin, parse_margin,
                    "the distance from the figure, relative to its diagonal: 2.5% by default, in space and "
                    "for lattices 2%");
    return lattice;
}

/// Adds the options on the shape of cages, which exclude `lattice`.
void add_shape(CommandLine& line, Arguments& given, const CommandOption& lattice) {
    auto& options = given.options;
    line.add_parsed(
            "--mirror", options.mirror, parse_mirror,
            "make the cage symmetric by a mirror across an axis: x, y, z, or with its position x=12.5")
        .excludes(lattice);
    line.add_text(
            "--cage", [&options](const std::string& word) { options.shape = CageChoice::of(word).shape; },
            "auto follows the figure (the default), hull its convex hull, box its bounds")
        .one_of({"auto", "hull", "box"})
        .excludes(lattice);
    line.add_flag("--parts", given.parts,
                  "make a loop for each part of the figure; otherwise bridges join the parts")
        .excludes(lattice);
    line.add_flag("--holes", options.holes, "keep empty regions that the figure encloses as holes")
        .excludes(lattice);
    line.add_flag("--fill-tunnels", options.fill_tunnels, "in space: make no tunnels through the cage")
        .excludes(lattice);
    line.add_flag("--quads", given.quads,
                  "in space: pair triangles to quads, for editing by loops; any triangulation of the quads "
                  "keeps a quarter of the margin from the figure")
        .excludes(lattice);
    line.add_flag(
            "--rings", options.rings,
            "in space: make a flat loop of edges around each limb, at its joint, as the border of parts")
        .excludes(lattice);
    line.add("--regular", options.regular, "higher values give more regular, looser cages")
        .range(0.0, 1000.0)
        .show_default()
        .excludes(lattice);
}

void add_outputs(CommandLine& line, Arguments& given) {
    line.add("-o,--output", given.out,
             "the cage to write: .svg or .csv; in space .obj; of a lattice also .lattice.json")
        .ends_with({".svg", ".csv", ".obj", ".json"});
    line.add("--picture", given.picture,
             "draw the figure in its cage. In the plane: .svg, with vertex numbers. In space: .png, with the "
             "parts of the cage in colours and their numbers")
        .ends_with({".svg", ".png"});
    given.view.add_options(line);
    line.add_flag("--png", given.png, "also render the picture, to the same name with .png");
    add_strict(line, given.is_strict);
}

/// Fails if options conflict.
void check_options(const Arguments& given) {
    const auto& options = given.options;
    if (options.shape == cageform::CageShape::box &&
        (given.vertices.count != 0 || given.vertices.fewest || options.looseness > 0))
        throw Failure(std::string(options.looseness > 0 ? "--volume" : "--vertices") +
                      ": --cage box has 8 vertices, in the plane 4; --cage hull and auto take a number");
    if (given.out.empty() && given.picture.empty())
        throw Failure("nothing to write: give -o, --picture or both");
    if (given.png && given.picture.empty()) throw Failure("--png is for --picture");
    if (given.out.ends_with(".json") && (!given.lattice || !is_lattice_path(given.out)))
        throw Failure(given.out + ": give --lattice and a name that ends with .lattice.json");
    const bool in_space = is_mesh_path(given.figure);
    for (const std::string& path : {given.out, given.picture}) {
        const bool is_of_space = path.ends_with(".obj") || path.ends_with(".png");
        if (!path.empty() && !path.ends_with(".json") && is_of_space != in_space)
            throw Failure(
                path + (in_space ? ": for a figure in space the cage is an .obj file, the picture a .png file"
                                 : ": for a figure in the plane the cage is an .svg or .csv file, the "
                                   "picture an .svg file"));
    }
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Makes a cage around any figure: an SVG drawing of filled shapes, strokes and scattered "
                     "parts, or a mesh. A mesh may have holes or several pieces.");
    line.set_examples({"icon.svg --vertices 16 -o cage.svg --picture numbers.svg --png",
                       "character.obj --vertices 112 -o cage.obj --picture cage.png",
                       "character.obj --vertices auto --volume 15% -o cage.obj",
                       "icon.svg --lattice 4x4 -o icon.lattice.json --picture numbers.svg"});
    Arguments given;
    line.add("figure", given.figure, "an SVG file, or in space a mesh: any faces").required();
    add_shape(line, given, add_size(line, given));
    add_outputs(line, given);
    line.set_footer(lattice_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    check_options(given);
    const bool in_space = is_mesh_path(given.figure);
    auto& options = given.options;
    options.vertices = given.vertices.count;
    if (given.vertices.fewest && options.looseness == 0) options.looseness = in_space ? 0.25 : 0.05;
    options.one_cage = !given.parts;
    return in_space ? cage_in_space(given) : cage_in_plane(given);
}

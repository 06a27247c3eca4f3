// Wraps one figure onto another: the source takes the shape of the target and keeps its own faces. Clothes,
// hair, joints and morph targets of the source follow.
//
//     wrap_mesh body.obj scan.obj -o wrapped.obj --follow dress.obj:dress_on_scan.obj --picture wrap.png
//     wrap_mesh man.obj child.obj -o wrapped.obj --landmarks pairs.csv --follow bones.csv:child_bones.csv
//     wrap_mesh man.glb child.obj -o child.glb --follow coat.glb:coat_on_child.glb --push-out 0.05% --report
//
// The map is the pose of a lattice, or of a cage. It moves all of space (fit/wrap.hpp).

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/followers.hpp"
#include "cli/wrap_choice.hpp"
#include "cli/wrap_report.hpp"
#include "files/bind_report.hpp"
#include "files/obj_parts.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"
#include "pictures/view_choice.hpp"
#include "pictures/wrap_picture.hpp"

#include <iostream>

namespace {

using namespace cageform_support;

struct Arguments {
    std::string source, target, out, picture;
    WrapChoice choice;
    std::vector<std::string> follow, morphs; // IN:OUT
    bool drops_skins = false, is_strict = false, report = false;
    ViewChoice view;
};

constexpr const char* pairs_format =
    "--follow IN:OUT and --morph IN:OUT may be given several times. A follower is a mesh in\n"
    "the place and size of the source, or a CSV file of points. A morph is the source with\n"
    "its vertices moved, such as a smile. Morph targets of glTF files follow by themselves.\n"
    "\n"
    "Percentages are relative to the target's height: its extent along the longest principal\n"
    "axis of the source.\n"
    "\n"
    "--report prints a row for each step of the search:\n"
    "  basis        the cage, or the cells of a lattice along the height\n"
    "  handles      points of the cage or lattice that move\n"
    "  stiffness    weight of the rigidity\n"
    "  iterations   number of solves\n"
    "  rms          how far the matches pull the source after the step\n"
    "  held places  places that are held back, so that space does not fold\n"
    "  kept         mean share of the step that the handles took\n"
    "stretch is the smallest and the largest factor by which a length changes.\n";

/// Reads a figure that needs a surface.
MeshFile read_surface(const std::string& path, bool is_strict) {
    MeshFile figure = load_mesh_figure(path, is_strict);
    if (figure.triangles.empty()) throw Failure(path + ": has no faces, and a wrap needs a surface");
    return figure;
}

/// The source's file on the target.
struct Wrapped {
    std::vector<Point3> places, guides;
    std::vector<Jacobian3> jacobians; // empty if not needed

    Wrapped(const Arguments& given, const MeshFile& source, const WrapMap& map)
        : places(source.vertices.size())
        , guides(source.guides.size()) {
        if (!source.normals.empty() || !source.guides.empty() || !given.morphs.empty())
            jacobians.resize(places.size());
        map.move(source.vertices, places, jacobians, source.name);
        map.move(source.guides, guides, {}, source.name);
    }
    MovedVertices moved(const Arguments& given) const {
        return {places, jacobians, guides, given.drops_skins};
    }
};

Picture draw(const Arguments& given, const WrapFigures& figures, const Wrapped& wrapped,
             const std::vector<Follower>& followers, const WrapSurfaces& surfaces) {
    std::vector<double> distances;
    for (const Point3& p : wrapped.places) {
        const Point3 off = surfaces.target.find(p).place - p;
        distances.push_back(100 * std::sqrt(dot(off, off)) / surfaces.height);
    }
    const auto& [source, target] = std::tie(figures.source, figures.target);
    WrapScene scene{{source.vertices, source.triangles}, {target.vertices, target.triangles},
                    {wrapped.places, source.triangles},  distances,
                    scale_of_distances(distances),       {}};
    for (const Follower& follower : followers)
        scene.followers.push_back({follower.moved(), follower.mesh().triangles, follower.table().segments});
    return draw_wrap(scene, given.view.sight);
}

/// What the program has read.
struct Inputs {
    MeshFile source, target;
    std::vector<Follower> followers;
    std::vector<MorphFile> morphs;
};

Inputs read_inputs(const Arguments& given) {
    Inputs inputs{
        read_surface(given.source, given.is_strict), read_surface(given.target, given.is_strict), {}, {}};
    fail_if(fault_of_extension(inputs.source, given.out));
    for (const std::string& word : given.follow)
        inputs.followers.push_back(Follower::read(word, given.is_strict));
    for (const std::string& word : given.morphs)
        inputs.morphs.push_back(MorphFile::read(word, inputs.source, given.is_strict));
    return inputs;
}

WrapFigures figures_of(const Arguments& given, const Inputs& inputs) {
    const auto& [source, target] = std::tie(inputs.source, inputs.target);
    WrapFigures figures{source, target, welded_surface(source), welded_surface(target), {}, {}, {}};
    figures.landmarks = value_or_fail(given.choice.landmarks.read({source.vertices, target.vertices}));
    MeshFile& enclosed = figures.enclosed;
    enclosed.name = source.name;
    enclosed.vertices = figures.source_surface.places;
    enclosed.triangles = figures.source_surface.triangles;
    for (const Follower& follower : inputs.followers) {
        const auto first = std::uint32_t(enclosed.vertices.size());
        const auto rest = follower.rest();
        figures.follow.insert(figures.follow.end(), rest.begin(), rest.end());
        if (given.choice.coordinates.facts().has_extension || follower.mesh().triangles.empty()) continue;
        enclosed.vertices.insert(enclosed.vertices.end(), rest.begin(), rest.end());
        for (const auto& [a, b, c] : follower.mesh().triangles)
            enclosed.triangles.push_back({first + a, first + b, first + c});
    }
    return figures;
}

int wrap_figures(const Arguments& given, Inputs inputs) {
    std::vector<std::filesystem::path> outs{given.out, given.choice.save_pose, given.picture};
    for (const Follower& follower : inputs.followers) outs.emplace_back(follower.out());
    for (const MorphFile& morph : inputs.morphs) outs.emplace_back(morph.out());
    const WrapFigures figures = figures_of(given, inputs);
    fail_if(fault_of_outputs(outs));
    const WrapMap map = given.choice.solve(figures);
    std::vector<std::string> warnings = warnings_of(map, figures);

    const Wrapped wrapped(given, inputs.source, map);
    const WrapSurfaces surfaces(figures, map.report.height);
    for (Follower& follower : inputs.followers) {
        follower.move(map);
        follower.push_out(surfaces, given.choice.push_out);
        warnings.push_back(follower.warning());
    }
    OutputFiles outputs;
    std::vector<std::string> notes;
    const auto keep = [&](const std::vector<std::string>& more) {
        notes.insert(notes.end(), more.begin(), more.end());
    };
    keep(value_or_fail(save_mesh(inputs.source, wrapped.moved(given), given.out, outputs)));
    keep({describe_materials(inputs.source, given.out)});
    for (const Follower& follower : inputs.followers) keep(follower.save(outputs));
    for (const MorphFile& morph : inputs.morphs)
        keep(morph.save(inputs.source, wrapped.moved(given), outputs));
    if (!given.choice.save_pose.empty()) outputs.add(given.choice.save_pose).write(map.saved_pose());
    if (!given.picture.empty())
        draw(given, figures, wrapped, inputs.followers, surfaces).write_png(outputs.add(given.picture));
    fail_if(outputs.commit());

    for (const std::string& text : warnings) warn(text);
    for (const std::string& text : notes) note(text);
    const auto& distance = map.report.to_target;
    std::cout << printable(given.out) << ": "
              << describe(distance, figures.source_surface.first[distance.farthest] + 1) << '\n';
    for (const Follower& follower : inputs.followers) std::cout << printable(follower.describe()) << '\n';
    if (given.report) std::cout << describe(map, figures);
    return 0;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Wraps one figure onto another: the source takes the shape of the target and keeps its "
                     "own faces. Clothes, hair, joints and morph targets of the source follow.");
    line.set_examples({"body.obj scan.obj -o wrapped.obj --picture wrap.png",
                       "body.obj scan.obj -o wrapped.obj --follow dress.obj:dress_on_scan.obj "
                       "--push-out 0.05% --report",
                       "man.glb child.obj -o child.glb --landmarks pairs.csv --follow "
                       "bones.csv:child_bones.csv"});
    Arguments given;
    line.add("source", given.source, "the figure to wrap: glTF, OBJ, PLY, STL or Medit").required();
    line.add("target", given.target,
             "the figure to wrap it onto, with any vertices and faces; it may be open or in parts")
        .required();
    line.add("-o,--output", given.out,
             "the source on the target, in the format of the source: .obj, .mesh, .glb, .gltf, .ply or .stl")
        .required()
        .ends_with(mesh_extensions);
    const auto add_pairs = [&](const char* name, std::vector<std::string>& words, const char* help) {
        line.add_text(
                name, [&words](const std::string& word) { words.push_back(word); }, help)
            .check([](const std::string& word) {
                std::string in, out;
                return parse_file_pair(word, in, out);
            })
            .in_order();
    };
    add_pairs("--follow", given.follow,
              "IN:OUT: a mesh, or a CSV file of points, that follows the source: "
              "dress.obj:dress_on_target.obj. May be given several times");
    add_pairs("--morph", given.morphs,
              "IN:OUT: the source with its vertices moved, whose displacements follow: "
              "smile.obj:smile_on_target.obj. May be given several times");
    given.choice.add_options(line);
    add_strict(line, given.is_strict);
    line.add_flag("--drop-skin", given.drops_skins,
                  "glTF: write skinned meshes without their skins; by default skins are kept, and their "
                  "joints follow");
    line.add("--picture", given.picture,
             "also draw source, target, wrapped source, followers, and distances from the target in colours, "
             "to a "
             "PNG file")
        .ends_with({".png"});
    given.view.add_options(line);
    line.add_flag("--report", given.report,
                  "print the steps of the search, distances, folds, landmarks and times");
    line.set_footer(mesh_formats + std::string("\n") + pairs_format + "\n" + point_table_format + "\n" +
                    landmarks_format + "\n" + lattice_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    fail_if(given.choice.fault());
    if (given.choice.push_out && given.follow.empty())
        throw Failure("--push-out is for --follow: give a follower too");
    return wrap_figures(given, read_inputs(given));
}

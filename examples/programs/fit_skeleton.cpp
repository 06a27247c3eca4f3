// Fits a skeleton to a sequence of meshes, and writes the figure with its skin and motion as glTF 2.0.
//
//     fit_skeleton rest.obj frames/*.obj -o skin.glb --bones auto --max-distance 0.2%
//     fit_skeleton rest.obj motion.mdd -o skin.glb --bones 20 --rate 24 --picture skin.png
//     fit_skeleton animated.glb -o skin.glb --animation walk
//
// Bones are fitted to the motion. They rotate, have joints and parents, and by default at most four move a
// vertex. The program converts any vertex animation for engines: cages, lattices, cloth. The method is that
// of Le and Deng, Smooth skinning decomposition with rigid bones, ACM TOG 31(6), 2012, with changes.

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/skeleton_choice.hpp"
#include "files/gltf_animation.hpp"
#include "files/gltf_skeleton.hpp"
#include "files/mdd_file.hpp"
#include "io/messages.hpp"
#include "pictures/skeleton_picture.hpp"
#include "pictures/view_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <map>

namespace {

using namespace cageform_support;

struct Arguments {
    std::string rest, animation, out, picture, axes = "x,y,z";
    std::string motion_name; // in the output
    std::vector<std::string> frames;
    double rate = 0; // 0: the times of an MDD file, else default_rate
    SkeletonChoice choice{.bones = "auto"};
    ViewChoice view;
    bool report = false, is_strict = false, flips_faces = false;
};

constexpr double default_rate = 30;

constexpr const char* frames_format =
    "The frames are meshes with the same vertices in the same order as the figure, or one\n"
    "MDD file. Files in the order of a shell pattern are sorted by number. An MDD file\n"
    "contains times, which --rate replaces. For MDD files of Blender, whose z axis is\n"
    "reversed, use --axes x,y,-z. Without frames, an animation of the glTF file is fitted:\n"
    "its nodes, skins and morph targets move the figure. The output has the new skeleton\n"
    "and its animation instead of them.\n";

std::string fault_of_axes(const std::string& word) {
    if (word == "x,y,z" || word == "x,y,-z" || word == "x,z,-y") return {};
    return detail::quoted(word) + " is none of x,y,z and x,y,-z and x,z,-y";
}

/// Converts positions from the axes of an MDD file to those of the figure.
void turn_axes(const std::string& axes, std::vector<std::vector<Point3>>& frames) {
    if (axes == "x,y,z") return;
    for (auto& frame : frames) {
        for (Point3& p : frame) p = axes == "x,y,-z" ? Point3{p[0], p[1], -p[2]} : Point3{p[0], p[2], -p[1]};
    }
}

/// Whether times are non-negative and ascend in single precision, the format of glTF.
bool ascend(std::span<const double> times) {
    for (std::size_t t = 0; t < times.size(); ++t) {
        if (!std::isfinite(times[t]) || times[t] < 0 || (t > 0 && !(float(times[t - 1]) < float(times[t]))))
            return false;
    }
    return true;
}

/// Samples an animation of the figure's file.
MddFile sample_animation(Arguments& given, const MeshFile& figure) {
    const auto* scene = dynamic_cast<const GltfScene*>(figure.document.get());
    if (scene == nullptr)
        throw Failure(figure.name + ": has no animation: give frames, which are meshes or one MDD file");
    const GltfIndex index = value_or_fail(find_animation(*scene, given.animation, figure.name));
    const auto animation = value_or_fail(GltfAnimation::read(*scene, index, figure.name));
    if (!animation.moves())
        throw Failure(figure.name + ": animation " + std::to_string(index) + " moves nothing in the scene");
    if (given.rate == 0) given.rate = default_rate;
    constexpr double most = 100000;
    if (!(animation.length() * given.rate <= most))
        throw Failure(figure.name + ": " + detail::short_number(given.rate) +
                      " frames per second are more than 100000 in all: give a smaller --rate");
    given.frames = {figure.name + ", animation " + std::to_string(index)};
    const GltfJson own_name = scene->document.array("animations")[index].value("name", GltfJson());
    if (own_name.is_string()) given.motion_name = own_name.get<std::string>();
    MddFile file;
    for (std::size_t k = 0; file.times.empty() || file.times.back() < double(float(animation.length()));
         ++k) {
        const double time = double(float(std::min(double(k) / given.rate, animation.length())));
        file.times.push_back(time);
        auto& places = file.frames.emplace_back(scene->positions(animation.pose_at(time)));
        for (const Point3& p : places) {
            if (!std::isfinite(float(p[0]) + float(p[1]) + float(p[2])))
                throw Failure(given.frames[0] + ": a vertex is not finite in single precision at " +
                              detail::short_number(time) + " s");
        }
    }
    return file;
}

/// Reads the frames. Vertices that a frame excludes are excluded from the figure too.
MddFile read_frames(Arguments& given, MeshFile& figure) {
    if (given.frames.size() == 1 && lowercase_extension(given.frames[0]) == ".mdd") {
        MddFile file = value_or_fail(load_mdd(given.frames[0], figure.vertices.size()));
        for (std::size_t t = 0; t < file.frames.size(); ++t) {
            std::vector<std::size_t> strays;
            for (std::size_t i = 0; i < figure.vertices.size(); ++i) {
                if (!cageform::is_finite(file.frames[t][i])) strays.push_back(i);
            }
            const std::string name = given.frames[0] + ": frame " + std::to_string(t) + ", ";
            fail_if(leave_out_also(figure, strays, name, given.is_strict));
        }
        turn_axes(given.axes, file.frames);
        if (const double first = file.times.empty() ? 0 : file.times[0]; first < 0 && given.rate == 0) {
            for (double& time : file.times) time -= first;
            note(given.frames[0] + ": the times of its frames are counted from the first, " +
                 detail::short_number(first));
        }
        if (given.rate == 0 && !ascend(file.times)) {
            note(given.frames[0] + ": the times of its frames do not ascend from 0 or later; " +
                 detail::short_number(default_rate) + " frames per second are used, as with --rate");
            given.rate = default_rate;
        }
        if (given.rate > 0) file.times.clear();
        return file;
    }
    for (const std::string& text : order_by_numbers(given.frames)) note(text);
    std::vector<std::vector<Point3>> frames;
    for (const std::string& path : given.frames) {
        if (lowercase_extension(path) == ".mdd")
            throw Failure(path + ": one MDD file holds all frames: give it alone, after " + given.rest);
        auto frame = value_or_fail(load_mesh(path, strays_of(given.is_strict)));
        fail_if(fault_of_frame(figure, frame));
        fail_if(leave_out_also(figure, frame.left_out, path + ": ", given.is_strict));
        fail_if(single_precision_fault(frame));
        frames.push_back(std::move(frame.vertices));
    }
    return {std::move(frames), {}};
}

/// Warns about the first frame that mirrors the figure, with a remedy.
void warn_of_mirrors(const Arguments& given, const FigureFrames& frames) {
    const auto mirrors = [&](const auto& frame) { return is_mirrored(frames.rest, frame); };
    const auto first = std::find_if(frames.places.begin(), frames.places.end(), mirrors);
    const bool has_all = std::all_of(frames.places.begin(), frames.places.end(), mirrors);
    const bool is_one_file = frames.files.size() != frames.places.size();
    const bool is_mdd = lowercase_extension(frames.files[0]) == ".mdd";
    if (first == frames.places.end()) {
        warn(describe_winding(frames.files[0], frames.name, side_of(frames.rest, frames.places[0]),
                              given.flips_faces));
        return;
    }
    if (has_all && is_mdd)
        return warn(frames.files[0] + ": every frame is a mirror image of " + frames.name +
                    "; for an MDD file of Blender give --axes x,y,-z");
    const auto number = std::size_t(first - frames.places.begin());
    const std::string name =
        is_one_file ? frames.files[0] + ", frame " + std::to_string(number) : frames.files[number];
    if (given.choice.kind != "stretched")
        return warn(name + ": the pose mirrors " + frames.name + ", and no bone of --kind " +
                    given.choice.kind + " does: give --kind stretched and --flip-faces" +
                    (given.flips_faces ? "; with --flip-faces alone all faces point inwards" : ""));
    if (!given.flips_faces) warn(describe_winding(name, frames.name, -1, false));
}

/// Returns the figure at rest. Files may round copies of a vertex differently. Copies that stay together in
/// all frames get the same position, at rest and in each frame, and therefore equal weights.
std::vector<Point3> join_copies(const MeshFile& figure, std::vector<std::vector<Point3>>& frames) {
    const double apart = 2e-6 * size_of(figure);
    std::vector<Point3> rest = joined_places(figure);
    std::map<std::array<double, 3>, std::vector<std::size_t>>
        known; // vertices that separate in a frame, by position
    for (std::size_t v = 0; v < rest.size(); ++v) {
        auto& parted = known[{rest[v][0], rest[v][1], rest[v][2]}];
        const auto first = std::find_if(parted.begin(), parted.end(), [&](std::size_t other) {
            return std::all_of(frames.begin(), frames.end(), [&](const auto& frame) {
                const Point3 gap = frame[v] - frame[other];
                return std::sqrt(dot(gap, gap)) <= apart;
            });
        });
        if (first == parted.end()) {
            rest[v] = figure.vertices[v];
            parted.push_back(v);
            continue;
        }
        rest[v] = rest[*first];
        for (auto& frame : frames) frame[v] = frame[*first];
    }
    return rest;
}

/// Reads the frames, fits, and writes the files.
int fit_figure(Arguments& given, MeshFile figure) {
    GltfFigure gltf = value_or_fail(gltf_figure(figure, "cageform fit_skeleton", GltfMotion::drop));
    auto read = given.frames.empty() ? sample_animation(given, figure) : read_frames(given, figure);
    auto& places = read.frames;
    const std::size_t sound = figure.triangles[0][0]; // excluded vertices get its position
    for (const std::size_t vertex : figure.left_out) {
        figure.vertices[vertex] = figure.vertices[sound];
        for (auto& frame : places) frame[vertex] = frame[sound];
    }
    if (places.size() < 2) {
        return fail(given.frames[0] + ": " + std::to_string(places.size()) +
                    (places.size() == 1 ? " frame" : " frames") + ": a motion has two or more");
    }
    fail_if(fault_of_outputs({given.out, given.picture}));
    const Point3 origin = far_origin(figure);
    figure.vertices = relative_to(origin, figure.vertices);
    for (auto& frame : places) frame = relative_to(origin, frame);
    const std::vector<Point3> rest = join_copies(figure, places);
    FigureFrames frames{figure.name,           rest,        figure.triangles, std::move(places),
                        std::move(read.times), given.frames};
    const double rate = given.rate > 0 ? given.rate : default_rate;
    while (frames.times.size() < frames.places.size())
        frames.times.push_back(double(float(double(frames.times.size()) / rate)));
    if (!ascend(frames.times)) return fail("--rate: the times of the frames are equal in single precision");

    warn_of_mirrors(given, frames);
    const auto motion = fit_motion(given.choice, frames);
    if (motion.loss.share() > PackingLoss::worth_a_warning) {
        warn(figure.name + ": " + describe_loss(motion) +
             "; use more --bones for a smaller error, or --bones auto with --max-distance");
    }
    print_warnings(gltf.warnings);
    for (const std::string& text : gltf.notes) note(text);
    add_skeleton(gltf, motion.skeleton, motion.keys, "float", given.motion_name, origin);

    OutputFiles outputs;
    const std::size_t bytes = value_or_fail(save_gltf(gltf.document, given.out, outputs));
    if (!given.picture.empty())
        draw_skeleton(frames, motion, given.view.sight).write_png(outputs.add(given.picture));
    fail_if(outputs.commit());
    std::cout << printable(describe_gltf(given.out, gltf, figure, count_bones(motion), bytes)) << '\n';
    if (given.report) std::cout << describe(motion) << gltf.unused;
    return 0;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Fits a skeleton to a sequence of meshes or an animation, and writes the figure with "
                     "its skin and its motion "
                     "as glTF 2.0.");
    line.set_examples({"rest.obj frame_*.obj -o skin.glb --bones auto --max-distance 0.2%",
                       "rest.obj motion.mdd -o skin.glb --bones 20 --rate 24 --picture skin.png --report",
                       "animated.glb -o skin.glb --animation walk"});
    Arguments given;
    line.add("figure", given.rest, "the mesh of the figure at rest, or an animated glTF file").required();
    const CommandOption frames = line.add(
        "frames", given.frames, "meshes, one per frame, or one MDD file; messages number frames from 0");
    line.add("--animation", given.animation,
             "without frames: the name or the number, from 0, of an animation of the glTF file; by default "
             "the "
             "first")
        .excludes(frames);
    line.add("-o,--output", given.out, "the file to write: .glb or .gltf")
        .required()
        .ends_with({".glb", ".gltf"});
    line.add("--bones", given.choice.bones, "the number of bones, or auto: as few as --max-distance needs")
        .check(SkeletonChoice::fault_of_bones)
        .show_default();
    add_share(line, "--max-distance", given.choice.distance,
              "the largest distance of a vertex from its frames, a share of the figure's size at rest such "
              "as 0.002 or 0.2%. 0 means no bound, but 0.2% with --bones auto")
        .show_default("0");
    given.choice.add_options(line);
    line.add("--rate", given.rate,
             "frames per second: frame k is at k / RATE seconds. By default the times of an MDD file, and 30 "
             "per second for meshes and animations")
        .range(1e-3, 1e6);
    line.add("--axes", given.axes,
             "the axes of the MDD file: x,y,z; x,y,-z as Blender writes; or x,z,-y if y is up in the MDD "
             "file and z in the figure")
        .check(fault_of_axes)
        .show_default();
    line.add("--picture", given.picture,
             "also draw frames to a PNG file: as given, as played with the distances in colours, and the "
             "bones")
        .ends_with({".png"});
    given.view.add_options(line);
    add_strict(line, given.is_strict);
    add_flip_faces(line, given.flips_faces);
    line.add_flag("--report", given.report, "print bones, keys, distances and times");
    line.set_footer(mesh_formats + std::string("\n") + frames_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    given.motion_name = std::filesystem::path(given.rest).stem().string();

    auto figure = load_mesh_figure(given.rest, given.is_strict);
    fail_if(single_precision_fault(figure));
    if (given.flips_faces) {
        fail_if(fault_of_reversing(figure));
        figure = with_faces_reversed(std::move(figure));
    }
    return fit_figure(given, std::move(figure));
}

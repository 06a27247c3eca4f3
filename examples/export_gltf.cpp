// Writes an OBJ figure that moves with its cage as glTF 2.0, for engines and viewers that know no cages.
//
//     export_gltf character.obj --cage character_cage.obj --clip character_clip.csv --skin 8 -o character.glb
//     export_gltf character.obj --cage character_cage.obj --clip character_clip.csv --morph -o character.gltf
//
// --skin K: every vertex of the cage is a joint that is only moved, every vertex of the figure follows K of them at most.
// Affine poses stay exact, bends lose what the left out weights did; normals do not turn, as no joint does. What is lost
// is measured over the motion; --max-distance 0.001 takes as many joints as keep every vertex that near, as a share of the
// figure's size.
//
// --morph: every pose of the motion is a morph target, made by the real clone, normals included. Clones depend linearly on
// the pose, and so do the curves between poses, so positions are those of the clone at all times.
//
// The motion is a clip (support/clip_file.hpp), or goes from the rest pose through those given and back. Either way it is
// written with CUBICSPLINE interpolation, without loss. Materials and groups of the OBJ file are left out.

#include "atomic_file.hpp"
#include "bind_report.hpp"
#include "command_line.hpp"
#include "coordinates.hpp"
#include "csv.hpp"
#include "gltf_file.hpp"
#include "guard.hpp"
#include "mesh_cage.hpp"
#include "progress_bar.hpp"

#include <cageform/clone/clone.hpp>

#include <iostream>

namespace {

using namespace cageform_examples;
using cageform::Binding;
using cageform::SkinWeights;
using cageform::Status;
using Use = GltfDocument::Use;

struct Arguments {
    std::string figure, cage, clip, labels, out;
    std::vector<std::string> poses;
    std::string weights = "float";
    OutsideChoice outside{.can_extend = false};
    std::size_t influences = 0; // 0: morph targets
    double threshold = 0, seconds = 1;
    double distance = 0; // share of the figure's size; 0: no promise
    bool morph = false, report = false;
    CoordinatesChoice choice;
};

/// All that is read.
struct Scene {
    ObjFile figure, cage;
    GltfMesh mesh;
    PoseClip clip;                   // without keys: no motion
    std::vector<std::string> labels; // of the cage's vertices, empty where one has none; or none at all
};

/// A skin as the file stores it.
SkinWeights stored(const SkinWeights& skin, const std::string& weights) {
    SkinWeights result = skin;
    const auto take = [&](const auto& integers) {
        using Integer = typename std::decay_t<decltype(integers)>::value_type;
        for (std::size_t n = 0; n < integers.size(); ++n)
            result.weights[n] = float(integers[n]) / float(std::numeric_limits<Integer>::max());
    };
    if (weights == "unorm8") take(cageform::to_normalised<std::uint8_t>(skin));
    if (weights == "unorm16") take(cageform::to_normalised<std::uint16_t>(skin));
    return result;
}

/// The largest distances between the vertices of a figure as it ought to be and as it is.
class LossMeter {
public:
    explicit LossMeter(const ObjFile& figure)
        : distances_(figure.vertices.size(), 0.0) {
        loss_.size = cageform::bounds_of(std::span<const Point3>(figure.vertices)).diagonal();
    }

    /// Over all poses in which no vertex of the cage bends farther.
    void set_reach(double reach) { loss_.reach = reach; }
    void raise(std::size_t i, double distance, std::optional<double> time) {
        distances_[i] = std::max(distances_[i], distance);
        if (distance <= loss_.largest) return;
        loss_.largest = distance;
        loss_.vertex = i;
        loss_.time = time;
    }
    void add_pose(std::span<const Point3> a, std::span<const Point3> b, double time) {
        ++loss_.poses;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const Point3 d = a[i] - b[i];
            raise(i, std::hypot(d[0], d[1], d[2]), time);
        }
    }
    StoredLoss loss() const {
        StoredLoss loss = loss_;
        for (const double distance : distances_) loss.mean += distance / double(distances_.size());
        return loss;
    }

private:
    StoredLoss loss_;
    std::vector<double> distances_; // the largest of every vertex
};

/// One of the poses.
cageform::StridedPoints<const double, 3> pose_of(const SampledPoses& poses, std::size_t p) {
    const std::size_t numbers = poses.numbers.size() / poses.times.size();
    return {poses.numbers.data() + p * numbers, numbers / 3};
}

/// The distance between the figure as bound and as it is played from a skin, over the motion. Without a motion, over
/// all poses that bend by no more than a tenth of the cage: then by the changes of weights alone.
StoredLoss loss_of(const Scene& scene, const Binding<double, 3>& bound, const Binding<double, 3>& played) {
    LossMeter meter(scene.figure);
    if (scene.clip.keys.empty()) {
        const double reach =
            0.1 * cageform::bounds_of(std::span<const Point3>(scene.cage.vertices)).diagonal();
        meter.set_reach(reach);
        for (std::size_t i = 0; i < bound.point_count(); ++i) {
            double error = 0;
            for (std::size_t h = 0; h < bound.handle_count(); ++h)
                error += std::fabs(played.weight(i, h) - bound.weight(i, h));
            meter.raise(i, reach * error, {});
        }
    } else {
        const SampledPoses poses = sample_poses(scene.clip);
        std::vector<Point3> a(bound.point_count()), b(a);
        for (std::size_t p = 0; p < poses.times.size(); ++p) {
            const auto pose = pose_of(poses, p);
            if (clone(bound, pose, a) == Status::ok && clone(played, pose, b) == Status::ok)
                meter.add_pose(a, b, poses.times[p]);
        }
    }
    return meter.loss();
}

std::string stem(const std::string& path) {
    return std::filesystem::path(path).stem().string();
}

/// Appends an animation of one sampler a channel; `track` gives that of a node.
struct Channel {
    std::size_t node;
    const char* path;
    std::vector<double> values; // of every key
    std::size_t components;
};
std::string add_animation(GltfDocument& document, const PoseClip& clip, std::span<const Channel> channels) {
    GltfJson animation = {{"name", stem(clip.name)}};
    std::size_t input = 0;
    for (const Channel& channel : channels) {
        const auto track = gltf_track(clip, channel.values, channel.components);
        if (track.status != Status::ok) return clip.name + ": " + cageform::to_string(track.status);
        if (&channel == channels.data()) {
            std::vector<std::array<float, 1>> times;
            for (const float time : track.times) times.push_back({time});
            input = document.add(times, Use::other, true);
        }
        std::size_t output = 0;
        if (channel.components == 3 && std::string_view(channel.path) == "translation") {
            std::vector<std::array<float, 3>> values;
            for (std::size_t i = 0; i < track.values.size(); i += 3)
                values.push_back({track.values[i], track.values[i + 1], track.values[i + 2]});
            output = document.add(values, Use::other);
        } else {
            std::vector<std::array<float, 1>> values;
            for (const float value : track.values) values.push_back({value});
            output = document.add(values, Use::other);
        }
        animation["samplers"].push_back(
            {{"input", input}, {"interpolation", "CUBICSPLINE"}, {"output", output}});
        animation["channels"].push_back({{"sampler", animation["samplers"].size() - 1},
                                         {"target", {{"node", channel.node}, {"path", channel.path}}}});
    }
    document.append("animations", std::move(animation));
    return {};
}

/// The mesh at rest, its attributes to be completed.
GltfJson primitive_of(GltfDocument& document, const Scene& scene) {
    GltfJson attributes;
    attributes["POSITION"] =
        document.add(gltf_positions(scene.mesh, scene.figure.vertices), Use::vertices, true);
    attributes["NORMAL"] =
        document.add(gltf_normals(scene.mesh, scene.figure, scene.figure.vertices), Use::vertices);
    if (!scene.mesh.texture.empty())
        attributes["TEXCOORD_0"] = document.add(scene.mesh.texture, Use::vertices);
    std::size_t indices = 0;
    if (scene.mesh.corners.size() < 65535) { // 3.7.2.1: the largest index is not a vertex
        std::vector<std::array<std::uint16_t, 1>> narrow;
        for (const auto& index : scene.mesh.indices) narrow.push_back({std::uint16_t(index[0])});
        indices = document.add(narrow, Use::indices);
    } else {
        indices = document.add(scene.mesh.indices, Use::indices);
    }
    document.append(
        "materials",
        {{"name", "clay"},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {0.72, 0.36, 0.2, 1.0}}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.7}}}});
    return {{"attributes", std::move(attributes)}, {"indices", indices}, {"material", 0}};
}

std::array<double, 3> rounded(const Point3& p) { // as the buffers have it
    return {double(float(p[0])), double(float(p[1])), double(float(p[2]))};
}

/// A skin: nodes are the mesh, the cage and its vertices.
std::string add_skin(GltfDocument& document, const Scene& scene, const Arguments& given,
                     const SkinWeights& skin, bool with_still) {
    const std::size_t handles = scene.cage.vertices.size(), joints = handles + (with_still ? 1 : 0);
    constexpr std::size_t figure_node = 0, root_node = 1, first_joint = 2;
    if (joints > 65536) return scene.cage.name + ": more vertices than glTF has joints";
    GltfJson primitive = primitive_of(document, scene);
    const auto add_attributes = [&]<class Weight>(const std::vector<Weight>& weights) {
        GltfJson& attributes = primitive["attributes"];
        const std::span<const Weight> all(weights);
        if (joints <= 256)
            add_skin_attributes<std::uint8_t>(document, attributes, scene.mesh, skin, all, handles);
        else
            add_skin_attributes<std::uint16_t>(document, attributes, scene.mesh, skin, all, handles);
    };
    if (given.weights == "unorm8")
        add_attributes(cageform::to_normalised<std::uint8_t>(skin));
    else if (given.weights == "unorm16")
        add_attributes(cageform::to_normalised<std::uint16_t>(skin));
    else
        add_attributes(skin.weights);
    document.append("meshes", {{"name", stem(given.figure)}, {"primitives", {std::move(primitive)}}});

    document.append("nodes", {{"name", stem(given.figure)}, {"mesh", 0}, {"skin", 0}});
    GltfJson root = {{"name", stem(given.cage)}};
    GltfJson list;
    for (std::size_t j = 0; j < joints; ++j) list.push_back(first_joint + j);
    root["children"] = list;
    document.append("nodes", std::move(root));
    std::vector<std::array<float, 16>> inverse;
    for (std::size_t j = 0; j < joints; ++j) {
        const auto at = j < handles ? rounded(scene.cage.vertices[j]) : std::array<double, 3>{};
        std::string name = j < handles ? "handle " + std::to_string(j) : "still";
        if (j < scene.labels.size() && !scene.labels[j].empty()) name = scene.labels[j];
        document.append("nodes", {{"name", name}, {"translation", at}});
        inverse.push_back(
            {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -float(at[0]), -float(at[1]), -float(at[2]), 1});
    }
    document.append("skins", {{"inverseBindMatrices", document.add(inverse, Use::other)},
                              {"skeleton", root_node},
                              {"joints", std::move(list)}});
    document.append("scenes", {{"nodes", {figure_node, root_node}}});
    if (scene.clip.keys.empty()) return {};

    std::vector<Channel> channels;
    for (std::size_t j = 0; j < handles; ++j) {
        Channel channel{first_joint + j, "translation", {}, 3};
        for (const PoseKey& key : scene.clip.keys) {
            for (std::size_t axis = 0; axis < 3; ++axis) channel.values.push_back(key.places[j][axis]);
        }
        channels.push_back(std::move(channel));
    }
    return add_animation(document, scene.clip, channels);
}

/// The motion of all handles, whose values between the keys go the way of the vertices' own. Warns of how far that is
/// from the vectors of a moving face.
SvgResult<PoseClip> clip_of_handles(const Scene& scene, const Binding<double, 3>& binding) {
    PoseClip motion = scene.clip;
    std::vector<std::string> warnings;
    for (PoseKey& key : motion.keys) {
        std::string warning;
        auto posed = pose_of_handles(binding, key.places, name_of_pose(scene.clip, key.time), warning);
        if (!posed) return posed.error();
        if (!warning.empty()) warnings.push_back(std::move(warning));
        key.places = std::move(*posed);
    }
    print_warnings(warnings);
    if (binding.handle_view().vector_count() == 0) return motion;
    const SampledPoses exact = sample_poses(scene.clip), linear = sample_poses(motion);
    std::vector<Point3> a(binding.point_count()), b(a), handles(binding.handle_count());
    LossMeter meter(scene.figure);
    for (std::size_t p = 0; p < exact.times.size(); ++p) {
        if (pose_handles(binding, pose_of(exact, p), handles).status == Status::ok &&
            clone(binding, handles, a) == Status::ok && clone(binding, pose_of(linear, p), b) == Status::ok)
            meter.add_pose(a, b, exact.times[p]);
    }
    const StoredLoss loss = meter.loss();
    if (loss.share() > StoredLoss::worth_a_warning) {
        warn(scene.figure.name + ": between the keys targets are off by " + describe(loss) +
             "; more keys bring them nearer");
    }
    return motion;
}

/// Morph targets: one for every key whose pose is not that at rest.
std::string add_targets(GltfDocument& document, const Scene& scene, const Arguments& given,
                        const Binding<double, 3>& binding) {
    GltfJson primitive = primitive_of(document, scene);
    const auto rest = gltf_positions(scene.mesh, scene.figure.vertices);
    const auto rest_normals = gltf_normals(scene.mesh, scene.figure, scene.figure.vertices);
    const auto difference = [](std::vector<std::array<float, 3>> a,
                               const std::vector<std::array<float, 3>>& b) {
        for (std::size_t i = 0; i < a.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) a[i][k] -= b[i][k];
        }
        return a;
    };
    GltfJson names, zeros;
    const auto motion = clip_of_handles(scene, binding);
    if (!motion) return motion.error().message;
    const PoseClip& of_handles = *motion;
    std::vector<std::size_t> keys; // of the targets
    std::vector<Point3> moved(scene.figure.vertices.size());
    for (std::size_t k = 0; k < scene.clip.keys.size(); ++k) {
        if (scene.clip.keys[k].places == scene.cage.vertices) continue;
        const Status status = clone(binding, of_handles.keys[k].places, moved);
        if (status != Status::ok) return scene.clip.name + ": " + cageform::to_string(status);
        for (const Point3& p : moved) {
            if (!std::isfinite(float(p[0]) + float(p[1]) + float(p[2])))
                return scene.figure.name + ": a vertex has moved beyond all numbers";
        }
        const auto shift = difference(gltf_positions(scene.mesh, moved), rest);
        const auto turn = difference(gltf_normals(scene.mesh, scene.figure, moved), rest_normals);
        primitive["targets"].push_back({{"POSITION", document.add(shift, Use::vertices, true)},
                                        {"NORMAL", document.add(turn, Use::vertices)}});
        keys.push_back(k);
        names.push_back(given.poses.empty() ? "key " + std::to_string(k) : stem(given.poses[k - 1]));
        zeros.push_back(0.0);
    }
    if (keys.empty()) return scene.clip.name + ": every pose is that at rest";
    document.append("meshes", {{"name", stem(given.figure)},
                               {"primitives", {std::move(primitive)}},
                               {"weights", zeros},
                               {"extras", {{"targetNames", std::move(names)}}}});
    document.append("nodes", {{"name", stem(given.figure)}, {"mesh", 0}});
    document.append("scenes", {{"nodes", {0}}});
    Channel channel{0, "weights", {}, keys.size()};
    for (std::size_t k = 0; k < scene.clip.keys.size(); ++k) {
        for (const std::size_t key : keys) channel.values.push_back(key == k ? 1.0 : 0.0);
    }
    return add_animation(document, scene.clip, std::span(&channel, 1));
}

/// The skin that was asked for, or the one of the fewest sets of four joints that keeps the distance; what it loses.
cageform::SkinWeightsResult make_skin(const Arguments& given, const Scene& scene,
                                      const Binding<double, 3>& bound, StoredLoss& loss) {
    constexpr std::size_t set = 4, most = 16; // joints
    const bool search = given.influences == 0;
    for (std::size_t influences = search ? set : given.influences;; influences += set) {
        cageform::SkinWeightsResult made;
        {
            ProgressBar bar("weights");
            made = cageform::skin_weights(bound, {.influences = influences, .threshold = given.threshold},
                                          {.progress = bar.callback()});
        }
        Binding<double, 3> played;
        if (made.report.status == Status::ok)
            made.report.status = skin_to_binding(bound, stored(made.skin, given.weights), played);
        if (made.report.status != Status::ok) return made;
        loss = loss_of(scene, bound, played);
        if (!search || influences == most || loss.share() <= given.distance) return made;
    }
}

/// Binds the figure and writes what was asked for.
int export_figure(const Arguments& given, const Scene& scene) {
    const ObjFile &figure = scene.figure, &cage = scene.cage;
    const auto coordinates = make_coordinates<double>(given.choice, cage);
    warn_of_closed_gaps(cage.name, coordinates->cage_report);
    if (!coordinates->note.empty()) note(coordinates->note);
    cageform::BindOptions options;
    options.outside = given.outside.policy(*coordinates);
    cageform::BindResult<double, 3> bound;
    {
        ProgressBar bar("binding");
        bound = coordinates->bind(figure.vertices, options, {.progress = bar.callback()});
    }
    const auto& report = bound.report;
    if (report.status != Status::ok) return fail(describe_mesh_faults(cage.name, report));
    warn_of_coarse_grid(cage.name, report.solver);
    const auto outside = given.outside.judge(*coordinates, report, figure.vertices, figure.name, cage.name);
    if (!outside.fault.empty()) return fail(outside.fault);
    if (!outside.warning.empty()) warn(outside.warning);
    if (given.report) std::cout << describe(report);

    GltfDocument document;
    document.json["scene"] = 0;
    std::string why;
    if (given.morph) {
        why = add_targets(document, scene, given, bound.binding);
    } else {
        StoredLoss loss;
        const cageform::SkinWeightsResult made = make_skin(given, scene, bound.binding, loss);
        const auto& skin = made.report;
        if (skin.status != Status::ok) return fail(cage.name + ": " + cageform::to_string(skin.status));
        if (given.distance > 0 && loss.share() > given.distance) {
            return fail(figure.name + ": a skin of " + std::to_string(made.skin.influences) +
                        " joints a vertex is off by " + describe(loss) + ": a larger --max-distance" +
                        (given.influences == 0 ? "" : ", a larger --skin,") + " or --morph");
        }
        if (loss.share() > StoredLoss::worth_a_warning) {
            warn(figure.name + ": a skin of " + std::to_string(made.skin.influences) +
                 " joints a vertex is off by " + describe(loss) + "; --max-distance bounds it");
        }
        if (!skin.not_reproduced.empty()) {
            warn(std::to_string(made.skin.influences) + " weights are too few for " +
                 std::to_string(skin.not_reproduced.size()) + " vertices of " + figure.name +
                 ", which affine poses will move otherwise, by up to " +
                 detail::short_number(skin.reproduction_error.value) + ", first " +
                 name_points(figure.vertices, skin.not_reproduced));
        }
        if (given.report) {
            std::cout << "skin: " << made.skin.influences << " weights at most, " << skin.mean_influences
                      << " in the mean\n"
                      << "largest sum |w - w0|: " << skin.weight_error.value << " at point "
                      << skin.weight_error.point << ", mean " << skin.mean_weight_error << '\n'
                      << "not reproduced: " << skin.not_reproduced.size()
                      << "; largest |sum w c - p|: " << skin.reproduction_error.value << "\noff by "
                      << describe(loss) << "\ntime: " << skin.seconds << " s\n";
        }
        why = add_skin(document, scene, given, made.skin, !skin.without_weights.empty());
    }
    if (!why.empty()) return fail(why);

    const bool binary = std::filesystem::path(given.out).extension() != ".gltf";
    if (document.bytes() > 0x7fffffff) return fail(given.out + ": would be larger than the format allows");
    const std::string text = document.text(binary);
    if (const auto error = write_file_atomically(given.out, text)) return fail(*error);
    std::cout << printable(given.out) << ": " << scene.mesh.corners.size() << " vertices, "
              << figure.triangles.size() << " triangles, "
              << (given.morph ? std::to_string(document.json["meshes"][0]["weights"].size()) + " targets"
                              : std::to_string(document.json["skins"][0]["joints"].size()) + " joints")
              << ", " << text.size() << " bytes\n";
    return 0;
}

int run_program(int argc, char** argv) {
    CommandLine line(
        "Writes an OBJ figure that moves with its cage as glTF 2.0: as a skin or as morph targets.");
    Arguments given;
    line.add("figure", given.figure, "the OBJ file").required();
    line.add("--cage", given.cage,
             "its cage: an OBJ file of a closed mesh, faces counter-clockwise seen from outside")
        .required();
    const CommandOption clip = line.add("--clip", given.clip, "the motion: a CSV file of poses");
    line.add("--pose", given.poses, "or poses of the cage, OBJ files: from rest through these and back")
        .excludes(clip);
    line.add("--seconds", given.seconds, "from one pose to the next").range(0.001, 1e5).show_default();
    const CommandOption labels =
        line.add("--labels", given.labels,
                 "of a skin: names of the joints, which are the cage's vertices: a text file");
    const CommandOption skin =
        line.add("--skin", given.influences, "a skin of at most so many joints a vertex").range(1, 16);
    const CommandOption distance =
        line.add("--max-distance", given.distance,
                 "of a skin: no vertex farther from where all weights put it, as a share of the figure's "
                 "size, in the poses of the motion, or in all that bend by up to a tenth of the cage; "
                 "without --skin, 4, 8, 12 or 16 joints, as few as do. 0: no bound")
            .range(0.0, 1.0)
            .show_default();
    line.add_flag("--morph", given.morph, "morph targets, one a pose")
        .excludes(skin)
        .excludes(distance)
        .excludes(labels);
    line.add("--weights", given.weights, "of a skin: float, unorm8 or unorm16 (normalised integers)")
        .one_of({"float", "unorm8", "unorm16"})
        .show_default();
    line.add("--threshold", given.threshold, "of a skin: lesser weights are left out")
        .range(0.0, 1.0)
        .show_default();
    line.add("-o,--output", given.out, "the file to write: .glb or .gltf")
        .required()
        .ends_with({".glb", ".gltf"});
    given.choice.with_normals = given.choice.in_space = true;
    given.choice.add_options(line);
    given.outside.add_option(line);
    line.add_flag("--report", given.report, "print the bind report, and what the skin loses");
    line.set_footer(
        obj_format +
        std::string("Vertices keep the order of the file: a vertex that needs several normals or\n"
                    "texture coordinates is there once more, behind all others.\n\n") +
        pose_clip_format + "\n" + labels_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    if (!given.morph && given.influences == 0 && given.distance == 0)
        return fail("--skin, --max-distance or --morph says what to write");
    if (!given.morph && given.choice.takes_normals())
        return fail("--coordinates green: joints carry no normals of faces; --morph writes targets");
    if (given.morph && given.clip.empty() && given.poses.empty())
        return fail("morph targets are made of poses: --clip or --pose");

    Scene scene;
    auto figure = load_obj(given.figure);
    if (!figure) return fail(to_string(figure.error()));
    auto mesh = gltf_mesh(*figure);
    if (!mesh) return fail(to_string(mesh.error()));
    auto cage = load_mesh_cage(given.cage);
    if (!cage) return fail(to_string(cage.error()));
    if (!given.labels.empty()) {
        auto read = read_labels(given.labels, cage->vertices.size());
        if (!read) return fail(to_string(read.error()));
        scene.labels = std::move(*read);
    }
    if (!given.clip.empty() || !given.poses.empty()) {
        auto motion = given.clip.empty() ? clip_through_poses(*cage, given.poses, given.seconds)
                                         : load_pose_clip(given.clip, cage->vertices.size());
        if (!motion) return fail(to_string(motion.error()));
        scene.clip = std::move(*motion);
    }
    scene.figure = std::move(*figure);
    scene.cage = std::move(*cage);
    scene.mesh = std::move(*mesh);
    for (const auto* file : {&scene.figure, &scene.cage}) { // glTF's numbers
        if (const auto fault = single_precision_fault(*file)) return fail(to_string(*fault));
    }
    return export_figure(given, scene);
}

} // namespace

int main(int argc, char** argv) {
    return guarded("export_gltf", [&] { return run_program(argc, argv); });
}

// Computes bone weights for a figure, and poses the figure by its bones.
//
//     skin_mesh character.obj --bones character.bones.csv --weights heat -o skinned.glb --picture skinned.png
//
// Writes a skin and a skeleton as glTF 2.0, animated from rest to the pose of the bones file and back.
// Weights are bone heat (Baran, Popović 2007) or harmonic on the surface (fields/skin.hpp).

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/progress_bar.hpp"
#include "files/bind_report.hpp"
#include "files/gltf_skeleton.hpp"
#include "files/welded_mesh.hpp"
#include "io/atomic_file.hpp"
#include "io/messages.hpp"
#include "pictures/mesh_picture.hpp"
#include "pictures/view_choice.hpp"

#include <cageform/binding/bind_bones.hpp>
#include <cageform/clone/clone.hpp>
#include <cageform/clone/pose_handles.hpp>
#include <cageform/fields/skin.hpp>

#include <algorithm>
#include <iostream>
#include <numbers>

namespace {

using namespace cageform_support;
using cageform::Status;
using Move = cageform::Transform<double, 3>;
using Use = GltfDocument::Use;

constexpr const char* bones_format =
    "A bones file has one line per bone: its name, its parent, x,y,z of its head, x,y,z of\n"
    "its tail, and x,y,z of its pose. The pose is a rotation about the head: the vector is\n"
    "the axis, and its length is the angle in degrees, at most 36000. 0,0,0\n"
    "is no rotation.\n"
    "Parents come before their children; a bone without a parent leaves that field\n"
    "empty. Lines that begin with # are skipped.\n";

constexpr std::size_t no_parent = GltfJoint::no_parent;
constexpr double most_degrees = 36000; // for larger angles keys would be too close

struct Bone {
    std::string name;
    std::size_t parent = no_parent;
    cageform::BoneSegment segment{};
    Point3 turn{}; // degrees
};

struct Arguments {
    std::string figure, bones, out, picture, red, blue;
    std::string weights = "heat";
    std::size_t influences = 4;
    bool sees_through = false, report = false, is_strict = false;
    ViewChoice view;
};

// ---- the bones ----

double degrees_of(const Bone& bone) {
    return std::hypot(bone.turn[0], bone.turn[1], bone.turn[2]);
}

/// Parses a bone; returns the fault, or empty.
std::string parse_bone(std::string_view line, const std::vector<Bone>& bones, Bone& bone) {
    const auto fields = detail::cells_of(line, 11);
    if (fields.size() != 11)
        return std::to_string(fields.size()) + " columns, where a bone has 11: name,parent,x,y,z,x,y,z,x,y,z";
    const auto number_of = [&](std::string_view name) {
        const auto at =
            std::find_if(bones.begin(), bones.end(), [&](const Bone& b) { return b.name == name; });
        return at == bones.end() ? no_parent : std::size_t(at - bones.begin());
    };
    bone.name = fields[0];
    if (bone.name.empty()) return "the bone has no name";
    if (number_of(fields[0]) != no_parent) return "there are two bones " + detail::quoted(fields[0]);
    if (!fields[1].empty() && (bone.parent = number_of(fields[1])) == no_parent)
        return "the parent " + detail::quoted(fields[1]) + " has to come before its child";
    std::array<Point3*, 3> places{&bone.segment.head, &bone.segment.tail, &bone.turn};
    for (std::size_t n = 0; n < 9; ++n) {
        double& number = (*places[n / 3])[n % 3];
        std::string why = detail::parse_number(fields[2 + n], number);
        if (why.empty()) why = detail::single_precision_fault(number); // the format of glTF
        if (!why.empty()) return "column " + std::to_string(3 + n) + ": " + why;
    }
    if (degrees_of(bone) > most_degrees)
        return "the bone " + detail::quoted(bone.name) + " turns by " +
               detail::short_number(degrees_of(bone)) + " degrees, more than " +
               detail::short_number(most_degrees);
    return {};
}

std::vector<Bone> load_bones(const std::string& path) {
    const auto file = value_or_fail(read_text(path));
    std::vector<Bone> bones;
    detail::RowFilter rows;
    std::string_view text = file, line;
    for (std::size_t number = 1; take_line(text, line); ++number) {
        if (!rows.take(line)) continue;
        Bone bone;
        const std::string why = parse_bone(line, bones, bone);
        if (!why.empty()) throw Failure(to_string(detail::row_fault(path, number, line, why)));
        bones.push_back(std::move(bone));
    }
    if (bones.empty()) throw Failure(path + ": holds no bones");
    return bones;
}

/// A rotation by a fraction of the pose's angle, as a quaternion x, y, z, w.
std::array<double, 4> quaternion(const Bone& bone, double share) {
    const double degrees = degrees_of(bone);
    const double half = share * degrees * std::numbers::pi / 360;
    const double factor = degrees > 0 ? std::sin(half) / degrees : 0;
    return {factor * bone.turn[0], factor * bone.turn[1], factor * bone.turn[2], std::cos(half)};
}

/// Posed bones: each rotates about its head and moves with its parent.
std::vector<Move> pose_of(const std::vector<Bone>& bones) {
    std::vector<Move> moves;
    for (const Bone& bone : bones) {
        const auto [x, y, z, w] = quaternion(bone, 1);
        Move own{{{{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
                   {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                   {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}}},
                 {}};
        own.translation = bone.segment.head - own.map_vector(bone.segment.head);
        if (bone.parent != no_parent) {
            const Move& parent = moves[bone.parent];
            for (auto& column : own.columns) column = parent.map_vector(column);
            own.translation = parent.map_vector(own.translation) + parent.translation;
        }
        moves.push_back(own);
    }
    return moves;
}

// ---- the skin ----

/// Explains why there are no weights, with the culprit.
std::string why_not(const Arguments& given, const MeshFile& figure, const std::vector<Bone>& bones,
                    const cageform::SurfaceSkinReport& report) {
    if (report.mesh.mesh.status != Status::ok) {
        cageform::BindReport faults;
        faults.status = report.mesh.mesh.status;
        faults.cage = report.mesh.mesh;
        std::string text = describe_mesh_faults(figure.name, faults);
        if (const std::size_t at = text.find("the cage"); at != std::string::npos)
            text.replace(at, 8, "the mesh");
        return text;
    }
    if (report.status == Status::cells_unreached) {
        return figure.name + ": no bone moves the part of the mesh about " +
               name_points(figure.vertices, {report.solver.culprit}) +
               (given.weights == "heat" && !given.sees_through
                    ? ", whose vertices do not see their nearest bones"
                    : "");
    }
    return (report.status == Status::value_not_finite ? bones[report.solver.culprit].name : figure.name) +
           ": " + cageform::to_string(report.status);
}

/// Copies weights of places to the vertices of the file.
std::vector<double> spread(const WeldedMesh& mesh, std::span<const double> weights, std::size_t bones) {
    std::vector<double> result;
    for (const std::uint32_t place : mesh.place_of) {
        const auto row = weights.subspan(place * bones, bones);
        result.insert(result.end(), row.begin(), row.end());
    }
    return result;
}

/// Averages the weights of vertices at the same position, in place.
void average(const WeldedMesh& mesh, std::vector<double>& weights, std::size_t bones) {
    std::vector<double> sums(mesh.places.size() * bones, 0.0), counts(mesh.places.size(), 0.0);
    for (std::size_t v = 0; v < mesh.place_of.size(); ++v) {
        const std::size_t place = mesh.place_of[v];
        ++counts[place];
        for (std::size_t b = 0; b < bones; ++b) sums[place * bones + b] += weights[v * bones + b];
    }
    for (std::size_t n = 0; n < sums.size(); ++n) sums[n] /= counts[n / bones];
    weights = spread(mesh, sums, bones);
}

/// The posed figure, by linear blend skinning.
std::vector<Point3> posed(const MeshFile& figure, const std::vector<Bone>& bones,
                          std::span<const double> weights) {
    std::vector<Move> frames;
    for (const Bone& bone : bones) frames.push_back({{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, bone.segment.head});
    const auto bound = cageform::bind_bones(figure.vertices, std::span<const Move>(frames), weights);
    std::vector<Point3> handles(bound.value.handle_count()), moved(figure.vertices.size());
    Status status = bound.report.status;
    const std::vector<Move> moves = pose_of(bones);
    if (status == Status::ok) status = pose_bones(bound.value, std::span<const Move>(moves), handles);
    if (status == Status::ok) status = clone(bound.value, handles, moved);
    if (status != Status::ok) throw Failure(figure.name + ": " + cageform::to_string(status));
    return moved;
}

/// The weights of a skin, #points · #bones.
std::vector<double> dense_weights(const cageform::SkinWeights& skin, std::size_t bones) {
    std::vector<double> weights(skin.weights.size() / skin.influences * bones, 0.0);
    for (std::size_t n = 0; n < skin.weights.size(); ++n)
        weights[n / skin.influences * bones + skin.joints[n]] += double(skin.weights[n]);
    return weights;
}

/// Distances between exact and stored positions.
PackingLoss loss_of(const MeshFile& figure, std::span<const Point3> right, std::span<const Point3> moved) {
    PackingLoss loss;
    loss.size = cageform::bounds_of(std::span<const Point3>(figure.vertices)).diagonal();
    loss.poses = 1;
    for (std::size_t i = 0; i < moved.size(); ++i) {
        const Point3 d = moved[i] - right[i];
        const double off = std::hypot(d[0], d[1], d[2]);
        loss.mean += off / double(moved.size());
        if (off > loss.largest) loss.vertex = i;
        loss.largest = std::max(loss.largest, off);
    }
    return loss;
}

/// Appends the animation to the pose and back in two seconds.
///
///   nodes   #bones
void add_turns(GltfDocument& document, const std::vector<Bone>& bones, std::span<const GltfIndex> nodes) {
    GltfJson animation = {{"name", "pose"}};
    double largest = 0;
    for (const Bone& bone : bones) largest = std::max(largest, degrees_of(bone));
    // Interpolation is linear between keys; keys are at most 36 degrees apart, so speed is nearly constant.
    const std::size_t keys = 16 * std::max<std::size_t>(std::size_t(std::ceil(largest / 180)), 1) + 1;
    std::vector<double> times;
    for (std::size_t k = 0; k < keys; ++k) times.push_back(double(2 * float(k) / float(keys - 1)));
    GltfIndex input = gltf_none;
    for (std::size_t b = 0; b < bones.size(); ++b) {
        if (bones[b].turn == Point3{}) continue;
        std::vector<std::array<float, 4>> turns;
        for (std::size_t k = 0; k < keys; ++k) {
            const double share = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * double(k) / double(keys - 1));
            const auto q = quaternion(bones[b], share);
            turns.push_back({float(q[0]), float(q[1]), float(q[2]), float(q[3])});
        }
        if (input == gltf_none) input = add_scalars(document, times, true);
        add_channel(animation, nodes[b], "rotation", input, "LINEAR", document.add(turns, Use::other));
    }
    if (animation.contains("channels")) document.append("animations", std::move(animation));
}

/// Adds the bones as nodes, the skin and the animation.
void add_bones(GltfFigure& gltf, const Point3& origin, const std::vector<Bone>& bones,
               const cageform::SkinWeights& skin) {
    std::vector<GltfJoint> list;
    for (const Bone& bone : bones) list.push_back({bone.name, bone.segment.head - origin, bone.parent});
    const GltfJoints joints = add_joints(gltf.document, "skeleton", origin, list);
    add_skin(gltf, joints, skin, "float", 0);
    add_turns(gltf.document, bones, joints.nodes);
}

/// The bone with a name; `otherwise` for an empty name.
std::size_t bone_named(const Arguments& given, const std::vector<Bone>& bones, const std::string& name,
                       std::size_t otherwise) {
    if (name.empty()) return otherwise;
    const auto at = std::ranges::find(bones, name, &Bone::name);
    if (at == bones.end()) throw Failure(given.bones + ": there is no bone " + detail::quoted(name));
    return std::size_t(at - bones.begin());
}

/// The bones whose weights are painted. By default the bone with the largest rotation is blue, and its parent
/// red.
struct PaintedBones {
    std::size_t blue = 0, red = 0;
};

PaintedBones painted_bones(const Arguments& given, const std::vector<Bone>& bones) {
    std::size_t turned = 0;
    const auto angle = [&](std::size_t b) { return dot(bones[b].turn, bones[b].turn); };
    for (std::size_t b = 1; b < bones.size(); ++b) turned = angle(b) > angle(turned) ? b : turned;
    const std::size_t blue = bone_named(given, bones, given.blue, turned);
    const std::size_t parent = bones[blue].parent;
    return {blue, bone_named(given, bones, given.red, parent == no_parent ? blue : parent)};
}

using Skin = cageform::Result<std::vector<double>, cageform::SurfaceSkinReport>;

/// The weights of bones, #points · #bones. Vertices of a mesh that is not closed see all bones.
template <class Triangles>
Skin skin_of(const Arguments& given, const std::string& name, const std::vector<Point3>& points,
             const Triangles& triangles, const std::vector<Bone>& bones) {
    std::vector<cageform::BoneSegment> segments;
    for (const Bone& bone : bones) segments.push_back(bone.segment);
    cageform::SurfaceSkinOptions options;
    if (given.sees_through) options.visibility = cageform::BoneVisibility::ignored;
    const auto compute = [&] {
        ProgressBar bar("weights");
        const cageform::Running running{.progress = bar.callback()};
        return given.weights == "heat"
                   ? cageform::bone_heat(points, triangles, segments, options, running)
                   : cageform::harmonic_skin(points, triangles, segments, options, running);
    };
    auto made = compute();
    if (made.report.status != Status::cage_not_closed || given.sees_through) return made;
    note(name + ": the mesh is not closed, so that nothing is inside it: every vertex sees its nearest "
                "bone, as with --see-through");
    options.visibility = cageform::BoneVisibility::ignored;
    return compute();
}

/// The weights at the vertices of the file, equal at equal positions.
Skin skin_of(const Arguments& given, const MeshFile& figure, const std::vector<Bone>& bones) {
    const WeldedMesh joined = welded_mesh(figure);
    Skin made = skin_of(given, figure.name, joined.places, joined.triangles, bones);
    if (made.report.status == Status::ok) {
        made.value = spread(joined, made.value, bones.size());
    } else if (made.report.mesh.mesh.status != Status::ok) { // touching sheets are not manifold when merged
        made = skin_of(given, figure.name, figure.vertices, figure.triangles, bones);
        if (made.report.status == Status::ok) average(joined, made.value, bones.size());
    } else if (made.report.status == Status::cells_unreached) {
        made.report.solver.culprit = joined.first[made.report.solver.culprit];
    }
    if (made.report.status != Status::ok) throw Failure(why_not(given, figure, bones, made.report));
    for (const std::size_t b : made.report.idle_bones) {
        warn(given.bones + ": " + bones[b].name +
             " is not the nearest bone of any vertex that it could move: all its weights are 0");
    }
    return made;
}

/// The figure as players show it, with positions in single precision.
MeshFile shown_figure(const MeshFile& figure, const MeshFile& stored, const Point3& origin) {
    MeshFile shown = figure;
    for (std::size_t i = 0; i < shown.vertices.size(); ++i)
        shown.vertices[i] = rounded_to_single(stored.vertices[i]) + origin;
    return shown;
}

/// Notes the errors in players that read four bones per vertex, if the skin has more.
///
///   right   the exact pose
void note_loss_of_four(const MeshFile& figure, const MeshFile& shown, const std::vector<Bone>& bones,
                       std::span<const double> weights, const cageform::SkinWeights& skin,
                       std::span<const Point3> right) {
    const std::size_t sets = joint_sets(skin);
    if (sets <= 1) return;
    const auto four = cageform::skin_weights(weights, bones.size(), {.influences = 4}).value;
    const auto loss = [&](const cageform::SkinWeights& read) {
        return describe(loss_of(figure, right, posed(shown, bones, dense_weights(read, bones.size()))));
    };
    note(figure.name + ": " + describe_sets(sets) + "such a player is off by " + loss(first_set(skin)) +
         "; a skin of four (--skin 4) is off by " + loss(four));
}

/// Draws the figure at rest and posed, with colours for the weights of two bones.
Picture draw_weights(const Arguments& given, const MeshFile& figure, std::span<const Point3> moved,
                     std::span<const double> weights, std::size_t bones, const PaintedBones& painted) {
    std::vector<Colour> paint;
    constexpr Colour clay{0.93f, 0.93f, 0.9f}, red{0.85f, 0.15f, 0.12f}, blue{0.12f, 0.25f, 0.85f};
    for (std::size_t i = 0; i < figure.vertices.size(); ++i) {
        const auto share = [&](std::size_t b) { return float(weights[i * bones + b]); };
        const float r = painted.red == painted.blue ? 0 : share(painted.red), b = share(painted.blue);
        const float rest = std::max(1 - r - b, 0.0f);
        paint.push_back({rest * clay.r + r * red.r + b * blue.r, rest * clay.g + r * red.g + b * blue.g,
                         rest * clay.b + r * red.b + b * blue.b});
    }
    const std::array<MeshScene, 2> scenes{
        {{{figure.vertices, figure.triangles, paint}, {}}, {{moved, figure.triangles, paint}, {}}}};
    return draw_meshes(scenes, 1600, 1000, given.view.sight);
}

int skin_figure(const Arguments& given, const MeshFile& figure, const std::vector<Bone>& bones) {
    const PaintedBones painted = painted_bones(given, bones);
    GltfFigure gltf = value_or_fail(gltf_figure(figure, "cageform skin_mesh", GltfMotion::without_skin));
    fail_if(fault_of_outputs({given.out, given.picture}));
    const auto [weights, report] = skin_of(given, figure, bones);
    auto [skin, kept] = cageform::skin_weights(std::span<const double>(weights), bones.size(),
                                               {.influences = given.influences});
    if (kept.status != Status::ok) return fail(given.bones + ": " + cageform::to_string(kept.status));
    make_sums_exact(skin);
    const Point3 origin = far_origin(figure);
    MeshFile stored = figure;
    stored.vertices = relative_to(origin, figure.vertices);
    const MeshFile shown = shown_figure(figure, stored, origin);
    const auto written = dense_weights(skin, bones.size());
    const auto right = posed(figure, bones, weights), moved = posed(shown, bones, written);
    PackingLoss loss = loss_of(figure, right, moved);
    loss.largest += single_precision_error(used_positions(stored.vertices, stored.triangles));
    note_loss_of_four(figure, shown, bones, weights, skin, right);
    if (loss.share() > PackingLoss::worth_a_warning) {
        warn(figure.name + ": a skin of " + std::to_string(skin.influences) + " bones per vertex is off by " +
             describe(loss) + "; a larger --skin reduces the error");
    }
    print_warnings(gltf.warnings);
    for (const std::string& text : gltf.notes) note(text);
    add_bones(gltf, origin, bones, skin);
    OutputFiles outputs;
    const std::size_t bytes = value_or_fail(save_gltf(gltf.document, given.out, outputs));
    if (!given.picture.empty())
        draw_weights(given, figure, moved, written, bones.size(), painted)
            .write_png(outputs.add(given.picture));
    fail_if(outputs.commit());
    std::cout << printable(
                     describe_gltf(given.out, gltf, figure, detail::counted(bones.size(), "bone"), bytes))
              << '\n';
    if (given.report) {
        std::cout << gltf.unused << "flipped edges: " << report.mesh.flips
                  << "\nnegative cotangent weights: " << report.mesh.negative_weights
                  << "\nvertices that do not see their nearest bones: " << report.hidden
                  << "\nbones per vertex, mean: " << kept.mean_influences << "\nlargest sum |w - w0| of "
                  << given.influences << " bones per vertex: " << kept.weight_error.value << "\noff by "
                  << describe(loss) << "\ntime: " << report.seconds << " s\n";
    }
    return 0;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line(
        "Finds the weights of bones on a figure, and writes the figure with its skin as glTF 2.0.");
    line.set_examples(
        {"character.obj --bones character.bones.csv -o skinned.glb",
         "character.obj --bones character.bones.csv --weights heat -o skinned.glb --picture skinned.png"});
    Arguments given;
    line.add("figure", given.figure, "the mesh, preferably closed").required();
    line.add("--bones", given.bones, "its bones: a CSV file").required();
    line.add("--weights", given.weights,
             "heat (from the nearest bone that a vertex sees) or harmonic (1 on the middle third of each "
             "bone, harmonic between)")
        .one_of({"heat", "harmonic"})
        .show_default();
    line.add("--skin", given.influences, "the largest number of bones per vertex in the file")
        .range(1, 16)
        .show_default();
    line.add_flag("--see-through", given.sees_through,
                  "heat: ignore visibility, as if the mesh were not closed");
    line.add("-o,--output", given.out, "the file to write: .glb or .gltf")
        .required()
        .ends_with({".glb", ".gltf"});
    line.add("--picture", given.picture, "also draw the figure at rest and posed to a PNG file")
        .ends_with({".png"});
    given.view.add_options(line);
    line.add("--blue", given.blue,
             "the bone whose weight is painted blue; by default the one that turns most");
    line.add("--red", given.red,
             "the bone whose weight is painted red; by default the parent of the blue one");
    add_strict(line, given.is_strict);
    line.add_flag("--report", given.report,
                  "print flipped edges, hidden vertices and the error of the stored skin");
    line.set_footer(mesh_formats + std::string("\n") + bones_format);
    if (const auto code = line.parse(argc, argv)) return *code;

    const auto figure = load_mesh_figure(given.figure, given.is_strict);
    if (figure.faces.empty()) return fail(figure.name + ": holds no faces");
    fail_if(single_precision_fault(figure));
    return skin_figure(given, figure, load_bones(given.bones));
}

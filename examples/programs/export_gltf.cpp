// Writes a figure that moves with its cage as glTF 2.0, for engines and viewers without cages.
//
//     export_gltf head.obj --cage head_cage.obj --clip head_clip.csv --bones auto -o head.glb
//     export_gltf head.obj --cage head_cage.obj --clip head_clip.csv --skin 16 -o head.glb
//     export_gltf head.obj --cage head_cage.obj --clip head_clip.csv --morph -o head.gltf
//
// --bones N or auto: a skeleton fitted to the motion. Bones rotate, and normals with them; by default at most
// four bones move a vertex. --max-distance 0.2% uses the fewest bones for which every vertex is within this
// distance of its clone in all frames.
//
// --skin K: every vertex of the cage is a joint that only translates, and every vertex of the figure has at
// most K joints. Joints are chosen so that the surface stays smooth. Affine poses are exact; in bends the
// omitted weights cause errors. Normals do not rotate, because joints do not. The errors of positions, edges
// and normals are measured over the motion. --max-distance 0.1% uses the fewest joints within the distance.
// This form is for games that pose the cage themselves.
//
// --morph: every pose of the motion is a morph target with normals. Clones depend linearly on the pose, so
// positions are exact at all times.
//
// The motion is a clip (support/files/clip_file.hpp), or goes from the rest pose through the given poses
// (files, or operations such as --twist) and back. --skin and --morph write it with CUBICSPLINE
// interpolation, without loss. The document of a .glb or .gltf file is kept: its nodes, materials, animations
// and morph targets. A new skin replaces an old one. Each object of an OBJ file is a node, each of its
// materials a primitive with colours and texture of the MTL file.

#include "cli/auto_cage.hpp"
#include "cli/command_line.hpp"
#include "cli/coordinates.hpp"
#include "cli/mesh_cage.hpp"
#include "cli/motion_choice.hpp"
#include "cli/progress_bar.hpp"
#include "cli/skeleton_choice.hpp"
#include "files/bind_report.hpp"
#include "files/gltf_skeleton.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"
#include "pictures/skeleton_picture.hpp"
#include "pictures/view_choice.hpp"

#include <cageform/binding/smooth_skin_weights.hpp>
#include <cageform/clone/jacobians.hpp>

#include <iostream>
#include <sstream>

namespace {

using namespace cageform_support;
using cageform::Binding;
using cageform::SkinWeights;
using cageform::Status;
using BoundAxes = std::array<Binding<double, 3>, 3>;

struct Arguments {
    std::string figure, cage, labels, out, picture;
    MotionChoice moves;
    std::string weights = "float";
    OutsideChoice outside{.can_extend = false, .can_fade = false};
    SkeletonChoice skeleton; // its distance also applies to skins
    double rate = 30;
    ViewChoice view;
    std::size_t influences = 0; // of --skin; 0: search
    double threshold = 0;
    bool morph = false, report = false, is_strict = false, flips_faces = false;
    CoordinatesChoice choice;
};

/// The input.
struct Scene {
    MeshFile figure, cage;
    Point3 origin;                   // of the positions in the file
    MeshFile stored;                 // the figure, relative to the origin
    PoseClip clip;                   // without keys: no motion
    std::vector<std::string> labels; // of the cage's vertices, "" without a label; or empty
};

/// The largest distances between exact and approximate vertices of a figure.
class LossMeter {
public:
    explicit LossMeter(const MeshFile& figure)
        : distances_(figure.vertices.size(), 0.0) {
        loss_.size = size_of(figure);
    }

    /// Upper bounds over all poses within this distance of an affine motion.
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
    PackingLoss loss() const {
        PackingLoss loss = loss_;
        for (const double distance : distances_) loss.mean += distance / double(distances_.size());
        return loss;
    }

private:
    PackingLoss loss_;
    std::vector<double> distances_; // the largest per vertex
};

/// A pose of the motion.
cageform::StridedPoints<const double, 3> pose_of(const SampledPoses& poses, std::size_t p) {
    const std::size_t numbers = poses.numbers.size() / poses.times.size();
    return {poses.numbers.data() + p * numbers, numbers / 3};
}

/// Errors of a skin relative to the clone: positions, edges and normals of the surface.
struct SkinLoss {
    PackingLoss places;
    double edge = 0;       // the largest error of an edge
    double edge_share = 0; // the largest error relative to the edge
    double turn = 0;       // the 99 % quantile of the errors of vertex normals, in degrees; of a motion
    double largest_turn = 0;
};

constexpr double warning_angle = 10; // degrees, of 99 % of the normals

/// "edges by at most 0.0041 (0.1 % of the figure's size, 4 % of the edge), …".
std::string describe_surface(const SkinLoss& loss) {
    std::ostringstream text;
    text.precision(3);
    text << "edges by at most " << loss.edge << " (" << 100 * loss.edge / loss.places.size << " % of "
         << loss.places.size_of;
    if (loss.places.poses == 0) {
        text << ')';
    } else {
        text << "), or " << 100 * loss.edge_share << " % of an edge; normals by at most " << loss.largest_turn
             << " degrees, 99 % of them by " << loss.turn << " at most";
    }
    return text.str();
}

/// Vertex normals for the positions `places`, not normalised.
std::vector<Point3> normals_of(const MeshFile& figure, std::span<const Point3> places) {
    std::vector<Point3> normals(places.size());
    for (const MeshFace& face : figure.faces) {
        const Point3 area = detail::area_vector(face, places);
        for (const MeshCorner& corner : face.corners) normals[corner.vertex] = normals[corner.vertex] + area;
    }
    return normals;
}

double length(const Point3& v) {
    return std::hypot(v[0], v[1], v[2]);
}

/// Compares an exact and an approximate pose; appends the angles between normals to `turns`.
void add_surface(const MeshFile& figure, std::span<const Point3> right, std::span<const Point3> played,
                 SkinLoss& loss, std::vector<float>& turns) {
    for (const auto& triangle : figure.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
            const Point3 edge = right[b] - right[a];
            const double difference = length(played[b] - played[a] - edge), own = length(edge);
            loss.edge = std::max(loss.edge, difference);
            if (own > 1e-9 * loss.places.size) loss.edge_share = std::max(loss.edge_share, difference / own);
        }
    }
    const auto before = normals_of(figure, right), after = normals_of(figure, played);
    constexpr double degrees = 180 / 3.14159265358979323846;
    for (std::size_t i = 0; i < before.size(); ++i) {
        if (!(length(before[i]) > 0) || !(length(after[i]) > 0)) continue;
        turns.push_back(
            float(degrees * std::atan2(length(cross(before[i], after[i])), dot(before[i], after[i]))));
    }
}

/// The figure as a player of the file shows it, with the vertices of the cage as translating joints.
void play_skin(const Scene& scene, const SkinWeights& skin, cageform::StridedPoints<const double, 3> pose,
               std::span<Point3> places) {
    std::vector<Point3> moves;
    for (std::size_t j = 0; j < scene.cage.vertices.size(); ++j)
        moves.push_back(rounded_to_single(pose[j] - scene.origin) -
                        rounded_to_single(scene.cage.vertices[j] - scene.origin));
    for (std::size_t i = 0; i < places.size(); ++i) {
        const Point3 rest = rounded_to_single(scene.stored.vertices[i]);
        const std::size_t first = i * skin.influences;
        places[i] = skin.weights[first] == 0 ? rest + scene.origin : Point3{}; // the fixed joint
        for (std::size_t k = first; k < first + skin.influences; ++k)
            places[i] = places[i] + double(skin.weights[k]) * (rest + moves[skin.joints[k]] + scene.origin);
    }
}

/// The errors of a skin over the motion. Without a motion, upper bounds over all poses within a
/// tenth of the cage's size of an affine motion, from the changes of weights.
///
///   skin     as stored in the file
///   played   the binding of its weights
SkinLoss loss_of(const Scene& scene, const Binding<double, 3>& bound, const Binding<double, 3>& played,
                 const SkinWeights& skin) {
    LossMeter meter(scene.figure);
    SkinLoss loss;
    if (scene.clip.keys.empty()) {
        const double reach =
            0.1 * cageform::bounds_of(std::span<const Point3>(scene.cage.vertices)).diagonal();
        meter.set_reach(reach);
        const auto change = [&](std::size_t i, std::size_t h) {
            return played.weight(i, h) - bound.weight(i, h);
        };
        for (std::size_t i = 0; i < bound.point_count(); ++i) {
            double error = 0;
            for (std::size_t h = 0; h < bound.handle_count(); ++h) error += std::fabs(change(i, h));
            meter.raise(i, reach * error, {});
        }
        for (const auto& triangle : scene.figure.triangles) {
            for (std::size_t k = 0; k < 3; ++k) {
                double error = 0;
                for (std::size_t h = 0; h < bound.handle_count(); ++h)
                    error += std::fabs(change(triangle[k], h) - change(triangle[(k + 1) % 3], h));
                loss.edge = std::max(loss.edge, reach * error);
            }
        }
        loss.places = meter.loss();
        return loss;
    }
    loss.places = meter.loss(); // sets the size
    const SampledPoses poses = sample_poses(scene.clip);
    std::vector<Point3> a(bound.point_count()), b(a);
    std::vector<float> turns;
    for (std::size_t p = 0; p < poses.times.size(); ++p) {
        const auto pose = pose_of(poses, p);
        if (clone(bound, pose, a) != Status::ok) continue;
        play_skin(scene, skin, pose, b);
        meter.add_pose(a, b, poses.times[p]);
        add_surface(scene.figure, a, b, loss, turns);
    }
    loss.places = meter.loss();
    loss.places.largest +=
        single_precision_error(used_positions(scene.stored.vertices, scene.stored.triangles));
    if (!turns.empty()) {
        const auto at = turns.begin() + std::ptrdiff_t(0.99 * double(turns.size() - 1));
        std::nth_element(turns.begin(), at, turns.end());
        loss.turn = double(*at);
        loss.largest_turn = double(*std::max_element(at, turns.end()));
    }
    return loss;
}

std::string stem(const std::string& path) {
    return std::filesystem::path(path).stem().string();
}

/// Appends the animation of a clip.
void add_motion(GltfFigure& gltf, const PoseClip& clip, std::span<const GltfTrackOfNode> tracks) {
    const Status status = add_clip(gltf.document, clip, stem(clip.name), tracks);
    if (status != Status::ok) throw Failure(clip.name + ": " + cageform::to_string(status));
}

/// Adds a skin whose joints are the vertices of the cage.
void add_handles(GltfFigure& gltf, const Scene& scene, const Arguments& given, const SkinWeights& skin,
                 bool with_still) {
    const std::size_t handles = scene.cage.vertices.size();
    if (handles + (with_still ? 1 : 0) > 65536)
        throw Failure(scene.cage.name + ": more vertices than glTF has joints");
    std::vector<GltfJoint> joints;
    for (std::size_t j = 0; j < handles; ++j) {
        const bool has_label = j < scene.labels.size() && !scene.labels[j].empty();
        joints.push_back({has_label ? scene.labels[j] : "handle " + std::to_string(j),
                          scene.cage.vertices[j] - scene.origin});
    }
    if (with_still) joints.push_back({"still", {}});
    const GltfJoints added = add_joints(gltf.document, stem(scene.cage.name), scene.origin, joints);
    add_skin(gltf, added, skin, given.weights, handles);
    if (scene.clip.keys.empty()) return;
    std::vector<GltfTrackOfNode> tracks;
    for (std::size_t j = 0; j < handles; ++j) {
        GltfTrackOfNode& track = tracks.emplace_back(GltfTrackOfNode{added.nodes[j], "translation", {}, 3});
        for (const PoseKey& key : scene.clip.keys) {
            const Point3 place = key.places[j] - scene.origin;
            track.values.insert(track.values.end(), std::begin(place.v), std::end(place.v));
        }
    }
    add_motion(gltf, scene.clip, tracks);
}

/// The motion of all handles, with the interpolation of the vertices. Warns about the error for normals of
/// moving faces.
PoseClip clip_of_handles(const Scene& scene, const Binding<double, 3>& binding) {
    PoseClip motion = scene.clip;
    std::vector<std::string> warnings;
    for (PoseKey& key : motion.keys) {
        std::string warning;
        key.places =
            value_or_fail(pose_of_handles(binding, key.places, name_of_pose(scene.clip, key.time), warning));
        if (!warning.empty()) warnings.push_back(std::move(warning));
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
    const PackingLoss loss = meter.loss();
    if (loss.share() > PackingLoss::worth_a_warning) {
        warn(scene.figure.name + ": between the keys the targets are off by " + describe(loss) +
             "; more keys reduce this");
    }
    return motion;
}

/// The poses of a motion that differ from the rest pose.
struct Targets {
    std::vector<std::size_t> keys; // of the clip
    std::vector<GltfPoseTarget> poses;
};

///   axes   bound at the vertices; empty if normals are computed from the faces
Targets targets_of(const Arguments& given, const Scene& scene, const Binding<double, 3>& binding,
                   const BoundAxes& axes) {
    Targets targets;
    const PoseClip motion = clip_of_handles(scene, binding);
    for (std::size_t k = 0; k < scene.clip.keys.size(); ++k) {
        if (scene.clip.keys[k].places == scene.cage.vertices) continue;
        GltfPoseTarget& pose = targets.poses.emplace_back();
        pose.name = given.moves.poses.empty() ? "key " + std::to_string(k) : stem(given.moves.poses[k - 1]);
        pose.places.resize(scene.figure.vertices.size());
        const Status status = clone(binding, motion.keys[k].places, pose.places);
        if (status != Status::ok) throw Failure(scene.clip.name + ": " + cageform::to_string(status));
        const std::vector<Point3> moved = relative_to(scene.origin, pose.places);
        for (const Point3& p : moved) {
            if (!std::isfinite(float(p[0]) + float(p[1]) + float(p[2])))
                throw Failure(scene.figure.name + ": a vertex is not finite in the pose");
        }
        warn(rounding_fault(name_of_pose(scene.clip, motion.keys[k].time), moved));
        const bool has_axes = axes[0].point_count() == moved.size();
        pose.jacobians.resize(has_axes ? moved.size() : 0);
        if (has_axes)
            (void)clone_jacobians(axes, motion.keys[k].places,
                                  cageform::StridedMatrices<double, 3>(pose.jacobians[0][0].v, moved.size()));
        targets.keys.push_back(k);
    }
    if (targets.keys.empty()) throw Failure(scene.clip.name + ": every pose equals the rest pose");
    return targets;
}

/// Adds morph targets, one for every key whose pose is not the rest pose.
void add_morphs(GltfFigure& gltf, const Scene& scene, const Targets& targets) {
    std::vector<GltfTrackOfNode> tracks;
    for (const GltfMorphs& morphs : value_or_fail(add_targets(gltf, scene.figure, targets.poses))) {
        GltfTrackOfNode& track = tracks.emplace_back(
            GltfTrackOfNode{morphs.node, "weights", {}, morphs.weights.size() + targets.keys.size()});
        for (std::size_t k = 0; k < scene.clip.keys.size(); ++k) {
            track.values.insert(track.values.end(), morphs.weights.begin(), morphs.weights.end());
            for (const std::size_t key : targets.keys) track.values.push_back(key == k ? 1.0 : 0.0);
        }
    }
    add_motion(gltf, scene.clip, tracks);
}

/// Clones of the figure in all frames of the motion; the last frame is the first pose again.
FigureFrames frames_of(const Arguments& given, const Scene& scene, const Binding<double, 3>& bound) {
    constexpr double most = 100000;
    if (given.rate * scene.clip.length > most)
        throw Failure(scene.clip.name + ": " + detail::short_number(given.rate) +
                      " frames per second are more than 100000 in all: give a smaller --rate");
    FigureFrames frames{scene.figure.name, scene.stored.vertices, scene.figure.triangles, {}, {}, {}};
    const SampledPoses poses = sample_poses(scene.clip, given.rate);
    std::vector<Point3> handles(bound.handle_count());
    for (std::size_t p = 0; p <= poses.times.size(); ++p) {
        const bool is_last = p == poses.times.size();
        const double time = double(float(is_last ? scene.clip.length : poses.times[p]));
        if (p > 0 && !(frames.times.back() < time)) continue; // equal in single precision
        const auto pose = pose_of(poses, is_last ? 0 : p);
        auto& places = frames.places.emplace_back(scene.figure.vertices.size());
        Status status = Status::ok;
        if (bound.handle_view().vector_count() == 0) {
            status = clone(bound, pose, places);
        } else {
            status = pose_handles(bound, pose, handles).status;
            if (status == Status::ok) status = clone(bound, handles, places);
        }
        if (status != Status::ok)
            throw Failure(name_of_pose(scene.clip, time) + ": " + cageform::to_string(status));
        places = relative_to(scene.origin, places);
        frames.times.push_back(time);
    }
    return frames;
}

constexpr std::size_t joint_set = 4, most_joints = 16;
constexpr std::size_t enough_joints = 12; // fewer joints without rotations distort the surface

/// A skin of `influences` joints per vertex, and its errors.
cageform::Result<cageform::SkinWeights, cageform::SkinWeightsReport>
make_skin(const Arguments& given, const Scene& scene, const Binding<double, 3>& bound, std::size_t influences,
          SkinLoss& loss) {
    ProgressBar bar("weights, " + std::to_string(influences) + " joints");
    auto made = cageform::smooth_skin_weights(bound, scene.figure.triangles,
                                              {.influences = influences, .threshold = given.threshold},
                                              {.progress = bar.callback()});
    if (!made) return made;
    make_sums_exact(made.value);
    const SkinWeights stored = stored_skin(made.value, given.weights);
    const auto played = skin_to_binding(bound, stored);
    made.report.status = played.status();
    if (made) loss = loss_of(scene, bound, played.value, stored);
    return made;
}

/// As make_skin(), with the fewest sets of four joints that keep the distance; if none does, with the most.
cageform::Result<cageform::SkinWeights, cageform::SkinWeightsReport>
make_near_skin(const Arguments& given, const Scene& scene, const Binding<double, 3>& bound,
               std::size_t influences, SkinLoss& loss) {
    for (;; influences += joint_set) {
        auto made = make_skin(given, scene, bound, influences, loss);
        if (!made || influences + joint_set > most_joints || loss.places.share() <= given.skeleton.distance)
            return made;
    }
}

/// Suggests a skin that keeps the distance, given that `influences` joints do not.
std::string suggest_skin(const Arguments& given, const Scene& scene, const Binding<double, 3>& bound,
                         std::size_t influences) {
    if (influences >= most_joints) return "use a larger --max-distance, --bones or --morph";
    SkinLoss loss;
    const std::size_t next = influences / joint_set * joint_set + joint_set;
    const auto made = make_near_skin(given, scene, bound, next, loss);
    if (made && loss.places.share() <= given.skeleton.distance)
        return "--skin " + std::to_string(made.value.influences) + " is enough";
    return "not even --skin " + std::to_string(most_joints) +
           " is enough; use a larger --max-distance, --bones or --morph";
}

/// Adds the skin of --skin or --max-distance, and prints its errors.
void add_chosen_skin(GltfFigure& gltf, const Arguments& given, const Scene& scene,
                     const Binding<double, 3>& bound) {
    const MeshFile& figure = scene.figure;
    SkinLoss loss;
    const bool searches = given.influences == 0;
    const auto [skin, made] = searches ? make_near_skin(given, scene, bound, joint_set, loss)
                                       : make_skin(given, scene, bound, given.influences, loss);
    if (made.status != Status::ok) throw Failure(scene.cage.name + ": " + cageform::to_string(made.status));
    const std::string is_off = "a skin of " + std::to_string(skin.influences) +
                               " joints per vertex is off by " + describe(loss.places);
    if (given.skeleton.distance > 0 && loss.places.share() > given.skeleton.distance)
        throw Failure(figure.name + ": " + is_off + ": " +
                      suggest_skin(given, scene, bound, skin.influences));
    if (loss.places.share() > PackingLoss::worth_a_warning || loss.turn > warning_angle) {
        warn(figure.name + ": " + is_off + "; " + describe_surface(loss) +
             (skin.influences < enough_joints
                  ? "; --bones auto finds rotating bones, with a smaller error for four bones per vertex"
              : skin.influences < most_joints ? "; more joints reduce the error, and --max-distance bounds it"
                                              : "; --bones auto finds rotating bones; --morph is exact"));
    }
    if (const std::size_t sets = joint_sets(skin); sets > 1) {
        SkinLoss of_four;
        const SkinWeights read = first_set(stored_skin(skin, given.weights));
        const auto played = skin_to_binding(bound, read);
        if (const auto four = make_skin(given, scene, bound, joint_set, of_four); four && played)
            note(figure.name + ": " + describe_sets(sets) + "such a player is off by " +
                 describe(loss_of(scene, bound, played.value, read).places) +
                 "; a skin of four (--skin 4) is off by " + describe(of_four.places));
    }
    if (!made.not_reproduced.empty()) {
        warn(std::to_string(skin.influences) + " weights are too few for " +
             std::to_string(made.not_reproduced.size()) + " vertices of " + figure.name +
             ", so affine poses are not reproduced there, with errors of up to " +
             detail::short_number(made.reproduction_error.value) + ", first " +
             name_points(figure.vertices, made.not_reproduced));
    }
    if (given.report) {
        std::cout << "skin: " << skin.influences << " weights at most, " << made.mean_influences
                  << " in the mean\n"
                  << "largest sum |w - w0|: " << made.weight_error.value << " at point "
                  << made.weight_error.point << ", mean " << made.mean_weight_error << '\n'
                  << "not reproduced: " << made.not_reproduced.size()
                  << "; largest |sum w c - p|: " << made.reproduction_error.value << "\noff by "
                  << describe(loss.places) << '\n'
                  << describe_surface(loss) << "\ntime: " << made.seconds << " s\n";
    }
    add_handles(gltf, scene, given, skin, !made.without_weights.empty());
}

/// A binding of the figure, and of Jacobians at its vertices if normals are computed by them.
struct BoundScene {
    Binding<double, 3> points;
    BoundAxes axes;
};

/// Binds the figure, and prints warnings and the report.
///
///   unused   GltfFigure::unused
BoundScene bind_scene(const Arguments& given, const Scene& scene, const std::string& unused) {
    const MeshFile &figure = scene.figure, &cage = scene.cage;
    const auto coordinates = make_coordinates<double>(given.choice, cage);
    print_notes(cage.name, coordinates.cage_report(), coordinates.note);
    const auto options = given.outside.bind_options(coordinates);
    cageform::Result<Binding<double, 3>, cageform::BindReport> bound;
    BoundAxes axes;
    {
        ProgressBar bar("binding");
        const cageform::Running running{.progress = bar.callback()};
        const bool turns = given.morph && !figure.normals.empty() && coordinates.has_gradients();
        if (turns) (void)coordinates.solve(running.subtask(0, 0.5)); // once for both binds
        bound = coordinates.bind(given.morph ? figure.vertices : joined_places(figure), options,
                                 running.subtask(turns ? 0.5 : 0, turns ? 0.7 : 1));
        if (turns && bound.report.status == Status::ok) {
            auto bound_axes = coordinates.bind_jacobians(figure.vertices, options, running.subtask(0.7, 1));
            if (!bound_axes)
                warn(figure.name + ": its normals are computed from the faces: " +
                     cageform::to_string(bound_axes.report.status));
            axes = std::move(bound_axes.value);
        }
    }
    const auto& report = bound.report;
    if (report.status != Status::ok) throw Failure(describe_mesh_faults(cage.name, report));
    warn_of_coarse_grid(cage.name, report.solver);
    given.outside.check(coordinates, report, figure.vertices, figure.name, cage.name);
    if (given.report) std::cout << describe(report) << unused;
    return {std::move(bound.value), std::move(axes)};
}

void warn_of_mirrors(const Arguments& given, const Scene& scene, const Binding<double, 3>& bound) {
    const MeshFile& figure = scene.figure;
    const std::string mirror = first_mirror(figure, bound, scene.clip);
    warn(describe_winding(mirror.empty() ? scene.clip.name : mirror, figure.name,
                          mirror.empty() ? side_of(figure.vertices, figure.vertices) : -1,
                          given.flips_faces));
}

/// Fits the skeleton of --bones to the motion and adds it. Returns the motion.
FittedMotion add_bones(GltfFigure& gltf, const Arguments& given, const Scene& scene,
                       const FigureFrames& frames) {
    auto motion = fit_motion(given.skeleton, frames, given.weights);
    if (motion.loss.share() > PackingLoss::worth_a_warning || motion.report.turn > warning_angle)
        warn(scene.figure.name + ": " + describe_loss(motion) + "; use more --bones for a smaller error");
    add_skeleton(gltf, motion.skeleton, motion.keys, given.weights, stem(scene.clip.name), scene.origin);
    return motion;
}

/// Binds the figure and writes the requested files.
int export_figure(const Arguments& given, const Scene& scene) {
    GltfFigure gltf = value_or_fail(gltf_figure(scene.figure, "cageform export_gltf",
                                                given.morph ? GltfMotion::keep : GltfMotion::without_skin));
    fail_if(fault_of_outputs({given.out, given.picture}));
    const BoundScene bound = bind_scene(given, scene, gltf.unused);
    warn_of_mirrors(given, scene, bound.points);
    print_warnings(gltf.warnings);
    for (const std::string& text : gltf.notes) note(text);
    std::string printed, moved;
    std::optional<Picture> picture;
    if (given.morph) {
        const Targets targets = targets_of(given, scene, bound.points, bound.axes);
        add_morphs(gltf, scene, targets);
        moved = std::to_string(targets.keys.size()) + " targets";
    } else if (!given.skeleton.bones.empty()) {
        const FigureFrames frames = frames_of(given, scene, bound.points);
        const FittedMotion motion = add_bones(gltf, given, scene, frames);
        moved = count_bones(motion);
        if (given.report) printed = describe(motion);
        if (!given.picture.empty()) picture = draw_skeleton(frames, motion, given.view.sight);
    } else {
        add_chosen_skin(gltf, given, scene, bound.points);
        moved = std::to_string(gltf.document.json["skins"].back()["joints"].size()) + " joints";
    }
    OutputFiles outputs;
    const std::size_t bytes = value_or_fail(save_gltf(gltf.document, given.out, outputs));
    if (picture) picture->write_png(outputs.add(given.picture));
    fail_if(outputs.commit());
    std::cout << printable(describe_gltf(given.out, gltf, scene.figure, moved, bytes)) << '\n' << printed;
    return 0;
}

/// Reads all input files.
Scene read_scene(const Arguments& given) {
    Scene scene;
    scene.figure = load_mesh_figure(given.figure, given.is_strict);
    scene.cage = load_or_make_cage(given.cage, scene.figure);
    if (given.flips_faces) {
        fail_if(fault_of_reversing(scene.figure));
        scene.figure = with_faces_reversed(std::move(scene.figure));
    }
    if (!given.labels.empty())
        scene.labels = value_or_fail(read_labels(given.labels, scene.cage.vertices.size()));
    scene.clip = given.moves.motion(scene.cage);
    scene.origin = far_origin(scene.figure);
    scene.stored = scene.figure;
    scene.stored.vertices = relative_to(scene.origin, scene.figure.vertices);
    for (const MeshFile* file : {&scene.figure, &scene.cage}) // the format of glTF
        fail_if(single_precision_fault(*file));
    return scene;
}

/// Adds the options that choose what to write; returns those that need --bones.
std::vector<CommandOption> add_outputs(CommandLine& line, Arguments& given) {
    const CommandOption labels =
        line.add("--labels", given.labels,
                 "skin: a text file with names of the joints, which are the cage's vertices");
    const CommandOption skin =
        line.add("--skin", given.influences, "write a skin with at most this many joints per vertex")
            .range(1, 16);
    const CommandOption bones =
        line.add("--bones", given.skeleton.bones,
                 "fit a skeleton of so many rotating bones to the motion, or auto: the "
                 "fewest within --max-distance")
            .check(SkeletonChoice::fault_of_bones)
            .excludes(skin)
            .excludes(labels);
    const CommandOption distance =
        add_share(line, "--max-distance", given.skeleton.distance,
                  "the largest distance of a vertex from its clone, a share of the figure's size such as "
                  "0.002 or 0.2%. 0 means no bound, but 0.2% with --bones auto. A skin is measured in the "
                  "poses of the motion, or in all poses within a tenth of the cage's size of an affine "
                  "motion. Without --skin and --bones the skin has the fewest of 4, 8, 12 or 16 joints that "
                  "suffice")
            .show_default("0");
    std::vector<CommandOption> of_bones = given.skeleton.add_options(line);
    of_bones.push_back(line.add("--rate", given.rate, "bones: the least number of frames per second to fit")
                           .range(1e-3, 1e6)
                           .show_default());
    of_bones.push_back(
        line.add("--picture", given.picture,
                 "bones: also draw frames to a PNG file: the clones, the skinned figure coloured by "
                 "distance, and the bones")
            .ends_with({".png"}));
    line.add_flag("--morph", given.morph, "write morph targets, one per pose")
        .excludes(skin)
        .excludes(bones)
        .excludes(distance)
        .excludes(labels);
    return of_bones;
}

/// Adds the options on storing.
void add_storing(CommandLine& line, Arguments& given) {
    line.add("--weights", given.weights,
             "bones and skin: the format of weights: float, unorm8 or unorm16 (normalised integers)")
        .one_of({"float", "unorm8", "unorm16"})
        .show_default();
    line.add("--threshold", given.threshold, "skin: leave out smaller weights")
        .range(0.0, 1.0)
        .show_default();
    line.add("-o,--output", given.out, "the file to write: .glb or .gltf")
        .required()
        .ends_with({".glb", ".gltf"});
    given.choice.with_normals = given.choice.in_space = true;
    given.choice.add_options(line);
    given.outside.add_options(line);
    given.view.add_options(line);
    add_strict(line, given.is_strict);
    add_flip_faces(line, given.flips_faces);
    line.add_flag("--report", given.report, "print the bind report and the error of the skin or the bones");
}

/// Fails if options conflict.
///
///   of_bones   options that need --bones
void check_options(const Arguments& given, std::span<const CommandOption> of_bones) {
    const bool has_bones = !given.skeleton.bones.empty();
    if (!given.morph && !has_bones && given.influences == 0 && given.skeleton.distance == 0)
        throw Failure("give --bones, --skin, --max-distance or --morph to choose what to write");
    for (const CommandOption& option : of_bones) {
        if (!has_bones && option.is_given())
            throw Failure("--kind, --influences, --flat, --tangents, --rate and --picture need --bones");
    }
    if (has_bones && !given.moves.is_given())
        throw Failure("--bones needs a motion: give --clip, --pose, or operations such as --twist");
    if (!given.morph && !has_bones && given.choice.takes_normals())
        throw Failure(
            "--coordinates green: --skin cannot represent normals of faces; use --morph or --bones");
    if (given.morph && !given.moves.is_given())
        throw Failure("--morph needs poses: give --clip, --pose, or operations such as --turn");
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line(
        "Writes a figure that moves with its cage as glTF 2.0, with bones, a skin or morph targets.");
    line.set_examples(
        {"character.obj --cage auto --turn 5-9:30,z --bones auto --max-distance 0.2% -o character.glb",
         "character.obj --cage character_cage.obj --clip character_clip.csv --skin 16 -o character.glb"});
    Arguments given;
    line.add("figure", given.figure, "the mesh").required();
    add_cage(line, given.cage, CageFiles::mesh);
    given.moves.add_options(line);
    const auto of_bones = add_outputs(line, given);
    add_storing(line, given);
    line.set_footer(
        mesh_formats +
        std::string("Vertices keep the order of the file. A vertex that needs several normals or\n"
                    "texture coordinates is duplicated; the copies follow all other vertices.\n\n") +
        pose_clip_format + "\n" + pose_operations_format + "\n" + labels_format + "\n" + lattice_format);
    if (const auto code = line.parse(argc, argv)) return *code;
    given.moves.order_poses();
    check_options(given, of_bones);
    return export_figure(given, read_scene(given));
}

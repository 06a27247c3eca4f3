// Makes a hand: skin, control points, poses.
//
//     make_hand out
//
// writes out/hand.obj, out/hand_cage.obj (its cage), out/hand_points.csv (the kind of each control point and
// the bone that moves it), out/hand_poses.csv (22 angles per line, for pose_hand) and out/hand.glb. In this
// clip of 4 s the hand opens, closes to a fist, points and grasps a ball. Morph targets are 0.25 s apart,
// because a rational clone is not linear in the pose.

#include "bound_hand.hpp"
#include "cli/command_line.hpp"
#include "files/gltf_figure.hpp"
#include "files/obj_file.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <cageform/cage/triangle_mesh.hpp>

#include <iostream>

namespace {

using namespace cageform_sources;

std::string points_text(const Hand& hand) {
    std::string text = "x,y,z,kind,joint,other,part,vertex\n"; // joints and vertices from 0; empty: none
    const auto index = [](std::size_t i) { return i == HandJoint::none ? std::string() : std::to_string(i); };
    for (const HandPoint& p : hand.points) {
        text += formatted("%.6f,%.6f,%.6f,%s,%s,%s,%g,%s\n", p.place[0], p.place[1], p.place[2],
                          to_string(p.kind), index(p.joint).c_str(), index(p.other).c_str(),
                          p.joint == HandJoint::none ? 0.0 : p.part, index(p.vertex).c_str());
    }
    return text;
}

std::string poses_text(const BoundHand& bound) {
    std::string text = "# ";
    for (std::size_t i = 0; i < hand_angle_count; ++i)
        text += (i == 0 ? "" : ",") + std::string(hand_angle_ranges[i].name);
    text += '\n';
    for (const NamedHandPose& pose : hand_poses()) {
        text += "# " + std::string(pose.name) + '\n';
        const HandPose angles = bound.closed(pose);
        for (std::size_t i = 0; i < hand_angle_count; ++i)
            text += formatted(i == 0 ? "%.6g" : ",%.6g", angles[i]);
        text += '\n';
    }
    return text;
}

/// The poses of the clip, with smooth transitions.
HandPose pose_at(const BoundHand& bound, double seconds) {
    const auto& poses = hand_poses();
    const std::array<HandPose, 5> keys{poses[0].angles, poses[1].angles, poses[2].angles,
                                       bound.closed(poses[3]), poses[0].angles};
    const auto key = std::min(std::size_t(seconds), keys.size() - 2);
    const double t = seconds - double(key), part = t * t * (3 - 2 * t);
    HandPose pose;
    for (std::size_t i = 0; i < pose.size(); ++i)
        pose[i] = (1 - part) * keys[key][i] + part * keys[key + 1][i];
    return pose;
}

/// The clip as morph targets, one per key.
GltfDocument clip_document(const BoundHand& bound) {
    constexpr std::size_t keys = 17; // the first and the last are at rest
    const auto file =
        value_or_fail(parse_obj(obj_text(bound.hand.skin, "A right hand, made by make_hand"), "hand.obj"));
    GltfFigure gltf = value_or_fail(gltf_figure(file, "cageform make_hand", GltfMotion::keep));
    std::vector<GltfPoseTarget> poses;
    std::vector<double> times, weights;
    for (std::size_t key = 0; key < keys; ++key) {
        times.push_back(0.25 * double(key));
        for (std::size_t target = 1; target + 1 < keys; ++target) weights.push_back(target == key ? 1 : 0);
        if (key == 0 || key + 1 == keys) continue;
        poses.push_back({"key " + std::to_string(key), bound.clone(pose_at(bound, times.back()))});
        if (poses.back().places.empty()) throw Failure("a pose of the clip cannot be cloned");
    }
    const auto morphs = value_or_fail(add_targets(gltf, file, poses));
    GltfJson animation = {{"name", "open, fist, point, grasp"}};
    const GltfIndex input = add_scalars(gltf.document, times, true);
    add_channel(animation, morphs[0].node, "weights", input, "LINEAR",
                add_scalars(gltf.document, weights, false));
    gltf.document.append("animations", std::move(animation));
    return std::move(gltf.document);
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line(
        "Makes the skin of a hand, its control points, some poses of its 22 joint angles, and a clip.");
    line.set_examples({"out"});
    std::string folder;
    line.add("folder", folder,
             "where hand.obj, hand_cage.obj, hand_points.csv, hand_poses.csv and hand.glb are written")
        .required();
    if (const auto code = line.parse(argc, argv)) return *code;

    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return fail("cannot make the folder " + folder + ": " + error.message());
    const BoundHand bound;
    if (bound.report.status != cageform::Status::ok) return fail(to_string(bound.report.status));
    const Hand& hand = bound.hand;
    const auto sound = cageform::check(cageform::TriangleMesh<double>(hand.skin.vertices, hand.skin.faces));
    if (sound.status != cageform::Status::ok)
        return fail(std::string("the skin: ") + to_string(sound.status));
    const ImplicitMesh cage = cage_of(hand);
    const GltfDocument clip = clip_document(bound);
    OutputFiles outputs;
    const auto path = std::filesystem::path(folder);
    outputs.add(path / "hand.obj").write(obj_text(hand.skin, "A right hand, made by make_hand"));
    outputs.add(path / "hand_cage.obj").write(obj_text(cage, "A cage of hand.obj, made by make_hand"));
    outputs.add(path / "hand_points.csv").write(points_text(hand));
    outputs.add(path / "hand_poses.csv").write(poses_text(bound));
    const std::size_t bytes = value_or_fail(save_gltf(clip, (path / "hand.glb").string(), outputs));
    fail_if(outputs.commit());
    const auto shown = [](const std::filesystem::path& file) { return printable(file.string()); };
    std::cout << shown(path / "hand.obj") << ": " << hand.skin.vertices.size() << " vertices, "
              << hand.skin.faces.size() << " faces\n"
              << shown(path / "hand_cage.obj") << ": " << cage.vertices.size() << " vertices\n"
              << shown(path / "hand_points.csv") << ": " << hand.points.size() << " control points\n"
              << shown(path / "hand_poses.csv") << ": " << hand_poses().size() << " poses\n"
              << shown(path / "hand.glb") << ": " << bytes << " bytes\n";
    return 0;
}

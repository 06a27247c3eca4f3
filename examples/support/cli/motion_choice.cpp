#include "cli/motion_choice.hpp"

#include "cli/mesh_cage.hpp"
#include "io/csv.hpp"
#include "io/input_file.hpp"
#include "io/messages.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace cageform_support {

void MotionChoice::add_options(CommandLine& line) {
    const CommandOption of_clip = line.add("--clip", clip, "a CSV file of poses, the motion of the cage");
    line.add("--pose", poses, "files of poses of the cage; the motion goes from rest through these and back")
        .excludes(of_clip);
    operations.add_options(line);
    line.add("--seconds", seconds, "the seconds from one pose to the next").range(0.001, 1e5).show_default();
}

namespace {

/// Whether a clip is probably for another cage: in every key, vertices differ from rest by more than a
/// quarter of the cage's size in the mean, after removing the mean displacement.
bool is_of_another_cage(const PoseClip& clip, const MeshFile& cage) {
    const double size = cageform::bounds_of(std::span<const Point3>(cage.vertices)).diagonal();
    return std::all_of(clip.keys.begin(), clip.keys.end(), [&](const PoseKey& key) {
        Point3 common{};
        const double share = 1 / double(cage.vertices.size());
        for (std::size_t i = 0; i < cage.vertices.size(); ++i)
            common = common + share * (key.places[i] - cage.vertices[i]);
        double off = 0;
        for (std::size_t i = 0; i < cage.vertices.size(); ++i) {
            const Point3 d = key.places[i] - cage.vertices[i] - common;
            off += share * std::hypot(d[0], d[1], d[2]);
        }
        return off > size / 4;
    });
}

} // namespace

void MotionChoice::order_poses() {
    for (const std::string& text : order_by_numbers(poses)) note("--pose: " + text);
}

PoseClip MotionChoice::motion(const MeshFile& cage) const {
    const auto held = operations.still(cage.lattice);
    if (operations.operations.empty()) {
        if (clip.empty() && poses.empty()) return PoseClip{};
        PoseClip motion = clip.empty() ? clip_through_poses(cage, poses, seconds)
                                       : value_or_fail(load_pose_clip(clip, cage.vertices.size()));
        if (!clip.empty() && is_of_another_cage(motion, cage)) {
            warn(clip + ": all keys are far from the rest pose of " + cage.name +
                 ": the clip is probably for another cage");
        }
        for (PoseKey& key : motion.keys) {
            for (const std::size_t i : held) key.places[i] = cage.vertices[i];
        }
        return motion;
    }
    if (!clip.empty() || !poses.empty())
        throw Failure("give only one of --clip, --pose, and operations such as --turn");
    const auto parts = cage_parts(cage);
    auto posed = operations.posed(cage.vertices, cage.lattice, nullptr, &parts);
    for (std::size_t i = 0; i < posed.size(); ++i) {
        for (const double x : posed[i].v) {
            if (const std::string why = detail::single_precision_fault(x); !why.empty())
                throw Failure("the pose of v " + std::to_string(i + 1) + " of " + cage.name + ": " + why);
        }
    }
    return PoseClip{"pose",
                    2 * seconds,
                    {{0, PoseInterpolation::smooth, cage.vertices},
                     {seconds, PoseInterpolation::smooth, std::move(posed)}}};
}

} // namespace cageform_support

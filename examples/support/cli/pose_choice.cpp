#include "cli/pose_choice.hpp"

#include "cli/auto_cage.hpp"
#include "cli/mesh_cage.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace cageform_support {

void PoseChoice::add_options(CommandLine& line) {
    const auto add = [&](const char* name, PoseOperation operation, const char* help) {
        line.add_text(
                name,
                [this, operation](const std::string& word) { operations.emplace_back(operation, word); },
                help)
            .in_order();
    };
    add("--move", PoseOperation::move, "move vertices: WHICH:X,Y, in space WHICH:X,Y,Z");
    add("--turn", PoseOperation::turn, "turn vertices: WHICH:DEGREES, in space WHICH:DEGREES,AXIS");
    add("--scale", PoseOperation::scale, "scale vertices: WHICH:FACTOR, or one factor per axis");
    add("--bend", PoseOperation::bend, "bend vertices: WHICH:AXES,FROM,TO,DEGREES");
    add("--twist", PoseOperation::twist, "in space, twist vertices: WHICH:AXIS,FROM,TO,DEGREES");
    if (in_plane)
        add("--curve", PoseOperation::curve,
            "move one control point of a cage of curves alone: LOOP:K:DX,DY");
    line.add("--freeze", freeze, "the number of outer layers of a lattice's points that no pose moves")
        .show_default();
}

template <std::size_t D>
std::vector<cageform::Vec<double, D>> PoseChoice::posed(const std::vector<cageform::Vec<double, D>>& rest,
                                                        const std::optional<LatticeBox<D>>& lattice,
                                                        const CageFile* curves,
                                                        const cageform::CageParts* parts) const {
    static constexpr std::array names{"move", "turn", "scale", "bend", "twist", "curve"};
    const auto held = still(lattice);
    auto pose = rest;
    const std::size_t count = lattice ? lattice->points() : rest.size();
    const auto followers = curves != nullptr ? curves->followers() : std::vector<std::vector<std::size_t>>();
    for (const auto& [operation, word] : operations) {
        std::string why = "the cage has no curves; --coordinates curved-green makes its edges curves";
        if (operation != PoseOperation::curve)
            why = apply_operation<D>(operation, word, std::span(rest).first(count),
                                     std::span(pose).first(count), followers, parts);
        else if constexpr (D == 2)
            why = curves != nullptr ? move_control_point(word, curves->handles, pose) : why;
        if (!why.empty()) {
            throw Failure("--" + std::string(names[std::size_t(operation)]) + " " + detail::quoted(word) +
                          ": " + why);
        }
    }
    for (const std::size_t i : held) pose[i] = rest[i];
    return pose;
}

template <std::size_t D>
std::vector<std::size_t> PoseChoice::still(const std::optional<LatticeBox<D>>& lattice) const {
    if (!lattice && freeze > 0) throw Failure("--freeze is for lattices, such as --cage lattice:4x4");
    if (!lattice) return std::vector<std::size_t>{};
    const auto coordinates = lattice->template coordinates<double>();
    const auto frozen = coordinates.frozen_handles(freeze);
    if (frozen.size() == lattice->points())
        throw Failure("--freeze " + std::to_string(freeze) + " leaves no point of the lattice to move");
    std::vector<std::size_t> list(frozen.begin(), frozen.end());
    for (std::size_t i = lattice->points(); i < coordinates.handles().size(); ++i) list.push_back(i);
    return list;
}

template std::vector<cageform::Vec<double, 2>> PoseChoice::posed(const std::vector<cageform::Vec<double, 2>>&,
                                                                 const std::optional<LatticeBox<2>>&,
                                                                 const CageFile*,
                                                                 const cageform::CageParts*) const;
template std::vector<cageform::Vec<double, 3>> PoseChoice::posed(const std::vector<cageform::Vec<double, 3>>&,
                                                                 const std::optional<LatticeBox<3>>&,
                                                                 const CageFile*,
                                                                 const cageform::CageParts*) const;
template std::vector<std::size_t> PoseChoice::still(const std::optional<LatticeBox<2>>&) const;
template std::vector<std::size_t> PoseChoice::still(const std::optional<LatticeBox<3>>&) const;

void MotionChoice::add_options(CommandLine& line) {
    const CommandOption of_clip = line.add("--clip", clip, "a CSV file of poses, the motion of the cage");
    line.add("--pose", poses,
             "OBJ files of poses of the cage; the motion goes from rest through these and back")
        .excludes(of_clip);
    operations.add_options(line);
    line.add("--seconds", seconds, "the seconds from one pose to the next").range(0.001, 1e5).show_default();
}

namespace {

/// Whether a clip is probably for another cage: in every key, vertices differ from rest by more than a
/// quarter of the cage's size in the mean, after removing the mean displacement.
bool is_of_another_cage(const PoseClip& clip, const ObjFile& cage) {
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

PoseClip MotionChoice::motion(const ObjFile& cage) const {
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

CageFile read_pose(const std::string& path, const PoseChoice& choice, const CageFile& cage, bool is_made) {
    const auto& operations = choice.operations;
    if (!path.empty() && !operations.empty())
        throw Failure("give --pose or operations such as --turn, but not both");
    if (path.empty() && operations.empty() && !is_made)
        throw Failure("--pose is required, or operations such as --turn");
    const auto rest = cage.places();
    if (!operations.empty())
        return moved_cage(cage, choice.posed(rest, cage.lattice, cage.curves ? &cage : nullptr));
    const auto held = choice.still(cage.lattice);
    CageFile pose = value_or_fail(path.empty() ? moved_cage(cage, first_pose(rest)) : load_pose(path, cage));
    if (held.empty()) return pose;
    auto places = pose.places();
    for (const std::size_t i : held) places[i] = rest[i];
    return moved_cage(std::move(pose), places);
}

} // namespace cageform_support

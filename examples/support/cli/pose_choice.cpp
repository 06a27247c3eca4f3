#include "cli/pose_choice.hpp"

#include "cli/auto_cage.hpp"
#include "cli/mesh_cage.hpp"
#include "files/csv.hpp"

#include <array>
#include <span>

namespace cageform_examples {

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
}

template <std::size_t D>
SvgResult<std::vector<cageform::Vec<double, D>>>
PoseChoice::posed(const std::vector<cageform::Vec<double, D>>& rest) const {
    static constexpr std::array names{"move", "turn", "scale", "bend", "twist"};
    auto pose = rest;
    for (const auto& [operation, word] : operations) {
        const std::string why = apply_operation<D>(operation, word, std::span(rest), std::span(pose));
        if (!why.empty()) {
            return SvgError{"--" + std::string(names[std::size_t(operation)]) + " " + detail::quoted(word) +
                            ": " + why};
        }
    }
    return pose;
}

template SvgResult<std::vector<cageform::Vec<double, 2>>>
PoseChoice::posed(const std::vector<cageform::Vec<double, 2>>&) const;
template SvgResult<std::vector<cageform::Vec<double, 3>>>
PoseChoice::posed(const std::vector<cageform::Vec<double, 3>>&) const;

void MotionChoice::add_options(CommandLine& line) {
    const CommandOption of_clip = line.add("--clip", clip, "a CSV file of poses, the motion of the cage");
    line.add("--pose", poses,
             "OBJ files of poses of the cage; the motion goes from rest through these and back")
        .excludes(of_clip);
    operations.add_options(line);
    line.add("--seconds", seconds, "the seconds from one pose to the next").range(0.001, 1e5).show_default();
}

SvgResult<PoseClip> MotionChoice::motion(const ObjFile& cage) const {
    if (operations.operations.empty()) {
        if (!clip.empty()) return load_pose_clip(clip, cage.vertices.size());
        return poses.empty() ? SvgResult<PoseClip>(PoseClip{}) : clip_through_poses(cage, poses, seconds);
    }
    if (!clip.empty() || !poses.empty())
        return SvgError{"give only one of --clip, --pose, and operations such as --turn"};
    auto posed = operations.posed(cage.vertices);
    if (!posed) return posed.error();
    for (std::size_t i = 0; i < posed->size(); ++i) {
        for (const double x : (*posed)[i].v) {
            if (const std::string why = detail::single_precision_fault(x); !why.empty())
                return SvgError{"the pose of vertex " + std::to_string(i + 1) + " of " + cage.name + ": " +
                                why};
        }
    }
    return PoseClip{"pose",
                    2 * seconds,
                    {{0, PoseWay::smooth, cage.vertices}, {seconds, PoseWay::smooth, std::move(*posed)}}};
}

SvgResult<CageFile> read_pose(const std::string& path, const PoseChoice& choice, const CageFile& cage,
                              bool is_made) {
    const auto& operations = choice.operations;
    if (!path.empty() && operations.empty()) return load_pose(path, cage);
    if (!path.empty()) return SvgError{"give --pose or operations such as --turn, but not both"};
    if (operations.empty() && !is_made) return SvgError{"--pose is required, or operations such as --turn"};
    if (operations.empty()) return moved_cage(cage, first_pose(cage.places()));
    const auto moved = choice.posed(cage.places());
    if (!moved) return moved.error();
    return moved_cage(cage, *moved);
}

} // namespace cageform_examples

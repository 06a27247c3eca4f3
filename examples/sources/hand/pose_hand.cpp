// Poses the hand of make_hand by joint angles. Draws it from the back and the palm, or writes its skin.
//
//     pose_hand --pose poses.csv --picture poses.png
//     pose_hand --pose point -o point.obj
//     pose_hand --pose fist --kappa 0 --picture fist.png

#include "bound_hand.hpp"
#include "cli/command_line.hpp"
#include "io/atomic_file.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"
#include "pictures/mesh_picture.hpp"

namespace {

using namespace cageform_sources;

/// The default angle of the last joint of a finger: two thirds of the previous joint, because tendons couple
/// them.
bool follows(std::size_t angle) {
    return angle < std::size_t(HandAngle::ring_metacarpal) && angle % 4 == std::size_t(HandAngle::index_dip);
}

/// Parses the angles of a line; returns the fault, or empty.
std::string parse_angles(std::string_view line, HandPose& pose) {
    const auto cells = detail::cells_of(line, hand_angle_count);
    if (cells.size() != hand_angle_count)
        return std::to_string(cells.size()) + " numbers where a pose has " + std::to_string(hand_angle_count);
    for (std::size_t i = 0; i < hand_angle_count; ++i) {
        if (follows(i) && cells[i].empty()) {
            pose[i] = pose[i - 1] * 2 / 3;
        } else {
            if (const std::string why = detail::parse_number(cells[i], pose[i]); !why.empty()) return why;
        }
        const auto& range = hand_angle_ranges[i];
        if (!(range.least <= pose[i] && pose[i] <= range.most)) {
            return std::string(range.name) + " is " + detail::short_number(pose[i]) +
                   ", but its range is from " + detail::short_number(range.least) + " to " +
                   detail::short_number(range.most);
        }
    }
    return {};
}

std::vector<HandPose> load_poses(const std::string& path) {
    const auto file = value_or_fail(read_text(path));
    std::vector<HandPose> poses;
    detail::RowFilter rows;
    std::string_view rest = file, line;
    for (std::size_t number = 1; take_line(rest, line); ++number) {
        if (!rows.take(line)) continue;
        const std::string why = parse_angles(line, poses.emplace_back());
        if (!why.empty()) throw Failure(to_string(detail::row_fault(path, number, line, why)));
    }
    if (poses.empty()) throw Failure(path + ": holds no pose");
    if (poses.size() > 16)
        throw Failure(path + ": holds more than 16 poses, the most that a picture can show");
    return poses;
}

} // namespace

int run_program(int argc, char** argv) {
    CommandLine line("Poses a hand by 22 joint angles in degrees: draws it from the back and the inner side, "
                     "or writes it.");
    line.set_examples({"--pose point -o point.obj", "--pose poses.csv --picture poses.png"});
    std::string pose, picture, out;
    double kappa = hand_kappa;
    line.add(
            "--pose", pose,
            "a file of poses with 22 numbers per line, or one of rest, fist, point, ball, rod, spread, pinch")
        .required();
    line.add("--picture", picture, "the PNG file to write").ends_with({".png"});
    line.add("-o,--output", out, "the OBJ file to write, for one pose").ends_with({".obj"});
    line.add("--kappa", kappa, "the strength of the inflation 1 + kappa (1 - cos angle)")
        .range(0, 100)
        .show_default();
    std::string angles = "The angles of a line, in this order, with their ranges:\n";
    for (const auto& range : hand_angle_ranges) {
        angles += std::string("  ") + range.name + "  " + detail::short_number(range.least) + " to " +
                  detail::short_number(range.most) + '\n';
    }
    angles += "The dip angle of a finger can be left empty; it is then two thirds of its pip angle.\n";
    line.set_footer(angles);
    if (const auto code = line.parse(argc, argv)) return *code;

    if (picture.empty() && out.empty()) return fail("give --picture or --output to choose what to write");
    const auto named = std::find_if(hand_poses().begin(), hand_poses().end(),
                                    [&](const NamedHandPose& known) { return pose == known.name; });
    auto poses = named != hand_poses().end() ? std::vector{named->angles} : load_poses(pose);
    if (!out.empty() && poses.size() > 1)
        return fail(pose + ": holds " + std::to_string(poses.size()) + " poses, but an OBJ file has one");
    fail_if(fault_of_outputs({out, picture}));
    const BoundHand bound;
    if (named != hand_poses().end()) poses.front() = bound.closed(*named);
    if (bound.report.status != cageform::Status::ok) return fail(to_string(bound.report.status));
    std::vector<std::vector<Point3>> skins;
    for (const HandPose& angles_of_pose : poses) {
        skins.push_back(bound.clone(angles_of_pose, kappa));
        if (skins.back().empty()) return fail("a pose cannot be cloned");
        skins.push_back(turned_over(skins.back()));
    }
    OutputFiles outputs;
    if (!out.empty())
        outputs.add(out).write(
            obj_text({skins.front(), bound.hand.skin.faces}, "A right hand, posed by pose_hand"));
    if (!picture.empty()) {
        std::vector<MeshScene> scenes;
        for (const auto& skin : skins) scenes.push_back({{skin, bound.hand.skin.faces}, {}});
        draw_meshes(scenes, 450 * scenes.size(), 650).write_png(outputs.add(picture));
    }
    return commit(outputs);
}

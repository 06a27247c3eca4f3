#include "cli/weight_choice.hpp"

#include "files/bind_report.hpp"
#include "io/messages.hpp"

#include <array>

namespace cageform_support {

using cageform::WeightFormat;

constexpr std::array format_names{
#define CAGEFORM_EXAMPLES_NAME(name, ...) #name,
    CAGEFORM_WEIGHT_FORMATS(CAGEFORM_EXAMPLES_NAME)
#undef CAGEFORM_EXAMPLES_NAME
};

const char* name_of(WeightFormat format) {
    return format_names[std::size_t(format)];
}

void WeightChoice::add_options(CommandLine& line, const std::string& share_of, const std::string& more,
                               const std::string& default_format) {
    line.add("--largest", largest, "the number of a vertex's largest weights to keep, 4 or more; 0 keeps all")
        .show_default();
    line.add("--max-distance", distance,
             "the largest distance of a vertex from its position with all weights, as a share of " +
                 share_of +
                 ": in the poses of the motion; without a motion, in all poses within a tenth of the cage's "
                 "size of an affine motion;" +
                 more + " green needs a motion; 0 means no bound")
        .range(0.0, 1.0)
        .show_default();
    std::string names;
    for (const char* name : format_names) names += (names.empty() ? "" : ", ") + std::string(name);
    line.add_text(
            "--format",
            [this](const std::string& given) {
                const auto found = std::find(format_names.begin(), format_names.end(), given);
                format = WeightFormat(found - format_names.begin());
            },
            "the format of weights: " + names)
        .one_of({format_names.begin(), format_names.end()})
        .show_default(default_format);
}

std::string WeightChoice::fault(const CoordinatesChoice& choice, bool has_motion) const {
    if (choice.takes_normals() && distance > 0 && !has_motion)
        return "--max-distance with --coordinates green needs a motion: give --clip, --pose, or operations "
               "such as --turn";
    return {};
}

std::vector<double> poses_of_handles(const cageform::Binding<float, 3>& binding, const PoseClip& clip,
                                     const SampledPoses& poses) {
    std::vector<double> numbers;
    std::vector<std::string> warnings;
    for (std::size_t p = 0; p < poses.times.size(); ++p) {
        std::vector<Point3> pose(clip.keys[0].places.size());
        for (std::size_t n = 0; n < 3 * pose.size(); ++n)
            pose[n / 3][n % 3] = poses.numbers[3 * pose.size() * p + n];
        std::string warning;
        const auto handles =
            value_or_fail(pose_of_handles(binding, pose, name_of_pose(clip, poses.times[p]), warning));
        if (!warning.empty()) warnings.push_back(std::move(warning));
        cageform::append_pose(numbers, handles);
    }
    print_warnings(warnings);
    return numbers;
}

} // namespace cageform_support

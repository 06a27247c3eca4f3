#include "pose_choice.hpp"

#include "auto_cage.hpp"

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
    add("--move", PoseOperation::move, "WHICH:X,Y or X,Y,Z");
    add("--turn", PoseOperation::turn, "WHICH:DEGREES, in space with ,AXIS");
    add("--scale", PoseOperation::scale, "WHICH:FACTOR or a factor an axis");
    add("--bend", PoseOperation::bend, "WHICH:AXES,FROM,TO,DEGREES");
    add("--twist", PoseOperation::twist, "in space: WHICH:AXIS,FROM,TO,DEGREES");
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

SvgResult<CageFile> read_pose(const std::string& path, const PoseChoice& choice, const CageFile& cage,
                              bool is_made) {
    const auto& operations = choice.operations;
    if (!path.empty() && operations.empty()) return load_pose(path, cage);
    if (!path.empty()) return SvgError{"--pose, or operations such as --turn, but not both"};
    if (operations.empty() && !is_made) return SvgError{"--pose is required, or operations such as --turn"};
    if (operations.empty()) return moved_cage(cage, first_pose(cage.places()));
    const auto moved = choice.posed(cage.places());
    if (!moved) return moved.error();
    return moved_cage(cage, *moved);
}

} // namespace cageform_examples

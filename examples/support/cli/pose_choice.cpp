#include "cli/pose_choice.hpp"

#include "cli/auto_cage.hpp"
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

#include "cli/pinned_cage.hpp"

#include "cli/pose_operations.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

namespace cageform_support {

void PinChoice::add_options(CommandLine& line) {
    solving.settled_step = 1e-6;
    line.add_text(
            "--pin", [this](const std::string& word) { given.emplace_back(word, false); },
            "move a point of the figure to a target, and the rest with it: PLACE:TARGET@DEGREES, such as "
            "90,16:70,20; with signs, TARGET is a displacement: 90,16:+0,-5; PLACE alone keeps the point "
            "fixed")
        .in_order();
    line.add_text(
            "--pins", [this](const std::string& path) { given.emplace_back(path, true); },
            "a CSV file of pins, one per line")
        .in_order();
    line.add(
        "--hold", held,
        "vertices of the cage that pins do not move: 0-1,5; they stay in the given pose, by default at rest");
    line.add("--pin-weight", solving.pin_weight,
             "the weight of pins; with many pins, a smaller weight lets them miss their targets")
        .range(1e-6, 1e12)
        .show_default();
    line.add_flag("--hard-pins", solving.hard_pins, "enforce pins a thousand times more strictly")
        .rarely_needed();
    line.add("--smoothing", sampling.smoothing,
             "spread bending by pins over this length, relative to the cage's size, such as 0.02")
        .range(0.0, 1.0)
        .show_default();
}

std::string PinChoice::fault(bool has_pose) const {
    if (!is_given() && !held.empty()) return "--hold is for pins: give --pin or --pins too";
    if (is_given() && has_pose && held.empty())
        return "pins move all vertices that are not held, whatever their pose: give --hold too, or only "
               "one of pins and a pose";
    return {};
}

template <std::size_t D>
Expected<std::vector<Pin<D>>> PinChoice::pins(std::span<const cageform::Vec<double, D>> vertices) const {
    std::vector<Pin<D>> all;
    for (const auto& [text, is_file] : given) {
        if (is_file) {
            auto some = load_pins<D>(text, vertices);
            if (!some) return some.error();
            all.insert(all.end(), some->begin(), some->end());
        } else {
            auto one = parse_pin<D>(text, vertices);
            if (!one) return one.error();
            all.push_back(std::move(*one));
        }
    }
    warn(contradiction(all));
    return all;
}

template <std::size_t D>
std::vector<std::uint32_t> PinChoice::held_handles(std::span<const cageform::Vec<double, D>> rest,
                                                   const std::vector<std::size_t>& still,
                                                   const cageform::CageParts* parts) const {
    std::vector<std::size_t> all = still;
    if (!held.empty()) {
        auto selected = parse_selection(held, rest, parts);
        if (!selected) throw Failure("--hold " + detail::quoted(held) + ": " + to_string(selected.error()));
        all.insert(all.end(), selected->begin(), selected->end());
    }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    const auto is_vertex = [&](std::size_t i) { return i < rest.size(); };
    if (std::size_t(std::count_if(all.begin(), all.end(), is_vertex)) == rest.size())
        throw Failure("--hold " + detail::quoted(held) + " leaves no vertex of the cage to move");
    return std::vector<std::uint32_t>(all.begin(), all.end());
}

template Expected<std::vector<Pin<2>>> PinChoice::pins(std::span<const cageform::Vec<double, 2>>) const;
template Expected<std::vector<Pin<3>>> PinChoice::pins(std::span<const cageform::Vec<double, 3>>) const;
template std::vector<std::uint32_t> PinChoice::held_handles(std::span<const cageform::Vec<double, 2>>,
                                                            const std::vector<std::size_t>&,
                                                            const cageform::CageParts*) const;
template std::vector<std::uint32_t> PinChoice::held_handles(std::span<const cageform::Vec<double, 3>>,
                                                            const std::vector<std::size_t>&,
                                                            const cageform::CageParts*) const;

} // namespace cageform_support

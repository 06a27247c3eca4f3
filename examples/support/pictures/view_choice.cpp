#include "pictures/view_choice.hpp"

#include "io/csv.hpp"

#include <cmath>

namespace cageform_support {

namespace {

/// Parses "TURN,RISE" in degrees. Returns the error; empty on success.
std::string parse_view(std::string_view word, ViewAngles& sight) {
    const std::size_t comma = word.find(',');
    double turn = 0, rise = 0;
    const bool whole = comma != word.npos && detail::parse_number(word.substr(0, comma), turn).empty() &&
                       detail::parse_number(word.substr(comma + 1), rise).empty();
    if (!whole || !std::isfinite(turn) || !(std::fabs(rise) <= 90))
        return detail::quoted(word) + " is not two angles such as 35,12, the second from -90 to 90";
    sight.turn = turn;
    sight.rise = rise;
    return {};
}

} // namespace

void ViewChoice::add_options(CommandLine& line) {
    line.add_parsed(
            "--view", sight, parse_view,
            "the picture's view: TURN,RISE in degrees, from the front towards the figure's left, and upwards")
        .show_default("34.4,11.5");
    line.add_text(
            "--up", [this](const std::string& word) { sight.z_is_up = word == "z"; },
            "the picture's up axis, y or z; the front then faces along z, or along -y")
        .one_of({"y", "z"})
        .show_default("y");
}

} // namespace cageform_support

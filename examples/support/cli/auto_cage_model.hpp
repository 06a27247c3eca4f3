// Shared code for cages in the plane and in space: values of --cage and error messages.
#pragma once

#include "cli/auto_cage.hpp"
#include "io/csv.hpp"
#include "io/messages.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>
#include <system_error>

namespace cageform_support {

/// Rounds to the decimals that resolve a thousandth of `clearance`.
inline double rounded(double x, double clearance) {
    const double unit = std::pow(10.0, std::floor(std::log10(clearance / 1000)));
    const double steps = std::round(x / unit);
    // The inverse of units below 1 is exact, so 0.1 does not become 0.1000000001.
    return std::fabs(steps) < 1e15 && std::isfinite(unit) && unit > 0
               ? (unit < 1 ? steps / std::round(1 / unit) : steps * unit)
               : x;
}

inline constexpr std::string_view lattice_prefix = "lattice:";

inline double farthest_coordinate(std::span<const double> coordinates, double before) {
    for (const double x : coordinates) before = std::max(before, std::fabs(x));
    return before;
}

/// Formats the error of make_cage.
///
///   farthest   the figure's largest coordinate
inline std::string no_cage(const cageform::MakeCageReport& report, const cageform::MakeCageOptions& options,
                           double farthest) {
    using Status = cageform::Status;
    std::string why = cageform::to_string(report.status);
    if (report.status == Status::cage_not_found && farthest > 1e14 * report.margin)
        why += ": a margin of " + detail::short_number(report.margin) + " at coordinates of " +
               detail::short_number(farthest) + " is below the precision of their 16 digits";
    else if (report.status == Status::cage_not_found && report.clearance > 0)
        why += ": the last attempt comes as near as " + detail::short_number(report.clearance) +
               ", and the margin is " + detail::short_number(report.margin);
    if (report.status == Status::margin_too_small && options.mirror && options.mirror->position)
        why += ": the grid spans the figure and its image across the mirror at " +
               detail::short_number(*options.mirror->position);
    return why;
}

/// Makes a cage as the value of --cage describes; warnings go to stderr.
template <class Figure>
auto made_by_word(const CageChoice& word, const Figure& figure) {
    cageform::MakeCageOptions options;
    options.vertices = word.vertices;
    options.looseness = word.looseness;
    options.shape = word.shape;
    auto made = make_cage_for(figure, options);
    for (const std::string& warning : warnings_of(made.report, options)) warn(figure.name + ": " + warning);
    return made;
}

/// Extends the error of a missing file if its name resembles a keyword of --cage.
inline FileError with_words(FileError error, const std::string& word) {
    std::error_code unknown;
    if (std::filesystem::exists(word, unknown)) return error;
    if (word.starts_with("box:"))
        error.message =
            "--cage " + detail::quoted(word) +
            ": a box has 8 vertices, in the plane 4; write --cage box, or for N vertices hull:N or auto:N";
    else if (word.starts_with("auto") || word.starts_with("hull") || word.starts_with("box"))
        error.message += "; to make a cage, write auto, hull or box, for 3 to 1000000 vertices auto:N or "
                         "hull:N, or for the "
                         "fewest within 15 % of the tightest auto:15%";
    return error;
}

/// The lattice that the value of --cage describes.
template <class Figure>
auto lattice_by_word(const std::string& word, const Figure& figure) {
    const auto read = value_or_fail(parse_lattice_word(std::string_view(word).substr(lattice_prefix.size())));
    return make_lattice_for(figure, read, lattice_margin);
}

} // namespace cageform_support

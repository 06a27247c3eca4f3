#pragma once

// Texts on the search for a map that wraps a source onto a target.

#include "cli/wrap_choice.hpp"

#include <cageform/fit/types/surface.hpp>

#include <string>
#include <vector>

namespace cageform_support {

/// "0.028 %" for 0.00028.
std::string percent_of(double share);

/// "0.028 % of the target's height in the mean, 0.091 % (95 %), at most 0.42 % at v 881".
///
///   vertex   the number, from 1, of the farthest vertex
std::string describe(const cageform::SurfaceDistance& distance, std::size_t vertex);

/// The alignment, a table of the steps, a table of the distances, and folds, landmarks and times.
std::string describe(const WrapMap& map, const WrapFigures& figures);

/// Warnings for the user: a target that was not reached, vertices without a match, folds, missed landmarks.
std::vector<std::string> warnings_of(const WrapMap& map, const WrapFigures& figures);

} // namespace cageform_support

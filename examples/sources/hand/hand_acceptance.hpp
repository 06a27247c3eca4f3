#pragma once

// Measures the requirements for a hand moved by control points.

#include "bound_hand.hpp"
#include "hand_builds.hpp"

#include <cstddef>

namespace cageform_sources {

using namespace cageform_support;

struct AcceptanceCount {
    std::size_t lines = 0, missed = 0;
};

/// Prints one line per property: "ok" or "missed", the number of the requirement (1 to 9), the measured
/// value, and its bound in parentheses. A missed line is a known limit of this hand, not an error.
AcceptanceCount print_acceptance(const BoundHand& bound, const HandBuilder& builder);

} // namespace cageform_sources

#pragma once

// Measures the requirements for a hand that control points move.

#include "bound_hand.hpp"
#include "hand_builds.hpp"

#include <cstddef>

namespace cageform_sources {

using namespace cageform_support;

struct AcceptanceCount {
    std::size_t lines = 0, missed = 0;
};

/// Prints a line a property, "ok" or "missed", with its bound in parentheses. A missed line is no error: it
/// says what this hand does not do yet.
AcceptanceCount print_acceptance(const BoundHand& bound, const HandBuilder& builder);

} // namespace cageform_sources

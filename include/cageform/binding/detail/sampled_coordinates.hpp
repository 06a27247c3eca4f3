// A concept for coordinates whose gradients are known at run time.
#pragma once

#include <cageform/coordinates/coordinate.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Coordinates with gradients; AnyCoordinates report them at run time.
template <class C>
concept SampledCoordinates = GradientCoordinates<C> || requires(const C& c) {
    { c.has_gradients() } -> std::same_as<bool>;
};

} // namespace cageform::inline CAGEFORM_ABI::detail

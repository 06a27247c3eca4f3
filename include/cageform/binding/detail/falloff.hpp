// How the weights of points outside fade with their distance from the cage.
#pragma once

#include <cageform/binding/types/bind_options.hpp>
#include <cageform/coordinates/detail/outside_distance.hpp>
#include <cageform/core/types/blocks.hpp>
#include <cageform/core/vec.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns whether the options have a falloff that can be had; see BindOptions::falloff.
inline Status check_falloff(const BindOptions& options, bool has_extension) noexcept {
    if (options.falloff == 0) return Status::ok;
    const bool has_weights = options.outside == OutsidePoints::nearest_boundary ||
                             (options.outside == OutsidePoints::extend && has_extension);
    const bool is_distance = options.falloff > 0 && is_finite(options.falloff);
    return has_weights && is_distance ? Status::ok : Status::falloff_not_supported;
}

/// The share of its displacement that a point outside keeps, f = (1 − x)² (1 + 2x) with x = d/falloff,
/// and the gradient of f.
template <std::size_t D>
struct Fading {
    double kept = 1;
    Vec<double, D> gradient{};

    Fading() = default;
    Fading(const OutsideDistance<D>& from_cage, double falloff) noexcept {
        const double x = from_cage.distance / falloff;
        if (!(x < 1)) {
            kept = 0;
            return;
        }
        // Each form is exact at its end.
        kept = x < 0.5 ? 1 - x * x * (3 - 2 * x) : (1 - x) * (1 - x) * (1 + 2 * x);
        gradient = (-6 * x * (1 - x) / falloff) * from_cage.gradient;
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail

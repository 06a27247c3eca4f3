// The falloff of weights outside the cage.
#pragma once

#include <cageform/binding/types/bind_options.hpp>
#include <cageform/coordinates/detail/outside_distance.hpp>
#include <cageform/core/types/blocks.hpp>
#include <cageform/core/vec.hpp>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns falloff_not_supported unless the falloff is valid; see BindOptions::falloff.
inline Status check_falloff(const BindOptions& options, bool has_extension) noexcept {
    if (options.falloff == 0) return Status::ok;
    const bool has_weights = options.outside == OutsidePoints::nearest_boundary ||
                             (options.outside == OutsidePoints::extend && has_extension);
    const bool is_distance = options.falloff > 0 && is_finite(options.falloff);
    return has_weights && is_distance ? Status::ok : Status::falloff_not_supported;
}

/// The factor f = (1 − x)² (1 + 2x), x = d/falloff, of the displacement of a point outside, and the
/// gradient of f.
template <std::size_t D>
struct FalloffValue {
    double kept = 1;
    Vec<double, D> gradient{};

    FalloffValue() = default;
    FalloffValue(const OutsideDistance<D>& from_cage, double falloff) noexcept {
        const double x = from_cage.distance / falloff;
        if (!(x < 1)) {
            kept = 0;
            return;
        }
        // The forms are equal; each is exact at its end of the range.
        kept = x < 0.5 ? 1 - x * x * (3 - 2 * x) : (1 - x) * (1 - x) * (1 + 2 * x);
        gradient = (-6 * x * (1 - x) / falloff) * from_cage.gradient;
    }
};

} // namespace cageform::inline CAGEFORM_ABI::detail

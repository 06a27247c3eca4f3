// The distance of an outside point from its cage, for BindOptions::falloff.
#pragma once

#include <cageform/coordinates/coordinate.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace cageform::inline CAGEFORM_ABI::detail {

/// A distance in the units of the cage, and its gradient; both are zero on the boundary.
template <std::size_t D>
struct OutsideDistance {
    double distance = 0;
    Vec<double, D> gradient{};

    OutsideDistance() = default;
    /// Takes the vector from the nearest boundary point. The vector's square may overflow or underflow.
    explicit OutsideDistance(const Vec<double, D>& away) noexcept {
        double largest = 0;
        for (std::size_t k = 0; k < D; ++k) largest = (std::max)(largest, std::fabs(away[k]));
        if (!(largest > 0)) return;
        Vec<double, D> scaled = away;
        for (std::size_t k = 0; k < D; ++k) scaled[k] /= largest;
        const double length = std::sqrt(dot(scaled, scaled));
        distance = largest * length;
        gradient = (1 / length) * scaled;
    }
};

/// Whether the distance is that from a cage whose corners are point handles. The cage then lies within the
/// bounds of these handles.
template <class C>
inline constexpr bool is_within_handles =
    requires(const C& c, Vec<typename C::scalar, C::dimension> p) { nearest_boundary_value(c.cage(), p, p); };

/// Returns the distance of the finite point `p` from the boundary: by `distance_outside` if the type has it,
/// else to the nearest point of the cage, else to the result of `nearest_boundary`.
template <CageCoordinates C>
OutsideDistance<C::dimension> outside_distance(const C& coordinates,
                                               const Vec<typename C::scalar, C::dimension>& p) {
    using T = typename C::scalar;
    if constexpr (requires { coordinates.distance_outside(p); }) {
        return coordinates.distance_outside(p);
    } else {
        Vec<T, C::dimension> place = p;
        if constexpr (is_within_handles<C>) {
            (void)nearest_boundary_value(coordinates.cage(), p, place);
        } else {
            std::vector<T> row(coordinates.handles().size());
            place = coordinates.nearest_boundary(p, std::span<T>(row));
        }
        return OutsideDistance<C::dimension>(vec_cast<double>(p) - vec_cast<double>(place));
    }
}

} // namespace cageform::inline CAGEFORM_ABI::detail

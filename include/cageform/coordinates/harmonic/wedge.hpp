// The function that is singular at an edge between two planes.
#pragma once

#include <cageform/core/vec.hpp>

#include <cmath>
#include <numbers>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The space between two half-planes that meet at an edge. With r the distance from the edge, and θ the angle
/// from the first plane, functions that are zero on both behave at the edge as
///
///     S = r^(π/α) sin(π θ/α)
///
/// where α is the angle between the planes. S is harmonic. Above π its gradient is infinite at the edge.
struct Wedge {
    using Point = Vec<double, 3>;
    Point from, along;   ///< where the edge begins; its direction, of unit length
    Point plane, normal; ///< at right angles to the edge: in the first plane, and into the wedge
    double length;       ///< of the edge
    double angle;        ///< α

    /// A point in the coordinates of the wedge.
    struct Place {
        double along, r, theta;
    };
    Place place(const Point& p) const noexcept {
        const auto q = p - from;
        const double x = dot(plane, q), y = dot(normal, q);
        double theta = std::atan2(y, x);
        if (theta < angle / 2 - std::numbers::pi) theta += 2 * std::numbers::pi;
        return {dot(along, q), std::sqrt(x * x + y * y), theta};
    }
    /// Whether a place lies between the planes, or on them.
    bool has(const Place& at) const noexcept { return at.theta > -rounding && at.theta < angle + rounding; }
    /// Whether S is not smooth: the planes are neither nearly one nor at about a right angle, or less.
    bool is_singular() const noexcept {
        constexpr double degree = std::numbers::pi / 180;
        return angle > 102 * degree && std::fabs(angle - std::numbers::pi) > 10 * degree;
    }
    /// Returns S.
    double singular(const Place& at) const noexcept {
        const double power = std::numbers::pi / angle;
        return std::pow(at.r, power) * std::sin(power * at.theta);
    }

private:
    static constexpr double rounding = 1e-3; ///< of an angle
};

} // namespace cageform::inline CAGEFORM_ABI::detail

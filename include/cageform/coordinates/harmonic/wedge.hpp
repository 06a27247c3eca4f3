// The singular function at an edge between two planes.
#pragma once

#include <cageform/core/vec.hpp>

#include <cmath>
#include <numbers>

namespace cageform::inline CAGEFORM_ABI::detail {

/// The space between two half-planes that meet at an edge. Let r be the distance from the edge and θ the
/// angle from the first plane. Functions that are zero on both planes behave at the edge like the harmonic
/// function
///
///     S = r^(π/α) sin(π θ/α)
///
/// where α is the angle between the planes. For α > π the gradient of S is infinite at the edge.
struct Wedge {
    using Point = Vec<double, 3>;
    Point from, along;   ///< start of the edge, and its unit direction
    Point plane, normal; ///< unit vectors orthogonal to the edge: in the first plane, and into the wedge
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
    /// Whether a place lies between or on the planes.
    bool has(const Place& at) const noexcept { return at.theta > -rounding && at.theta < angle + rounding; }
    /// Whether S is not smooth: the angle differs from 180 degrees and exceeds about 90 degrees.
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
    static constexpr double rounding = 1e-3; ///< tolerance of angles
};

} // namespace cageform::inline CAGEFORM_ABI::detail

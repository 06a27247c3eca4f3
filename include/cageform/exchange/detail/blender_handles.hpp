// Shortens the handles of a curve by the rule of Blender's F-curves.
#pragma once

#include <cageform/animate/curves/bezier.hpp>

#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Scales a handle by `factor` about its key; a factor of 1 changes no bit.
inline Vec<double, 2> shortened(const Vec<double, 2>& key, const Vec<double, 2>& handle,
                                double factor) noexcept {
    return factor == 1 ? handle : key + factor * (handle - key);
}

/// Returns the curve as Blender evaluates it (BlenderLimit).
///
///   each  true: limits each handle to the interval's length; false: limits the sum of both handles
inline BezierCurve with_blender_limit(const BezierCurve& curve, bool each) noexcept {
    const auto& [p0, p1, p2, p3] = curve.points;
    const double length = p3[0] - p0[0];
    const double first = std::fabs(p1[0] - p0[0]), second = std::fabs(p3[0] - p2[0]);
    const auto factor = [&](double span) { return span > length ? length / span : 1.0; };
    return {{p0, shortened(p0, p1, factor(each ? first : first + second)),
             shortened(p3, p2, factor(each ? second : first + second)), p3}};
}

} // namespace cageform::inline CAGEFORM_ABI::detail

// Tolerances of animated values.
#pragma once

#include <cageform/config.hpp>

#include <cmath>
#include <numbers>

namespace cageform::inline CAGEFORM_ABI {

/// @name Tolerances The largest invisible errors (Izdebski 2019, sec. 5.2), in the units of the
/// animated values. Angles are in radians.

/// One step of a colour channel with `bits` bits and a range of 1.
inline double colour_tolerance(unsigned bits) noexcept {
    return std::ldexp(1.0, -int(bits));
}
/// One pixel under an orthographic camera that shows `width` units on `pixels` pixels.
inline double orthographic_tolerance(double width, double pixels) noexcept {
    return width / pixels;
}
/// One pixel at distance `depth` under a perspective camera with the field of view `angle` across
/// `pixels` pixels.
inline double perspective_tolerance(double angle, double depth, double pixels) noexcept {
    return 2 * std::tan(0.5 * angle) * depth / pixels;
}
/// The angle that moves points within `radius` of the pivot by at most `distance`.
inline double rotation_tolerance(double distance, double radius) noexcept {
    return distance / radius;
}
/// The resolution of the eye at a distance: one arc minute.
inline double eye_tolerance(double distance) noexcept {
    return 2 * std::tan(std::numbers::pi / 180 / 120) * distance;
}
/// The distance between the pixels of a screen, in millimetres, from its size in pixels and its
/// diagonal in inches.
inline double pixel_pitch(double width, double height, double diagonal) noexcept {
    return 25.4 * diagonal / std::hypot(width, height);
}
/// The default: one pixel of a screen 1920 pixels wide, relative to the extent of the animation.
inline constexpr double screen_tolerance = 1.0 / 1920;
/// @}

} // namespace cageform::inline CAGEFORM_ABI

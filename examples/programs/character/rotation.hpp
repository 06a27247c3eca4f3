#pragma once

// Rotations as unit quaternions x, y, z, w.

#include <cageform/clip/curves/rigid_motion.hpp>
#include <cageform/core/vec.hpp>

#include <cmath>
#include <numbers>

namespace cageform_programs {

using Point3 = cageform::Vec<double, 3>;
using Rotation = cageform::Quaternion<double>;

inline constexpr Rotation no_rotation{0, 0, 0, 1};

/// Rotates by `b`, then by `a`.
inline Rotation product(const Rotation& a, const Rotation& b) {
    const Point3 u{a[0], a[1], a[2]}, v{b[0], b[1], b[2]};
    const Point3 w = a[3] * v + b[3] * u + cross(u, v);
    return {w[0], w[1], w[2], a[3] * b[3] - dot(u, v)};
}

inline Rotation inverse(const Rotation& q) {
    return {-q[0], -q[1], -q[2], q[3]};
}

inline Point3 rotated(const Rotation& q, const Point3& p) {
    const Point3 u{q[0], q[1], q[2]}, t = 2.0 * cross(u, p);
    return p + q[3] * t + cross(u, t);
}

/// A rotation about a coordinate axis.
inline Rotation about(std::size_t axis, double degrees) {
    const double half = degrees * std::numbers::pi / 360;
    Rotation q{0, 0, 0, std::cos(half)};
    q[axis] = std::sin(half);
    return q;
}

/// The smallest rotation from one direction to another, which must not be opposite.
inline Rotation between(const Point3& from, const Point3& to) {
    const Point3 axis = cross(from, to);
    const double scale = std::sqrt(dot(from, from) * dot(to, to));
    const double w = scale + dot(from, to), length = std::sqrt(dot(axis, axis) + w * w);
    return {axis[0] / length, axis[1] / length, axis[2] / length, w / length};
}

/// The rotation mirrored in the plane x = 0.
inline Rotation mirrored(const Rotation& q) {
    return {q[0], -q[1], -q[2], q[3]};
}

} // namespace cageform_programs

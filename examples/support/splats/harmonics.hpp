#pragma once

// Spherical harmonics of splats: how their colour changes with the direction from which they are seen.

#include "splats/splat.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace cageform_support {

inline constexpr std::size_t most_harmonics = 15; // of degrees 1 to 3

/// The number of coefficients of degrees 1 to `highest`.
constexpr std::size_t harmonics_of(std::size_t highest) {
    return highest * (highest + 2);
}

/// The constant of degree 0.
inline constexpr double constant_harmonic = 0.28209479177387814; // 1 / (2√π)

/// Real spherical harmonics of degrees 1 to 3 in the order and with the signs of 3D Gaussian splatting.
///
///   direction   of unit length
///   values      out: harmonics_of(3) of them
void harmonics_at(const Point3& direction, std::span<double, most_harmonics> values);

/// Turns functions on the sphere by an orthogonal matrix Q: f'(d) = f(Qᵀd). Reflections are as good as
/// rotations. The coefficients of a degree follow from the values at as many directions, since these values
/// determine them; the system of equations is solved once (its condition is 3).
class TurnedHarmonics {
public:
    explicit TurnedHarmonics(const Matrix3& orthogonal);

    /// Turns a function of one channel.
    ///
    ///   coefficients   in and out: of degrees 1 to 1, 2 or 3
    void turn(std::span<double> coefficients) const;

private:
    std::array<std::array<double, most_harmonics>, 7> turned_; // the harmonics at Qᵀ · each direction
};

} // namespace cageform_support

#pragma once

// Spherical harmonics of splats: colour as a function of the viewing direction.

#include "splats/splat.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace cageform_support {

inline constexpr std::size_t most_harmonics = 15; // of degrees 1 to 3

/// Number of coefficients of degrees 1 to `highest`.
constexpr std::size_t harmonics_of(std::size_t highest) {
    return highest * (highest + 2);
}

/// The harmonic of degree 0.
inline constexpr double constant_harmonic = 0.28209479177387814; // 1 / (2√π)

/// Real spherical harmonics of degrees 1 to 3 in the order and with the signs of 3D Gaussian splatting.
///
///   direction   of unit length
///   values      out: harmonics_of(3) of them
void harmonics_at(const Point3& direction, std::span<double, most_harmonics> values);

/// Rotates functions on the sphere by an orthogonal matrix Q (also reflections): f'(d) = f(Qᵀd). The
/// coefficients of a degree are determined by the values at 2 · degree + 1 directions. This linear system
/// (condition number 3) is inverted once.
class TurnedHarmonics {
public:
    explicit TurnedHarmonics(const Matrix3& orthogonal);

    /// Rotates a function of one channel.
    ///
    ///   coefficients   in and out: 3 of degree 1, 8 of degrees 1 and 2, or 15 of degrees 1 to 3
    void turn(std::span<double> coefficients) const;

private:
    std::array<std::array<double, most_harmonics>, 7> turned_; // the harmonics at Qᵀ · each direction
};

} // namespace cageform_support

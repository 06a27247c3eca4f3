// Scales vectors to unit length, and finds tangents of a normal.
#pragma once

#include <cageform/core/vec.hpp>

#include <array>
#include <cmath>

namespace cageform::inline CAGEFORM_ABI::detail {

/// Returns `v` scaled to unit length without overflow; zero stays zero.
template <std::size_t D>
Vec<double, D> unit_or_zero(Vec<double, D> v) noexcept {
    double largest = 0;
    for (std::size_t k = 0; k < D; ++k) largest = std::fmax(largest, std::fabs(v[k]));
    if (!(largest > 0)) return {};
    for (std::size_t k = 0; k < D; ++k) v[k] /= largest;
    return (1 / std::sqrt(dot(v, v))) * v;
}

/// Returns two orthogonal unit vectors with cross(first, second) = `n`, for `n` of unit length.
///
/// Duff et al., Building an Orthonormal Basis, Revisited (JCGT 6, 2017), listing 3.
inline std::array<Vec<double, 3>, 2> any_tangents(const Vec<double, 3>& n) noexcept {
    const double sign = std::copysign(1.0, n[2]), a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
    return {{{1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]}, {b, sign + n[1] * n[1] * a, -n[1]}}};
}

} // namespace cageform::inline CAGEFORM_ABI::detail
